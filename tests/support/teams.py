"""Small hand-made teams whose verdicts are known."""

import numpy as np

from codegen import ir
from codegen.paths import in_preorder
from maviper.worlds import find
from tests.support.strategies import with_trees


def tree(*nodes):
    """A tree from (feature, threshold, left, right) splits and bare actions."""
    columns = [(*node, -1) if isinstance(node, tuple) else (-1, 0.0, -1, -1, node) for node in nodes]
    return ir.Tree(*(np.array(column) for column in zip(*columns, strict=True)))


def nested(node, numbers="float32"):
    """A tree from nested (feature, threshold, left, right) and bare actions."""
    return in_preorder(node, lambda each: each, numbers)


STAY, LEFT, RIGHT, DOWN, UP = range(5)


def towards(k, index):
    """Goes to landmark k along the axis on which it is farther, with tests on its offsets only."""
    dx, dy = 2 + 2 * k, 3 + 2 * k
    # x first unless it is within a tenth
    return tree(
        (dx, -0.05, 1, 2), LEFT, (dx, 0.05, 3, 6), (dy, 0.0, 4, 5), DOWN, UP, RIGHT,
    )  # fmt: skip


def team(profile, first, second):
    return with_trees({"agent_0": first, "agent_1": second}, profile)


def team_in(world, trees):
    """A profile of a world, given itself or by its name, with a tree for each agent."""
    world = find(world) if isinstance(world, str) else world
    columns = zip(world.agents, world.features, world.actions, trees, strict=True)
    policies = (ir.AgentPolicy(agent, world.team_of(agent), *rest) for agent, *rest in columns)
    return ir.PolicyProfile(world.spec, tuple(policies), ir.Provenance("", "", 0, "", ""))


def average_tests(one, seen):
    """The mean number of tests that observations [n, n_features] meet: the depth of the leaf that each ends in."""
    return float(ir.depth(one)[ir.apply(one, seen)].mean())
