"""The leaves that boxes meet below a node of a tree, looked up instead of walked to.

Does: for each way down by tests of single variables, how far a box must reach to meet its end, and what of the box is
  met there; for all boxes at once, which ends each meets.
Assumes: half lines as cuts.py has them.
Does not: know trees, or tests of several variables.

All bounds are bounds from below, of variables and of their negatives (`BoxList.bounds`). A way down asks that some are
at most `last`, the largest float of a half line; what is met is cut at `first`, a float beyond the end of the half line
that looks the other way. A box meets an end if none of its bounds exceeds `last`. So the ends that a single bound
leaves are a row of bits, found by its place among all `last`, and the ends that a box meets are what its rows share.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from math import inf
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from codegen.ir import Bool, Float64, Int64
from verify.checker.covers.boxes import FEW, BoxList, alike, bounded, rounded, unit_of
from verify.checker.covers.cuts import BoundLine
from verify.checker.reading import RejectedError

AT_ONCE = 1 << 24  # pairs of a box and an end
Bits = NDArray[np.uint64]


class WayDown(NamedTuple):
    """A way down: bounds that may not be exceeded and those at which is cut, by column; the node at its end."""

    last: list[float]
    first: list[float]
    node: int

    @classmethod
    def begun(cls, columns: int, node: int) -> WayDown:
        """The way to a node at which all begins."""
        return cls([inf] * columns, [-inf] * columns, node)

    def on(self, lines: Sequence[BoundLine], node: int) -> WayDown | None:
        """The way on to a node, where some half lines hold; None where no state meets all."""
        last, first = list(self.last), list(self.first)
        for near, far, end, _ in lines:
            last[near], first[far] = min(last[near], end.last), max(first[far], -end.up)
            if first[near] > last[near] or first[far] > last[far]:
                return None
        return WayDown(last, first, node)


class _Column(NamedTuple):
    """One column of bounds: all `last` of ways in it, in order; by how many of these a bound exceeds, the ways left."""

    column: int
    ends: Float64
    left: Bits  # [ends + 1, words]


class LeafWays:
    """Some ways down from one node."""

    def __init__(self, ways: Sequence[WayDown]) -> None:
        last = np.array([way.last for way in ways])
        self._first, self._node = np.array([way.first for way in ways]), np.array([way.node for way in ways])
        self._columns = [_column(at, last[:, at]) for at in np.flatnonzero((last < inf).any(axis=0)).tolist()]

    def met(self, boxes: BoxList) -> tuple[BoxList, Int64]:
        """The boxes cut at the ends of the ways that they meet, and the node at each end. RejectedError for a bound
        that is no number.
        """
        bounds = boxes.bounds
        if np.isnan(bounds).any():
            raise RejectedError("a box has bounds that are not finite")
        box, way = self._pairs(bounds)
        first = self._first.take(way, axis=0)
        bounds, part, joint = np.maximum(bounds.take(box, axis=0), first), boxes.part.take(box), boxes.joint.take(box)
        if len(box) >= FEW:
            kept, bounds = _nested_joined(bounds, bounds == first, [way, part, joint])
            way, part, joint = way.take(kept), part.take(kept), joint.take(kept)
        return bounded(bounds, part, joint), self._node.take(way)

    def _pairs(self, bounds: Float64) -> tuple[Int64, Int64]:
        """Which boxes meet which ways: numbers of both, pair by pair."""
        count, most = len(self._node), max(AT_ONCE // len(self._node), 1)
        parts = [self._flags(bounds[begin : begin + most]) for begin in range(0, max(len(bounds), 1), most)]
        pairs = [np.flatnonzero(flags) + at * most * count for at, flags in enumerate(parts)]
        return np.divmod(np.concatenate(pairs) if len(pairs) > 1 else pairs[0], count)

    def _flags(self, bounds: Float64) -> NDArray[np.uint8]:
        """For each box and way whether they meet, [n, ways]."""
        by_column: Float64 = np.ascontiguousarray(bounds.T)
        common: Bits = np.full((len(bounds), -(-len(self._node) // 64)), ~np.uint64(0))
        for column, ends, left in self._columns:
            own: Float64 = by_column[column]
            least, most = float(own.min(initial=inf)), float(own.max(initial=-inf))
            place = bisect_left(ends, least)
            if place < bisect_left(ends, most):
                common &= left.take(np.searchsorted(ends, own), axis=0)
            elif place:  # the same ways are left to all boxes
                common &= left[place]
        return np.unpackbits(common.view(np.uint8), axis=1, count=len(self._node), bitorder="little")


def _column(column: int, last: Float64) -> _Column:
    ends = np.unique(last)
    places = np.arange(len(ends) + 1)[:, None]
    flags = np.zeros((len(places), -(-len(last) // 64) * 64), dtype=np.bool_)
    flags[:, : len(last)] = np.searchsorted(ends, last) >= places
    return _Column(column, ends, np.packbits(flags, axis=1, bitorder="little").view(np.uint64))


def _nested_joined(bounds: Float64, at_end: Bool, kinds: Sequence[Int64]) -> tuple[Int64, Float64]:
    """The numbers of some boxes, and bounds in which these hold all states of a list of boxes in leaves, where those of
    one kind became one of which one all but holds the others. `at_end`: which bounds are those of the leaf.

    Rounding outward makes slivers at the ends of leaves. Two boxes that reach the end of their leaf, and are alike but
    for the bound on the other side, lie in each other. So that bound is left out of the hash by which they are found.
    Whatever is joined, what is around it holds its states; that one box all but does is asked to lose nothing else.
    """
    size, unit = bounds.shape[1] // 2, unit_of(bounds)
    rows = rounded(bounds, unit) * ~np.concatenate([at_end[:, size:], at_end[:, :size]], axis=1)
    order, begins = alike(rows, kinds)
    if len(begins) == len(order):
        return np.arange(len(order)), bounds
    bounds, counts = bounds.take(order, axis=0), np.diff(begins, append=len(order))
    around = np.repeat(np.minimum.reduceat(bounds, begins, axis=0), counts, axis=0)
    holds = np.logical_or.reduceat((bounds - around <= unit).all(axis=1), begins)
    alone = np.repeat(~holds, counts)
    kept = alone.copy()
    kept[begins] = True
    return order[kept], np.where(alone[:, None], bounds, around)[kept]
