"""Thresholds: rounding and literals decide as the numbers they stand for."""

import ctypes
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from codegen.floats import deciding_double, short_hex
from codegen.numbers import decimal_literal, hex_literal, round_down
from tests.support.strategies import FLOAT32

DOUBLES = st.floats(-1e38, 1e38, allow_nan=False)
INFINITY = np.float32(np.inf)


@given(DOUBLES)
def test_round_down_preserves_every_float32_decision(threshold):
    rounded = round_down(threshold)
    at = np.array([rounded, np.nextafter(rounded, INFINITY), np.nextafter(rounded, -INFINITY)])
    assert ((at <= np.float64(threshold)) == (at <= rounded)).all()


def test_round_to_nearest_would_not():
    threshold = 0.1  # its nearest float32 lies above it
    x = np.float32(threshold)
    assert not x <= np.float64(threshold)
    assert not x <= round_down(threshold)
    assert x <= np.float32(threshold)


@pytest.mark.parametrize("threshold", [3.5e38, 1e300])
def test_round_down_beyond_the_largest_float32(threshold):
    assert round_down(threshold) == np.finfo(np.float32).max


@given(FLOAT32, st.sampled_from([-2, -1, 0, 1, 2]))
def test_deciding_double_decides_as_float32_rounding(value, steps):
    threshold = np.float32(value)
    turning = deciding_double(threshold)
    double = turning
    for _ in range(abs(steps)):
        double = math.nextafter(double, math.copysign(math.inf, steps))
    with np.errstate(over="ignore"):
        single = np.float32(double)
    assert (double <= turning) == bool(single <= threshold)
    # a float32 scalar against a Python float is compared in float32 (NumPy 2), which must agree too
    assert bool(single <= turning) == bool(single <= threshold)
    assert np.float32(turning) <= threshold < np.nextafter(threshold, INFINITY)


@given(FLOAT32)
def test_literals_read_back(value):
    assert float.fromhex(hex_literal(np.float32(value)).rstrip("f")) == value
    assert float.fromhex(short_hex(value)) == value
    assert float(decimal_literal(value)) == value


def test_hex_literal_in_c_syntax():
    assert hex_literal(np.float32(0.1)) == "0x1.99999ap-4f"
    assert hex_literal(np.float32(0)) == "0x0p+0f"
    assert ctypes.c_float(float.fromhex("0x1.99999ap-4")).value == float(np.float32(0.1))
