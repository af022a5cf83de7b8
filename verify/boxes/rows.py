"""Boxes as arrays of float64, and what is done with many of them at once.

Does: the data of a list of boxes; cuts by inequalities; joins in cells.
Assumes: nothing is rounded outward, since what is found is computed again by the checker.
Does not: know systems or claims.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from codegen.ir import Bool, Float64, Int64


class Rows(NamedTuple):
    """Boxes `low`, `high` [n, variables]; the `part` of the start and the `joint` action of each, [n]."""

    low: Float64
    high: Float64
    part: Int64
    joint: Int64

    @staticmethod
    def of(low: Float64, high: Float64) -> Rows:
        """Boxes as parts of the start, each its own."""
        count = len(low)
        return Rows(low.copy(), high.copy(), np.arange(count), np.zeros(count, dtype=np.int64))

    @property
    def size(self) -> int:
        """The number of boxes."""
        return len(self.part)

    def at(self, which: Bool | Int64 | slice) -> Rows:
        """Some of them, copied."""
        at = np.arange(self.size)[which] if isinstance(which, slice) else which
        at = np.flatnonzero(at) if at.dtype == np.bool_ else np.asarray(at, dtype=np.int64)  # `take` beats a mask
        low, high, part, joint = self
        return Rows(low.take(at, axis=0), high.take(at, axis=0), part.take(at), joint.take(at))


def join_rows(lists: Sequence[Rows]) -> Rows:
    """Several lists as one."""
    lists = [each for each in lists if each.size] or lists[:1]
    return lists[0] if len(lists) == 1 else Rows(*map(np.concatenate, zip(*lists, strict=True)))


class Half:
    """The states whose sum of `weights`, by column, is at most `end`."""

    def __init__(self, weights: Mapping[int, float], end: float) -> None:
        self._weights = {
            column: weight for column, weight in weights.items() if weight
        }  # some are too small for a float
        self._end = end

    def holds_all(self, low: Sequence[float], high: Sequence[float]) -> bool:
        """Returns True if a box lies in it wholly, bounds by column."""
        return sum(weight * (high if weight > 0 else low)[at] for at, weight in self._weights.items()) <= self._end

    def opposite(self) -> Half:
        """All other states, and the border."""
        return Half({column: -weight for column, weight in self._weights.items()}, -self._end)

    def holds(self, rows: Rows) -> Bool:
        """Returns which boxes lie in it wholly, [n]."""
        most = np.zeros(rows.size)
        for column, weight in self._weights.items():
            most += weight * (rows.high if weight > 0 else rows.low)[:, column]
        return most <= self._end

    def of(self, rows: Rows) -> Rows:
        """The boxes that meet it, narrowed to what may lie in it."""
        if not self._weights:
            return rows if self._end >= 0 else rows.at(np.zeros(rows.size, dtype=np.bool_))
        least = {
            column: weight * (rows.low if weight > 0 else rows.high)[:, column]
            for column, weight in self._weights.items()
        }
        total = np.sum(list(least.values()), axis=0)
        met = total <= self._end
        overlap = rows.at(met)
        for column, weight in self._weights.items():
            most = (self._end - (total - least[column])[met]) / weight
            if weight > 0:
                overlap.high[:, column] = np.minimum(overlap.high[:, column], np.maximum(most, overlap.low[:, column]))
            else:
                overlap.low[:, column] = np.maximum(overlap.low[:, column], np.minimum(most, overlap.high[:, column]))
        return overlap


def in_cells(rows: Rows, widths: Mapping[int, float]) -> Rows:
    """The boxes cut at the bounds of cells, whose middles are whole multiples of `widths`, and joined where they share
    a cell and a part of the start.
    """
    keys = [rows.part]
    for column, width in widths.items():
        first = np.floor(rows.low[:, column] / width + 0.5).astype(np.int64)
        last = np.maximum(np.ceil(rows.high[:, column] / width + 0.5).astype(np.int64) - 1, first)
        count = last - first + 1
        from_ = np.repeat(np.arange(rows.size), count)
        cell = np.arange(len(from_)) - np.repeat(np.cumsum(count) - count, count) + first[from_]
        rows, keys = rows.at(from_), [key[from_] for key in keys]
        rows.low[:, column] = np.maximum(rows.low[:, column], (cell - 0.5) * width)
        rows.high[:, column] = np.minimum(rows.high[:, column], (cell + 0.5) * width)
        keys.append(cell)
    if not rows.size:
        return rows
    order = np.lexsort(keys)
    new = np.zeros(rows.size, dtype=np.bool_)
    new[0] = True
    for key in keys:
        new[1:] |= key[order][1:] != key[order][:-1]
    begins, rows = np.flatnonzero(new), rows.at(order)
    low, high = np.minimum.reduceat(rows.low, begins), np.maximum.reduceat(rows.high, begins)
    return Rows(low, high, rows.part[begins], rows.joint[begins])


def cells_of(rows: Rows, widths: Mapping[int, float]) -> float:
    """Counts the boxes that a cut at the bounds of cells makes, at most."""
    count = np.ones(rows.size)
    for column, width in widths.items():
        count *= (rows.high[:, column] - rows.low[:, column]) / width + 2.0
    return float(count.sum())
