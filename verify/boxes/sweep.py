"""Which parts of the start are shown by boxes: all parts are followed at once, until a limit stops them.

Does: follows boxes step by step; tells which parts are left open, and how many boxes that took.
Assumes: a claim about episodes of steps.
Does not: choose parts or cells (covering.py).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from codegen.ir import Bool, Float64
from codegen.numbers import nearest_double
from verify.boxes.model import Model
from verify.boxes.rows import Half, Rows, cells_of, in_cells, join_rows
from verify.systems.claims import SystemClaim
from verify.systems.system import System

MAX_AT_ONCE = 200_000  # boxes of one list


@dataclass(frozen=True)
class Swept:
    """The result of a sweep: which parts of the start are left open, [parts]; how many boxes it took; whether what it
    was allowed stopped it.
    """

    open: Bool
    boxes: int
    stopped: bool = False


class Sweep:
    """Boxes for a claim about a team in a system."""

    def __init__(self, model: Model, system: System, claim: SystemClaim) -> None:
        self._model, self._claim = model, claim
        self._regions = [model.region(region) for region in claim.regions]
        self._stated = _bound_pieces(model, system)

    def run(self, parts: tuple[Float64, Float64], widths: Mapping[int, float], most: int) -> Swept:
        """Follows parts of the start, bounds [parts, variables], with at most so many boxes."""
        follow = _Following(Rows.of(*parts))
        with np.errstate(all="ignore"):  # boxes that overflow are left open
            self._follow(follow, widths, most)
        return Swept(follow.open, follow.boxes, follow.stopped)

    def _follow(self, at: _Following, widths: Mapping[int, float], most: int) -> None:
        for step in range(self._claim.steps + 1):
            wild = np.asarray(~np.isfinite(at.rows.low.sum(axis=1) + at.rows.high.sum(axis=1)), dtype=np.bool_)
            if wild.any():
                at.leave(at.rows.at(wild))
                at.rows = at.rows.at(~wild)
            if widths and cells_of(at.rows, widths) > MAX_AT_ONCE:
                at.leave(at.rows)
                return
            at.rows = in_cells(at.rows, widths) if widths else at.rows
            at.boxes += at.rows.size
            self._ask(at, step)
            if step == self._claim.steps:
                return
            if self._stated is not None:
                low, high = self._stated
                beyond = ((at.rows.low < low) | (at.rows.high > high)).any(axis=1)
                at.leave(at.rows.at(np.flatnonzero(beyond)))
            at.keep()
            if not at.rows.size:
                return
            at.rows = self._model.step_boxes(at.rows)
            if at.boxes + at.rows.size > most or at.rows.size > MAX_AT_ONCE:
                at.stopped = at.boxes + at.rows.size > most
                at.leave(at.rows)
                return

    def _ask(self, at: _Following, step: int) -> None:
        """Leaves open the parts whose boxes may break the claim at a step."""
        says = self._claim.says
        if says.avoided:
            for region in self._regions:
                at.leave(_within(at.rows, region))
        elif says.once:
            at.rows = self._without_regions(at.rows)
            if step == self._claim.steps:
                at.leave(at.rows)
        elif step >= self._claim.by:
            at.leave(self._without_regions(at.rows))

    def _without_regions(self, rows: Rows) -> Rows:
        """Returns the parts of the boxes that lie in none of the claim's regions."""
        for region in self._regions:
            rows = _outside(rows, region)
        return rows

    def estimate_ranges(self, low: Float64, high: Float64) -> Float64:
        """Estimates how far each variable ranges in the episodes from some boxes, [variables]."""
        rows = Rows.of(low, high)
        least, most = low.min(axis=0), high.max(axis=0)
        for _ in range(self._claim.steps):
            rows = self._model.step_boxes(rows)
            rows = rows.at(np.linspace(0, rows.size - 1, min(rows.size, 2 * len(low))).astype(np.int64))
            if not rows.size:
                break
            least, most = np.minimum(least, rows.low.min(axis=0)), np.maximum(most, rows.high.max(axis=0))
        return most - least


class _Following:
    """A sweep under way: its boxes, and the parts that are left open."""

    def __init__(self, rows: Rows) -> None:
        self.rows = rows
        self.boxes, self.stopped = 0, False
        self.open = np.zeros(rows.size, dtype=np.bool_)

    def leave(self, rows: Rows) -> None:
        """Leaves open the parts of some boxes."""
        self.open[rows.part] = True

    def keep(self) -> None:
        """Drops boxes of parts that are left open."""
        alive = ~self.open[self.rows.part]
        if not alive.all():
            self.rows = self.rows.at(alive)


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
