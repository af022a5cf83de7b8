"""Machine thresholds: the ends of half lines, against the roundings themselves."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from tests.strategies import FLOAT32
from verify.encode import half_line, last_double

NORMAL = FLOAT32.filter(lambda value: value == 0 or abs(value) >= 2.0**-126)


def holds(line, d):
    return d < line.end if line.strict else d <= line.end


@given(NORMAL, st.integers(-3, 3), st.floats(-4, 4))
def test_half_line_is_what_two_roundings_do(threshold, steps, b):
    """For float64 a and b near the end, fl32(fl64(a - b)) <= t iff the exact a - b lies on the half line."""
    assume(abs(threshold) < 1e30)
    line = half_line(threshold)
    a = float(line.end + Fraction(b))
    for _ in range(abs(steps)):
        a = math.nextafter(a, math.copysign(math.inf, steps))
    observed = np.float32(np.float64(a) - np.float64(b))
    assert bool(observed <= np.float32(threshold)) == holds(line, Fraction(a) - Fraction(b))


@given(NORMAL, st.integers(-3, 3))
def test_one_rounding_of_a_coordinate(threshold, steps):
    assume(abs(threshold) < 1e38)
    line = last_double(threshold)
    z = float(line.end)
    for _ in range(abs(steps)):
        z = math.nextafter(z, math.copysign(math.inf, steps))
    with np.errstate(over="ignore"):
        assert bool(np.float32(z) <= np.float32(threshold)) == holds(line, Fraction(z))


def test_ties_are_decided_by_the_even_significand():
    one, above = np.float32(1), np.nextafter(np.float32(1), np.float32(2))
    tie = (Fraction(float(one)) + Fraction(float(above))) / 2
    assert last_double(1.0) == (tie, False)  # 1 is even: the tie rounds to it
    higher = np.nextafter(above, np.float32(2))
    tie = (Fraction(float(above)) + Fraction(float(higher))) / 2
    assert last_double(float(above)) == (tie, True)


@pytest.mark.parametrize("threshold", [0.1, -0.1, 0.25, 1.0, 0.0])
def test_naive_real_semantics_would_differ(threshold):
    """The end of the half line is never the threshold itself."""
    assert half_line(float(np.float32(threshold))).end != Fraction(float(np.float32(threshold)))


@pytest.mark.solver
def test_float32_theory_agrees_with_the_half_line():
    """Z3's own floating-point theory, which shares nothing with our arithmetic, at a few thresholds."""
    import z3

    mode = z3.RNE()
    d = z3.FP("d", z3.Float64())
    for threshold in (0.0, 0.1, -0.3, 1.0, float(np.nextafter(np.float32(1), np.float32(2)))):
        single = z3.fpFPToFP(mode, d, z3.Float32())
        line = last_double(float(np.float32(threshold)))
        end = float(line.end)
        assert Fraction(end) == line.end
        bound = z3.FPVal(end, z3.Float64())
        ours = z3.fpLT(d, bound) if line.strict else z3.fpLEQ(d, bound)
        theirs = z3.fpLEQ(single, z3.FPVal(float(np.float32(threshold)), z3.Float32()))
        solver = z3.Solver()
        solver.add(z3.Not(z3.fpIsNaN(d)), ours != theirs)
        assert solver.check() == z3.unsat, threshold
