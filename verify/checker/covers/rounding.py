"""Float64 arithmetic on arrays whose results are bounds: no result above what it bounds from below, none below.

Does: the floats around an exact number; sums and products rounded down or up; asks whether the processor rounds so.
Assumes: IEEE 754 float64, rounding to nearest, with subnormals, which `ensure_arithmetic` tests.
Does not: refuse what is not finite: sums beyond the largest float are infinite or NaN, which boxes.py refuses.

A sum is exact where its rounding error, which is computed without error (Knuth, The Art of Computer Programming 2,
4.2.2, theorem B), is 0. Otherwise the next float on the safe side bounds it.
"""

from fractions import Fraction
from math import frexp, inf, nextafter

import numpy as np

from codegen.ir import Float64
from verify.checker.reading import RejectedError

TINY = 2.0**-1022  # the least normal float64
LANES = 67  # numbers in a test array: more than a processor takes at once, and a rest


def floor(exact: Fraction) -> float:
    """The largest float64 that is at most a number. RejectedError for a number beyond the floats."""
    near = _nearest(exact)
    return near if Fraction(near) <= exact else nextafter(near, -inf)


def ceiling(exact: Fraction) -> float:
    """The least float64 that is at least a number. RejectedError for a number beyond the floats."""
    return -floor(-exact)


def _nearest(exact: Fraction) -> float:
    try:
        return float(exact)
    except OverflowError:
        raise RejectedError("a number is too large for the arithmetic of covers") from None


def ensure_arithmetic() -> None:
    """RejectedError where float64 does not round to nearest, ties to even, or where subnormals are taken for 0."""
    one, half = np.ones(LANES), np.full(LANES, 2.0**-53)
    small, least = np.full(LANES, TINY), np.full(LANES, 2.0**-1074)
    right = (
        one + half == 1.0,
        one + 1.5 * half == 1.0 + 2.0**-52,
        -one - half == -1.0,
        -one - 1.5 * half == -1.0 - 2.0**-52,
        (small * 0.5 > 0.0) & (small * 0.5 * 2.0 == TINY),
        (least + 0.0 > 0.0) & (least * 1.0 > 0.0) & (small - least < TINY),
    )
    if not all(bool(each.all()) for each in right):
        raise RejectedError("this process does not round float64 to nearest with subnormals, so nothing can be checked")


def sum_down(one: Float64, other: Float64 | float) -> Float64:
    """A float at most the sum, element by element."""
    total, error = _with_error(one, other)
    return np.where(error < 0, np.nextafter(total, -np.inf), total)


def sum_up(one: Float64, other: Float64 | float) -> Float64:
    """A float at least the sum, element by element."""
    total, error = _with_error(one, other)
    return np.where(error > 0, np.nextafter(total, np.inf), total)


def _with_error(one: Float64, other: Float64 | float) -> tuple[Float64, Float64]:
    total = one + other
    part = total - one
    return total, (one - (total - part)) + (other - part)


class Factor:
    """An exact number other than 0, as the floats around it."""

    def __init__(self, exact: Fraction) -> None:
        self.low, self.high = floor(exact), ceiling(exact)
        self.positive = exact > 0
        if not self.low or not self.high:
            raise RejectedError("a number is too small for the arithmetic of covers")
        self.one = exact == 1
        self._shifts = self.low == self.high and abs(frexp(self.low)[0]) == 0.5  # a power of two

    def times_down(self, values: Float64) -> Float64:
        """A float at most the product with each value."""
        if self.one:
            return values
        return self._beside(np.where(values >= 0, self.low, self.high) * values, values, -np.inf)

    def times_up(self, values: Float64) -> Float64:
        """A float at least the product with each value."""
        if self.one:
            return values
        return self._beside(np.where(values >= 0, self.high, self.low) * values, values, np.inf)

    def _beside(self, product: Float64, values: Float64, way: float) -> Float64:
        exact = values == 0
        if self._shifts:
            exact = exact | (np.abs(product) >= TINY)
        return np.where(exact, product, np.nextafter(product, way))

    def into_down(self, values: Float64) -> Float64:
        """A float at most the quotient of each value by this number."""
        quotients = np.minimum(values / self.low, values / self.high)
        return np.where(values == 0, 0.0, np.nextafter(quotients, -np.inf))

    def into_up(self, values: Float64) -> Float64:
        """A float at least the quotient of each value by this number."""
        quotients = np.maximum(values / self.low, values / self.high)
        return np.where(values == 0, 0.0, np.nextafter(quotients, np.inf))
