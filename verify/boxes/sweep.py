"""Which parts of the start are shown by boxes: all parts and all claims are followed at once, until a limit stops them.

Does: follows boxes step by step; tells for each claim which parts are left open, and how many boxes that took.
Assumes: claims about episodes of steps.
Does not: choose parts or cells (covering.py).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from codegen.ir import Bool, Float64
from codegen.numbers.rounding import nearest_double
from verify.boxes.model import Model
from verify.boxes.rows import Half, Rows, cells_of, in_cells, join_rows
from verify.systems.claims import SystemClaim
from verify.systems.system import System

MAX_AT_ONCE = 200_000  # boxes of one list


@dataclass(frozen=True)
class Swept:
    """What a sweep says: which parts of the start are left open, [claims, parts]; how many boxes it took; whether it
    was stopped by what it was allowed.
    """

    open: Bool
    boxes: int
    stopped: bool = False


class _ClaimRegions:
    """A claim, with its regions as inequalities. `place` numbers those that one state fulfils, from 0."""

    def __init__(self, model: Model, claim: SystemClaim, place: int) -> None:
        self.claim, self.place = claim, place
        self.regions = [model.region(region) for region in claim.regions]


class Sweep:
    """Boxes for all claims about a team in a system."""

    def __init__(self, model: Model, system: System, claims: Sequence[SystemClaim]) -> None:
        self._model = model
        once = [claim.says.once for claim in claims]
        self._claims = [_ClaimRegions(model, claim, sum(once[:number])) for number, claim in enumerate(claims)]
        self._fulfillable = sum(once)
        self._stated = _bound_pieces(model, system)

    def run(
        self, parts: tuple[Float64, Float64], widths: Mapping[int, float], most: int, asked: Sequence[int] | None = None
    ) -> Swept:
        """Follows parts of the start, bounds [parts, variables], with at most so many boxes. `asked`: the numbers of
        the claims that are asked about, where these are not all; the others are left open.
        """
        rows = Rows.of(*parts, self._fulfillable)
        follow = _Following(rows, self._claims, range(len(self._claims)) if asked is None else asked)
        with np.errstate(all="ignore"):  # boxes that overflow are left open
            self._follow(follow, widths, most)
        return Swept(follow.open, follow.boxes, follow.stopped)

    def _follow(self, at: _Following, widths: Mapping[int, float], most: int) -> None:
        last = max((self._claims[number].claim.steps for number in at.asked), default=0)
        for step in range(last + 1):
            wild = np.asarray(~np.isfinite(at.rows.low.sum(axis=1) + at.rows.high.sum(axis=1)), dtype=np.bool_)
            if wild.any():
                at.leave(at.asked, wild)
                at.rows = at.rows.at(~wild)
            if widths and cells_of(at.rows, widths) > MAX_AT_ONCE:
                at.leave(at.asked, None)
                return
            at.rows = in_cells(at.rows, widths) if widths else at.rows
            at.boxes += at.rows.size
            for number in at.asked:
                self._ask(at, number, step)
            going = [number for number in at.asked if self._claims[number].claim.steps > step]
            if going and self._stated is not None:
                low, high = self._stated
                within = (at.rows.low >= low) & (at.rows.high <= high)
                at.leave(going, np.asarray(~within.all(axis=1), dtype=np.bool_))
            at.asked = going
            at.keep()
            if not at.rows.size:
                return
            at.rows = self._model.step_boxes(at.rows)
            if at.boxes + at.rows.size > most or at.rows.size > MAX_AT_ONCE:
                at.stopped = at.boxes + at.rows.size > most
                at.leave(at.asked, None)
                return

    def _ask(self, at: _Following, number: int, step: int) -> None:
        """Leaves open the parts whose boxes may break a claim at a step."""
        one = self._claims[number]
        says, claim = one.claim.says, one.claim
        if says.avoided:
            for region in one.regions:
                at.leave_parts(number, _within(at.rows, region))
        elif says.once:
            at.rows = self._split_at_regions(at.rows, one, len(at.asked) > 1)
            if step == claim.steps:
                at.leave_parts(number, at.rows.at(~at.rows.met[:, one.place]))
        elif step >= claim.by:
            outside = at.rows
            for region in one.regions:
                outside = _outside(outside, region)
            at.leave_parts(number, outside)

    @staticmethod
    def _split_at_regions(rows: Rows, one: _ClaimRegions, kept: bool) -> Rows:
        """The boxes cut at the regions of a claim that one state fulfils. `kept`: with what lies inside, as met."""
        met = rows.met[:, one.place]
        before, outside = rows.at(met), rows.at(~met)
        parts = [before]
        for region in one.regions:
            inside = _within(outside, region)
            if kept and inside.size:
                inside = inside.at(slice(None))
                inside.met[:, one.place] = True
                parts.append(inside)
            outside = _outside(outside, region)
        return join_rows([*parts, outside])

    def estimate_ranges(self, low: Float64, high: Float64) -> Float64:
        """How far each variable ranges in the episodes from some boxes, about, [variables]."""
        rows = Rows.of(low, high)
        least, most = low.min(axis=0), high.max(axis=0)
        for _ in range(max((one.claim.steps for one in self._claims), default=0)):
            rows = self._model.step_boxes(rows)
            rows = rows.at(np.linspace(0, rows.size - 1, min(rows.size, 2 * len(low))).astype(np.int64))
            if not rows.size:
                break
            least, most = np.minimum(least, rows.low.min(axis=0)), np.maximum(most, rows.high.max(axis=0))
        return most - least


class _Following:
    """A sweep under way: its boxes, the claims that are still asked about, and the parts that are left open."""

    def __init__(self, rows: Rows, claims: Sequence[_ClaimRegions], asked: Sequence[int]) -> None:
        self.rows, self._claims, self.asked = rows, claims, list(asked)
        self.boxes, self.stopped = 0, False
        self.open = np.ones((len(claims), rows.size), dtype=np.bool_)
        self.open[self.asked] = False

    def leave(self, claims: Sequence[int], bad: Bool | None) -> None:
        """Leaves open the parts of some boxes (None: of all), for each claim that these do not fulfil."""
        if bad is None or bad.any():
            for number in claims:
                unmet = self._unmet(number)
                self.open[number, self.rows.part[unmet if bad is None else bad & unmet]] = True

    def leave_parts(self, number: int, rows: Rows) -> None:
        """Leaves open the parts of boxes for one claim."""
        if rows.size:
            self.open[number, rows.part] = True

    def keep(self) -> None:
        """Drops boxes that no claim asks about: all are shown or left open, or are fulfilled already."""
        alive = np.zeros(self.rows.size, dtype=np.bool_)
        for number in self.asked:
            alive |= ~self.open[number, self.rows.part] & self._unmet(number)
        if not alive.all():
            self.rows = self.rows.at(alive)

    def _unmet(self, number: int) -> Bool:
        one = self._claims[number]
        return ~self.rows.met[:, one.place] if one.claim.says.once else np.ones(self.rows.size, dtype=np.bool_)


def _within(rows: Rows, region: list[Half]) -> Rows:
    for half in region:
        rows = half.of(rows)
    return rows


def _outside(rows: Rows, region: list[Half]) -> Rows:
    parts = [rows.at(slice(0, 0))]
    if not rows.size:
        return rows
    low, high = rows.low.min(axis=0).tolist(), rows.high.max(axis=0).tolist()
    for half in region:
        if not half.holds_all(low, high):
            parts.append(_strictly(half.opposite().of(rows), half))
            rows = half.of(rows)
    return join_rows(parts)


def _strictly(rows: Rows, half: Half) -> Rows:
    """Without boxes that touch a half space from outside only, at a border that belongs to it."""
    return rows.at(~half.holds(rows))


def _bound_pieces(model: Model, system: System) -> tuple[Float64, Float64] | None:
    """About the bounds of what is stated; None where some piece has no box."""
    if not all(piece.where for piece in system.pieces):
        return None
    low, high = np.full(len(model.names), -np.inf), np.full(len(model.names), np.inf)
    for name, column in model.columns.items():
        ends = [piece.where[name] for piece in system.pieces if name in piece.where]
        if ends:
            low[column] = nearest_double(min(end for end, _ in ends))
            high[column] = nearest_double(max(end for _, end in ends))
    return low, high
