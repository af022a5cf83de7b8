"""Boxes of cores in float32: of each side its middle and the square of its half, within the side by all that rounds.

Does: narrows boxes of float64 to such ones, which take half the memory and one comparison for each variable.
Assumes: boxes [n, variables] of float64; those that hold no state have a low end above the high one.
Does not: refuse a state: whoever is in no core is asked of the list itself; keep the end of a side that has no other.

A state passes where d * d <= square for d = w - middle, with w rounded to float32. With s the root of the square that
says |w - middle| <= s (1 + 2^-21) + 2^-23 |middle|: each of the three roundings is 2^-24 of its number, and s is so
large that nothing underflows. So s is smaller than half of the side by KEPT and by LOST of the middle.
"""

from __future__ import annotations

import numpy as np

from codegen.floats import short_hex
from codegen.ir import Bool, Float32, Float64
from codegen.lowering.parts import Centred
from codegen.lowering.searching import Boxes

KEPT, LOST = 1.0 - 2.0**-20, 2.0**-22
LEAST, MOST = 2.0**-40, 2.0**60  # of s; beyond MOST from 0 no state passes
MOSTLY = 0.999  # of half of a side, that has to be left
NONE = -1.0  # a square that no number has


def centre_boxes(boxes: Boxes) -> tuple[Float32, Float32]:
    """Middles and squares, [n, variables] float32. A box that is empty, or thin for float32, holds no state then."""
    low, high = np.maximum(boxes.low, -MOST), np.minimum(boxes.high, MOST)
    middle = np.clip(low / 2.0 + high / 2.0, -MOST, MOST).astype(np.float32)
    half = np.minimum(np.minimum(high - middle, middle - low), MOST)
    root = KEPT * half - LOST * np.abs(middle.astype(np.float64))
    square = np.nextafter((np.maximum(root, 0.0) ** 2).astype(np.float32), np.float32(0.0))
    return middle, np.where((root >= LEAST) & (root >= MOSTLY * half), square, np.float32(NONE))


def is_centred(middle: Float32, square: Float32, states: Float64) -> Bool:
    """Which states [n, variables] pass, each of a box, as code has it."""
    with np.errstate(over="ignore", invalid="ignore"):
        off = states.astype(np.float32) - middle
        return np.asarray((off * off <= square).all(axis=1))


def write_centred(middle: Float32, square: Float32) -> tuple[Centred, ...]:
    """The same as C writes them."""
    return tuple(
        Centred(*(tuple(f"{short_hex(value + 0.0)}F" for value in row) for row in pair))
        for pair in zip(middle.astype(np.float64).tolist(), square.astype(np.float64).tolist(), strict=True)
    )
