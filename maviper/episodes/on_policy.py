"""On-policy episodes: what a profile's own trees meet.

Does: plays the profile, or the same episodes driven by another controller.
Assumes: the profile's world is one of ours.
Does not: measure.
"""

from collections.abc import Iterator, Sequence

from codegen import ir
from maviper.episodes import measures
from maviper.episodes.play import Controller, Episodes, play, tree_policies
from maviper.worlds import World

ON_POLICY_EPISODES = 4_000  # of 25 steps: 100,000 observations per agent
AT_ONCE = 1 << 24  # numbers that agents observe in a part of the episodes


def all_seeds() -> range:
    """The seeds of all on-policy episodes."""
    return range(measures.ON_POLICY_SEEDS, measures.ON_POLICY_SEEDS + ON_POLICY_EPISODES)


def in_parts(profile: ir.PolicyProfile) -> Iterator[range]:
    """The seeds of on-policy episodes in parts of bounded memory: one part, unless agents observe much."""
    numbers = profile.world.episode_steps * sum(len(policy.features) for policy in profile.agents)
    count, seeds = max(1, AT_ONCE // max(1, numbers)), all_seeds()
    return (seeds[low : low + count] for low in range(0, len(seeds), count))


def on_policy(
    profile: ir.PolicyProfile,
    world: World,
    driver: Controller | None = None,
    keep: bool = True,
    seeds: Sequence[int] | None = None,
) -> Episodes:
    """Episodes of the profile's own trees, or the same episodes driven by `driver`. `keep`: as in `play`; `seeds`: of
    which episodes, None for all.
    """
    controller = tree_policies(profile.agents) if driver is None else driver
    start = world.start_from_seeds(all_seeds() if seeds is None else seeds)
    return play(world, [controller] * len(profile.agents), start, keep)
