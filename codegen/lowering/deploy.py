"""From a tree as it was grown to the tree that is deployed.

Does: rounds float64 thresholds down to float32, unless float64 is compared; renumbers the nodes in preorder; brings
  along the sums that are tested, and the numbers that leaves give.
Assumes: the grown tree is sound (the IR's checker looks at both).
Does not: change a decision for any observation of the numbers that are compared.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple, cast

import numpy as np

from codegen.floats import FLOAT32, FLOAT64
from codegen.ir import CONSTANT, NO_CHILD, NO_FEATURE, ROOT, Float32, Float64, GrownTree, Sum, Tree
from codegen.numbers import at_most
from codegen.sums import DOUBLE_SUMS, choose_numbers


@dataclass(frozen=True, eq=False)
class SummedTree(GrownTree):
    """A tree whose tests from the number of features on count in `tests`. Where it has `given`, its leaves give
    numbers, and `action` counts in them. Its sums are double sums, and have a term for each weight that is not 0.
    """

    tests: Float32 = field(metadata={"dtype": np.float32})  # [n_sums, n_features] weights
    given: Float64 = field(metadata={"dtype": np.float64})  # [n_vectors, n_outputs, n_features + 1], the constant last
    arithmetic = DOUBLE_SUMS

    @cached_property
    def sums(self) -> tuple[Sum, ...]:  # type: ignore[override]
        """The sums that it tests."""
        return tuple(_sum(row) for row in self.tests)

    @property
    def vectors(self) -> tuple[tuple[Sum, ...], ...]:
        """The numbers that its leaves give."""
        return tuple(tuple(_sum(row[:-1], float(row[-1])) for row in vector) for vector in self.given)


def _sum(weights: Float32 | Float64, constant: float = 0.0) -> Sum:
    """The sum of those weights that float32 holds as normal numbers, with the constant where it is not 0 or alone."""
    held = np.asarray(weights, np.float32)
    terms = [(float(held[k]), k) for k in np.flatnonzero(np.abs(held) >= np.finfo(np.float32).tiny).tolist()]
    normal = abs(constant) >= np.finfo(np.float64).tiny
    return Sum((*terms, (constant if normal else 0.0, CONSTANT)) if normal or not terms else tuple(terms))


def deploy_tree(grown: GrownTree, numbers: str = FLOAT32) -> Tree:
    """The deployed form of a grown tree. `numbers`: what it compares."""
    if isinstance(grown, SummedTree):
        n_features = grown.tests.shape[1]
        return with_given(grown, Given(grown.sums, grown.vectors, DOUBLE_SUMS, FLOAT32), n_features, n_features)
    return _plain(grown, numbers)


def _plain(grown: GrownTree, numbers: str) -> Tree:
    order: list[int] = []
    stack = [ROOT]
    while stack:
        node = stack.pop()
        order.append(node)
        if grown.feature[node] != NO_FEATURE:
            stack += [int(grown.right[node]), int(grown.left[node])]
    new_id = {node: place for place, node in enumerate(order)} | {NO_CHILD: NO_CHILD}
    split = grown.feature != NO_FEATURE
    threshold = np.where(split, at_most(grown.threshold, numbers), np.zeros(1, numbers))
    return Tree(
        feature=grown.feature[order],
        # adding zero turns -0.0 into 0.0, which compares alike and has one spelling
        threshold=threshold[order] + threshold.dtype.type(0),
        left=np.array([new_id[int(node)] for node in grown.left[order]]),
        right=np.array([new_id[int(node)] for node in grown.right[order]]),
        action=grown.action[order],
        numbers=numbers,
    )


class Given(NamedTuple):
    """The sums that a tree may test, the vectors that its leaves may give, and how they are computed."""

    sums: Sequence[Sum]
    vectors: Sequence[tuple[Sum, ...]]  # (): leaves have actions
    arithmetic: str
    gives: str  # what outputs are rounded to


def with_given(grown: GrownTree, given: Given, n_features: int, first: int, numbers: str = FLOAT32) -> Tree:
    """The deployed form of a tree whose features from `first` on count in sums, and whose actions count in vectors,
    where there are any. Each that is named is kept once, in the order in which nodes first name it.
    """
    plain = _plain(grown, FLOAT64)  # in preorder, thresholds as they are
    leaf, summed = plain.feature == NO_FEATURE, plain.feature >= first
    own, of_sums = (at_most(plain.threshold, each) for each in (numbers, choose_numbers(given.arithmetic)))
    threshold = cast("Any", np.where(~leaf & ~summed, own, of_sums))
    sums, feature = _first_named(given.sums, (plain.feature[summed] - first).tolist())
    vectors, action = _first_named(given.vectors, plain.action[leaf].tolist() if given.vectors else [])
    chosen, tested = plain.action.copy(), plain.feature.copy()
    tested[summed] = np.array(feature, dtype=np.int32) + n_features
    if given.vectors:
        chosen[leaf] = action
    return Tree(
        tested,
        threshold,
        plain.left,
        plain.right,
        chosen,
        numbers=numbers,
        gives=given.gives if given.vectors else FLOAT32,
        sums=sums,
        vectors=vectors,
        arithmetic=given.arithmetic if sums or vectors else "",
    )


def _first_named(known: Sequence[Any], named: Sequence[int]) -> tuple[tuple[Any, ...], list[int]]:
    """Those that are named, equal ones once, in the order in which they are; and the place of each name among them."""
    places, distinct = dict[str, int](), list[Any]()
    for each in named:
        if places.setdefault(repr(known[each]), len(distinct)) == len(distinct):
            distinct.append(known[each])
    return tuple(distinct), [places[repr(known[each])] for each in named]
