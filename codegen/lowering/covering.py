"""The lowered cover: boxes of states of which something is proved, as lists that are searched fast.

Does: makes, of lists of closed boxes, one per step, lists of the same boxes with hulls before groups of them.
Assumes: boxes [n, variables] of float64, without NaN, whose sides are infinite where a part does not bound a variable.
Does not: know what is proved, or write text (codegen/targets/monitor.py).

A row is a box or the hull of the rows that follow it, and says which row comes next for a state outside. So a search
needs no stack, ends after as many rows as there are at most, and compares the very numbers of the proof.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from codegen.errors import InputError
from codegen.floats import decimal_literal, short_hex
from codegen.ir import Bool, Float64, Int64
from codegen.lowering.parts import Double

MAX_BOXES = 20_000  # of all lists together
MAX_GIVEN = 100_000  # before some are joined
COMPARED = 2_000  # boxes of one list that are compared with each other
FEW = 3  # boxes that have no hull before them


class Boxes(NamedTuple):
    """Closed boxes: `low`, `high` [n, variables] float64."""

    low: Float64
    high: Float64

    def taken(self, which: Bool | Int64) -> Boxes:
        """Some of them."""
        return Boxes(self.low[which], self.high[which])

    def holds(self, states: Float64) -> Bool:
        """Which states [batch, variables] lie in a box."""
        found = np.zeros(len(states), dtype=np.bool_)
        for low, high in zip(self.low, self.high, strict=True):
            open_ = np.flatnonzero(~found)
            found[open_] = ((states[open_] >= low) & (states[open_] <= high)).all(axis=1)
        return found

    @property
    def bounded(self) -> tuple[int, ...]:
        """The variables that some box bounds."""
        return tuple(np.flatnonzero((np.isfinite(self.low) | np.isfinite(self.high)).any(axis=0)).tolist())


class Variable(NamedTuple):
    """One number of a state: its name, and the least and most that it may be."""

    name: str
    low: float
    high: float


@dataclass(frozen=True)
class Cover:
    """Of which states something is proved: for each step parts, which hold at once, each a union of boxes.

    `ever`: there is one list, and it holds at every step. `paced`: it is about states at whole steps.
    """

    variables: tuple[Variable, ...]
    steps: tuple[tuple[Boxes, ...], ...]
    ever: bool
    paced: bool
    dt: float  # seconds of a step
    rests: Mapping[str, int] = field(default_factory=dict[str, int])  # by agent the action that does nothing

    def holds(self, states: Float64, step: int) -> Bool:
        """Of which states [batch, variables] something is proved at a step."""
        parts = self.steps[0 if self.ever else step] if self.ever or step < len(self.steps) else ()
        found = np.full(len(states), bool(parts))
        for part in parts:
            found &= part.holds(states)
        return found


class Row(NamedTuple):
    """A box or a hull: the least and most of each column of its part; the row that comes next for a state outside."""

    ends: tuple[tuple[Double, Double], ...]
    skip: int


@dataclass(frozen=True)
class Lookup:
    """Lists of rows. A state is in the list of a step if it is in a box of each part of it: a row whose next one is the
    same inside and outside.
    """

    columns: tuple[tuple[int, ...], ...]  # by part: the variables that its rows bound, as many for each
    begins: tuple[int, ...]  # of each part of each step its first row; then how many rows there are
    rows: tuple[Row, ...]

    @property
    def parts(self) -> int:
        """How many parts a list has."""
        return len(self.columns)

    @property
    def width(self) -> int:
        """How many variables a row bounds."""
        return len(self.columns[0])

    @property
    def ends(self) -> int:
        """How many numbers a row has: the least and most of each variable."""
        return 2 * self.width

    @property
    def steps(self) -> int:
        """How many lists there are."""
        return (len(self.begins) - 1) // self.parts

    @property
    def comparisons(self) -> int:
        """The most that one step takes."""
        sizes = np.diff(np.array(self.begins)).reshape(self.steps, self.parts)
        return self.ends * int(sizes.sum(axis=1).max())


def lookup(steps: Sequence[Sequence[Boxes]], where: str) -> Lookup:
    """The rows of lists: for each step its parts, as many at each. `where` is named in errors.

    InputError for too many boxes.
    """
    count = sum(len(part.low) for parts in steps for part in parts)
    lists = [[merged(part) for part in parts] for parts in steps] if count <= MAX_GIVEN else []
    count = sum(len(part.low) for parts in lists for part in parts) if lists else count
    if count > MAX_BOXES or not lists:
        what = f"the proof's sets are {count:,} boxes, and a monitor has room for {MAX_BOXES:,}"
        raise InputError(what, where, "verify the claim with wider cells, or for fewer steps")
    columns = [sorted({at for parts in lists for at in parts[number].bounded}) for number in range(len(lists[0]))]
    most = max(1, *map(len, columns))
    padded = [(*of, *[of[0] if of else 0] * (most - len(of))) for of in columns]  # twice the same changes nothing
    rows, begins = list[Row](), [0]
    for parts in lists:
        for part, of in zip(parts, padded, strict=True):
            rows += _rows(Boxes(part.low[:, of], part.high[:, of]), len(rows))
            begins.append(len(rows))
    return Lookup(tuple(padded), tuple(begins), tuple(rows))


def _rows(boxes: Boxes, begin: int) -> list[Row]:
    """The rows of some boxes, the first of which has the number `begin`."""
    if len(boxes.low) <= FEW:
        return [_row(low, high, begin + 1 + at) for at, (low, high) in enumerate(zip(*boxes, strict=True))]
    low, high = boxes.low.min(axis=0), boxes.high.max(axis=0)
    middles = boxes.low + boxes.high
    order = np.argsort(middles[:, _widest(middles, high - low)], kind="stable")
    half = len(order) // 2
    first = _rows(boxes.taken(order[:half]), begin + 1)
    rest = _rows(boxes.taken(order[half:]), begin + 1 + len(first))
    return [_row(low, high, begin + 1 + len(first) + len(rest)), *first, *rest]


def _widest(middles: Float64, sizes: Float64) -> int:
    """The variable along which boxes lie farthest apart, for their hull's size."""
    spread = middles.max(axis=0) - middles.min(axis=0)
    return int(np.argmax(np.divide(spread, sizes, out=np.zeros_like(spread), where=sizes > 0)))


