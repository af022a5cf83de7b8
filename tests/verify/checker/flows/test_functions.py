"""Intervals of functions, sums and products hold what mpmath says to 30 digits, and exact fractions."""

from fractions import Fraction as F

import numpy as np
import pytest

from verify.checker.covers.rounding import Factor
from verify.checker.flows import intervals
from verify.checker.flows.intervals import Spans

mpmath = pytest.importorskip("mpmath")
N = 400


def points(random, scale):
    """Floats of all sizes up to a scale, with those next to multiples of pi / 2 among them."""
    some = random.standard_normal(N) * 10.0 ** random.uniform(-12, np.log10(scale), N)
    turns = np.rint(random.uniform(-0.6, 0.6, N) * min(scale, 1e6))
    edges = turns * (np.pi / 2) + random.choice([-1e-13, 0.0, 1e-13, 1e-9], N)
    return np.clip(np.concatenate([some, edges, [0.0, scale, -scale]]), -scale, scale)


CASES = {
    "sin": (lambda span: intervals.waves(span)[0], 1e6),
    "cos": (lambda span: intervals.waves(span)[1], 1e6),
    "exp": (intervals.exponential, 600.0),
    "sqrt": (intervals.root, 1e9),
}


@pytest.mark.parametrize("name", CASES)
def test_points_and_widths_hold_the_function(name):
    function, scale = CASES[name]
    random = np.random.default_rng(0)
    x = np.abs(points(random, scale)) if name == "sqrt" else points(random, scale)
    wide = np.minimum(x + 10.0 ** random.uniform(-10, 1, len(x)), scale)
    narrow, found = function(Spans(x, x)), function(Spans(x, wide))
    with mpmath.workdps(40):
        for place, number in enumerate(x):
            exact = getattr(mpmath, name)(mpmath.mpf(number))
            assert narrow.low[place] <= exact <= narrow.high[place], (name, number)
            assert narrow.high[place] - narrow.low[place] <= 1e-13 * max(1.0, abs(narrow.high[place]))
            for share in (0.0, 0.31, 1.0):
                inner = number + share * (wide[place] - number)
                value = getattr(mpmath, name)(mpmath.mpf(min(max(inner, number), wide[place])))
                assert found.low[place] <= value <= found.high[place], (name, number, wide[place])


@pytest.fixture(autouse=True)
def _quietly():
    with np.errstate(all="ignore"):  # as sweeps do: what overflows is not finite
        yield


def test_what_is_not_defined_is_no_number():
    one = np.ones(1)
    for span in (
        intervals.inverse(Spans(-one, one)),
        intervals.root(Spans(-one, one)),
        intervals.exponential(Spans(one, 1e4 * one)),
        intervals.waves(Spans(one, 1e7 * one))[0],
    ):
        assert not intervals.finite(span).any()


def test_sums_and_products_hold_exact_results():
    random = np.random.default_rng(1)

    def some():
        ends = random.standard_normal((2, N)) * 10.0 ** random.uniform(-160, 160, N)
        ends[:, ::7], ends[0, ::5] = 0.0, 0.0
        return Spans(ends.min(axis=0), ends.max(axis=0))

    factor = F(-22, 7)
    for _ in range(3):
        one, other = some(), some()
        results = {
            "plus": (intervals.plus(one, other), lambda a, b: a + b),
            "minus": (intervals.minus(one, other), lambda a, b: a - b),
            "times": (intervals.times(one, other), lambda a, b: a * b),
            "scaled": (intervals.scale_spans(one, Factor(factor)), lambda a, b: a * factor),
        }
        for name, (found, exactly) in results.items():
            for place in range(N):
                ends = [exactly(F(one[i][place]), F(other[j][place])) for i in (0, 1) for j in (0, 1)]
                if np.isfinite(found.low[place]) and np.isfinite(found.high[place]):
                    assert F(found.low[place]) <= min(ends) and max(ends) <= F(found.high[place]), name
        squares = intervals.square(one)
        for place in range(N):
            low, high = F(one.low[place]), F(one.high[place])
            if np.isfinite(squares.high[place]):
                assert F(squares.low[place]) <= (0 if low <= 0 <= high else min(low**2, high**2))
                assert max(low**2, high**2) <= F(squares.high[place])
