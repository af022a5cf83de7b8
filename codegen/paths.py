"""Paths through a tree: the boxes of observations that they leave, which actions are legal there, trees as arrays.

Does: intervals (low, high] of features, halved test by test; nested trees in preorder; finds the feature that says
  whether an action is legal (an action mask), and the leaves that may take an illegal one.
Assumes: sound trees; in every observation at least one action is legal.
Does not: change a tree (maviper's extraction does), or serve what checks a claim or a proof, beside refusing trees that
  may act illegally: those read trees on their own.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias, TypeVar

import numpy as np

from codegen.ir import NO_ACTION, NO_CHILD, NO_FEATURE, ROOT, ActionSpec, FeatureSpec, Tree

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


LEGAL: Final = 0.5  # a mask's feature is above it where its action is legal
Mask: TypeAlias = tuple[int | None, ...]  # per action: the feature that says whether it is legal; None: it always is


def mask_of(features: Sequence[FeatureSpec], actions: Sequence[ActionSpec]) -> Mask | None:
    """The mask of an agent's actions; None where all are always legal, or a mask names a feature that is not there."""
    places = {feature.name: place for place, feature in enumerate(features)}
    if not all(action.legal_if in places for action in actions if action.legal_if):
        return None
    mask = tuple(places[action.legal_if] if action.legal_if else None for action in actions)
    return mask if any(place is not None for place in mask) else None


def illegal_leaves(tree: Tree, mask: Mask) -> Iterator[int]:
    """The leaves that some observation reaches in which their action is illegal although another one is legal."""
    return (leaf for leaf, box in boxes_of(tree) if not _lawful(box, mask, int(tree.action[leaf])))


def boxes_of(tree: Tree, box: Box = EVERYTHING) -> Iterator[tuple[int, Box]]:
    """The leaves that observations of a box reach, left to right, each with the box of those that do."""
    stack: list[tuple[int, Box]] = [(ROOT, box)]
    while stack:
        node, box = stack.pop()
        if tree.feature[node] == NO_FEATURE:
            yield node, box
            continue
        sides = box.split_at(int(tree.feature[node]), float(tree.threshold[node]))
        for child, side in zip((tree.right[node], tree.left[node]), reversed(sides), strict=True):
            if side is not None:
                stack.append((int(child), side))


def _lawful(box: Box, mask: Mask, action: int) -> bool:
    own = mask[action]
    if own is None or box.low.get(own, LEGAL - 1) >= LEGAL:
        return True
    others = [place for place in mask if place != own]  # what has the same feature is illegal with it
    return all(place is not None and box.high.get(place, LEGAL + 1) <= LEGAL for place in others)
