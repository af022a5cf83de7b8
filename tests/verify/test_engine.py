"""Verdicts: brute force on small worlds, counterexamples that replay, proofs that mean something."""

from dataclasses import replace
from fractions import Fraction
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from codegen import ir
from codegen.errors import DisagreementError, InputError, UnknownNameError
from maviper.extract.deploy import deployed
from tests.strategies import grown_trees, profiles
from tests.teams import LEFT, RIGHT, STAY, team, towards, tree
from verify import engine, shares
from verify.engine import decide, shuffled, verify
from verify.regions import proved_boxes
from verify.spec import PROPERTIES, Property, Region, Verdict, find_property, start_region
from verify.world import Point, inside, sample, violates

pytestmark = pytest.mark.solver


@pytest.fixture
def claim(profile):
    return find_property("distinct_targets", profile)


def test_fixed_roles_are_proved_everywhere(profile, claim):
    roles = team(profile, towards(0, 0), towards(1, 1))
    result = verify(roles, claim, start_region(roles.world), {})
    assert result.verdict is Verdict.PROVED
    assert result.control is Verdict.VIOLATED
    assert 0.34 < result.shares.conflict.value < 0.38  # 36 % of the start box, see the definitions
    assert result.shares.contested is not None and 0.026 < result.shares.contested.value < 0.031
    assert result.shares.violating.hits == 0


def test_both_at_the_same_target_is_refuted(profile, claim):
    same = team(profile, towards(0, 0), towards(0, 1))
    result = verify(same, claim, start_region(same.world), {})
    assert result.verdict is Verdict.VIOLATED
    point = result.counterexample.point
    assert violates(same, claim, point) and inside(result.region, point)
    assert all(len(repr(value)) <= 6 for value in point.position.values()), "not shrunk"


def test_standing_still_is_refuted(profile, claim):
    still = team(profile, tree(STAY), tree(STAY))
    assert decide(still, claim, start_region(still.world)).verdict is Verdict.VIOLATED


def test_an_empty_region_is_vacuous(profile, claim):
    start = start_region(profile.world)
    high = Region(start.box, start.goals, differences=(("agent_0.x", "agent_1.x", (Fraction(3), Fraction(4))),))
    result = verify(profile, claim, high, {})
    assert result.verdict is Verdict.VACUOUS and result.control is Verdict.SKIPPED
    apart = Region(start.box, start.goals, apart=(("agent_0", "agent_1", Fraction(5)),))
    assert verify(profile, claim, apart, {}).verdict is Verdict.VACUOUS


def test_a_spent_budget_is_unknown_with_its_reason(profile, claim):
    result = verify(profile, claim, start_region(profile.world), {}, budget=10)
    assert result.verdict is Verdict.UNKNOWN
    assert "resource units" in result.reason and "--budget" in result.reason


def test_the_same_question_costs_the_same(profile, claim):
    region = start_region(profile.world)
    decide(shuffled(profile, claim.team), claim, region)
    assert decide(profile, claim, region).resources == decide(profile, claim, region).resources


def test_a_replay_that_acts_differently_is_no_verdict(profile, claim):
    same = team(profile, towards(0, 0), towards(0, 1))
    with pytest.raises(DisagreementError, match="compiled C"):
        verify(same, claim, start_region(same.world), {"compiled C": lambda point: [STAY, STAY]})


def test_violation_only_between_neighbouring_floats(profile, claim):
    """A violating sliver one float32 wide is found, and the point replays in float64."""
    t = np.float32(0.3)
    sliver = tree((2, float(np.nextafter(t, np.float32(0))), 1, 2), RIGHT, (2, float(t), 3, 4), STAY, RIGHT)
    other = towards(1, 1)
    box = dict(start_region(profile.world).box)
    one = Fraction(1)
    box |= {"landmark_0.x": (one, one), "landmark_0.y": (one, one), "agent_0.x": (-one, Fraction(8, 10))}
    box |= {"landmark_1.x": (-one, -one), "landmark_1.y": (-one, -one), "agent_0.y": (-one, Fraction(0))}
    box |= {"agent_1.x": (Fraction(-1, 2), Fraction(-1, 4)), "agent_1.y": (Fraction(1, 4), one)}
    region = Region(box, ("landmark_0",))
    lopsided = team(profile, sliver, other)
    result = verify(lopsided, claim, region, {})
    assert result.verdict is Verdict.VIOLATED
    assert violates(lopsided, claim, result.counterexample.point)
    # the same region is proved once the sliver is gone
    assert decide(team(profile, tree(RIGHT), other), claim, region).verdict is Verdict.PROVED


