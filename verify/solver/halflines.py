"""Tests of the deployed arithmetic as half lines of the unrounded difference: Z3's own reading of thresholds.

Does: gives the exact end of the differences, or coordinates, that a threshold lets go left.
Assumes: thresholds are numbers of the type that their agent compares, float32 or float64.
Does not: share the arithmetic of thresholds with codegen or with any other engine, so that consensus means something.

Machine rounding: a difference d of two float64 positions is observed as fl32(fl64(d)), or as fl64(d) by an agent that
compares float64. Rounding is monotone, so
"fl32(fl64(d)) <= t" is a half line of d. Its end is where the second rounding ties, then where the first one does; a
tie belongs to it iff the lower neighbour has an even significand. Replacing the threshold by that end makes the
question over the reals the machine's own question.
"""

import struct
from fractions import Fraction
from functools import lru_cache
from typing import NamedTuple

MAX_KNOWN = 1 << 15  # thresholds that are kept for the next query


class HalfLine(NamedTuple):
    """All d with d <= end, or d < end when `strict`."""

    end: Fraction
    strict: bool


class _Format(NamedTuple):
    code: str  # struct codes of the float and of the integer with the same bits
    bits: str
    overflow: Fraction  # what the next value after the largest finite one would be


_SINGLE = _Format("<f", "<i", Fraction(2) ** 128)
_DOUBLE = _Format("<d", "<q", Fraction(2) ** 1024)


def _rank(value: float, form: _Format) -> int:
    """Position of a float in the order of its format: 0 for 0.0, neighbours differ by one."""
    (bits,) = struct.unpack(form.bits, struct.pack(form.code, value))
    return bits if bits >= 0 else -(bits & (2 ** (8 * struct.calcsize(form.code) - 1) - 1))


def _value(rank: int, form: _Format) -> Fraction:
    """The float at a position, exactly; one past the largest finite float stands for the value that would follow."""
    (value,) = struct.unpack(form.code, struct.pack(form.bits, abs(rank)))
    if value in (float("inf"), float("-inf")):
        return form.overflow if rank > 0 else -form.overflow
    return Fraction(value) if rank >= 0 else -Fraction(value)


def _round_at_most(rank: int, form: _Format) -> HalfLine:
    """All real numbers that round to a float not above the one at `rank`, ties to even."""
    middle = (_value(rank, form) + _value(rank + 1, form)) / 2
    return HalfLine(middle, strict=rank % 2 != 0)


@lru_cache(maxsize=MAX_KNOWN)
def half_line(threshold: float, single: bool) -> HalfLine:
    """The differences d with fl32(fl64(d)) <= `threshold` (a float32); unless `single`, with fl64(d) <= `threshold`."""
    if not single:
        return _round_at_most(_rank(threshold, _DOUBLE), _DOUBLE)
    last = _round_at_most(_rank(threshold, _SINGLE), _SINGLE)
    # midpoints of neighbouring float32 values are float64 values
    rank = _rank(float(last.end), _DOUBLE) - (1 if last.strict else 0)
    return _round_at_most(rank, _DOUBLE)


def last_double(threshold: float, single: bool) -> HalfLine:
    """The float64 values z with fl32(z) <= `threshold`: for a feature that is one coordinate, rounded once. Unless
    `single`, it is not rounded.
    """
    if not single:
        return HalfLine(Fraction(threshold), strict=False)
    return _round_at_most(_rank(threshold, _SINGLE), _SINGLE)
