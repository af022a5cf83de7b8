"""Lists of boxes as arrays: cut by inequalities and cells, joined cell by cell; the start as boxes.

Does: the data of a list of boxes, and what neither tests nor moves do with it; boxes around what lies within and
  outside of polytopes; the parts of the start that cuts name.
Assumes: closed boxes with finite float64 bounds; `finite` is asked of every list that was moved. A box is dropped only
  where a bound shows that no state of it is meant.
Does not: know trees, claims or moves.

A bound is a float64, so an inequality whose end lies between two floats, or is not reached, is met by a box exactly if
the box reaches the last float that meets it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import lru_cache
from math import inf, isfinite, nextafter
from typing import NamedTuple

import numpy as np

from codegen.ir import Bool, Float64, Int64
from verify.checker.covers.rounding import Factor, around, ceiling, floor, sum_down
from verify.checker.reading import RejectedError
from verify.claims.formula import Linear
from verify.systems.system import HalfSpace, Polytope, System

MAX_CELL = 2.0**40  # of a cell's number along a variable
MAX_BOXES = 4_000_000  # of one list
FEW, ALIKE = 64, 2.0**-36  # boxes that are not joined; how close bounds are, beside the largest, that are alike


class BoxList(NamedTuple):
    """Closed boxes: `bounds` [n, 2 variables], from below, of the variables and then of their negatives: what is true
    of one is true of each; `part` [n], the part of the start that each comes from; `joint` [n], the number of the joint
    action that is chosen in it.
    """

    bounds: Float64
    part: Int64
    joint: Int64

    @classmethod
    def of(cls, low: Float64, high: Float64, part: Int64, joint: Int64) -> BoxList:
        """Boxes by their ends, [n, variables] each, which are copied."""
        return cls(np.concatenate([low, -high], axis=1), part, joint)

    @property
    def size(self) -> int:
        """The number of boxes."""
        return len(self.part)

    @property
    def variables(self) -> int:
        """The number of variables that the boxes bound."""
        return self.bounds.shape[1] // 2

    @property
    def low(self) -> Float64:
        """The lower ends, [n, variables]."""
        return self.bounds[:, : self.variables]

    @property
    def high(self) -> Float64:
        """The upper ends, [n, variables], copied."""
        return np.asarray(-self.bounds[:, self.variables :], dtype=np.float64)

    def take(self, which: Bool | Int64 | slice) -> BoxList:
        """Some of the boxes, by a mask or by their numbers, copied; by a slice as a view."""
        bounds, part, joint = self
        if isinstance(which, slice):
            return BoxList(bounds[which], part[which], joint[which])
        at = np.flatnonzero(which) if which.dtype == np.bool_ else np.asarray(which, dtype=np.int64)
        return BoxList(bounds.take(at, axis=0), part.take(at), joint.take(at))  # faster than a mask

    @property
    def finite(self) -> Bool:
        """True for each box that has finite bounds only, [n]."""
        if isfinite(self.bounds.sum()):
            return np.ones(self.size, dtype=np.bool_)
        return np.asarray(np.isfinite(self.bounds).all(axis=1), dtype=np.bool_)  # a sum may overflow


Watch = Callable[[int, BoxList], None]  # told of every list that a proof rests on: its step, or its part


def together(lists: Sequence[BoxList]) -> BoxList:
    """The boxes of some lists in one. RejectedError for too many."""
    if sum(each.size for each in lists) > MAX_BOXES:
        raise RejectedError(f"a list has more than {MAX_BOXES:,} boxes")
    kept = [each for each in lists if each.size] or lists[:1]
    return kept[0] if len(kept) == 1 else BoxList(*map(np.concatenate, zip(*kept, strict=True)))


def in_cells(boxes: BoxList, widths: Mapping[int, float], most: int = MAX_BOXES) -> BoxList:
    """Boxes that hold all states of a list, one for each cell and part of the start that has some."""
    return join_by_cell(*cut(boxes, widths, most))


def cut(boxes: BoxList, widths: Mapping[int, float], most: int = MAX_BOXES) -> tuple[BoxList, Int64]:
    """The boxes cut at the bounds of cells, and the cell of each, [n, widths]. `widths`: of cells, by column; whole
    multiples of them are the middles of cells. RejectedError for more than `most` boxes.
    """
    cells = np.zeros((boxes.size, 0), dtype=np.int64)
    for column, width in widths.items():
        boxes, cells = _cut_along(boxes, cells, column, width, most)
    return boxes, cells


def _cut_along(boxes: BoxList, cells: Int64, column: int, width: float, most: int) -> tuple[BoxList, Int64]:
    """The boxes cut at the bounds of cells along one variable, with one more column of cells' numbers.

    Two neighbours share the float at which they are cut, so nothing lies between them.
    """
    above = boxes.variables + column
    low, high = boxes.bounds[:, column], -boxes.bounds[:, above]
    first, last = np.floor(low / width + 0.5), np.floor(high / width + 0.5)
    if not ((np.abs(first) <= MAX_CELL) & (np.abs(last) <= MAX_CELL)).all():
        raise RejectedError("cells are too narrow for a box")
    last = np.maximum(np.where((last > first) & ((last - 0.5) * width >= high), last - 1, last), first)
    count = (last - first).astype(np.int64) + 1
    if int(count.sum()) > most:
        raise RejectedError(f"a list has more than {most:,} boxes")
    rows = np.repeat(np.arange(boxes.size), count)
    place = np.arange(len(rows)) - np.repeat(np.cumsum(count) - count, count)
    number = first[rows] + place
    parts = boxes.take(rows)
    low, high = low.take(rows), high.take(rows)
    low = np.where(place == 0, low, np.maximum(low, (number - 0.5) * width))
    high = np.where(number == last[rows], high, np.minimum(high, (number + 0.5) * width))
    parts.bounds[:, column], parts.bounds[:, above] = low, -high
    kept = ~(low > high)
    cells = np.column_stack([cells[rows], number.astype(np.int64)])
    return parts.take(kept), cells[kept]


def join_by_cell(boxes: BoxList, cells: Int64) -> BoxList:
    """For each cell and part of the start, the box around its boxes."""
    if not boxes.size:
        return boxes
    keys = np.column_stack([boxes.part, cells])
    order = np.lexsort(keys.T)
    sorted_keys = keys[order]
    begins = np.flatnonzero(np.concatenate([[True], (sorted_keys[1:] != sorted_keys[:-1]).any(axis=1)]))
    return _around(boxes.take(order), begins)


def alike_joined(boxes: BoxList) -> BoxList:
    """Boxes that hold all states of a list, where those that are all but equal became one.

    Rounding outward makes slivers at borders of tests, and these make almost the same boxes again and again. What is
    joined is found by a hash of rounded bounds: boxes that share one by chance are joined too, which loses no state.
    """
    if boxes.size < FEW:
        return boxes
    bounds = boxes.bounds
    order, begins = alike(round_bounds(bounds, unit_of(bounds.min(axis=0), bounds.max(axis=0))), [boxes.part])
    return boxes if len(begins) == boxes.size else _around(boxes.take(order), begins)


def unit_of(least: Float64, most: Float64) -> Float64:
    """Returns the distance within which bounds count as alike, for each column, from its least and its most."""
    return np.maximum(np.abs(least), np.abs(most)) * ALIKE + 2.0**-1000


def round_bounds(bounds: Float64, unit: Float64) -> Int64:
    """Bounds as whole numbers."""
    return (bounds * (1.0 / unit) + 0.3).astype(np.int64)


def alike(rows: Int64, kinds: Sequence[Int64]) -> tuple[Int64, Int64]:
    """An order in which rows are neighbours that share a hash of their numbers and kinds, and where each run of such
    rows begins. Those of a run are of one kind, whatever the hash says.
    """
    factors = multipliers(rows.shape[1] + len(kinds))
    hashed = rows @ factors[len(kinds) :]
    for kind, factor in zip(kinds, factors.tolist(), strict=False):
        hashed += kind * factor
    order = np.argsort(hashed, kind="stable")
    new = np.ones(len(order), dtype=np.bool_)
    new[1:] = False
    for each in (hashed, *kinds):
        sorted_ = each.take(order)
        new[1:] |= sorted_[1:] != sorted_[:-1]
    return order, np.flatnonzero(new)


@lru_cache(maxsize=16)
def multipliers(count: int) -> Int64:
    """Some large odd numbers, by which rows are hashed."""
    return np.random.default_rng(0).integers(1, 2**62, size=count) | 1


def _around(boxes: BoxList, begins: Int64) -> BoxList:
    """The box around the boxes of each run."""
    return BoxList(least_of_runs(boxes.bounds, begins), boxes.part.take(begins), boxes.joint.take(begins))


def least_of_runs(bounds: Float64, begins: Int64) -> Float64:
    """The least of each column over each run of rows, by halves of runs: runs are short, and `reduceat` is slow for
    these.
    """
    counts = np.diff(begins, append=len(bounds))
    after, least, apart = np.repeat(begins + counts, counts), bounds.copy(), 1  # least of `apart` rows, from each on
    while apart < counts.max():
        at = np.flatnonzero(np.arange(apart, len(bounds)) < after[:-apart])
        least[at] = np.minimum(least.take(at, axis=0), least.take(at + apart, axis=0))
        apart *= 2
    return least.take(begins, axis=0)


class FloatEnd(NamedTuple):
    """Where a half line of numbers up to an end stops: `last` is the largest float in it, `up` no less than the end."""

    last: float
    up: float


def end_of(bound: Fraction, strict: bool) -> FloatEnd:
    """The half line of the numbers that are at most a bound, or below it."""
    last, up = around(bound)
    return FloatEnd(nextafter(last, -inf) if strict and last == up else last, up)


class BoundLine(NamedTuple):
    """An inequality of one variable: the column of `BoxList.bounds` that it bounds from above, the column of the other
    side, and its end there. `down`: no more than the end.
    """

    near: int
    far: int
    end: FloatEnd
    down: float

    @property
    def opposite(self) -> BoundLine:
        """The bound that holds where this one does not."""
        (last, up), down = self.end, self.down
        beyond = nextafter(-up, -inf) if last == up else -up  # a float that belongs to the one side only
        return BoundLine(self.far, self.near, FloatEnd(beyond, -down), -up)


def half_line(inequality: Linear, columns: Mapping[str, int]) -> BoundLine | None:
    """An inequality of one variable as bounds have it; None for one of none, or of several. `columns`: of all."""
    terms = [(weight, columns[name]) for weight, name in inequality.terms if weight]
    if len(terms) != 1:
        return None
    ((weight, low),) = terms
    high = low + len(columns)
    near, far = (low, high) if weight.numerator > 0 else (high, low)
    size = weight if weight.numerator > 0 else -weight
    bound = inequality.bound if size == 1 else inequality.bound / size
    down, up = around(bound)
    last = nextafter(down, -inf) if inequality.strict and down == up else down
    return BoundLine(near, far, FloatEnd(last, up), down)


def opposite(inequality: Linear) -> Linear:
    """Returns the negation of an inequality."""
    terms = tuple((-weight, name) for weight, name in inequality.terms)
    return Linear(terms, -inequality.bound, not inequality.strict)


def linear(half: HalfSpace) -> Linear:
    """A half space as an inequality."""
    terms = tuple((factor, name) for name, factor in half.form.terms)
    return Linear(terms, -half.form.constant, half.strict)


class Cut:
    """An inequality as a cut of boxes. `line`: the same as a half line, where it is about one variable."""

    def __init__(self, inequality: Linear, columns: Mapping[str, int]) -> None:
        self.line = half_line(inequality, columns)
        self._always = inequality.bound > 0 or (inequality.bound == 0 and not inequality.strict)
        self._terms: list[_Term] = []
        if self.line is None:
            self._end = end_of(inequality.bound, inequality.strict)
            self._terms = [_Term.of(weight, columns[name], len(columns)) for weight, name in inequality.terms if weight]

    def within(self, boxes: BoxList) -> BoxList:
        """For each box with a state that may meet the inequality, a box around all such states."""
        if not boxes.size:
            return boxes
        if self.line is not None:
            return self._by_one(boxes, self.line)
        if not self._terms:
            return boxes if self._always else boxes.take(slice(0, 0))
        least = [each.least(boxes.bounds) for each in self._terms]
        met = ~(_total_down(least) > self._end.last)
        if not met.any():
            return boxes.take(slice(0, 0))
        at = np.flatnonzero(met)
        kept, least = boxes.take(at), [each.take(at) for each in least]
        empty = np.zeros(kept.size, dtype=np.bool_)
        for place, term in enumerate(self._terms):  # bounded by what the least of all others leaves of the end
            left = sum_down(_total_down(least[:place] + least[place + 1 :]), -self._end.up)
            far = np.maximum(kept.bounds[:, term.far], term.factor.into_down(left if term.factor.positive else -left))
            kept.bounds[:, term.far] = far
            empty |= kept.bounds[:, term.near] + far > 0  # a sum of two floats has its sign, however it rounds
        return kept.take(~empty) if empty.any() else kept

    @staticmethod
    def _by_one(boxes: BoxList, line: BoundLine) -> BoxList:
        met, first = ~(boxes.bounds[:, line.near] > line.end.last), -line.end.up
        if not met.any():
            return boxes.take(slice(0, 0))
        if met.all() and (boxes.bounds[:, line.far] >= first).all():
            return boxes
        kept = boxes.take(met)
        kept.bounds[:, line.far] = np.maximum(kept.bounds[:, line.far], first)
        return kept


class _Term(NamedTuple):
    """A variable times a number. `near`, `far`: the columns of `BoxList.bounds` where it is least and most."""

    factor: Factor
    near: int
    far: int

    @classmethod
    def of(cls, weight: Fraction, column: int, variables: int) -> _Term:
        """The term of a column, of so many variables."""
        ends = (column, column + variables)
        return cls(Factor(weight), *(ends if weight > 0 else reversed(ends)))

    def least(self, bounds: Float64) -> Float64:
        """A float at most its least value in each box."""
        ends = bounds[:, self.near]
        return self.factor.times_down(ends if self.factor.positive else -ends)


def _total_down(values: Sequence[Float64]) -> Float64:
    total = values[0]
    for each in values[1:]:
        total = sum_down(total, each)
    return total


class LineCuts:
    """Inequalities of one variable each, as one cut. `variables`: how many there are."""

    def __init__(self, lines: Sequence[BoundLine], variables: int) -> None:
        self._last, self._first = np.full(2 * variables, inf), np.full(2 * variables, -inf)
        for near, far, end, _ in lines:
            self._last[near] = min(self._last[near], end.last)
            self._first[far] = max(self._first[far], -end.up)
        self._none = bool((self._first > self._last).any())  # no state meets all

    def within(self, boxes: BoxList) -> BoxList:
        """For each box with a state that may meet all of them, a box around all such states."""
        if self._none:
            return boxes.take(slice(0, 0))
        beyond: Bool = np.asarray((boxes.bounds > self._last).any(axis=1), dtype=np.bool_)
        boxes = boxes.take(~beyond) if beyond.any() else boxes
        return boxes._replace(bounds=np.maximum(boxes.bounds, self._first))


class RegionCut:
    """A polytope, by the cuts of its half spaces and of their opposites."""

    def __init__(self, region: Sequence[HalfSpace], columns: Mapping[str, int]) -> None:
        self._sides = [(Cut(each, columns), Cut(opposite(each), columns)) for each in map(linear, region)]
        lines = [outside.line for _, outside in self._sides]
        self._single = None not in lines
        self._inside = LineCuts([inside.line for inside, _ in self._sides if inside.line], len(columns))
        self._columns = np.array([each.near for each in lines if each], dtype=np.int64)
        self._last = np.array([each.end.last for each in lines if each])

    def within(self, boxes: BoxList) -> BoxList:
        """Boxes around the states that may lie in it."""
        boxes = self._inside.within(boxes)
        for inside, _ in () if self._single else self._sides:
            boxes = boxes if inside.line else inside.within(boxes)
        return boxes

    def outside(self, boxes: BoxList) -> BoxList:
        """Boxes around the states that may lie outside of it."""
        none = boxes.take(slice(0, 0))
        if self._single and (boxes.bounds.take(self._columns, axis=1) > self._last).all():
            return none
        outer_parts = [none]
        for inside, outside in self._sides:
            outer_parts.append(outside.within(boxes))
            boxes = inside.within(boxes)
        return together(outer_parts)


class Regions:
    """Some polytopes, at least one."""

    def __init__(self, regions: Sequence[Polytope], columns: Mapping[str, int]) -> None:
        self._cuts = [RegionCut(region, columns) for region in regions]

    def within(self, boxes: BoxList) -> BoxList:
        """Boxes around the states that may lie in some of them."""
        return together([region.within(boxes) for region in self._cuts])

    def outside(self, boxes: BoxList) -> BoxList:
        """Boxes around the states that may lie in none of them."""
        for region in self._cuts:
            boxes = region.outside(boxes)
        return boxes


MAX_WIDTH = Fraction(2) ** 200  # of a cell, and 1 over the least


def widths_of(given: Mapping[str, Fraction]) -> dict[str, float]:
    """The widths of cells that a proof names. RejectedError for one out of range."""
    if not all(1 / MAX_WIDTH < width < MAX_WIDTH for width in given.values()):
        raise RejectedError("a cell has a width out of range")
    return {name: floor(width) for name, width in given.items()}


MAX_PARTS = 1 << 20  # of the start
AT_ONCE = 1 << 12  # parts that are swept together


class StartBox(NamedTuple):
    """A part of the start as a box, [n_variables] each."""

    low: Float64
    high: Float64


def halves(one: StartBox, column: int) -> list[StartBox]:
    """A part cut at the middle of a variable, the lower half first."""
    middle, lower, upper = 0.5 * one.low[column] + 0.5 * one.high[column], one.high.copy(), one.low.copy()
    lower[column] = upper[column] = middle
    return [StartBox(one.low, lower), StartBox(upper, one.high)]


class Parts:
    """The start of a system, to be cut into at most so many parts, of which so many are swept together."""

    def __init__(self, system: System, most: int = MAX_PARTS, at_once: int = AT_ONCE) -> None:
        self._system, self._most, self._at_once = system, most, at_once
        self._columns = {one.name: column for column, one in enumerate(system.variables)}
        self._start = RegionCut(system.start, self._columns)

    def parts(self, cuts: Sequence[int]) -> Iterator[BoxList]:
        """The start as boxes, some parts at a time."""
        return map(self.box_starts, self.cut(cuts))

    def cut(self, cuts: Sequence[int]) -> Iterator[list[StartBox]]:
        """The parts that cuts make of a box around all starts, some at a time."""
        batch: list[StartBox] = []
        count, numbers = 0, iter(cuts)
        pending = [] if (whole := self.whole) is None else [whole]
        while pending:
            one = pending.pop()
            number = next(numbers, None)
            if number is None or number > len(self._columns):
                raise RejectedError("the cuts of the start end too early, or name a variable that there is not")
            if number:
                pending += reversed(halves(one, number - 1))
                continue
            batch.append(one)
            count += 1
            if count > self._most:
                raise RejectedError(f"the start is cut into more than {self._most:,} parts")
            if len(batch) == self._at_once:
                yield batch
                batch = []
        if next(numbers, None) is not None:
            raise RejectedError("the cuts of the start go on after their end")
        if batch:
            yield batch

    @property
    def whole(self) -> StartBox | None:
        """A box around all starts; None where bounds show that there are none."""
        ends = [one.range for one in self._system.variables]
        low, high = np.array([floor(low) for low, _ in ends]), np.array([ceiling(high) for _, high in ends])
        boxes = self.box_starts([StartBox(low, high)])
        return StartBox(boxes.low[0], boxes.high[0]) if boxes.size else None

    def box_starts(self, parts: Sequence[StartBox]) -> BoxList:
        """Boxes around the starts in some parts."""
        none = np.zeros(len(parts), dtype=np.int64)
        lows, highs = np.array([one.low for one in parts]), np.array([one.high for one in parts])
        boxes = BoxList.of(lows, highs, np.arange(len(parts)), none)
        return self._start.within(boxes)
