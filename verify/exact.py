"""Exact numbers: their texts in files, read without trusting them, and how large they may be in a question.

Does: reads a number that a file states exactly.
Assumes: a reader that turns ValueError into words about its file.
Does not: round, write, or read what people write (decimals.py).
"""

import re
from fractions import Fraction

MAX_NUMBER = 10**9  # largest length in a question; beyond it float64 positions are coarser than any world
MAX_DIGITS = 4000
_NUMBER = re.compile(r'-?\d+(\.\d+)?|"?-?\d+/\d+"?')


def read_number(text: object) -> Fraction:
    """A number from its exact text. ValueError for anything else."""
    if not isinstance(text, str) or len(text) > MAX_DIGITS or not _NUMBER.fullmatch(text):
        raise ValueError(f"not a number, or one with more than {MAX_DIGITS} digits: {str(text)[:40]!r}")
    try:
        return Fraction(text.strip('"'))
    except ZeroDivisionError:
        raise ValueError(f"not a number: {text[:40]!r}") from None
