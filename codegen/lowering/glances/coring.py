"""The lowered cores of lists of boxes: for each cell along one variable a box that lies within them, where states are.

Does: looks for the variable and the cells by which most of the states that were visited are told by one box.
Assumes: lists of closed boxes [n, variables] of finite float64; visited states, which decide nothing but how soon.
Does not: refuse a state: whoever is in no core is asked of the list itself.

A cell counts for a box if the box holds all of it along the variable, by EDGE and more: then that variable need not be
compared. The cells of all lists are in one row, and a number's place in it is a product and a sum. With what is rounded
before, that is off by five times 2^-53 of FAR at most, less than EDGE: so no state beyond a box is in a cell of
it. The first and the last cell of a list take what is beyond the others, and no number, and have no box; a place
that is rounded beyond them is in a cell of another list that has none. Where one variable is left, boxes that meet
are one. Without cells the box may be one that several boxes hold together (spanning.py).

Tried at the mountain car, where a step took 2.1 ns, and the call of a function alone takes .95: one number in place of
three flags takes .1 less, a place that is a product and a sum .1, boxes in float32 another .1 (but not where a list is
as thin as a point, as the first one is), a first row for no turn and one comparison less with a constant end .05. Cells
beside the row of their list take .1 more; a mean of both ends in float64 gains nothing, nor does a step that is built
into its caller, but for .2 of what a monitor adds to a control step. Cells that several boxes hold together tell .02 %
more states.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np

from codegen.ir import Bool, Float64, Int64
from codegen.lowering.glances.centring import centre_boxes, is_centred, write_centred
from codegen.lowering.glances.spanning import span_states
from codegen.lowering.parts import Cores, Ends
from codegen.lowering.searching import EDGE, INSIDE, Boxes, doubles_of, draw_points

SIZES = (8, 16, 32, 64)  # cells along a variable, the first and the last included
FEW = 16  # visited states of a list: with fewer, states are drawn in its boxes
MAX_PAIRS = 1 << 24  # of a visited state and a box of its list: with more, some states stand for all
ENOUGH = 0.9  # of the states that must be told by cores, so that it pays to have them
FAR = 2.0**20  # cells, from 0 and from the first of all
NARROWEST = 2.0**-960  # of a cell: parts of it and its inverse are numbers without underflow
GIVEN, INWARD = 1e-3, 0.01  # of the states, that cores in float32 may tell less, if they were so much further in
ALONG, MISSED, CELL = 0.9, 25.0, 0.003  # ns: what finding a cell takes, a state that no core tells, and a larger table


def find_cores(lists: Sequence[Boxes], visited: Sequence[Float64]) -> Cores | None:
    """Cores of lists, or None where they tell too few. `visited`: of each list some states, or nothing at all."""
    seen = [
        states if len(states) >= FEW else draw_points(boxes)
        for boxes, states in zip(lists, visited or [np.zeros((0, 0))] * len(lists), strict=True)
        if len(boxes.low)
    ]
    if len(seen) < len(lists):
        return None
    seen = [_thin_out(states, len(boxes.low)) for boxes, states in zip(lists, seen, strict=True)]
    halves = [_Visited(boxes, states[::2]) for boxes, states in zip(lists, seen, strict=True)]
    ways: list[tuple[float, int | None, int]] = []
    for axis, size in _list_ways(lists[0].low.shape[1]):
        if size * len(lists) > FAR:
            continue
        told = _measure_share(halves, [states[1::2] for states in seen], axis, size)
        if told >= ENOUGH:
            ways.append((MISSED * (1.0 - told) + (0.0 if axis is None else ALONG + CELL * size), axis, size))
        if ways and ways[0][0] < ALONG:
            break  # no variable does better
    if not ways:
        return None
    _, axis, size = min(ways, key=lambda way: way[0])
    laid = [_Cored(_Visited(boxes, states), axis, size) for boxes, states in zip(lists, seen, strict=True)]
    return _write_cores(laid, seen)


def _list_ways(count: int) -> Iterator[tuple[int | None, int]]:
    yield None, 1
    if count > 1:
        yield from ((axis, size) for axis in range(count) for size in SIZES)


def _thin_out(states: Float64, boxes: int) -> Float64:
    """Every so many of the states, so that there are few pairs of them with boxes."""
    return states[:: 1 + len(states) * boxes // MAX_PAIRS]


def _measure_share(made: Sequence[_Visited], asked: Sequence[Float64], axis: int | None, size: int) -> float:
    """The share of the states asked of lists that cores tell which others made; 0 once it cannot be enough."""
    missed = 0.0
    for visited, states in zip(made, asked, strict=True):
        missed += 1.0 - float(_Cored(visited, axis, size).tell(states).mean())
        if missed > (1.0 - ENOUGH) * len(made):
            return 0.0
    return 1.0 - missed / len(made)


class _Visited:
    """A list with visited states, and what all ways to divide it ask: which of its boxes hold which states."""

    def __init__(self, boxes: Boxes, states: Float64) -> None:
        self.boxes, self.states = boxes, states

    @cached_property
    def inside(self) -> Bool:
        """[states, boxes]."""
        inside = np.ones((len(self.states), len(self.boxes.low)), dtype=np.bool_)
        for column, low, high in zip(self.states.T, self.boxes.low.T, self.boxes.high.T, strict=True):
            inside &= column[:, None] >= low
            inside &= column[:, None] <= high
        return inside

    @cached_property
    def counts(self) -> Int64:
        """How many states each box holds."""
        return self.inside.sum(axis=0)


class _Cored:
    """The cores of a list: `row`, the least and most of its cells and their scale; `cores`, [size, others]."""

    def __init__(self, seen: _Visited, axis: int | None, size: int) -> None:
        boxes, states, visited = seen.boxes, seen.states, seen.counts
        self.axis, self.size = axis, size
        self.others = [at for at in range(boxes.low.shape[1]) if at != axis]
        self.row = 0.0, 0.0, 0.0
        held = np.ones((len(boxes.low), size), dtype=np.bool_)
        if axis is not None:
            near = visited > 0 if visited.any() else visited == 0
            self.row = lay_row(boxes.low[near, axis], boxes.high[near, axis], size)
            if max(-self.row[0], self.row[1]) * self.row[2] > FAR:
                self.row = 0.0, 0.0, 0.0
            held = self._hold_cells(boxes.low[:, axis], boxes.high[:, axis])
        others = Boxes(boxes.low[:, self.others], boxes.high[:, self.others])
        cells = self.find_cells(states)
        self.cores = Boxes(np.ones((size, len(self.others))), np.full((size, len(self.others)), -1.0))  # no state
        for cell in np.flatnonzero(held.any(axis=0)).tolist():
            here, of = np.flatnonzero(cells == cell), np.flatnonzero(held[:, cell])
            if len(self.others) == 1:
                core = _choose_joined(others.take(of), visited[of], states[here, self.others[0]])
            else:  # who is in a cell is between the ends of a box that holds it
                told = seen.inside[here[:, None], of].sum(axis=0)
                core = _choose_core(others.take(of), told, visited[of])
            self.cores.low[cell], self.cores.high[cell] = core
        if axis is None and len(self.others) > 1 and not self.tell(states).all():
            spanned = span_states(boxes, states[seen.inside.any(axis=1)]) if visited.any() else None
            if spanned is not None and _count_held(spanned, states) > _count_held(self.cores, states):
                self.cores = spanned

    def tell(self, states: Float64) -> Bool:
        """Which states are in a core."""
        cells, others = self.find_cells(states), states[:, self.others]
        return np.asarray(((others >= self.cores.low[cells]) & (others <= self.cores.high[cells])).all(axis=1))

    def miss_in_float32(self, states: Float64) -> Bool:
        """Which states are in a core, but not once it is in float32. They are moved a little towards their mean: boxes
        may end at some of them, and these do not stand for others.
        """
        cells, others = self.find_cells(states), states[:, self.others]
        inner = others + INWARD * (others.mean(axis=0) - others)
        held = np.asarray(((inner >= self.cores.low[cells]) & (inner <= self.cores.high[cells])).all(axis=1))
        middle, square = centre_boxes(self.cores)
        return held & ~is_centred(middle[cells], square[cells], inner)

    def _hold_cells(self, low: Float64, high: Float64) -> Bool:
        """Which cells lie within bounds along the variable, [n, size]."""
        least, _, scale = self.row
        if scale == 0.0:
            return np.zeros((len(low), self.size), dtype=np.bool_)
        with np.errstate(over="ignore"):
            first, last = (low - least) * scale, (high - least) * scale
        cells = np.arange(self.size)
        held = (first[:, None] < cells - EDGE) & (last[:, None] > cells + 1.0 + EDGE)
        held[:, [0, -1]] = False
        return held

    def find_cells(self, states: Float64) -> Int64:
        """The cells of states."""
        if self.axis is None:
            return np.zeros(len(states), dtype=np.int64)
        return place_numbers(states[:, self.axis], self.row, self.size)


def place_numbers(numbers: Float64, row: tuple[float, float, float], size: int) -> Int64:
    """The cells of numbers along a variable, as code finds them."""
    least, most, scale = row
    with np.errstate(over="ignore", invalid="ignore"):
        places = (np.clip(numbers, least, most) - least) * scale
    return np.clip(np.nan_to_num(places), 0.0, size - 1.0).astype(np.int64)


def lay_row(low: Float64, high: Float64, size: int) -> tuple[float, float, float]:
    """Cells over boxes, with one more before and after them: the least and most, and the scale; all 0 where they have
    no width, or more than floats have, or so little that rounding puts what is beyond them into another cell than the
    last. Those at the ends are held by the boxes, for these reach a little beyond.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        first, last = float(low.min()), float(high.max())
        side = (last - first) * (1.0 - 2.0**-20) / (size - 2)
        least = first - side * (1.0 - 2.0**-20)
        scale = 1.0 / side if side > NARROWEST else 0.0
        most = least + side * size * INSIDE
        known = np.isfinite([least, most, most - least, scale]).all()
        last = int((most - least) * scale) if known else 0
    return (least, most, scale) if last == size - 1 else (0.0, 0.0, 0.0)


