"""Margins by zones against Z3, which is asked at every margin anew; how few searches they take."""

from dataclasses import replace
from fractions import Fraction

import pytest

from tests.support.teams import team, towards
from verify.claims.catalogue import find_property
from verify.claims.region_files import start_region
from verify.question import Question
from verify.result import Verdict
from verify.solver.solve import decide
from verify.subjects import Game
from verify.verdicts.decisions import STEP, largest_margin, room
from verify.zones.engine import BeyondZonesError, Room, ZoneQuery


@pytest.fixture(scope="module")
def roles(profile):
    return team(profile, towards(0, 0), towards(1, 1))


@pytest.mark.solver
@pytest.mark.parametrize("radius", [Fraction(3, 50), Fraction(1, 10), Fraction(1, 2)])
@pytest.mark.parametrize("margin", [Fraction(0), Fraction(1, 3000), Fraction(1, 20) - STEP])
@pytest.mark.parametrize("name", ["distinct_targets", "own_target"])
def test_margins_are_those_that_z3_finds(roles, name, radius, margin):
    claim = replace(find_property(name, roles), radius=radius, margin=margin)
    question = Question(Game(roles), claim, start_region(roles.world))
    assert decide(question).verdict is Verdict.PROVED
    asked = largest_margin(lambda m: decide(question.with_margin(m)).verdict is Verdict.PROVED, margin)
    assert room(question) == asked


def test_most_margins_need_no_search(roles, monkeypatch):
    question = Question(Game(roles), find_property("distinct_targets", roles), start_region(roles.world))
    answer, asked = ZoneQuery.answer, []
    monkeypatch.setattr(ZoneQuery, "answer", lambda self: (asked.append(1), answer(self))[1])
    found = room(question)
    assert found.questions > 10 and len(asked) <= 5 * len(question.goals)


def test_what_takes_too_many_nodes_counts_as_not_proved(roles):
    question = Question(Game(roles), find_property("distinct_targets", roles), start_region(roles.world))
    assert room(question).proved > 0
    assert room(question.spending(max_nodes=5)).proved == 0


def test_claims_beyond_zones_are_left_to_z3(roles):
    question = Question(Game(roles), find_property("aligned", roles), start_region(roles.world))
    with pytest.raises(BeyondZonesError):
        Room(question, STEP, 10)
