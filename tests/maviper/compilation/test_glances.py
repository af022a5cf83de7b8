"""Monitors in C with a glance say what those without it say."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from codegen.lowering.searching import Lookup
from maviper import load
from maviper.compilation import monitors
from maviper.compilation.monitors import load_proof
from maviper.worlds.stated.certified import read_certificate
from tests.support import monitored

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
