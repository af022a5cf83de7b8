"""MAVIPER: joint extraction of the trees of all teams (paper, Algorithm MAVIPER, mixed cooperative-competitive form).

Does: the algorithm, line by line, with both of the paper's ablations.
Assumes: an expert with a critic, or one of value networks.
Does not: choose among iterates (extraction/selection/race.py), write files or print.
"""

from collections.abc import Sequence
from functools import partial

import numpy as np

from codegen.ir import Float32, Float64, GrownTree
from maviper.episodes.play import Controller, tree_policies
from maviper.episodes.trees import agent_policies
from maviper.experts.expert import Expert
from maviper.extraction.dataset import Dataset, Met, collect, resample
from maviper.extraction.examples import NO_EXAMPLES, Examples
from maviper.extraction.growth.growing import Growth
from maviper.extraction.growth.weights import iviper_weights, maviper_weights
from maviper.extraction.journal import Journal
from maviper.extraction.selection.race import Selection
from maviper.extraction.settings import IVIPER_RESAMPLING, NO_PREDICTION, Settings
from maviper.worlds import World
from maviper.worlds.world import Int


def maviper(
    world: World,
    expert: Expert,
    settings: Settings,
    selection: Selection,
    journal: Journal,
    examples: Examples = NO_EXAMPLES,
) -> int:
    """Offers every iterate to `selection`; returns how many points there were in the end, beside the
    examples.
    """
    growth = Growth(world, settings)
    data: Dataset | None = None
    policies: Controller = expert  # line 1: no data yet, the experts play first
    for iteration in range(settings.iterations):
        step = f"{iteration:04d}"
        met = journal.met(f"{step}-rollouts", rollouts, world, expert, policies, settings, iteration)  # line 3
        selection.met(met.values, met.fidelity)
        data = met.data if data is None else data + met.data  # line 4
        known = examples.before(world, data)
        grown = journal.trees(f"{step}-trees", grow_teams, world, known, settings, growth, iteration)  # lines 5 and 6
        policies = tree_policies(agent_policies(world, grown))
        if selection.offer(grown):
            break
    return len(data) if data else 0


def rollouts(world: World, expert: Expert, policies: Controller, settings: Settings, iteration: int) -> Met:
    """Episodes of `policies` for all agents, labelled by the expert, with each agent's weights."""
    everybody = range(len(world.agents))
    seeds = settings.rollout_episodes(iteration)
    return collect(
        world, expert, [policies] * len(everybody), everybody, seeds, partial(weights, world, expert, settings)
    )


def weights(
    world: World, expert: Expert, settings: Settings, observations: tuple[Float32, ...], state: object, wanted: Int
) -> Float64:
    """Each agent's weights, [n, n_agents]."""
    if settings.algorithm != IVIPER_RESAMPLING:
        return maviper_weights(world, expert, observations, state, wanted)
    agents = range(len(world.agents))
    return np.stack([iviper_weights(world, expert, observations, state, wanted, agent) for agent in agents], axis=1)


def grow_teams(world: World, data: Dataset, settings: Settings, growth: Growth, iteration: int) -> Sequence[GrownTree]:
    """Resampling and TrainJointTrees for each team; the trees in the world's order of agents."""
    rng = np.random.default_rng([settings.seed, iteration])
    columns = zip(data.weights.T, data.alive.T, strict=True)
    counts = [resample(column, alive, settings.max_samples, rng) for column, alive in columns]
    seeds = rng.integers(2**31, size=len(world.agents))
    trees: dict[int, GrownTree] = {}
    for team in world.teams:
        members = world.members(team)
        # the ablation without prediction keeps every point, as a team that needs no right prediction does
        least_right = 0 if settings.algorithm == NO_PREDICTION else len(members) - 1
        grown = growth.team(members, data, counts, seeds, least_right)
        trees |= dict(zip(members, grown, strict=True))
    return [trees[agent] for agent in range(len(world.agents))]
