"""Invariants: sets of states that a system leaves for a few steps at most, and that its episodes come to.

Does: moves sets by boxes, asks the claim of all that they become, and whether that comes back: into a list of cells, or
  into regions; says whether a certificate that is an invariant fits a profile and a system, and shows its claim.
Assumes: images.py, trees.py and boxes.py bound what they are asked; a certificate that anyone made.
Does not: read documents (../systems/proofs.py), or find an invariant.

Some variables are followed, all others may be any number. A cell is a box of the followed variables, whole multiples of
a width being the middles; of a mode it is one value, since systems/cases.py shows that a mode has no others.

Cells: the invariant holds the states of the cells that meet the claim. If all states at the claim's first step are
among them, and if all that such a state becomes meets the claim until it is in a cell again, within so many steps,
then by induction all states from that step on meet the claim.

Regions: all of their states meet the claim. If the states at the claim's first step and at those after it, `steps` in
all, lie in the regions, and if after `steps` states in a row that do so comes another one, then by induction all states
from that first step on lie in the regions (k-induction). Boxes show the last of these, or a walk of one step by exact
rows does (systems/branch_proofs.py), where a border of a region is met exactly.

States outside of the regions that a claim assumes are dropped wherever they are met.

The numbers of a part are, for each followed variable, the least cell (zigzag: 2n, or -2n - 1 below 0) and how many it
spans; then the cells in order, each as its distance from the one before. A cell's number has one digit for each
variable, the first the highest. Cuts are those of covers (README.md).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from copy import copy
from dataclasses import replace
from functools import partial
from itertools import chain

import numpy as np

from codegen.ir import Bool, Int64, PolicyProfile
from verify.checker.certificate import numbers
from verify.checker.covers.boxes import BoxList, Parts, Regions, Watch, alike_joined, cut, in_cells, together, widths_of
from verify.checker.covers.images import BoxMotion, StatedStates
from verify.checker.covers.rounding import ensure_arithmetic
from verify.checker.reading import RejectedError
from verify.checker.systems.branch_proofs import close_branches, ensure_asked, needs_stated, ways
from verify.checker.systems.proofs import FollowedPart, Invariant, InvariantPart, SystemCertificate
from verify.systems.claims import Pattern, SystemClaim
from verify.systems.system import FREE, HalfSpace, Polytope, System, bounds_of, ensure_in_steps

MAX_STEPS = 8  # out of the list, or in the regions
AT_ONCE = 1 << 14  # cells that are moved together
MAX_SPAN = 1 << 62  # of the numbers of cells


def names_of(half: HalfSpace) -> set[str]:
    """The variables that a half space speaks of."""
    return {name for name, _ in half.form.terms}


class FollowedMotion:
    """Boxes of some variables, moved. `names`: of these. RejectedError where what they become depends on others."""

    def __init__(self, profile: PolicyProfile, system: System, claim: SystemClaim, names: set[str]) -> None:
        ensure_arithmetic()
        self.columns = {one.name: column for column, one in enumerate(system.variables)}
        _ensure_closed(system, names)
        self.followed = np.array([self.columns[name] for name in self.columns if name in names], dtype=np.int64)
        self._others = np.array([at for name, at in self.columns.items() if name not in names], dtype=np.int64)
        self._modes = [(self.columns[one.name], len(one.modes)) for one in system.variables if one.modes]
        self._motion, self._starts = BoxMotion(profile, system), Parts(system)
        self._stated, self._first = StatedStates(system, claim), claim.by
        self._assumed = Regions(claim.assuming, self.columns) if claim.assuming else None
        self.shows = find_shown_halves(claim, names)
        asked = [tuple(half for half in region if names_of(half) <= names) for region in claim.regions]
        self._claimed = Regions(asked, self.columns) if self.shows else None

    def arriving(self, cuts: Sequence[int], widths: Mapping[str, float]) -> Iterator[BoxList]:
        """Boxes around all states at the claim's first step, some at a time. `cuts`: of the start; `widths`: of the
        cells in which boxes are joined on the way, by variable. RejectedError as of `move_boxes`.
        """
        cells = {self.columns[name]: width for name, width in widths.items()}
        for boxes in self._starts.parts(cuts):
            boxes = self.restrict_boxes(boxes)
            for _ in range(self._first):
                boxes = self.move_boxes(in_cells(boxes, cells) if cells else boxes)
            yield boxes

    def restrict_boxes(self, boxes: BoxList) -> BoxList:
        """Boxes around the states that the claim does not leave out, other variables being any number."""
        if self._assumed:
            boxes = self._assumed.within(boxes)
        bounds = boxes.bounds.copy()
        bounds[:, self._others], bounds[:, boxes.variables + self._others] = -np.inf, -np.inf
        return boxes._replace(bounds=bounds)

    def by_modes(self, boxes: BoxList) -> BoxList:
        """The boxes, one for each value of each mode that is followed."""
        for column, count in self._modes:
            if column in self.followed:
                low, high = boxes.low[:, column], boxes.high[:, column]
                met = [(low <= mode) & (high >= mode) for mode in range(count)]
                boxes = together([boxes.take(each) for each in met])
                values = np.repeat(np.arange(float(count)), [int(each.sum()) for each in met])
                boxes.bounds[:, column], boxes.bounds[:, boxes.variables + column] = values, -values
        return boxes

    def meeting(self, boxes: BoxList) -> BoxList:
        """Boxes around the states that meet what these variables are to show."""
        return self._claimed.within(boxes) if self._claimed else boxes

    def find_breaking(self, boxes: BoxList) -> BoxList:
        """Boxes around the states that may break what these variables are to show."""
        return self._claimed.outside(boxes) if self._claimed else boxes.take(slice(0, 0))

    def is_unstated(self, boxes: BoxList) -> Bool:
        """Returns True for each box that may hold states of which nothing is stated."""
        return self._stated.beyond(boxes.low, boxes.high)

    def move_boxes(self, boxes: BoxList) -> BoxList:
        """Boxes around all next states. RejectedError where some are not finite, or nothing is stated of a state."""
        if self.is_unstated(boxes).any():
            raise RejectedError("a set may hold states of which nothing is stated")
        boxes = alike_joined(self.restrict_boxes(self._motion.move_boxes(boxes)))
        if not (np.isfinite(boxes.low) & np.isfinite(boxes.high))[:, self.followed].all():
            raise RejectedError("a box has bounds that are not finite")
        return boxes

    def ensure_meets(self, boxes: BoxList) -> None:
        """RejectedError for boxes that may hold states that break the claim."""
        count = self.find_breaking(boxes).size
        if count:
            raise RejectedError(f"{count:,} boxes of the invariant may hold states that break the claim")


class InvariantSweep:
    """Cells of some variables, moved. `widths`: of cells, for each of these. RejectedError as of `FollowedMotion`."""

    def __init__(self, profile: PolicyProfile, system: System, claim: SystemClaim, widths: Mapping[str, float]) -> None:
        self.motion = FollowedMotion(profile, system, claim, set(widths))
        self._widths = {self.motion.columns[name]: width for name, width in widths.items()}
        self._modes = {self.motion.columns[one.name] for one in system.variables if one.modes}

    def of_widths(self, widths: Mapping[str, float]) -> InvariantSweep:
        """The same with other widths, for the same variables."""
        other = copy(self)
        other._widths = {self.motion.columns[name]: width for name, width in widths.items()}
        return other

    def boxes(self, cells: Int64) -> BoxList:
        """Boxes around the states of cells, [n, followed], that meet the claim; `part` is the place of the cell."""
        low = np.zeros((len(cells), len(self.motion.columns)))
        high = low.copy()
        for place, (column, width) in enumerate(self._widths.items()):
            half = 0.0 if column in self._modes else 0.5
            low[:, column] = (cells[:, place] - half) * width
            high[:, column] = (cells[:, place] + half) * width
        boxes = BoxList.of(low, high, np.arange(len(cells)), np.zeros(len(cells), dtype=np.int64))
        return self.motion.meeting(self.motion.restrict_boxes(boxes))

    def in_cells(self, boxes: BoxList) -> tuple[BoxList, Int64]:
        """The boxes cut at the bounds of cells, and the cell of each, [n, followed]."""
        return cut(boxes, self._widths)

    def check(
        self, arriving: Iterator[BoxList], cells: Int64, steps: int, watch: Callable[[BoxList], None] | None = None
    ) -> int:
        """Checks that cells are an invariant that shows the claim; returns the number of boxes asked about.
        RejectedError where they are not. `arriving`: boxes at the claim's first step.

        `watch` is told of the boxes of cells, and of those on the way back to cells: of every state of these that meets
        the claim it is shown that the system keeps it.
        """
        asked, seen = 0, watch or _unseen
        with np.errstate(all="ignore"):  # what overflows is not finite, and is refused
            known = Known(cells)
            for boxes in arriving:
                self.motion.ensure_meets(boxes)
                if not known.holds(self.in_cells(boxes)[1]).all():
                    raise RejectedError("a state at the first step lies in no cell of the invariant")
            for begin in range(0, len(cells), AT_ONCE):
                boxes = self.boxes(cells[begin : begin + AT_ONCE])
                asked += boxes.size
                seen(boxes)
                for _ in range(steps):
                    boxes = self.motion.move_boxes(boxes)
                    self.motion.ensure_meets(boxes)
                    boxes, of = self.in_cells(boxes)
                    asked += boxes.size
                    boxes = boxes.take(~known.holds(of))
                    if not boxes.size:
                        break
                    seen(boxes)
                else:
                    raise RejectedError("some states may stay out of the invariant")
        return asked


def _unseen(boxes: BoxList) -> None:
    """Nobody watches."""


class Known:
    """A list of cells, to be asked whether it holds others."""

    def __init__(self, cells: Int64) -> None:
        if not len(cells):
            raise RejectedError("an invariant without cells")
        self._low, self._high = cells.min(axis=0), cells.max(axis=0)
        span = 1
        for low, high in zip(self._low.tolist(), self._high.tolist(), strict=True):
            span *= high - low + 1
        if span > MAX_SPAN:
            raise RejectedError("the cells of the invariant lie too far apart")
        self._keys = np.unique(self._key(cells))

    def _key(self, cells: Int64) -> Int64:
        key = np.zeros(len(cells), dtype=np.int64)
        for place, (low, high) in enumerate(zip(self._low.tolist(), self._high.tolist(), strict=True)):
            key = key * (high - low + 1) + (cells[:, place] - low)
        return key

    def holds(self, cells: Int64) -> Bool:
        """Returns True for each cell that is in the list, [n]."""
        held = np.asarray(((cells >= self._low) & (cells <= self._high)).all(axis=1), dtype=np.bool_)
        held[held] = np.isin(self._key(cells[held]), self._keys)
        return held


class RegionSweep:
    """Regions, moved: whether `steps` states in a row in them are followed by another one. What is followed are the
    variables that they name; 0 `steps`: what follows is shown elsewhere. RejectedError as of `FollowedMotion`, and for
    a region that does not bound each of these.
    """

    def __init__(
        self, profile: PolicyProfile, system: System, claim: SystemClaim, regions: Sequence[Polytope], steps: int
    ) -> None:
        names = {name for region in regions for half in region for name in names_of(half)}
        self.motion = FollowedMotion(profile, system, claim, names)
        self.regions = Regions(regions, self.motion.columns)
        # the system as if a region were its start, and as if the bounds of the region were the ranges
        free = {one.name: one.range if one.modes else FREE for one in system.variables if one.name in names}
        self._begun: list[System] = []
        for region in regions:
            ranges = bounds_of(region, free)
            for name, ends in ranges.items():
                if not set(FREE).isdisjoint(ends):
                    raise RejectedError(f"the invariant does not bound {name}")
            variables = tuple(replace(one, range=ranges.get(one.name, one.range)) for one in system.variables)
            self._begun.append(replace(system, variables=variables, start=region))
        self.parts = [Parts(begun) for begun in self._begun]
        self._all, self._names, self._steps = tuple(regions), names, steps

    def check(self, arriving: Iterator[BoxList], cuts: Sequence[Sequence[int]]) -> int:
        """Checks that the regions are an invariant that shows the claim; returns the number of boxes asked about.
        RejectedError where they are not. `arriving`: boxes at the claim's first step; `cuts`: of each region.
        """
        with np.errstate(all="ignore"):
            for boxes in arriving:
                for step in range(max(self._steps, 1)):
                    boxes = self.motion.move_boxes(boxes) if step else boxes
                    if self.regions.outside(boxes).size:
                        raise RejectedError("the invariant does not hold all states at the first steps")
            asked = 0
            for parts, numbers in zip(self.parts, cuts, strict=True):
                for boxes in parts.parts(numbers):
                    asked += boxes.size
                    if self.find_open_parts(boxes).size:
                        raise RejectedError("some states of the invariant may leave it, or break the claim")
            return asked

    def find_open_parts(self, boxes: BoxList) -> Int64:
        """The parts of which states may break the claim or leave the regions. RejectedError for infinite bounds."""
        boxes = self.motion.by_modes(self.motion.restrict_boxes(boxes))
        open_ = [self.motion.find_breaking(boxes).part]
        if not self._steps:
            return np.unique(open_[0])
        for step in range(1, self._steps + 1):
            unknown = self.motion.is_unstated(boxes)
            open_.append(boxes.part[unknown])
            boxes = self.motion.move_boxes(boxes.take(~unknown))
            if step < self._steps:
                boxes = self.regions.within(boxes)
        return np.unique(np.concatenate([*open_, self.regions.outside(boxes).part]))

    def one_step(self, number: int) -> tuple[System, SystemClaim, FollowedPart]:
        """A region as the start of a system, that one step of it ends in the regions, and what a proof of that is."""
        begun, claim = self._begun[number], SystemClaim(Pattern.STAYS_IN, self._all, 1)
        followed = tuple(one.name for one in begun.variables if one.name in self._names)
        return begun, claim, FollowedPart(followed, tuple(range(ways(claim) + needs_stated(claim, begun))), (), b"")


def find_shown_halves(claim: SystemClaim, followed: set[str]) -> frozenset[int]:
    """Returns the half spaces of a claim's one region that some variables decide; of several regions all or none."""
    if len(claim.regions) == 1:
        return frozenset(place for place, half in enumerate(claim.regions[0]) if names_of(half) <= followed)
    named = {name for region in claim.regions for half in region for name in names_of(half)}
    return frozenset([0]) if named <= followed else frozenset()


