"""Floats in their order: the place of each number, and the number at a place.

Does: counts float32 or float64 numbers from 0 outwards, infinities at both ends; rounds exact numbers down to doubles.
Assumes: IEEE 754; 0.0 and -0.0 share the place 0.
Does not: place NaN.
"""

import math
import struct
from typing import TypeAlias

from codegen.floats import FLOAT32, FLOAT64
from codegen.numbers.rounding import round_down

Number: TypeAlias = int | float
LAST: dict[str, int] = {FLOAT32: 0x7F800000, FLOAT64: 0x7FF0000000000000}  # the places of infinity


def at_most(number: Number) -> float:
    """The largest double that is not above a number."""
    try:
        near = float(number)
    except OverflowError:
        near = math.inf if number > 0 else -math.inf
    return near if near <= number else math.nextafter(near, -math.inf)


def below(number: Number) -> float:
    """The largest double that is below a number."""
    near = at_most(number)
    return math.nextafter(near, -math.inf) if near == number else near


def place(value: float, numbers: str) -> int:
    """The place of the largest of the `numbers` that is not above a double; infinities are the ends."""
    if numbers == FLOAT32:
        bits: int = struct.unpack("<i", struct.pack("<f", value if math.isinf(value) else round_down(value)))[0]
        return bits if bits >= 0 else -(bits & 0x7FFFFFFF)
    bits = struct.unpack("<q", struct.pack("<d", value))[0]
    return bits if bits >= 0 else -(bits & 0x7FFFFFFFFFFFFFFF)


def number(at: int, numbers: str) -> float:
    """The number at a place."""
    kinds = ("<i", "<f") if numbers == FLOAT32 else ("<q", "<d")
    value: float = struct.unpack(kinds[1], struct.pack(kinds[0], abs(at)))[0]
    return -value if at < 0 else value
