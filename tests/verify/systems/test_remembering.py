"""Memory of agents as variables of a stated system: beside the reference, proved for ever, refuted, checked."""

import itertools
import re
from fractions import Fraction

import numpy as np
import pytest

import maviper
from codegen.errors import InputError
from codegen.importers.c.source import from_c
from codegen.importers.origin import Names, profile_of
from codegen.importers.reading import Said
from codegen.memory import step_memory, tabulate_updates
from maviper.worlds.stated.certified import sentence
from tests.support.remembering import PUMP, SOURCES, SUMMING, make_world
from verify.checker.accept import accept
from verify.reports.systems import facts, lines
from verify.subjects import Game
from verify.systems import remembering
from verify.systems.files import statement_of
from verify.systems.observing import as_played, choose_actions, list_roundings, with_roundings

CLAIMS = """
[[claim]]
name = "always"
region = { box = { t = [18, 22.5] } }
[[claim]]
name = "always"
region = { box = { t = [19.5, 22] } }
[[claim]]
formula = "act.heating == 1 and t < 21 implies acts(act) == heat"
[[claim]]
formula = "act.heating == 0 and t < 21 implies acts(act) == heat"
[[claim]]
formula = "act.heating == 1 and t > 22 implies acts(act) == heat"
"""


@pytest.mark.parametrize("name", SOURCES)
def test_a_system_changes_memory_as_the_reference_does(name):
    profile = profile_of(from_c(SOURCES[name].encode(), "act.c", Said(run=False)), Names())
    (policy,), rng = profile.agents, np.random.default_rng(0)
    statement, _ = as_played(statement_of(make_world(policy), "room.toml"), profile)
    for _ in range(300):
        t = Fraction(float(np.float32(rng.choice([rng.uniform(-2, 25), 0, 0.5, 19, 21, 10]))))
        known = [
            int(rng.choice([each.low, each.high, rng.integers(each.low, each.high + 1)])) for each in policy.memory
        ]
        state = {"t": t} | {
            f"act.{each.name}": value - int(each.low) for each, value in zip(policy.memory, known, strict=True)
        }
        _, (after,) = step_memory(policy, [known], [[float(t)]])
        chosen = {"act": policy.actions[choose_actions(statement.system, profile, state)["act"]].name}
        (piece,) = (each for each in statement.system.pieces if each.holds(state))
        moved = piece.step(state, chosen, {})
        assert [moved[f"act.{each.name}"] + int(each.low) for each in policy.memory] == after.tolist()


def test_a_heater_with_hysteresis_is_warm_for_ever_and_a_bound_too_narrow_is_broken(tmp_path, monkeypatch):
    profile = profile_of(from_c(SOURCES["heater"].encode(), "act.c", Said(run=False)), Names(actions=["off", "heat"]))
    world = tmp_path / "room.toml"
    world.write_text(make_world(profile.agents[0], CLAIMS))
    verified = maviper.verify_system(profile, world)
    assert [str(each.verdict) for each in verified.results] == ["PROVED", "VIOLATED", "PROVED", "VIOLATED", "VIOLATED"]
    assert "act: off (heating := 0)" in lines(facts(verified.results[4], 5))  # not by the action's own name
    certificate, known = verified.results[0].evidence.certificate, verified.results[1].evidence.counterexample
    statement, played = as_played(statement_of(world.read_text(), "room.toml"), profile)
    assert accept(certificate, played, statement.system) > 0
    assert "acts(act) == heat (heating := 1)" in sentence(verified.results[2].claim, statement, played)  # of `check`
    on, t = False, known.states[0]["t"]  # the C by hand, in exact numbers
    for state in known.states[1:]:
        seen = np.float32(float(t))
        on = True if seen < 19 else False if seen > 21 else on
        t = t - Fraction(2, 100) * (t - 10) + Fraction(on, 2)
        assert (state["t"], state["act.heating"]) == (t, on)
    assert not Fraction(39, 2) <= t <= 22
    # a system that forgets is another one, of which the proof says nothing

    def forget(policy):
        return tuple(np.full_like(each, k) for k, each in zip((1, 0), tabulate_updates(policy), strict=True))

    monkeypatch.setattr(remembering, "tabulate_updates", forget)
    forgetting, played = as_played(statement_of(world.read_text(), "room.toml"), profile)
    with pytest.raises(InputError, match="another system"):
        accept(certificate, played, forgetting.system)


LOOP = """name = "loop"
steps = 60
[variables]
x = {{ range = [-50, 50] }}
y = {{ range = [-50, 50] }}
[agents.act.features]
{features}
[agents.act.actions]
{actions}
[start]
box = {{ x = [0, 1], y = [0, 0.5] }}
[dynamics.next]
x = "x + 0.25 - 0.5*act.push"
y = "y"
"""


