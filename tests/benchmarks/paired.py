"""Paired comparisons of a few seeds: p-values, Holm's correction, verdict words, and the effect that can be seen."""

from dataclasses import dataclass

import numpy as np
from scipy import stats

BETTER, WORSE, NOT_DECIDED = "BETTER", "WORSE", "NOT DECIDED"


@dataclass(frozen=True)
class Paired:
    """Differences of one comparison, one a seed; positive where the first is better."""

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
        if len(self.differences) < 2:
            return -np.inf, np.inf
        half = stats.t.ppf((1 + level) / 2, len(self.differences) - 1) * self._error()
        return self.mean - half, self.mean + half

    def _error(self):
        return self.deviation / len(self.differences) ** 0.5

    def _above(self, bound):
        """The one-sided p-value of the mean lying above a bound."""
        count = len(self.differences)
        if count < 2:
            return 1.0
        if np.ptp(self.differences) < 1e-12:  # all the same: t would divide by nothing
            return float(self.mean <= bound)
        return float(stats.t.sf((self.mean - bound) / self._error(), count - 1))

    def p_differs(self):
        """Two-sided."""
        return min(1.0, 2 * min(self._above(0.0), self.turned()._above(0.0)))

    def p_equal(self, margin):
        """Of the mean lying within the margin on both sides: two one-sided tests."""
        return max(self._above(-margin), self.turned()._above(-margin))

    def turned(self):
        """With the other one first."""
        return Paired(tuple(-each for each in self.differences))


def holm(p_values):
    """Holm's adjusted p-values, in the order given."""
    order = np.argsort(p_values, kind="stable")
    adjusted, least = np.zeros(len(order)), 0.0
    for rank, place in enumerate(order):
        least = max(least, min(1.0, (len(order) - rank) * p_values[place]))
        adjusted[place] = least
    return adjusted.tolist()


def verdicts(family, alpha, margin):
    """A word for each comparison of a family, Holm-corrected over it."""
    differ = holm([each.p_differs() for each in family])
    equal = holm([each.p_equal(margin) for each in family])
    words = []
    for each, apart, alike in zip(family, differ, equal, strict=True):
        if alike <= alpha:
            words.append(f"EQUAL within {margin:g}".replace("0.", "."))
        elif apart <= alpha:
            words.append(BETTER if each.mean > 0 else WORSE)
        else:
            words.append(NOT_DECIDED)
    return words


def detectable(deviation, seeds, alpha, power):
    """The mean difference that a two-sided paired t test of so many seeds finds with that power."""
    return float((stats.t.ppf(1 - alpha / 2, seeds - 1) + stats.t.ppf(power, seeds - 1)) * deviation / seeds**0.5)
