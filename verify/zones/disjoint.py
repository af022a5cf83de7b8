"""Rewrites disjunctions into mutually exclusive cases, so that volumes add up.

Does: numbers the opposite of every bound of a table; rewrites flat formulas so that no point is on two branches.
Assumes: all formulas of the question are numbered in the table already.
Does not: change what a formula says.
"""

from collections.abc import Callable, Sequence
from functools import cache
from typing import TypeAlias

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
