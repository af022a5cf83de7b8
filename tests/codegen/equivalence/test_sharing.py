"""Agents with the same tree share its code in C, and the proofs see what such an agent really calls."""

from dataclasses import replace

import numpy as np
import pytest

from codegen import ir
from codegen.dynamics import motionless
from codegen.equivalence.structure import faults
from codegen.equivalence.symbolic import Definitions, Header, Unreadable
from codegen.importers.c.header import from_header
from codegen.lowering.lower import lower
from codegen.targets.rendered import emit_c

STUMP = ir.Tree(*np.array([[0, 0.5, 1, 2, -1], [-1, 0, -1, -1, 1], [-1, 0, -1, -1, 0]], np.float64).T)
OTHER = replace(STUMP, threshold=np.array([0.25, 0, 0], np.float32))
ACTIONS = tuple(ir.ActionSpec(name, None) for name in ("stay", "go"))


def profile_of(*trees):
    policies = [
        ir.AgentPolicy(f"walker_{k}", "walkers", (ir.FeatureSpec(f"x_{k}", "none", -1, 1, None),), ACTIONS, tree)
        for k, tree in enumerate(trees)
    ]
    names = [policy.agent for policy in policies]
    return ir.PolicyProfile(motionless("walk", "", names, 5, {}), tuple(policies), ir.Provenance("", "", 0, "", ""))


def header_of(profile, style):
    model = lower(profile, style=style)
    return emit_c(model, profile)["walk.h"], model


@pytest.mark.parametrize("style", ["nested", "ordered", "walk"])
def test_the_tree_stands_there_once_and_is_proved_for_all(style):
    profile = profile_of(STUMP, OTHER, STUMP)
    header, model = header_of(profile, style)
    assert [agent.twin and agent.twin.act for agent in model.agents] == [None, None, "walk_walker_0_act"]
    assert header.count("return walk_walker_0_act(x);") == 1
    assert faults(header, profile, model) == {"walker_0": [], "walker_1": [], "walker_2": []}
    asked = [Header(header).decide(f"walk_walker_{k}_act", ["x"], {"x": "b"}, Definitions("")) for k in (0, 2)]
    assert asked[0] == asked[1]


@pytest.mark.parametrize("style", ["nested", "walk"])
def test_agents_share_code_with_those_that_compare_the_same_numbers(style):
    wide = replace(STUMP, numbers="float64")
    profile = profile_of(STUMP, wide, STUMP, wide)
    header, model = header_of(profile, style)
    assert [agent.twin and agent.twin.act for agent in model.agents] == [
        None,
        None,
        *map("walk_walker_{}_act".format, (0, 1)),
    ]
    assert not any(faults(header, profile, model).values())
    origins = from_header(header.encode(), "walk.h")
    assert [origin.numbers for origin in origins.values()] == ["float32", "float64"] * 2


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("return walk_walker_0_act(x);", "return walk_walker_1_act(x);", "node 0 has the threshold"),
        ("walk_walker_0_act_columns(x, n, actions);", "walk_walker_1_act_columns(x, n, actions);", "node 0 has"),
        ("return walk_walker_0_act(x);", "return walk_walker_2_act(x);", "there is no function"),
        ("return walk_walker_0_act(x);", "return walk_walker_0_finite(x);", "act: "),
        ("return walk_walker_0_act(x);", "return walk_walker_0_act(x + 1);", "there is no function"),
    ],
)
def test_a_call_of_something_else_is_found(old, new, said):
    profile = profile_of(STUMP, OTHER, STUMP)
    header, model = header_of(profile, "nested")
    assert old in header
    found = faults(header.replace(old, new), profile, model)
    assert found["walker_0"] == found["walker_1"] == [] and any(said in each for each in found["walker_2"]), found


def test_a_call_in_another_way_is_not_read():
    header, _ = header_of(profile_of(STUMP, STUMP), "nested")
    changed = header.replace("return walk_walker_0_act(x);", "return walk_walker_0_act(x + 1);")
    with pytest.raises(Unreadable, match="in another way"):
        Header(changed).decide("walk_walker_1_act", ["x"], {"x": "b"}, Definitions(""))
