"""Real arithmetic beside the machine's, SMT-LIB of the very question, and the margin that a proof keeps."""

import re
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from codegen import ir
from maviper.verification.run import question_files
from tests.support.teams import RIGHT, STAY, UP, team, towards, tree
from verify.claims.catalogue import EPS, find_property
from verify.claims.decisions import PLAIN, Aligned, NoDouble
from verify.claims.formula import Acts, below, conjunction, disjunction
from verify.claims.region import Region
from verify.claims.region_files import start_region
from verify.claims.wording import BUILT_IN, OwnFormula
from verify.kinds import MACHINE, REAL
from verify.question import Question, from_start
from verify.result import Verdict
from verify.solver.encode import half_line
from verify.solver.encode import query as query_of
from verify.solver.solve import decide, smt_lib
from verify.states.state import inside, violates
from verify.subjects import Game
from verify.verdicts.decisions import verify
from verify.verdicts.opinions import MAX_QUESTIONS, STEP, largest_margin

pytestmark = [pytest.mark.solver, pytest.mark.usefixtures("few_states_throughout")]

T = Fraction(float(np.float32(0.3)))  # a threshold as it is written; the machine turns half a float32 step above it
END = half_line(float(T), True).end


def between(profile, low, high):
    """World states in which landmark_0_dx lies between two numbers and all else is settled."""
    box = dict.fromkeys(start_region(profile.world).box, (Fraction(0), Fraction(0)))
    box |= {f"landmark_{k}.{axis}": (Fraction(1), Fraction(1)) for k in (0, 1) for axis in "xy"}
    box["agent_0.x"] = (Fraction(-2), Fraction(2))
    return Region(box, ("landmark_0",), differences=(("landmark_0.x", "agent_0.x", (low, high)),))


def test_a_violation_over_the_reals_only_is_one_of_real_arithmetic_alone(profile):
    """Above the threshold the agent stays: in the sliver up to where the machine turns, only on paper."""
    claim = find_property("distinct_targets", profile)
    one = team(profile, tree((2, float(T), 1, 2), RIGHT, STAY), tree(UP))
    sliver = between(profile, T + Fraction(1, 2**40), END - Fraction(1, 2**40))
    assert decide(Question(Game(one), claim, sliver)).verdict is Verdict.PROVED
    found = verify(Question(Game(one), claim, sliver, REAL), {})
    assert found.verdict is Verdict.VIOLATED and found.semantics == REAL and found.evidence.shares.violating.count == 0
    shown = found.evidence.counterexample
    assert shown.state.floats and inside(sliver, shown.state) and violates(from_start(one, claim, REAL), shown.state)
    assert not violates(from_start(one, claim), shown.state) and not shown.deployed.violated and not shown.replayed
    assert (
        shown.deployed.actions["agent_0"] == "right" and "agent_0 takes right, and the claim holds there" in shown.says
    )
    assert decide(Question(Game(one), claim, sliver, REAL)).verdict is Verdict.VIOLATED


def test_a_proof_over_the_reals_may_fail_on_the_machine(profile):
    claim = find_property("distinct_targets", profile)
    other = team(profile, tree((2, float(T), 1, 2), STAY, RIGHT), tree(UP))
    sliver = between(profile, T + Fraction(1, 2**40), END - Fraction(1, 2**40))
    assert verify(Question(Game(other), claim, sliver, REAL), {}).verdict is Verdict.PROVED
    assert verify(Question(Game(other), claim, sliver, MACHINE), {}).verdict is Verdict.VIOLATED


def test_away_from_thresholds_both_agree_and_real_violations_replay(profile):
    claim = find_property("distinct_targets", profile)
    for one, verdict in ((team(profile, towards(0, 0), towards(1, 1)), Verdict.PROVED),
                         (team(profile, towards(0, 0), towards(0, 1)), Verdict.VIOLATED)):  # fmt: skip
        found = verify(Question(Game(one), claim, start_region(one.world), REAL), {})
        assert found.verdict is verdict and found.evidence.control.verdict is Verdict.VIOLATED
        assert (found.evidence.counterexample is not None) == (verdict is Verdict.VIOLATED)


