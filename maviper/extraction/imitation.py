"""Imitation DT, the paper's simplest baseline: trees fitted to what the experts do in their own episodes.

Does: collects expert episodes, refits every agent's tree on all of them.
Assumes: nothing of the expert but its actions.
Does not: visit the states that the trees lead to, weigh points, or choose among refits (extraction/selection/race.py).
"""

import numpy as np

from codegen.ir import Float32, Float64, GrownTree
from maviper.experts.expert import Expert
from maviper.extraction.dataset import Dataset, Met, collect
from maviper.extraction.examples import NO_EXAMPLES, Examples, counts_of
from maviper.extraction.growth.growing import Growth
from maviper.extraction.journal import Journal
from maviper.extraction.selection.race import Selection
from maviper.extraction.settings import Settings
from maviper.worlds import World
from maviper.worlds.world import Int


def imitation(
    world: World,
    expert: Expert,
    settings: Settings,
    selection: Selection,
    journal: Journal,
    examples: Examples = NO_EXAMPLES,
) -> int:
    """Offers every refit, each on `rollouts` more expert episodes; returns how many points there were in the end,
    beside the examples.
    """
    growth = Growth(world, settings)
    data: Dataset | None = None
    for iteration in range(settings.iterations):
        step = f"{iteration:04d}"
        met = journal.met(f"{step}-rollouts", rollouts, world, expert, settings, iteration)
        data = met.data if data is None else data + met.data
        grown = journal.trees(f"{step}-trees", refit, examples.before(world, data), settings, growth, iteration)
        if selection.offer(grown):
            break
    return len(data) if data else 0


def rollouts(world: World, expert: Expert, settings: Settings, iteration: int) -> Met:
    """Expert episodes; every point weighs the same."""
    everybody = range(len(world.agents))
    seeds = settings.rollout_episodes(iteration)
    return collect(world, expert, [expert] * len(everybody), everybody, seeds, _alike)


def _alike(observations: tuple[Float32, ...], state: object, wanted: Int) -> Float64:
    del observations, state
    return np.ones(wanted.shape)


def refit(data: Dataset, settings: Settings, growth: Growth, iteration: int) -> list[GrownTree]:
    """Every agent's tree on all points."""
    everybody = range(len(data.observations))
    counts = [counts_of(column) for column in data.weights.T]
    seeds = np.random.default_rng([settings.seed, iteration]).integers(2**31, size=len(everybody))
    return [growth.team([agent], data, counts, seeds, 0)[0] for agent in everybody]
