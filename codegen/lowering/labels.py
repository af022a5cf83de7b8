"""Labels of actions as literals of each language: what an imported source returns where code returns a place.

Does: chooses a type that holds all labels of an agent, and writes each exactly.
Assumes: labels that check.py accepts.
Does not: name anything.
"""

import json
from collections.abc import Callable, Sequence

from codegen.floats import short_hex
from codegen.lowering.model import Labels
from codegen.numbers import decimal_literal

INT, LONG = 2**31, 2**53  # below which C's int, and every program's 64-bit numbers, hold whole numbers
PLAIN = {*map(chr, range(0x20, 0x7F))} - {*'"\\?*/'}
Label = int | float | str


def labels_of(given: Sequence[Label | None]) -> Labels | None:
    """The labels of an agent's actions; None where it has none."""
    labels = [each for each in given if each is not None]
    if not labels:
        return None
    texts, numbers = [each for each in labels if isinstance(each, str)], [e for e in labels if not isinstance(e, str)]
    if texts:
        c, python, other = (tuple(_quote_text(each, way) for each in texts) for way in (_octal, _long, _brace_letter))
        return Labels(c, "char *const", python, "str", other, other, "&str", json.dumps(texts))
    if all(isinstance(each, int) and abs(each) <= LONG for each in numbers):
        plain = tuple(map(str, numbers))
        kind = "int" if all(abs(each) < INT for each in numbers) else "long long"
        return Labels(plain, kind, plain, "int", plain, plain, "i64", json.dumps(numbers))
    doubles = [float(each) for each in numbers]
    written, decimal = tuple(map(short_hex, doubles)), tuple(map(decimal_literal, doubles))
    return Labels(written, "double", decimal, "float", decimal, decimal, "f64", json.dumps(doubles))


def _quote_text(text: str, escaped: Callable[[str], str]) -> str:
    return f'"{"".join(each if each in PLAIN else escaped(each) for each in text)}"'


def _octal(letter: str) -> str:
    return "".join(f"\\{byte:03o}" for byte in letter.encode())


def _long(letter: str) -> str:
    return f"\\U{ord(letter):08x}"


def _brace_letter(letter: str) -> str:
    return f"\\u{{{ord(letter):x}}}"