def _row(low: Float64, high: Float64, skip: int) -> Row:
    ends = zip(low.tolist(), high.tolist(), strict=True)
    return Row(tuple((_double(least + 0.0), _double(most + 0.0)) for least, most in ends), skip)


def _double(value: float) -> Double:
    return Double(short_hex(value), decimal_literal(value))


def merged(boxes: Boxes) -> Boxes:
    """The same float64 states in fewer boxes: two that meet, or leave no float64 between them, and differ in one
    variable alone become one; what lies in another box goes.
    """
    size = boxes.low.shape[1]
    rows = np.unique(np.concatenate(boxes, axis=1), axis=0)
    before = len(rows) + 1
    while len(rows) < before:
        before = len(rows)
        for variable in range(size):
            rows = _joined(rows, variable, size)
    low, high = rows[:, :size], rows[:, size:]
    held = np.zeros(len(rows), dtype=np.bool_)
    for at in range(len(rows) if len(rows) <= COMPARED else 0):
        around = (low <= low[at]).all(axis=1) & (high >= high[at]).all(axis=1)
        held[at] = around.sum() > 1  # rows are unlike, so another one is larger
    return Boxes(np.ascontiguousarray(low[~held]), np.ascontiguousarray(high[~held]))


def _joined(rows: Float64, variable: int, size: int) -> Float64:
    """The rows, those joined that differ in this variable alone."""
    others = [column for column in range(2 * size) if column not in (variable, size + variable)]
    order = np.lexsort([rows[:, variable], *(rows[:, column] for column in others)])
    found: list[Float64] = []
    for row in rows[order]:
        last = found[-1] if found else None
        if last is not None and (last[others] == row[others]).all() and row[variable] <= _after(last[size + variable]):
            last[size + variable] = max(last[size + variable], row[size + variable])
        else:
            found.append(row.copy())
    return np.array(found, dtype=np.float64).reshape(len(found), 2 * size)


def _after(value: float) -> float:
    """The next float64."""
    return float(np.nextafter(value, np.inf))
