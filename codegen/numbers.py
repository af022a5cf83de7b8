"""Numbers: floats beside a number, and literals of generated code that every reader decodes to the same float.

Does: rounds numbers to float32 or float64 downwards, to the nearest, and to a neighbour; writes exact literals of C, of
  decimals and of SMT-LIB.
Assumes: IEEE 754 binary32 and binary64; finite numbers, but for SMT-LIB.
Does not: know about trees, or belong to what proofs rest on.
"""

import math
from fractions import Fraction
from typing import Any

import numpy as np

from codegen.floats import FLOAT32, short_hex

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
    finite = [np.float32(each) for each in beside if np.isfinite(each)]
    return min(finite, key=lambda each: (abs(Fraction(float(each)) - exact), int(each.view(np.uint32)) & 1))


def nearest_number(exact: Fraction, numbers: str) -> float:
    """The nearest of the `numbers`, as a float64."""
    return float(nearest_single(exact)) if numbers == FLOAT32 else nearest_double(exact)


def hex_literal(threshold: np.float32 | np.float64) -> str:
    """The exact value as a C99 hexadecimal literal of its type: `0x1.99999ap-4f` of float, `0x1.8p-4` of double."""
    return short_hex(float(threshold)) + ("f" if threshold.dtype == np.float32 else "")


def whole_literal(number: float, whole: str) -> str:
    """A whole number of a type as a C literal. The least int32 is a difference: without its sign it is none."""
    digits = str(int(number))
    if whole.startswith("u"):
        return f"{digits}U"
    return digits if int(number) > -(2**31) else "(-2147483647 - 1)"


def hex_bits(number: np.float32 | np.float64) -> str:
    """The bits of a number as a hexadecimal literal, all digits of them."""
    return f"0x{number.view(f'u{number.itemsize}'):0{2 * number.itemsize}x}"


def decimal_literal(value: float) -> str:
    """The shortest decimal that reads back as the same double."""
    return repr(float(value))


def smt_literal(bits: int) -> str:
    """A Float32 of SMT-LIB by its bits; every NaN is the same one to a solver."""
    if bits & 0x7FFFFFFF > 0x7F800000:
        return "(_ NaN 8 24)"
    return f"(fp #b{bits >> 31:b} #b{bits >> 23 & 0xFF:08b} #b{bits & 0x7FFFFF:023b})"
