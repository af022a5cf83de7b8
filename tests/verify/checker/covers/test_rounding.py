"""Sums, products and quotients that are rounded outward: bounds in exact numbers, and exact where a float is met."""

from fractions import Fraction as F

import numpy as np
import pytest

from verify.checker.covers import rounding
from verify.checker.covers.rounding import Factor, ceiling, ensure_arithmetic, floor, sum_down, sum_up
from verify.checker.reading import RejectedError

EDGES = [0.0, 1.0, -1.0, 2.0**-1074, 2.0**-1022, 2.0**-1022 * 3, 0.1, 1 / 3, 2.0**53, 2.0**53 + 2, 1e300, 1 - 2.0**-53]
FACTORS = [F(1), F(-1), F(1, 10), F(-1, 3), F(2), F(-1, 4), F(7, 5), F(10) ** 20, F(1, 2), F(9, 8)]
FACTORS += [F(2) ** -1020, F(1, 3) * F(2) ** -1020]  # products below the normal floats
# half of the first is rounded up to the least normal float; twice the second is none
BEYOND = np.array([(2 - 2.0**-52) * 2.0**-1022, 1.7e308])


def numbers(count=2_000, seed=0):
    random = np.random.default_rng(seed)
    drawn = random.standard_normal(count) * 2.0 ** random.integers(-60, 60, count)
    edges = np.array([sign * each for each in EDGES for sign in (1, -1)])
    return np.concatenate([edges, drawn, random.choice(edges, count) * random.choice([1.0, 0.5, 3.0], count)])


def test_floats_around_numbers():
    for each in (F(1, 3), F(-1, 3), F(1, 2), F(10) ** -400, -(F(10) ** -400), F(0), F(2) ** 100 + 1):
        assert F(floor(each)) <= each <= F(ceiling(each))
        assert floor(each) == ceiling(each) or np.nextafter(floor(each), np.inf) == ceiling(each)
    with pytest.raises(RejectedError):
        floor(F(10) ** 400)


def test_sums():
    one, other = numbers(seed=1), numbers(seed=2)
    for a, b, low, high in zip(one, other, sum_down(one, other), sum_up(one, other), strict=True):
        exact = F(a) + F(b)
        assert F(low) <= exact <= F(high)
        assert (low == high) == (F(low) == exact)


def test_sums_beyond_the_floats_are_none():
    with np.errstate(all="ignore"):
        assert np.isnan(sum_down(BEYOND[1:], BEYOND[1:])).all() and np.isnan(sum_up(-BEYOND[1:], -BEYOND[1:])).all()
        assert sum_down(-BEYOND[1:], -BEYOND[1:]) == -np.inf and sum_up(BEYOND[1:], BEYOND[1:]) == np.inf


@pytest.mark.parametrize("factor", FACTORS, ids=str)
def test_products_and_quotients(factor):
    values, by = np.concatenate([numbers(500, seed=3), BEYOND, -BEYOND]), Factor(factor)
    with np.errstate(all="ignore"):
        found = by.times_down(values), by.into_down(values)
    for value, low, least in zip(values, *found, strict=True):
        assert not np.isfinite(low) or F(low) <= factor * F(value)
        assert not np.isfinite(least) or F(least) <= F(value) / factor
        assert low != np.inf
    assert (by.times_down(np.zeros(1)) == 0).all()


@pytest.mark.parametrize("factor", [F(10) ** -400, F(2) ** -1060, -(F(2) ** -1023)], ids=str)
def test_factors_too_small(factor):
    with pytest.raises(RejectedError):
        Factor(factor)


@pytest.mark.parametrize("fault", ["rounds up", "rounds down", "drops subnormals"])
def test_another_arithmetic_is_refused(fault, monkeypatch):
    class Odd(np.ndarray):
        def __array_ufunc__(self, ufunc, method, *given, **more):
            plain = [np.asarray(each) for each in given]
            found = getattr(ufunc, method)(*plain, **more)
            if found.dtype == np.bool_:
                return found
            if fault == "drops subnormals":
                found = np.where(np.abs(found) < 2.0**-1022, 0.0, found)
            elif ufunc is np.add or ufunc is np.subtract:
                found = np.nextafter(found, np.inf if fault == "rounds up" else -np.inf)
            return found.view(Odd)

    ensure_arithmetic()
    ones, full = np.ones, np.full
    monkeypatch.setattr(rounding.np, "ones", lambda count: ones(count).view(Odd))
    monkeypatch.setattr(rounding.np, "full", lambda count, each: full(count, each).view(Odd))
    with pytest.raises(RejectedError, match="round"):
        ensure_arithmetic()
