"""What episodes are worth: each team's measures, with intervals; and how like an expert's actions others are.

Does: estimates the world's measures over episodes, and of each team against given opponents; the share of an action
  that is the expert's, for actions and for numbers.
Assumes: evaluation seeds are episode seeds of the reference environment, so that every number can be replayed there;
  outputs with both bounds, as worlds have them.
Does not: run experiments over training seeds, or ask an expert.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, TypeVar

import numpy as np

from codegen.intervals import Z95, Share
from codegen.ir import Float64, OutputSpec
from maviper.episodes.play import Controller, Episodes, rollout
from maviper.worlds import Measure, World
from maviper.worlds.world import RETURN, bounds


def likeness(outputs: Sequence[OutputSpec], acted: Any, wanted: Any) -> Float64:
    """From 0 to 1, how like an agent's actions are to those that were `wanted`: whether they are the same.

    Of numbers, [..., n_outputs] and any zeros behind them: 1 less their mean distance in parts of their ranges.
    """
    if not outputs:
        return np.equal(acted, wanted).astype(np.float64)
    low, high = bounds(outputs)
    off = np.abs(np.asarray(acted, np.float64) - np.asarray(wanted, np.float64))[..., : len(outputs)]
    return 1 - (off / np.where(high > low, high - low, 1.0)).mean(axis=-1)


# Episode seeds. Those below a billion have fixed lengths; extraction seeds shift the others by 100,000
# each, up to 2**32 of them, so those lie far apart. No purpose meets another's episodes.
CHECKPOINT_SEEDS = 1_000_000
FINALIST_SEEDS = 2_000_000
MEASUREMENT_SEEDS = 3_000_000
ON_POLICY_SEEDS = 4_000_000
RESPONSE_SEEDS = 5_000_000
ROLLOUT_SEEDS = 1_000_000_000_000_000
SELECTION_SEEDS = 2_000_000_000_000_000
REFINEMENT_SEEDS = 3_000_000_000_000_000


NORMAL = 100  # episodes from which on the normal approximation is within 1.3 % of Student's t
CUT = "cut"  # the name of what counts the episodes that were stopped at a length that nobody stated


@dataclass(frozen=True)
class Mean:
    """The mean of a number over `count` episodes."""

    value: float
    half_width: float  # of its 95 % interval
    count: int

    @property
    def interval(self) -> tuple[float, float]:
        """The 95 % interval."""
        return self.value - self.half_width, self.value + self.half_width


Estimate = Share | Mean
Number = TypeVar("Number", float, Float64)


def estimate(measure: Measure, values: Float64) -> Estimate:
    """A measure over episodes, `values` [batch]."""
    if measure.share:
        return Share(int(values.sum()), len(values))
    deviation = float(values.std(ddof=1)) if len(values) > 1 else math.inf
    return Mean(float(values.mean()), _quantile(len(values)) * deviation / math.sqrt(len(values)), len(values))


@lru_cache
def _quantile(count: int) -> float:
    """Half the width of the 95 % interval of a mean, in standard errors: by Student's t (1908) of a few episodes."""
    from scipy.special import stdtrit  # pyright: ignore[reportMissingTypeStubs]

    return Z95 if not 1 < count < NORMAL else float(stdtrit(count - 1, 0.975))


def format_estimate(estimate: Estimate) -> str:
    """An estimate with its interval, for people: `0.910 [0.891, 0.926]`."""
    low, high = estimate.interval
    return f"{estimate.value:.3f} [{low:.3f}, {high:.3f}]"


def ratio(measure: Measure, ours: float, theirs: float) -> float | None:
    """The performance ratio `quotient`; None where that divides by zero."""
    return quotient(measure, ours, theirs) if (ours if measure.lower_is_better else theirs) else None


def quotient(measure: Measure, ours: Number, theirs: Number, size: Number | None = None) -> Number:
    """Ours over theirs, the inverse where lower is better. `size`: what to divide by instead of |theirs|.

    A negative return is no divisor: 1 + (ours - theirs) / |theirs| is the same where theirs is positive.
    """
    if measure.lower_is_better:
        return theirs / ours
    return 1 + (ours - theirs) / (abs(theirs) if size is None else size)


def score(measure: Measure, values: Float64) -> Float64:
    """A measure's values with the sign that makes higher better."""
    return -values if measure.lower_is_better else values


def values(
    world: World, controllers: Sequence[Controller], seeds: Sequence[int], over: Callable[[], bool] = lambda: False
) -> dict[Measure, Float64]:
    """Every measure of the world in each of the episodes `seeds`, and each team's return (its agents' mean). `over`: as
    in `rollout`.
    """
    tables = [table(world, episodes) for episodes in rollout(world, controllers, seeds, keep=False, over=over)]
    return {measure: np.concatenate([rows[measure] for rows in tables]) for measure in tables[0]}


def table(world: World, episodes: Episodes) -> dict[Measure, Float64]:
    """Every measure of each episode, and each team's return (its agents' mean), [batch]; where nobody states how long
    episodes are, also which of them were stopped.
    """
    rows: dict[Measure, Float64] = dict(zip(world.measures, episodes.values, strict=True))
    rows |= {Measure(team, RETURN): episodes.returns[world.members(team)].mean(axis=0) for team in world.teams}
    return rows | (
        {} if world.length_stated else {Measure(team, CUT): episodes.cut.astype(np.float64) for team in world.teams}
    )


def list_measures(world: World) -> tuple[Measure, ...]:
    """The world's measures and each team's return, in the order in which they are to be read."""
    returns = {team: Measure(team, RETURN) for team in world.teams}
    first = [returns[team] for team in world.return_first]
    return tuple(dict.fromkeys((*first, *world.measures, *returns.values())))  # a user's world measures returns itself


def team_values(
    world: World,
    ours: Sequence[Controller],
    opponents: Sequence[Controller],
    seeds: Sequence[int],
    teams: Iterable[str] | None = None,
) -> dict[Measure, Float64]:
    """Measures and returns of teams (None: of all) in each episode, each team played by `ours` against all others
    played by `opponents`.
    """
    by_measure: dict[Measure, Float64] = {}
    for team in world.teams if teams is None else teams:
        members = world.members(team)
        mixed = [ours[agent] if agent in members else opponents[agent] for agent in range(len(ours))]
        by_measure |= {measure: row for measure, row in values(world, mixed, seeds).items() if measure.team == team}
    return by_measure


def evaluate(world: World, controllers: Sequence[Controller], seeds: Sequence[int]) -> dict[Measure, Estimate]:
    """The estimates of `values`."""
    return estimates(values(world, controllers, seeds))


def evaluate_teams(
    world: World, ours: Sequence[Controller], opponents: Sequence[Controller], seeds: Sequence[int]
) -> dict[Measure, Estimate]:
    """The estimates of `team_values`, of the world's measures and of what was stopped."""
    by_measure = team_values(world, ours, opponents, seeds)
    asked = [*world.measures, *(measure for measure in by_measure if measure.name == CUT)]
    return estimates({measure: by_measure[measure] for measure in asked})


def estimates(values: Mapping[Measure, Float64]) -> dict[Measure, Estimate]:
    """An estimate of each measure."""
    return {measure: estimate(measure, row) for measure, row in values.items()}
