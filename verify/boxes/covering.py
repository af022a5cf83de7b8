"""How to cut the start and in which cells to join boxes, so that a claim about episodes is shown.

Does: tries whole boxes, cuts the start where the claim stays open, tries affine forms, which do not widen where boxes
  do, then joins boxes in ever smaller cells.
Assumes: a checked profile, system and claim.
Does not: prove: the checker makes the boxes again and says whether they do.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from math import floor, log2

import numpy as np

from codegen.floats import nearest_double
from codegen.ir import Float64, PolicyProfile
from verify.boxes.model import Model
from verify.boxes.rows import Rows
from verify.boxes.sweep import Sweep, Swept
from verify.progress import tell
from verify.systems.claims import SystemClaim
from verify.systems.system import System

SEED, POINTS = 0, 128  # of starts that show how far episodes range
FIRST, FORMS, SECOND = 20_000, 60_000, 400_000  # boxes for cuts of the start alone; the last after cells
FORM = 10  # boxes take as long as a form
CELLS = tuple(range(2, 10))  # into how many parts, as powers of two, what episodes range over is cut
IN_CELLS = 250_000  # boxes for cells of one width
NARROW = 1e-200  # what a variable has to range over
MAX_DEPTH = 24  # of cuts of the start


# Which parts of the start a sweep leaves open; of `low` and `high` [parts, variables], with at most so many sets.
Sweeping = Callable[[Float64, Float64, int], Swept]


@dataclass(frozen=True)
class Covering:
    """What a cover is made from, as verify/checker/covers reads it: boxes in cells, `widths` by variable, or forms."""

    cuts: tuple[int, ...]
    widths: Mapping[str, Fraction]
    forms: bool = False


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
    """The search for one cover. `spent`: boxes so far; `open`: parts of the start that were left open at last.
    `by_forms`: the sweep by affine forms, which whoever asks for covers has.
    """

    def __init__(
        self, profile: PolicyProfile, system: System, claim: SystemClaim, most: int, by_forms: Sweeping | None = None
    ) -> None:
        self._model = Model(profile, system)
        self._sweep, self._by_forms = Sweep(self._model, system, claim), by_forms
        self._most, self.spent = most, 0
        self.open: list[tuple[Float64, Float64]] = []
        self._start = self._started(system)
        counting = _relevant(self._model, system, claim)
        self._modes = [column for column, one in enumerate(system.variables) if one.modes]  # never joined
        self._columns = [column for name, column in self._model.columns.items() if name in counting]

    def coverings(self) -> Iterator[Covering]:
        """Covers that show the claim by this arithmetic, the cheap ones first; the checker may still refuse one."""
        yield from self._by_cuts(FIRST, self._boxes)
        yield from self._by_cuts(FORMS, self._forms)
        for widths in self._cells():
            if self._left:
                swept = self._sweep.run(*self._one(), widths, min(IN_CELLS, self._left))
                self._spend(swept.boxes)
                if not swept.open.any():
                    yield Covering((0,), {self._model.names[at]: Fraction(width) for at, width in widths.items()})
        yield from self._by_cuts(SECOND, self._forms)
        yield from self._by_cuts(SECOND, self._boxes)

    def _boxes(self, low: Float64, high: Float64, most: int) -> Swept:
        return self._sweep.run(low, high, {}, most)

    def _forms(self, low: Float64, high: Float64, most: int) -> Swept:
        assert self._by_forms is not None
        swept = self._by_forms(low, high, most // FORM)
        return Swept(swept.open, swept.boxes * FORM)

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

    @property
    def _left(self) -> int:
        return max(self._most - self.spent, 0)

    def _spend(self, boxes: int) -> None:
        self.spent += boxes
        tell(min(self.spent, self._most), self._most, "boxes")

    def _one(self) -> tuple[Float64, Float64]:
        return self._start.low[None, :].copy(), self._start.high[None, :].copy()

    def _by_cuts(self, allowed: int, sweep: Sweeping) -> Iterator[Covering]:
        """Cuts of the start after which all of its parts are shown; none where too many are left open."""
        forms = sweep == self._forms
        if forms and self._by_forms is None:
            return
        root = StartPart(self._start.low, self._start.high)
        pending: list[StartPart] = [root]
        before = self.spent
        while pending and self._left and self.spent - before < allowed:
            low, high = np.array([part.low for part in pending]), np.array([part.high for part in pending])
            swept = sweep(low, high, min(self._left, allowed - (self.spent - before)))
            self._spend(swept.boxes)
            left = [pending[at] for at in np.flatnonzero(swept.open)]
            self.open = [(part.low, part.high) for part in left]
            if not left:
                yield Covering(tuple(root.cuts()), {}, forms)
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
        """How far each variable ranges, about."""
        low, high = self._start.low, self._start.high
        points = low + np.random.default_rng(SEED).random((POINTS, len(low))) * (high - low)
        with np.errstate(all="ignore"):
            found = self._sweep.reached(points, points.copy())
        return np.where(np.isfinite(found), found, 0.0)

    def _started(self, system: System) -> StartPart:
        """A box around all starts."""
        ends = np.array([[nearest_double(end) for end in one.range] for one in system.variables])
        rows = Rows(ends[:, 0][None], ends[:, 1][None], np.zeros(1, dtype=np.int64), np.zeros(1, dtype=np.int64))
        for half in self._model.region(system.start):
            rows = half.of(rows)
        return StartPart(rows.low[0], rows.high[0]) if rows.size else StartPart(ends[:, 0], ends[:, 0])


def _relevant(model: Model, system: System, claim: SystemClaim) -> set[str]:
    """The variables that the claim, tests or boxes of pieces speak of, and those that move them."""
    found = {name for region in claim.regions for half in region for name, _ in half.form.terms}
    found |= {name for piece in system.pieces for name in piece.where}
    found |= {name for piece in system.pieces for half in piece.when for name, _ in half.form.terms}
    found = found.union(*(tree.variables for tree in model.trees))
    before = -1
    while len(found) > before:
        before = len(found)
        for piece in system.pieces:
            for forms in (piece.move, *piece.effect.values()):
                found |= {read for name, form in forms.items() if name in found for read, _ in form.terms}
    return found
