"""Branches of a tree: what is above and below a node, the observations that reach it, and how many numbers stand there.

Does: the way up from a node, the leaves below it, its box and a point of a box; tests as corners of boxes.
Assumes: sound trees.
Does not: belong to what proofs rest on.
"""

from itertools import pairwise
from typing import TypeAlias

import numpy as np

from codegen.ir import NO_FEATURE, ROOT, AgentPolicy, Floats, Tree
from codegen.numbers.rounding import neighbour
from codegen.paths import Box

Corners: TypeAlias = tuple[Floats, Floats]  # the ends (low, high] of each feature, [n_features]


def find_point(box: Box, n_features: int, numbers: str) -> Floats:
    """An observation in a box, [n_features], of these numbers."""
    observation = np.zeros(n_features, dtype=numbers)
    for feature in box.low.keys() | box.high.keys():
        high, low = box.high.get(feature), box.low.get(feature, 0.0)
        observation[feature] = neighbour(low, np.inf, numbers) if high is None else high
    return observation


def upwards(tree: Tree, node: int) -> list[int]:
    """A node and all above it, up to the root."""
    path = [node]
    while path[-1] != ROOT:
        path.append(int(np.flatnonzero((tree.left == path[-1]) | (tree.right == path[-1]))[0]))
    return path


def leaves_below(tree: Tree, node: int) -> list[int]:
    """The leaves of the part of a tree that begins at a node, from left to right; of a leaf itself."""
    leaves, waiting = list[int](), [node]
    while waiting:  # no recursion: chains of tests may be thousands long
        first = waiting.pop()
        if tree.feature[first] == NO_FEATURE:
            leaves.append(first)
        else:
            waiting += [int(tree.right[first]), int(tree.left[first])]
    return leaves


def box_of(tree: Tree, node: int) -> Box:
    """The observations that reach a node: none where a low end is not below its high end."""
    low: dict[int, float] = {}
    high: dict[int, float] = {}
    way = upwards(tree, node)
    for below, parent in pairwise(way):
        feature, threshold = int(tree.feature[parent]), float(tree.threshold[parent])
        if tree.left[parent] == below:
            high[feature] = min(high.get(feature, threshold), threshold)
        else:
            low[feature] = max(low.get(feature, threshold), threshold)
    return Box(low, high)


def split_corners(low: Floats, high: Floats, feature: int, threshold: np.floating) -> tuple[Corners, Corners]:
    """What goes left and what goes right at a test, as arrays; a side is empty where its low end is not below."""
    most, least = high.copy(), low.copy()
    most[feature] = min(high[feature], threshold)
    least[feature] = max(low[feature], threshold)
    return (low, most), (least, high)


def size(policy: AgentPolicy) -> int:
    """How many numbers stand in a tree: a test's threshold and a sum's weights, a leaf's action or all of its terms."""
    tree, n = policy.tree, len(policy.features)
    tested: list[int] = tree.feature[tree.feature != NO_FEATURE].tolist()
    chosen: list[int] = tree.action[tree.feature == NO_FEATURE].tolist()
    tests = [1 if each < n else 1 + len(tree.sums[each - n].terms) for each in tested]
    given = [sum(len(each.terms) for each in vector) for vector in tree.vectors] or [1] * len(policy.actions)
    return sum(tests) + sum(given[each] for each in chosen)
