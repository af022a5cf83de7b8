"""Sums of a few trees as one tree: each path goes through the trees in turn.

Does: leaves out tests that earlier tests on the path decide; hands the leaves of a path to whoever adds them.
Assumes: readers of the single trees, as for nodes.py.
Does not: add anything itself, or take trees whose product is large.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from codegen.errors import InputError
from codegen.importers.nodes import Leaf, Split
from codegen.importers.symbolic.line import at_most, below

MAX_LEAVES = 4_096  # of the one tree: with more it is no longer looked at, and compilers take minutes


class Tree(NamedTuple):
    """One of the trees: its root, and what reads its nodes."""

    root: Any
    read: Callable[[Any], Split | Leaf]


class State(NamedTuple):
    """Where a path is: the place of a tree and a node of it, the leaves before it, and between which numbers each
    feature lies: above `low`, at most `high`.
    """

    place: int
    node: Any
    leaves: tuple[Leaf, ...]
    low: Mapping[int, float]
    high: Mapping[int, float]


class Product:
    """The one tree. InputError where it would have more than MAX_LEAVES leaves."""

    def __init__(self, trees: Sequence[Tree], added: Callable[[Sequence[Leaf]], Leaf], where: str) -> None:
        self._trees, self._added = trees, added
        self.root = State(0, trees[0].root, (), {}, {})
        self._ensure_small(where)

    def _ensure_small(self, where: str) -> None:
        leaves, open_ = 0, [self.root]
        while open_:
            each = self.read(open_.pop())
            if isinstance(each, Split):
                open_ += [each.otherwise, each.then]
                continue
            leaves += 1
            if leaves > MAX_LEAVES:
                what = f"{len(self._trees)} trees together have more than {MAX_LEAVES:,} leaves"
                raise InputError(what, where, "train fewer or smaller trees (n_estimators, max_depth, num_leaves)")

    def read(self, state: State) -> Split | Leaf:
        """The next test on a path that is still open, or the sum of its leaves."""
        place, node, leaves = state.place, state.node, state.leaves
        while True:
            each = self._trees[place].read(node)
            if isinstance(each, Split):
                left, right, threshold = _sides(each)
                if state.high.get(each.feature, float("inf")) <= threshold:
                    node = left
                elif state.low.get(each.feature, float("-inf")) >= threshold:
                    node = right
                else:
                    here = State(place, node, leaves, state.low, state.high)
                    return _open(each, here, threshold)
                continue
            leaves = (*leaves, each)
            if len(leaves) == len(self._trees):
                return self._added(leaves)
            place += 1
            node = self._trees[place].root


def _sides(each: Split) -> tuple[Any, Any, float]:
    """Where `x <= threshold` goes, where all else goes, and the threshold."""
    turned = each.sign in (">", ">=")
    threshold = at_most(each.number) if each.sign in ("<=", ">") else below(each.number)
    return (each.otherwise, each.then, threshold) if turned else (each.then, each.otherwise, threshold)


def _open(each: Split, here: State, threshold: float) -> Split:
    left, right, _ = _sides(each)
    at_left = here._replace(node=left, high={**here.high, each.feature: threshold})
    at_right = here._replace(node=right, low={**here.low, each.feature: threshold})
    turned = each.sign in (">", ">=")
    then, otherwise = (at_right, at_left) if turned else (at_left, at_right)
    return each._replace(then=then, otherwise=otherwise)
