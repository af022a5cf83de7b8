"""Paired comparisons of a few seeds: verdict words. The tests behind them are those of `maviper reproduce`."""

from dataclasses import dataclass

import numpy as np

from maviper.reproduction.statistics import Estimate, of_differences

BETTER, WORSE, NOT_DECIDED = "BETTER", "WORSE", "NOT DECIDED"


@dataclass(frozen=True)
class Paired:
    """Differences of one comparison, one per seed; positive where the first is better."""

    differences: tuple[float, ...]

    @property
    def mean(self):
        return float(np.mean(self.differences))

    @property
    def deviation(self):
        """The standard deviation over seeds; 0 for one seed."""
        return float(np.std(self.differences, ddof=1)) if len(self.differences) > 1 else 0.0

    def interval(self, level=0.95):
        """Of the mean, by Student's t."""
        return of_differences(self.differences).interval(level)

    def p_differs(self):
        """Two-sided."""
        return of_differences(self.differences).p_differs()

    def p_equal(self, margin):
        """Of the mean lying within the margin on both sides: two one-sided tests."""
        return of_differences(self.differences).p_equal(margin)


def detectable(deviation, seeds, alpha, power):
    """The mean difference that a two-sided paired t test of so many seeds finds with that power."""
    return Estimate(0.0, deviation / seeds**0.5, seeds - 1).detectable(alpha, power)
