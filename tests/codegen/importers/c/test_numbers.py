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
    ["010", "0x10", "1u", "1L", "1.0L", "'a'", '"1"', "1e400", "1e39f", "0x1.000000000000008p0f", "1_0", "", "١"],
)
def test_what_is_not_understood_or_not_finite_is_none(text):
    assert literal(text) is None


def test_conversions_change_nothing_or_round_once():
    assert converted(Literal(0.1, DOUBLE), FLOAT) == 0.10000000149011612
    assert converted(Literal(1e300, DOUBLE), FLOAT) is None and converted(Literal(0.5, DOUBLE), "int") is None
    assert converted(Literal(2**24 + 1, WHOLE), FLOAT) is None and converted(Literal(300, WHOLE), "uint8_t") is None
    assert math.isclose(converted(Literal(0.5, FLOAT), DOUBLE), 0.5)
