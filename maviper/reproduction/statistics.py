"""Numbers over seeds and episodes with what they are known by: intervals, p-values, Holm's correction, visible effects.

Does: the bootstrap over seeds and episodes, t intervals and tests from its standard error, two one-sided tests.
Assumes: what is compared was played in the same episodes (common random numbers), so that draws are shared.
Does not: know claims, games or files.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.special import stdtr, stdtrit  # pyright: ignore[reportMissingTypeStubs]

from codegen.ir import Float64
from maviper.evaluation.crossplay import DRAWS, counts

DRAW_SEED = 17
TINY = 1e-12  # a smaller standard error is rounding: all draws are the same
LEVEL = 0.95
ENDS = (1 - LEVEL) / 2, (1 + LEVEL) / 2  # quantiles that an interval lies between


@dataclass(frozen=True)
class Estimate:
    """A number with its standard error, from which all else follows by Student's t (scipy.stats has the same functions,
    and takes most of a second to load).
    """

    value: float
    error: float
    freedom: int  # degrees of freedom; 0: nothing is known of the spread

    def interval(self, level: float = LEVEL) -> tuple[float, float]:
        """The two-sided interval of that level; infinite without degrees of freedom."""
        if not self.freedom:
            return -np.inf, np.inf
        half = float(stdtrit(self.freedom, (1 + level) / 2)) * self.error
        return self.value - half, self.value + half

    def p_above(self, bound: float) -> float:
        """The one-sided p-value of the number lying above a bound."""
        if not self.freedom or not np.isfinite(self.value):
            return 1.0
        if self.error < TINY:
            return float(self.value <= bound)
        return float(stdtr(self.freedom, (bound - self.value) / self.error))

    def p_below(self, bound: float) -> float:
        """The one-sided p-value of the number lying below a bound."""
        return Estimate(-self.value, self.error, self.freedom).p_above(-bound)

    def p_differs(self) -> float:
        """The two-sided p-value of the number not being 0."""
        return min(1.0, 2 * min(self.p_above(0.0), self.p_below(0.0)))

    def p_equal(self, margin: float) -> float:
        """The p-value of the number lying within the margin around 0: two one-sided tests (Schuirmann, 1987)."""
        return max(self.p_above(-margin), self.p_below(margin))

    def detectable(self, alpha: float, power: float) -> float:
        """The smallest true effect that a two-sided test finds with that power; infinite if none."""
        if not self.freedom:
            return np.inf
        return float((stdtrit(self.freedom, 1 - alpha / 2) + stdtrit(self.freedom, power)) * self.error)


VALUE, RATIO, INVERSE, REWARD, PAPER = "value", "ratio", "inverse", "reward", "paper"
MODES: Mapping[str, Callable[[Float64, Float64, Float64], Float64]] = {
    VALUE: lambda ours, theirs, size: ours,
    RATIO: lambda ours, theirs, size: ours / theirs,
    INVERSE: lambda ours, theirs, size: theirs / ours,
    REWARD: lambda ours, theirs, size: 1 + (ours - theirs) / size,
    PAPER: lambda ours, theirs, size: abs(abs(theirs) - abs(ours)) / theirs,
}


@dataclass(frozen=True)
class Term:
    """A weighted mean over seeds, part of a number.

    `mode`: a seed's own number. `value`: the mean of ours; `ratio`: of ours over theirs, or its `inverse`; `reward`:
    one and our gain over the mean size of their returns; `paper`: the paper's ||A|-|B||/A, theirs being A.
    """

    weight: float
    ours: Float64  # [seeds, episodes]
    theirs: Float64 | None = None  # [seeds, episodes], the same episodes
    mode: str = VALUE

    def by_seed(self, weights: Float64) -> Float64:
        """Each seed's number, [draws, seeds]. `weights` [draws, episodes]: of the episodes, each row's sum being 1."""
        theirs = self.ours if self.theirs is None else self.theirs
        return MODES[self.mode](weights @ self.ours.T, weights @ theirs.T, weights @ np.abs(theirs).T)


def estimate(terms: Sequence[Term], crossed: bool = False) -> Estimate:
    """The sum of terms that share their seeds and episodes, its standard error by the bootstrap.

    A draw of seeds, with replacement, serves all terms. A seed brings its own episodes, so that both are drawn at once;
    `crossed`: all seeds played the same episodes, which are then drawn beside the seeds. A single seed leaves the
    episodes alone. The standard error is enlarged by sqrt(n / (n - 1)), which the bootstrap of n lacks; n - 1 are the
    degrees of freedom.
    """
    seeds, episodes = terms[0].ours.shape
    rows, drawn_episodes = draws(seeds, episodes)
    even = np.full((1, episodes), 1 / episodes)
    weights = drawn_episodes if crossed or seeds == 1 else even
    with np.errstate(divide="ignore", invalid="ignore"):  # a ratio to nothing is no number
        value = sum(term.weight * float(term.by_seed(even).mean()) for term in terms)
        numbers = sum(term.weight * term.by_seed(weights) for term in terms)
        drawn = np.take_along_axis(np.broadcast_to(np.asarray(numbers), rows.shape), rows, axis=1).mean(axis=1)
    count = seeds if seeds > 1 else episodes
    if count < 2 or not np.isfinite(drawn).all() or not np.isfinite(value):
        return Estimate(value, float("nan"), 0)
    return Estimate(value, float(drawn.std(ddof=1)) * (count / (count - 1)) ** 0.5, count - 1)


@lru_cache(maxsize=16)
def draws(seeds: int, episodes: int) -> tuple[np.ndarray, Float64]:
    """The seeds drawn [DRAWS, seeds], and the weights of the episodes [DRAWS, episodes]."""
    rng = np.random.default_rng([DRAW_SEED, seeds, episodes])
    rows = rng.integers(0, seeds, (DRAWS, seeds))
    return rows, np.concatenate([*counts(episodes, rng)]) / episodes


def of_differences(differences: Sequence[float]) -> Estimate:
    """The mean of paired differences, one per seed, as the paired t test has it."""
    count = len(differences)
    deviation = float(np.std(differences, ddof=1)) if count > 1 else 0.0
    return Estimate(float(np.mean(differences)), deviation / count**0.5, count - 1)


def interquartile_mean(values: Float64) -> Float64:
    """The mean of the middle half of `values` [..., n]: at either end a quarter of n, rounded down, is left out."""
    cut = values.shape[-1] // 4
    return np.sort(values, axis=-1)[..., cut : values.shape[-1] - cut].mean(axis=-1)


def interquartile(scores: Sequence[Float64]) -> tuple[float, float, float]:
    """The interquartile mean of all scores of several tasks, each [runs], and its 95 % interval: percentiles of a
    bootstrap that draws runs within each task (Agarwal et al. 2021). NaN where there are none, or no finite ones.
    """
    every = np.concatenate([*scores, np.empty(0)])
    if not len(every) or not np.isfinite(every).all():
        return np.nan, np.nan, np.nan
    value = float(interquartile_mean(every))
    if max(map(len, scores)) < 2:
        return value, np.nan, np.nan
    low, high = np.quantile(interquartile_mean(_draw_runs(scores)), ENDS)
    return value, float(low), float(high)


def _draw_runs(scores: Sequence[Float64]) -> Float64:
    """As many runs as there are, drawn with replacement within each task, [DRAWS, runs of all tasks]."""
    rng = np.random.default_rng([DRAW_SEED, *map(len, scores)])
    return np.hstack([each[rng.integers(0, len(each), (DRAWS, len(each)))] for each in scores])


def performance_profile(scores: Sequence[Float64], thresholds: Float64) -> Float64:
    """The share of all runs whose score is above each threshold, and the ends of its 95 % interval, [3, thresholds];
    drawn as for `interquartile` (Agarwal et al. 2021, score distributions). `scores`: per task [runs].
    """
    drawn = _draw_runs(scores)
    bands = [np.quantile((drawn > each).mean(axis=1), ENDS) for each in thresholds]
    shares = (np.concatenate(scores) > thresholds[:, None]).mean(axis=1)
    return np.vstack([shares, np.transpose(bands)])


OPPOSITE, SMALLER, SAME_SIZE, SIZE_OPEN = "OPPOSITE", "SMALLER THAN HALF", "SAME SIZE", "SIZE OPEN"
HALF = 0.5  # of a published effect: an interval below it refutes the size, one above it confirms it
CEILING = 0.97  # of the expert, which a baseline may keep before a lead over it cannot be seen


def size(effect: float, low: float, high: float) -> str:
    """The word for an interval's size against a published `effect`, which is positive and in the same unit."""
    if high < 0:
        return OPPOSITE
    if high < HALF * effect:
        return SMALLER
    return SAME_SIZE if low >= HALF * effect else SIZE_OPEN


def untestable(low: float) -> bool:
    """Returns True if no lead over a baseline can be seen. `low`: lower bound of its ratio to the expert."""
    return low >= CEILING


def holm(p_values: Sequence[float], at_once: int | None = None) -> list[float]:
    """Holm's adjusted p-values (1979), in the order given.

    `at_once`: how many of the hypotheses can be true together, where logic allows fewer than all (Shaffer, 1986).
    """
    most = len(p_values) if at_once is None else at_once
    order = np.argsort(p_values, kind="stable")
    adjusted: Float64 = np.zeros(len(order))
    least = 0.0
    for rank, place in enumerate(map(int, order)):
        least = max(least, min(1.0, min(len(order) - rank, most) * p_values[place]))
        adjusted[place] = least
    return adjusted.tolist()
