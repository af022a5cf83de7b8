"""Intervals of means: their coverage where there are few episodes."""

import numpy as np
import pytest

from codegen.intervals import Z95
from maviper.episodes.measures import NORMAL, Mean, estimate
from maviper.worlds import Measure

RETURN = Measure("a", "return")


@pytest.mark.parametrize("count", [2, 3, 5, 20])
def test_the_interval_of_a_mean_covers_it_in_95_of_100_samples(count):
    """By the normal approximation it was 70 % at 2 episodes, 81 % at 3, 88 % at 5."""
    rng, samples = np.random.default_rng(count), 4_000
    intervals = np.array([estimate(RETURN, rng.normal(1.0, 2.0, count)).interval for _ in range(samples)])
    covered = float(((intervals[:, 0] <= 1.0) & (intervals[:, 1] >= 1.0)).mean())
    assert 0.94 < covered < 0.96


def test_many_episodes_have_the_normal_interval_that_records_have():
    values = np.random.default_rng(0).normal(size=NORMAL)
    few, many = estimate(RETURN, values[:-1]), estimate(RETURN, values)
    assert isinstance(few, Mean) and isinstance(many, Mean)
    assert many.half_width == Z95 * values.std(ddof=1) / NORMAL**0.5
    assert 1 < few.half_width / (Z95 * values[:-1].std(ddof=1) / (NORMAL - 1) ** 0.5) < 1.013
