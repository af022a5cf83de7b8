"""Float arithmetic of thresholds: rounding, and literals that every reader decodes to the same decision.

Does: float64 to float32 downwards; the double that stands for a float32 threshold; exact literals.
Assumes: IEEE 754 binary32 and binary64, finite thresholds.
Does not: know about trees.
"""

import math
from typing import Any

import numpy as np


def neighbour(values: Any, towards: float) -> Any:
    """The next float32 towards minus or plus infinity, element by element; the step onto infinity is no error."""
    with np.errstate(over="ignore", under="ignore"):
        return np.nextafter(np.asarray(values, dtype=np.float32), np.float32(towards))


def round_down(threshold: Any) -> Any:
    """The largest float32 that is not above a finite float64, element by element.

    For a float32 x and a float64 t, `x <= t` and `x <= round_down(t)` say the same; round-to-nearest does not, when
    it rounds up. Below every float32 the result is -infinity, which no finite observation is below.
    """
    with np.errstate(over="ignore"):
        near = np.asarray(threshold, dtype=np.float64).astype(np.float32)
    return np.where(near.astype(np.float64) <= threshold, near, neighbour(near, -math.inf))[()]


def deciding_double(threshold: np.float32) -> float:
    """The largest float64 that rounds to a float32 not above `threshold`.

    A double d compared with it decides as float32(d) does against the threshold itself, and so does every float32.
    It is the midpoint to the next float32 where that tie rounds down (even mantissa), else the double before it.
    """
    t = float(threshold)
    above = np.float32(neighbour(threshold, math.inf))
    # past the largest float32 the next value of the unbounded format is 2**128
    middle = t + ((2.0**128 if np.isinf(above) else float(above)) - t) / 2.0
    with np.errstate(over="ignore"):
        ties_down = float(np.float32(middle)) <= t
    return middle if ties_down else math.nextafter(middle, -math.inf)


def hex_literal(threshold: np.float32) -> str:
    """The exact value as a C99 hexadecimal float literal, e.g. `0x1.99999ap-4f`."""
    return short_hex(float(threshold)) + "f"


def short_hex(value: float) -> str:
    """`float.hex` without trailing zeros of the fraction."""
    mantissa, exponent = value.hex().split("p")
    if "." in mantissa:
        mantissa = mantissa.rstrip("0").rstrip(".")
    return f"{mantissa}p{exponent}"


def decimal_literal(value: float) -> str:
    """The shortest decimal that reads back as the same double."""
    return repr(float(value))


def smt_literal(bits: int) -> str:
    """A Float32 of SMT-LIB by its bits; every NaN is the same one to a solver."""
    if bits & 0x7FFFFFFF > 0x7F800000:
        return "(_ NaN 8 24)"
    return f"(fp #b{bits >> 31:b} #b{bits >> 23 & 0xFF:08b} #b{bits & 0x7FFFFF:023b})"
