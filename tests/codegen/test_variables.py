"""Coordinates that belong to no entity: rules, JSON form, observation; profiles without them keep their bytes."""

import re
from dataclasses import replace

import numpy as np
import pytest

from codegen import ir
from codegen.dynamics import motionless
from codegen.floats import FLOAT32
from codegen.ir import FeatureSpec, Meaning, VariableSpec
from codegen.observe import observe
from codegen.policy_json import dumps
from codegen.profiles import check, ensure, loads
from tests.support.small import small_profile
from tests.support.teams import tree

ANGLE, SPIN = VariableSpec("angle", "rad", -1.0, 1.0), VariableSpec("pole.spin", "rad/s", -2.0, 2.0)


def profile(*variables):
    """One agent that observes an angle, and an angle less half a spin, in a world of variables alone."""
    features = (
        FeatureSpec("angle", "rad", -1, 1, Meaning(((1.0, "angle"),))),
        FeatureSpec("ahead", "rad", -2, 2, Meaning(((1.0, "angle"), (-0.5, "pole.spin")))),
        FeatureSpec("side", "none", -1, 1, Meaning(((1.0, "angle"),), "sign")),
    )
    actions = (ir.ActionSpec("left", None), ir.ActionSpec("right", None))
    policy = ir.AgentPolicy("cart", "carts", features, actions, tree((1, 0.25, 1, 2), 0, 1))
    world = replace(motionless("pole", "", ()), variables=variables)
    return ir.PolicyProfile(world, (policy,), ir.Provenance("hand-made", "none", 0, "", "tests"))


def test_they_are_coordinates_after_all_others():
    world = replace(small_profile().world, variables=(ANGLE,))
    assert world.coordinates() == (*small_profile().world.coordinates(), "angle")
    assert profile(ANGLE, SPIN).world.coordinates() == ("angle", "pole.spin")


def test_a_profile_comes_back_from_its_text():
    made = ensure(profile(ANGLE, SPIN))
    again = loads(dumps(made))
    assert again.world == made.world and dumps(again) == dumps(made)
    assert [one.meaning for one in again.agents[0].features] == [one.meaning for one in made.agents[0].features]


def test_a_profile_without_them_says_nothing_of_them():
    assert "variables" not in dumps(small_profile())


def test_features_are_observed_from_them():
    seen = observe(
        profile(ANGLE, SPIN).agents[0].features, np.array([[0.5, -2.0]]), profile(ANGLE, SPIN).world, FLOAT32
    )
    assert seen.tolist() == [[0.5, 1.5, 1.0]]


@pytest.mark.parametrize(
    ("variables", "said"),
    [
        ((ANGLE, SPIN, replace(ANGLE, name="Angle")), "variable 'Angle' appears twice"),
        ((ANGLE, replace(SPIN, name="1.spin")), "not a legal name"),
        ((ANGLE, SPIN, replace(SPIN, name="a.b.c")), "not a legal name"),
        ((ANGLE, replace(SPIN, low=3.0)), "low <= high"),
        ((ANGLE, replace(SPIN, high=float("inf"))), "low <= high"),
        ((ANGLE, replace(SPIN, low=float("nan"))), "low <= high"),
        ((ANGLE, replace(SPIN, high=1e10)), "within 1e\\+09"),
        ((ANGLE, replace(SPIN, unit="rad\u202e")), "invisible character"),
        ((ANGLE,), "no coordinate 'pole.spin'"),
        ((ANGLE, SPIN, replace(SPIN, name="goal.x")), "'goal.x' appears twice, or is taken"),  # it is the goal's place
        ((ANGLE, SPIN, replace(ANGLE, name="Goal")), "'Goal' appears twice, or is taken"),
    ],
)
def test_what_is_broken_is_told(variables, said):
    messages = " ".join(violation.message for violation in check(profile(*variables)))
    assert re.search(said, messages), messages


def test_no_name_of_a_coordinate_is_taken_twice():
    world = replace(small_profile().world, variables=(replace(ANGLE, name="agent_0.x"),))
    found = check(replace(small_profile(), world=world))
    assert [violation.path for violation in found] == ["$.world.variables[0]"]


def test_the_name_of_the_goals_place_is_taken_where_there_is_no_goal_too():
    """Claims, tables and certificates read "goal.x" as the goal's place."""
    made = small_profile()
    landmark = ir.EntitySpec("goal", 0.1, 0.0, None, False)
    world = replace(made.world, goals=(), landmarks=(*made.world.landmarks, landmark))
    found = check(replace(made, world=world))
    assert f"$.world.landmarks[{len(made.world.landmarks)}]" in [violation.path for violation in found]


def test_agents_are_entities_where_there_are_entities():
    world = replace(motionless("pole", "", ("other",)), variables=(ANGLE, SPIN))
    assert any(
        "no agent 'cart'" in violation.message for violation in check(replace(profile(ANGLE, SPIN), world=world))
    )
    assert any("no agent 'cart'" in violation.message for violation in check(profile()))
