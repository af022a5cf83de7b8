"""Many trees at once, and small changes to one.

Does: applies a stack of trees to observations, each row with a tree of its own; copies of a tree with a change.
Assumes: trees over the same features, their thresholds rounded as they are deployed; changes are to trees without sums.
Does not: judge trees.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from codegen import ir
from codegen.floats import round_down
from codegen.ir import NO_ACTION, NO_CHILD, NO_FEATURE, ROOT, Bool, Float32, GrownTree
from codegen.lowering.deploy import SummedTree
from maviper.episodes.trees import agent_policies
from maviper.worlds import World
from maviper.worlds.world import Int


@dataclass(frozen=True)
class Stack:
    """`n_trees` trees padded to the same number of nodes; a leaf is its own child."""

    feature: Int  # [n_trees * n_nodes], as all others; 0 at a leaf
    threshold: Float32  # NaN at a leaf, so that every observation goes right
    left: Int  # places in these arrays
    right: Int
    action: Int
    n_nodes: int
    depth: int

    @staticmethod
    def of(trees: Sequence[GrownTree]) -> "Stack":
        """A stack of trees."""
        n_nodes = max(len(tree.feature) for tree in trees)
        size = len(trees) * n_nodes
        feature, action = np.zeros(size, dtype=np.int64), np.zeros(size, dtype=np.int64)
        threshold = np.full(size, np.nan, dtype=np.float32)
        left, right = np.arange(size), np.arange(size)
        depth = 0
        for index, tree in enumerate(trees):
            first = index * n_nodes
            here = slice(first, first + len(tree.feature))
            split = tree.feature != NO_FEATURE
            feature[here] = np.where(split, tree.feature, 0)
            threshold[here] = np.where(split, round_down(tree.threshold), np.float32(np.nan))
            left[here] = np.where(split, first + tree.left, left[here])
            right[here] = np.where(split, first + tree.right, right[here])
            action[here] = np.where(split, 0, tree.action)
            depth = max(depth, int(ir.depth(tree).max()))
        return Stack(feature, threshold, left, right, action, n_nodes, depth)

    def act(self, which: Int, obs: Float32) -> Int:
        """What tree `which[row]` does with each row of `obs` [n, n_features], [n]."""
        node = which * self.n_nodes
        flat, base = np.ascontiguousarray(obs).ravel(), np.arange(len(obs)) * obs.shape[1]
        for _ in range(self.depth):
            goes_left = flat[base + self.feature[node]] <= self.threshold[node]
            node = np.where(goes_left, self.left[node], self.right[node])
        return self.action[node]


@dataclass(frozen=True)
class OneByOne:
    """Trees that test sums or give numbers, each asked for its own rows."""

    policies: Sequence[ir.AgentPolicy]

    def act(self, which: Int, obs: Float32) -> Any:
        """As `Stack.act`, or [n, n_outputs]."""
        shape = (len(obs), len(self.policies[0].outputs)) if self.policies[0].outputs else len(obs)
        decisions: Any = np.zeros(shape, np.float32 if self.policies[0].outputs else np.int64)
        for place, policy in enumerate(self.policies):
            rows = np.flatnonzero(which == place)
            decisions[rows] = ir.outputs(policy, obs[rows]) if policy.outputs else ir.act(policy, obs[rows])
        return decisions


def stack_trees(world: World, agent: int, trees: Sequence[GrownTree]) -> Stack | OneByOne:
    """Trees of an agent, to be asked at once."""
    if any(isinstance(tree, SummedTree) for tree in trees):
        return OneByOne([agent_policies(world, [tree], [agent])[0] for tree in trees])
    return Stack.of(trees)


def reaching(tree: GrownTree, obs: Float32) -> dict[int, Int]:
    """Which rows of `obs` pass through each node: node -> rows; every node from the root down that any row reaches."""
    threshold = round_down(tree.threshold)
    rows_at: dict[int, Int] = {ROOT: np.arange(len(obs))}
    stack = [ROOT]
    while stack:
        node = stack.pop()
        if tree.feature[node] == NO_FEATURE:
            continue
        rows = rows_at[node]
        goes_left: Bool = obs[rows, tree.feature[node]] <= threshold[node]
        for child, part in ((int(tree.left[node]), rows[goes_left]), (int(tree.right[node]), rows[~goes_left])):
            if part.size:
                rows_at[child] = part
                stack.append(child)
    return rows_at


def with_leaf(tree: GrownTree, node: int, action: int) -> GrownTree:
    """The tree with a leaf at `node` instead of what is there."""
    arrays = _copies(tree)
    for array, value in zip(arrays, (NO_FEATURE, 0.0, NO_CHILD, NO_CHILD, action), strict=True):
        array[node] = value
    return _compact(arrays)


def with_split(tree: GrownTree, node: int, feature: int, threshold: float) -> GrownTree:
    """The tree with another test at the split `node`."""
    arrays = _copies(tree)
    arrays[0][node], arrays[1][node] = feature, threshold
    return GrownTree(*arrays)


def with_new_split(tree: GrownTree, leaf: int, feature: int, threshold: float, actions: tuple[int, int]) -> GrownTree:
    """The tree with a leaf turned into a split with two leaves."""
    n = len(tree.feature)
    added = ([NO_FEATURE] * 2, [0.0] * 2, [NO_CHILD] * 2, [NO_CHILD] * 2, list(actions))
    arrays = [np.concatenate([array, more]) for array, more in zip(_copies(tree), added, strict=True)]
    for array, value in zip(arrays, (feature, threshold, n, n + 1, NO_ACTION), strict=True):
        array[leaf] = value
    return GrownTree(*arrays)


def merge_leaves(tree: GrownTree) -> GrownTree:
    """The tree without splits that decide nothing: equal sibling leaves become one, from the bottom up."""
    arrays = _copies(tree)
    feature, _, left, right, action = arrays
    order = np.argsort(-ir.depth(tree), kind="stable")
    for node in order:
        if feature[node] != NO_FEATURE:
            a, b = left[node], right[node]
            if feature[a] == feature[b] == NO_FEATURE and action[a] == action[b]:
                for array, value in zip(arrays, (NO_FEATURE, 0.0, NO_CHILD, NO_CHILD, action[a]), strict=True):
                    array[node] = value
    return _compact(arrays)


def _copies(tree: GrownTree) -> list[np.ndarray]:
    return [array.copy() for array in (tree.feature, tree.threshold, tree.left, tree.right, tree.action)]


def _compact(arrays: Sequence[np.ndarray]) -> GrownTree:
    """Without nodes that the root no longer leads to; the others keep their order."""
    feature, _, left, right, _ = arrays
    kept = np.zeros(len(feature), dtype=bool)
    stack = [ROOT]
    while stack:
        node = stack.pop()
        kept[node] = True
        if feature[node] != NO_FEATURE:
            stack += [int(left[node]), int(right[node])]
    place = np.append(np.cumsum(kept) - 1, NO_CHILD)  # the last entry is what NO_CHILD leads to
    feature, threshold, left, right, action = (array[kept] for array in arrays)
    return GrownTree(feature, threshold, place[left], place[right], action)
