"""Verdicts about stated systems with all that stands beside them: two engines, and shuffled leaves."""

from dataclasses import replace
from fractions import Fraction as F

import pytest

from tests.support.system_cases import box, corridor, double_integrator, passing, policy, stays, switching, team
from verify.checker.systems import reading
from verify.claims.region import UNBOUNDED
from verify.question import Budgets, Question, shuffle_leaves
from verify.reach import decide as reach
from verify.reach.results import ReachOutcome
from verify.result import Verdict
from verify.solver import unrolled
from verify.subjects import ClosedLoop
from verify.systems.claims import Pattern, SystemClaim
from verify.verdicts import systems
from verify.verdicts.systems import verify_system

pytestmark = pytest.mark.solver


def asked(steps=8, bound=1, axes=1, **budgets):
    system, profile = double_integrator(axes=axes), switching(axes=axes)
    claim = stays(system, steps, x=(-bound, bound))
    return Question(ClosedLoop(profile, system), claim, UNBOUNDED, budgets=Budgets(**{"covers": False, **budgets}))


def test_two_engines_speak_and_the_control_fails():
    """What is proved of the trees is not so of the same trees with shuffled leaves."""
    found = verify_system(asked())
    engine, second = found.evidence.opinions
    assert found.verdict is engine.verdict is second.verdict is Verdict.PROVED
    assert found.evidence.control.verdict is Verdict.VIOLATED and second.spent > 0 and found.cost.spent == engine.spent
    assert found.certificate is found.evidence.certificate is not None


def test_a_violation_has_both_opinions_too():
    found = verify_system(asked(bound=F(1, 10)))
    assert found.verdict is Verdict.VIOLATED and found.counterexample is not None and found.certificate is None
    assert [one.verdict for one in found.evidence.opinions] == [Verdict.VIOLATED] * 2


def test_the_verdict_alone_asks_nobody_else():
    found = verify_system(asked(), beside=False)
    assert found.verdict is Verdict.PROVED and len(found.evidence.opinions) == 1
    assert found.evidence.control.verdict is Verdict.SKIPPED


def test_a_large_query_is_not_asked():
    question = asked(steps=unrolled.MAX_SIZE)
    assert unrolled.opinion(question).verdict is Verdict.SKIPPED
    assert unrolled.opinion(asked(solver_units=10)).verdict is Verdict.UNKNOWN


def test_all_agents_are_shuffled():
    profile = passing()
    mixed = shuffle_leaves(profile, "")
    assert all(
        sorted(one.tree.action.tolist()) == sorted(other.tree.action.tolist())
        for one, other in zip(profile.agents, mixed.agents, strict=True)
    )
    assert {one.agent for one in mixed.agents} == {one.agent for one in profile.agents} and mixed != profile


def test_a_claim_that_any_leaves_fulfil_has_a_control_that_is_proved():
    question = asked(bound=1000)
    assert verify_system(question).evidence.control.verdict is Verdict.PROVED


def test_engines_that_disagree_are_a_bug_of_ours(monkeypatch):
    monkeypatch.setattr(reach, "decide", lambda question: ReachOutcome(Verdict.PROVED))
    with pytest.raises(AssertionError, match=r"reach PROVED, Z3 .* VIOLATED"):
        verify_system(asked(bound=F(1, 10)))


def test_what_is_not_stated_is_no_proof(monkeypatch):
    """Z3 says so too where an episode leaves the boxes before the claim is broken."""
    question = asked(steps=3)
    system = question.subject.system
    narrow = tuple(replace(piece, where={"x": (F(-1, 100), F(1, 100))}) for piece in system.pieces)
    question = replace(question, subject=ClosedLoop(question.profile, replace(system, pieces=narrow)))
    assert verify_system(question).verdict is Verdict.UNKNOWN
    assert unrolled.opinion(question).verdict is Verdict.VIOLATED


def test_a_step_misread_by_prover_and_checker_is_seen_by_the_solver(monkeypatch):
    """Both have one reading of a system: here one in which no action has an effect. Z3 has a reading of its own."""
    question, right = asked(samples=0), reading._total
    fast = SystemClaim(Pattern.AVOIDS, (box(vx=(F(1, 1000), F(10))),), 4)
    monkeypatch.setattr(reading, "_total", lambda name, piece, effects, number: right(name, piece, (), number))
    with pytest.raises(AssertionError, match=r"reach PROVED, Z3 .* VIOLATED"):
        verify_system(question.about(fast))


def test_an_enclosure_that_the_rules_do_not_follow_is_unknown():
    found = verify_system(asked(bound=F(1, 10)), confirm=lambda counterexample: None)
    assert found.verdict is Verdict.UNKNOWN and found.reason == systems.ENCLOSED and found.counterexample is None
    assert found.evidence.helps == systems.NARROWER and found.evidence.control.verdict is Verdict.SKIPPED
    again = verify_system(asked(bound=F(1, 10)), confirm=lambda counterexample: counterexample)
    assert again.verdict is Verdict.VIOLATED


def test_a_claim_of_several_agents_is_written_for_the_solver():
    """The corridor's two agents: they stay apart, and would not if they stood still."""
    system, profile = corridor(), passing()
    claim = SystemClaim(Pattern.REACHES, (box(**{system.variables[0].name: (F(-100), F(100))}),), 1)
    assert unrolled.opinion(Question(ClosedLoop(profile, system), claim, UNBOUNDED)).verdict is Verdict.PROVED
    lone = policy("nobody", ["f"], ["go"], 0)
    assert unrolled.size(team(lone), system, claim) < unrolled.size(profile, system, claim)
