"""Exact volumes of polytopes given by difference bounds, and of disjunctions, which are made mutually exclusive.

Does: d! times the volume of a closed matrix of integers, by recursion over facets, counting the faces it visits;
  numbers the opposite of every bound of a table; rewrites flat formulas so that no point is on two branches.
Assumes: closed matrices, node 0 standing for zero, every coordinate bounded on both sides; all formulas of the question
  are numbered in the table already.
Does not: sample; go on beyond its budget of faces; change what a formula says.

A polytope of dimension d is the union of the pyramids over its facets from one of its vertices, so d! vol is the sum
of height times (d-1)! vol of the facet (Lasserre 1983). On the facet x_i - x_j = c two coordinates differ by a
constant: it is again given by difference bounds, in one coordinate less; coefficients are 1, so no roots appear, and
d! vol of a matrix of integers is an integer. The vertex is where every coordinate is least: facets through it add
nothing.
"""

from collections.abc import Callable, Sequence
from functools import cache
from itertools import product
from math import factorial
from typing import TypeAlias

from verify.spending import SpentError
from verify.zones.tables import TRUE, Bound, Flat, Table

Disjoint: TypeAlias = Callable[[Flat | None], Flat | None]  # None: false


def disjoint(table: Table) -> Disjoint:
    """The rewriting for the formulas of a table; adds the opposites of its bounds to the table's numbers."""
    opposite: dict[int, int] = {}
    for bound, number in list(table.numbers.items()):
        other = Bound(bound.lower, bound.upper, -bound.over, bound.under, not bound.strict)
        opposite[number] = table.numbers.setdefault(other, len(table.numbers))

    @cache
    def split(flat: Flat | None) -> Flat | None:
        """The formula itself, its choices disjoint."""
        return flat and _all([Flat(flat.edges, ()), *map(split_choice, flat.ors)])

    @cache
    def split_choice(parts: tuple[Flat, ...]) -> Flat | None:
        """Some of the parts: the first that holds."""
        return _some([_all([*map(deny_flat, parts[:place]), split(part)]) for place, part in enumerate(parts)])

    @cache
    def deny_flat(flat: Flat) -> Flat | None:
        """Not the formula: the first of its bounds and choices that fails."""
        held: list[Flat | None] = [*(Flat((edge,), ()) for edge in flat.edges), *map(split_choice, flat.ors)]
        fails: list[Flat | None] = [Flat((opposite[edge],), ()) for edge in flat.edges]
        fails += [_all([deny_flat(part) for part in choice]) for choice in flat.ors]
        return _some([_all([*held[:place], fail]) for place, fail in enumerate(fails)])

    return split


def _all(parts: Sequence[Flat | None]) -> Flat | None:
    edges: list[int] = []
    ors: list[tuple[Flat, ...]] = []
    for part in parts:
        if part is None:
            return None
        edges += [edge for edge in part.edges if edge not in edges]
        ors += [choice for choice in part.ors if choice not in ors]
    return Flat(tuple(edges), tuple(ors))


def _some(parts: Sequence[Flat | None]) -> Flat | None:
    """A choice between parts that exclude one another."""
    possible = tuple(part for part in parts if part is not None)
    if TRUE in possible:
        return TRUE
    return possible[0] if len(possible) == 1 else Flat((), (possible,)) if possible else None


DEFAULT_FACES = 1_000_000


class FacesError(SpentError):
    """The budget of faces has ended."""


class Volumes:
    """Volumes with a common memory and a common budget of faces."""

    def __init__(self, budget: int = DEFAULT_FACES) -> None:
        self.budget, self.faces = budget, 0
        self._known: dict[tuple[int, ...], int] = {}

    def measure(self, cells: Sequence[int], size: int) -> int:
        """d! times the volume, d = size - 1, of a closed matrix [size * size] given row by row; 0 when it is flat.

        FacesError when more faces are needed than the budget has left.
        """
        rows = [list(cells[row * size : row * size + size]) for row in range(size)]
        if any(rows[i][j] + rows[j][i] <= 0 for i in range(size) for j in range(i)):
            return 0
        volume = factorial(size - 1)
        for group in _independent(rows):
            nodes = [0, *group]
            part = [[rows[i][j] for j in nodes] for i in nodes]
            volume = volume // factorial(len(group)) * self._whole(part)
        return volume

    def _whole(self, rows: list[list[int]]) -> int:
        """Measures as `measure` does, for coordinates that hang together and a matrix that is not flat."""
        if len(rows) == 1:
            return 1
        if len(rows) == 2:
            return rows[0][1] + rows[1][0]
        if len(rows) == 3:  # twice a rectangle less two opposite corners, which are triangles with equal sides
            width, length = rows[1][0] + rows[0][1], rows[2][0] + rows[0][2]
            first, second = rows[1][0] + rows[0][2] - rows[1][2], rows[2][0] + rows[0][1] - rows[2][1]
            return 2 * width * length - first * first - second * second
        least = rows[0]
        moved = tuple(cell + least[i] - least[j] for i, row in enumerate(rows) for j, cell in enumerate(row))
        if moved not in self._known:
            self.faces += 1
            if self.faces > self.budget:
                raise FacesError
            # pyramids over the facets that do not go through the point 0, which is the least vertex
            size, total = len(rows), 0
            sides = [moved[row * size : row * size + size] for row in range(size)]
            for i, j in product(range(1, size), range(size)):
                height, others = sides[i][j], [k for k in range(size) if k not in (i, j)]
                # a bound that two others imply touches less than a facet
                if i != j and height and not any(sides[i][k] + sides[k][j] == height for k in others):
                    total += height * self.measure(_facet(sides, i, j), size - 1)
            self._known[moved] = total
        return self._known[moved]


def _independent(rows: list[list[int]]) -> list[list[int]]:
    """The coordinates, grouped so that no bound on a difference joins two groups but those that the box implies."""
    groups: list[list[int]] = []
    for i in range(1, len(rows)):
        joined = [
            group
            for group in groups
            if any(rows[i][j] < rows[i][0] + rows[0][j] or rows[j][i] < rows[j][0] + rows[0][i] for j in group)
        ]
        groups = [group for group in groups if group not in joined]
        groups.append([*(node for group in joined for node in group), i])
    return groups


def _facet(rows: Sequence[Sequence[int]], i: int, j: int) -> list[int]:
    """The closed matrix of the face x_i - x_j = rows[i][j], without node i."""
    nodes = [k for k in range(len(rows)) if k != i]
    gap = rows[i][j]
    out = [min(rows[j][k], rows[i][k] - gap) for k in nodes]
    into = [min(rows[k][j], rows[k][i] + gap) for k in nodes]
    return [
        0 if k == m else min(rows[k][m], before + after)
        for k, before in zip(nodes, into, strict=True)
        for m, after in zip(nodes, out, strict=True)
    ]
