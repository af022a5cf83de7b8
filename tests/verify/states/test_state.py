"""World states: exact points against a walk of the trees by hand, rounding into regions, samples, shortfalls."""

import math
from dataclasses import replace
from fractions import Fraction as F

import numpy as np
import pytest

from codegen import ir
from tests.support.small import small_profile
from tests.support.teams import LEFT, RIGHT, STAY, team, towards, tree
from tests.support.zone_cases import actions_at, deception, exactly_inside, random_region
from verify.claims.catalogue import find_property
from verify.claims.formula import Linear
from verify.claims.region import Region
from verify.claims.region_files import everywhere, start_region
from verify.claims.wording import OwnFormula
from verify.kinds import MACHINE, REAL
from verify.question import Question
from verify.states import state as states
from verify.states.state import State
from verify.subjects import Game

PROFILE = team(small_profile(), towards(0, 0), towards(1, 1))
WORLD = PROFILE.world


def drawn(profile, count, seed=0):
    region = everywhere(profile)
    coordinates, goals = states.sample(region, profile.world, count, seed)
    rows = zip(coordinates, goals, strict=True)
    points = [states.state_at(region, profile.world, row, int(goal)) for row, goal in rows]
    return coordinates, goals, points


def test_coordinates_are_in_the_worlds_order_velocities_zero_and_the_goal_where_its_landmark_is():
    _, _, (point,) = drawn(PROFILE, 1)
    names = WORLD.coordinates()
    found = dict(zip(names, point.coordinates(PROFILE)[0].tolist(), strict=True))
    assert all(found[name] == value for name, value in point.position.items())
    assert [found[f"goal.{axis}"] for axis in "xy"] == [found[f"{point.goal}.{axis}"] for axis in "xy"]
    assert {found[name] for name in names if name.endswith((".vx", ".vy"))} == {0.0}
    assert point.exactly(PROFILE) == {name: F(value) for name, value in found.items()}
    assert point.floats and not replace(point, errors={"agent_0:goal_dx": F(1, 3)}).floats


@pytest.mark.parametrize("semantics", [MACHINE, REAL])
@pytest.mark.parametrize("seed", range(6))
def test_a_batch_decides_as_each_state_and_as_thresholds_say(seed, semantics):
    """The support's account of thresholds shares nothing with how states observe."""
    profile, _ = deception(np.random.default_rng(seed), 4)
    coordinates, _, points = drawn(profile, 25, seed)
    for policy in profile.agents:
        batch = states.choose_actions(policy, coordinates, profile.world, semantics)
        leaves = states.find_leaves(policy, coordinates, profile.world, semantics)
        assert (policy.tree.action[leaves] == batch).all()
        for row, point in enumerate(points):
            at = {name: F(value) for name, value in point.position.items()}
            assert states.leaf_at(profile, policy, point, semantics) == leaves[row]
            assert actions_at(profile, at, point.goal, semantics == MACHINE)[policy.agent] == batch[row]


def test_an_error_is_added_before_what_is_measured_is_rounded():
    """agent_0 goes left at landmark_0_dx <= 0.1: an error moves it over that, by the least float32 above."""
    profile = team(small_profile(), tree((2, 0.1, 1, 2), LEFT, RIGHT), tree(STAY))
    policy = profile.policy("agent_0")
    name = policy.features[2].name
    position = dict.fromkeys(everywhere(profile).box, 0.0)
    above = float(np.nextafter(np.float32(0.1), np.float32(1)))
    for error, action in ((0.0, LEFT), (0.1, LEFT), (above, RIGHT), (-1.0, LEFT)):
        at = State(position, "landmark_0", {states.error_name("agent_0", name): error})
        assert states.actions_at(profile, policy.team, at)["agent_0"] == action
        assert states.measurements(profile, policy, at)[2] == F(error)
    assert states.observe_state(profile, policy, replace(at, errors={}))[0, 2] == 0


def moved_in(region, coordinates, rng):
    """Most coordinates clipped into the box, so that some points are inside."""
    names, found = WORLD.coordinates(), coordinates.copy()
    for name, (low, high) in region.box.items():
        column = names.index(name)
        clipped = np.clip(found[:, column], float(low), float(high))
        found[:, column] = np.where(rng.random(len(found)) < 0.02, found[:, column], clipped)
    return found


@pytest.mark.parametrize("seed", range(10))
def test_a_point_is_inside_exactly(seed):
    rng = np.random.default_rng(seed)
    region = random_region(rng, PROFILE)
    coordinates = moved_in(region, drawn(PROFILE, 60, seed)[0], rng)
    points = [states.state_at(region, WORLD, row, 0) for row in coordinates]
    exactly = [exactly_inside(region, {n: F(v) for n, v in point.position.items()}) for point in points]
    assert [states.inside(region, point) for point in points] == exactly


