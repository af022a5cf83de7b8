"""Modes and cases beside a flow: read, played, proved by cases at samples, and broken by episodes that say which."""

from dataclasses import replace
from fractions import Fraction as F

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from codegen.errors import InputError
from codegen.ir import act
from maviper.worlds.checking import check_integration
from maviper.worlds.stated.environment import StatedEnv
from tests.support.flows import off_by
from tests.support.system_cases import box, policy, team
from verify.checker.accept import accept
from verify.checker.flows import samples
from verify.checker.flows.samples import FlowCases
from verify.checker.flows.sweep import NOT_STATED, FlowSweep, Plan
from verify.checker.reading import RejectedError
from verify.claims.region import UNBOUNDED
from verify.flows.decide import decide
from verify.flows.episodes import FlowCourse, FlowPlay, FlowReplay, replay_course
from verify.question import Question
from verify.result import Verdict
from verify.subjects import ClosedLoop
from verify.systems import documents
from verify.systems.expressions import Name, Number
from verify.systems.files import statement_of
from verify.systems.properties import claims_of

ROOM = """
name = "room"
steps = 8
[variables]
warm = { unit = "K", range = [-20, 20] }
heat = { modes = ["off", "low", "high"] }
[agents.a.features]
warm = "warm"
high = "heat == high"
[agents.a.actions]
off = {}
low = {}
high = {}
[start]
box = { warm = [-1, 1], heat = "off" }
[dynamics]
period = "0.5 s"
next = { heat = "acts(a)" }
error = { warm = 0.05 }
[[dynamics.piece]]
when = "heat == high and warm <= 1"
flow = { warm = "2[K/s] - 0.5[1/s]*warm" }
[[dynamics.piece]]
when = "heat == high and warm > 1"
flow = { warm = "1[K/s] - 0.5[1/s]*warm" }
next = { heat = "off" }
[[dynamics.piece]]
when = "heat == low"
flow = { warm = "0.5[K/s] - 0.5[1/s]*warm" }
[[dynamics.piece]]
when = "otherwise"
flow = { warm = "-1[K/s] - 0.5[1/s]*warm" }
error = { warm = 0.1 }
[[property]]
name = "stays_in"
region = { box = { warm = [-2, 3] } }
"""
KEEPER = team(policy("a", ["warm", "high"], ["off", "low", "high"], ((0, 0.0), 2, ((0, 0.5), ((1, 0.5), 1, 2), 0))))
RATES = {0: (-1.0, 0.1), 1: (0.5, 0.05), 2: (2.0, 0.05), 3: (1.0, 0.05)}  # by mode, 3: high and above 1


def room(old="", new="", region=None):
    assert old in ROOM
    statement = statement_of(ROOM.replace(old, new), "room.toml")
    claim = claims_of(statement, KEEPER, "room.toml")[0]
    return statement, KEEPER, claim if region is None else replace(claim, regions=(box(warm=region),))


def asked(*given, steps=8, **changes):
    statement, profile, claim = room(*given, **changes)
    return Question(ClosedLoop(profile, statement.system), replace(claim, steps=steps), UNBOUNDED)


def escapes(plan, count, seed=0):
    """By how much episodes by scipy leave the sets of samples."""
    statement, profile, claim = room(region=(-99, 99))
    sweep, seen, random = FlowSweep(profile, statement.system, claim), {}, np.random.default_rng(seed)
    sweep.sampled = lambda period, sets: seen.setdefault(period, []).append((sets.box.low.copy(), sets.box.high.copy()))
    sweep.run(plan)
    warm, heat, worst = random.uniform(-1, 1, count), np.zeros(count, dtype=np.int64), 0.0
    warm[::3] = np.round(warm[::3])
    for period in range(claim.steps + 1):
        worst = max(worst, off_by(seen[period], np.stack([warm, heat], axis=1)))
        if np.isinf(worst):  # nothing is followed further
            return worst
        observed = np.stack([warm.astype(np.float32), (heat == 2).astype(np.float32)], axis=1)
        case = np.where((heat == 2) & (warm > 1), 3, heat)
        chosen = act(profile.agents[0], observed)
        pull, error = (np.array([RATES[k][side] for k in case.tolist()]) for side in (0, 1))
        pull = pull + error * np.where(random.random(count) < 0.5, random.choice([-1.0, 1.0], count), 0.0)
        done = solve_ivp(lambda _, x, pull=pull: pull - 0.5 * x, (0, 0.5), warm, "DOP853", rtol=1e-12, atol=1e-12)
        warm, heat = done.y[:, -1], np.where(case == 3, 0, chosen)
    return worst


