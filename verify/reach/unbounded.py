"""Claims about all steps, decided by invariants: cells that grow from the start, or regions.

Does: asks for which variables an invariant is needed, at last for all that trees test; tries the regions that a user
  gives, those of the claim, then cells, wide ones first: it adds what the cells of the first step become until none is
  new; cuts regions in half where a part of them may leave (k-induction); has the checker accept what was found, or says
  which state leaves, and where it goes.
Assumes: a checked system; a claim about all steps. The checker's arithmetic moves cells and parts, and is asked again.
Does not: look for counterexamples but along cells that grew, or for regions, or shrink a region until it is closed.
  What is left of a region whose cells are removed once they leave holds all cells that grow from the start, so with the
  same cells that shows nothing that growing does not.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from functools import cached_property
from itertools import chain, pairwise, product
from math import floor, log2
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from codegen.ir import Float64, Int64, PolicyProfile
from verify.certificates.proofs import encode_numbers
from verify.checker.certificate import numbers
from verify.checker.covers.boxes import BoxList, Parts, StartBox, together
from verify.checker.covers.images import BoxMotion
from verify.checker.covers.invariants import FollowedMotion, InvariantSweep, RegionSweep, names_of, read_cells
from verify.checker.reading import RejectedError
from verify.checker.systems.proofs import WHOLE, Invariant, InvariantPart, InvariantRegion
from verify.checker.systems.reading import Branch, sides_of
from verify.claims.formula import conjunction, coordinates, disjunction, holds
from verify.reach.covering import POINTS, CutPart, close_names, estimate_ranges, set_anew
from verify.reach.programs import inhabitant, prove
from verify.reach.replay import take_step
from verify.reach.results import OpenState, ReachOutcome, SystemCounterexample, about_nothing
from verify.reach.search import ReachBudgetError, SystemProver, Unfolding
from verify.reach.trace import trace_cells
from verify.result import Verdict
from verify.spending import Spending, tell
from verify.systems.claims import SystemClaim, atom
from verify.systems.system import Polytope, System

Bounds = Mapping[str, tuple[float, float]]


class LeftError(RejectedError):
    """The checker refuses a set that leaves what is allowed. `cell` and `to`: bounds of it, and of where it goes;
    `step`: of an episode, 0 where that is any; `exact`: a state and where it goes, where these were played; `breaks`:
    it may break the claim itself; `begins`: an episode may begin outside; `found`: an episode that breaks the claim.
    """

    def __init__(
        self,
        cell: Bounds,
        to: Bounds,
        step: int = 0,
        exact: tuple[Mapping[str, Fraction], Mapping[str, Fraction]] | None = None,
        breaks: bool = False,
        begins: bool = False,
        found: SystemCounterexample | None = None,
    ) -> None:
        super().__init__("a set leaves")
        self.cell, self.to, self.step, self.exact, self.found = cell, to, step, exact, found
        self.breaks, self.begins = breaks, begins

    @property
    def words(self) -> str:
        """Where the set may go, or where a state of it does go."""
        if self.breaks:
            return "a state of the cell below may lie outside of the claim's region"
        if self.exact is None:
            ends = ", ".join(f"{name} in [{low:.4g}, {high:.4g}]" for name, (low, high) in self.to.items())
            return f"a state of the cell below may go to {ends}"
        state, after = (", ".join(f"{name} {float(value):.6g}" for name, value in each.items()) for each in self.exact)
        return f"{state} goes to {after}"


POWERS = (3, 4, 5, 6, 7, 8)  # of two: cells in the range of a variable
STEPS = (1, 4, 8)  # out of the list
MAX_CELLS, MAX_TRIED = 60_000, 400_000  # of one list; boxes that one list may take
SHARE = 16  # the part of the budget that these may take
ATTEMPT = 500  # boxes that take as long as all else of a list that is tried
TIMES, JOINED = (0, 6, 12), 6  # how often the start is cut on the way to a later step; the power of joined cells there
Cell = tuple[int, ...]
NO_CELLS = frozenset[Cell]()


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
        self._columns = {one.name: at for at, one in enumerate(system.variables)}
        self._starting = dict.fromkeys(self._columns, 0.0)
        self._start: StartBox | None = None  # None: of numbers that the arithmetic does not hold
        with suppress(RejectedError):
            self._start = Parts(system).whole or StartBox(np.zeros(len(self._columns)), np.zeros(len(self._columns)))
            ends = zip(self._columns, self._start.low.tolist(), self._start.high.tolist(), strict=True)
            self._starting = {name: high - low for name, low, high in ends}
        self._played = min(POINTS, max(most // (SHARE * (claim.steps + 1)), 1))

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
                        if left.found is not None:
                            return None
                    except RejectedError:  # not finite, too many, or nothing is stated
                        continue
        return None

    def grow(self, part: InvariantPart) -> InvariantPart:
        """An invariant that grows from the cells of another one. LeftError, RejectedError."""
        known = _cells(read_cells(numbers(part.cells), len(part.widths)))
        return self._close_cells(part.widths, part.steps, Approach(part.cuts, part.joined), known)

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

    def _close_cells(
        self, widths: Mapping[str, Fraction], steps: int, approach: Approach, begun: AbstractSet[Cell] = NO_CELLS
    ) -> InvariantPart:
        """Cells that nothing leaves for more than some steps, those that were `begun` with among them. LeftError,
        RejectedError.
        """
        names, floats = tuple(widths), {name: float(width) for name, width in widths.items()}
        with np.errstate(all="ignore"):
            if names not in self._sweeps:
                self._sweeps[names] = InvariantSweep(self._profile, self._system, self._claim, floats)
            sweep = self._sweeps[names].of_widths(floats)
            arriving = collect_arriving(sweep.motion, approach, self.most - self.spent)
            broken = sweep.motion.find_breaking(arriving)
            if broken.size:
                raise LeftError(bounds_of(sweep.motion, arriving), bounds_of(sweep.motion, broken), self._claim.by)
            known = _cells(sweep.in_cells(arriving)[1])
            before, came = self.spent, dict[Cell, Cell]()
            if not known:  # the claim speaks of no episode for so long, so there is nothing to hold
                raise RejectedError("no state at the first step is spoken of")
            known = fresh = known | begun
            while fresh:
                cells = np.array(sorted(fresh), dtype=np.int64)
                if self.spent - before > MAX_TRIED or self.spent > self.most:
                    raise self._make_left_error(sweep, cells[:1], sweep.motion.move_boxes(sweep.boxes(cells[:1])))
                fresh = self._becoming(sweep, cells, known, steps, came)
                known |= fresh
        # as numbers, as checker/covers/invariants.py reads them
        grown = np.array(sorted(known), dtype=np.int64)
        lows, spans = grown.min(axis=0).tolist(), (grown.max(axis=0) - grown.min(axis=0) + 1).tolist()
        keys = np.zeros(len(grown), dtype=np.int64)
        for place, (low, span) in enumerate(zip(lows, spans, strict=True)):
            keys = keys * span + (grown[:, place] - low)
        ordered = sorted(keys.tolist())
        zigzag = [2 * low if low >= 0 else -2 * low - 1 for low in lows]
        heads = [number for pair in zip(zigzag, spans, strict=True) for number in pair]
        told = encode_numbers([*heads, ordered[0], *(after - before for before, after in pairwise(ordered))])
        return InvariantPart(dict(widths), steps, told, (), approach.cuts, approach.joined)

    def _becoming(
        self, sweep: InvariantSweep, cells: Int64, known: set[Cell], steps: int, came: dict[Cell, Cell]
    ) -> set[Cell]:
        """The new cells that cells become after some steps. LeftError where one leaves. `came`: each with the cell that
        it comes from, where that takes one step.
        """
        boxes = sweep.boxes(cells)
        for step in range(1, steps + 1):
            boxes = sweep.motion.move_boxes(boxes)
            broken = sweep.motion.find_breaking(boxes)
            if broken.size:
                found = self._trace(sweep, cells[broken.part[0]], came) if steps == 1 else None
                raise self._make_left_error(sweep, cells, broken, found)
            boxes, of = sweep.in_cells(boxes)
            self.spent += boxes.size
            tell(min(self.spent, self.most), self.most, "boxes")
            new = np.array([tuple(each) not in known for each in of.tolist()], dtype=np.bool_)
            boxes, of = boxes.take(new), of[new]
            if boxes.size and (boxes.size > MAX_TRIED or len(known) > MAX_CELLS or self.spent > self.most):
                raise self._make_left_error(sweep, cells, boxes)
            if steps == 1:
                for after, place in zip(of.tolist(), boxes.part.tolist(), strict=True):
                    came.setdefault(tuple(after), tuple(cells[place].tolist()))
            if step == steps or not boxes.size:
                return _cells(of)
        return set()

    def _trace(self, sweep: InvariantSweep, last: Int64, came: Mapping[Cell, Cell]) -> SystemCounterexample | None:
        """An episode through the cells that led to the last one, and then out of the claim's region."""
        cells = [tuple(last.tolist())]
        while cells[-1] in came:
            cells.append(came[cells[-1]])
        bounds = [bounds_of(sweep.motion, sweep.boxes(np.array([cell]))) for cell in reversed(cells)]

        def is_inside(state: State, place: int) -> bool:
            return all(low <= state[name] <= high for name, (low, high) in bounds[place].items())

        if self._claim.by or self._start is None or len(cells) > self._claim.steps:
            return None
        ends = zip(self._columns, self._start.low.tolist(), self._start.high.tolist(), strict=True)
        start = {name: (Fraction(low), Fraction(high)) for name, low, high in ends}
        return trace_cells(self._profile, self._system, self._claim, start, len(cells), is_inside)

    def _make_left_error(
        self, sweep: InvariantSweep, cells: Int64, to: BoxList, found: SystemCounterexample | None = None
    ) -> LeftError:
        """That a state of a cell goes to where it may not, or goes on and on."""
        cell = sweep.boxes(cells[to.part[:1]])
        return LeftError(bounds_of(sweep.motion, cell), bounds_of(sweep.motion, to), found=found)

    @cached_property
    def _scale(self) -> Float64:
        """Estimates how far each variable ranges in some episodes, at most as far as the claim's region reaches."""
        with suppress(RejectedError):  # numbers that the arithmetic does not hold
            motion = BoxMotion(self._profile, self._system)
            if self._start is not None:
                return estimate_ranges(motion, self._start, self._played, self._claim.steps)
        return np.zeros(len(self._columns))


