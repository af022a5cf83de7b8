"""The start as boxes: cut into the parts that a proof names.

Does: reads cuts, and gives the boxes of starts that they leave.
Assumes: a system that is well formed; cuts that anyone made.
Does not: move boxes.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from codegen.ir import Float64
from verify.checker.covers.boxes import BoxList
from verify.checker.covers.cuts import Cut, linear
from verify.checker.covers.rounding import ceiling, floor
from verify.checker.reading import RejectedError
from verify.systems.system import System

MAX_PARTS = 1 << 20  # of the start
AT_ONCE = 1 << 12  # parts that are swept together


class Parts:
    """The start of a system, to be cut."""

    def __init__(self, system: System) -> None:
        self._system = system
        self._columns = {one.name: column for column, one in enumerate(system.variables)}
        self._starts = [Cut(linear(half), self._columns) for half in system.start]

    def parts(self, cuts: Sequence[int]) -> Iterator[BoxList]:
        """The start as boxes, some parts at a time."""
        lows: list[Float64] = []
        highs: list[Float64] = []
        count, numbers = 0, iter(cuts)
        start = self._start()
        pending = [(start.low[0], start.high[0])] if start.size else []
        while pending:
            low, high = pending.pop()
            number = next(numbers, None)
            if number is None or number > len(self._columns):
                raise RejectedError("the cuts of the start end too early, or name a variable that there is not")
            if number:
                middle = 0.5 * low[number - 1] + 0.5 * high[number - 1]
                lower, upper = high.copy(), low.copy()
                lower[number - 1] = upper[number - 1] = middle
                pending += [(upper, high), (low, lower)]
                continue
            lows.append(low)
            highs.append(high)
            count += 1
            if count > MAX_PARTS:
                raise RejectedError(f"the start is cut into more than {MAX_PARTS:,} parts")
            if len(lows) == AT_ONCE:
                yield self._started(lows, highs)
                lows, highs = [], []
        if next(numbers, None) is not None:
            raise RejectedError("the cuts of the start go on after their end")
        if lows:
            yield self._started(lows, highs)

    def _start(self) -> BoxList:
        """A box around all starts; none where bounds show that there are none."""
        ends = [one.range for one in self._system.variables]
        low, high = np.array([floor(low) for low, _ in ends]), np.array([ceiling(high) for _, high in ends])
        return self._started([low], [high])

    def _started(self, lows: Sequence[Float64], highs: Sequence[Float64]) -> BoxList:
        """Boxes around the starts in some boxes."""
        none = np.zeros(len(lows), dtype=np.int64)
        boxes = BoxList(np.array(lows), np.array(highs), np.arange(len(lows)), none)
        for cut in self._starts:
            boxes = cut.within(boxes)
        return boxes
