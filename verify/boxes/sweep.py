"""Which parts of the start are shown by boxes: all parts are followed at once, until the claim or a limit stops one.

Does: follows boxes step by step; tells the parts that are left open, and how many boxes that took.
Assumes: a claim about episodes.
Does not: choose parts or cells (covering.py).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from codegen.floats import nearest_double
from codegen.ir import Bool, Float64
from verify.boxes.model import Model
from verify.boxes.rows import Half, Rows, cells_of, in_cells, joined
from verify.systems.claims import SystemClaim
from verify.systems.system import System

MAX_AT_ONCE = 200_000  # boxes of one list


@dataclass(frozen=True)
class Swept:
    """What a sweep says: which parts of the start are left open, [parts], and how many boxes it took."""

    open: Bool
    boxes: int


class Sweep:
    """Boxes for one claim."""

    def __init__(self, model: Model, system: System, claim: SystemClaim) -> None:
        self._model, self._claim = model, claim
        self._regions = [model.region(region) for region in claim.regions]
        self._stated = _stated(model, system)

    def run(self, low: Float64, high: Float64, widths: Mapping[int, float], most: int) -> Swept:
        """Follows parts of the start, `low` and `high` [parts, variables], with at most so many boxes."""
        with np.errstate(all="ignore"):  # boxes that overflow are left open
            return self._run(low, high, widths, most)

    def _run(self, low: Float64, high: Float64, widths: Mapping[int, float], most: int) -> Swept:
        count = len(low)
        none = np.zeros(count, dtype=np.int64)
        rows, open_, spent = Rows(low, high, np.arange(count), none), np.zeros(count, dtype=np.bool_), 0
        for step in range(self._claim.steps + 1):
            wild = ~(np.isfinite(rows.low) & np.isfinite(rows.high)).all(axis=1)
            if wild.any():
                open_[rows.part[wild]] = True
                rows = rows.at(~open_[rows.part])
            if widths and cells_of(rows, widths) > MAX_AT_ONCE:
                return Swept(open_ | np.isin(np.arange(count), rows.part), spent)
            rows = in_cells(rows, widths) if widths else rows
            spent += rows.size
            rows, broken = self._asked(rows, step)
            open_[broken.part] = True
            if step < self._claim.steps and self._stated is not None:
                low, high = self._stated
                open_[rows.part[~((rows.low >= low) & (rows.high <= high)).all(axis=1)]] = True
            rows = rows.at(~open_[rows.part]) if open_.any() else rows
            if not rows.size or step == self._claim.steps:
                break
            rows = self._model.stepped(rows)
            if spent + rows.size > most or rows.size > MAX_AT_ONCE:
                open_[rows.part] = True
                break
        return Swept(open_, spent)

    def _asked(self, rows: Rows, step: int) -> tuple[Rows, Rows]:
        """The boxes that are followed further, and those that may break the claim."""
        says, claim = self._claim.says, self._claim
        nothing = rows.at(np.zeros(0, dtype=np.int64))
        if says.avoided:
            return rows, joined([nothing, *(_within(rows, region) for region in self._regions)])
        if step < claim.by:
            return rows, nothing
        outside = rows
        for region in self._regions:
            outside = _outside(outside, region)
        if says.once:
            return outside, outside if step == claim.steps else nothing
        return rows, outside

    def reached(self, low: Float64, high: Float64) -> Float64:
        """How far each variable ranges in the episodes from some boxes, about, [variables]."""
        rows = Rows(low, high, np.arange(len(low)), np.zeros(len(low), dtype=np.int64))
        least, most = low.min(axis=0), high.max(axis=0)
        for _ in range(self._claim.steps):
            rows = self._model.stepped(rows)
            rows = rows.at(np.linspace(0, rows.size - 1, min(rows.size, 2 * len(low))).astype(np.int64))
            if not rows.size:
                break
            least, most = np.minimum(least, rows.low.min(axis=0)), np.maximum(most, rows.high.max(axis=0))
        return most - least


def _within(rows: Rows, region: list[Half]) -> Rows:
    for half in region:
        rows = half.of(rows)
    return rows


def _outside(rows: Rows, region: list[Half]) -> Rows:
    found = [rows.at(np.zeros(0, dtype=np.int64))]
    for half in region:
        found.append(_strictly(half.opposite().of(rows), half))
        rows = half.of(rows)
    return joined(found)


def _strictly(rows: Rows, half: Half) -> Rows:
    """Without boxes that touch a half space from outside only, at a border that belongs to it."""
    return rows.at(~half.holds(rows))


def _stated(model: Model, system: System) -> tuple[Float64, Float64] | None:
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
