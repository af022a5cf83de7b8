"""Imitation DT, the paper's simplest baseline: trees fitted to what the experts do in their own episodes.

Does: collects expert episodes, refits every agent's tree on all of them, keeps the best refit.
Assumes: nothing of the expert but its actions.
Does not: visit the states that the trees lead to, or weigh points.
"""

import numpy as np

from codegen import ir
from maviper.evaluate import metrics
from maviper.evaluate.play import rollout
from maviper.experts.expert import Expert
from maviper.extract.dataset import Dataset, labels, points
from maviper.extract.growing import Growth
from maviper.extract.outcome import OnIteration, Selection
from maviper.extract.settings import EPISODES_PER_SEED, Settings
from maviper.worlds import World


def imitation(world: World, expert: Expert, settings: Settings, on_iteration: OnIteration) -> ir.PolicyProfile:
    """The profile of the best refit: `iterations` times `rollouts` more expert episodes, all points alike."""
    rng = np.random.default_rng(settings.seed)
    selection = Selection(world, expert, settings, on_iteration)
    growth = Growth(world, settings)
    everybody = range(len(world.agents))
    data: Dataset | None = None
    for iteration in range(settings.iterations):
        first = metrics.ROLLOUT_SEEDS + settings.seed * EPISODES_PER_SEED + iteration * settings.rollouts
        for episodes in rollout(world, [expert] * len(world.agents), range(first, first + settings.rollouts)):
            observations, state = points(episodes)
            wanted = labels(expert, observations, state)
            met = Dataset(observations, wanted, np.ones(wanted.shape))
            data = met if data is None else data + met
        assert data is not None
        counts = [np.ones(len(data), dtype=np.int64)] * len(world.agents)
        seeds = rng.integers(2**31, size=len(world.agents))
        grown = [growth.team([agent], data.observations, data.labels, counts, seeds, 0)[0] for agent in everybody]
        if selection.offer(grown):
            break
    assert data is not None
    return selection.profile(expert, {"points": len(data)})
