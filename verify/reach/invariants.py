"""Claims about all steps, decided by invariants: cells that all episodes stay in, and that meet a claim.

Does: adds the cells that the cells of the start become until none is new, in wide cells first, for few variables first;
  has the checker accept the list, or says which cell leaves.
Assumes: a checked system; a claim about all steps. The checker's arithmetic moves cells, and is asked again.
Does not: shrink a region until it is closed: it grows what is reached.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from fractions import Fraction
from itertools import pairwise
from math import floor, log2

import numpy as np

from codegen.floats import nearest_double
from codegen.ir import Float64, Int64, PolicyProfile
from codegen.policy_json import content_hash
from verify.boxes.model import Model
from verify.boxes.sweep import Sweep
from verify.certificates.proofs import encode_numbers
from verify.checker.covers.boxes import BoxList
from verify.checker.covers.forever import InvariantCertificate, InvariantPart, accepted
from verify.checker.covers.invariants import InvariantSweep, names_of
from verify.checker.reading import RejectedError
from verify.progress import tell
from verify.reach.results import NO_STATE, ROOM, OpenState, ReachOutcome
from verify.reach.witnesses import inhabitant
from verify.result import Verdict
from verify.systems import documents
from verify.systems.claims import SystemClaim
from verify.systems.system import System

POWERS = (3, 4, 5, 6, 7, 8)  # of two: cells in the range of a variable
STEPS = (1, 4, 8)  # out of the list
MAX_CELLS, MAX_TRIED = 60_000, 400_000  # of one list; boxes that one list may take
POINTS, SEED = 128, 0  # of starts that show how far episodes range
HELPS = ("a larger region, or a smaller start region", "another region that episodes stay in")
Cell = tuple[int, ...]
Bounds = Mapping[str, tuple[float, float]]


class _LeftError(Exception):
    """A cell leaves what the claim allows. `cell` and `to`: bounds of it, and of where it goes."""

    def __init__(self, cell: Bounds, to: Bounds) -> None:
        super().__init__()
        self.cell, self.to = cell, to


class InvariantSearch:
    """The search for one claim. `spent`: boxes so far; `open`: a cell that leaves, of the last list that was tried;
    `to`: bounds of where it goes.
    """

    def __init__(self, profile: PolicyProfile, system: System, claim: SystemClaim, most: int) -> None:
        self._profile, self._system, self._claim, self._most = profile, system, claim, most
        self.spent, self.open, self.to = 0, None, ""
        self._scale = self._ranging()

    open: OpenState | None
    to: str

    def parts(self) -> tuple[InvariantPart, ...] | None:
        """Invariants that show the whole claim together; None where some were not found."""
        for groups in (self._groups(together=False), self._groups(together=True)):
            found = [self._part(names) for names in groups]
            if all(part is not None for part in found):
                return tuple(part for part in found if part is not None)
        return None

    def _groups(self, together: bool) -> list[tuple[str, ...]]:
        """The variables that halves of the claim need, with all that these depend on. `together`: and all that stand
        in one test with them.
        """
        regions = self._claim.regions
        halves = [names_of(half) for half in regions[0]] if len(regions) == 1 else []
        asked = halves or [{name for region in regions for half in region for name in names_of(half)}]
        found: list[frozenset[str]] = []
        for names in asked:
            closed = frozenset(self._closed(names, together))
            if not any(closed <= other for other in found):
                found = [other for other in found if not other <= closed] + [closed]
        return [tuple(one.name for one in self._system.variables if one.name in names) for names in found]

    def _closed(self, names: set[str], together: bool) -> set[str]:
        found = set(names).union(*(piece.where for piece in self._system.pieces))
        found = found.union(*(names_of(half) for piece in self._system.pieces for half in piece.when))
        tests = [
            {name for name, _ in known[feature.name].form.terms}
            for policy in self._profile.agents
            for known in [self._system.features[policy.agent]]
            for feature in policy.features
        ]
        before = -1
        while len(found) > before:
            before = len(found)
            for piece in self._system.pieces:
                for forms in (piece.move, *piece.effect.values()):
                    found |= {read for name, form in forms.items() if name in found for read, _ in form.terms}
            found = found.union(*(test for test in tests if together and test & found))
        return found

    def _part(self, names: tuple[str, ...]) -> InvariantPart | None:
        for power in POWERS:
            for steps in STEPS:
                if self.spent >= self._most:
                    return None
                try:
                    return self._closed_list(self._widths(names, power), steps)
                except _LeftError as left:
                    self.open = OpenState(0, left.cell)
                    self.to = ", ".join(f"{name} in [{low:.4g}, {high:.4g}]" for name, (low, high) in left.to.items())
                except RejectedError:  # not finite, too many, or nothing is stated
                    continue
        return None

    def _widths(self, names: Sequence[str], power: int) -> dict[str, Fraction]:
        modes = {one.name for one in self._system.variables if one.modes}
        scale = {name: float(self._scale[at]) for at, name in enumerate(one.name for one in self._system.variables)}
        widths = {name: Fraction(2) ** (floor(log2(scale[name])) - power) if scale[name] > 0 else 1 for name in names}
        return {name: Fraction(1 if name in modes else width) for name, width in widths.items()}

    def _closed_list(self, widths: Mapping[str, Fraction], steps: int) -> InvariantPart:
        """Cells that nothing leaves for more than some steps. _LeftError, RejectedError."""
        floats = {name: float(width) for name, width in widths.items()}
        with np.errstate(all="ignore"):
            sweep = InvariantSweep(self._profile, self._system, self._claim, floats)
            known = _cells(sweep.in_cells(self._meeting(sweep))[1])
            fresh = known
            before = self.spent
            while fresh:
                cells = np.array(sorted(fresh), dtype=np.int64)
                if self.spent - before > MAX_TRIED:
                    raise self._left(sweep, cells[:1], sweep.moved(sweep.boxes(cells[:1])))
                fresh = self._becoming(sweep, cells, known, steps)
                known |= fresh
        return InvariantPart(dict(widths), steps, encode_numbers(_numbers(np.array(sorted(known), dtype=np.int64))))

    def _becoming(self, sweep: InvariantSweep, cells: Int64, known: set[Cell], steps: int) -> set[Cell]:
        """The new cells that cells become after some steps. _LeftError where one leaves."""
        boxes = sweep.boxes(cells)
        for step in range(1, steps + 1):
            boxes = sweep.moved(boxes)
            broken = sweep.broken(boxes)
            if broken.size:
                raise self._left(sweep, cells, broken)
            boxes, of = sweep.in_cells(boxes)
            self.spent += boxes.size
            tell(min(self.spent, self._most), self._most, "boxes")
            new = np.array([tuple(each) not in known for each in of.tolist()], dtype=np.bool_)
            boxes, of = boxes.taken(new), of[new]
            if boxes.size > MAX_TRIED or len(known) > MAX_CELLS:
                raise self._left(sweep, cells, boxes)
            if step == steps or not boxes.size:
                return _cells(of)
        return set()

    def _meeting(self, sweep: InvariantSweep) -> BoxList:
        """The start. _LeftError where it does not meet the claim."""
        start = sweep.started()
        broken = sweep.broken(start)
        if broken.size:
            raise _LeftError(self._bounds(sweep, start), self._bounds(sweep, broken))
        return start

    def _left(self, sweep: InvariantSweep, cells: Int64, to: BoxList) -> _LeftError:
        """That a state of a cell goes to where it may not, or goes on and on."""
        return _LeftError(self._bounds(sweep, sweep.boxes(cells[to.part[:1]])), self._bounds(sweep, to))

    def _bounds(self, sweep: InvariantSweep, boxes: BoxList) -> Bounds:
        names = [one.name for one in self._system.variables]
        return {names[at]: (float(boxes.low[0, at]), float(boxes.high[0, at])) for at in sweep.followed}

    def _ranging(self) -> Float64:
        """How far each variable ranges in some episodes, about, and at most as far as the claim's region reaches."""
        ends = np.array([[nearest_double(end) for end in one.range] for one in self._system.variables])
        for half in self._system.start:
            if len(half.form.terms) == 1:
                ((name, factor),) = half.form.terms
                at = next(at for at, one in enumerate(self._system.variables) if one.name == name)
                end = nearest_double(-half.form.constant / factor)
                ends[at, int(factor > 0)] = (min if factor > 0 else max)(ends[at, int(factor > 0)], end)
        low, high = ends[:, 0], np.maximum(ends[:, 0], ends[:, 1])
        points = low + np.random.default_rng(SEED).random((POINTS, len(low))) * (high - low)
        with np.errstate(all="ignore"):
            sweep = Sweep(Model(self._profile, self._system), self._system, self._claim)
            found = sweep.reached(points, points.copy())
        return np.where(np.isfinite(found), found, 0.0)


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


# --- the answer


def lasting(profile: PolicyProfile, system: System, claim: SystemClaim, most: int) -> ReachOutcome:
    """The answer, after at most so many boxes."""
    search = InvariantSearch(profile, system, claim, most)
    parts = search.parts()
    if parts is not None:
        state = inhabitant(system, claim)
        if isinstance(state, Verdict):
            return ReachOutcome(state, NO_STATE[state], helps=(ROOM,), boxes=search.spent)
        made = InvariantCertificate(content_hash(profile), documents.content_hash(system), claim, state, parts)
        with suppress(RejectedError):
            cells = accepted(made, profile, system)
            return ReachOutcome(Verdict.PROVED, certificate=made, branches=cells, boxes=search.spent)
    spent = search.spent >= most
    helps = (*HELPS, f"a larger --max-boxes than {most:,}") if spent else HELPS
    where = f": a state of the cell below may go to {search.to}" if search.open is not None else ""
    said = f"no invariant was found after {search.spent:,} boxes{where}"
    return ReachOutcome(Verdict.UNKNOWN, said, search.open, helps, boxes=search.spent)
