"""Invariants as cells that all episodes stay in, and that meet a claim.

Does: adds the cells that the cells of the first step become until none is new, in wide cells first; says which cell
  leaves where that does not end.
Assumes: a checked system; a claim about all steps. The checker's arithmetic moves cells, and is asked again.
Does not: shrink a region until it is closed. What is left of a region whose cells are removed once they leave holds all
  cells that grow from the start, so with the same cells that shows nothing that growing does not.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import pairwise
from math import floor, log2
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from codegen.ir import Float64, Int64, PolicyProfile
from codegen.numbers import nearest_double
from verify.boxes.covering import set_anew
from verify.boxes.model import Model
from verify.boxes.sweep import Sweep
from verify.certificates.proofs import encode_numbers
from verify.checker.certificate import numbers
from verify.checker.covers.boxes import BoxList, together
from verify.checker.covers.invariants import FollowedMotion, InvariantSweep
from verify.checker.reading import RejectedError
from verify.checker.systems.proofs import WHOLE, InvariantPart
from verify.progress import tell
from verify.reach.forever.leaving import Bounds, LeftError
from verify.systems.claims import SystemClaim
from verify.systems.system import System

POWERS = (3, 4, 5, 6, 7, 8)  # of two: cells in the range of a variable
STEPS = (1, 4, 8)  # out of the list
MAX_CELLS, MAX_TRIED = 60_000, 400_000  # of one list; boxes that one list may take
POINTS, SEED = 128, 0  # of starts that show how far episodes range
SHARE = 16  # the part of the budget that these may take
ATTEMPT = 500  # boxes that take as long as all else of a list that is tried
TIMES, JOINED = (0, 6, 12), 6  # how often the start is cut on the way to a later step; the power of joined cells there
Cell = tuple[int, ...]


class Approach(NamedTuple):
    """A way to the first step of which a claim speaks: how the start is cut, and in which cells boxes are joined."""

    cuts: bytes = WHOLE
    joined: Mapping[str, Fraction] = MappingProxyType({})


def evenly(columns: Sequence[int], times: int) -> bytes:
    """Cuts of the start into 2^times parts, along some variables in turn."""
    if not times:
        return WHOLE

    def cut(level: int) -> list[int]:
        below = cut(level + 1) if level + 1 < times else [0]
        return [1 + columns[level % len(columns)], *below, *below]

    return encode_numbers(cut(0))


def collect_arriving(motion: FollowedMotion, approach: Approach, most: int) -> BoxList:
    """The boxes at the claim's first step. RejectedError for more than `most`."""
    widths = {name: float(width) for name, width in approach.joined.items()}
    arriving: list[BoxList] = []
    for boxes in motion.arriving(list(numbers(approach.cuts)), widths):
        arriving.append(boxes)
        if sum(each.size for each in arriving) > most:
            raise RejectedError("too many boxes at the first step")
    if not arriving:
        raise RejectedError("no start was seen")
    return together(arriving)


def bounds_of(motion: FollowedMotion, boxes: BoxList) -> Bounds:
    """Bounds of the first of some boxes."""
    names = list(motion.columns)
    return {names[at]: (float(boxes.low[0, at]), float(boxes.high[0, at])) for at in motion.followed}


