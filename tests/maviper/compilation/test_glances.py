"""Monitors in C with a glance say what those without it say."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from codegen.agreement.compiled import find_compiler
from codegen.lowering.lower import lower
from codegen.lowering.parts import Ends
from codegen.lowering.searching import Lookup, doubles_of
from codegen.targets import emit, monitor
from maviper import load
from maviper.compilation import monitors
from maviper.compilation.monitors import load_proof
from maviper.worlds.stated.certified import read_certificate
from tests.support import monitored
from tests.support.monitors import run_c, run_python

GENERATED = Path(__file__).parents[3] / "generated"


def drawn(cover, count):
    """States in sets, pushed a little, with some numbers at the ends of boxes, a float beside, or none; and steps."""
    rng = np.random.default_rng(0)
    at = rng.integers(len(cover.steps), size=count).astype(np.int32)
    states = np.empty((count, len(cover.variables)))
    for step, (part,) in enumerate(cover.steps):
        here = np.flatnonzero(at == step)
        low, high = (ends[rng.integers(len(ends), size=len(here))] for ends in (part.low, part.high))
        row = rng.integers(len(part.low), size=len(here))
        share = rng.random(low.shape)
        inside = part.low[row] + share * (part.high[row] - part.low[row])
        if hasattr(part, "matrix"):
            z = (2.0 * share - 1.0) * (1.0 + rng.choice([-1e-4, 0.0, 1e-4, 0.1, 0.3], share.shape))
            inside = part.centre[row] + np.einsum("nij,nj->ni", part.matrix[row], np.where(share < 0.2, np.sign(z), z))
        ends = np.where(rng.random(low.shape) < 0.5, low, high)
        ends = np.where(rng.random(low.shape) < 0.5, ends, np.nextafter(ends, rng.choice([-np.inf, np.inf], low.shape)))
        states[here] = np.where(rng.random(low.shape) < 0.1, ends, inside)
    states[rng.random(states.shape) < 0.005] = np.nan
    return states, np.where(rng.random(count) < 0.02, rng.choice([-1, len(cover.steps), 2**31 - 1], count), at)


@pytest.mark.slow
@pytest.mark.compile
@pytest.mark.parametrize(
    "name",
    [
        "worlds/crossing/certificate-1-stays_in",
        "worlds/mountain_car/certificate-1-stays_in",
        "arch/double_pendulum_less/certificate-1-stays_in",
        "arch/tora_reach/certificate-1-reaches_and_stays",
        "arch/attitude/certificate-1-avoids",
        "arch/pendulum/certificate-1-reaches_and_stays",
        "arch/cart_pole/certificate-1-reaches_and_stays",
    ],
)
def test_a_glance_changes_no_word(name, monkeypatch):
    certificate = GENERATED / f"{name}.json"
    profile = load(certificate.parent / "profile.json")
    proved, (_, statement) = load_proof(certificate, profile), read_certificate(certificate)
    states, at = drawn(proved.region, 200_000)
    with monitored.compiled(profile, proved, statement.system) as made:
        said = made.words(states, at)

    def lower_plainly(*given):
        watched = monitors.lower_monitor(*given)
        assert watched.glances
        monkeypatch.setattr(Lookup, "alone", False)
        return replace(watched, lookup=replace(watched.lookup, tilts=(), cores=None, tiles=None))

    monkeypatch.setattr(monitored, "lower_monitor", lower_plainly)
    with monitored.compiled(profile, proved, statement.system) as made:
        assert (made.words(states, at) == said).all()
    assert set(said.tolist()) == {0, 1, 2, 3} and (said <= 1).mean() > 0.2


@pytest.mark.compile
def test_a_glance_at_other_boxes_is_seen_in_words(monkeypatch):
    """The control: words are told by the glance, so that one that lets all states pass says OK of them."""
    certificate = GENERATED / "worlds/crossing/certificate-1-stays_in.json"
    profile = load(certificate.parent / "profile.json")
    proved, (_, statement) = load_proof(certificate, profile), read_certificate(certificate)
    states = np.full((len(proved.region.steps), len(proved.region.variables)), -1e6)

    def lower_wide(*given):
        watched = monitors.lower_monitor(*given)
        cores = watched.lookup.cores
        wide = Ends(doubles_of(np.full(len(cores.columns), -1e9)), doubles_of(np.full(len(cores.columns), 1e9)))
        return replace(
            watched, lookup=replace(watched.lookup, cores=cores._replace(boxes=(wide,) * len(cores.boxes), centred=()))
        )

    for lowered, said in ((monitors.lower_monitor, [3] * len(states)), (lower_wide, [0] * (len(states) - 1) + [1])):
        monkeypatch.setattr(monitored, "lower_monitor", lowered)
        with monitored.compiled(profile, proved, statement.system) as made:
            assert made.words(states, np.arange(len(states))).tolist() == said


def flown(proved, seed):
    """States of the proof in order, with steps that are late, numbers that are old or none, states of other steps, and
    actions that do not exist; after each of them the episode goes on, as if nothing were wrong.
    """
    rng, cover = np.random.default_rng(seed), proved.region
    visits = [states[rng.integers(len(states), size=60)] for states in cover.visit()]
    rows = []
    for episode in range(60):
        for step, states in enumerate(visits):
            w, fresh, dt, action = states[episode].copy(), np.ones(states.shape[1], np.int32), cover.dt, 0
            chance, column = rng.random() * len(visits) / 7.0, int(rng.integers(len(w)))
            if chance < 0.02:
                w[column] = rng.choice([np.nan, np.inf, w[column] * (1.0 + 1e-9)])
            elif chance < 0.12:
                w = visits[-1 - step][episode]
            elif chance < 0.15:
                fresh[column] = 0
            elif chance < 0.17:
                dt *= rng.choice([0.4, 1.6])
            elif chance < 0.2:
                action = int(rng.choice([-1, 99]))
            rows.append((w, fresh, dt, int(step == 0), action))
    w, fresh, dt, start, acts = map(np.array, zip(*rows, strict=True))
    return w, fresh, dt, start.astype(np.int32), np.stack([acts] * 9, axis=1).astype(np.int32)


@pytest.mark.compile
@pytest.mark.parametrize(
    "name",
    [
        "worlds/crossing/certificate-1-stays_in",
        "arch/docking/certificate-1-stays_in",
        "arch/tora_remain/certificate-1-stays_in",
        pytest.param("worlds/corridor/certificate-1-avoids", marks=pytest.mark.slow),
        pytest.param("arch/cart_pole/certificate-1-reaches_and_stays", marks=pytest.mark.slow),
        pytest.param("arch/pendulum/certificate-1-reaches_and_stays", marks=pytest.mark.slow),
    ],
)
def test_c_with_a_glance_says_in_flight_what_python_says_without_one(name, tmp_path):
    """Words that stay do so after a glance too, and the turn is lost where an action does not exist."""
    if find_compiler() is None:
        pytest.skip("no C compiler")
    certificate = GENERATED / f"{name}.json"
    profile = load(certificate.parent / "profile.json")
    proved = load_proof(certificate, profile)
    model = lower(profile)
    watched = monitors.lower_monitor(profile, model, proved)
    texts = {**emit(profile, ["c", "python"]), **monitor.emit(watched, ["c", "python"])}
    *rows, acts = flown(proved, 0)
    asked = (*rows, np.ascontiguousarray(acts[:, : len(model.agents)]))
    words, acted = run_c(texts, watched, tmp_path, asked)
    assert (words, acted) == run_python(texts, watched, asked)
    assert watched.glances and {0, 1, 3} <= set(words) and words.count(0) > 60
    assert 2 in words or "crossing" in name  # whose sets are as wide as its ranges
