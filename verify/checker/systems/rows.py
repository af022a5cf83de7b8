"""The checker's own symbolic states: sums over unknowns with bounds and rows, and what contradicts these.

Does: what the bounds of unknowns settle about a row; whether a sum of rows is beyond these bounds.
Assumes: nothing; belongs to what must be right for a certificate to mean something.
Does not: know systems, trees or claims.

An unknown lies in [0, 1]: how far a start variable is between its bounds, or the error of a variable in a step. A
symbolic state is, for each variable that is followed, a sum of multiples of unknowns (its motion) and a number.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from fractions import Fraction
from typing import NamedTuple

Weights = Mapping[int, Fraction]  # by unknown
Terms = tuple[tuple[Fraction, str], ...]  # weight, variable


class Span(NamedTuple):
    """Bounds of a number, each of which it may not be allowed to meet."""

    low: Fraction
    low_open: bool
    high: Fraction
    high_open: bool


UNIT = Span(Fraction(0), False, Fraction(1), False)


class Direction:
    """A sum of multiples of unknowns: whole numbers without a common divisor, the first of them above 0."""

    def __init__(self, weights: tuple[tuple[int, int], ...]) -> None:
        self.weights = weights  # (unknown, multiple), by unknown
        self.bits = max(abs(weight) for _, weight in weights).bit_length()  # multipliers are per 2**bits
        self.low = Fraction(sum(min(weight, 0) for _, weight in weights))
        self.high = Fraction(sum(max(weight, 0) for _, weight in weights))
        self.mask = sum(1 << unknown for unknown, _ in weights)  # the set of its unknowns
        self.alone = weights[0][0] if len(weights) == 1 else None  # the unknown, where there is one only


class Row(NamedTuple):
    """A direction is at most `end`, or with `upper` False at least; below or above it where `strict`."""

    direction: Direction
    upper: bool
    end: Fraction
    strict: bool

    def opposite(self) -> Row:
        """Returns the row that holds where this one does not."""
        return Row(self.direction, not self.upper, self.end, not self.strict)


class VariableSum:
    """A sum of multiples of followed variables; one object for equal sums."""

    def __init__(self, terms: Terms) -> None:
        self.terms = terms


class Motion:
    """The dependence of the followed variables on the unknowns after some steps; one object for equal dependence."""

    def __init__(self, weights: Mapping[str, Weights], unknowns: tuple[tuple[int, str], ...]) -> None:
        self.weights = weights
        self.unknowns = unknowns  # (number of the step, variable) of each error; of start variables the step is -1
        self.directions: dict[VariableSum, tuple[Direction | None, Fraction]] = {}
        self.later: dict[int, Motion] = {}  # by kind of step


class Branch:
    """A symbolic state: all states that some values of the unknowns within `box` and all `rows` lead to."""

    def __init__(self, step: int, motion: Motion, at: Mapping[str, Fraction]) -> None:
        self.step = step
        self.motion = motion
        self.at = at  # the number that is added, by variable
        self.added: dict[VariableSum, Fraction] = {}  # the same for sums of variables, as far as they were asked about
        self.box: Mapping[int, Span] = {}  # of unknowns that are bounded more narrowly than by [0, 1]
        self.rows: tuple[Row, ...] = ()
        self.pieces: tuple[int, ...] = ()  # that moved it
        self.note: object = None  # whoever answers questions may keep something here

    def copy(self) -> Branch:
        """The same again."""
        other = Branch(self.step, self.motion, self.at)
        other.box, other.rows, other.pieces, other.note = self.box, self.rows, self.pieces, self.note
        other.added = self.added
        return other

    def with_row(self, row: Row) -> Branch:
        """Those of its states for which a row holds."""
        other, alone = self.copy(), row.direction.alone
        if alone is None:
            other.rows = (*self.rows, row)
        else:
            other.box = {**self.box, alone: _narrow_span(self.box.get(alone, UNIT), row)}
        return other

    def span(self, direction: Direction) -> Span:
        """Bounds of a direction by the box, and by the rows of that direction."""
        span = self._by_box(direction)
        for row in self.rows:
            if row.direction is direction:
                span = _narrow_span(span, row)
        return span

    def _by_box(self, direction: Direction) -> Span:
        if not self.box:
            return Span(direction.low, False, direction.high, False)
        if direction.alone is not None:  # its multiple is 1
            return self.box.get(direction.alone, UNIT)
        low, high = direction.low, direction.high
        low_open = high_open = False
        for unknown, weight in direction.weights:
            span = self.box.get(unknown)
            if span is not None:
                small, large = (span[:2], span[2:]) if weight > 0 else (span[2:], span[:2])
                low, high = low + weight * small[0], high + weight * large[0]
                low, high = low - min(weight, 0), high - max(weight, 0)
                low_open, high_open = low_open or small[1], high_open or large[1]
        return Span(low, low_open, high, high_open)

    def decide_row(self, row: Row) -> bool | None:
        """Returns whether a row holds for all its states or for none, as far as bounds tell; None where they do not."""
        low, low_open, high, high_open = self.span(row.direction)
        if not row.upper:
            low, low_open, high, high_open = -high, high_open, -low, low_open
        end = row.end if row.upper else -row.end
        if high < end or (high == end and (high_open or not row.strict)):
            return True
        return False if low > end or (low == end and (low_open or row.strict)) else None

    def is_contradicted(self, used: Iterable[tuple[Row, int]]) -> bool:
        """Returns True if rows, each times a number above 0 per 2**bits of its direction, sum to beyond all bounds."""
        used = list(used)
        most = max((row.direction.bits for row, _ in used), default=0)
        weights: dict[int, int] = {}
        total, strict = Fraction(0), False
        for row, times in used:
            factor = times << (most - row.direction.bits)
            factor = factor if row.upper else -factor
            for unknown, weight in row.direction.weights:
                weights[unknown] = weights.get(unknown, 0) + factor * weight
            total -= factor * row.end
            strict = strict or row.strict
        least, is_open = self._least(weights)
        return total + least > 0 or (total + least == 0 and (strict or is_open))

    def _least(self, weights: Mapping[int, int]) -> tuple[Fraction, bool]:
        """The greatest lower bound of a sum by the box, and whether it is out of reach."""
        least, is_open, whole = Fraction(0), False, 0
        for unknown, weight in weights.items():
            if not weight:
                continue
            span = self.box.get(unknown)
            if span is None:
                whole += min(weight, 0)
            else:
                end, beyond = span[:2] if weight > 0 else span[2:]
                least, is_open = least + weight * end, is_open or beyond
        return least + whole, is_open


def _narrow_span(span: Span, row: Row) -> Span:
    """The bounds of a direction once a row of that direction holds."""
    low, low_open, high, high_open = span
    if row.upper:
        high_open = row.strict if row.end < high else high_open or (row.strict and row.end == high)
        return Span(low, low_open, min(high, row.end), high_open)
    low_open = row.strict if row.end > low else low_open or (row.strict and row.end == low)
    return Span(max(low, row.end), low_open, high, high_open)
