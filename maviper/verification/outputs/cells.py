"""The leaves of two trees that meet: which boxes and half spaces of observations they share.

Does: walks both trees at once over ranges of the features; leaves out what no observation reaches, by boxes.
Assumes: checked trees over the same features; ranges that are finite.
Does not: decide sums exactly: a half space is kept as it is written, without the rounding of sums.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from codegen import ir
from codegen.floats import FLOAT32
from codegen.ir import Float64
from codegen.numbers import neighbour
from codegen.sums import CONSTANT, FLOAT64_SUMS

SLACK = 1e-6  # relative, of what rounding of a sum may change


@dataclass(frozen=True)
class Plane:
    """A half space `weights @ x <= limit`."""

    weights: Float64  # [n_features]
    limit: float
    test: tuple[ir.Sum, str, float, bool] | None = None  # what was tested: sum, arithmetic, threshold, whether it held

    def settles(self, each: ir.Sum, arithmetic: str, threshold: float) -> bool | None:
        """Returns True if another test of the sum holds here, rounding included, else False; None if that is open."""
        if self.test is None or self.test[:2] != (each, arithmetic):
            return None
        _, _, limit, held = self.test
        return held if (limit <= threshold if held else threshold <= limit) else None


@dataclass(frozen=True)
class Cell:
    """A leaf of each tree, and the observations that both send there: a box, and half spaces of tested sums."""

    first: int
    second: int
    low: Float64  # [n_features]
    high: Float64
    planes: tuple[Plane, ...]


def affine(each: ir.Sum, n_features: int) -> tuple[Float64, float]:
    """The weights [n_features] and the constant of a sum."""
    weights, constant = np.zeros(n_features), 0.0
    for weight, place in each.terms:
        if place == CONSTANT:
            constant += weight
        else:
            weights[place] += weight
    return weights, constant


def extremes(weights: Float64, constant: float, low: Float64, high: Float64) -> tuple[float, float]:
    """The least and most that weighted features may be in a box."""
    ends = np.sort(np.stack([weights * low, weights * high]), axis=0)
    return float(constant + ends[0].sum()), float(constant + ends[1].sum())


def cells(first: ir.AgentPolicy, second: ir.AgentPolicy, low: Float64, high: Float64) -> Iterator[Cell]:
    """Every pair of leaves that boxes do not part. `low`, `high`: the ranges, [n_features] each."""
    stack = [Cell(ir.ROOT, ir.ROOT, low, high, ())]
    while stack:
        cell = stack.pop()
        policy, node = (first, cell.first) if _splits(first, cell.first) else (second, cell.second)
        if not _splits(policy, node):
            yield cell
            continue
        for side in (False, True):
            child = int(policy.tree.left[node] if side else policy.tree.right[node])
            part = _part(policy, node, cell, left=side)
            if part is not None:
                places = (child, cell.second) if policy is first and node == cell.first else (cell.first, child)
                stack.append(Cell(*places, part.low, part.high, part.planes))


def _splits(policy: ir.AgentPolicy, node: int) -> bool:
    return int(policy.tree.feature[node]) != ir.NO_FEATURE


def _part(policy: ir.AgentPolicy, node: int, cell: Cell, *, left: bool) -> Cell | None:
    """The part of a cell on one side of a test; None where the box has none."""
    tree, n = policy.tree, len(policy.features)
    place, limit = int(tree.feature[node]), float(tree.threshold[node])
    if place < n:
        low, high = cell.low.copy(), cell.high.copy()
        if left:
            high[place] = min(high[place], limit)
        else:
            low[place] = max(low[place], float(neighbour(limit, np.inf, policy.numbers)))
        return None if low[place] > high[place] else Cell(cell.first, cell.second, low, high, cell.planes)
    each = tree.sums[place - n]
    for plane in cell.planes:
        settled = plane.settles(each, tree.arithmetic, limit)
        if settled is not None:
            return cell if settled == left else None
    weights, constant = affine(each, n)
    least, most = extremes(weights, constant, cell.low, cell.high)
    doubt = SLACK * (abs(least) + abs(most) + abs(limit)) if tree.arithmetic != FLOAT64_SUMS else 0.0
    if (least - doubt > limit) if left else (most + doubt <= limit):
        return None
    if (most + doubt <= limit) if left else (least - doubt > limit):
        return cell
    test = (each, tree.arithmetic, limit, left)
    plane = Plane(weights, limit - constant, test) if left else Plane(-weights, constant - limit, test)
    return Cell(cell.first, cell.second, cell.low, cell.high, (*cell.planes, plane))


def ranges(policy: ir.AgentPolicy) -> tuple[Float64, Float64]:
    """The least and most of each feature, [n_features] each."""
    ends = np.array([(feature.low, feature.high) for feature in policy.features], np.float64)
    return ends[:, 0], ends[:, 1]


def clip_rows(rows: Float64, low: Float64, high: Float64, numbers: str) -> ir.Floats:
    """Observations [n, n_features] in the agent's numbers, within the ranges."""
    rounded = rows.astype(numbers)
    if numbers == FLOAT32:  # rounding may leave a range by one number
        rounded = np.where(rounded > high, neighbour(rounded, -np.inf), rounded)
        rounded = np.where(rounded < low, neighbour(rounded, np.inf), rounded)
    return rounded
