"""Invariants as cells: a list of boxes that the system leaves for a few steps at most, and that its start lies in.

Does: moves cells by boxes, asks the claim of all that they become, and whether they come back into the list.
Assumes: images.py, trees.py and cuts.py bound what they are asked.
Does not: read documents, or find a list.

Some variables are followed, all others may be any number. A cell is a box of the followed variables, whole multiples of
a width being the middles; of a mode it is one value, since systems/cases.py shows that a mode has no others.

The invariant holds the states of the cells that meet the claim. If all starts are among them, and if all that such a
state becomes meets the claim until it is in a cell again, within so many steps, then by induction all states of all
episodes meet the claim.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import chain

import numpy as np

from codegen.ir import Bool, Int64, PolicyProfile
from verify.checker.covers.boxes import BoxList, alike_joined, together
from verify.checker.covers.boxes import cut as cut_in_cells
from verify.checker.covers.cuts import RegionCut, linear
from verify.checker.covers.images import PieceImage
from verify.checker.covers.parts import Parts
from verify.checker.covers.rounding import ensure_arithmetic
from verify.checker.covers.stated import StatedStates
from verify.checker.covers.trees import TreeCuts, decided
from verify.checker.reading import RejectedError
from verify.systems.claims import SystemClaim
from verify.systems.system import HalfSpace, System

MAX_STEPS = 8  # out of the list
AT_ONCE = 1 << 14  # cells that are moved together
MAX_SPAN = 1 << 62  # of the numbers of cells


def names_of(half: HalfSpace) -> set[str]:
    """The variables that a half space speaks of."""
    return {name for name, _ in half.form.terms}


class InvariantSweep:
    """Cells of some variables, moved. `widths`: of cells, for each of these. RejectedError where what they become
    depends on others.
    """

    def __init__(self, profile: PolicyProfile, system: System, claim: SystemClaim, widths: Mapping[str, float]) -> None:
        ensure_arithmetic()
        columns = {one.name: column for column, one in enumerate(system.variables)}
        _ensure_closed(system, set(widths))
        self._widths = {columns[name]: width for name, width in widths.items()}
        self._modes = [columns[one.name] in self._widths and bool(one.modes) for one in system.variables]
        self.followed = np.array(list(self._widths), dtype=np.int64)
        self._others = np.array([column for column in columns.values() if column not in self._widths], dtype=np.int64)
        self._trees = [TreeCuts(system, policy, columns) for policy in profile.agents]
        self._pieces = [PieceImage(system, piece, profile.agents, self._trees) for piece in system.pieces]
        self._parts, self._stated = Parts(system), StatedStates(system, claim)
        self.shows = shown_by(claim, set(widths))
        asked = [[linear(half) for half in region if names_of(half) <= set(widths)] for region in claim.regions]
        self._regions = [RegionCut(each, columns) for each in asked] if self.shows else []

    def started(self) -> BoxList:
        """Boxes around all starts."""
        return self._free(together(list(self._parts.parts([0]))))

    def boxes(self, cells: Int64) -> BoxList:
        """Boxes around the states of cells, [n, followed], that meet the claim; `part` is the place of the cell."""
        low = np.zeros((len(cells), len(self._modes)))
        high = low.copy()
        for place, (column, width) in enumerate(self._widths.items()):
            half = 0.0 if self._modes[column] else 0.5
            low[:, column] = (cells[:, place] - half) * width
            high[:, column] = (cells[:, place] + half) * width
        boxes = self._free(BoxList(low, high, np.arange(len(cells)), np.zeros(len(cells), dtype=np.int64)))
        return together([region.within(boxes) for region in self._regions]) if self._regions else boxes

    def in_cells(self, boxes: BoxList) -> tuple[BoxList, Int64]:
        """The boxes cut at the bounds of cells, and the cell of each, [n, followed]."""
        cells = np.zeros((boxes.size, 0), dtype=np.int64)
        for column, width in self._widths.items():
            boxes, cells = cut_in_cells(boxes, cells, column, width)
        return boxes, cells

    def broken(self, boxes: BoxList) -> BoxList:
        """Boxes around the states that may break what these variables are to show."""
        if not self._regions:
            return boxes.taken(slice(0, 0))
        for region in self._regions:
            boxes = region.outside(boxes)
        return boxes

    def moved(self, boxes: BoxList) -> BoxList:
        """Boxes around all next states. RejectedError where some are not finite, or nothing is stated of a state."""
        if self._stated.beyond(boxes.low, boxes.high).any():
            raise RejectedError("a cell may hold states of which nothing is stated")
        boxes = decided(self._trees, boxes)
        boxes = self._free(alike_joined(together([piece.moved(piece.within(boxes)) for piece in self._pieces])))
        if not (np.isfinite(boxes.low) & np.isfinite(boxes.high))[:, self.followed].all():
            raise RejectedError("a box has bounds that are not finite")
        return boxes

    def _free(self, boxes: BoxList) -> BoxList:
        low, high = boxes.low.copy(), boxes.high.copy()
        low[:, self._others], high[:, self._others] = -np.inf, np.inf
        return boxes._replace(low=low, high=high)

    def check(self, cells: Int64, steps: int, watch: Callable[[BoxList], None] | None = None) -> int:
        """How many boxes were asked about. RejectedError where a list of cells is no invariant that shows the claim.

        `watch` is told of the boxes of cells, and of those on the way back to cells: of every state of these that meets
        the claim it is shown that the system keeps it.
        """
        seen = watch or _unseen
        with np.errstate(all="ignore"):  # what overflows is not finite, and is refused
            known, started = Known(cells), self.started()
            self._ensure_meets(started)
            if not known.holds(self.in_cells(started)[1]).all():
                raise RejectedError("a start lies in no cell of the invariant")
            return sum(
                self._followed(cells[begin : begin + AT_ONCE], known, steps, seen)
                for begin in range(0, len(cells), AT_ONCE)
            )

    def _followed(self, cells: Int64, known: Known, steps: int, seen: Callable[[BoxList], None]) -> int:
        boxes = self.boxes(cells)
        asked = boxes.size
        seen(boxes)
        for _ in range(steps):
            boxes = self.moved(boxes)
            self._ensure_meets(boxes)
            boxes, of = self.in_cells(boxes)
            asked += boxes.size
            boxes = boxes.taken(~known.holds(of))
            if not boxes.size:
                return asked
            seen(boxes)
        raise RejectedError("some states may stay out of the invariant")

    def _ensure_meets(self, boxes: BoxList) -> None:
        found = self.broken(boxes).size
        if found:
            raise RejectedError(f"{found:,} boxes of the invariant may hold states that break the claim")


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
        """Which cells are in the list, [n]."""
        inside = np.asarray(((cells >= self._low) & (cells <= self._high)).all(axis=1), dtype=np.bool_)
        found = inside.copy()
        found[inside] = np.isin(self._key(cells[inside]), self._keys)
        return found


def shown_by(claim: SystemClaim, followed: set[str]) -> frozenset[int]:
    """Which half spaces of a claim's one region some variables decide; of several regions all or none."""
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
