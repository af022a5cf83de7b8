"""How to cut the start and in which cells to join boxes, so that a claim about episodes is shown.

Does: tries whole boxes, cuts the start where the claim stays open, tries affine forms, which do not widen where boxes
  do, then joins boxes in ever smaller cells.
Assumes: a checked profile, system and claim. The checker's own sweeps say what is shown.
Does not: prove: the checker makes the sets again by the certificate alone.

What is tried, in which order, and how much each attempt may take depends on no budget. A budget only ends the search.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import chain
from math import floor, log2
from typing import NamedTuple

import numpy as np

from codegen.ir import Float64, PolicyProfile
from verify.certificates.proofs import encode_numbers
from verify.checker.certificate import numbers
from verify.checker.covers.boxes import BoxList, Parts, StartBox, halves, unit_of, widths_of
from verify.checker.covers.images import BoxMotion
from verify.checker.covers.sweep import BoxSweep, FormSweep, Swept
from verify.checker.reading import RejectedError
from verify.checker.systems.branch_proofs import depends_on
from verify.checker.systems.proofs import WHOLE, Cover
from verify.checker.systems.reading import sides_of
from verify.claims.formula import coordinates
from verify.spending import FORM, OPTION, BudgetSpentError, Spending
from verify.systems.claims import SystemClaim
from verify.systems.system import System

SEED, POINTS = 0, 128  # of starts that show how far episodes range
FIRST, FORMS, SECOND = 20_000, 60_000, 400_000  # boxes for cuts of the start alone; the last after cells
CELLS = tuple(range(2, 10))  # into how many parts, as powers of two, what episodes range over is cut
QUICK, IN_CELLS = 5_000, 250_000  # boxes for cells of one width, before and after forms
MOST, LARGEST = 2_000_000, 200_000  # boxes for all, and of one list; what they leave open goes on to linear programs
NARROW = 1e-200  # what a variable has to range over
MAX_DEPTH = 24  # of cuts of the start
PLAYED = (256, 1_024, 4_096)  # starts that are played in what is open: after first cuts, after cells, at the end


class OpenParts(NamedTuple):
    """The parts of the start in which an attempt left the claim open; how many starts are worth playing there."""

    parts: Sequence[StartBox]
    played: int


@dataclass
class CutPart:
    """A part of the start or of a region, with its two halves once it is cut."""

    box: StartBox
    depth: int = 0
    column: int = -1
    halves: list[CutPart] = field(default_factory=list["CutPart"])

    def cut(self, whole: StartBox, weights: Float64, deepest: int = MAX_DEPTH) -> list[CutPart]:
        """Its halves along the variable in which it is widest, beside the whole and by weights [variables]; none where
        no such variable has a float within, and for a part that was cut so often.
        """
        widest = 0.0  # one by one: most systems have few variables
        ends = zip(*(each.tolist() for each in (*self.box, *whole, weights)), strict=True)
        for column, (low, high, least, most, weight) in enumerate(ends if self.depth < deepest else ()):
            within = low < 0.5 * low + 0.5 * high < high
            ratio = weight * (high - low) / (most - least) if within else 0.0
            if ratio > widest:
                self.column, widest = column, ratio
        if widest:
            self.halves = [CutPart(half, self.depth + 1) for half in halves(self.box, self.column)]
        return self.halves

    @property
    def cuts(self) -> bytes:
        """All cuts in it, as the checker reads them."""
        numbers = list[int]()
        pending: list[CutPart] = [self]
        while pending:
            part = pending.pop()
            numbers.append(part.column + 1)
            pending += reversed(part.halves)
        return encode_numbers(numbers)


class Search:
    """The search for covers."""

    def __init__(self, profile: PolicyProfile, system: System, claim: SystemClaim, spending: Spending) -> None:
        self._spending, self._steps, self._start = spending, claim.steps, Parts(system).whole
        self._boxes: BoxSweep | None = None
        self._forms: FormSweep | None = None
        with suppress(RejectedError):  # a system whose numbers the arithmetic does not hold, or that leaves gaps
            self._boxes = BoxSweep(profile, system, claim, largest=LARGEST)
            self._forms = FormSweep(profile, system, claim)
        self._open: Sequence[StartBox] = ()
        self._failed: set[int] = set()  # cells, by their number, that leave the claim open
        self._names = [one.name for one in system.variables]
        self._modes = [column for column, one in enumerate(system.variables) if one.modes]  # never joined
        # the variables that the claim, tests or boxes of pieces speak of, and those that move them
        names = {name for region in claim.regions for half in region for name, _ in half.form.terms}
        names |= {name for piece in system.pieces for name in piece.where}
        names |= {name for piece in system.pieces for half in piece.when for name, _ in half.form.terms}
        sides = [side for policy in profile.agents for side in sides_of(system, policy).values()]
        counting = close_names(system, names.union(*map(coordinates, sides))) - set_anew(system)
        self._columns = [column for column, name in enumerate(self._names) if name in counting]
        self._weights = np.array([float(name in counting) for name in self._names])

    def iterate_covers(self) -> Iterator[Cover | OpenParts]:
        """Covers that show the claim, the cheap ones first. What is left open stands between them. BudgetSpentError."""
        if self._start is None:
            yield Cover({}, WHOLE)
            return
        self._open = [self._start]
        if self._boxes is not None:
            yield from self._by_cuts(FIRST, self._boxes)
            yield self._report_open(PLAYED[0])
            yield from self._by_cells(QUICK)
            yield from self._by_cuts(FORMS, self._forms)
            yield from self._by_cells(IN_CELLS)
            yield self._report_open(PLAYED[1])
            yield from self._by_cuts(SECOND, self._forms)
            yield from self._by_cuts(SECOND, self._boxes)
        yield self._report_open(PLAYED[2])

    def holds(self, cover: Cover) -> bool:
        """Returns True where a cover shows the claim with so few boxes that it is worth a try. RejectedError for cuts
        of another start; BudgetSpentError.
        """
        sweep = self._forms if cover.sets == "forms" else self._boxes
        if self._start is None or sweep is None:
            return False
        widths = {self._names.index(name): width for name, width in widths_of(cover.cells).items()}
        parts = chain.from_iterable(sweep.parts.cut(list(numbers(cover.cuts))))
        return not self._sweep(sweep, [*parts], SECOND, widths).open.any()

    def _report_open(self, played: int) -> OpenParts:
        """Returns the parts left open; where the checker refused a cover, no part is open, so all may be."""
        assert self._start is not None
        return OpenParts(self._open or [self._start], played)

    def _by_cells(self, boxes: int) -> Iterator[Cover]:
        """Cells, the wide ones first, each with at most so many boxes."""
        assert self._start is not None and self._boxes is not None
        for number, widths in enumerate(self._cells(self._start)):
            allowed = self._limit_boxes(boxes)
            if number in self._failed or not allowed:
                continue
            swept = self._sweep(self._boxes, [self._start], allowed, widths)
            if not swept.stopped:  # what they leave open, they leave open again
                self._failed.add(number)
            if not swept.open.any():
                yield Cover({self._names[at]: Fraction(widths[at]) for at in widths}, WHOLE)

    def _sweep(
        self,
        sweep: BoxSweep | FormSweep,
        parts: Sequence[StartBox],
        allowed: int,
        widths: Mapping[int, float] | None = None,
    ) -> Swept:
        """Finds the parts that boxes or forms leave open, with as many as that many boxes are. BudgetSpentError."""
        each = FORM if sweep is self._forms else 1  # boxes that one set takes as long as
        self._spending.ensure_left(each)
        if isinstance(sweep, BoxSweep):
            sweep.motion.forget()
        most = min(allowed, self._spending.left)
        swept = sweep.find_open_parts(parts, most // each, widths)
        ended = swept.stopped and most < allowed  # before it asked about the sets that its last step made
        self._spending.take(most if ended else swept.sets * each)
        if ended:
            raise BudgetSpentError(OPTION)
        return swept

    def _cells(self, start: StartBox) -> Iterator[dict[int, float]]:
        """Widths of cells, the wide ones first: of the variables that start at one number, which often stay on few, and
        of all variables.
        """
        assert self._boxes is not None
        scale, wide = estimate_ranges(self._boxes.motion, start, POINTS, self._steps), start.high > start.low
        ranging = [at for at in self._columns if scale[at] > NARROW and at not in self._modes]
        for power in CELLS:
            for columns in ([at for at in ranging if not wide[at]], ranging):
                if columns:
                    widths = {at: 2.0 ** (floor(log2(scale[at])) - power) for at in columns}
                    yield {**dict.fromkeys(self._modes, 1.0), **widths}

    def _limit_boxes(self, boxes: int) -> int:
        return max(min(boxes, MOST - self._spending.boxes), 0)

    def _by_cuts(self, boxes: int, sweep: BoxSweep | FormSweep | None) -> Iterator[Cover]:
        """Cuts of the start after which all parts are shown."""
        if self._start is None or sweep is None:
            return
        root = CutPart(self._start)
        pending: list[CutPart] = [root]
        end = self._spending.boxes + self._limit_boxes(boxes)
        while end > self._spending.boxes:
            open_ = self._sweep(sweep, [part.box for part in pending], end - self._spending.boxes).open
            left = [pending[at] for at in np.flatnonzero(open_).tolist()]
            self._open = [part.box for part in left]
            if not left:
                yield Cover({}, root.cuts, "forms" if sweep is self._forms else "boxes")
                return
            if 2 * len(left) > end - self._spending.boxes:  # each half is a box at least
                return
            pending = [half for part in left for half in part.cut(self._start, self._weights)]
            if len(pending) < 2 * len(left):
                return


def estimate_ranges(motion: BoxMotion, start: StartBox, count: int, steps: int) -> Float64:
    """Estimates how far each variable ranges in some episodes, [variables]; 0 where that is not finite."""
    random, none = np.random.default_rng(SEED), np.zeros(count, dtype=np.int64)
    points = start.low + random.random((count, len(start.low))) * (start.high - start.low)
    boxes, least, most = BoxList.of(points, points, np.arange(count), none), points.min(axis=0), points.max(axis=0)
    with np.errstate(all="ignore"), suppress(RejectedError):
        for _ in range(steps):
            boxes = motion.move_boxes(boxes)
            boxes = boxes.take(np.linspace(0, boxes.size - 1, min(boxes.size, 2 * count)).astype(np.int64))
            if not boxes.size:
                break
            low, high = boxes.low, boxes.high
            least, most = np.minimum(least, low.min(axis=0)), np.maximum(most, high.max(axis=0))
            middle, unit = 0.5 * low + 0.5 * high, unit_of(low.min(axis=0), high.max(axis=0))
            # points stay points: what rounding outward adds to them would grow from step to step
            low, high = np.minimum(low + unit, middle), np.maximum(high - unit, middle)
            boxes = BoxList.of(low, high, boxes.part, boxes.joint)
    return np.where(np.isfinite(most - least), most - least, 0.0)


def set_anew(system: System) -> set[str]:
    """The variables that each step sets anew, whatever they were: parts of their start tell nothing after a step."""
    names = {one.name for one in system.variables if not one.modes}
    for piece in system.pieces:
        names -= {name for name, form in piece.move.items() if form.terms}
        names -= {name for effects in piece.effect.values() for name in effects}
    return names if system.pieces else set()


def close_names(system: System, names: Iterable[str], joined: Sequence[set[str]] = ()) -> set[str]:
    """Variables with all that they depend on. `joined`: sets of which all belong to them once one does."""
    depends, closed, before = depends_on(system), set(names), -1
    while len(closed) > before:
        before = len(closed)
        closed = closed.union(*(depends[name] for name in closed))
        for together in joined:
            closed |= together if together & closed else set()
    return closed
