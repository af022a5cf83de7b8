"""Lists of boxes as arrays: taken, put together, cut into cells and joined cell by cell.

Does: the data of a list of boxes, and what neither tests nor moves do with it.
Assumes: closed boxes with finite float64 bounds; `finite` is asked of every list that was moved.
Does not: know systems, trees or claims.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from math import isfinite
from typing import NamedTuple

import numpy as np

from codegen.ir import Bool, Float64, Int64
from verify.checker.reading import RejectedError

MAX_CELL = 2.0**40  # of a cell's number along a variable
MAX_BOXES = 4_000_000  # of one list
FEW, ALIKE = 64, 2.0**-36  # boxes that are not joined; how close bounds are, beside the largest, that are alike


class BoxList(NamedTuple):
    """Closed boxes: `bounds` [n, 2 variables], from below, of the variables and then of their negatives: what is true
    of one is true of each; `part` [n], the part of the start that each comes from; `joint` [n], the number of the joint
    action that is chosen in it.
    """

    bounds: Float64
    part: Int64
    joint: Int64

    @classmethod
    def of(cls, low: Float64, high: Float64, part: Int64, joint: Int64) -> BoxList:
        """Boxes by their ends, [n, variables] each, which are copied."""
        return cls(np.concatenate([low, -high], axis=1), part, joint)

    @property
    def size(self) -> int:
        """The number of boxes."""
        return len(self.part)

    @property
    def variables(self) -> int:
        """The number of variables that the boxes bound."""
        return self.bounds.shape[1] // 2

    @property
    def low(self) -> Float64:
        """The lower ends, [n, variables]."""
        return self.bounds[:, : self.variables]

    @property
    def high(self) -> Float64:
        """The upper ends, [n, variables], copied."""
        return np.asarray(-self.bounds[:, self.variables :], dtype=np.float64)

    def take(self, which: Bool | Int64 | slice) -> BoxList:
        """Some of the boxes, by a mask or by their numbers, copied; by a slice as a view."""
        bounds, part, joint = self
        if isinstance(which, slice):
            return BoxList(bounds[which], part[which], joint[which])
        at = np.flatnonzero(which) if which.dtype == np.bool_ else np.asarray(which, dtype=np.int64)
        return BoxList(bounds.take(at, axis=0), part.take(at), joint.take(at))  # faster than a mask

    @property
    def finite(self) -> Bool:
        """True for each box that has finite bounds only, [n]."""
        if isfinite(self.bounds.sum()):
            return np.ones(self.size, dtype=np.bool_)
        return np.asarray(np.isfinite(self.bounds).all(axis=1), dtype=np.bool_)  # a sum may overflow


Watch = Callable[[int, BoxList], None]  # told of every list that a proof rests on: its step, or its part


def together(lists: Sequence[BoxList]) -> BoxList:
    """The boxes of some lists in one. RejectedError for too many."""
    if sum(each.size for each in lists) > MAX_BOXES:
        raise RejectedError(f"a list has more than {MAX_BOXES:,} boxes")
    if len(lists) == 1:
        return lists[0]
    return BoxList(*(np.concatenate(column) for column in zip(*lists, strict=True)))


def in_cells(boxes: BoxList, widths: Mapping[int, float], most: int = MAX_BOXES) -> BoxList:
    """Boxes that hold all states of a list, one for each cell and part of the start that has some."""
    return join_by_cell(*cut(boxes, widths, most))


def cut(boxes: BoxList, widths: Mapping[int, float], most: int = MAX_BOXES) -> tuple[BoxList, Int64]:
    """The boxes cut at the bounds of cells, and the cell of each, [n, widths]. `widths`: of cells, by column; whole
    multiples of them are the middles of cells. RejectedError for more than `most` boxes.
    """
    cells = np.zeros((boxes.size, 0), dtype=np.int64)
    for column, width in widths.items():
        boxes, cells = _cut_along(boxes, cells, column, width, most)
    return boxes, cells


def _cut_along(boxes: BoxList, cells: Int64, column: int, width: float, most: int) -> tuple[BoxList, Int64]:
    """The boxes cut at the bounds of cells along one variable, with one more column of cells' numbers.

    Two neighbours share the float at which they are cut, so nothing lies between them.
    """
    above = boxes.variables + column
    low, high = boxes.bounds[:, column], -boxes.bounds[:, above]
    first, last = np.floor(low / width + 0.5), np.floor(high / width + 0.5)
    if not ((np.abs(first) <= MAX_CELL) & (np.abs(last) <= MAX_CELL)).all():
        raise RejectedError("cells are too narrow for a box")
    last = np.maximum(np.where((last > first) & ((last - 0.5) * width >= high), last - 1, last), first)
    count = (last - first).astype(np.int64) + 1
    if int(count.sum()) > most:
        raise RejectedError(f"a list has more than {most:,} boxes")
    rows = np.repeat(np.arange(boxes.size), count)
    place = np.arange(len(rows)) - np.repeat(np.cumsum(count) - count, count)
    number = first[rows] + place
    parts = boxes.take(rows)
    low, high = low.take(rows), high.take(rows)
    low = np.where(place == 0, low, np.maximum(low, (number - 0.5) * width))
    high = np.where(number == last[rows], high, np.minimum(high, (number + 0.5) * width))
    parts.bounds[:, column], parts.bounds[:, above] = low, -high
    kept = ~(low > high)
    cells = np.column_stack([cells[rows], number.astype(np.int64)])
    return parts.take(kept), cells[kept]


def join_by_cell(boxes: BoxList, cells: Int64) -> BoxList:
    """For each cell and part of the start, the box around its boxes."""
    if not boxes.size:
        return boxes
    keys = np.column_stack([boxes.part, cells])
    order = np.lexsort(keys.T)
    sorted_keys = keys[order]
    begins = np.flatnonzero(np.concatenate([[True], (sorted_keys[1:] != sorted_keys[:-1]).any(axis=1)]))
    return _around(boxes.take(order), begins)


def alike_joined(boxes: BoxList) -> BoxList:
    """Boxes that hold all states of a list, where those that are all but equal became one.

    Rounding outward makes slivers at borders of tests, and these make almost the same boxes again and again. What is
    joined is found by a hash of rounded bounds: boxes that share one by chance are joined too, which loses no state.
    """
    if boxes.size < FEW:
        return boxes
    bounds = boxes.bounds
    order, begins = alike(round_bounds(bounds, unit_of(bounds.min(axis=0), bounds.max(axis=0))), [boxes.part])
    return boxes if len(begins) == boxes.size else _around(boxes.take(order), begins)


def unit_of(least: Float64, most: Float64) -> Float64:
    """Returns the distance within which bounds count as alike, for each column, from its least and its most."""
    return np.maximum(np.abs(least), np.abs(most)) * ALIKE + 2.0**-1000


def round_bounds(bounds: Float64, unit: Float64) -> Int64:
    """Bounds as whole numbers."""
    return (bounds * (1.0 / unit) + 0.3).astype(np.int64)


def alike(rows: Int64, kinds: Sequence[Int64]) -> tuple[Int64, Int64]:
    """An order in which rows are neighbours that share a hash of their numbers and kinds, and where each run of such
    rows begins. Those of a run are of one kind, whatever the hash says.
    """
    factors = _multipliers(rows.shape[1] + len(kinds))
    hashed = rows @ factors[len(kinds) :]
    for kind, factor in zip(kinds, factors.tolist(), strict=False):
        hashed += kind * factor
    order = np.argsort(hashed, kind="stable")
    new = np.ones(len(order), dtype=np.bool_)
    new[1:] = False
    for each in (hashed, *kinds):
        sorted_ = each.take(order)
        new[1:] |= sorted_[1:] != sorted_[:-1]
    return order, np.flatnonzero(new)


@lru_cache(maxsize=16)
def _multipliers(count: int) -> Int64:
    """Some large odd numbers."""
    return np.random.default_rng(0).integers(1, 2**62, size=count) | 1


def _around(boxes: BoxList, begins: Int64) -> BoxList:
    """The box around the boxes of each run."""
    return BoxList(least_of_runs(boxes.bounds, begins), boxes.part.take(begins), boxes.joint.take(begins))


def least_of_runs(bounds: Float64, begins: Int64) -> Float64:
    """The least of each column over each run of rows, by halves of runs: runs are short, and `reduceat` is slow for
    these.
    """
    counts = np.diff(begins, append=len(bounds))
    after, least, apart = np.repeat(begins + counts, counts), bounds.copy(), 1  # least of `apart` rows, from each on
    while apart < counts.max():
        at = np.flatnonzero(np.arange(apart, len(bounds)) < after[:-apart])
        least[at] = np.minimum(least.take(at, axis=0), least.take(at + apart, axis=0))
        apart *= 2
    return least.take(begins, axis=0)
