"""Hypothesis strategies for trees, profiles and observations."""

from dataclasses import replace

import numpy as np
from hypothesis import strategies as st

from codegen import ir
from codegen.lowering.deploy import deploy_tree
from maviper.worlds import PhysicalDeception

WORLD = PhysicalDeception()
FLOAT32 = st.floats(width=32, allow_nan=False, allow_infinity=False)
# thresholds where doubles and float32 differ, around zero and at the ends of the format
THRESHOLDS = st.one_of(
    st.floats(-3, 3, allow_nan=False),
    FLOAT32,
    st.sampled_from([0.0, -0.0, 0.1, 1.0, -1.0, 1e-45, -1e-45, 1e-38, 3.4028234663852886e38, 0.30000000000000004]),
)


@st.composite
def grown_trees(draw, n_features=10, n_actions=5, max_depth=4):
    """A grown tree with float64 thresholds, numbered level by level, as the learner does."""
    feature, threshold, left, right, action = [], [], [], [], []
    levels = [0]
    feature.append(None)
    for place in range(10_000):
        if place >= len(feature):
            break
        if levels[place] < max_depth and draw(st.booleans()):
            feature[place] = draw(st.integers(0, n_features - 1))
            threshold.append(draw(THRESHOLDS))
            left.append(len(feature))
            right.append(len(feature) + 1)
            action.append(ir.NO_ACTION)
            feature += [None, None]
            levels += [levels[place] + 1] * 2
        else:
            feature[place] = ir.NO_FEATURE
            threshold.append(0.0)
            left.append(ir.NO_CHILD)
            right.append(ir.NO_CHILD)
            action.append(draw(st.integers(0, n_actions - 1)))
    return ir.GrownTree(np.array(feature), np.array(threshold), np.array(left), np.array(right), np.array(action))


@st.composite
def profiles(draw, max_depth=4):
    """A physical deception profile with random trees."""
    agents = []
    for name, features, actions in zip(WORLD.agents, WORLD.features, WORLD.actions, strict=True):
        grown = draw(grown_trees(len(features), len(actions), max_depth))
        agents.append(ir.AgentPolicy(name, WORLD.team_of(name), features, actions, deploy_tree(grown), grown))
    provenance = ir.Provenance("random", "none", draw(st.integers(0, 9)), "", "tests")
    return ir.PolicyProfile(WORLD.spec, tuple(agents), provenance)


def with_trees(trees: dict[str, ir.Tree], base: ir.PolicyProfile) -> ir.PolicyProfile:
    """`base` with the deployed trees of some agents replaced, and no grown ones."""
    agents = tuple(replace(policy, tree=trees.get(policy.agent, policy.tree), grown=None) for policy in base.agents)
    return replace(base, agents=agents)
