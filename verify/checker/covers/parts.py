"""The start as boxes: cut into the parts that a proof names.

Does: reads cuts, and gives the boxes of starts that they leave.
Assumes: a system that is well formed; cuts that anyone made.
Does not: move boxes.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from codegen.ir import Float64
from verify.checker.covers.boxes import BoxList
from verify.checker.covers.cuts import RegionCut, linear
from verify.checker.covers.rounding import ceiling, floor
from verify.checker.reading import RejectedError
from verify.systems.system import System

MAX_PARTS = 1 << 20  # of the start
AT_ONCE = 1 << 12  # parts that are swept together


class StartBox(NamedTuple):
    """A part of the start as a box, [n_variables] each."""

    low: Float64
    high: Float64


def halves(one: StartBox, column: int) -> list[StartBox]:
    """A part cut at the middle of a variable, the lower half first."""
    middle, lower, upper = 0.5 * one.low[column] + 0.5 * one.high[column], one.high.copy(), one.low.copy()
    lower[column] = upper[column] = middle
    return [StartBox(one.low, lower), StartBox(upper, one.high)]


class Parts:
    """The start of a system, to be cut into at most so many parts, of which so many are swept together."""

    def __init__(self, system: System, most: int = MAX_PARTS, at_once: int = AT_ONCE) -> None:
        self._system, self._most, self._at_once = system, most, at_once
        self._columns = {one.name: column for column, one in enumerate(system.variables)}
        self._start = RegionCut(list(map(linear, system.start)), self._columns)

    def parts(self, cuts: Sequence[int]) -> Iterator[BoxList]:
        """The start as boxes, some parts at a time."""
        return map(self.box_starts, self.cut(cuts))

    def cut(self, cuts: Sequence[int]) -> Iterator[list[StartBox]]:
        """The parts that cuts make of a box around all starts, some at a time."""
        batch: list[StartBox] = []
        count, numbers = 0, iter(cuts)
        pending = [] if (whole := self.whole) is None else [whole]
        while pending:
            one = pending.pop()
            number = next(numbers, None)
            if number is None or number > len(self._columns):
                raise RejectedError("the cuts of the start end too early, or name a variable that there is not")
            if number:
                pending += reversed(halves(one, number - 1))
                continue
            batch.append(one)
            count += 1
            if count > self._most:
                raise RejectedError(f"the start is cut into more than {self._most:,} parts")
            if len(batch) == self._at_once:
                yield batch
                batch = []
        if next(numbers, None) is not None:
            raise RejectedError("the cuts of the start go on after their end")
        if batch:
            yield batch

    @property
    def whole(self) -> StartBox | None:
        """A box around all starts; None where bounds show that there are none."""
        ends = [one.range for one in self._system.variables]
        low, high = np.array([floor(low) for low, _ in ends]), np.array([ceiling(high) for _, high in ends])
        boxes = self.box_starts([StartBox(low, high)])
        return StartBox(boxes.low[0], boxes.high[0]) if boxes.size else None

    def box_starts(self, parts: Sequence[StartBox]) -> BoxList:
        """Boxes around the starts in some parts."""
        none = np.zeros(len(parts), dtype=np.int64)
        lows, highs = np.array([one.low for one in parts]), np.array([one.high for one in parts])
        boxes = BoxList.of(lows, highs, np.arange(len(parts)), none)
        return self._start.within(boxes)
