"""Invariants as regions: whether some regions are one, by k-induction.

Does: cuts regions in half where a part of them may leave; plays states of such parts, and says which state leaves.
Assumes: a checked system; a claim about all steps. The checker's arithmetic moves parts, and is asked again.
Does not: look for regions: they are a user's, or those of the claim.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from fractions import Fraction
from itertools import product

import numpy as np

from codegen.ir import Bool, Float64, PolicyProfile
from verify.certificates.proofs import encode_numbers
from verify.checker.covers.invariants import RegionSweep, outside_of
from verify.checker.covers.parts import StartBox
from verify.checker.reading import RejectedError
from verify.checker.systems.proofs import InvariantPart, InvariantRegion
from verify.checker.systems.rows import Branch
from verify.claims.formula import conjunction, disjunction, holds
from verify.progress import tell
from verify.reach.covering import CutPart
from verify.reach.forever.cells import Approach, bounds_of, collect_arriving
from verify.reach.forever.leaving import LeftError
from verify.reach.replay import piece_of
from verify.reach.search import ReachBudgetError, SystemProver
from verify.reach.unfolding import Unfolding
from verify.spending import Spending
from verify.systems.claims import SystemClaim, atom
from verify.systems.observing import choose_actions
from verify.systems.system import Polytope, System

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

    def part(self, steps: int, approaches: Sequence[Approach]) -> InvariantPart:
        """The regions as an invariant. LeftError for a part of them that leaves, RejectedError where they are none for
        another reason.
        """
        sweep = RegionSweep(self._profile, self._system, self._claim, self._regions, steps)
        with np.errstate(all="ignore"):
            approach = self._approach(sweep, steps, approaches)
            cuts = [self._cuts(sweep, number, steps) for number in range(len(self._regions))]
        regions = tuple(map(InvariantRegion, self._regions, cuts))
        return InvariantPart({}, steps, b"", regions, approach.cuts, approach.joined)

    def walk_regions(self, approaches: Sequence[Approach], left: int) -> InvariantPart:
        """The same where one step is followed by exact rows, which may take what boxes leave of so many. LeftError,
        RejectedError.
        """
        self.walking = Spending(left)
        sweep = RegionSweep(self._profile, self._system, self._claim, self._regions, 0)
        with np.errstate(all="ignore"):
            approach = self._approach(sweep, 1, approaches)
            cuts = [self._cuts(sweep, number, 1) for number in range(len(self._regions))]
        walks = [self._walk(sweep, number) for number in range(len(self._regions))]
        regions = tuple(map(InvariantRegion, self._regions, cuts, walks))
        return InvariantPart({}, 1, b"", regions, approach.cuts, approach.joined)

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
            outside = outside_of(sweep.regions, boxes)
            if outside.size:
                at = self._claim.by + step
                raise LeftError(bounds_of(motion, boxes), bounds_of(motion, outside), at, begins=True)

    def _cuts(self, sweep: RegionSweep, number: int, steps: int) -> bytes:
        """Cuts a region so that no part leaves, and returns the encoded cuts. LeftError, RejectedError."""
        whole = sweep.parts[number].whole
        if whole is None:
            raise RejectedError("a region of the invariant is empty")
        root, count = CutPart(whole), 1
        open_: list[CutPart] = [root]
        while open_:
            left = self._mark_leaving(sweep, number, open_)
            open_ = [open_[place] for place in np.flatnonzero(left)]
            self._ensure_none_leaves(open_, steps)
            count += len(open_)
            if open_ and (count > MAX_PARTS or self.spent > self._most):
                raise self._leaving(sweep, number, open_[0])
            for node in open_:
                node.cut(self._column(sweep, node.box, whole))
            open_ = [each for node in open_ for each in node.halves]
        return encode_numbers(root.cuts())

    def _mark_leaving(self, sweep: RegionSweep, number: int, nodes: Sequence[CutPart]) -> Bool:
        """Marks the parts that may leave, [n]."""
        boxes = sweep.parts[number].box_starts([node.box for node in nodes])
        self.spent += boxes.size
        tell(min(self.spent, self._most), self._most, "boxes")
        left = np.zeros(len(nodes), dtype=np.bool_)
        left[sweep.find_open_parts(boxes)] = True
        return left

    def _column(self, sweep: RegionSweep, box: StartBox, whole: StartBox) -> int:
        """The followed variable along which a part is widest, beside the region."""
        columns = sweep.motion.followed
        widths = np.where(whole.high > whole.low, (box.high - box.low) / (whole.high - whole.low), 0.0)[columns]
        return int(columns[int(widths.argmax())])

    def _leaving(self, sweep: RegionSweep, number: int, node: CutPart) -> LeftError:
        """A part that may leave, and where it may go."""
        boxes = sweep.motion.by_modes(sweep.motion.restrict_boxes(sweep.parts[number].box_starts([node.box])))
        if sweep.motion.find_breaking(boxes).size:
            broken = bounds_of(sweep.motion, sweep.motion.find_breaking(boxes))
            return LeftError(broken, broken, breaks=True)
        to = boxes
        if not sweep.motion.is_unstated(boxes).any():
            moved = sweep.motion.move_boxes(boxes)
            outside = outside_of(sweep.regions, moved)
            to = outside if outside.size else moved
        return LeftError(bounds_of(sweep.motion, boxes), bounds_of(sweep.motion, to if to.size else boxes))

    # --- states of parts, in exact numbers

    def _ensure_none_leaves(self, nodes: Sequence[CutPart], steps: int) -> None:
        """LeftError for a state of a part that stays in the regions for some steps, and then leaves."""
        for node in nodes[:PLAYED]:
            for point, end in product(_points(node.box), ENDS if self._erring else ENDS[:1]):
                states = self._play_from(self._state(point), steps, end)
                if states is not None:
                    shown = {name for region in self._regions for half in region for name, _ in half.form.terms}
                    state, after = ({name: each[name] for name in each if name in shown} for each in states[-2:])
                    cell = {name: (float(value), float(value)) for name, value in state.items()}
                    to = {name: (float(value), float(value)) for name, value in after.items()}
                    raise LeftError(cell, to, exact=(state, after))

    def _state(self, point: Float64) -> dict[str, Fraction]:
        """A state as exact numbers; a mode at the nearest of its values."""
        named = zip(self._system.variables, point.tolist(), strict=True)
        return {one.name: Fraction(round(value)) if one.modes else Fraction(value) for one, value in named}

    def _play_from(self, state: dict[str, Fraction], steps: int, end: Fraction) -> list[State] | None:
        """The states from one that stay in the regions until the last one leaves; None where these do not."""
        states: list[State] = [state]
        for step in range(steps + 1):
            here = states[-1]
            if not holds(self._claim.spoken_of, here, {}):
                return None
            if not holds(self._inside, here, {}):
                return states if step == steps else None
            number = piece_of(self._system, here)
            if step == steps or number is None:
                return None
            piece, actions = self._system.pieces[number], choose_actions(self._system, self._profile, here)
            joint = {one.agent: one.actions[actions[one.agent]].name for one in self._profile.agents}
            error = {name: min(max(end, low), high) for name, (low, high) in piece.error.items()}
            states.append(piece.step(here, joint, error))
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