PLANS = {"frames": Plan((0,), 4, 1), "cells": Plan((0,), 4, 2, {0: 0.125})}


@pytest.mark.parametrize("plan", PLANS)
def test_episodes_stay_in_the_sets(plan):
    assert escapes(PLANS[plan], 100) <= 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("plan", PLANS)
def test_ten_thousand_episodes_stay(plan):
    assert max(escapes(PLANS[plan], 2_000, seed) for seed in range(5)) <= 1e-9


FAULTS = {
    "only the first case": lambda self, boxes: [self._cuts[0].within(boxes), *(boxes.take(slice(0, 0)),) * 3],
    "the cases in another order": lambda self, boxes: [cut.within(boxes) for cut in self._cuts[::-1]],
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_planted_fault_is_caught(name, monkeypatch):
    monkeypatch.setattr(FlowCases, "within", FAULTS[name])
    assert escapes(PLANS["frames"], 60) > 1e-6


@pytest.mark.parametrize("steps", [3, pytest.param(8, marks=pytest.mark.slow)])
def test_a_claim_is_proved_and_a_false_one_broken(steps):
    question = asked(steps=steps)
    found = decide(question)
    assert found.verdict is Verdict.PROVED
    assert accept(found.certificate, question.profile, question.subject.system) == found.branches
    broken = asked(steps=steps, region=(-2, 1))
    again = decide(broken).counterexample
    assert again.states[-1]["warm"] > 1 and again.pieces[0] == 3 and len(again.pieces) == len(again.actions)
    course = FlowCourse(again.start, again.errors, again.longer, again.ways, again.rank)
    assert replay_course(broken.profile, broken.subject.system, broken.claim, course) == again
    assert (
        replay_course(broken.profile, broken.subject.system, broken.claim, course._replace(errors=[{"warm": F(1)}]))
        is None
    )


def test_choices_of_jumps_hold_for_each():
    """Nobody heats but by a choice that is anybody's: no proof forgets it, and an episode says what was chosen."""
    chosen = ('next = { heat = "acts(a)" }', 'next = { heat = "choice(acts(a), high)" }')
    never = team(policy("a", ["warm"], ["off", "low", "high"], 0))
    statement, _, claim = room(*chosen, region=(-3, F(12, 10)))
    assert [dict(case.choice) for case in statement.system.flow.cases[:2]] == [{"heat": "acts(a)"}, {"heat": "high"}]
    assert len(statement.system.flow.cases) == 7
    cold = room()[0]
    assert decide(Question(ClosedLoop(never, cold.system), claim, UNBOUNDED)).verdict is Verdict.PROVED
    broken = decide(Question(ClosedLoop(never, statement.system), claim, UNBOUNDED))
    assert broken.verdict is Verdict.VIOLATED and {"heat": "high"} in broken.counterexample.choices


def test_play_and_the_referee_take_the_case_that_holds():
    statement, _, _ = room()
    assert check_integration(statement).mark.value == "ok"
    env = StatedEnv(statement, "room.toml")
    env.reset(seed=0)
    env.state = {"warm": 1.5, "heat": 2.0}
    env.step({"a": 1})
    assert env.state["heat"] == 0
    assert env.state["warm"] == pytest.approx(2 - 0.5 * np.exp(-0.25), abs=0.03)


def test_beyond_what_cases_test_nothing_is_stated():
    statement, profile, claim = room("range = [-20, 20]", "range = [-1.5, 1.5]", region=(-9, 9))
    sweep = FlowSweep(profile, statement.system, claim)
    with pytest.raises(RejectedError, match=NOT_STATED):
        sweep.run(PLANS["frames"])


WRONG = {
    "cases that leave a gap": ('when = "otherwise"', 'when = "heat == off and warm <= 2"', "cases leave a gap"),
    "cases that overlap": ("warm > 1", "warm >= 1", "cases 1 and 2 overlap"),
    "a mode that flows": (
        'flow = { warm = "0.5[K/s]',
        'flow = { heat = "0", warm = "0.5[K/s]',
        "unknown variable 'heat'",
    ),
    "no such mode": ('heat = "off" }\n[[', 'heat = "warm" }\n[[', "unknown mode of heat"),
    "a derivative that is chosen": ("0.5[K/s] -", "choice(0.5[K/s], 1[K/s]) -", "choice"),
    "no derivative in a piece": ('flow = { warm = "0.5[K/s] - 0.5[1/s]*warm" }', "", "nothing says how warm moves"),
    "a period in a piece": ('when = "heat == low"', 'when = "heat == low"\nperiod = 1', "unknown key 'period'"),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_is_wrong_in_a_case_is_told_with_its_line(name):
    old, new, said = WRONG[name]
    with pytest.raises(InputError, match=said) as error:
        room(old, new)
    assert "room.toml" in str(error.value) and "dynamics.piece" in str(error.value)


def forged(system, **changes):
    """A system whose first case says something else."""
    first, *rest = system.flow.cases
    return replace(system, flow=replace(system.flow, cases=(replace(first, **changes), *rest)))


def test_what_a_reader_should_have_refused_the_checker_refuses():
    statement, profile, claim = room()
    system = statement.system
    flow = system.flow
    of = {
        "none of its modes": forged(system, jumps={"heat": Number(F(3))}),
        "what is none of its modes": forged(system, jumps={"heat": Name("warm")}),
        "moves between samples": forged(system, rates={**flow.rates, "heat": Number(F(1))}),
        "no piece is seen to hold": replace(system, flow=replace(flow, cases=flow.cases[1:])),
    }
    for said, other in of.items():
        assert documents.content_hash(other) != documents.content_hash(system)
        with pytest.raises(RejectedError, match=said):
            FlowSweep(profile, other, claim)
    assert Number(F(0)) == samples.STILL


def test_the_number_of_the_sample_is_known():
    text = ROOM.replace('when = "heat == low"', 'when = "heat == low and step < 3"')
    text = text.replace('flow = { warm = "-1[K/s] - ', 'flow = { warm = "-1[K/s] + 0.1[K/s]*step - ')
    statement = statement_of(text, "room.toml")
    claim = claims_of(statement, KEEPER, "room.toml")[0]
    found = decide(Question(ClosedLoop(KEEPER, statement.system), replace(claim, steps=4), UNBOUNDED))
    assert found.verdict is Verdict.PROVED


def test_a_mode_that_is_observed_is_played_as_the_agent_sees_it():
    """A relay that goes on while it is on: all episodes break what only `heat == high` tells apart."""
    relay = team(policy("a", ["high"], ["off", "low", "high"], ((0, 0.5), 0, 2)))
    start = ('warm = [-1, 1], heat = "off"', 'warm = [-1, -0.8], heat = "high"')
    statement, _, claim = room(*start, region=(-3, F(1, 2)))
    found = decide(Question(ClosedLoop(relay, statement.system), claim, UNBOUNDED))
    assert found.verdict is Verdict.VIOLATED and {"a": "high"} in found.counterexample.actions


def test_errors_of_a_counterexample_lie_in_the_bounds_of_their_case():
    bounds = F(7, 100), F(9, 100)
    bent = ("error = { warm = 0.1 }", "error = { warm = [0.07, 0.09] }")
    statement, profile, claim = room(*bent, region=(F(-11, 10), 3))
    play = FlowPlay(profile, statement.system, claim)
    replay, met = FlowReplay(profile, statement.system, claim), 0
    for broken in filter(None, map(replay.follow_course, play.breaking(64))):
        for case, error in zip(broken.pieces, broken.errors, strict=True):
            low, high = bounds if case == 3 else (F(-5, 100), F(5, 100))
            assert low <= error["warm"] <= high
        met += 1
        course = FlowCourse(broken.start, broken.errors, broken.longer, broken.ways, broken.rank)
        assert replay_course(profile, statement.system, claim, course) == broken
    assert met
