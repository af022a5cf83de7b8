"""What episodes are worth: each team's primary measure, with intervals.

Does: success shares at the world's radii, returns, and the joint measure of a profile against expert opponents.
Assumes: evaluation seeds are episode seeds of the reference environment, so that every number can be replayed there.
Does not: run experiments over training seeds.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from codegen import ir
from maviper.evaluate.play import Policy, play
from maviper.worlds import ParticleWorld

# Episode seeds, far apart so that no purpose meets another's episodes.
CHECKPOINT_SEEDS = 1_000_000
FINALIST_SEEDS = 2_000_000
MEASUREMENT_SEEDS = 3_000_000
ROLLOUT_SEEDS = 4_000_000
SELECTION_SEEDS = 5_000_000
ON_POLICY_SEEDS = 6_000_000


@dataclass(frozen=True)
class Share:
    """A measured share with its 95 % interval (Wilson)."""

    value: float
    low: float
    high: float
    count: int

    def __str__(self) -> str:
        return f"{self.value:.3f} [{self.low:.3f}, {self.high:.3f}]"


def share(successes: int, count: int) -> Share:
    """The share of `successes` in `count` trials, with its Wilson interval."""
    from scipy.stats import binomtest

    interval = binomtest(successes, count).proportion_ci(0.95, method="wilson")
    return Share(successes / count, float(interval.low), float(interval.high), count)


def tree_policy(policy: ir.AgentPolicy) -> Policy:
    """The reference semantics of a tree policy, as a function from observations to actions."""
    return partial(ir.act, policy)


def success(world: ParticleWorld, policies: Sequence[Policy], seeds: Sequence[int]) -> list[dict[str, Share]]:
    """Each team's success share over the episodes `seeds`, one dictionary for each of the world's radii."""
    episodes = play(world, policies, world.start_from_seeds(seeds))
    return [
        {
            team: share(int(won.sum()), len(won))
            for team, won in world.success(episodes.position, episodes.goal, radius).items()
        }
        for radius in world.squared_radii
    ]


def team_success(
    world: ParticleWorld, ours: Sequence[Policy], opponents: Sequence[Policy], seeds: Sequence[int]
) -> list[dict[str, Share]]:
    """As `success`, with each team played by `ours` against all other teams played by `opponents`."""
    tables: list[dict[str, Share]] = [{} for _ in world.squared_radii]
    for team in world.teams:
        members = world.members(team)
        mixed = [ours[agent] if agent in members else opponents[agent] for agent in range(len(ours))]
        for table, row in zip(tables, success(world, mixed, seeds), strict=True):
            table[team] = row[team]
    return tables
