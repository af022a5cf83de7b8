"""Floats beside a number: the next one, the largest that is not above it, the nearest.

Does: rounds numbers to float32 or float64 downwards, to the nearest, and to a neighbour.
Assumes: IEEE 754 binary32 and binary64.
Does not: know about trees, or belong to what proofs rest on.
"""

import math
from fractions import Fraction
from typing import Any

import numpy as np

from codegen.floats import FLOAT32

MAX_FLOAT32 = Fraction(float(np.finfo(np.float32).max))
BEYOND = MAX_FLOAT32 + Fraction(2) ** 103  # from here on the nearest float32 is infinite


def neighbour(values: Any, towards: float, numbers: str = FLOAT32) -> Any:
    """The next of the `numbers` towards minus or plus infinity, element by element; the step onto infinity is no
    error.
    """
    with np.errstate(over="ignore", under="ignore"):
        return np.nextafter(np.asarray(values, dtype=numbers), np.dtype(numbers).type(towards))


def at_most(threshold: Any, numbers: str) -> Any:
    """The largest of the `numbers` that is not above a finite float64, element by element."""
    return round_down(threshold) if numbers == FLOAT32 else np.asarray(threshold, dtype=np.float64)[()]


def round_down(threshold: Any) -> Any:
    """The largest float32 that is not above a finite float64, element by element.

    For a float32 x and a float64 t, `x <= t` and `x <= round_down(t)` say the same; round-to-nearest does not, when
    it rounds up. Below every float32 the result is -infinity, which no finite observation is below.
    """
    with np.errstate(over="ignore", under="ignore"):
        near = np.asarray(threshold, dtype=np.float64).astype(np.float32)
    return np.where(near.astype(np.float64) <= threshold, near, neighbour(near, -math.inf))[()]


def nearest_double(exact: Fraction | int) -> float:
    """The float64 nearest to a number, of two that are as near the even one; infinite beyond the largest."""
    try:
        return float(exact)  # Python's division of whole numbers rounds so
    except OverflowError:
        return math.inf if exact > 0 else -math.inf


def nearest_single(exact: Fraction) -> np.float32:
    """The float32 nearest to a number, of two that are as near the even one; infinite beyond the largest."""
    if abs(exact) >= BEYOND:
        return np.float32(math.inf if exact > 0 else -math.inf)
    close = np.float32(float(max(-MAX_FLOAT32, min(MAX_FLOAT32, exact))))
    beside = [neighbour(close, -math.inf), close, neighbour(close, math.inf)]
    return min((each for each in beside if np.isfinite(each)), key=lambda each: _distance(each, exact))


def _distance(number: np.float32, exact: Fraction) -> tuple[Fraction, int]:
    odd = int(np.float32(number).view(np.uint32)) & 1
    return abs(Fraction(float(number)) - exact), odd


def nearest_number(exact: Fraction, numbers: str) -> float:
    """The nearest of the `numbers`, as a float64."""
    return float(nearest_single(exact)) if numbers == FLOAT32 else nearest_double(exact)