class CellSearch:
    """The search for one claim, with at `most` so many boxes. `spent`: boxes so far; `left`: of the last list that was
    tried, a cell that leaves.
    """

    def __init__(self, profile: PolicyProfile, system: System, claim: SystemClaim, most: int) -> None:
        self._profile, self._system, self._claim, self.most = profile, system, claim, most
        self.spent, self._tried = 0, 0
        self._sweeps: dict[tuple[str, ...], InvariantSweep] = {}  # by variables: all widths move boxes alike
        self.left: LeftError | None = None
        self._scale = self._ranging()

    def part(self, names: Sequence[str]) -> InvariantPart | None:
        """An invariant of some variables, as cells; None where none was found."""
        for power in POWERS:
            for steps in STEPS:
                for approach in self.approaches(names) if self._claim.by else [Approach()]:
                    if self.spent + ATTEMPT * self._tried >= self.most:
                        return None
                    self._tried += 1
                    try:
                        return self._close_cells(self._widths(names, power), steps, approach)
                    except LeftError as left:
                        self.left = left
                    except RejectedError:  # not finite, too many, or nothing is stated
                        continue
        return None

    def approaches(self, names: Sequence[str]) -> list[Approach]:
        """Ways to the claim's first step: the start is cut more often; boxes are joined."""
        wide = [name for name in names if self._starting[name] > 0]
        whole = [
            Approach(evenly([self._columns[name] for name in wide], times)) for times in TIMES if wide or not times
        ]
        if not self._claim.by:
            return whole
        return [*whole, Approach(joined=self._widths(names, JOINED))]

    def _widths(self, names: Sequence[str], power: int) -> dict[str, Fraction]:
        modes = {one.name for one in self._system.variables if one.modes}
        scale = {name: float(self._scale[at]) for at, name in enumerate(one.name for one in self._system.variables)}
        widths = {name: Fraction(2) ** (floor(log2(scale[name])) - power) if scale[name] > 0 else 1 for name in names}
        ranges = {one.name: one.range for one in self._system.variables}
        for name in set_anew(self._system) & widths.keys():  # one cell from 0 on, if the range begins there
            widths[name] = Fraction(2) ** (2 + floor(log2(max(map(abs, ranges[name])) or 1)))
        return {name: Fraction(1 if name in modes else width) for name, width in widths.items()}

    def _close_cells(self, widths: Mapping[str, Fraction], steps: int, approach: Approach) -> InvariantPart:
        """Cells that nothing leaves for more than some steps. LeftError, RejectedError."""
        floats = {name: float(width) for name, width in widths.items()}
        with np.errstate(all="ignore"):
            sweep = self._sweep(floats)
            arriving = collect_arriving(sweep.motion, approach, self.most - self.spent)
            known = _cells(sweep.in_cells(self._meeting(sweep, arriving))[1])
            fresh = known
            before = self.spent
            if not known:  # the claim speaks of no episode for so long, so there is nothing to hold
                raise RejectedError("no state at the first step is spoken of")
            while fresh:
                cells = np.array(sorted(fresh), dtype=np.int64)
                if self.spent - before > MAX_TRIED or self.spent > self.most:
                    raise self._make_left_error(sweep, cells[:1], sweep.motion.move_boxes(sweep.boxes(cells[:1])))
                fresh = self._becoming(sweep, cells, known, steps)
                known |= fresh
        cells = encode_numbers(_numbers(np.array(sorted(known), dtype=np.int64)))
        return InvariantPart(dict(widths), steps, cells, (), approach.cuts, approach.joined)

    def _sweep(self, widths: Mapping[str, float]) -> InvariantSweep:
        """Cells of some widths, moved by what was read once."""
        names = tuple(widths)
        if names not in self._sweeps:
            self._sweeps[names] = InvariantSweep(self._profile, self._system, self._claim, widths)
        return self._sweeps[names].of_widths(widths)

    def _becoming(self, sweep: InvariantSweep, cells: Int64, known: set[Cell], steps: int) -> set[Cell]:
        """The new cells that cells become after some steps. LeftError where one leaves."""
        boxes = sweep.boxes(cells)
        for step in range(1, steps + 1):
            boxes = sweep.motion.move_boxes(boxes)
            broken = sweep.motion.find_breaking(boxes)
            if broken.size:
                raise self._make_left_error(sweep, cells, broken)
            boxes, of = sweep.in_cells(boxes)
            self.spent += boxes.size
            tell(min(self.spent, self.most), self.most, "boxes")
            new = np.array([tuple(each) not in known for each in of.tolist()], dtype=np.bool_)
            boxes, of = boxes.take(new), of[new]
            if boxes.size and (boxes.size > MAX_TRIED or len(known) > MAX_CELLS or self.spent > self.most):
                raise self._make_left_error(sweep, cells, boxes)
            if step == steps or not boxes.size:
                return _cells(of)
        return set()

    def _meeting(self, sweep: InvariantSweep, arriving: BoxList) -> BoxList:
        """The boxes at the claim's first step. LeftError where they do not meet the claim."""
        broken = sweep.motion.find_breaking(arriving)
        if broken.size:
            raise LeftError(self._bounds(sweep, arriving), self._bounds(sweep, broken), self._claim.by)
        return arriving

    def _make_left_error(self, sweep: InvariantSweep, cells: Int64, to: BoxList) -> LeftError:
        """That a state of a cell goes to where it may not, or goes on and on."""
        return LeftError(self._bounds(sweep, sweep.boxes(cells[to.part[:1]])), self._bounds(sweep, to))

    def _bounds(self, sweep: InvariantSweep, boxes: BoxList) -> Bounds:
        return bounds_of(sweep.motion, boxes)

    def _ranging(self) -> Float64:
        """Estimates how far each variable ranges in some episodes, at most as far as the claim's region reaches."""
        ends = np.array([[nearest_double(end) for end in one.range] for one in self._system.variables])
        self._columns = {one.name: at for at, one in enumerate(self._system.variables)}
        for half in self._system.start:
            if len(half.form.terms) == 1:
                ((name, factor),) = half.form.terms
                at = self._columns[name]
                end = nearest_double(-half.form.constant / factor)
                ends[at, int(factor > 0)] = (min if factor > 0 else max)(ends[at, int(factor > 0)], end)
        low, high = ends[:, 0], np.maximum(ends[:, 0], ends[:, 1])
        self._starting = {name: high[at] - low[at] for name, at in self._columns.items()}
        played = min(POINTS, max(self.most // (SHARE * (self._claim.steps + 1)), 1))
        points = low + np.random.default_rng(SEED).random((played, len(low))) * (high - low)
        with np.errstate(all="ignore"):
            sweep = Sweep(Model(self._profile, self._system), self._system, self._claim)
            ranges = sweep.estimate_ranges(points, points.copy())
        return np.where(np.isfinite(ranges), ranges, 0.0)


def _cells(cells: Int64) -> set[Cell]:
    return {tuple(map(int, each)) for each in cells}


def _numbers(cells: Int64) -> list[int]:
    """Cells as numbers, as checker/covers/forever.py reads them."""
    lows, spans = cells.min(axis=0).tolist(), (cells.max(axis=0) - cells.min(axis=0) + 1).tolist()
    keys = np.zeros(len(cells), dtype=np.int64)
    for place, (low, span) in enumerate(zip(lows, spans, strict=True)):
        keys = keys * span + (cells[:, place] - low)
    ordered = sorted(keys.tolist())
    zigzag = [2 * low if low >= 0 else -2 * low - 1 for low in lows]
    heads = [number for pair in zip(zigzag, spans, strict=True) for number in pair]
    return [*heads, ordered[0], *(after - before for before, after in pairwise(ordered))]