def _cells(cells: Int64) -> set[Cell]:
    return {tuple(map(int, each)) for each in cells}


MAX_PARTS = 1 << 14  # of one region
MAX_STATES, MAX_PROGRAMS = 400, 1_500  # symbolic states and linear programs of one step from one region
PLAYED, CORNERS = 2, 16  # parts of one level of which some states are played; corners of these
ENDS = (Fraction(0), Fraction(-(10**18)), Fraction(10**18))  # of errors, each cut to its bounds
State = Mapping[str, Fraction]


class RegionSearch:
    """The question whether regions are an invariant, with some numbers of steps in a row. `spent`: boxes so far;
    `walking`: what steps by exact rows took.
    """

    def __init__(
        self, profile: PolicyProfile, system: System, claim: SystemClaim, regions: Sequence[Polytope], most: int
    ) -> None:
        self._profile, self._system, self._claim, self._most = profile, system, claim, most
        self._regions = tuple(regions)
        self._erring = any(piece.error for piece in system.pieces)
        self._inside = disjunction(*(conjunction(*map(atom, region)) for region in regions))
        self.spent = 0
        self.walking = Spending(0)

    def part(self, steps: int, approaches: Sequence[Approach], left: int | None = None) -> InvariantPart:
        """The regions as an invariant. `left`: one step is followed by exact rows, which may take what boxes leave of
        so many; None: boxes show all. LeftError for a part of them that leaves, RejectedError where they are none for
        another reason.
        """
        sweep = RegionSweep(self._profile, self._system, self._claim, self._regions, steps if left is None else 0)
        numbers, walks = range(len(self._regions)), list[bytes | None]([None] * len(self._regions))
        with np.errstate(all="ignore"):
            approach = self._approach(sweep, steps, approaches)
            cuts = [self._cuts(sweep, number, steps) for number in numbers]
        if left is not None:
            self.walking = Spending(left)
            walks = [self._walk(sweep, number) for number in numbers]
        regions = tuple(map(InvariantRegion, self._regions, cuts, walks))
        return InvariantPart({}, steps, b"", regions, approach.cuts, approach.joined)

    def _walk(self, sweep: RegionSweep, number: int) -> bytes:
        """The proof of one step from a region. RejectedError where there is none."""
        begun, claim, part = sweep.one_step(number)
        prover = SystemProver(MAX_STATES, MAX_PROGRAMS, _refuse, left=max(self.walking.left - self.spent, 0))
        try:
            return Unfolding(self._profile, begun, claim, part, prover).run(None).proof
        except ReachBudgetError:
            raise RejectedError("one step takes too many symbolic states") from None
        finally:
            self.walking.states += prover.states
            self.walking.programs += prover.programs.solved

    def _approach(self, sweep: RegionSweep, steps: int, approaches: Sequence[Approach]) -> Approach:
        """The first way to the first step that ends in the regions. LeftError, RejectedError of the last one."""
        for approach in approaches[:-1]:
            with suppress(LeftError, RejectedError):
                self._ensure_begun(sweep, steps, approach)
                return approach
        self._ensure_begun(sweep, steps, approaches[-1])
        return approaches[-1]

    def _ensure_begun(self, sweep: RegionSweep, steps: int, approach: Approach) -> None:
        """LeftError where a state at the first steps may lie outside of the regions."""
        motion = sweep.motion
        boxes = collect_arriving(motion, approach, self._most - self.spent)
        for step in range(steps):
            boxes = motion.move_boxes(boxes) if step else boxes
            self.spent += boxes.size
            outside = sweep.regions.outside(boxes)
            if outside.size:
                at = self._claim.by + step
                raise LeftError(bounds_of(motion, boxes), bounds_of(motion, outside), at, begins=True)

    def _cuts(self, sweep: RegionSweep, number: int, steps: int) -> bytes:
        """Cuts a region so that no part leaves, and returns the encoded cuts. LeftError, RejectedError."""
        whole = sweep.parts[number].whole
        if whole is None:
            raise RejectedError("a region of the invariant is empty")
        root, count, weights = CutPart(whole), 1, np.zeros(len(whole.low))
        weights[sweep.motion.followed] = 1.0
        open_: list[CutPart] = [root]
        while open_:
            boxes = sweep.parts[number].box_starts([node.box for node in open_])
            self.spent += boxes.size
            tell(min(self.spent, self._most), self._most, "boxes")
            left = np.zeros(len(open_), dtype=np.bool_)
            left[sweep.find_open_parts(boxes)] = True
            open_ = [open_[place] for place in np.flatnonzero(left)]
            self._ensure_none_leaves(open_, steps)
            count += len(open_)
            if open_ and (count > MAX_PARTS or self.spent > self._most):
                raise self._leaving(sweep, number, open_[0])
            for node in open_:
                if not node.cut(whole, weights, MAX_PARTS):
                    raise self._leaving(sweep, number, node)
            open_ = [each for node in open_ for each in node.halves]
        return root.cuts

    def _leaving(self, sweep: RegionSweep, number: int, node: CutPart) -> LeftError:
        """A part that may leave, and where it may go."""
        boxes = sweep.motion.by_modes(sweep.motion.restrict_boxes(sweep.parts[number].box_starts([node.box])))
        if sweep.motion.find_breaking(boxes).size:
            broken = bounds_of(sweep.motion, sweep.motion.find_breaking(boxes))
            return LeftError(broken, broken, breaks=True)
        to = boxes
        if not sweep.motion.is_unstated(boxes).any():
            moved = sweep.motion.move_boxes(boxes)
            outside = sweep.regions.outside(moved)
            to = outside if outside.size else moved
        return LeftError(bounds_of(sweep.motion, boxes), bounds_of(sweep.motion, to if to.size else boxes))

    def _ensure_none_leaves(self, nodes: Sequence[CutPart], steps: int) -> None:
        """LeftError for a state of a part that stays in the regions for some steps, and then leaves."""
        for node in nodes[:PLAYED]:
            for point, end in product(_points(node.box), ENDS if self._erring else ENDS[:1]):
                named = zip(self._system.variables, point.tolist(), strict=True)
                start = {one.name: Fraction(round(at)) if one.modes else Fraction(at) for one, at in named}
                states = self._play_from(start, steps, end)
                if states is not None:
                    shown = {name for region in self._regions for half in region for name, _ in half.form.terms}
                    state, after = ({name: each[name] for name in each if name in shown} for each in states[-2:])
                    cell = {name: (float(value), float(value)) for name, value in state.items()}
                    to = {name: (float(value), float(value)) for name, value in after.items()}
                    raise LeftError(cell, to, exact=(state, after))

    def _play_from(self, state: dict[str, Fraction], steps: int, end: Fraction) -> list[State] | None:
        """The states from one that stay in the regions until the last one leaves; None where these do not."""
        states: list[State] = [state]
        for step in range(steps + 1):
            here = states[-1]
            if not holds(self._claim.spoken_of, here, {}):
                return None
            if not holds(self._inside, here, {}):
                return states if step == steps else None
            taken = take_step(self._profile, self._system, here, dict.fromkeys(here, end)) if step < steps else None
            if taken is None:
                return None
            states.append(taken.after)
        return None


