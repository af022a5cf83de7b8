"""Sums, products and functions of ranges of numbers, rounded outwards, for the second proof of enclosures.

Does: bounds of values and of slopes of sin, cos, tan, exp, roots, powers and reciprocals.
Assumes: Python's whole numbers.
Does not: use floats, or share arithmetic with verify/systems/enclosures.py.

Numbers are whole multiples of 2^-BITS. sin, cos and exp are short series of a small number, which is doubled until it
is the one asked for. A series ends with a term of one unit or less; from its second term on, each is less than half of
the one before, so two units more than hold the rest. pi is Machin's 16 arctan(1/5) - 4 arctan(1/239).
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from functools import lru_cache
from math import isqrt
from typing import NamedTuple, TypeAlias

from verify.checker.reading import RejectedError
from verify.systems.system import Interval

BITS = 128
ONE = 1 << BITS
MAX_HALVINGS = 40  # of an angle
HALF = ONE >> 8  # of what the series are taken
LARGEST_EXPONENT = 64 * ONE


class Range(NamedTuple):
    """All numbers from `low` to `high`, in multiples of 2^-BITS."""

    low: int
    high: int


ValueAndSlope: TypeAlias = tuple[Range, Range | None]  # of a function over a range; None: the slope has no bound


class UnboundedError(RejectedError):
    """Over a box a part of an expression may not be defined."""


# --- arithmetic


def up(value: Fraction | int) -> int:
    """The least multiple that is not below a number."""
    return -(-value.numerator * ONE // value.denominator)


def exactly(value: Fraction | int) -> Range:
    """One number."""
    return Range(value.numerator * ONE // value.denominator, up(value))


def outwards(bounds: Interval) -> Range:
    """The numbers between two."""
    return Range(-up(-bounds[0]), up(bounds[1]))


def plus(one: Range, other: Range) -> Range:
    """Sums."""
    return Range(one.low + other.low, one.high + other.high)


def minus(one: Range, other: Range) -> Range:
    """Differences."""
    return Range(one.low - other.high, one.high - other.low)


def times(one: Range, other: Range) -> Range:
    """Products."""
    ends = (one.low * other.low, one.low * other.high, one.high * other.low, one.high * other.high)
    return Range(min(ends) >> BITS, -(-max(ends) >> BITS))


def scale_range(one: Range, factor: int) -> Range:
    """Multiples by a positive number."""
    return Range(one.low * factor, one.high * factor)


def power(base: Range, exponent: int) -> Range:
    """Powers by a whole number from 0."""
    if exponent == 0:
        return Range(ONE, ONE)
    if exponent % 2 == 0:
        most = max(abs(base.low), abs(base.high))
        least = 0 if base.low <= 0 <= base.high else min(abs(base.low), abs(base.high))
        base = Range(least, most)
    low, high = Range(base.low, base.low), Range(base.high, base.high)
    lowest, highest = low, high
    for _ in range(exponent - 1):
        lowest, highest = times(lowest, low), times(highest, high)
    return Range(lowest.low, highest.high)


def inverse(span: Range) -> ValueAndSlope:
    """1 over numbers, and the slope of that."""
    low, high = span
    if low <= 0 <= high:
        raise UnboundedError
    value = Range(ONE * ONE // high, -(-ONE * ONE // low))
    return value, _negative(times(value, value))


def _negative(span: Range) -> Range:
    return Range(-span.high, -span.low)


# --- functions


def _sin(angle: Range) -> ValueAndSlope:
    return waves(angle)


def _cos(angle: Range) -> ValueAndSlope:
    sin, cos = waves(angle)
    return cos, _negative(sin)


def _tan(angle: Range) -> ValueAndSlope:
    """tan grows where cos is not 0, so its values at both ends bound it; its slope is 1 more than its square."""
    _, cos = waves(angle)
    if cos.low <= 0 <= cos.high:
        raise UnboundedError
    ends = [times(sin, inverse(below)[0]) for sin, below in map(waves_at, angle)]
    value = Range(ends[0].low, ends[1].high)
    return value, plus(Range(ONE, ONE), power(value, 2))


def _exp(span: Range) -> ValueAndSlope:
    if max(abs(span.low), abs(span.high)) > LARGEST_EXPONENT:
        raise UnboundedError
    value = Range(exp_at(span.low).low, exp_at(span.high).high)
    return value, value


def _root(span: Range) -> ValueAndSlope:
    """A square root and its slope, 1 over twice the root."""
    if span.low < 0:
        raise UnboundedError
    value = Range(isqrt(span.low << BITS), isqrt(span.high << BITS) + 1)
    return value, inverse(scale_range(value, 2))[0] if value.low > 0 else None


FUNCTIONS: dict[str, Callable[[Range], ValueAndSlope]] = {
    "sin": _sin,
    "cos": _cos,
    "tan": _tan,
    "exp": _exp,
    "sqrt": _root,
}


def waves(angle: Range) -> tuple[Range, Range]:
    """sin and cos of all angles of a range: those of its middle, off by at most half its width."""
    middle = (angle.low + angle.high) // 2
    off = max(angle.high - middle, middle - angle.low)
    sin, cos = waves_at(middle)
    return _near(sin, off), _near(cos, off)


def _near(value: Range, off: int) -> Range:
    return Range(max(value.low - off, -ONE), min(value.high + off, ONE))


@lru_cache(maxsize=1 << 14)
def waves_at(angle: int) -> tuple[Range, Range]:
    """sin and cos of a number."""
    halvings = _halvings(angle)
    small = Range(angle >> halvings, -(-angle >> halvings))
    square = _negative(power(small, 2))
    sin, cos = _series(small, square, 1, 2), _series(Range(ONE, ONE), square, 0, 2)
    for _ in range(halvings):
        both, squared = times(sin, cos), power(sin, 2)
        sin, cos = scale_range(both, 2), Range(ONE - 2 * squared.high, ONE - 2 * squared.low)
    return sin, cos


@lru_cache(maxsize=1 << 14)
def exp_at(number: int) -> Range:
    """exp of a number, above 0."""
    halvings = _halvings(number)
    enclosure = _series(Range(ONE, ONE), Range(number >> halvings, -(-number >> halvings)), 0, 1)
    for _ in range(halvings):
        enclosure = times(enclosure, enclosure)
    return enclosure


def _halvings(number: int) -> int:
    """Returns how often a number is halved for a series."""
    count = 0
    while abs(number) >> count > HALF:
        count += 1
    if count > MAX_HALVINGS:
        raise RejectedError("a function of a number beyond all use")
    return count


def _series(first: Range, factor: Range, k: int, steps: int) -> Range:
    """The series that begins with a term, whose next terms are the ones before times factor / (k (k - 1)), or / k."""
    total = term = first
    while max(abs(term.low), abs(term.high)) > 1:
        k += steps
        grown, divisor = times(term, factor), k * (k - 1) if steps == 2 else k
        term = Range(grown.low // divisor, -(-grown.high // divisor))
        total = plus(total, term)
    return Range(total.low - 2, total.high + 2)


@lru_cache(maxsize=1)
def pi() -> Range:
    """pi, by its neighbours."""
    return minus(scale_range(_arctan(5), 16), scale_range(_arctan(239), 4))


def _arctan(n: int) -> Range:
    """arctan(1 / n): 1 / n - 1 / (3 n^3) + ..., whose rest is below the first term left out."""
    total, power_of, k = 0, ONE // n, 1
    lost = 1  # by terms that are rounded down, and by the rest
    while power_of:
        total += power_of // k if k % 4 == 1 else -(power_of // k)
        lost += 2
        power_of //= n * n
        k += 2
    return Range(total - lost, total + lost)
