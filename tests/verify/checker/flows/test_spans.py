"""Sums, products and quotients of intervals hold the exact ones of all their ends, at the ends of the floats too."""

from fractions import Fraction as F
from itertools import product

import numpy as np
import pytest

from verify.checker.covers.rounding import Factor
from verify.checker.flows import intervals
from verify.checker.flows.intervals import Spans

ENDS = [0.0, 1.0, 3.0, 0.1, 2.0**-1074, 3e-320, 2.0**-1022, 1.5e-160, 7e150, 1.7e308]
FACTORS = (F(1), F(-1), F(1, 3), F(-7, 5), F(2) ** 40)


def random_spans(seed, count=300):
    """Intervals with ends of all sizes, points and zeros among them."""
    random = np.random.default_rng(seed)
    ends = (
        random.choice([-1.0, 1.0], (2, count)) * random.choice(ENDS, (2, count)) * random.choice([1.0, 0.7], (2, count))
    )
    ends[1, ::5] = ends[0, ::5]
    return Spans(ends.min(axis=0), ends.max(axis=0))


def misses(found, exact):
    """How many finite intervals do not hold all exact numbers of theirs; those that are not finite say nothing."""
    finite = intervals.finite(found).tolist()
    bounds = zip(found.low.tolist(), found.high.tolist(), strict=True)
    return sum(
        known and not all(F(low) <= each <= F(high) for each in sure)
        for known, (low, high), sure in zip(finite, bounds, exact, strict=True)
    )


def ends_of(span):
    return [(F(low), F(high)) for low, high in zip(span.low.tolist(), span.high.tolist(), strict=True)]


def missed(seed=0):
    """How often one of the operations misses an exact result."""
    one, other = random_spans(seed), random_spans(seed + 1)
    pairs = list(zip(ends_of(one), ends_of(other), strict=True))
    with np.errstate(all="ignore"):
        count = misses(intervals.plus(one, other), [[a + b for a, b in product(*pair)] for pair in pairs])
        count += misses(intervals.times(one, other), [[a * b for a, b in product(*pair)] for pair in pairs])
        count += misses(intervals.square(one), [[a * a for a in ends] for ends in ends_of(one)])
        sure = [[1 / a for a in ends] if 0 not in ends else [] for ends in ends_of(one)]
        count += misses(intervals.inverse(one), sure)
        for factor in FACTORS:
            found = intervals.scale_spans(one, Factor(factor))
            count += misses(found, [[factor * a for a in ends] for ends in ends_of(one)])
    return count


def test_operations_hold_the_exact_results():
    assert not any(map(missed, (0, 7)))


def test_what_is_exactly_zero_stays_so():
    nothing, wide = Spans(np.zeros(1), np.zeros(1)), Spans(np.array([-np.inf]), np.array([1e300]))
    with np.errstate(all="ignore"):
        found = intervals.times(nothing, wide)
    assert found.low[0] == found.high[0] == 0.0


@pytest.mark.parametrize("fault", ["lower", "sum_down"])
def test_a_planted_fault_is_caught(fault, monkeypatch):
    faults = {"lower": lambda values: values, "sum_down": lambda one, other: one + other}
    monkeypatch.setattr(intervals, fault, faults[fault])
    assert missed()
