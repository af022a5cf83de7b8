"""Monitors of proofs about episodes of games: they vouch for a start, and for what follows from it by the rules; of
claims for ever, for whoever is within the edges, and comes to rest within them.
"""

import json
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from codegen.boxes import is_inside
from codegen.errors import InputError, RefusedError
from codegen.lowering.lower import lower
from codegen.lowering.tracking import ensure_followed
from codegen.lowering.watching import watch
from maviper import load, verify
from maviper.compilation.compile import split_targets
from maviper.compilation.monitors import Proved, load_proof, lower_monitor, noisy
from maviper.episodes.trees import on_policy
from maviper.page.document import Contents
from maviper.page.page import page, with_proof
from maviper.worlds.matching import matching_world
from tests.benchmarks import monitor as benchmark
from tests.maviper.page.browsers import in_node
from tests.support import monitors
from tests.support.altered import sealed
from tests.support.generated import FOLDER
from tests.support.monitored import acting
from tests.support.monitors import (
    INVALID,
    LEAVING,
    OK,
    OUTSIDE,
    ShadowTwin,
    TrackTwin,
    asked_of_episodes,
    asked_of_shadows,
    drawn,
    module_of,
)
from tests.support.pages import STATE
from tests.support.pushed import move_game
from verify.certificates.games import to_json

VERDICTS = FOLDER.parent / "verdicts"
NAME = "certificate-7-reaches.json.xz"
TWO = ("c", "python")


@pytest.fixture(scope="module")
def made():
    """A profile, what is proved of its episodes, and the lowered monitor."""
    profile = load(VERDICTS / "physical_deception" / "profile.json")
    proved = load_proof(VERDICTS / "physical_deception" / NAME, profile)
    return profile, proved.region, lower_monitor(profile, lower(profile), proved)


def wanted_of(twin, rows):
    """What a monitor must say of each row: all words occur."""
    wanted = twin.said(rows)
    assert {OK, LEAVING, OUTSIDE, INVALID} == set(wanted) and wanted.count(OK) > 500
    return wanted


@pytest.mark.compile
def test_all_languages_say_what_follows(made, tmp_path):
    profile, start, watched = made
    rows = asked_of_episodes(profile, start, 1_200, 4)
    wanted = wanted_of(TrackTwin(profile, start), rows)
    monitors.ensure_alike(profile, watched, rows, wanted, tmp_path)


@pytest.mark.compile
@pytest.mark.parametrize("languages", [TWO, pytest.param(monitors.LANGUAGES, marks=pytest.mark.slow)])
def test_all_languages_follow_the_episode_that_noisy_numbers_are_near(languages, made, tmp_path):
    profile, start, _ = made
    start = replace(start, noise=0.008)
    watched = watch(profile, lower(profile), start, "0" * 64, "nothing, but in a test")
    rows = asked_of_shadows(profile, start, 1_200, 4)
    wanted = wanted_of(ShadowTwin(profile, start), rows)
    monitors.ensure_alike(profile, watched, rows, wanted, tmp_path, languages)


def test_noise_is_for_episodes_and_a_small_number(made):
    _, start, _ = made
    proved = Proved(start, "0" * 64, "nothing, but in a test")
    assert noisy(proved, "1/125").region.noise == 0.008 and noisy(proved, None) is proved
    assert "within 0.024" in noisy(proved, 0.008).claim
    for noise in (0, -1, "2"):
        with pytest.raises(InputError, match="the noise is"):
            noisy(proved, noise)
    with pytest.raises(InputError, match="not a number"):
        noisy(proved, "much")
    with pytest.raises(InputError, match="single states"):
        noisy(replace(proved, region=start.region), 0.008)
    with pytest.raises(InputError, match="only for the target monitor"):
        split_targets(["c"], None, 0.008)


@pytest.mark.compile
def test_it_vouches_for_the_simulators_episodes_and_for_no_push(made):
    """Episodes of the simulator from its own starts; a push, or an action that was not taken, is seen at once."""
    profile, _, watched = made
    space = module_of(watched)
    world = matching_world(profile)
    played = on_policy(profile, world, seeds=range(6))
    whole = np.stack([world.coordinates(state) for state in played.states[:-1]])  # [steps, batch, coordinates]
    for number in range(whole.shape[1]):
        states, actions = whole[:, number], played.actions[:, number]
        for pushed in (None, 5):
            found = space["Monitor"]()
            for step, (w, acts) in enumerate(zip(states, actions, strict=True)):
                seen = w + (1e-6 if step == pushed else 0.0) * (np.arange(len(w)) == 0)
                found.renew_all()
                word = int(found.step(seen.tolist(), profile.world.dt))
                assert word == (OK if pushed is None or step < pushed else OUTSIDE)
                for policy, act in zip(profile.agents, acts, strict=True):
                    found.act(policy.agent, int(act))


