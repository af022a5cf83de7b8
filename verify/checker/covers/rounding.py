"""Float64 arithmetic on arrays whose results are bounds: no result above what it bounds from below, none below.

Does: the floats around an exact number; sums and products rounded down or up; asks whether the processor rounds so.
Assumes: IEEE 754 float64, rounding to nearest, with subnormals, which `ensure_arithmetic` tests.
Does not: refuse what is not finite: sums beyond the largest float are infinite or NaN, which boxes.py refuses.

A sum is exact where its rounding error, which is computed without error (Knuth, The Art of Computer Programming 2,
4.2.2, theorem B), is 0. Otherwise a float below it bounds it (`lower`), which costs a third of the next one.
"""

from fractions import Fraction
from math import frexp, inf, nextafter

import numpy as np

from codegen.ir import Float64, Int64
from verify.checker.reading import RejectedError

TINY, LEAST = 2.0**-1022, 2.0**-1074  # the least normal float64, and the least one above 0
LANES = 67  # numbers in a test array: more than a processor takes at once, and a rest


def around(exact: Fraction) -> tuple[float, float]:
    """The largest float64 that is at most a number, and the least that is at least it: the same where it is a float.
    RejectedError for a number beyond the floats.
    """
    try:
        near = float(exact)
    except OverflowError:
        raise RejectedError("a number is too large for the arithmetic of covers") from None
    numerator, denominator = near.as_integer_ratio()
    beyond = numerator * exact.denominator - exact.numerator * denominator
    return nextafter(near, -inf) if beyond > 0 else near, nextafter(near, inf) if beyond < 0 else near


def floor(exact: Fraction) -> float:
    """The largest float64 that is at most a number. RejectedError as of `around`."""
    return around(exact)[0]


def ceiling(exact: Fraction) -> float:
    """The least float64 that is at least a number. RejectedError as of `around`."""
    return around(exact)[1]


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


def lower(values: Float64, times: float = 1.0) -> Float64:
    """A float below each finite value, at most three floats away `times` 1; -inf stays, inf becomes NaN.

    The floats beside a value x, 2^e <= |x| < 2^(e+1), are at most max(2^(e-52), 2^-1074) away. What is taken off is
    no less: |x| 2^-52, which is exact or off by at most 2^-1075, and 2^-1074. Rounding keeps the order, so the
    difference becomes no more than the float below x.
    """
    taken: Float64 = np.abs(values)
    taken *= times * 2.0**-52
    taken += times * LEAST
    return np.subtract(values, taken, out=taken)


def sum_down(one: Float64, other: Float64 | float) -> Float64:
    """A float at most the sum, element by element; NaN where it lies beyond the floats."""
    total, error = _with_error(one, other)
    bound = lower(total)
    np.copyto(bound, total, where=error >= 0)  # the error of an infinite total is NaN
    return bound


def sum_up(one: Float64, other: Float64 | float) -> Float64:
    """A float at least the sum, element by element."""
    return -sum_down(-one, -other)


def _with_error(one: Float64, other: Float64 | float) -> tuple[Float64, Float64]:
    total = one + other
    part = total - one
    return total, (one - (total - part)) + (other - part)


class Factor:
    """Exact numbers other than 0, as the floats around them: one for all values, or one for each column of them."""

    def __init__(self, *exact: Fraction) -> None:
        ends = [around(each) for each in exact]
        self.low, self.high = (np.array(column) for column in zip(*ends, strict=True))
        self.positive = exact[0] > 0
        if min(np.abs(self.low).min(), np.abs(self.high).min()) < TINY:
            raise RejectedError("a number is too small for the arithmetic of covers")
        self._ones = np.array([each == 1 for each in exact])
        self._all_ones, self._some_ones = bool(self._ones.all()), bool(self._ones.any())
        self._shifts = np.array([low == high and abs(frexp(low)[0]) == 0.5 for low, high in ends])  # powers of two
        self._some_shifts = bool(self._shifts.any())
        self._exact = bool((self.low == self.high).all())  # each is a float

    def times_down(self, values: Float64, at: Int64 | None = None) -> Float64:
        """A float at most the product with each value; NaN where it lies beyond the floats. `at`: the numbers of the
        factors, of the shape of the values; None: one for each column.

        The factor f is in [l, h], |h - l| <= 2^-52 |l|, and p is l v rounded. Where |l v| >= 2^-1022, p is off from
        f v by 2^-52 |l v| for the factor and 2^-53 |l v| for rounding. Twice that is taken off, about 3 2^-52 |p|, and
        the difference is rounded by a third of the rest. Below, the factor is off by less than 2^-1074, rounding by
        2^-1075, and 3 2^-1074 or more are taken off, exactly. Products by powers of two are exact between 2^-1022,
        which a smaller one may be rounded to, and infinity.
        """
        if self._all_ones:
            return values
        product = (self.low if at is None else self.low.take(at)) * values
        exact = values == 0
        if self._some_ones:
            exact |= self._ones if at is None else self._ones.take(at)
        if self._some_shifts:
            size = np.abs(product)
            exact |= (self._shifts if at is None else self._shifts.take(at)) & (size > TINY) & (size < np.inf)
        bound = lower(product, 3.0)
        np.copyto(bound, product, where=exact)
        return bound

    def into_down(self, values: Float64) -> Float64:
        """A float at most the quotient of each value by this number."""
        quotients = values / self.low if self._exact else np.minimum(values / self.low, values / self.high)
        return np.where(values == 0, 0.0, lower(quotients))
