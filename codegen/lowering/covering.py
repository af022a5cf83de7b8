"""The lowered cover: boxes of states of which something is proved, joined to few, and grids by which one is found.

Does: joins closed boxes to fewer ones that hold the same float64 states; lays a grid over each list, along the
  variables that tell its boxes apart best, whose cells name the few boxes that may hold a state, the likeliest first.
Assumes: boxes [n, variables] of float64, without NaN, whose sides are infinite where a part does not bound a variable.
Does not: know what is proved, or write text (codegen/targets/rendered.py).

A state's cell is found by arithmetic alone, without a branch that could be guessed wrongly: a number is put between the
ends of a grid by comparing it with these, for which compilers have one instruction; with zero they take a jump. Then
the boxes of the cell are compared, with the very numbers of the proof: a wrong cell could refuse a state, and never
vouch for one. Cells have the boxes next to them too, so that rounding never puts a state into a wrong one.

Tried on the committed covers, which take 3 to 19 ns so: a tree of comparisons takes 15 to 97, since each waits for the
one before; eight cuts at once, without a tree, leave twice as many boxes to compare; a third axis or four times the
cells gain less than a tenth. A table of first boxes gained a tenth to a sixth, comparisons that end early a tenth more,
boxes grown over their neighbours up to a quarter. A path of its own for states that are well and inside gained nothing.
No jump at the border of a grid, one variable where a second one tells little, and a function for what comes after the
first box gained a seventh to a fifth on thin covers. A box of each cell, grown over others within it: a tenth more for
two variables, with 20 times the work here; for four nothing, since tables outgrow the cache. A variable of its own for
the grid of each list: up to a sixth slower.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations
from typing import ClassVar, NamedTuple

import numpy as np

from codegen.errors import InputError
from codegen.ir import Bool, Float64, Int64
from codegen.lowering.model import Double, Ends, RaisedSum

MAX_BOXES = 20_000  # of all lists together
MAX_GIVEN = 100_000  # before some are joined
COMPARED = 2_000  # boxes of one list that are compared with each other
AXES = 2  # variables along which grids are laid
CELLS = 1_024  # of a grid, at most
ENTRIES = 1_000_000  # boxes times cells of a grid, at most
POINTS = 300  # drawn in the boxes of a list: where they lie, searches are short
ENOUGH = 1.02  # boxes that are compared on average
DEAR = 0.03  # boxes: what a variable of the grid takes, since processors do not expect a second box
TRIED = 8  # lists by which the variables are chosen
INSIDE = 1.0 - 2.0**-40  # so that rounding puts no number beyond the last cell
EDGE = 2.0**-30  # of a cell: what is nearer to its border is in both
NARROW = 65_535  # what the narrow type of C counts to
LARGEST = float(np.finfo(np.float64).max)


class Boxes(NamedTuple):
    """Closed boxes: `low`, `high` [n, variables] float64."""

    low: Float64
    high: Float64

    def take(self, which: Bool | Int64) -> Boxes:
        """Some of them."""
        return Boxes(self.low[which], self.high[which])

    def holds(self, states: Float64) -> Bool:
        """Returns which states [batch, variables] lie in a box; whichever are fewer are gone through one by one."""
        if len(states) < len(self.low):
            inside = (((state >= self.low) & (state <= self.high)).all(axis=1).any() for state in states)
            return np.fromiter(inside, np.bool_, len(states))
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
        # of a step, in all parts; without a state, anywhere
        low = [max(float(part.low[:, variable].min(initial=np.inf)) for part in parts) for parts in self.steps]
        high = [min(float(part.high[:, variable].max(initial=-np.inf)) for part in parts) for parts in self.steps]
        return min(low), max(high)


class Grid(NamedTuple):
    """The grid of a list. Along each of its axes a state is in the cell floor((number - low) * scale), once its number
    is put between `low` and `high`; `strides` make one number of these, and `begin` is where its cells begin.
    """

    low: tuple[Double, ...]
    high: tuple[Double, ...]  # as `low` where there is one cell
    scale: tuple[Double, ...]
    strides: tuple[int, ...]
    begin: int

    def along(self, axes: Sequence[int]) -> Grid:
        """The same along some of its axes; of the others it has one cell."""
        low, high, scale = (tuple(each[at] for at in axes) for each in (self.low, self.high, self.scale))
        return Grid(low, high, scale, tuple(self.strides[at] for at in axes), self.begin)


@dataclass(frozen=True)
class Lookup:
    """Lists of boxes and their grids. A state is in the list of a step if it is in a box of each part of it."""

    kind: ClassVar = "cover"
    count: ClassVar = "N_VARIABLES"  # the name of how many numbers a state has

    columns: tuple[tuple[int, ...], ...]  # by part: the variables that its boxes bound, as many for each
    axes: tuple[tuple[int, ...], ...]  # by part: the variables of its grids, as many for each
    grids: tuple[Grid, ...]  # of each part of each step
    firsts: tuple[int, ...]  # by cell: the box that is compared first
    rests: tuple[int, ...]  # by cell: where in `order` those begin that are compared then
    order: tuple[int, ...]  # boxes, those of a cell followed by -1
    boxes: tuple[Ends, ...]  # the last one holds no state: it is the first of cells without a box
    most: int  # boxes of a cell, at most
    sums: tuple[RaisedSum, ...] = ()  # which a state has after its variables
    ever: bool = False  # whether there is one list, which holds at every step

    @property
    def counted(self) -> bool:
        """True if steps are counted since the start."""
        return not self.ever

    @property
    def parts(self) -> int:
        """The number of parts of a list."""
        return len(self.columns)

    @property
    def width(self) -> int:
        """The number of variables that a box bounds."""
        return len(self.columns[0])

    @property
    def last(self) -> int:
        """The last step, from 0; each has a list."""
        return len(self.grids) // self.parts - 1

    @property
    def divided(self) -> bool:
        """True if some grid has more than one cell."""
        return any(grid.low != grid.high for grid in self.grids)

    @property
    def counter(self) -> str:
        """The type in C of a box, and of a place in `order`: the narrower, the more of them a cache holds."""
        return "unsigned short" if max(len(self.order), len(self.boxes)) <= NARROW else "int"

    @property
    def comparisons(self) -> int:
        """The most that one step takes."""
        sizes = sum(len(each.terms) for each in self.sums)
        return sizes + self.parts * (2 * len(self.axes[0]) + 2 * self.width * self.most)


def lookup(steps: Sequence[Sequence[Boxes]], where: str) -> Lookup:
    """The search of lists: for each step its parts, as many at each. `where` is named in errors. InputError for too
    many boxes.
    """
    count = sum(len(part.low) for parts in steps for part in parts)
    lists = [[merge_boxes(part) for part in parts] for parts in steps] if count <= MAX_GIVEN else []
    count = sum(len(part.low) for parts in lists for part in parts) if lists else count
    if count > MAX_BOXES or not lists:
        what = f"the proof's sets are {count:,} boxes, and a monitor has room for {MAX_BOXES:,}"
        raise InputError(what, where, "verify the claim with wider cells, or for fewer steps")
    columns = [sorted({at for parts in lists for at in parts[number].bounded}) for number in range(len(lists[0]))]
    width = max(1, *map(len, columns))
    columns = [[*of, *[of[0] if of else 0] * (width - len(of))] for of in columns]  # twice the same changes nothing
    lists = [
        # of the same finite states
        [
            Boxes(np.maximum(part.low[:, of], -LARGEST), np.minimum(part.high[:, of], LARGEST))
            for part, of in zip(parts, columns, strict=True)
        ]
        for parts in lists
    ]
    counts = range(1, min(AXES, width) + 1)  # as many axes for each part
    ways = [
        [_lay_grids([parts[number] for parts in lists], count) for number in range(len(columns))] for count in counts
    ]
    laid = [grids for _, grids in min(ways, key=lambda way: sum(cost for cost, _ in way))]
    axes, grids, cells, boxes = [of[0].axes for of in laid], list[Grid](), list[tuple[int, ...]](), list[Ends]()
    for step, parts in enumerate(lists):
        for of, part in zip(laid, parts, strict=True):
            grids.append(of[step].grid._replace(begin=len(cells)))
            cells += [tuple(len(boxes) + box for box in each) for each in of[step].within()]
            boxes += (Ends(doubles_of(low), doubles_of(high)) for low, high in zip(*part, strict=True))
    axes, grids = _drop_idle(axes, grids)
    chosen = tuple(tuple(of[axis] for axis in along) for of, along in zip(columns, axes, strict=True))
    order, rests = _place_rests([each[1:] for each in cells])
    firsts = tuple(each[0] if each else len(boxes) for each in cells)
    boxes.append(Ends((Double.of(1.0),) * width, (Double.of(-1.0),) * width))
    most = max(1, *map(len, cells))
    return Lookup(tuple(map(tuple, columns)), chosen, tuple(grids), firsts, rests, order, tuple(boxes), most)


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
            # boxes that differ in this variable alone lie one after the other, and are joined where they meet
            end = size + variable
            others = [column for column in range(2 * size) if column not in (variable, end)]
            joined: list[Float64] = []
            for row in rows[np.lexsort([rows[:, variable], *(rows[:, column] for column in others)])]:
                last = joined[-1] if joined else None
                alike = last is not None and (last[others] == row[others]).all()
                if last is not None and alike and row[variable] <= np.nextafter(last[end], np.inf):
                    last[end] = max(last[end], row[end])
                else:
                    joined.append(row.copy())
            rows = np.array(joined, dtype=np.float64).reshape(len(joined), 2 * size)
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


def _drop_idle(axes: Sequence[tuple[int, ...]], grids: Sequence[Grid]) -> tuple[list[tuple[int, ...]], list[Grid]]:
    """The axes of each part along which some grid has more than one cell, as many for each; the grids along them."""
    whole = range(len(axes[0]))
    divided = [
        [at for at in whole if any(grid.low[at] != grid.high[at] for grid in grids[part :: len(axes)])]
        for part in range(len(axes))
    ]
    count = max(1, *map(len, divided))
    kept = [sorted([*of, *(at for at in whole if at not in of)][:count]) for of in divided]
    narrowed = [grid.along(kept[number % len(axes)]) for number, grid in enumerate(grids)]
    return [tuple(along[at] for at in of) for along, of in zip(axes, kept, strict=True)], narrowed


def _place_rests(cells: Sequence[tuple[int, ...]]) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """All boxes of cells in one row, each cell's followed by -1, and where they begin; like ones stand there once."""
    order, begins = list[int](), dict[tuple[int, ...], int]()
    for each in cells:
        if each not in begins:
            begins[each] = len(order)
            order += [*each, -1]
    return tuple(order), tuple(begins[each] for each in cells)


