"""Steps before a tree, folded into its thresholds.

Does: finds, for each test of the tree, the float32 number at which it turns, through the steps' own arithmetic.
Assumes: each test looks at one number of the observation, and what it sees never falls (or never rises) where that
  number rises.
Does not: know any step (steps.py, onnx/columns.py).

Subtractions, additions, products with and quotients by numbers that are not 0, clipping and comparisons have that
property, and so has rounding, in float32 or float64. So a test holds for all numbers up to one, or from one on, and for
no others; bisection over all float32 numbers in their order finds that one.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from codegen.ir import NO_ACTION, NO_CHILD, NO_FEATURE, Bool, Float32, GrownTree

LARGEST, INFINITE = np.float32(np.finfo(np.float32).max), np.float32(np.inf)


class Asked(NamedTuple):
    """What the n splits of a tree ask, in the order of their nodes."""

    source: npt.NDArray[Any]  # [n] the number of the observation that each one looks at
    rising: Bool  # [n] whether what it sees never falls where that number rises; else it never rises
    passes: Callable[[Float32], Bool]  # numbers [n], one for each split -> which splits send them to the left


class Folded(NamedTuple):
    """A tree over the observations before the steps."""

    tree: GrownTree
    nan: bool  # whether a NaN, which goes right, goes where the steps and their tree send it


def fold_steps(tree: GrownTree, tests: Asked, largest: np.float32 = INFINITE) -> Folded:
    """The tree over the observations before the steps, for numbers from -`largest` to `largest`."""
    split = np.flatnonzero(tree.feature != NO_FEATURE)
    if not len(split):
        return Folded(tree, True)
    turn = np.where(tests.rising, 1, -1)

    def passes(order: Any) -> Bool:
        return tests.passes(_number(turn * order))

    ends = _order(largest)
    low, high = (np.full(len(split), end, dtype=np.int64) for end in (-ends, ends))
    never, always = ~passes(low), passes(high)
    while (low < high).any():  # the last number that passes is in [low, high]
        middle = (low + high + 1) // 2
        good = passes(middle)
        low, high = np.where(good, middle, low), np.where(good, high, middle - 1)
    threshold, feature = np.zeros(len(tree.feature)), tree.feature.copy()
    # what passes from a number on fails up to the one before it
    threshold[split], feature[split] = _number(np.where(tests.rising, low, -low - 1)), tests.source
    left, right = tree.left.copy(), tree.right.copy()
    turned = split[~tests.rising]
    left[turned], right[turned] = tree.right[turned], tree.left[turned]
    skip = dict(zip(split[never].tolist(), tree.right[split[never]].tolist(), strict=True))
    skip |= dict(zip(split[always].tolist(), tree.left[split[always]].tolist(), strict=True))
    to_the_left = np.where(never | always, always, ~tests.rising)  # where a NaN goes here, as the steps' tree names it
    nan = (tests.passes(np.full(len(split), np.nan, dtype=np.float32)) == to_the_left).all()
    return Folded(without(GrownTree(feature, threshold, left, right, tree.action), skip), bool(nan))


def _order(number: Any) -> int:
    """The place of a positive float32 in the order of all: 0 for 0."""
    return int(np.float32(number).view(np.int32))


def _number(order: Any) -> Float32:
    """The float32 numbers at places of their order; what lies before -infinity is -infinity."""
    bits: Float32 = np.minimum(np.abs(order), _order(INFINITE)).astype(np.int32).view(np.float32)
    return np.where(np.asarray(order) < 0, -bits, bits)


def without(tree: GrownTree, skip: dict[int, int]) -> GrownTree:
    """The tree without splits that all observations pass on one side; `skip`: node -> that side."""

    def follow_skips(node: int) -> int:
        while node in skip:
            node = skip[node]
        return node

    order, open_ = list[int](), [follow_skips(0)]
    while open_:
        node = open_.pop()
        order.append(node)
        if tree.feature[node] != NO_FEATURE:
            open_ += [follow_skips(int(tree.right[node])), follow_skips(int(tree.left[node]))]
    place = {node: index for index, node in enumerate(order)} | {NO_CHILD: NO_CHILD}
    left, right = ([place[follow_skips(int(side[node]))] for node in order] for side in (tree.left, tree.right))
    return GrownTree(tree.feature[order], tree.threshold[order], np.array(left), np.array(right), tree.action[order])


def without_alike(tree: GrownTree) -> GrownTree:
    """The tree without splits whose sides decide alike, or of which one side is ruled out: NO_ACTION leaves."""
    skip, kinds = dict[int, int](), dict[Any, int]()  # what decides, and its number
    kind = [NO_ACTION] * len(tree.feature)
    rows = list(zip(*(each.tolist() for each in (tree.feature, tree.threshold, tree.left, tree.right)), strict=True))
    for node in range(len(rows) - 1, -1, -1):  # preorder: children come after their parents
        feature, threshold, left, right = rows[node]
        sides = () if feature == NO_FEATURE else (kind[left], kind[right])
        if not sides:
            action = int(tree.action[node])
            kind[node] = action if action == NO_ACTION else kinds.setdefault(action, len(kinds))
        elif sides[0] == sides[1] or NO_ACTION in sides:
            skip[node] = right if sides[0] == NO_ACTION else left
            kind[node] = kind[skip[node]]
        else:
            kind[node] = kinds.setdefault((feature, threshold, sides), len(kinds))
    return without(tree, skip)