GRID = [-1.0, -0.25, 0.5]


@settings(max_examples=25)
@given(grown_trees(max_depth=2), grown_trees(max_depth=2))
def test_against_brute_force_on_a_grid(first, second):
    """A region of few points: Z3's verdict is that of trying each of them."""
    from maviper.worlds import PhysicalDeception

    world = PhysicalDeception()
    roles = {"agent_0": deployed(first), "agent_1": deployed(second)}
    agents = tuple(
        ir.AgentPolicy(name, world.team_of(name), features, actions, roles.get(name, tree(STAY)))
        for name, features, actions in zip(world.agents, world.features, world.actions, strict=True)
    )
    profile = ir.PolicyProfile(world.spec, agents, ir.Provenance("", "", 0, "", ""))
    if any((np.abs(p.tree.threshold) < 2.0**-126)[p.tree.threshold != 0].any() for p in agents):
        return  # subnormal thresholds are refused
    claim = Property("distinct_targets", "defenders")
    fixed = {"adversary_0.x": 0.5, "adversary_0.y": -1.0, "landmark_0.x": 1.0, "landmark_0.y": 0.75}
    fixed |= {"landmark_1.x": -0.75, "landmark_1.y": -1.0, "agent_1.x": 0.0, "agent_1.y": 0.25}
    answers = []
    for x, y in product(GRID, GRID):
        point = Point(fixed | {"agent_0.x": x, "agent_0.y": y}, "landmark_1")
        box = {name: (Fraction(value), Fraction(value)) for name, value in point.position.items()}
        found = decide(profile, claim, Region(box, ("landmark_1",))).verdict
        answers.append((found is Verdict.VIOLATED) == violates(profile, claim, point))
    assert all(answers)


@settings(max_examples=10)
@given(profiles(max_depth=2), st.integers(0, 99))
def test_sampled_violations_are_never_proved_away(profile, seed):
    claim = Property("distinct_targets", "defenders")
    if any((np.abs(p.tree.threshold) < 2.0**-126)[p.tree.threshold != 0].any() for p in profile.agents):
        return
    region = start_region(profile.world)
    coordinates, _ = sample(region, profile.world, 500, seed)
    if shares.violating(profile, claim, coordinates).any():
        assert decide(profile, claim, region).verdict is Verdict.VIOLATED


def test_proved_against_samples_is_our_bug(profile, claim, monkeypatch):
    same = team(profile, towards(0, 0), towards(0, 1))
    monkeypatch.setattr(engine, "decide", lambda *given: engine.Decision(Verdict.PROVED, 0))
    with pytest.raises(AssertionError, match="proved, yet"):
        verify(same, claim, start_region(same.world), {})


def test_subnormal_thresholds_are_refused(profile, claim):
    tiny = team(profile, tree((0, 1e-40, 1, 2), LEFT, RIGHT), tree(STAY))
    with pytest.raises(InputError, match="subnormal"):
        decide(tiny, claim, start_region(tiny.world))


def test_features_without_meaning_are_refused(profile, claim):
    policy = profile.policy("agent_0")
    blind = replace(policy, features=tuple(replace(feature, meaning=None) for feature in policy.features))
    agents = tuple(blind if p.agent == "agent_0" else p for p in profile.agents)
    with pytest.raises(InputError, match="no meaning"):
        decide(replace(profile, agents=agents), claim, start_region(profile.world))


def test_unknown_names_are_answered_with_the_closest(profile):
    with pytest.raises(UnknownNameError, match="distinct_targets"):
        find_property("distinct_target", profile)
    with pytest.raises(UnknownNameError, match="defenders"):
        find_property("distinct_targets", profile, "defender")
    assert PROPERTIES == ("distinct_targets",)


def test_boxes_found_are_proved_conflicting_and_discriminating(profile, claim):
    box = next(proved_boxes(profile, claim, 0))
    result = verify(profile, claim, box.region, {})
    assert result.verdict is Verdict.PROVED
    assert result.shares.conflict.hits > 0
    assert result.control is Verdict.VIOLATED
