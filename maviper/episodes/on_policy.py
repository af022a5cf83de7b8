"""On-policy episodes: what a profile's own trees meet.

Does: plays the profile, or the same episodes driven by another controller.
Assumes: the profile's world is one of ours.
Does not: measure.
"""

from codegen import ir
from maviper.episodes import measures
from maviper.episodes.play import Controller, Episodes, play, tree_policies
from maviper.worlds import World

ON_POLICY_EPISODES = 4_000  # of 25 steps: 100,000 observations per agent


def on_policy(profile: ir.PolicyProfile, world: World, driver: Controller | None = None, keep: bool = True) -> Episodes:
    """Episodes of the profile's own trees, or the same episodes driven by `driver`. `keep`: as in `play`."""
    seeds = range(measures.ON_POLICY_SEEDS, measures.ON_POLICY_SEEDS + ON_POLICY_EPISODES)
    controller = tree_policies(profile.agents) if driver is None else driver
    return play(world, [controller] * len(profile.agents), world.start_from_seeds(seeds), keep)
