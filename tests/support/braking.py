"""Trees that test sums, written by hand: agents of cooperative navigation that steer to landmarks and brake."""

import numpy as np

from codegen.ir import NO_ACTION, NO_CHILD, NO_FEATURE, GrownTree
from codegen.lowering.deploy import SummedTree
from maviper.worlds import World


def write_trees(world: World, brake: float = 0.2) -> list[GrownTree]:
    """Four leaves an agent: agent k steers along the longer axis to landmark k, less `brake` seconds of velocity."""
    left, right, down, up = range(1, 5)
    trees: list[GrownTree] = []
    for agent, features in enumerate(world.features):
        names = [feature.name for feature in features]
        tests = np.zeros((2, len(names)), np.float32)
        for axis, signs in (("x", (1.0, 1.0)), ("y", (1.0, -1.0))):
            tests[:, names.index(f"landmark_{agent}_d{axis}")] = signs
            tests[:, names.index(f"v{axis}")] = np.multiply(signs, -brake)
        feature = np.array([len(names), len(names) + 1, len(names) + 1, *[NO_FEATURE] * 4])
        action = np.array([NO_ACTION] * 3 + [left, down, up, right])
        one, other = np.array([1, 3, 5, *[NO_CHILD] * 4]), np.array([2, 4, 6, *[NO_CHILD] * 4])
        trees.append(SummedTree(feature, np.zeros(7), one, other, action, tests, np.zeros((0, 0, len(names) + 1))))
    return trees
