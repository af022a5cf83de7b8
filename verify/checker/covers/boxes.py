"""Lists of boxes as arrays: taken, put together, cut into cells and joined cell by cell.

Does: the data of a list of boxes, and what neither tests nor moves do with it.
Assumes: closed boxes with finite float64 bounds; `ensure_finite` is asked of every list that was moved.
Does not: know systems, trees or claims.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from codegen.ir import Bool, Float64, Int64
from verify.checker.reading import RejectedError

MAX_CELL = 2.0**40  # of a cell's number along a variable
MAX_BOXES = 4_000_000  # of one list
FEW, ALIKE = 64, 2.0**-36  # boxes that are not joined; how close bounds are, beside the largest, that are alike


class BoxList(NamedTuple):
    """Closed boxes: `low`, `high` [n, variables]; `part` [n], the part of the start that each comes from; `joint` [n],
    the number of the joint action that is chosen in it.
    """

    low: Float64
    high: Float64
    part: Int64
    joint: Int64

    @property
    def size(self) -> int:
        """How many there are."""
        return len(self.part)

    @property
    def bounds(self) -> Float64:
        """Bounds from below of the variables, then of their negatives, [n, 2 variables]: with all bounds on one side,
        what is true of one is true of each.
        """
        return np.concatenate([self.low, -self.high], axis=1)

    def taken(self, which: Bool | Int64 | slice) -> BoxList:
        """Some of the boxes, by a mask or by their numbers."""
        low, high, part, joint = self
        if isinstance(which, slice):
            return BoxList(low[which], high[which], part[which], joint[which])
        at = np.flatnonzero(which) if which.dtype == np.bool_ else np.asarray(which, dtype=np.int64)
        return BoxList(low.take(at, axis=0), high.take(at, axis=0), part.take(at), joint.take(at))  # faster than a mask

    def ensure_finite(self) -> None:
        """RejectedError for a bound that is infinite or NaN."""
        if not (np.isfinite(self.low).all() and np.isfinite(self.high).all()):
            raise RejectedError("a box has bounds that are not finite")


def bounded(bounds: Float64, part: Int64, joint: Int64) -> BoxList:
    """Boxes by their bounds, as `BoxList.bounds` has them."""
    size = bounds.shape[1] // 2
    return BoxList(bounds[:, :size], -bounds[:, size:], part, joint)


Watch = Callable[[int, BoxList], None]  # told of every list that a proof rests on: its step, or its part


def together(lists: Sequence[BoxList]) -> BoxList:
    """The boxes of some lists in one. RejectedError for too many."""
    if sum(each.size for each in lists) > MAX_BOXES:
        raise RejectedError(f"a list has more than {MAX_BOXES:,} boxes")
    if len(lists) == 1:
        return lists[0]
    return BoxList(*(np.concatenate(column) for column in zip(*lists, strict=True)))


def in_cells(boxes: BoxList, widths: Mapping[int, float]) -> BoxList:
    """Boxes that hold all states of a list, one for each cell and part of the start that has some. `widths`: of cells,
    by column; whole multiples of them are the middles of cells.
    """
    cells = np.zeros((boxes.size, 0), dtype=np.int64)
    for column, width in widths.items():
        boxes, cells = cut(boxes, cells, column, width)
    return _joined(boxes, cells)


def cut(boxes: BoxList, cells: Int64, column: int, width: float) -> tuple[BoxList, Int64]:
    """The boxes cut at the bounds of cells along one variable, with one more column of cells' numbers.

    Two neighbours share the float at which they are cut, so nothing lies between them.
    """
    low, high = boxes.low[:, column], boxes.high[:, column]
    first, last = np.floor(low / width + 0.5), np.floor(high / width + 0.5)
    if not ((np.abs(first) <= MAX_CELL) & (np.abs(last) <= MAX_CELL)).all():
        raise RejectedError("cells are too narrow for a box")
    last = np.maximum(np.where((last > first) & ((last - 0.5) * width >= high), last - 1, last), first)
    count = (last - first).astype(np.int64) + 1
    if int(count.sum()) > MAX_BOXES:
        raise RejectedError(f"a list has more than {MAX_BOXES:,} boxes")
    rows = np.repeat(np.arange(boxes.size), count)
    place = np.arange(len(rows)) - np.repeat(np.cumsum(count) - count, count)
    number = first[rows] + place
    parts = boxes.taken(rows)
    at_low, at_high = parts.low[:, column], parts.high[:, column]
    parts.low[:, column] = np.where(place == 0, at_low, np.maximum(at_low, (number - 0.5) * width))
    parts.high[:, column] = np.where(number == last[rows], at_high, np.minimum(at_high, (number + 0.5) * width))
    kept = ~(parts.low[:, column] > parts.high[:, column])
    cells = np.column_stack([cells[rows], number.astype(np.int64)])
    return parts.taken(kept), cells[kept]


def _joined(boxes: BoxList, cells: Int64) -> BoxList:
    """For each cell and part of the start, the box around its boxes."""
    if not boxes.size:
        return boxes
    keys = np.column_stack([boxes.part, cells])
    order = np.lexsort(keys.T)
    sorted_keys = keys[order]
    begins = np.flatnonzero(np.concatenate([[True], (sorted_keys[1:] != sorted_keys[:-1]).any(axis=1)]))
    return _around(boxes.taken(order), begins)


def alike_joined(boxes: BoxList) -> BoxList:
    """Boxes that hold all states of a list, where those that are all but equal became one.

    Rounding outward makes slivers at borders of tests, and these make almost the same boxes again and again. What is
    joined is found by a hash of rounded bounds: boxes that share one by chance are joined too, which loses no state.
    """
    if boxes.size < FEW:
        return boxes
    bounds = boxes.bounds
    order, begins = alike(rounded(bounds, unit_of(bounds)), [boxes.part])
    return boxes if len(begins) == boxes.size else _around(boxes.taken(order), begins)


def unit_of(bounds: Float64) -> Float64:
    """How close bounds are that are alike, [columns]."""
    return np.abs(bounds).max(axis=0) * ALIKE + 2.0**-1000


def rounded(bounds: Float64, unit: Float64) -> Int64:
    """Bounds as whole numbers."""
    return np.floor(bounds * (1.0 / unit) + 0.3).astype(np.int64)


def alike(rows: Int64, kinds: Sequence[Int64]) -> tuple[Int64, Int64]:
    """An order in which rows are neighbours that share a hash of their numbers and kinds, and where each run of such
    rows begins.
    """
    factors = _multipliers(rows.shape[1] + len(kinds))
    hashed = rows @ factors[len(kinds) :]
    for kind, factor in zip(kinds, factors.tolist(), strict=False):
        hashed += kind * factor
    order = np.argsort(hashed, kind="stable")
    hashed = hashed.take(order)
    return order, np.flatnonzero(np.concatenate([[True], hashed[1:] != hashed[:-1]]))


@lru_cache(maxsize=16)
def _multipliers(count: int) -> Int64:
    """Some large odd numbers."""
    return np.random.default_rng(0).integers(1, 2**62, size=count) | 1


def _around(boxes: BoxList, begins: Int64) -> BoxList:
    """The box around the boxes of each run."""
    low, high = np.minimum.reduceat(boxes.low, begins, axis=0), np.maximum.reduceat(boxes.high, begins, axis=0)
    return BoxList(low, high, boxes.part[begins], boxes.joint[begins])
