"""Paths through a tree: the boxes of observations that they leave, and nested trees written as arrays.

Does: intervals (low, high] of features, halved test by test; the box of a node, what is above and below it; preorder;
  how many numbers stand in a tree.
Assumes: sound trees.
Does not: serve what checks a claim or a proof, beside refusing trees that may act illegally (legality.py): those read
  trees on their own.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeAlias, TypeVar

import numpy as np

from codegen.floats import neighbour
from codegen.ir import NO_ACTION, NO_CHILD, NO_FEATURE, ROOT, AgentPolicy, Floats, Tree

Node = TypeVar("Node")
Corners: TypeAlias = tuple[Floats, Floats]  # the ends (low, high] of each feature, [n_features]


@dataclass(frozen=True)
class Box:
    """Observations within intervals (low, high] of features; one without `high` holds infinity and NaN too."""

    low: dict[int, float]
    high: dict[int, float]

    def split_at(self, feature: int, threshold: float) -> tuple["Box | None", "Box | None"]:
        """What of it goes left and what goes right at a test; None for nothing."""
        low, high = self.low.get(feature), self.high.get(feature)
        left = right = None
        if low is None or low < threshold:
            left = self if high is not None and high <= threshold else Box(self.low, self.high | {feature: threshold})
        if high is None or threshold < high:
            right = self if low is not None and low >= threshold else Box(self.low | {feature: threshold}, self.high)
        return left, right

    def point(self, n_features: int, numbers: str) -> Floats:
        """An observation in it, [n_features], of these numbers."""
        observation = np.zeros(n_features, dtype=numbers)
        for feature in self.low.keys() | self.high.keys():
            high, low = self.high.get(feature), self.low.get(feature, 0.0)
            observation[feature] = neighbour(low, np.inf, numbers) if high is None else high
        return observation


EVERYTHING = Box({}, {})


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


def in_preorder(root: Node, parts: Callable[[Node], int | tuple[int, float, Node, Node]], numbers: str) -> Tree:
    """A nested tree as arrays. `parts`: a leaf's action, or the feature, threshold and sides of a split; `numbers`:
    what it compares.
    """
    rows: list[list[float]] = []
    stack: list[tuple[Node, int, int]] = [(root, NO_CHILD, 0)]
    while stack:
        node, parent, column = stack.pop()
        place = len(rows)
        if parent != NO_CHILD:
            rows[parent][column] = place
        part = parts(node)
        if isinstance(part, int):
            rows.append([NO_FEATURE, 0.0, NO_CHILD, NO_CHILD, part])
            continue
        feature, threshold, left, right = part
        rows.append([feature, threshold, NO_CHILD, NO_CHILD, NO_ACTION])
        stack += [(right, place, 3), (left, place, 2)]
    return Tree(*np.array(rows).T, numbers=numbers)


def size(policy: AgentPolicy) -> int:
    """How many numbers stand in a tree: a test's threshold and a sum's weights, a leaf's action or all of its terms."""
    tree, n = policy.tree, len(policy.features)
    tested: list[int] = tree.feature[tree.feature != NO_FEATURE].tolist()
    chosen: list[int] = tree.action[tree.feature == NO_FEATURE].tolist()
    tests = [1 if each < n else 1 + len(tree.sums[each - n].terms) for each in tested]
    given = [sum(len(each.terms) for each in vector) for vector in tree.vectors] or [1] * len(policy.actions)
    return sum(tests) + sum(given[each] for each in chosen)
