"""A formula along one coordinate, everything else as it is: exact sets of rationals, and the float64 numbers in them.

Does: the values of a coordinate for which a formula is true; the interval of a value inside such a set, and the float64
  numbers of it.
Assumes: formulas without actions and goals (`formula.substitute_actions`, `formula.for_goal`); sums are linear in
  the coordinate.
Does not: know trees, regions or claims.

A set is a union of intervals between cuts. The cut (v, 0) lies just below v and (v, 1) just above it, so that one form
covers open and closed ends.
"""

import math
from collections.abc import Mapping
from fractions import Fraction
from typing import TypeAlias

from verify.claims.formula import And, Formula, Linear, Not, Or

Cut: TypeAlias = tuple[Fraction, int]
Line: TypeAlias = tuple[tuple[Cut, Cut], ...]  # disjoint intervals in order, each from its lower to its upper cut


def line_between(low: Fraction, high: Fraction) -> Line:
    """All values from `low` to `high`, both included."""
    return (((low, 0), (high, 1)),)


def along(formula: Formula, name: str, at: Mapping[str, Fraction], within: Line) -> Line:
    """The values of coordinate `name`, of those in `within`, for which `formula` is true at the point `at`."""
    if isinstance(formula, Linear):
        return _half_line(formula, name, at, within)
    if isinstance(formula, And):
        for part in formula.parts:
            within = along(part, name, at, within)
        return within
    if isinstance(formula, Or):
        return _join_intervals([interval for part in formula.parts for interval in along(part, name, at, within)])
    assert isinstance(formula, Not), formula
    return _without(within, along(formula.part, name, at, within))


def around(line: Line, value: float) -> tuple[float, float]:
    """The float64 numbers around `value` that lie in the set without another float64 number between: the ends, both in
    the set. `value` lies in the set.
    """
    low = high = value
    while (piece := _interval_of(line, low)) is not None:
        low = _first(piece[0])
        below = math.nextafter(low, -math.inf)
        if _interval_of(line, below) is None:
            break
        low = below  # a gap between two intervals that no float64 number lies in
    while (piece := _interval_of(line, high)) is not None:
        high = _last(piece[1])
        above = math.nextafter(high, math.inf)
        if _interval_of(line, above) is None:
            break
        high = above
    return low, high


def interval(line: Line, value: Fraction) -> tuple[Cut, Cut]:
    """The interval of the set in which `value` lies; it lies in the set."""
    return next((low, high) for low, high in line if low <= (value, 0) < high)


def beyond(line: Line, value: Fraction) -> list[Fraction]:
    """A number on either side of the interval of `value`, and outside the set; at an end that is left out, the end."""
    low, high = interval(line, value)
    place = line.index((low, high))
    below = line[place - 1][1][0] if place else low[0] - 1
    above = line[place + 1][0][0] if place + 1 < len(line) else high[0] + 1
    return [low[0] if low[1] else (below + low[0]) / 2, (high[0] + above) / 2 if high[1] else high[0]]


def _half_line(atom: Linear, name: str, at: Mapping[str, Fraction], within: Line) -> Line:
    weight, rest = Fraction(0), Fraction(0)
    for share, coordinate in atom.terms:
        if coordinate == name:
            weight += share
        else:
            rest += share * at[coordinate]
    if not weight:
        return within if rest < atom.bound or (rest == atom.bound and not atom.strict) else ()
    end = (atom.bound - rest) / weight
    if weight > 0:
        cut = (end, 0 if atom.strict else 1)
        return tuple((low, min(high, cut)) for low, high in within if low < cut)
    cut = (end, 1 if atom.strict else 0)
    return tuple((max(low, cut), high) for low, high in within if cut < high)


def _join_intervals(intervals: list[tuple[Cut, Cut]]) -> Line:
    """The union."""
    union: list[tuple[Cut, Cut]] = []
    for low, high in sorted(intervals):
        if union and low <= union[-1][1]:
            union[-1] = union[-1][0], max(union[-1][1], high)
        else:
            union.append((low, high))
    return tuple(union)


def _without(line: Line, other: Line) -> Line:
    """Returns the part of `line` that is not in `other`, which lies in it."""
    remaining: list[tuple[Cut, Cut]] = []
    for low, high in line:
        for start, end in other:
            if low <= start and end <= high:
                remaining += [(low, start)] if low < start else []
                low = end
        remaining += [(low, high)] if low < high else []
    return tuple(remaining)


def _interval_of(line: Line, value: float) -> tuple[Cut, Cut] | None:
    if not math.isfinite(value):
        return None
    cut = (Fraction(value), 0)
    return next(((low, high) for low, high in line if low <= cut < high), None)


def _first(low: Cut) -> float:
    """The least float64 number above a cut."""
    value = float(low[0])
    if (Fraction(value), 0) < low:
        value = math.nextafter(value, math.inf)
    return value


def _last(high: Cut) -> float:
    """The greatest float64 number below a cut."""
    value = float(high[0])
    if (Fraction(value), 0) >= high:
        value = math.nextafter(value, -math.inf)
    return value