def _refuse(branch: Branch, stated: bool) -> None:
    raise RejectedError("a step may leave the regions")


def _points(box: StartBox) -> Iterator[Float64]:
    """The middle of a part, and some corners."""
    yield 0.5 * box.low + 0.5 * box.high
    wide = np.flatnonzero(box.high > box.low)
    for number in range(min(CORNERS, 2 ** len(wide))):
        corner = box.low.copy()
        upper = [column for place, column in enumerate(wide) if number >> place & 1]
        corner[upper] = box.high[upper]
        yield corner


IN_A_ROW = (1, 2, 4, 8)  # states in regions, from which another one is to follow; what fewer show, more show too
FEW, LATER = 4_096, 8  # boxes of the first question about a claim's own regions; the part of all boxes of later ones
HELPS = ("a larger region, or a smaller start region", "another region that episodes stay in, as `invariant`")
CHANGED = ("another invariant, or none, so that one is looked for",)
SPENT = "a larger --effort"
NOTHING = frozenset[str]()


class InvariantSearch:
    """The answer to one claim. `left`: what leaves; `given`: what leaves the invariant that a user gives."""

    def __init__(self, profile: PolicyProfile, system: System, claim: SystemClaim, most: int) -> None:
        self._profile, self.system, self.claim, self._most = profile, system, claim, most
        self._anew = set_anew(system)
        self._tests = [names_of(half) for region in claim.assuming for half in region]
        for policy in profile.agents:
            known = system.features[policy.agent]
            self._tests += [{name for name, _ in known[each.name].form.terms} for each in policy.features]
        self._remembered = [{f"{policy.agent}.{each.name}" for each in policy.memory} for policy in profile.agents]
        self._cells = CellSearch(profile, system, claim, most)
        self._by_regions, self.walking = 0, Spending(most)
        self.left: LeftError | None = None
        self.given: LeftError | None = None

    @property
    def found(self) -> SystemCounterexample | None:
        """An episode that breaks the claim."""
        return self._cells.left.found if self._cells.left else None

    @property
    def spent(self) -> int:
        """Boxes so far, and what steps by exact rows took, in boxes."""
        return self.boxes + self.walking.total

    @property
    def boxes(self) -> int:
        """Boxes so far."""
        return self._cells.spent + self._by_regions

    def add_spending(self, outcome: ReachOutcome) -> ReachOutcome:
        """An outcome with what was spent."""
        return replace(outcome, boxes=self.boxes, states=self.walking.states, programs=self.walking.programs)

    def iterate_invariants(self) -> Iterator[tuple[InvariantPart, ...]]:
        """Lists of parts, each of which may show the whole claim, in the order in which they are tried."""
        if self.claim.invariant:
            part = self._of_regions(self.claim.invariant, IN_A_ROW[:1], min(FEW, self._most), walked=True)
            left = max(self._most - self.walking.total, 0)
            part = self._of_regions(self.claim.invariant, IN_A_ROW, left) if part is None else part
            self.given, self.left = self.left, None
            if part is not None:
                yield (part,)
        sides = chain.from_iterable(sides_of(self.system, each).values() for each in self._profile.agents)
        tested = frozenset(chain.from_iterable(map(coordinates, sides))) - self._anew
        tried: list[list[tuple[str, ...]]] = []
        for joined, beside in ((False, NOTHING), (True, NOTHING), (True, tested)):
            groups = self._groups(joined, beside)
            if groups in tried:
                continue
            tried.append(groups)
            parts = [self._part(names) for names in groups]
            if self.found is not None:
                return
            shown = tuple(part for part in parts if part is not None)
            if len(shown) == len(parts):
                yield shown

    def _part(self, names: tuple[str, ...]) -> InvariantPart | None:
        """An invariant of some variables."""
        asked = tuple(tuple(half for half in region if names_of(half) <= set(names)) for region in self.claim.regions)
        usable = all(asked) and {name for region in asked for half in region for name in names_of(half)} == set(names)
        part = self._of_regions(asked, IN_A_ROW[:1], min(FEW, self._most)) if usable else None
        if part is None:
            part = self._cells.part(names)
            self.left = self._cells.left or self.left
        later = usable and part is None
        return self._of_regions(asked, IN_A_ROW[1:], self._most // LATER) if later else part

    def _of_regions(
        self, regions: Sequence[Polytope], in_a_row: Sequence[int], most: int, walked: bool = False
    ) -> InvariantPart | None:
        """Regions as an invariant, where they are one. `walked`: where exact rows show one step from them."""
        named = {name for region in regions for half in region for name in names_of(half)}
        approaches = self._cells.approaches([one.name for one in self.system.variables if one.name in named])
        for steps in in_a_row:
            search = RegionSearch(self._profile, self.system, self.claim, regions, most)
            try:
                return search.part(steps, approaches, max(self._most - self.spent, 0) if walked else None)
            except LeftError as left:
                self.left = left if not walked and (self.left is None or left.exact is not None) else self.left
                if left.begins:  # more steps ask for more
                    break
            except RejectedError:  # not bounded, not finite, or too many
                pass
            finally:
                self._by_regions += search.spent
                self.walking.states += search.walking.states
                self.walking.programs += search.walking.programs
                self._cells.most = max(self._cells.most - search.walking.total, 0)
        return None

    def _groups(self, joined: bool, beside: frozenset[str]) -> list[tuple[str, ...]]:
        """The variables that halves of the claim need, with all that these depend on. `joined`: and all that stand
        in one test with them; `beside`: and these.
        """
        regions = self.claim.regions
        halves = [names_of(half) for half in regions[0]] if len(regions) == 1 else []
        asked = halves or [{name for region in regions for half in region for name in names_of(half)}]
        groups: list[set[str]] = []
        for names in asked:
            closed = {*names, *beside}.union(*(piece.where for piece in self.system.pieces))
            closed = closed.union(*(names_of(half) for piece in self.system.pieces for half in piece.when))
            before = -1
            while len(closed) > before:
                before = len(closed)
                closed = close_names(self.system, closed, self._tests if joined else ())
                # a rounding that is tested with them alone is one cell more, and without it the test would be open
                closed = closed.union(*(test for test in self._tests if test - self._anew <= closed and test & closed))
                # one action sets all that is remembered
                closed = closed.union(*(kept for kept in self._remembered if kept & closed))
            if not any(closed <= other for other in groups):
                groups = [other for other in groups if not other <= closed] + [closed]
        return [tuple(one.name for one in self.system.variables if one.name in names) for names in groups]


def lasting(profile: PolicyProfile, system: System, claim: SystemClaim, most: int) -> ReachOutcome:
    """The answer, after about so many boxes at most."""
    search = InvariantSearch(profile, system, claim, most)
    for parts in search.iterate_invariants():
        with suppress(RejectedError):
            return search.add_spending(prove(profile, system, claim, Invariant(parts)))
    if search.found is not None:
        return search.add_spending(ReachOutcome(Verdict.VIOLATED, counterexample=search.found))
    if inhabitant(system, claim) is Verdict.VACUOUS:
        return search.add_spending(about_nothing(claim, Verdict.VACUOUS))

    # no answer, with the state that leaves and where it goes
    left = search.given or search.left
    helps = (*(CHANGED if search.given else ()), *HELPS)
    helps = (*helps, SPENT) if search.spent >= most else helps
    said = f"no invariant was found after {replace(search.walking, boxes=search.boxes).words}"
    if left is None:
        return search.add_spending(ReachOutcome(Verdict.UNKNOWN, said, None, helps))
    said = f"{said}; the one that is given is none: {left.words}" if search.given else f"{said}: {left.words}"
    return search.add_spending(ReachOutcome(Verdict.UNKNOWN, said, OpenState(left.step, left.cell), helps))
