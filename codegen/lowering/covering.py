"""The lowered cover: boxes of states of which something is proved, for each step a list of few that are searched fast.

Does: joins closed boxes to fewer ones that hold the same float64 states; has a search of the lists made.
Assumes: boxes [n, variables] of float64, without NaN, whose sides are infinite where a part does not bound a variable.
Does not: know what is proved, or write text (codegen/targets/monitor.py).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from codegen.errors import InputError
from codegen.ir import Bool, Float64
from codegen.lowering.parts import RaisedSum
from codegen.lowering.searching import Boxes, Lookup, search_of

MAX_BOXES = 20_000  # of all lists together
MAX_GIVEN = 100_000  # before some are joined
COMPARED = 2_000  # boxes of one list that are compared with each other


class Variable(NamedTuple):
    """One number of a state: its name, and the least and most that it may be."""

    name: str
    low: float
    high: float


@dataclass(frozen=True)
class Cover:
    """Of which states something is proved: for each step parts, which hold at once, each a union of boxes. Boxes bound
    the variables, and after these the raised sums.

    `ever`: there is one list, and it holds at every step. `paced`: it is about states at whole steps.
    """

    variables: tuple[Variable, ...]
    steps: tuple[tuple[Boxes, ...], ...]
    ever: bool
    paced: bool
    dt: float  # seconds of a step
    rests: Mapping[str, str] = field(default_factory=dict[str, str])  # by agent the action that does nothing
    sums: tuple[RaisedSum, ...] = ()

    def extend(self, states: Float64) -> Float64:
        """States [batch, variables] and their sums, as boxes bound both."""
        return np.column_stack([states, *(each.of(states) for each in self.sums)]) if self.sums else states

    def holds(self, states: Float64, step: int) -> Bool:
        """Of which states [batch, variables] something is proved at a step."""
        parts = self.steps[0 if self.ever else step] if self.ever or step < len(self.steps) else ()
        inside, extended = np.full(len(states), bool(parts)), self.extend(states)
        for part in parts:
            inside &= part.holds(extended)
        return inside

    def bounds(self, variable: int) -> tuple[float, float]:
        """Between which numbers a variable is in every state of which something is proved."""
        found = [_between(parts, variable) for parts in self.steps]
        return min(low for low, _ in found), max(high for _, high in found)


def _between(parts: Sequence[Boxes], variable: int) -> tuple[float, float]:
    """Between which numbers a variable is in all parts; without a state, anywhere."""
    low = max(float(part.low[:, variable].min(initial=np.inf)) for part in parts)
    high = min(float(part.high[:, variable].max(initial=-np.inf)) for part in parts)
    return low, high


def look_up(cover: Cover, where: str) -> Lookup:
    """How states are looked up in the sets of a cover. `where` is named in errors. InputError for too many sets."""
    return replace(lookup(cover.steps, where), sums=cover.sums)


def lookup(steps: Sequence[Sequence[Boxes]], where: str) -> Lookup:
    """The search of lists: for each step its parts, as many at each. `where` is named in errors.

    InputError for too many boxes.
    """
    count = sum(len(part.low) for parts in steps for part in parts)
    lists = [[merge_boxes(part) for part in parts] for parts in steps] if count <= MAX_GIVEN else []
    count = sum(len(part.low) for parts in lists for part in parts) if lists else count
    if count > MAX_BOXES or not lists:
        what = f"the proof's sets are {count:,} boxes, and a monitor has room for {MAX_BOXES:,}"
        raise InputError(what, where, "verify the claim with wider cells, or for fewer steps")
    columns = [sorted({at for parts in lists for at in parts[number].bounded}) for number in range(len(lists[0]))]
    most = max(1, *map(len, columns))
    padded = [(*of, *[of[0] if of else 0] * (most - len(of))) for of in columns]  # twice the same changes nothing
    return search_of(lists, padded)


def merge_boxes(boxes: Boxes) -> Boxes:
    """The same float64 states in fewer boxes: two that meet, or leave no float64 between them, and differ in one
    variable alone become one; what lies in another box goes. Boxes may overlap.
    """
    size = boxes.low.shape[1]
    rows = np.unique(np.concatenate(boxes, axis=1), axis=0)
    before = len(rows) + 1
    while len(rows) < before:
        before = len(rows)
        for variable in range(size):
            rows = _join_rows(rows, variable, size)
    low, high = np.ascontiguousarray(rows[:, :size]), np.ascontiguousarray(rows[:, size:])
    if len(rows) > COMPARED:
        return Boxes(low, high)
    _grow(low, high)
    rows = np.unique(np.concatenate([low, high], axis=1), axis=0)
    low, high = rows[:, :size], rows[:, size:]
    held = np.zeros(len(rows), dtype=np.bool_)
    for at in range(len(rows)):
        around = (low <= low[at]).all(axis=1) & (high >= high[at]).all(axis=1)
        held[at] = around.sum() > 1  # rows are unlike, so another one is larger
    return Boxes(np.ascontiguousarray(low[~held]), np.ascontiguousarray(high[~held]))


def _grow(low: Float64, high: Float64) -> None:
    """Grows each box, in place, over those that it meets along one variable and that are as wide in all others. What
    they hold together stays, and a state that lies in the middle of many is in the first that is compared.
    """
    size, grew = low.shape[1], True
    while grew:
        grew = False
        for variable in range(size):
            others = [at for at in range(size) if at != variable]
            wider = np.ones((len(low), len(low)), dtype=np.bool_)  # [box, another one]
            for at in others:
                wider &= (low[:, at] <= low[:, at, None]) & (high[:, at] >= high[:, at, None])
            while True:
                first, last = low[:, variable], high[:, variable]
                meets = wider & (first <= np.nextafter(last, np.inf)[:, None])
                meets &= np.nextafter(last, np.inf) >= first[:, None]
                most = np.where(meets, last, -np.inf).max(axis=1)
                least = np.where(meets, first, np.inf).min(axis=1)
                if (most <= last).all() and (least >= first).all():
                    break
                low[:, variable], high[:, variable], grew = least, most, True


def _join_rows(rows: Float64, variable: int, size: int) -> Float64:
    """The rows, those joined that differ in this variable alone."""
    others = [column for column in range(2 * size) if column not in (variable, size + variable)]
    order = np.lexsort([rows[:, variable], *(rows[:, column] for column in others)])
    joined_rows: list[Float64] = []
    for row in rows[order]:
        last = joined_rows[-1] if joined_rows else None
        if last is not None and (last[others] == row[others]).all() and row[variable] <= _after(last[size + variable]):
            last[size + variable] = max(last[size + variable], row[size + variable])
        else:
            joined_rows.append(row.copy())
    return np.array(joined_rows, dtype=np.float64).reshape(len(joined_rows), 2 * size)


def _after(value: float) -> float:
    """The next float64."""
    return float(np.nextafter(value, np.inf))
