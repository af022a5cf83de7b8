"""Paths through a tree: the boxes of observations that they leave, and nested trees written as arrays.

Does: intervals (low, high] of features, halved test by test; preorder.
Assumes: sound trees.
Does not: serve what checks a claim or a proof, beside refusing trees that may act illegally (legality.py): those read
  trees on their own.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from codegen.ir import NO_ACTION, NO_CHILD, NO_FEATURE, Tree

Node = TypeVar("Node")


@dataclass(frozen=True)
class Box:
    """Observations within intervals (low, high] of features; one without `high` holds infinity and NaN too."""

    low: dict[int, float]
    high: dict[int, float]

    def split_at(self, feature: int, threshold: float) -> tuple["Box | None", "Box | None"]:
        """Returns the parts of it that go left and right at a test; None for nothing."""
        low, high = self.low.get(feature), self.high.get(feature)
        left = right = None
        if low is None or low < threshold:
            left = self if high is not None and high <= threshold else Box(self.low, self.high | {feature: threshold})
        if high is None or threshold < high:
            right = self if low is not None and low >= threshold else Box(self.low | {feature: threshold}, self.high)
        return left, right


EVERYTHING = Box({}, {})


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
