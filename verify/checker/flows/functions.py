"""sin, cos, exp and roots of intervals, by polynomials whose errors are proved here.

Does: bounds of these functions over intervals.
Assumes: float64 as covers/rounding.py asks for; sums and products in any order, as numpy computes them.
Does not: call a library's sin, cos or exp, whose errors nobody states.

sin and cos. k is the whole number next to 2 x / pi, and y = x - k pi / 2 is computed as (x - k P) - k Q. P has 33
bits and |k| < 2**20, so k P is exact; |pi / 2 - P - Q| < 2**-86. Two subtractions and one product round, by at most
2**-53 in all that counts, so y is off by less than 2**-51, and |y| < 0.8. The series end at y**17 / 17! and y**18 /
18!, and leave less than 2**-62. Horner's scheme with 9 steps is off by at most 20 * 2**-53 * cosh(0.8) < 2**-48. In
all less than 2**-46.

exp. k is next to x / ln 2, y = (x - k L) - k M with L of 33 bits, |y| < 0.36; the series ends at y**13 / 13! and leaves
less than 2**-57 of the value. Horner's scheme with 13 steps and the error of y are off by less than 2**-46 of the
value in all, and 2**k is exact.
"""

from __future__ import annotations

from math import factorial

import numpy as np

from codegen.ir import Bool, Float64
from verify.checker.flows.spans import Spans

P, Q = float.fromhex("0x1.921fb544p+0"), float.fromhex("0x1.0b4611a626331p-34")  # pi / 2
L, M = float.fromhex("0x1.62e42fefp-1"), float.fromhex("0x1.473de6af278edp-34")  # ln 2
QUARTER = float.fromhex("0x1.921fb54442d18p+0")  # the float64 next to pi / 2
SLACK = 2.0**-46
LARGEST = 1e6  # of what sin and cos are taken: k stays below 2**20
LARGEST_EXPONENT = 690.0
NEAR = 2.0**-30  # of a turn, within which an extremum counts as met; more than (x - e) / (2 pi) is off by
TURN = 4.0 * QUARTER
SINES = [(-1.0) ** n / factorial(2 * n + 1) for n in range(9)]
COSINES = [(-1.0) ** n / factorial(2 * n) for n in range(10)]
POWERS = [1.0 / factorial(n) for n in range(14)]


def half_turns(count: int) -> Spans:
    """pi, `count` times: it lies between the float64 next to it and the one after, as 2 QUARTER is below it."""
    below = np.full(count, 2.0 * QUARTER)
    return Spans(below, np.nextafter(below, np.inf))


def waves(span: Spans) -> tuple[Spans, Spans]:
    """Bounds of sin and of cos; NaN beyond LARGEST."""
    ends = np.stack([span.low, span.high])
    known = np.abs(ends) <= LARGEST
    ends = np.where(known, ends, 0.0)
    turns = np.rint(ends / QUARTER)
    y = (ends - turns * P) - turns * Q
    quarter, squared = turns.astype(np.int64) % 4, y * y
    sine, cosine = y * _horner(SINES, squared), _horner(COSINES, squared)
    odd = quarter % 2 == 1
    sine, cosine = np.where(odd, cosine, sine), np.where(odd, sine, cosine)
    sine, cosine = np.where(quarter >= 2, -sine, sine), np.where((quarter == 1) | (quarter == 2), -cosine, cosine)
    known = known[0] & known[1]
    return _bound_wave(span, sine, QUARTER, known), _bound_wave(span, cosine, 0.0, known)


def _bound_wave(span: Spans, ends: Float64, top: float, known: Bool) -> Spans:
    """Bounds of a wave by its values at both ends, off by less than SLACK, and a place `top` where it is 1."""
    low, high = ends.min(axis=0) - SLACK, ends.max(axis=0) + SLACK
    high = np.where(_meets(span, top), 1.0, np.minimum(high, 1.0))
    low = np.where(_meets(span, top + 2.0 * QUARTER), -1.0, np.maximum(low, -1.0))
    return Spans(np.where(known, low, np.nan), np.where(known, high, np.nan))


def _meets(span: Spans, place: float) -> Bool:
    """Where an interval may hold a place, or one whole turns from it."""
    first, last = (span.low - place) / TURN - NEAR, (span.high - place) / TURN + NEAR
    return np.ceil(first) <= np.floor(last)


def _horner(factors: list[float], x: Float64) -> Float64:
    total = np.full_like(x, factors[-1])
    for factor in reversed(factors[:-1]):
        total = total * x + factor
    return total


def exponential(span: Spans) -> Spans:
    """Bounds of exp; NaN beyond LARGEST_EXPONENT."""
    low, high = _exp(span.low) * (1.0 - SLACK), _exp(span.high) * (1.0 + SLACK)
    known = np.maximum(np.abs(span.low), np.abs(span.high)) <= LARGEST_EXPONENT
    return Spans(np.where(known, low, np.nan), np.where(known, high, np.nan))


def _exp(x: Float64) -> Float64:
    x = np.where(np.abs(x) <= LARGEST_EXPONENT, x, 0.0)
    doublings = np.rint(x / L)
    y = (x - doublings * L) - doublings * M
    return np.ldexp(_horner(POWERS, y), doublings.astype(np.int32))


def root(span: Spans) -> Spans:
    """Bounds of the square root, which IEEE 754 rounds to nearest; NaN where a number may be below 0."""
    low, high = np.sqrt(span.low), np.sqrt(span.high)
    return Spans(np.maximum(np.nextafter(low, -np.inf), 0.0), np.nextafter(high, np.inf))
