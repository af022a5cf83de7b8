"""Real arithmetic beside the machine's, and the margin that a proof keeps."""

from dataclasses import replace
from fractions import Fraction

import pytest

from tests.support.teams import team, towards
from verify.claims.catalogue import EPS, find_property
from verify.claims.decisions import PLAIN, Aligned, NoDouble
from verify.claims.region_files import start_region
from verify.claims.wording import BUILT_IN
from verify.kinds import REAL
from verify.question import Question
from verify.result import Verdict
from verify.solver.solve import decide
from verify.subjects import Game
from verify.verdicts.decisions import MAX_QUESTIONS, STEP, largest_margin, verify

pytestmark = [pytest.mark.solver, pytest.mark.usefixtures("few_states_throughout")]


def test_away_from_thresholds_both_agree_and_real_violations_replay(profile):
    claim = find_property("distinct_targets", profile)
    for one, verdict in ((team(profile, towards(0, 0), towards(1, 1)), Verdict.PROVED),
                         (team(profile, towards(0, 0), towards(0, 1)), Verdict.VIOLATED)):  # fmt: skip
        found = verify(Question(Game(one), claim, start_region(one.world), REAL), {})
        assert found.verdict is verdict and found.evidence.control.verdict is Verdict.VIOLATED
        assert (found.evidence.counterexample is not None) == (verdict is Verdict.VIOLATED)


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
