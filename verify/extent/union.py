"""The volume of zones that overlap: of each the parts that no earlier one has.

Does: cuts the zones of one goal, the largest first, into parts without a common point, and adds up their volumes;
  beyond a budget of parts it bounds what a zone adds by its own volume.
Assumes: closed matrices of one problem; volumes of the zones themselves are known (violations.py).
Does not: keep the parts: one state may lie in zones of several leaves, and each zone is told whole.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import permutations
from typing import NamedTuple, TypeAlias

import numpy as np

from codegen.ir import Bool, Float64
from verify.progress import tell
from verify.zones.search import Branch
from verify.zones.tables import EPSILON, Problem

DEFAULT_PARTS = 200_000  # that zones are cut into, over all goals
NEAR = 1e-9  # within which float64 does not say that zones have no common point
Cells: TypeAlias = list[list[list[int]]]  # a zone: a closed matrix for each component


class Union(NamedTuple):
    """The volume of a union: at least, at most, in the units of the zones' volumes; and the parts made for it."""

    least: int
    most: int
    parts: int


def union(
    problem: Problem,
    zones: Sequence[Branch],
    own: Sequence[int],
    fixed: Mapping[str, str],
    measure: Callable[[Branch], int],
    budget: int,
) -> Union:
    """The volume of all zones together. `own`: the volume of each; `fixed`: as of `find_fixed_coordinates`;
    `measure`: of a zone.
    """
    order = sorted(range(len(zones)), key=lambda number: (-own[number], number))
    cutter = _Cutter(problem, fixed)
    matrices = [cutter.matrices(zones[number][1]) for number in order]
    bounds = np.array([[cell / problem.scale for cell in zones[number][1]] for number in order])
    turned = bounds[:, cutter.turned] if len(bounds) else bounds
    least = most = made = 0
    for place, number in enumerate(order):
        tell(place, len(order), "failing cells made disjoint")
        earlier = np.flatnonzero(_meeting(bounds[:place], turned[place]))
        parts = cutter.parts(matrices[place], [matrices[other] for other in earlier], bounds[earlier], budget - made)
        if parts is None:
            most += own[number]
            made = budget
            continue
        made += len(parts)
        volume = own[number] if not len(earlier) else sum(measure(((), cutter.flat(part))) for part in parts)
        least, most = least + volume, most + volume
    return Union(least, most, made)


def _meeting(bounds: Float64, turned: Float64) -> Bool:
    """Returns which of some zones [zones, cells] may meet one whose matrices are `turned` [cells]."""
    return np.asarray((bounds + turned >= -NEAR).all(axis=1))


class _Cutter:
    """Cuts zones of one problem."""

    def __init__(self, problem: Problem, fixed: Mapping[str, str]) -> None:
        self._sizes, self._scale = problem.sizes, problem.scale
        names = [[""] * size for size in problem.sizes]
        for name, (component, node) in problem.places.items():
            names[component][node] = name

        def root(name: str) -> str:
            while name in fixed:
                name = fixed[name]
            return name

        self._tied = [[[root(a) == root(b) for b in own] for a in own] for own in names]
        starts = np.cumsum([0, *(size * size for size in problem.sizes)])
        self.turned = np.concatenate(
            [
                start + np.arange(size * size).reshape(size, size).T.ravel()
                for start, size in zip(starts[:-1], self._sizes, strict=True)
            ]
        )

    def matrices(self, cells: Sequence[int]) -> Cells:
        """A zone's cells as matrices."""
        # of a sum of strict bounds one unit less says enough, and its opposite can be stated
        even = [-(-cell // EPSILON) * EPSILON - (cell % EPSILON != 0) for cell in cells]
        matrices, start = list[list[list[int]]](), 0
        for size in self._sizes:
            matrices.append([even[start + i * size : start + (i + 1) * size] for i in range(size)])
            start += size * size
        return matrices

    def flat(self, zone: Cells) -> list[int]:
        """The cells of a zone, given as matrices, in one list: the inverse of `matrices`."""
        return [cell for matrix in zone for row in matrix for cell in row]

    def parts(self, zone: Cells, others: Sequence[Cells], bounds: Float64, most: int) -> list[Cells] | None:
        """Returns what is left of a zone without others, in parts; None where more than `most` are met on the way.

        `bounds`: the others' [others, cells], in units of length.
        """
        left, work, met = list[Cells](), [(zone, 0)], 0
        while work:
            part, first = work.pop()
            met += 1
            if met > most:
                return None
            turned = np.array([cell / self._scale for cell in self.flat(part)])[self.turned]
            near = (first + int(k) for k in np.flatnonzero(_meeting(bounds[first:], turned)))
            number = next((number for number in near if not self._apart(part, others[number])), None)
            if number is None:
                left.append(part)
            else:
                work += [(piece, number + 1) for piece in self._without(part, others[number])]
        return left

    def _without(self, zone: Cells, other: Cells) -> Iterator[Cells]:
        """The parts of a zone that lie beyond one bound of another one and within those before."""
        left: Cells | None = zone
        for component, matrix in enumerate(other):
            for i, j in permutations(range(len(matrix)), 2):
                if left is None or left[component][i][j] <= matrix[i][j]:
                    continue
                beyond = self._cut(left, component, j, i, -matrix[i][j] - 1)
                if beyond is not None:
                    yield beyond
                left = self._cut(left, component, i, j, matrix[i][j])

    def _apart(self, zone: Cells, other: Cells) -> bool:
        """Returns True if two zones have no volume in common, as a pair of bounds alone says."""
        return any(
            a + b < 0 or (a + b == 0 and not tied)
            for one, two, ties in zip(zone, other, self._tied, strict=True)
            for row, column, tie in zip(one, zip(*two, strict=True), ties, strict=True)
            for a, b, tied in zip(row, column, tie, strict=True)
        )

    def _cut(self, zone: Cells, component: int, i: int, j: int, most: int) -> Cells | None:
        """The part of a zone with x_i - x_j <= most; None where that has no volume."""
        matrix = zone[component]
        thickness = most + matrix[j][i]
        if thickness < 0 or (not thickness and not self._tied[component][i][j]):
            return None
        if most >= matrix[i][j]:
            return zone
        onward = [most + far for far in matrix[j]]
        cut = [[min(a, row[i] + b) for a, b in zip(row, onward, strict=True)] for row in matrix]
        return [*zone[:component], cut, *zone[component + 1 :]]
