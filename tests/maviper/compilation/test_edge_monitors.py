"""Monitors of claims for ever about games: whoever is within the edges, and comes to rest within them, stays there."""

import json
from fractions import Fraction

import numpy as np
import pytest

from codegen.boxes.bounding import is_inside
from codegen.errors import InputError, RefusedError
from codegen.lowering.lower import lower
from codegen.targets import emit, monitor
from maviper import load, verify
from maviper.compilation.monitors import load_proof, lower_monitor, noisy
from maviper.page.document import Contents
from maviper.page.page import page
from maviper.page.results import with_proof
from tests.maviper.page.browsers import in_node
from tests.support import monitors
from tests.support.generated import FOLDER
from tests.support.monitored import acting
from tests.support.monitors import INVALID, OK, OUTSIDE
from tests.support.pages import STATE
from tests.support.pushed import move_game
from verify.certificates.episodes import to_json
from verify.checker.envelope import body_hash

RADIUS, STEPS = 2.5, 40
PROFILE = FOLDER.parent / "proved_defenders" / "profile.json"


@pytest.fixture(scope="module")
def lasting(tmp_path_factory):
    """A profile, and the certificate that its defenders stay within a radius for ever."""
    profile = load(PROFILE)
    found = verify(profile, "stays_in", steps="always", radius=Fraction(RADIUS))
    path = tmp_path_factory.mktemp("lasting") / "certificate.json"
    path.write_text(to_json(found.evidence.certificate))
    return profile, path


def drawn(profile, edges, count, seed):
    """States in the region and around it, as fast as can be, with the goal at a landmark; rows of coordinates."""
    rng, names = np.random.default_rng(seed), profile.world.coordinates()
    w = rng.uniform(-1.0, 1.0, (count, len(names)))
    for name, (low, high) in edges.region.box.items():
        ends = np.array([float(Fraction(low)), float(Fraction(high))])
        column = w[:, names.index(name)] = rng.uniform(*ends, count)
        at_end = rng.random(count) < 0.05
        beside = [*ends, *np.nextafter(ends, [-np.inf, np.inf]), *(1.4 * ends)]
        column[at_end] = rng.choice(beside, at_end.sum())
        w[:, names.index(name)] = column
    goals = rng.choice(profile.world.goals, count)
    for axis in "xy":
        w[:, names.index(f"goal.{axis}")] = w[np.arange(count), [names.index(f"{goal}.{axis}") for goal in goals]]
    return w, goals


def vouched(profile, edges, w):
    """Which states are within the edges, now and at rest; in numpy, by the numbers of the monitor."""
    names = profile.world.coordinates()
    rest = w.copy()
    for name in edges.region.box:
        if f"{name[:-1]}v{name[-1]}" in names:
            place, speed = names.index(name), names.index(f"{name[:-1]}v{name[-1]}")
            rest[:, place] = w[:, place] + edges.coasting * w[:, speed]
    return is_inside(edges.region, w, names) & is_inside(edges.region, rest, names)


def test_wherever_it_vouches_the_claim_is_kept_from_there_on(lasting):
    """Episodes from full speed too, in which the adversary does anything; where it does not vouch some break the claim,
    also such that only come to rest beyond an edge.
    """
    profile, path = lasting
    proved = load_proof(path, profile)
    w, _ = drawn(profile, proved.region, 1_500, 3)
    held = vouched(profile, proved.region, w)
    assert 0.2 < held.mean() < 0.9
    rng, states = np.random.default_rng(4), [w]
    for _ in range(STEPS):
        acted = acting(profile, states[-1]) | {"adversary_0": rng.integers(5, size=len(w))}
        states.append(move_game(profile, states[-1], acted))
    names = profile.world.coordinates()
    places = [names.index(f"{agent}.{axis}") for agent in ("agent_0", "agent_1") for axis in "xy"]
    kept = np.all([(np.abs(each[:, places]) <= RADIUS).all(axis=1) for each in states], axis=0)
    begun = (np.abs(w[:, places]) <= RADIUS).all(axis=1)
    assert kept[held].all() and not kept[~held & begun].all()
    later = np.array([vouched(profile, proved.region, each)[held] for each in states])
    assert later.mean() > 0.999  # all but for what rounds over an edge


