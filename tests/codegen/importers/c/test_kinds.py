"""Literals of C have the value that a compiler gives them."""

from fractions import Fraction

import numpy as np
import pytest

from codegen.importers.c.kinds import (
    DOUBLE,
    FLOAT,
    INT,
    LLONG,
    LONG,
    SHORT,
    UINT,
    ULONG,
    Many,
    Number,
    Record,
    literal,
    round_number,
    size_of,
)


@pytest.mark.parametrize(
    ("text", "value", "kind"),
    [
        ("0.5", 0.5, DOUBLE),
        ("0.1", 0.1, DOUBLE),
        ("0.1f", 0.10000000149011612, FLOAT),
        (".5F", 0.5, FLOAT),
        ("1.", 1.0, DOUBLE),
        ("1e3", 1000.0, DOUBLE),
        ("12", 12, INT),
        ("0", 0, INT),
        ("010", 8, INT),
        ("0x1F", 31, INT),
        ("0X1fL", 31, LONG),
        ("017777777777", 2**31 - 1, INT),
        ("9223372036854775807", 2**63 - 1, LLONG),
        ("2147483648ll", 2**31, LLONG),
        ("1u", 1, UINT),
        ("1UL", 1, ULONG),
        ("0x80000000", 2**31, UINT),
        ("'a'", 97, INT),
        ("'\\n'", 10, INT),
        ("'\"'", 34, INT),
        ("0x1.8p1", 3.0, DOUBLE),
        ("0x1.8p1f", 3.0, FLOAT),
        # the double nearest to it is the middle of two floats, and would round to the even one below
        ("1.000000059604644775390626f", 1.0000001192092896, FLOAT),
        ("1.000000059604644775390625f", 1.0, FLOAT),  # the middle itself
        ("3.4028235e38f", 3.4028234663852886e38, FLOAT),
    ],
)
def test_literals(text, value, kind):
    assert literal(text) == Number(value, kind)


@pytest.mark.parametrize(
    "text",
    ["1.0L", "1lL", "0b1", "08", "0x", "9223372036854775808", "'ab'", "'\\x41'", "L'a'", "'é'", "''", '"1"', "1e400",
     "1e39f", "1e400f", "1e9999f", "0x1.000000000000008p0f", "1_0", "", "١"],
)  # fmt: skip
def test_what_is_not_understood_or_not_finite_is_none(text):
    assert literal(text) is None


def test_exact_numbers_are_rounded_once_to_the_nearest_even():
    assert round_number(Fraction(1, 10), FLOAT) == np.float32(0.1) and round_number(Fraction(1, 10), DOUBLE) == 0.1
    assert round_number(2**24 + 1, FLOAT) == 2**24 and round_number(2**24 + 3, FLOAT) == 2**24 + 4
    largest = 2**128 - 2**104
    assert round_number(largest + 2**103 - 1, FLOAT) == np.float32(largest)  # below the middle of it and 2**128
    assert np.isposinf(round_number(largest + 2**103, FLOAT)) and np.isneginf(round_number(-(10**400), DOUBLE))


def test_structs_are_as_large_as_compilers_align_them():
    record = Record("", {"a": SHORT, "b": DOUBLE, "c": Many(SHORT, 3)})
    assert size_of(record) == (24, 8) and size_of(Many(record, 2)) == (48, 8)