def _ensure_closed(system: System, followed: set[str]) -> None:
    """RejectedError unless what followed variables become depends on them alone, whatever agents do."""
    for piece in system.pieces:
        read = set(piece.where).union(*map(names_of, piece.when))
        for forms in chain([piece.move], piece.effect.values()):
            read = read.union(*({name for name, _ in form.terms} for to, form in forms.items() if to in followed))
        if not read <= followed:
            raise RejectedError(f"what is followed depends on {min(read - followed)}, which is not")


def ensure_shown(claim: SystemClaim, parts: Sequence[frozenset[int]]) -> None:
    """RejectedError unless all half spaces of a claim are shown by some part."""
    wanted = range(len(claim.regions[0])) if len(claim.regions) == 1 else range(1)
    if set(wanted) - frozenset().union(*parts):
        raise RejectedError("no part of the invariant shows some of the claim")


def check_certificate(
    certificate: SystemCertificate, proof: Invariant, profile: PolicyProfile, system: System, watch: Watch | None = None
) -> int:
    """Checks a certificate with this proof; the number of its cells. `watch` is told of all boxes that its cells speak
    of, by part.

    InputError when it is about another profile or system, or names what they do not have; RejectedError when its sets
    do not show the claim.
    """
    named = {name for part in proof.parts for name in (*part.followed, *part.joined)}
    ensure_asked(certificate, named, profile, system, ever=True)
    ensure_in_steps(system, "an invariant")
    count, shown = 0, list[frozenset[int]]()
    for number, part in enumerate(proof.parts):
        seen = None if watch is None else partial(watch, number)
        sets, shows = check_part(part, certificate.claim, profile, system, seen)
        count, shown = count + sets, [*shown, shows]
    ensure_shown(certificate.claim, shown)
    return count