def test_a_batch_is_inside_where_its_points_are():
    """All numbers are eighths, which float64 adds without rounding; some points lie on borders."""
    rng = np.random.default_rng(4)
    box = {name: (F(-1), F(int(rng.integers(-2, 9)), 8)) for name in start_region(WORLD).box}
    differences = (("agent_0.x", "agent_1.x", (F(-1, 2), F(1, 2))),)
    region = Region(box, (), differences, (("agent_0", "landmark_0", F(1, 4)),))
    coordinates = moved_in(region, rng.integers(-8, 9, (600, len(WORLD.coordinates()))) / 8, rng)
    points = [states.state_at(region, WORLD, row, 0) for row in coordinates]
    found = states.contains(region, coordinates, WORLD)
    assert found.tolist() == [states.inside(region, point) for point in points] and 50 < found.sum() < 550


def test_another_goal_is_outside():
    _, _, (point,) = drawn(PROFILE, 1)
    region = start_region(WORLD)
    assert states.inside(region, point)
    assert not states.inside(replace(region, goals=tuple(g for g in region.goals if g != point.goal)), point)


def test_samples_lie_in_their_region_with_the_goal_at_one_of_its_landmarks():
    box = dict(start_region(WORLD).box) | {"agent_0.x": (F(1, 4), F(1, 2)), "agent_1.y": (F(-1, 8),) * 2}
    difference, apart = ("agent_0.x", "agent_1.x", (F(0), F(1))), ("agent_0", "agent_1", F(1, 2))
    region = Region(box, ("landmark_1",), (difference,), (apart,))
    coordinates, goals = states.sample(region, WORLD, 2_000, 3)
    assert 100 < len(coordinates) < 2_000 and set(goals) == {1}
    names = WORLD.coordinates()
    for axis in "xy":
        assert (coordinates[:, names.index(f"goal.{axis}")] == coordinates[:, names.index(f"landmark_1.{axis}")]).all()
    for row in coordinates[:100]:
        assert states.inside(region, states.state_at(region, WORLD, row, 1))
    again, _ = states.sample(region, WORLD, 2_000, 3)
    assert (again == coordinates).all()


def test_the_nearest_float_is_never_outside():
    third, tenth = F(1, 3), F(1, 10)
    region = Region({"a.x": (third, third + F(1, 10**20)), "b.x": (-tenth, tenth)}, ())
    for value in (third, third + F(1, 10**21)):
        found = states.nearest({"a.x": value, "b.x": tenth, "a:f": -tenth}, region, None, tenth)
        assert abs(found.position["a.x"] - 1 / 3) <= math.ulp(1 / 3)
        assert F(found.position["b.x"]) <= tenth and F(found.errors["a:f"]) >= -tenth
    exact = states.exact_point({"a.x": third, "b.x": F(1, 2), "a:f": F(0)}, region, None)
    assert exact.position == {"a.x": third, "b.x": 0.5} and not exact.errors


@pytest.mark.parametrize("seed", range(5))
def test_a_claim_relaxed_by_more_than_its_shortfall_holds(seed):
    """A claim of one bound: what it lacks is by how much its sum is too large."""
    _, _, points = drawn(PROFILE, 40, seed)
    terms, bound = ((F(1), "agent_0.x"), (F(-1), "agent_1.x")), F(1, 4)
    claim = OwnFormula("defenders", statement=Linear(terms, bound, False))
    question = Question(Game(PROFILE), claim, start_region(WORLD))
    failing = [point for point in points if states.violates(question, point)]
    assert failing
    for point in points:
        over = F(point.position["agent_0.x"]) - F(point.position["agent_1.x"]) - bound
        assert states.violates(question, point) == (over > 0)
        if over > 0:
            assert states.shortfall(question, point) == over


def test_an_agent_is_engaged_with_what_it_closes_in_on_or_is_near_to():
    """towards(0, 0) goes right where landmark_0 is more than 0.05 to the right."""
    claim = find_property("distinct_targets", PROFILE, "defenders", radius=F(1, 10))
    position = dict.fromkeys(start_region(WORLD).box, 0.0) | {"landmark_0.x": 0.75, "landmark_1.x": -0.75}
    at = State(position, "landmark_0")
    actions = states.actions_at(PROFILE, "defenders", at)
    assert actions == {"agent_0": RIGHT, "agent_1": LEFT}
    found = states.find_engaged(PROFILE, claim, at, actions)
    assert found == {"agent_0": ("landmark_0",), "agent_1": ("landmark_1",)}
    assert states.find_engaged(PROFILE, claim, at, dict.fromkeys(actions, RIGHT))["agent_1"] == ("landmark_0",)


def test_what_is_constant_or_compared_is_not_measured():
    assert not states.measurable(ir.Meaning(())) and not states.measurable(ir.Meaning(((1, "a.x"),), "zero"))
    assert states.measurable(ir.Meaning(((1, "a.x"),), "sign"))
