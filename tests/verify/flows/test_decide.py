"""Verdicts about continuous time: proved with plans that the checker accepts, broken by episodes that surely break."""

from dataclasses import replace
from fractions import Fraction as F

import numpy as np
import pytest

from codegen.errors import InputError
from tests.support.flows import BRAKING, CASES, EXACTLY, LOWERED, NEAR, PENDULUM, SIDES, TURNING, case
from tests.support.stated_play import value
from tests.support.system_cases import box, policy, team
from verify.checker.accept import accept
from verify.checker.flows.sweep import FEW, NOT_SHOWN, FlowSweep, Plan
from verify.checker.systems.proofs import WHOLE
from verify.claims.region import UNBOUNDED
from verify.flows import decide as flows
from verify.flows.decide import find_undefined
from verify.flows.episodes import FlowCourse, FlowPlay, replay_course
from verify.flows.search import PlanSearch
from verify.question import Budgets, Question
from verify.result import Verdict
from verify.spending import listening
from verify.subjects import ClosedLoop
from verify.systems.claims import Pattern
from verify.systems.observing import ARRAYS, function


def asked(text, profile, claim, **changes):
    system, profile, claim = case(text, profile, claim)
    return Question(ClosedLoop(profile, system), replace(claim, **changes), UNBOUNDED)


@pytest.mark.parametrize("name", CASES)
def test_what_holds_is_proved(name):
    question = asked(*CASES[name])
    found = flows.decide(question)
    assert found.verdict is Verdict.PROVED and found.certificate is not None
    assert accept(found.certificate, question.profile, question.subject.system) == found.branches > 0


def test_progress_is_told_in_boxes_of_the_budget():
    told = []
    with listening(lambda *each: told.append(each)):
        flows.decide(asked(*CASES["mixed"]))
    assert {(most, words) for _, most, words in told} == {(Budgets().max_boxes, "boxes of the budget")}
    assert [done for done, _, _ in told] == sorted(done for done, _, _ in told)


def test_what_fails_is_broken_by_an_episode_that_is_found_again():
    question = asked(PENDULUM, BRAKING, LOWERED, regions=(box(angle=(0, F(6, 10))),))
    found = flows.decide(question)
    assert found.verdict is Verdict.VIOLATED
    broken = found.counterexample
    assert (broken.step, broken.seconds) == (10, F(1, 2)) and broken.states[-1]["angle"] > F(6, 10)
    again = replay_course(question.profile, question.subject.system, question.claim, FlowCourse(broken.start))
    assert again == broken


def test_what_never_gets_there_is_broken_at_the_end():
    found = flows.decide(asked(PENDULUM, BRAKING, LOWERED, pattern=Pattern.REACHES, by=0, regions=(box(angle=(2, 3)),)))
    assert found.verdict is Verdict.VIOLATED and found.counterexample.seconds == 1


def test_what_gets_there_is_proved():
    found = flows.decide(
        asked(PENDULUM, BRAKING, LOWERED, pattern=Pattern.REACHES, by=0, regions=(box(angle=(0, F(9, 10))),))
    )
    assert found.verdict is Verdict.PROVED


def test_between_samples_an_episode_breaks_what_holds_at_samples():
    within = {"regions": (box(x=(F(9, 10), F(11, 10))),)}
    broken = flows.decide(asked(EXACTLY, SIDES, NEAR, **within))
    assert broken.verdict is Verdict.VIOLATED and 0 < broken.counterexample.seconds < F(6283, 1000)
    assert flows.decide(asked(EXACTLY, SIDES, NEAR, at_samples=True, **within)).verdict is Verdict.PROVED


def test_errors_of_derivatives_break_a_claim():
    text = TURNING.replace("y = [-0.002, 0.001]", "y = 0.3")
    found = flows.decide(asked(text, SIDES, NEAR, regions=(box(x=(F(-13, 10), F(13, 10))),)))
    assert found.verdict is Verdict.VIOLATED
    assert any(abs(error["y"]) == F(3, 10) for error in found.counterexample.errors)


def test_what_is_razor_thin_is_unknown_and_says_what_may_help():
    text = EXACTLY.replace('"6.283185307 s"', '"0.5 s"').replace("= 2", "= 12")
    question = asked(text, SIDES, NEAR, regions=(box(x=(-1, 1)),))
    found = flows.decide(replace(question, budgets=Budgets(max_boxes=120_000, samples=64)))
    assert found.verdict is Verdict.UNKNOWN and "none was found that surely does" in found.reason
    assert found.helps and found.open is not None


@pytest.mark.parametrize("most_parts", [0, 1])
def test_halves_that_are_all_shown_help(most_parts, monkeypatch):
    """Only lists of so many parts are left open: the start alone, or nothing."""
    system, profile, claim = case(PENDULUM, BRAKING, LOWERED)
    search = PlanSearch(profile, system, claim, 1_000_000)
    monkeypatch.setattr(
        search, "_find_open", lambda parts, *_: list(range(len(parts) if len(parts) <= most_parts else 0))
    )
    assert search.sweep.whole is not None
    search.open = [search.sweep.whole]
    assert search.helps() == ["a start region in smaller parts: a larger --effort"]