def _write_cores(laid: Sequence[_Cored], seen: Sequence[Float64]) -> Cores:
    """The cores of all lists. In float32 where that tells about as many of the states seen."""
    axis, others, size = laid[0].axis, laid[0].others, laid[0].size
    none = Boxes(np.ones((1, len(others))), np.full((1, len(others)), -1.0))
    cores = [cored.cores for cored in laid]
    joined = [none, *cores] if axis is None else [*cores, none]  # behind a row, where its last place is rounded up
    boxes = Boxes(*(np.concatenate(ends) for ends in zip(*joined, strict=True)))
    ends = tuple(Ends(doubles_of(low), doubles_of(high)) for low, high in zip(*boxes, strict=True))
    rows = [(0.0, 0.0, 0.0, size * len(laid))]
    rows += [(*cored.row, size * at - cored.row[0] * cored.row[2]) for at, cored in enumerate(laid)]
    written = () if axis is None else tuple(doubles_of(np.array(row)) for row in rows)
    missed = np.concatenate([cored.miss_in_float32(states) for cored, states in zip(laid, seen, strict=True)])
    centred = write_centred(*centre_boxes(boxes)) if float(missed.mean()) <= GIVEN else ()
    return Cores(axis, tuple(others), size, written, ends, centred)


def _count_held(boxes: Boxes, states: Float64) -> int:
    return int(boxes.holds(states).sum())


