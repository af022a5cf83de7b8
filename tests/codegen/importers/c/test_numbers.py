"""Literals of C have the value that a compiler gives them."""

import math

import pytest

from codegen.importers.c.numbers import DOUBLE, FLOAT, WHOLE, Literal, converted, literal


@pytest.mark.parametrize(
    ("text", "value", "kind"),
    [
        ("0.5", 0.5, DOUBLE),
        ("0.1", 0.1, DOUBLE),
        ("0.1f", 0.10000000149011612, FLOAT),
        (".5F", 0.5, FLOAT),
        ("1.", 1.0, DOUBLE),
        ("1e3", 1000.0, DOUBLE),
        ("12", 12, WHOLE),
        ("0", 0, WHOLE),
        ("010", 8, WHOLE),
        ("0x1F", 31, WHOLE),
        ("0X1fL", 31, WHOLE),
        ("017777777777", 2**31 - 1, WHOLE),
        ("9223372036854775807", 2**63 - 1, WHOLE),
        ("2147483648ll", 2**31, WHOLE),
        ("'a'", 97, WHOLE),
        ("'\"'", 34, WHOLE),
        ("0x1.8p1", 3.0, DOUBLE),
        ("0x1.8p1f", 3.0, FLOAT),
        # the double nearest to it is the middle of two floats, and would round to the even one below
        ("1.000000059604644775390626f", 1.0000001192092896, FLOAT),
        ("1.000000059604644775390625f", 1.0, FLOAT),  # the middle itself
        ("3.4028235e38f", 3.4028234663852886e38, FLOAT),
    ],
)
def test_literals(text, value, kind):
    assert literal(text) == Literal(value, kind)


@pytest.mark.parametrize(
    "text",
    ["1u", "1UL", "1.0L", "1lL", "0b1", "08", "0x", "0x80000000", "020000000000", "9223372036854775808", "'ab'",
     "'\\n'", "L'a'", "'é'", "''", '"1"', "1e400", "1e39f", "1e400f", "1e9999f", "0x1.000000000000008p0f",
     "1_0", "", "١"],
)  # fmt: skip
def test_what_is_not_understood_or_not_finite_is_none(text):
    assert literal(text) is None


def test_conversions_change_nothing_or_round_once():
    assert converted(Literal(0.1, DOUBLE), FLOAT) == 0.10000000149011612
    assert converted(Literal(1e300, DOUBLE), FLOAT) is None and converted(Literal(0.5, DOUBLE), "int") is None
    assert converted(Literal(2**24 + 1, WHOLE), FLOAT) is None and converted(Literal(300, WHOLE), "uint8_t") is None
    assert math.isclose(converted(Literal(0.5, FLOAT), DOUBLE), 0.5)