def test_a_start_or_an_error_out_of_bounds_breaks_nothing():
    system, profile, claim = case(TURNING, SIDES, NEAR.replace("[-2, 2]", "[-0.1, 0.1]"))
    start = {"x": F(1), "y": F(0)}
    assert replay_course(profile, system, claim, FlowCourse(start, [{"x": F(1, 1000), "y": F(0)}])) is not None
    assert replay_course(profile, system, claim, FlowCourse({"x": F(2), "y": F(0)})) is None
    assert replay_course(profile, system, claim, FlowCourse(start, [{}, {"x": F(1)}])) is None
    assert replay_course(profile, system, claim, FlowCourse(start, [{"z": F(0)}])) is None


def test_play_reads_derivatives_as_the_tests_do():
    system, _, _ = case(*CASES["mixed"])
    random = np.random.default_rng(0)
    known = {name: random.uniform(0.5, 1.5, 50) for name in ("x", "y", "z", "one.u")}
    for expression in system.flow.rates.values():
        again = value(expression, known)
        assert np.allclose(function(expression, ARRAYS)(known), again, rtol=1e-13)


@pytest.mark.parametrize("name", CASES)
def test_a_start_that_needs_no_cut_is_followed_once(name):
    system, profile, claim = case(*CASES[name])
    search = PlanSearch(profile, system, claim, 100_000)
    assert next(search.plans()).cuts == WHOLE and search.spent < 2 * FEW * claim.steps


def test_a_search_stops_at_its_budget():
    system, profile, claim = case(PENDULUM, BRAKING, LOWERED.replace("[0, 1]", "[0, 0.76]"))
    search = PlanSearch(profile, system, claim, 100)
    assert list(search.plans()) == [] and search.spent < 1_000
    assert list(FlowPlay(profile, system, claim).breaking(0)) == []


def test_a_claim_that_says_nothing_of_times_is_refused():
    with pytest.raises(InputError, match="whether it is about samples"):
        flows.decide(asked(PENDULUM, BRAKING, LOWERED, at_samples=None))


DRAIN = """
name = "drain"
steps = 12
[variables]
level = { unit = "m", range = [0, 2] }
[agents.valve.features]
level = "level"
[agents.valve.actions]
on = { flow = "0.05 m/s" }
off = {}
[start]
box = { level = [0.4, 0.5] }
[dynamics]
period = "1 s"
[dynamics.flow]
level = "valve.flow - 0.2[m^0.5/s]*sqrt(level)"
[[property]]
name = "stays_in"
region = { box = { level = [0, 1] } }
"""


def test_what_may_not_be_defined_on_the_way_is_named():
    """A tank that drains: its root has no bound of the slope at 0."""
    profile = team(policy("valve", ["level"], ["on", "off"], ((0, 0.0), 0, 1)))
    system, profile, claim = case(DRAIN, profile, "")
    sweep = FlowSweep(profile, system, claim)
    assert sweep.whole is not None
    assert find_undefined(system, sweep, [sweep.whole], Plan((), 4, 1)) == ["level"]
    assert sweep.open == {0: NOT_SHOWN} and sweep.watch is None
    bold = team(policy("valve", ["level"], ["on", "off"], ((0, 0.3), 0, 1)))
    assert find_undefined(system, FlowSweep(bold, system, claim), [sweep.whole], Plan((), 4, 4)) == []


FINE = """
name = "fine"
steps = 2
[variables]
x = { range = [-9, 9] }
v = { range = [-9, 9] }
[agents.a.features]
x = "x"
[agents.a.actions]
p = {}
[start]
box = { x = 0.3, v = [0, 1] }
[dynamics]
period = "0.2 s"
flow = { x = "0[1/s]", v = "0[1/s]" }
"""


@pytest.mark.parametrize(
    ("most", "verdict"), [("0.9999", Verdict.VIOLATED), ("1", Verdict.PROVED), ("0.9999", Verdict.UNKNOWN)]
)
def test_a_start_that_is_no_float_ends(most, verdict, monkeypatch):
    """Its box is one float wide, and is not cut."""
    if verdict is Verdict.UNKNOWN:  # where no episode breaks what is left open, the budget ends the search
        monkeypatch.setattr(FlowPlay, "breaking", lambda play, *asked: iter(()))
        monkeypatch.setattr(FlowPlay, "from_starts", lambda play, starts: iter(()))
    nobody = team(policy("a", ["x"], ["p"], 0))
    claim = f'[[property]]\nname = "stays_in"\nregion = {{ box = {{ v = [-9, {most}] }} }}\n'
    question = asked(FINE, nobody, claim).spending(max_boxes=2_000_000)
    found = flows.decide(question)
    assert found.verdict is verdict
    if verdict is Verdict.VIOLATED:
        assert found.counterexample.start["x"] == F(3, 10)


def test_the_soonest_episodes_come_first():
    question = asked(PENDULUM, BRAKING, LOWERED, pattern=Pattern.STAYS_IN, by=0, regions=(box(angle=(0, F(6, 10))),))
    play = FlowPlay(question.profile, question.subject.system, question.claim)
    replayed = [
        [replay_course(question.profile, question.subject.system, question.claim, each).seconds for each in courses]
        for courses in (list(play.breaking(64))[:8], list(play.breaking(64, soonest=True))[:8])
    ]
    assert replayed[1] == sorted(replayed[1]) and replayed[1][0] <= min(replayed[0])