def _axes(lists: Sequence[Boxes], count: int) -> tuple[int, ...]:
    """The columns whose grid of a middling size leaves the fewest boxes to compare."""
    told = sorted((boxes for boxes in lists if len(boxes.low) > 1), key=lambda boxes: -len(boxes.low))[:TRIED]
    ways = list(combinations(range(lists[0].low.shape[1]), count))
    if not told or len(ways) == 1:
        return ways[0]
    points = [draw_points(boxes) for boxes in told]

    def sum_comparisons(way: tuple[int, ...]) -> float:
        sizes = [16] * count
        return sum(_Laid(boxes, way, sizes).count_comparisons(at) for boxes, at in zip(told, points, strict=True))

    return min(ways, key=sum_comparisons)


def _lay_grids(lists: Sequence[Boxes], count: int) -> tuple[float, list[_Laid]]:
    """A grid over each list along so many variables, and what searches take: a second one has to make them shorter."""
    points = [draw_points(boxes) if len(boxes.low) > 1 else None for boxes in lists]
    axes = _axes(lists, count)
    grids = [_lay_grid(boxes, of, axes) for boxes, of in zip(lists, points, strict=True)]
    compared = [laid.count_comparisons(of) for laid, of in zip(grids, points, strict=True) if of is not None]
    return count * DEAR * len(compared) + sum(compared), grids


