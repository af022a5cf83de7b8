"""Trees that may act illegally are no profiles; what says that an action is legal survives files and compilation."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from codegen import ir, policy_json, profiles
from codegen.dynamics import motionless
from codegen.errors import ProfileError
from codegen.lowering.lower import lower
from codegen.paths import illegal_leaves, mask_of
from codegen.profiles import check
from codegen.targets import emit_model
from codegen.targets.rendered import emit_c
from tests.support.teams import nested

ACTIONS = 3
FEATURES = tuple(
    ir.FeatureSpec(name, "none", 0.0, 1.0, None) for name in ("place", *(f"legal_{k}" for k in range(ACTIONS)))
)
CHOICES = tuple(ir.ActionSpec(f"go_{k}", None, f"legal_{k}") for k in range(ACTIONS))


def tree_of(*rows):
    return ir.Tree(*np.array(rows, dtype=np.float64).T)


def profile_of(tree, actions=CHOICES):
    policy = ir.AgentPolicy("walker", "walkers", FEATURES, actions, tree)
    return ir.PolicyProfile(motionless("walk", "", ["walker"], 5, {}), (policy,), ir.Provenance("", "", 0, "", ""))


# go_1 where it is legal, else go_0, else go_2
LAWFUL = tree_of((2, 0.5, 1, 4, -1), (1, 0.5, 2, 3, -1), (-1, 0, -1, -1, 2), (-1, 0, -1, -1, 0), (-1, 0, -1, -1, 1))


@st.composite
def trees(draw):
    """Random trees over the mask and one other feature, thresholds anywhere near the numbers that a mask has."""

    def grow(depth):
        action = draw(st.integers(0, ACTIONS - 1))
        if not depth or not draw(st.booleans()):
            return action
        feature = draw(st.integers(0, ACTIONS))
        threshold = 0.5 if feature else draw(st.sampled_from([0.25, 0.5, 0.75]))
        return feature, threshold, grow(depth - 1), grow(depth - 1)

    return nested(grow(5))


def acts_illegally(tree):
    """By trying every mask in which something is legal, and places between all thresholds."""
    for bits in range(1, 2**ACTIONS):
        legal = [float(bits >> k & 1) for k in range(ACTIONS)]
        for place in (0.2, 0.4, 0.6, 0.8):
            obs = np.array([[place, *legal]], np.float32)
            action = int(tree.action[ir.apply(tree, obs)[0]])
            if not legal[action]:
                return True
    return False


@given(trees())
def test_exactly_the_trees_that_may_act_illegally_are_refused(tree):
    wrong = acts_illegally(tree)
    mask = mask_of(FEATURES, CHOICES)
    assert mask == (1, 2, 3)
    assert bool(list(illegal_leaves(tree, mask))) == wrong
    assert bool(check(profile_of(tree))) == wrong


def test_a_profile_keeps_what_makes_an_action_legal():
    profile = profile_of(LAWFUL)
    assert not check(profile)
    again = profiles.loads(policy_json.dumps(profile))
    assert again.agents[0].actions == CHOICES
    assert '"legal_if": "legal_1"' in policy_json.dumps(profile)


def test_actions_that_are_always_legal_need_no_test():
    actions = (replace(CHOICES[0], legal_if=""), *CHOICES[1:])
    leaf = tree_of((-1, 0, -1, -1, 0))
    assert not check(profile_of(leaf, actions))
    assert check(profile_of(tree_of((-1, 0, -1, -1, 1)), actions))


def test_refusals_say_where_and_what():
    unsafe = profile_of(tree_of((-1, 0, -1, -1, 1)))
    assert [(each.path, each.message) for each in check(unsafe)] == [
        ("$.agents[0].tree[0]", "takes 'go_1' where it may be illegal")
    ]
    misspelt = profile_of(LAWFUL, (replace(CHOICES[0], legal_if="lgeal_0"), *CHOICES[1:]))
    with pytest.raises(ProfileError, match=r"actions\[0\]\.legal_if: no feature 'lgeal_0'; did you mean 'legal_0'"):
        profiles.loads(policy_json.dumps(misspelt))


def test_generated_code_says_which_actions_are_legal():
    profile = profile_of(LAWFUL)
    model = lower(profile)
    header = emit_c(model, profile)["walk.h"]
    assert "WALK_WALKER_GO_1 = 1, /* legal where LEGAL_1 is 1 */" in header
    assert "takes legal actions only" in header
    module = emit_model(model, profile, ["python"])["walk.py"]
    assert "GO_1 = 1  # legal where LEGAL_1 is 1" in module and "Takes legal actions only" in module
    free = profile_of(tree_of((-1, 0, -1, -1, 0)), tuple(replace(each, legal_if="") for each in CHOICES))
    assert "legal" not in emit_c(lower(free), free)["walk.h"].replace("LEGAL_", "")
