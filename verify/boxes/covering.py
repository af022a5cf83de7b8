"""How to cut the start and in which cells to join boxes, so that a claim about episodes is shown.

Does: tries whole boxes, cuts the start where the claim stays open, tries affine forms, which do not widen where boxes
  do, then joins boxes in ever smaller cells.
Assumes: a checked profile, system and claim.
Does not: prove: the checker makes the boxes again and says whether they do.

What is tried, in which order, and how much each attempt may take depends on no budget. A budget only ends the search.

Most boxes of a long list lie in another one of it. They are not dropped: in the six worlds in which that was tried the
claims were decided after the same boxes, since cells join them anyway, and to look for them took as long as it saved.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from math import floor, log2
from typing import NamedTuple

import numpy as np

from codegen.ir import Bool, Float64, PolicyProfile
from codegen.numbers import nearest_double
from verify.boxes.model import Model
from verify.boxes.rows import Rows
from verify.boxes.sweep import Sweep, Swept
from verify.spending import FORM, OPTION, BudgetSpentError, Spending
from verify.systems.claims import SystemClaim
from verify.systems.system import System

SEED, POINTS = 0, 128  # of starts that show how far episodes range
FIRST, FORMS, SECOND = 20_000, 60_000, 400_000  # boxes for cuts of the start alone; the last after cells
CELLS = tuple(range(2, 10))  # into how many parts, as powers of two, what episodes range over is cut
QUICK, IN_CELLS = 5_000, 250_000  # boxes for cells of one width, before and after forms
MOST = 2_000_000  # boxes for all; what they leave open goes on to linear programs
NARROW = 1e-200  # what a variable has to range over
MAX_DEPTH = 24  # of cuts of the start
PLAYED = (256, 1_024, 4_096)  # starts that are played in what is open: after first cuts, after cells, at the end


class FormsSwept(NamedTuple):
    """The parts that forms leave open, [parts]; how many forms there were; whether what was allowed stopped them."""

    open: Bool
    forms: int
    stopped: bool


# a sweep by affine forms of parts of the start, bounds `low` and `high` [parts, variables], with at most so many forms
SweepForms = Callable[[Float64, Float64, int], FormsSwept]


@dataclass(frozen=True)
class Covering:
    """The way a cover is made, as verify/checker/covers reads it: boxes in cells, `widths` by variable, or forms."""

    cuts: tuple[int, ...]
    widths: Mapping[str, Fraction]
    forms: bool = False


class OpenParts(NamedTuple):
    """The parts of the start in which an attempt left the claim open, bounds [parts, variables]; how many starts are
    worth playing there.
    """

    low: Float64
    high: Float64
    played: int


@dataclass
class StartPart:
    """A part of the start, with its two halves once it is cut."""

    low: Float64
    high: Float64
    depth: int = 0
    column: int = -1
    halves: list[StartPart] = field(default_factory=list["StartPart"])

    def cut(self, column: int) -> list[StartPart]:
        """Its halves."""
        middle, lower, upper = 0.5 * self.low[column] + 0.5 * self.high[column], self.high.copy(), self.low.copy()
        lower[column] = upper[column] = middle
        self.column = column
        self.halves = [StartPart(self.low, lower, self.depth + 1), StartPart(upper, self.high, self.depth + 1)]
        return self.halves

    def cuts(self) -> Iterator[int]:
        """All cuts in it, in the order in which the checker reads them."""
        pending: list[StartPart] = [self]
        while pending:
            part = pending.pop()
            yield part.column + 1
            pending += reversed(part.halves)


class Search:
    """The search for covers. `by_forms`: the sweep by affine forms, where there is one."""

    def __init__(
        self,
        profile: PolicyProfile,
        system: System,
        claim: SystemClaim,
        spending: Spending,
        by_forms: SweepForms | None = None,
    ) -> None:
        self._model = Model(profile, system)
        self._sweep, self._by_forms = Sweep(self._model, system, claim), by_forms
        self._spending = spending
        self._start = self._bound_starts(system)
        self._whole = self._open = self._start.low[None], self._start.high[None]
        counting = _relevant(self._model, system, claim) - set_anew(system)
        self._failed: set[int] = set()  # cells, by their number, that leave the claim open
        self._modes = [column for column, one in enumerate(system.variables) if one.modes]  # never joined
        self._columns = [column for name, column in self._model.columns.items() if name in counting]

    def iterate_covers(self) -> Iterator[Covering | OpenParts]:
        """Covers that show the claim by this arithmetic, the cheap ones first; the checker may still refuse one. What
        is left open stands between them. BudgetSpentError.
        """
        yield from self._by_cuts(FIRST, self._boxes)
        yield self._report_open(PLAYED[0])
        yield from self._by_cells(QUICK)
        yield from self._by_cuts(FORMS, self._forms)
        yield from self._by_cells(IN_CELLS)
        yield self._report_open(PLAYED[1])
        yield from self._by_cuts(SECOND, self._forms)
        yield from self._by_cuts(SECOND, self._boxes)
        yield self._report_open(PLAYED[2])

    def _report_open(self, played: int) -> OpenParts:
        """Returns the parts left open; where the checker refused a cover, no part is open, so all may be."""
        return OpenParts(*(self._open if len(self._open[0]) else self._whole), played)

    def _by_cells(self, boxes: int) -> Iterator[Covering]:
        """Cells, the wide ones first, each with at most so many boxes."""
        for number, widths in enumerate(self._cells()):
            if number in self._failed or not self._limit_boxes(boxes):
                continue
            swept = self._boxes(*self._whole, self._limit_boxes(boxes), widths)
            if not swept.stopped:  # what they leave open, they leave open again
                self._failed.add(number)
            if not swept.open.any():
                yield Covering((0,), {self._model.names[at]: Fraction(widths[at]) for at in widths})

    def _boxes(self, low: Float64, high: Float64, allowed: int, widths: Mapping[int, float] | None = None) -> Swept:
        """Returns the parts that boxes leave open. BudgetSpentError."""
        self._spending.ensure_left()
        most = min(allowed, self._spending.left)
        swept = self._sweep.run((low, high), widths or {}, most)
        self._spending.take(swept.boxes)
        if swept.stopped and most < allowed:
            raise BudgetSpentError(OPTION)
        return swept

    def _forms(self, low: Float64, high: Float64, allowed: int) -> FormsSwept:
        """Returns the parts that affine forms leave open. BudgetSpentError."""
        assert self._by_forms is not None
        self._spending.ensure_left(FORM)
        most = min(allowed, self._spending.left)
        swept = self._by_forms(low, high, most // FORM)
        self._spending.take(swept.forms * FORM)
        if swept.stopped and most < allowed:
            raise BudgetSpentError(OPTION)
        return swept

    def _cells(self) -> Iterator[dict[int, float]]:
        """Widths of cells, the wide ones first: of the variables that start at one number, which often stay on few, and
        of all variables.
        """
        scale, wide = self._scale(), self._start.high > self._start.low
        ranging = [at for at in self._columns if scale[at] > NARROW and at not in self._modes]
        for power in CELLS:
            for columns in ([at for at in ranging if not wide[at]], ranging):
                if columns:
                    widths = {at: 2.0 ** (floor(log2(scale[at])) - power) for at in columns}
                    yield {**dict.fromkeys(self._modes, 1.0), **widths}

    def _limit_boxes(self, boxes: int) -> int:
        return max(min(boxes, MOST - self._spending.boxes), 0)

    def _by_cuts(self, boxes: int, sweep: Callable[[Float64, Float64, int], Swept | FormsSwept]) -> Iterator[Covering]:
        """Cuts of the start after which all parts are shown."""
        forms = sweep == self._forms
        root = StartPart(self._start.low, self._start.high)
        pending: list[StartPart] = [root]
        allowed, before = self._limit_boxes(boxes), self._spending.boxes
        while (not forms or self._by_forms is not None) and allowed > self._spending.boxes - before:
            low, high = np.array([part.low for part in pending]), np.array([part.high for part in pending])
            open_ = sweep(low, high, allowed - (self._spending.boxes - before)).open
            self._open = low[open_], high[open_]
            if not open_.any():
                yield Covering(tuple(root.cuts()), {}, forms)
                return
            left = [pending[at] for at in np.flatnonzero(open_).tolist()]
            if 2 * len(left) > allowed - (self._spending.boxes - before):  # each half is a box at least
                return
            columns = [self._widest(part) for part in left]
            if any(column is None or part.depth >= MAX_DEPTH for part, column in zip(left, columns, strict=True)):
                return
            pending = [half for part, at in zip(left, columns, strict=True) if at is not None for half in part.cut(at)]

    def _widest(self, part: StartPart) -> int | None:
        """The variable along which a part is widest, beside the whole start."""
        whole = self._start.high - self._start.low
        ratios = {at: (part.high[at] - part.low[at]) / whole[at] for at in self._columns if whole[at] > 0}
        return max(ratios, key=lambda at: ratios[at]) if ratios and max(ratios.values()) > 0 else None

    def _scale(self) -> Float64:
        """Estimates how far each variable ranges."""
        low, high = self._start.low, self._start.high
        points = low + np.random.default_rng(SEED).random((POINTS, len(low))) * (high - low)
        with np.errstate(all="ignore"):
            ranges = self._sweep.estimate_ranges(points, points.copy())
        return np.where(np.isfinite(ranges), ranges, 0.0)

    def _bound_starts(self, system: System) -> StartPart:
        """A box around all starts."""
        ends = np.array([[nearest_double(end) for end in one.range] for one in system.variables])
        rows = Rows.of(ends[:, 0][None], ends[:, 1][None])
        for half in self._model.region(system.start):
            rows = half.of(rows)
        return StartPart(rows.low[0], rows.high[0]) if rows.size else StartPart(ends[:, 0], ends[:, 0])


def set_anew(system: System) -> set[str]:
    """The variables that each step sets anew, whatever they were: parts of their start tell nothing after a step."""
    names = {one.name for one in system.variables if not one.modes}
    for piece in system.pieces:
        names -= {name for name, form in piece.move.items() if form.terms}
        names -= {name for effects in piece.effect.values() for name in effects}
    return names if system.pieces else set()


def _relevant(model: Model, system: System, claim: SystemClaim) -> set[str]:
    """The variables that the claim, tests or boxes of pieces speak of, and those that move them."""
    names = {name for region in claim.regions for half in region for name, _ in half.form.terms}
    names |= {name for piece in system.pieces for name in piece.where}
    names |= {name for piece in system.pieces for half in piece.when for name, _ in half.form.terms}
    names = names.union(*(tree.variables for tree in model.trees))
    before = -1
    while len(names) > before:
        before = len(names)
        for piece in system.pieces:
            for forms in (piece.move, *piece.effect.values()):
                names |= {read for name, form in forms.items() if name in names for read, _ in form.terms}
    return names
