"""The largest difference between what two agents give, or an observation at which they act differently.

Does: for each pair of leaves that meet, looks for extremes by linear programs over pieces (cut below, within, above);
  replays what it finds in both references.
Assumes: comparable agents (compared.py).
Does not: prove by floating point: a bound by linear programs is told as one, a difference that was replayed is exact.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.optimize import linprog

from codegen import ir
from codegen.ir import Float64
from maviper.verification.outputs.cells import Cell, Plane, affine, cells, clip_rows, extremes

NUDGES = (0.0, 1e-7, 1e-4, 1e-2)  # from an extreme towards the middle of its cell: rounding may lie beyond a tie


@dataclass(frozen=True)
class Found:
    """Two agents beside one another at one observation."""

    difference: float  # of an output, replayed; 1 for other actions
    seen: tuple[float, ...]  # the observation, in the agent's numbers
    leaves: tuple[int, int]


@dataclass(frozen=True)
class Apart:
    """The difference of one output. `most`: the bound by linear programs, None where the cells were too many."""

    output: str
    unit: str
    found: Found | None  # None: no difference was met
    most: float | None


@dataclass
class _Best:
    found: Found | None = None
    most: float = 0.0

    @property
    def reached(self) -> float:
        """The largest difference so far."""
        return 0.0 if self.found is None else self.found.difference


@dataclass(frozen=True)
class Searched:
    """The outcome of a search: by output, or one entry for actions; whether every pair of leaves was looked at, and
    whether boxes alone decided, so that a difference of 0 is exact.
    """

    apart: tuple[Apart, ...]
    cells: int
    complete: bool
    exact: bool


def search(first: ir.AgentPolicy, second: ir.AgentPolicy, low: Float64, high: Float64, max_cells: int) -> Searched:
    """The largest differences of two agents over ranges of their features, [n_features] each."""
    best = [_Best() for _ in first.outputs] or [_Best()]
    looked, complete, exact = 0, True, True
    for cell in cells(first, second, low, high):
        if looked == max_cells:
            complete = False
            break
        looked += 1
        exact &= not cell.planes
        if first.outputs:
            exact &= _outputs(first, second, cell, best)
        elif not _alike(first, second, cell):
            for point in _points(cell, np.zeros(len(low))):
                _replay(first, second, cell, point, best)
                best[0].most = 1.0
    labels = [(output.name, output.unit) for output in first.outputs] or [("action", "")]
    apart = (
        Apart(name, unit, each.found, max(each.most, each.reached) if complete else None)
        for (name, unit), each in zip(labels, best, strict=True)
    )
    return Searched(tuple(apart), looked, complete, exact)


def _alike(first: ir.AgentPolicy, second: ir.AgentPolicy, cell: Cell) -> bool:
    return int(first.tree.action[cell.first]) == int(second.tree.action[cell.second])


def _outputs(first: ir.AgentPolicy, second: ir.AgentPolicy, cell: Cell, best: list[_Best]) -> bool:
    """Looks at every output in a cell; whether both leaves give numbers only, so that no program rounds."""
    n = len(first.features)
    vectors = [policy.tree.vectors[int(policy.tree.action[leaf])] for policy, leaf in _leaves(first, second, cell)]
    constant = True
    for place, spec in enumerate(first.outputs):
        given = [affine(vector[place], n) for vector in vectors]
        constant &= not any(weights.any() for weights, _ in given)
        other = second.outputs[place]
        if vectors[0][place] == vectors[1][place] and (spec.low, spec.high) == (other.low, other.high):
            continue
        ends = [_cut(extremes(*each, cell.low, cell.high), s) for each, s in zip(given, (spec, other), strict=True)]
        bound = max(ends[0][1] - ends[1][0], ends[1][1] - ends[0][0])
        if bound <= best[place].reached:
            continue
        pieces = product(_pieces(given[0], spec, cell), _pieces(given[1], other, cell))
        for sign, (one, two) in product((1, -1), pieces):
            _piece(first, second, cell, sign, one, two, best, place)
    return constant


def _leaves(first: ir.AgentPolicy, second: ir.AgentPolicy, cell: Cell) -> Iterator[tuple[ir.AgentPolicy, int]]:
    yield first, cell.first
    yield second, cell.second


def _cut(ends: tuple[float, float], spec: ir.OutputSpec) -> tuple[float, float]:
    low, high = (-np.inf if spec.low is None else spec.low), (np.inf if spec.high is None else spec.high)
    return min(max(ends[0], low), high), min(max(ends[1], low), high)


@dataclass(frozen=True)
class _Piece:
    """Where a sum is cut to a bound, or is within both: what is given there, and its half spaces."""

    weights: Float64
    constant: float
    planes: tuple[Plane, ...]


def _pieces(given: tuple[Float64, float], spec: ir.OutputSpec, cell: Cell) -> Iterator[_Piece]:
    weights, constant = given
    least, most = extremes(weights, constant, cell.low, cell.high)
    low, high = (-np.inf if spec.low is None else spec.low), (np.inf if spec.high is None else spec.high)
    none = np.zeros_like(weights)
    above, below = Plane(-weights, constant - high), Plane(weights, low - constant)
    if most > high:
        yield _Piece(none, high, (above,) if least < high else ())
    if least < low:
        yield _Piece(none, low, (below,) if most > low else ())
    if most >= low and least <= high:
        within = [Plane(weights, high - constant)] if most > high else []
        within += [Plane(-weights, constant - low)] if least < low else []
        yield _Piece(weights, constant, tuple(within))


def _piece(
    first: ir.AgentPolicy,
    second: ir.AgentPolicy,
    cell: Cell,
    sign: int,
    one: _Piece,
    two: _Piece,
    best: list[_Best],
    place: int,
) -> None:
    """The extreme of sign * (one - two) in a piece of a cell, kept where it is the largest."""
    part = Cell(cell.first, cell.second, cell.low, cell.high, (*cell.planes, *one.planes, *two.planes))
    weights, constant = sign * (one.weights - two.weights), sign * (one.constant - two.constant)
    for point in _points(part, weights):
        best[place].most = max(best[place].most, float(weights @ point + constant))
        _replay(first, second, part, point, best)


def _points(cell: Cell, weights: Float64) -> Iterator[Float64]:
    """An observation of a cell at which weighted features are largest; none where the cell is empty."""
    if not cell.planes:
        yield np.where(weights > 0, cell.high, np.where(weights < 0, cell.low, _inner(cell)))
        return
    rows, limits = np.array([plane.weights for plane in cell.planes]), np.array([one.limit for one in cell.planes])
    scale = np.maximum(np.abs(rows).max(axis=1), np.finfo(np.float64).tiny)
    done = linprog(-weights, rows / scale[:, None], limits / scale, bounds=np.stack([cell.low, cell.high], axis=1))
    if done.status == 0:
        yield done.x


def _inner(cell: Cell) -> Float64:
    """The observation nearest to 0 that lies by 1 within a cell, or halfway across it."""
    inset = np.minimum(1.0, (cell.high - cell.low) / 2)
    return np.clip(0.0, cell.low + inset, cell.high - inset)


def _replay(first: ir.AgentPolicy, second: ir.AgentPolicy, cell: Cell, point: Float64, best: list[_Best]) -> None:
    """Both references at a point and a little beside it."""
    middle = _inner(cell)
    if cell.planes:
        middle = next(_points(cell, middle - point), middle)
    rows = clip_rows(
        np.array([point + share * (middle - point) for share in NUDGES]), cell.low, cell.high, first.numbers
    )
    leaves = [ir.apply(policy.tree, rows) for policy in (first, second)]
    if first.outputs:
        given = [ir.outputs(policy, rows).astype(np.float64) for policy in (first, second)]
        apart = np.abs(given[0] - given[1])
    else:
        apart = (ir.act(first, rows) != ir.act(second, rows)).astype(np.float64)[:, None]
    for row, differences in enumerate(np.nan_to_num(apart)):
        at = (int(leaves[0][row]), int(leaves[1][row]))
        for each, difference in zip(best, differences.tolist(), strict=True):
            if difference > each.reached:
                each.found = Found(difference, tuple(rows[row].astype(float).tolist()), at)
