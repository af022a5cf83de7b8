"""What is said about episodes that fail: intervals against episodes played singly, other ways to fail, the radius."""

import math
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from tests.support.episode_cases import arriving
from tests.support.teams import LEFT, STAY, UP, team, tree
from verify.claims.catalogue import find_claim
from verify.claims.region import Region
from verify.claims.region_files import everywhere
from verify.counterexamples.episode_explanation import BETWEEN
from verify.question import Question
from verify.result import Verdict
from verify.states.episodes import courses, fails
from verify.states.state import State, inside
from verify.subjects import Game
from verify.verdicts.episodes import verify_episodes

pytestmark = [pytest.mark.solver, pytest.mark.usefixtures("few_states_throughout")]


def explained(profile, name, region=None):
    """The answer to a claim that fails, and what is said of each coordinate of its start."""
    question = Question(Game(profile), find_claim(name, profile), region or everywhere(profile))
    result = verify_episodes(question, {})
    assert result.verdict is Verdict.VIOLATED
    return result, {span.name: span for span in result.evidence.explanation.spans}


def alike(profile, result, name, value):
    """Whether the episode from a start with another value of one coordinate has the team's actions and fails."""
    moved = State({**result.evidence.state.position, name: float(value)}, result.evidence.state.goal)
    episode, actions = courses(profile, [moved], result.claim.steps)
    order = [entity.name for entity in profile.world.agents]
    places = [order.index(policy.agent) for policy in profile.team(result.claim.team)]
    same = np.array_equal(actions[:, 0][:, places], result.evidence.episode.actions[:, places])
    return inside(result.region, moved) and same and fails(profile, result.claim, episode[:, 0])


@pytest.mark.parametrize("name", ["reaches", "covers"])
def test_intervals_hold_wherever_they_were_played(profile, name):
    result, spans = explained(profile, name)
    assert set(spans) == set(result.evidence.state.position)
    for one in spans.values():
        assert one.low <= result.evidence.state.position[one.name] <= one.high
        assert all(alike(profile, result, one.name, value) for value in (one.low, one.high))
        if one.low < one.high and one.whole:
            values = np.linspace(one.low, one.high, BETWEEN + 2)
            assert all(alike(profile, result, one.name, value) for value in values)
    # bisection: hardly beyond an end that is not the region's, the episode is another one
    beyond = [
        (one.name, one.high + 1e-9)
        for one in spans.values()
        if one.high < float(result.region.box[one.name][1]) and one.high > result.evidence.state.position[one.name]
    ]
    assert beyond and sum(alike(profile, result, *moved) for moved in beyond) <= len(beyond) // 2


def test_what_the_team_does_not_see_makes_no_difference(profile):
    still = team(profile, tree(UP), tree(STAY))
    result, spans = explained(still, "reaches")
    assert spans["adversary_0.x"].whole and (spans["adversary_0.x"].low, spans["adversary_0.x"].high) == (-1.0, 1.0)
    assert result.evidence.explanation.other is None, "this team has one course only"
    says = result.evidence.explanation.says()
    assert "not decided" in says["unique"] and "adversary_0.x" in says["free"]


def test_another_way_to_fail_is_an_episode_that_fails(profile):
    arrivers = team(profile, arriving(0), arriving(1))
    result, _ = explained(arrivers, "covers")
    other = result.evidence.explanation.other
    episode, actions = courses(arrivers, [other], 25)
    assert inside(result.region, other) and fails(arrivers, result.claim, episode[:, 0])
    assert not np.array_equal(actions[:, 0], result.evidence.episode.actions)
    assert result.evidence.explanation.document()["other"]["goal"] == other.goal


def test_the_radius_with_which_it_would_hold(profile):
    for name in ("reaches", "covers"):
        result, _ = explained(profile, name)
        change = Fraction(result.evidence.explanation.change)
        assert change > 0 and "larger" in result.evidence.explanation.says()["fails by"]
        for more, holds in ((change, True), (change - Fraction(1, 10**9), False)):
            wider = replace(result.claim, radius=result.claim.radius + more)
            assert fails(profile, wider, result.evidence.episode.coordinates) != holds


def test_a_start_between_two_bounds_of_a_region(profile):
    """Intervals stay in the region: in its box, its differences and its distances."""
    both = team(profile, tree(LEFT), tree(LEFT))
    start = everywhere(both)
    box = dict(start.box) | {"landmark_0.x": (Fraction(1, 3), Fraction(2, 3))}
    difference = (("agent_0.x", "agent_1.x", (Fraction(1, 10), Fraction(1, 2))),)
    region = Region(box, start.goals, difference, (("agent_0", "landmark_0", Fraction(1, 5)),))
    result, spans = explained(both, "reaches", region)
    third = spans["landmark_0.x"]
    assert Fraction(third.low) >= Fraction(1, 3) and Fraction(third.high) <= Fraction(2, 3)
    assert math.isclose(third.low, 1 / 3) and not spans["agent_0.x"].whole
    found = result.evidence.state
    ends = [(one.name, value) for one in spans.values() for value in (one.low, one.high)]
    assert all(inside(region, State({**found.position, name: value}, found.goal)) for name, value in ends)


def test_what_the_region_fixes_is_not_said_to_make_no_difference(profile):
    still = team(profile, tree(UP), tree(STAY))
    start = everywhere(still)
    region = Region(dict(start.box) | {"adversary_0.x": (Fraction(1, 2),) * 2}, start.goals)
    result, spans = explained(still, "reaches", region)
    free = result.evidence.explanation.says()["free"]
    assert str(spans["adversary_0.x"]) == "fixed by the region"
    assert "adversary_0.x" not in free and "adversary_0.y" in free