def test_the_exported_question_is_the_very_question(profile):
    """Read back by the solver's parser it has the same answer; equal questions give equal bytes."""
    import z3

    for trees in ((towards(0, 0), towards(1, 1)), (towards(0, 0), towards(0, 1))):
        one = team(profile, *trees)
        for name in PLAIN:
            claim = find_property(name, one)
            region = start_region(one.world)
            for goal in region.goals:
                text = smt_lib(query_of(Question(Game(one), claim, region), goal))
                assert (
                    text == smt_lib(query_of(Question(Game(one), claim, region), goal))
                    and text.count("(check-sat)") == 1
                )
                solver = z3.Solver(ctx=z3.Context())
                solver.from_string(text)
                question = Question(Game(one), claim, region)
                violated = decide(question, cases=[(goal, question)]).verdict is Verdict.VIOLATED
                assert (str(solver.check()) == "sat") == violated, (name, goal)


def parts_of(text):
    """The lists of an SMT-LIB text, each as its words and lists."""
    open_lists = [[]]
    for word in re.findall(r"[()]|[^\s()]+", re.sub(r";.*", "", text)):
        if word == "(":
            open_lists.append([])
        elif word == ")":
            open_lists[-2].append(open_lists.pop())
        else:
            open_lists[-1].append(word)
    (found,) = open_lists
    return found


def ensure_standard(term):
    """Sums, conjunctions and disjunctions have two parts or more, and never stand alone."""
    if isinstance(term, list):
        for place, part in enumerate(term):
            assert part not in ("+", "and", "or") or (place == 0 and len(term) > 2), term
            ensure_standard(part)


def test_the_exported_question_is_for_every_solver(profile):
    """SMT-LIB has no sum, conjunction or disjunction of fewer than two parts; Z3 reads them, others refuse them."""
    alone = replace(profile.policy("agent_0").features[0], meaning=ir.Meaning(((1, "agent_0.x"),)))
    features = (alone, *profile.policy("agent_0").features[1:])
    first = replace(profile.policy("agent_0"), features=features, tree=tree((0, 0.25, 1, 2), STAY, STAY))
    agents = tuple(first if one.agent == "agent_0" else one for one in profile.agents)
    one = replace(profile, agents=agents)
    for statement in (below({"agent_0.x": 1}, 1), conjunction(), disjunction(Acts("agent_0", STAY))):
        question = Question(Game(one), OwnFormula("defenders", statement=statement), start_region(one.world))
        (text, *_) = question_files([question]).values()
        commands = parts_of(text)
        assert commands[0] == ["set-logic", "QF_LRA"] and commands[-1] == ["check-sat"]
        ensure_standard(commands)


def test_the_largest_margin_is_proved_and_the_next_is_not(profile):
    roles = team(profile, towards(0, 0), towards(1, 1))
    region = start_region(roles.world)
    claim = replace(find_property("distinct_targets", roles), radius=Fraction(3, 50))
    found = verify(Question(Game(roles), claim, region), {})
    room = found.evidence.largest
    assert found.verdict is Verdict.PROVED and room.failed == room.proved + STEP and room.questions <= MAX_QUESTIONS
    assert decide(Question(Game(roles), replace(claim, margin=room.proved), region)).verdict is Verdict.PROVED
    assert decide(Question(Game(roles), replace(claim, margin=room.failed), region)).verdict is Verdict.VIOLATED
    # where x is left for y within 0.05, an agent at distance 0.06 on y has no more than that ahead of it
    assert Fraction(1, 40) < room.proved < Fraction(1, 10)
    same = team(profile, towards(0, 0), towards(0, 1))
    assert verify(Question(Game(same), claim, region), {}).evidence.largest is None


def test_bisection_finds_every_end_with_few_questions():
    for start in (Fraction(0), Fraction(1, 3), Fraction(3)):
        for end in (0, 1, 2, 37, 999, 1_500, 5_000):
            asked = []

            def proved(margin, end=end, start=start, asked=asked):
                asked.append(margin)
                return margin <= start + end * STEP

            found = largest_margin(proved, start)
            assert len(asked) == len(set(asked)) == found.questions <= MAX_QUESTIONS
            assert found.proved == start or proved(found.proved)
            assert found.failed is None or (not proved(found.failed) and found.failed - found.proved == STEP)


def test_margins_are_sought_where_they_make_a_claim_harder():
    harder = {name for name in (*PLAIN, "alive_leaves") if BUILT_IN[name].hardens}
    assert harder == {"distinct_targets", "own_target", "aligned", "assignment"}
    assert not NoDouble("x", eps=EPS).hardens and Aligned("x", eps=EPS).hardens
