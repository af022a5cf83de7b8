"""Floats of observations and thresholds: rounding, and literals that every reader decodes to the same decision.

Does: numbers of any type to those that an agent compares, float32 or float64; float64 to float32 downwards; the double
  that stands for a float32 threshold; exact literals.
Assumes: IEEE 754 binary32 and binary64, finite thresholds.
Does not: know about trees.
"""

import math
import struct
from fractions import Fraction
from typing import Any, Final

import numpy as np

from codegen.errors import InputError

FLOAT32: Final = "float32"
FLOAT64: Final = "float64"
NUMBERS: Final = (FLOAT32, FLOAT64)  # that an agent compares, by the names that numpy and profiles give them
PIECE_DIGITS = 4_000
PIECE = 10**PIECE_DIGITS
MANTISSA, LEAST_EXPONENT = 24, -125  # of a float32, as `math.frexp` counts
NO_NUMBERS = "cmMSUV"  # numpy's kinds: complex, times, texts, records


def observations(given: Any, n_features: int | None = None, agent: str = "an agent", numbers: str = FLOAT32) -> Any:
    """Observations in the `numbers` that an agent compares, [batch, n_features]: each number a double first, and then,
    for float32, the nearest float32, ties to even.

    One observation is a batch of one; a number beyond the largest is infinite, a signalling NaN is quiet. InputError
    for another number of features (None: any) or axes, and for what is no number.
    """
    try:
        x = np.asarray(given)
    except ValueError as error:
        raise InputError(
            f"{agent} observes rows of one length", str(error), "give an array [batch, features]"
        ) from None
    x = np.atleast_2d(x.reshape(0, n_features or 0) if x.shape == (0,) else x)
    if x.ndim != 2 or n_features not in (None, x.shape[1]):
        wanted = "rows" if n_features is None else f"rows of {n_features} numbers"
        raise InputError(
            f"{agent} observes {wanted}, given an array of shape {x.shape}", "", "see the profile's features"
        )
    if x.dtype.kind in NO_NUMBERS:
        raise InputError(f"{agent} observes numbers, given an array of {x.dtype}", "", "give floats")
    if x.dtype.kind == "O":
        x = np.array([_double(each, agent) for each in x.flat], dtype=np.float64).reshape(x.shape)
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        if x.dtype.kind != "f" or x.dtype.itemsize > 8:
            x = x.astype(np.float64)
        return x.astype(numbers, copy=False)


def _double(number: Any, agent: str) -> float:
    try:
        return struct.unpack("d", struct.pack("d", None if isinstance(number, str | bytes) else number))[0]
    except (struct.error, TypeError, OverflowError):
        raise InputError(f"{agent} observes numbers, given {type(number).__name__}", "", "give floats") from None


def neighbour(values: Any, towards: float, numbers: str = FLOAT32) -> Any:
    """The next of the `numbers` towards minus or plus infinity, element by element; the step onto infinity is no
    error.
    """
    with np.errstate(over="ignore", under="ignore"):
        return np.nextafter(np.asarray(values, dtype=numbers), np.dtype(numbers).type(towards))


def at_most(threshold: Any, numbers: str) -> Any:
    """The largest of the `numbers` that is not above a finite float64, element by element."""
    return round_down(threshold) if numbers == FLOAT32 else np.asarray(threshold, dtype=np.float64)[()]


def below_zero(numbers: str) -> float:
    """The last of the numbers below 0: `x <= below_zero` says `x < 0`. It is subnormal, and so code writes `x < 0`."""
    return -float(np.finfo(numbers).smallest_subnormal)


def round_down(threshold: Any) -> Any:
    """The largest float32 that is not above a finite float64, element by element.

    For a float32 x and a float64 t, `x <= t` and `x <= round_down(t)` say the same; round-to-nearest does not, when
    it rounds up. Below every float32 the result is -infinity, which no finite observation is below.
    """
    with np.errstate(over="ignore", under="ignore"):
        near = np.asarray(threshold, dtype=np.float64).astype(np.float32)
    return np.where(near.astype(np.float64) <= threshold, near, neighbour(near, -math.inf))[()]


def deciding_double(threshold: np.float32 | float) -> float:
    """The largest float64 that rounds to a float32 not above `threshold`, which is a finite float32.

    A double d compared with it decides as float32(d) does against the threshold itself, and so does every float32.
    It is the midpoint to the next float32 where that tie rounds down (even mantissa), else the double before it.
    """
    t = float(threshold)
    fraction, exponent = math.frexp(t)
    least = exponent <= LEAST_EXPONENT or not t  # the spacing of subnormal numbers, and of those just above
    closer = fraction == -0.5 and not least  # above a negative power of two the floats lie twice as close
    spacing = math.ldexp(1.0, (LEAST_EXPONENT if least else exponent) - MANTISSA - closer)
    middle = t + spacing / 2
    return middle if t / spacing % 2 == 0 else math.nextafter(middle, -math.inf)


def hex_literal(threshold: np.float32 | np.float64) -> str:
    """The exact value as a C99 hexadecimal literal of its type: `0x1.99999ap-4f` of float, `0x1.8p-4` of double."""
    return short_hex(float(threshold)) + ("f" if threshold.dtype == np.float32 else "")


def short_hex(value: float) -> str:
    """`float.hex` without trailing zeros of the fraction."""
    mantissa, exponent = value.hex().split("p")
    if "." in mantissa:
        mantissa = mantissa.rstrip("0").rstrip(".")
    return f"{mantissa}p{exponent}"


def decimal_literal(value: float) -> str:
    """The shortest decimal that reads back as the same double."""
    return repr(float(value))


def factor(weight: float) -> str:
    """What stands before a coordinate of this weight, its sign aside: "" or such as "0.5*"."""
    return "" if abs(weight) == 1 else f"{abs(weight):g}*"


def nearest_double(exact: Fraction | int) -> float:
    """The float64 nearest to a number, of two that are as near the even one; infinite beyond the largest."""
    try:
        return float(exact)  # Python's division of whole numbers rounds so
    except OverflowError:
        return math.inf if exact > 0 else -math.inf


def rational_literal(number: Fraction | int) -> str:
    """The text of an integer or a fraction, as `str` gives it, which stops at 4,300 digits."""
    whole = _digits(number.numerator)
    return whole if number.denominator == 1 else f"{whole}/{_digits(number.denominator)}"


def _digits(number: int) -> str:
    """All digits of an integer, in pieces that Python converts."""
    left, pieces = abs(number), list[str]()
    while left >= PIECE:
        left, piece = divmod(left, PIECE)
        pieces.append(f"{piece:0{PIECE_DIGITS}d}")
    return "".join(["-" if number < 0 else "", str(left), *reversed(pieces)])


def smt_literal(bits: int) -> str:
    """A Float32 of SMT-LIB by its bits; every NaN is the same one to a solver."""
    if bits & 0x7FFFFFFF > 0x7F800000:
        return "(_ NaN 8 24)"
    return f"(fp #b{bits >> 31:b} #b{bits >> 23 & 0xFF:08b} #b{bits & 0x7FFFFF:023b})"
