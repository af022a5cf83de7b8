"""Exact numbers as people write them: decimals and fractions.

Does: reads one from a text or a value of a TOML file whose floats were read as texts; writes one.
Assumes: nothing about the text.
Does not: round.
"""

import re
from fractions import Fraction

from codegen.errors import InputError
from codegen.floats import rational_literal
from verify.exact import MAX_NUMBER

MAX_PLACES = 60  # of a decimal; what needs more is written as a fraction
MAX_DIGITS = 2_000
_DECIMAL = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,3})?|[+-]?\d+/\d+", re.ASCII)


def text(number: Fraction) -> str:
    """A number as files have it: a fraction is in quotes."""
    literal = plain(number)
    return f'"{literal}"' if "/" in literal else literal


def plain(number: Fraction, most: int = MAX_PLACES) -> str:
    """A number as a decimal where it has one of at most so many places, else as a fraction; `exact` reads both."""
    rest, twos = _without(number.denominator, 2)
    rest, fives = _without(rest, 5)
    places = max(twos, fives)
    if rest != 1 or places > most:
        return rational_literal(number)
    digits = f"{abs(number.numerator) * 10**places // number.denominator:0{places + 1}d}"
    sign = "-" if number < 0 else ""
    return sign + (f"{digits[:-places]}.{digits[-places:]}" if places else digits)


def _without(number: int, factor: int) -> tuple[int, int]:
    """A number divided by a factor as often as that goes, and how often."""
    times = 0
    while not number % factor:
        number, times = number // factor, times + 1
    return number, times


def number(value: object, where: object) -> Fraction:
    """The exact number of a TOML value whose floats were read as texts: a number, or a text as `exact` reads it."""
    if isinstance(value, bool) or not isinstance(value, (int, str, Fraction)):
        raise InputError("not a number", where, 'write 0.025 or "1/40"')
    if isinstance(value, str):
        return exact(value, where)
    if abs(value) > MAX_NUMBER:
        raise InputError(f"numbers may be at most {MAX_NUMBER}", where)
    return Fraction(value)


def exact(written: str, where: object) -> Fraction:
    """The number that a text states exactly: a decimal or a fraction such as 1/40. InputError for anything else."""
    unspaced = written.strip().replace("_", "")
    if len(unspaced) > MAX_DIGITS or not _DECIMAL.fullmatch(unspaced) or not written.isprintable():
        raise InputError(f"not a number: {written[:40]!r}", where, "write 0.025 or 1/40")
    try:
        stated = Fraction(unspaced)
    except ZeroDivisionError:
        raise InputError(f"not a number: {written[:40]!r}", where, "write 0.025 or 1/40") from None
    if abs(stated) > MAX_NUMBER:
        raise InputError(f"numbers may be at most {MAX_NUMBER}", where)
    return stated
