"""The sweep of a cover: step by step, boxes that hold every state, each of which has to meet the claim.

Does: cuts the start into the parts that a proof names, cuts and moves their boxes, joins them in the cells of the
  proof, and asks the claim of every list.
Assumes: images.py, trees.py and cuts.py bound what they are asked.
Does not: read documents. A list is computed anew from the one before, so a proof holds no boxes.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from codegen.ir import Float64, PolicyProfile
from verify.checker.covers.boxes import BoxList, in_cells, together
from verify.checker.covers.cuts import Cut, RegionCut, linear
from verify.checker.covers.images import PieceImage
from verify.checker.covers.rounding import ceiling, ensure_arithmetic, floor
from verify.checker.covers.trees import TreeCuts, decided
from verify.checker.reading import RejectedError
from verify.checker.systems.cases import has_cases, hull_of
from verify.systems.claims import SystemClaim
from verify.systems.regions import left_out
from verify.systems.system import Box, System

MAX_PARTS = 1 << 20  # of the start
AT_ONCE = 1 << 12  # parts that are swept together
MAX_SWEPT = 200_000_000  # boxes over all steps


@dataclass(frozen=True)
class Cells:
    """How the start is cut, and in which cells boxes are joined. `cuts`: for each box in turn, 0 where it is swept as
    it is, else 1 more than the column of the variable at whose middle it is cut, the lower half first. `widths`: of
    cells, by column; none: boxes are not joined.
    """

    cuts: Sequence[int]
    widths: Mapping[int, float]


class CoverSweep:
    """The sweep for one claim."""

    def __init__(self, profile: PolicyProfile, system: System, claim: SystemClaim) -> None:
        self._system, self._claim = system, claim
        self._columns = {one.name: column for column, one in enumerate(system.variables)}
        self._trees = [TreeCuts(system, policy, self._columns) for policy in profile.agents]
        self._pieces = [PieceImage(system, piece, profile.agents, self._trees) for piece in system.pieces]
        self._regions = [RegionCut(list(map(linear, region)), self._columns) for region in claim.regions]
        self._starts = [Cut(linear(half), self._columns) for half in system.start]
        self._stated = self._bounds_of_stated() if claim.steps else None
        self.swept = 0

    def run(self, cells: Cells) -> int:
        """How many boxes were asked about. RejectedError where one may break the claim, or leave what is stated."""
        ensure_arithmetic()
        with np.errstate(all="ignore"):  # what overflows is not finite, and is refused
            for boxes in self._parts(cells.cuts):
                self._follow(boxes, cells.widths)
        return self.swept

    def _follow(self, boxes: BoxList, widths: Mapping[int, float]) -> None:
        for step in range(self._claim.steps + 1):
            if widths:
                boxes = in_cells(boxes, widths)
            self.swept += boxes.size
            if self.swept > MAX_SWEPT:
                raise RejectedError(f"the cover has more than {MAX_SWEPT:,} boxes")
            boxes.ensure_finite()
            boxes = self._asked(boxes, step)
            if step == self._claim.steps or not boxes.size:
                return
            self._ensure_stated(boxes, step)
            boxes = decided(self._trees, boxes)
            boxes = together([piece.moved(piece.within(boxes)) for piece in self._pieces])

    def _asked(self, boxes: BoxList, step: int) -> BoxList:
        """The boxes that are followed further. RejectedError where one may hold a state that breaks the claim."""
        says, claim = self._claim.says, self._claim
        if says.avoided:
            self._ensure_none([region.within(boxes) for region in self._regions], step)
            return boxes
        outside = boxes
        if says.once or not says.first or step >= claim.by:
            for region in self._regions:
                outside = region.outside(outside)
        if says.once:
            self._ensure_none([outside] if step == claim.steps else [], step)
            return outside
        self._ensure_none([outside] if not says.first or step >= claim.by else [], step)
        return boxes

    def _ensure_none(self, lists: Sequence[BoxList], step: int) -> None:
        found = sum(each.size for each in lists)
        if found:
            raise RejectedError(f"at step {step} {found:,} boxes may hold states that break the claim")

    # --- what is stated

    def _bounds_of_stated(self) -> tuple[Float64, Float64] | None:
        """Bounds of a box all of whose states lie in a piece; None where some piece holds all states."""
        wheres = [piece.where for piece in self._system.pieces]
        if not all(wheres):
            return None
        bounds: dict[str, tuple[Fraction, Fraction]] = {}
        for where in wheres:
            for name, (low, high) in where.items():
                least, most = bounds.get(name, (low, high))
                bounds[name] = min(least, low), max(most, high)
        bounds = dict(hull_of(self._system)) if has_cases(self._system) else bounds
        whole: Box = bounds
        gap = not has_cases(self._system) and (
            any(low >= high for low, high in bounds.values()) or left_out(whole, wheres) is not None
        )
        if gap:
            raise RejectedError("the pieces leave gaps between them")
        low = np.full(len(self._columns), -np.inf)
        high = np.full(len(self._columns), np.inf)
        for name, (least, most) in bounds.items():
            low[self._columns[name]], high[self._columns[name]] = ceiling(least), floor(most)
        return low, high

    def _ensure_stated(self, boxes: BoxList, step: int) -> None:
        if self._stated is not None:
            low, high = self._stated
            if not ((boxes.low >= low) & (boxes.high <= high)).all():
                raise RejectedError(f"at step {step} a box may hold states of which nothing is stated")

    # --- the start

    def _parts(self, cuts: Sequence[int]) -> Iterator[BoxList]:
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