def _lay_grid(boxes: Boxes, points: Float64 | None, axes: Sequence[int]) -> _Laid:
    """The grid of a list along some variables, as fine as makes searches shorter."""
    sizes = [1] * len(axes)
    best = _Laid(boxes, axes, sizes)
    while points is not None and (now := best.count_comparisons(points)) > ENOUGH:
        finer = [[2 * size if at == axis else size for at, size in enumerate(sizes)] for axis in range(len(axes))]
        finer = [each for each in finer if np.prod(each) <= min(CELLS, ENTRIES // len(boxes.low))]
        if not finer:
            break
        candidate = min((_Laid(boxes, axes, each) for each in finer), key=lambda laid: laid.count_comparisons(points))
        if candidate.count_comparisons(points) >= now and np.prod(candidate.sizes) > CELLS // 4:
            break
        best, sizes = candidate, candidate.sizes
    return best


class _Laid:
    """A grid of a size over a list of boxes."""

    def __init__(self, boxes: Boxes, axes: Sequence[int], sizes: Sequence[int]) -> None:
        self.boxes, self.axes, self.sizes = boxes, tuple(axes), list(sizes)
        count = len(boxes.low)
        self.low = boxes.low[:, list(axes)].min(axis=0) if count else np.zeros(len(sizes))
        high = boxes.high[:, list(axes)].max(axis=0) if count else np.zeros(len(sizes))
        with np.errstate(over="ignore"):
            sides = high - self.low
        known = np.isfinite(sides) & (sides > 0)
        with np.errstate(over="ignore"):
            cells = np.array(sizes, dtype=np.float64) * INSIDE
            scale = np.divide(cells, sides, out=np.zeros(len(sizes)), where=known)
        self.scale = np.where(np.isfinite(scale), scale, 0.0)
        self.high = np.where(self.scale > 0, high, self.low)
        self.strides = [int(np.prod(self.sizes[at + 1 :])) for at in range(len(self.sizes))]
        self._order: Int64 | None = None
        self._shares = self._measure_shares()

    @property
    def grid(self) -> Grid:
        """The grid as code has it, without its place."""
        high = np.where(np.array(self.sizes) > 1, self.high, self.low)
        return Grid(doubles_of(self.low), doubles_of(high), doubles_of(self.scale), tuple(self.strides), 0)

    def within(self) -> list[list[int]]:
        """The boxes of each cell that are needed, those that fill most of it first."""
        order, held = self._order_boxes(), self._shares >= 0.0
        cells = np.indices(self.sizes).reshape(len(self.sizes), -1).T
        near = [order[held[order[:, at], at], at] for at in range(len(cells))]
        return [self._find_needed(boxes, cell) for boxes, cell in zip(near, cells, strict=True)]

    def _find_needed(self, boxes: Int64, cell: Int64) -> list[int]:
        """Those of the boxes of a cell, in their order, of which none before them holds all that they hold there."""
        low, high = self.boxes.take(boxes)
        first, last = low.copy(), high.copy()  # without what is surely beyond the cell
        for at, axis in enumerate(self.axes):
            with np.errstate(over="ignore", invalid="ignore"):  # where the scale is 0, no side is cut
                places = (np.stack([low[:, axis], high[:, axis]]) - self.low[at]) * self.scale[at]
            first[places[0] < cell[at] - EDGE, axis] = -np.inf
            last[places[1] > cell[at] + 1.0 + EDGE, axis] = np.inf
        kept: list[int] = []
        for at in range(len(boxes)):
            around = (first[kept] <= first[at]).all(axis=1) & (last[kept] >= last[at]).all(axis=1)
            if not around.any():
                kept.append(at)
        return boxes[kept].tolist()

    def count_comparisons(self, points: Float64) -> float:
        """Returns how many boxes are compared for one of these states, on average."""
        place = (np.clip(points[:, list(self.axes)], self.low, self.high) - self.low) * self.scale
        cell = place.astype(np.int64) @ np.array(self.strides)
        low, high = self.boxes
        inside = ((points[:, None] >= low) & (points[:, None] <= high)).all(axis=2)
        return float(np.take_along_axis(inside, self._order_boxes()[:, cell].T, axis=1).argmax(axis=1).mean()) + 1.0

    def _order_boxes(self) -> Int64:
        if self._order is None:
            self._order = np.argsort(-self._shares, axis=0, kind="stable")
        return self._order

    def _measure_shares(self) -> Float64:
        """Returns how much of each cell each box fills, [n, cells]; -1 where it is not near."""
        low, high = self.boxes
        shares = np.ones((len(low), 1))
        near = np.ones((len(low), 1), dtype=np.bool_)
        others = [at for at in range(low.shape[1]) if at not in self.axes]
        with np.errstate(over="ignore"):
            sides = np.minimum(high - low, LARGEST)[:, others]
        widest = sides.max(axis=0, initial=0.0)
        rest = np.divide(sides, widest, out=np.ones_like(sides), where=widest > 0).prod(axis=1)
        for at, axis in enumerate(self.axes):
            edges = np.arange(self.sizes[at], dtype=np.float64)
            with np.errstate(over="ignore", invalid="ignore"):  # where the scale is 0, all are in the first cell
                places = (np.stack([low[:, axis], high[:, axis]]) - self.low[at]) * self.scale[at]
            first, last = np.where(self.scale[at] > 0, places, 0.0)[:, :, None]
            inner = (edges <= last + EDGE) & (edges + 1.0 >= first - EDGE)
            share = np.clip(np.minimum(last, edges + 1.0) - np.maximum(first, edges), 0.0, 1.0)
            share = share if self.scale[at] > 0 else np.ones_like(share)
            shares = (shares[:, :, None] * share[:, None]).reshape(len(low), -1)
            near = (near[:, :, None] & inner[:, None]).reshape(len(low), -1)
        return np.where(near, shares * rest[:, None], -1.0)


def draw_points(boxes: Boxes) -> Float64:
    """Points in the boxes, by volume, always the same ones."""
    ends = np.concatenate(boxes)
    finite = ends[np.abs(ends) < LARGEST]
    least, most = (float(finite.min()), float(finite.max())) if len(finite) else (0.0, 0.0)
    low, high = np.clip(boxes.low, least, most), np.clip(boxes.high, least, most)
    sides = high - low
    widest = sides.max(axis=0)
    sizes = np.divide(sides, widest, out=np.ones_like(sides), where=widest > 0).prod(axis=1)
    rng = np.random.default_rng(0)
    shares = sizes / sizes.sum() if sizes.sum() > 0 else np.full(len(sizes), 1.0 / len(sizes))
    chosen = rng.choice(len(sizes), POINTS, p=shares)
    return low[chosen] + rng.random((POINTS, low.shape[1])) * sides[chosen]


def doubles_of(values: Float64) -> tuple[Double, ...]:
    """Numbers as languages write them."""
    return tuple(Double.of(value) for value in values.tolist())
