"""Numbers of C: the value of a literal in its own type, and in the type that it is converted to.

Does: reads decimal, hexadecimal, octal and character literals; rounds to float as a compiler does.
Assumes: IEEE binary32 `float`, binary64 `double`, `int` of 32 bits, and evaluation in a type's own precision.
Does not: take long double, unsigned or binary literals, escapes, or several characters.
"""

import math
import re
from fractions import Fraction
from typing import Final, NamedTuple, TypeAlias

import numpy as np

Number: TypeAlias = int | float
FLOAT, DOUBLE, WHOLE = "float", "double", "int"
WHOLES: Final = {  # values of types of whole numbers
    **dict.fromkeys(("int", "signed int", "signed", "long", "long int", "int32_t"), (-(2**31), 2**31 - 1)),
    **dict.fromkeys(("long long", "long long int", "int64_t"), (-(2**63), 2**63 - 1)),
    **dict.fromkeys(("short", "short int", "int16_t"), (-(2**15), 2**15 - 1)),
    **dict.fromkeys(("_Bool", "bool"), (0, 1)),
    "char": (0, 127),
    **dict.fromkeys(("signed char", "int8_t"), (-128, 127)),
    **dict.fromkeys(("unsigned char", "uint8_t"), (0, 255)),
    **dict.fromkeys(("unsigned short", "unsigned short int", "short unsigned int", "uint16_t"), (0, 2**16 - 1)),
    **dict.fromkeys(("unsigned", "unsigned int", "unsigned long", "uint32_t", "size_t"), (0, 2**31 - 1)),
}
EXACT = {FLOAT: 2**24, DOUBLE: 2**53}  # up to which whole numbers are numbers of the type
BEYOND_FLOAT = 2**128  # from here on, no float is near
DECIMAL = re.compile(r"(\d+\.\d*|\.\d+|\d+)([eE][+-]?\d{1,4})?([fF]?)")
HEXADECIMAL = re.compile(r"(0[xX][01](?:\.[0-9a-fA-F]{0,13})?[pP][+-]?\d{1,4})([fF]?)")  # so that a double holds it
WHOLE_NUMBER = re.compile(r"(?:(?P<more>0[xX][0-9a-fA-F]+|0[0-7]*)|[1-9]\d*)(?:[lL]|ll|LL)?", re.ASCII)
CHARACTER = re.compile(r"'([ -&(-\[\]-~])'")  # of ASCII, and no escape
MAX_DIGITS = 1_000


class Literal(NamedTuple):
    """A number and its type."""

    value: Number
    kind: str  # FLOAT, DOUBLE or WHOLE


def literal(text: str) -> Literal | None:
    """A literal without its sign; None: it is not understood, or not finite."""
    if len(text) > MAX_DIGITS:
        return None
    if match := CHARACTER.fullmatch(text):
        return Literal(ord(match[1]), WHOLE)
    if match := WHOLE_NUMBER.fullmatch(text):
        return _whole(text.rstrip("lL"), octal=match["more"] is not None)
    match = DECIMAL.fullmatch(text)
    if match and (match[2] or "." in match[1]):
        value = _single(Fraction(match[1] + (match[2] or ""))) if match[3] else float(match[1] + (match[2] or ""))
        return Literal(value, FLOAT if match[3] else DOUBLE) if math.isfinite(value) else None
    match = HEXADECIMAL.fullmatch(text)
    if not match:
        return None
    try:
        value = float.fromhex(match[1])
    except OverflowError:
        return None
    if match[2] and not fits(value, FLOAT):
        return None
    return Literal(value, FLOAT if match[2] else DOUBLE)


def _whole(digits: str, *, octal: bool) -> Literal | None:
    """A whole number of a signed type. `octal`: or hexadecimal, which beyond int is unsigned for some compilers."""
    value = int(digits, 16 if digits[:2] in ("0x", "0X") else 8 if octal else 10)
    return Literal(value, WHOLE) if value <= WHOLES["int" if octal else "long long"][1] else None


def _single(exact: Fraction) -> float:
    """The nearest float32, ties to even; infinite beyond the largest."""
    if exact >= BEYOND_FLOAT:
        return math.inf
    with np.errstate(over="ignore", under="ignore"):
        near = np.float32(float(exact))
        beside = [near, np.nextafter(near, np.float32(-np.inf)), np.nextafter(near, np.float32(np.inf))]
    if not np.isfinite(near):
        return math.inf
    finite = [each for each in beside if np.isfinite(each)]
    return float(min(finite, key=lambda each: (abs(Fraction(float(each)) - exact), int(each.view(np.uint32)) & 1)))


def fits(value: Number, kind: str) -> bool:
    """Whether a value is one of a type, so that its conversion changes nothing."""
    if kind in WHOLES:
        low, high = WHOLES[kind]
        return isinstance(value, int) and low <= value <= high
    if isinstance(value, int):
        return abs(value) <= EXACT[kind]
    with np.errstate(over="ignore", under="ignore"):
        return kind == DOUBLE or float(np.float32(value)) == value


def converted(number: Literal, kind: str) -> Number | None:
    """A number as a constant of a type holds it; None: it does not fit."""
    if kind == FLOAT and number.kind == DOUBLE:
        with np.errstate(over="ignore", under="ignore"):
            value = float(np.float32(number.value))
        return value if math.isfinite(value) else None
    return number.value if fits(number.value, kind) else None
