"""Floats of observations and thresholds: the numbers that agents compare, and the texts that profiles have of them.

Does: numbers of any type to those that an agent compares, float32 or float64; the double that stands for a float32
  threshold; the exact texts of profiles and certificates.
Assumes: IEEE 754 binary32 and binary64, finite thresholds.
Does not: know about trees, round to neighbours, or write literals of languages (numbers).
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
# types of whole numbers that an agent may observe, the narrowest first, and the floats that hold each number of them
WHOLE: Final = {f"{sign}int{bits}": FLOAT32 if bits < 32 else FLOAT64 for bits in (8, 16, 32) for sign in ("", "u")}
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


def as_whole(rows: Any, whole: str) -> Any:
    """Floats as a type of whole numbers: the next one above, within its ends, as trees of whole thresholds take them.
    InputError for NaN, which is none.
    """
    if np.isnan(rows).any():
        raise InputError(f"NaN is no {whole}", "", "give whole numbers")
    return np.ceil(rows.astype(np.float64)).clip(np.iinfo(whole).min, np.iinfo(whole).max).astype(whole)


def _double(number: Any, agent: str) -> float:
    try:
        return struct.unpack("d", struct.pack("d", None if isinstance(number, str | bytes) else number))[0]
    except (struct.error, TypeError, OverflowError):
        raise InputError(f"{agent} observes numbers, given {type(number).__name__}", "", "give floats") from None


def below_zero(numbers: str) -> float:
    """The last of the numbers below 0: `x <= below_zero` says `x < 0`. It is subnormal, and so code writes `x < 0`."""
    return -float(np.finfo(numbers).smallest_subnormal)


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


def short_hex(value: float) -> str:
    """`float.hex` without trailing zeros of the fraction."""
    mantissa, exponent = value.hex().split("p")
    if "." in mantissa:
        mantissa = mantissa.rstrip("0").rstrip(".")
    return f"{mantissa}p{exponent}"


def factor(weight: float) -> str:
    """Returns the text before a coordinate of this weight, its sign aside: "" or such as "0.5*"."""
    return "" if abs(weight) == 1 else f"{abs(weight):g}*"


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
