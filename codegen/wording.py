"""Numbers as people read them: `<= 0.1`, `< 0` where a threshold is the last number below 0, `1 leaf`, `2,000 leaves`.

Does: words a test, or either of its sides, with some digits; a count with its noun; what cannot
  be seen in a line.
Assumes: a reader; code and profiles hold thresholds exactly.
Does not: write what a program reads.

What is written as x < 0 compares with a number so small that it says nothing to a reader: -1.17549e-38, the last
float32 that is not subnormal, or the last number of all. And what is written as x < 19.5 compares with the last float
below, which in a few digits would read as `<= 19.5`.
"""

import math
import struct
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from codegen.errors import escape_letter

PLURALS = {"box": "boxes", "branch": "branches", "leaf": "leaves"}  # of nouns that take no s
TINY = 2.0**-126  # the least float32 that is not subnormal
NO_UNIT = ("", "none")
ROUND = 4  # digits of numbers that people write as a bound
WRITTEN = 6  # digits of numbers that stay as they are written


def holds(threshold: float, digits: int = 6) -> str:
    """The side of a test where it holds: `<= 0.1`, `< 0`."""
    return f"{_sign(threshold, '<=', '<')} {number(threshold, digits)}"


def fails(threshold: float, digits: int = 6) -> str:
    """Its other side: `> 0.1`, `>= 0`."""
    return f"{_sign(threshold, '>', '>=')} {number(threshold, digits)}"


def number(threshold: float, digits: int = 6) -> str:
    """The number that a test's words compare with."""
    bound = _bound(threshold)
    value = 0.0 if is_zero(threshold) else threshold if bound is None else bound
    # so many digits, and those that people wrote: 23.25 stays, 1400 is not 1.4e+03
    whole = f"{value:.{WRITTEN}g}"
    if float(whole) == value:
        return whole
    before = len(str(int(abs(value)))) if abs(value) < 10**WRITTEN else 0
    return f"{value:.{max(digits, before)}g}"


def is_zero(threshold: float) -> bool:
    """Returns True if a threshold is read as 0."""
    return abs(threshold) <= TINY


def format_count(count: int, noun: str) -> str:
    """A count and what is counted: `1 leaf`, `2,000 episodes`."""
    return f"{count:,} {noun if count == 1 else PLURALS.get(noun, noun + 's')}"


def _sign(threshold: float, plain: str, below: str) -> str:
    return plain if _bound(threshold) is None else below


def _bound(threshold: float) -> float | None:
    """The b of a test `x < b` that became `x <= threshold`, where b is 0 or a number of few digits."""
    if is_zero(threshold):
        return 0.0 if threshold < 0 else None
    bound = float(f"{threshold:.{ROUND}g}")
    if not threshold < bound:
        return None
    return bound if bound in (math.nextafter(threshold, math.inf), _next_single(threshold)) else None


def _next_single(threshold: float) -> float | None:
    """The float32 number after one that is no zero; None where it is no float32. Without numpy, which loads slowly."""
    try:
        packed = struct.pack("<f", threshold)
    except OverflowError:
        return None
    if struct.unpack("<f", packed)[0] != threshold:
        return None
    (bits,) = struct.unpack("<i", packed)
    return float(struct.unpack("<f", struct.pack("<i", bits + (1 if threshold > 0 else -1)))[0])


def describe_sum(terms: Sequence[tuple[float | Fraction, Any]], names: Sequence[str], digits: int = 6) -> str:
    """A sum as people read it: `0.5 x - y + 1`, `2 (x - 1) + y`. `terms`: weights with places of names, or with sums;
    below 0: the weight alone.
    """

    def named(place: Any) -> str | None:
        if not isinstance(place, int):
            return f"({describe_sum(place.terms, names, digits)})"
        return names[place] if place >= 0 else None

    parts = [_describe_term(weight, named(place), digits) for weight, place in terms]
    text = " ".join(f"{sign} {size}" for sign, size in parts)
    return text.removeprefix("+ ").replace("- ", "-", 1) if text.startswith("- ") else text.removeprefix("+ ")


def _describe_term(weight: float | Fraction, name: str | None, digits: int) -> tuple[str, str]:
    if isinstance(weight, Fraction):  # which divides by its reciprocal
        return "-" if weight < 0 else "+", f"{name} / {float(abs(1 / weight)):.{digits}g}"
    sign, size = "-" if math.copysign(1, weight) < 0 else "+", f"{abs(weight):.{digits}g}"
    if name is None:
        return sign, size
    return sign, name if abs(weight) == 1 else f"{size} {name}"


def visible(text: str) -> str:
    """A line in any language: what cannot be seen, or would steer a terminal, is escaped, but for tabs."""
    if text.isprintable():
        return text
    return "".join(each if each.isprintable() or each == "\t" else escape_letter(each) for each in text)


def align_columns(table: Sequence[Sequence[str]]) -> list[str]:
    """The rows of a table as lines, each column as wide as its widest cell."""
    widths = [max(len(row[column]) for row in table) for column in range(len(table[0]))]
    return ["  ".join(f"{cell:<{width}}" for cell, width in zip(row, widths, strict=True)).rstrip() for row in table]