def check_part(
    part: InvariantPart,
    claim: SystemClaim,
    profile: PolicyProfile,
    system: System,
    seen: Callable[[BoxList], None] | None,
) -> tuple[int, frozenset[int]]:
    """Checks a part; returns how many sets were asked about, and the half spaces that it shows. RejectedError."""
    modes = {one.name for one in system.variables if one.modes}
    widths, joined = widths_of(part.widths), widths_of(part.joined)
    if any(part.widths[name] != 1 for name in modes & set(part.widths)) or not 1 <= part.steps <= MAX_STEPS:
        raise RejectedError("cells of modes are 1 wide, and a part takes 1 to 8 steps")
    if bool(part.widths) == bool(part.regions) or bool(part.widths) != bool(part.cells):
        raise RejectedError("a part has either cells with their widths, or regions")
    start = list(numbers(part.cuts))
    if part.regions:
        regions = [each.region for each in part.regions]
        walks = [each.walk for each in part.regions if each.walk is not None]
        if walks and (len(walks) < len(regions) or part.steps != 1):
            raise RejectedError("one step is walked from all regions, or from none")
        by_regions = RegionSweep(profile, system, claim, regions, 0 if walks else part.steps)
        cuts = [list(numbers(each.cuts)) for each in part.regions]
        arriving = by_regions.motion.arriving(start, joined)
        closed = sum(close_branches(profile, *by_regions.one_step(number), walk) for number, walk in enumerate(walks))
        return by_regions.check(arriving, cuts) + closed, by_regions.motion.shows
    sweep = InvariantSweep(profile, system, claim, widths)
    cells = read_cells(numbers(part.cells), len(part.widths))
    sweep.check(sweep.motion.arriving(start, joined), cells, part.steps, seen)
    return len(cells), sweep.motion.shows


def read_cells(given: Iterator[int], variables: int) -> Int64:
    """The cells that numbers stand for, [n, variables]. RejectedError where there are none, or too large ones."""
    lows, spans, span = list[int](), list[int](), 1
    for _ in range(variables):
        low, size = next(given, 0), next(given, 0)
        lows.append(low // 2 if low % 2 == 0 else -(low // 2) - 1)
        spans.append(size)
        span *= size
    steps = list(given)
    if not 0 < span <= MAX_SPAN or not steps or max([*steps, *map(abs, lows)]) >= MAX_SPAN:
        raise RejectedError("the cells of an invariant are out of range")
    keys = np.cumsum(np.array(steps, dtype=np.int64))
    if not ((keys >= 0) & (keys < span)).all():
        raise RejectedError("the cells of an invariant are out of range")
    digits: list[Int64] = []
    for low, size in zip(reversed(lows), reversed(spans), strict=True):
        digits.append(keys % size + low)
        keys = keys // size
    return np.stack(digits[::-1], axis=1)
