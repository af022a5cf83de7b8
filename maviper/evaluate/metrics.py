"""What episodes are worth: each team's primary measure, with intervals.

Does: success shares at the world's radii, returns, and the joint measure of a profile against expert opponents.
Assumes: evaluation seeds are episode seeds of the reference environment, so that every number can be replayed there.
Does not: run experiments over training seeds.
"""

from collections.abc import Sequence
from functools import partial

from codegen import ir
from maviper.evaluate.play import Policy, play
from maviper.worlds import ParticleWorld
from verify.shares import Share

# Episode seeds. The first three have fixed lengths; extraction seeds shift the rollouts and the selection by 100,000
# each, up to 2**32 of them, so those lie far apart. No purpose meets another's episodes.
CHECKPOINT_SEEDS = 1_000_000
FINALIST_SEEDS = 2_000_000
MEASUREMENT_SEEDS = 3_000_000
ON_POLICY_SEEDS = 4_000_000
ROLLOUT_SEEDS = 1_000_000_000_000_000
SELECTION_SEEDS = 2_000_000_000_000_000


def shown(won: Share) -> str:
    """A share with its interval, for people: `0.910 [0.891, 0.926]`."""
    low, high = won.interval
    return f"{won.value:.3f} [{low:.3f}, {high:.3f}]"


def tree_policy(policy: ir.AgentPolicy) -> Policy:
    """The reference semantics of a tree policy, as a function from observations to actions."""
    return partial(ir.act, policy)


def success(world: ParticleWorld, policies: Sequence[Policy], seeds: Sequence[int]) -> list[dict[str, Share]]:
    """Each team's success share over the episodes `seeds`, one dictionary for each of the world's radii."""
    episodes = play(world, policies, world.start_from_seeds(seeds))
    return [
        {
            team: Share(int(won.sum()), len(won))
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
