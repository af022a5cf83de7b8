"""Intervals as pairs of float64 arrays, rounded outward.

Does: sums, products, quotients, multiples, powers of intervals, element by element; their middles and parts in common.
Assumes: rounding to nearest with subnormals, which covers/rounding.py asks for.
Does not: refuse what is not finite. Bounds that are infinite or NaN stay so, and `finite` tells.

A float that is computed by one operation lies within half a step of the exact result, so the next float on the safe
side bounds it. Products with an interval that is exactly 0 are exactly 0, and sums are exact where no error was made.
"""

from __future__ import annotations

from fractions import Fraction
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from codegen.ir import Bool, Float64, Int64
from verify.checker.covers.rounding import Factor, ceiling, floor, lower, sum_down, sum_up

Index = int | slice | Bool | Int64 | tuple[int | slice | None, ...]
RELATIVE = 1.0 + 2.0**-44  # more than rounding takes from a sum of at most 500 products that are not negative
LEAST = 2.0**-1000


class Spans(NamedTuple):
    """Intervals: `low` and `high` of one shape."""

    low: Float64
    high: Float64

    @property
    def ends(self) -> Float64:
        """The same as one array, [2, ...]: bounds from below of the numbers, and of their negatives."""
        ends = np.empty((2, *self.low.shape))  # faster than to stack
        ends[0], ends[1] = self.low, -self.high
        return ends

    def at(self, index: Index) -> Spans:
        """Some of them."""
        return Spans(self.low[index], self.high[index])

    @property
    def middle(self) -> Float64:
        """About the middles."""
        return 0.5 * self.low + 0.5 * self.high

    @property
    def largest(self) -> Float64:
        """The largest absolute value in each."""
        return np.maximum(np.abs(self.low), np.abs(self.high))

    def around(self, middle: Float64) -> Float64:
        """At most how far each comes from a number."""
        return round_up(np.maximum(self.high - middle, middle - self.low))


def round_up(values: Float64) -> Float64:
    """At least the sums that were computed as these values, of products that are not negative."""
    return np.maximum(values, 0.0) * RELATIVE + LEAST


def exact(number: Fraction, count: int) -> Spans:
    """An exact number, `count` times."""
    low, high = _ends(number)
    return Spans(np.full(count, low), np.full(count, high))


@lru_cache(maxsize=1 << 12)
def _ends(number: Fraction) -> tuple[float, float]:
    return floor(number), ceiling(number)


def of_ends(ends: Float64) -> Spans:
    """Intervals by their ends."""
    return Spans(ends[0], -ends[1])


def plus(one: Spans, other: Spans) -> Spans:
    """Sums."""
    return of_ends(add_ends(one.ends, other.ends))


def add_ends(one: Float64, other: Float64) -> Float64:
    """Sums, by ends."""
    return sum_down(one, other)


def minus(one: Spans, other: Spans) -> Spans:
    """Differences."""
    return Spans(sum_down(one.low, -other.high), sum_up(one.high, -other.low))


def times(one: Spans, other: Spans) -> Spans:
    """Products."""
    return of_ends(multiply_ends(one.ends, other.ends))


def multiply_ends(one: Float64, other: Float64) -> Float64:
    """Products, by ends: those of like ends bound the products as they are, those of unlike ends their negatives."""
    alike, unlike = one * other, one * other[::-1]
    products = np.empty_like(alike)
    np.minimum(np.minimum(alike[0], alike[1]), -np.maximum(unlike[0], unlike[1]), out=products[0])
    np.minimum(-np.maximum(alike[0], alike[1]), np.minimum(unlike[0], unlike[1]), out=products[1])
    nothing = ((one[0] == 0.0) & (one[1] == 0.0)) | ((other[0] == 0.0) & (other[1] == 0.0))
    return np.where(nothing, 0.0, lower(products))


def _is_zero(span: Spans) -> Bool:
    return (span.low == 0.0) & (span.high == 0.0)


def scale_spans(span: Spans, factor: Factor) -> Spans:
    """Multiples by one exact number other than 0."""
    ends = span.ends if factor.positive else -span.ends[::-1]
    return of_ends(factor.times_down(ends))


def square(span: Spans) -> Spans:
    """Squares, which are not below 0."""
    ends = span.low * span.low, span.high * span.high
    low = np.where((span.low <= 0.0) & (span.high >= 0.0), 0.0, np.nextafter(np.minimum(*ends), -np.inf))
    return Spans(np.maximum(low, 0.0), np.where(_is_zero(span), 0.0, np.nextafter(np.maximum(*ends), np.inf)))


def inverse(span: Spans) -> Spans:
    """1 over each; NaN where that may be 0."""
    apart = (span.low > 0.0) | (span.high < 0.0)
    low, high = np.nextafter(1.0 / span.high, -np.inf), np.nextafter(1.0 / span.low, np.inf)
    return Spans(np.where(apart, low, np.nan), np.where(apart, high, np.nan))


def hull(one: Spans, other: Spans) -> Spans:
    """The least intervals around both."""
    return Spans(np.minimum(one.low, other.low), np.maximum(one.high, other.high))


def common(one: Spans, other: Spans) -> Spans:
    """Returns the intersections of the spans."""
    return Spans(np.maximum(one.low, other.low), np.minimum(one.high, other.high))


def within(one: Spans, other: Spans) -> Bool:
    """Returns True for each span of `one` that lies in that of `other`; never where a bound is NaN."""
    return (one.low >= other.low) & (one.high <= other.high)


def finite(span: Spans) -> Bool:
    """Returns True for each span whose bounds are both finite."""
    return np.isfinite(span.low) & np.isfinite(span.high)