def make_loop(policy, claims=""):
    """A world file for an agent with the features x and y, whose actions push x down but for the first."""
    names = [each.name for each in policy.actions if not each.acts]
    actions = "\n".join(f"{name} = {{ push = {int(place > 0)} }}" for place, name in enumerate(names))
    seen = zip(policy.features, "xy", strict=False)
    return LOOP.format(features="\n".join(f'{each.name} = "{at}"' for each, at in seen), actions=actions) + claims


@pytest.mark.parametrize("name", SUMMING)
def test_a_system_changes_memory_beside_sums_as_the_reference_does(name):
    """At ties of sums, too, where the roundings of the state decide; memory itself is observed without any."""
    profile = profile_of(from_c(SUMMING[name].encode(), "act.c", Said(run=False)), Names())
    (policy,), rng = profile.agents, np.random.default_rng(0)
    statement, played = as_played(statement_of(make_loop(policy), "loop.toml"), profile)
    assert not [each for each in list_roundings(statement) if "feature_" in each and each[-1] in "345"]
    for _ in range(300):
        x = float(np.float32(rng.uniform(-4, 9)))
        y = float(np.float32(rng.choice([x - 1.5, x - 0.5, 3 - x / 2, x, 12 - 2 * x, rng.uniform(-4, 9)])))
        known = [int(rng.integers(each.low, each.high + 1)) for each in policy.memory]
        state = {each: Fraction(0) for each in list_roundings(statement)} | {"x": Fraction(x), "y": Fraction(y)}
        state |= {
            f"act.{each.name}": Fraction(value - int(each.low))
            for each, value in zip(policy.memory, known, strict=True)
        }
        state = with_roundings(statement, state)
        (taken,), (after,) = step_memory(policy, [known], [[x, y]])
        chosen = {"act": played.agents[0].actions[choose_actions(statement.system, played, state)["act"]].name}
        (piece,) = (each for each in statement.system.pieces if each.holds(state))
        moved = piece.step(state, chosen, {})
        assert [moved[f"act.{each.name}"] + int(each.low) for each in policy.memory] == after.tolist()
        assert moved["x"] == state["x"] + Fraction(1, 4) - Fraction(int(taken > 0), 2)


DWELLS = """
[[claim]]
name = "always"
region = {{ box = {{ x = [-3, 4.5] }} }}
[[claim]]
name = "always"
region = {{ box = {{ x = [-3, 2] }} }}
[[claim]]
formula = "act.held <= {} and act.on == 1 implies acts(act) == action_1"
[[claim]]
formula = "act.held <= {} and act.on == 1 implies acts(act) == action_1"
[[claim]]
formula = "x - y > 1.51 and act.held >= 5 implies acts(act) == action_1"
"""


@pytest.mark.parametrize("numbers", ["double", "float"])
def test_a_dwell_beside_a_sum_is_proved_for_ever_and_one_call_more_is_refuted(numbers, tmp_path):
    source = PUMP if numbers == "double" else re.sub(r"(\d\.\d)", r"\1f", PUMP.replace("double", "float"))
    profile = profile_of(from_c(source.encode(), "act.c", Said(run=False)), Names())
    world = tmp_path / "loop.toml"
    world.write_text(make_loop(profile.agents[0], DWELLS.format(4, 5)))
    verified = maviper.verify_system(profile, world)
    verdicts = [str(each.verdict) for each in verified.results]
    assert verdicts == ["PROVED", "VIOLATED", "PROVED", "VIOLATED", "PROVED"]
    statement, played = as_played(statement_of(world.read_text(), "loop.toml"), profile)
    for place in (0, 2, 4):
        accept(verified.results[place].evidence.certificate, played, statement.system)
    x, y, on, held = (*(verified.results[1].evidence.counterexample.states[0][each] for each in "xy"), False, 0)
    for state in verified.results[1].evidence.counterexample.states[1:]:  # the C by hand, in exact numbers
        if held < 5:
            held += 1
        elif (x - y < Fraction(1, 2)) if on else (x - y > Fraction(3, 2)):
            on, held = not on, 0
        x += Fraction(1, 4) - Fraction(on, 2)
        assert (state["x"], state["act.on"], state["act.held"]) == (x, on, held)
    assert not -3 <= x <= 2


def test_memory_is_taken_where_a_system_states_it_alone():
    """Elsewhere `heat` and `heat, on := 1` would be two actions: `differ` would be PROVED of two that both heat."""
    profile = profile_of(from_c(SOURCES["heater"].encode(), "act.c", Said(run=False)), Names())
    with pytest.raises(InputError, match="does not take memory"):
        Game(profile)