def _choose_joined(boxes: Boxes, visited: Int64, here: Float64) -> tuple[Float64, Float64]:
    """As `_choose_core` where one variable is left: boxes that meet are one."""
    order = np.argsort(boxes.low[:, 0], kind="stable")
    low, high = boxes.low[order, 0], np.maximum.accumulate(boxes.high[order, 0])
    with np.errstate(over="ignore"):
        begins = np.flatnonzero(np.append(True, low[1:] > np.nextafter(high[:-1], np.inf)))
    ends = np.append(begins[1:], len(low)) - 1
    low, high = low[begins], high[ends]
    told = ((here[:, None] >= low) & (here[:, None] <= high)).sum(axis=0)
    return _choose_core(Boxes(low[:, None], high[:, None]), told, np.add.reduceat(visited[order], begins))


def _choose_core(boxes: Boxes, told: Int64, visited: Int64) -> tuple[Float64, Float64]:
    """Of boxes that hold a cell the one with most of the states in it (`told`), then of all in the list, then the
    largest.
    """
    best = np.flatnonzero(told == told.max())
    best = best[visited[best] == visited[best].max()]
    with np.errstate(over="ignore"):
        widest = (boxes.high - boxes.low).max(axis=0)
        sides = boxes.high[best] - boxes.low[best]
        sizes = np.divide(sides, widest, out=np.ones_like(sides), where=(widest > 0) & np.isfinite(widest)).prod(axis=1)
    last = best[np.flatnonzero(sizes == sizes.max())[-1]]
    return boxes.low[last], boxes.high[last]