def test_who_has_not_moved_yet_is_where_it_started_to_the_bit(made):
    """A proof knows who has not: such a tree decides as before, at its thresholds too. Later a rounding is none."""
    profile, start, watched = made
    space, twin = module_of(watched), TrackTwin(profile, start)
    rows = asked_of_episodes(profile, start, 1, 4)
    first, names = rows[0][0], list(profile.world.coordinates())
    right = [
        next(at for at, each in enumerate(policy.actions) if each.effect == (1.0, 0.0)) for policy in profile.agents
    ]
    states = [first]
    for _ in range(3):
        states.append(twin.moved(states[-1], right))
    for step, name, wanted in (
        (1, "agent_0.x", OUTSIDE),
        (2, "agent_0.x", OK),
        (3, "agent_0.y", OUTSIDE),
        (1, "agent_0.vx", OK),
        (1, "agent_0.vy", OUTSIDE),
    ):
        found = space["Monitor"]()
        for at, w in enumerate(states[: step + 1]):
            seen = w + (2.0**-42 if at == step else 0.0) * (np.array(names) == name)
            found.renew_all()
            assert int(found.step(seen.tolist(), profile.world.dt)) == (wanted if at == step else OK)
            for policy, act in zip(profile.agents, right, strict=True):
                found.act(policy.agent, act)


@pytest.mark.parametrize(
    ("steps", "dt", "damping", "taken"),
    [(100, 0.1, 0.25, True), (101, 0.1, 0.25, False), (100, 1.0, 0.0, False), (15, 1.0, 0.0, True)],
)
def test_episodes_in_which_roundings_add_up_to_more_than_proofs_leave_are_refused(steps, dt, damping, taken, made):
    """Followed with all that may be off at each step, numbers are within a quarter of the 2^-30 that proofs leave."""
    world = replace(made[0].world, dt=dt, damping=damping)
    if not taken:
        with pytest.raises(InputError, match="too much adds up"):
            ensure_followed(world, steps)
        return
    ensure_followed(world, steps)
    x = v = 0.0
    for _ in range(steps):
        x, v = x + dt * v + 2.0**-40, (1.0 - damping) * v + 2.0**-40
    assert x <= 2.0**-32


@pytest.mark.parametrize("game", ["cooperative_navigation", "predator_prey"])
def test_episodes_with_contacts_are_refused_with_the_reason(game):
    profile = load(VERDICTS / game / "profile.json")
    (certificate,) = (VERDICTS / game).glob("certificate-7-*.json.xz")
    with pytest.raises(InputError, match="push each other"):
        lower_monitor(profile, lower(profile), load_proof(certificate, profile))


@pytest.mark.compile
def test_noisy_numbers_raise_no_false_alarm_and_no_claim_fails():
    """A small run of the benchmark, in a closed loop; its control shows that the judge says where a claim fails."""
    ((_, found),) = benchmark.measured(9_000, benchmark.FLOWN)
    assert found["fails_while_vouched"] == 0 < found["control_fails"] and found["fails_elsewhere"] > 0
    assert found["refused"] == 0 and found["false_alarms"] < 0.05 and 0.3 < found["vouched"] < 0.95


# --- for ever

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
    w, _ = drawn(profile, proved.region.region, 1_500, np.random.default_rng(3))
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
    w, _ = drawn(profile, proved.region.region, 600, np.random.default_rng(5))
    rng, step = np.random.default_rng(6), profile.world.dt
    w[rng.random(len(w)) < 0.02, rng.integers(w.shape[1])] = np.nan
    dt = rng.choice([step, 0.1 * step, 2.0 * step], len(w), p=[0.96, 0.02, 0.02])
    held, valid = vouched(profile, proved.region, w), np.isfinite(w).all(axis=1) & (dt == step)
    wanted = np.where(valid, np.where(held, OK, OUTSIDE), INVALID).tolist()
    assert {OK, OUTSIDE, INVALID} == set(wanted)
    rows = (w, np.ones(w.shape, np.int32), dt, np.ones(len(w), np.int32))
    monitors.ensure_alike(profile, watched, rows, wanted, tmp_path, languages)


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
    body["edges"] = {name: [low, "2"] for name, (low, _) in body["edges"].items()}
    (tmp_path / "edited.json").write_text(sealed(body))
    with pytest.raises(RefusedError, match="refused"):
        load_proof(tmp_path / "edited.json", profile)
    with pytest.raises(InputError, match="no room for noise"):
        noisy(load_proof(path, profile), 0.01)


def test_the_page_says_the_same(lasting, tmp_path):
    profile, path = lasting
    contents = with_proof(Contents(), profile, path)
    proved = contents.claims[0].proved
    assert contents.claims[0].verdict.startswith("PROVED in")
    w, goals = drawn(profile, proved.region, 200, np.random.default_rng(7))
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