@pytest.mark.compile
@pytest.mark.parametrize("languages", [("python",), pytest.param(monitors.LANGUAGES, marks=pytest.mark.slow)])
def test_all_languages_say_the_same(languages, lasting, tmp_path):
    profile, path = lasting
    proved = load_proof(path, profile)
    watched = lower_monitor(profile, lower(profile), proved)
    w, _ = drawn(profile, proved.region, 600, 5)
    rng, step = np.random.default_rng(6), profile.world.dt
    w[rng.random(len(w)) < 0.02, rng.integers(w.shape[1])] = np.nan
    dt = rng.choice([step, 0.1 * step, 2.0 * step], len(w), p=[0.96, 0.02, 0.02])
    held, valid = vouched(profile, proved.region, w), np.isfinite(w).all(axis=1) & (dt == step)
    wanted = np.where(valid, np.where(held, OK, OUTSIDE), INVALID).tolist()
    assert {OK, OUTSIDE, INVALID} == set(wanted)
    rows = (w, np.ones(w.shape, np.int32), dt, np.ones(len(w), np.int32))
    rest = watched.fallbacks[0].action
    acted = [i % 5 if word == OK else rest for i, word in enumerate(wanted)]
    texts = {**emit(profile, languages), **monitor.emit(watched, languages)}
    if languages == ("python",):
        assert monitors.run_python(texts, watched, rows) == (wanted, acted)
    else:
        monitors.ensure_said_by_all(texts, watched, tmp_path, rows, (wanted, acted), languages)


def test_every_speed_is_an_input(lasting):
    """Also those that no agent observes: whoever is faster than pushes make it may cross an edge."""
    profile, path = lasting
    watched = lower_monitor(profile, lower(profile), load_proof(path, profile))
    assert {each.place.name for each in watched.watched} >= {
        name for name in profile.world.coordinates() if ".v" in name
    }
    assert watched.says["LEAVING"] == "never" and "for ever" in watched.claim


def test_a_certificate_with_other_edges_is_refused(lasting, tmp_path):
    profile, path = lasting
    body = json.loads(path.read_text())
    body.pop("content_hash")
    body["edges"] = {name: [low, "2"] for name, (low, _) in body["edges"].items()}
    (tmp_path / "edited.json").write_text(json.dumps(body | {"content_hash": body_hash(body)}))
    with pytest.raises(RefusedError, match="refused"):
        load_proof(tmp_path / "edited.json", profile)
    with pytest.raises(InputError, match="no room for noise"):
        noisy(load_proof(path, profile), 0.01)


def test_the_page_says_the_same(lasting, tmp_path):
    profile, path = lasting
    contents = with_proof(Contents(), profile, path)
    proved = contents.claims[0].proved
    assert contents.claims[0].verdict.startswith("PROVED in")
    w, goals = drawn(profile, proved, 200, 7)
    names = profile.world.coordinates()
    given = [(dict(zip(names, row, strict=True)), goal) for row, goal in zip(w.tolist(), goals.tolist(), strict=True)]
    script = (
        STATE
        + """
  const word = Engine.monitor(game, data.claims[0].region, data.claims[0].coasting);
  return given.map(([at, goal]) => {
    const state = stateIn(game)(at, goal);
    data.agents.forEach(({ name }, k) => { state.velocity[k] = [at[`${name}.vx`], at[`${name}.vy`]]; });
    return word(state);
  });
"""
    )
    said = in_node(page(profile, contents), script, given, tmp_path)
    assert said == ["OK" if each else "OUTSIDE" for each in vouched(profile, proved, w)]