FOR_EVER = {
    "debounce": ("act.count <= {} and act.stable == 1 implies acts(act) == action_1", 48, 49),
    "watchdog": ("act.silent >= {} and t < 0.4 implies acts(act) == TRIP", 999, 998),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", FOR_EVER)
def test_counters_and_timers_decide_as_claimed_and_one_call_more_or_less_is_refuted(name, tmp_path):
    profile = profile_of(from_c(SOURCES[name].encode(), "act.c", Said(run=False)), Names())
    (claim, *bounds), world = FOR_EVER[name], tmp_path / "room.toml"
    claims = [f'[[claim]]\nformula = "{claim.format(bound)}"\n' for bound in bounds]
    world.write_text(make_world(profile.agents[0], "".join(claims)))
    verified = maviper.verify_system(profile, world)
    assert [str(each.verdict) for each in verified.results] == ["PROVED", "VIOLATED"]
    statement, played = as_played(statement_of(world.read_text(), "room.toml"), profile)
    accept(verified.results[0].evidence.certificate, played, statement.system)


SWITCHED = """name = "room"
steps = 400
[variables]
t = { range = [0, 40] }
[agents.act.features]
x = "t - 20"
[agents.act.actions]
action_0 = { push = 0.01 }
action_1 = { push = -0.01 }
[start]
box = { t = [19.9, 20.1] }
[dynamics.next]
t = "t + act.push"
[[claim]]
name = "always"
region = { box = { t = [19.3, 20.7] } }
[[claim]]
name = "always"
region = { box = { t = [19.6, 20.4] } }
[[claim]]
name = "always"
region = { box = { "act.count" = [0, 49] } }
[[claim]]
name = "always"
region = { box = { "act.count" = [0, 40] } }
"""
SILENT = """name = "line"
steps = 3000
[variables]
pulse = { range = [-2, 2] }
[agents.act.features]
pulse = "pulse"
[agents.act.actions]
OK = { keep = 1, more = -0.0009765625 }
TRIP = { keep = 0, more = 1 }
[start]
box = { pulse = [0.75, 1] }
[dynamics.next]
pulse = "act.keep*pulse + act.more"
[[claim]]
name = "always"
region = { box = { pulse = [-0.5, 1] } }
"""
QUEUING = """name = "crossing"
steps = 300
[variables]
queue = { range = [-10, 100] }
[agents.act.features]
queue = "queue"
[agents.act.actions]
RED = { served = 0 }
GREEN = { served = 1 }
YELLOW = { served = 0 }
[start]
box = { queue = [0, 5] }
[[dynamics.piece]]
when = "queue > 1"
next = { queue = "queue + 0.25 - act.served" }
[[dynamics.piece]]
when = "otherwise"
next = { queue = "0.5*queue + 0.5" }
[dynamics.error]
queue = [-0.125, 0.125]
[[claim]]
name = "always"
region = { box = { queue = [-1, 20] } }
[[claim]]
name = "always"
region = { box = { queue = [-1, 10] } }
"""


def change_queue(queue, taken):
    return (queue + 1) / 2 if queue <= 1 else queue + Fraction(1, 4) - (taken == 1)


PLANTS = {  # the world, verdicts, the number that moves, what is observed of it, its next value but for the error
    "debounce": (
        SWITCHED,
        ["PROVED", "VIOLATED", "PROVED", "VIOLATED"],
        ("t", lambda t: t - 20, lambda t, taken: t + Fraction(-1 if taken else 1, 100), 0),
    ),
    "watchdog": (SILENT, ["PROVED"], None),
    "light": (QUEUING, ["PROVED", "VIOLATED"], ("queue", lambda queue: queue, change_queue, Fraction(1, 8))),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", PLANTS)
def test_a_plant_stays_in_bounds_that_follow_from_timers_alone(name, tmp_path):
    """A switch after 50 calls lets a room drift by half a degree; a watchdog trips in time, after 1,000 calls; a light
    with two timers keeps a queue short.
    """
    profile = profile_of(from_c(SOURCES[name].encode(), "act.c", Said(run=False)), Names())
    text, verdicts, plant = PLANTS[name]
    (tmp_path / "world.toml").write_text(text)
    verified = maviper.verify_system(profile, tmp_path / "world.toml")
    assert [str(each.verdict) for each in verified.results] == verdicts
    statement, played = as_played(statement_of(text, "world.toml"), profile)
    for each in verified.results:
        if each.evidence.certificate is not None:
            assert accept(each.evidence.certificate, played, statement.system) > 0
        else:  # the C is called again, from the start of the counterexample
            moving, observe, change, error = plant
            (policy,), states = profile.agents, each.evidence.counterexample.states
            known = np.array([[int(states[0][f"act.{m.name}"] + int(m.low)) for m in policy.memory]])
            assert known.tolist() == [[m.initial for m in policy.memory]]
            for before, after in itertools.pairwise(states):
                taken, known = step_memory(policy, known, [[float(observe(before[moving]))]])
                assert abs(after[moving] - change(before[moving], taken[0])) <= error
                assert known.tolist() == [[after[f"act.{m.name}"] + int(m.low) for m in policy.memory]]
