"""MAVIPER: joint extraction of the trees of all teams (paper, Algorithm MAVIPER, mixed cooperative-competitive form).

Does: the algorithm, line by line, with both of the paper's ablations; returns the best iterate as a profile.
Assumes: an expert with a critic, or one of value networks.
Does not: write files or print; progress goes to a callback.
"""

from collections.abc import Sequence
from functools import reduce
from operator import add

import numpy as np

from codegen import ir
from codegen.ir import Float64, GrownTree
from maviper.evaluate import metrics
from maviper.evaluate.play import Controller, Episodes, rollout, tree_policies
from maviper.experts.expert import Expert
from maviper.extract.dataset import Dataset, labels, points, resample
from maviper.extract.growing import Growth
from maviper.extract.outcome import OnIteration, Selection, agent_policies
from maviper.extract.settings import EPISODES_PER_SEED, IVIPER_RESAMPLING, NO_PREDICTION, Settings
from maviper.extract.weights import iviper_weights, maviper_weights
from maviper.worlds import World


def extract(
    world: World, expert: Expert, settings: Settings, on_iteration: OnIteration = lambda progress: None
) -> ir.PolicyProfile:
    """The policy profile of the best iterate, with its measures and provenance."""
    settings.checked()
    rng = np.random.default_rng(settings.seed)
    selection = Selection(world, expert, settings, on_iteration)
    growth = Growth(world, settings)
    data: Dataset | None = None
    policies: Sequence[Controller] = [expert] * len(world.agents)  # line 1: no data yet, the experts play first
    for iteration in range(settings.iterations):
        first = metrics.ROLLOUT_SEEDS + settings.seed * EPISODES_PER_SEED + iteration * settings.rollouts
        met = rollouts(world, expert, policies, range(first, first + settings.rollouts), settings)  # line 3
        data = met if data is None else data + met  # line 4
        counts = [resample(weights, settings.max_samples, rng) for weights in data.weights.T]  # line 5
        grown = grow_teams(world, data, counts, settings, growth, rng)  # line 6
        policies = [tree_policies(agent_policies(world, grown))] * len(world.agents)
        if selection.offer(grown):
            break
    assert data is not None
    return selection.profile(expert, {"points": len(data)})


def rollouts(
    world: World, expert: Expert, policies: Sequence[Controller], seeds: Sequence[int], settings: Settings
) -> Dataset:
    """Episodes of `policies`, labelled by the expert, with each agent's weights."""
    played = rollout(world, policies, seeds)
    return reduce(add, [labelled(world, expert, episodes, settings) for episodes in played])


def labelled(world: World, expert: Expert, episodes: Episodes, settings: Settings) -> Dataset:
    """The points of some episodes, with the expert's actions and each agent's weights."""
    observations, state = points(episodes)
    wanted = labels(expert, observations, state)
    weights: Float64
    if settings.algorithm == IVIPER_RESAMPLING:
        columns = [
            iviper_weights(world, expert, observations, state, wanted, agent) for agent in range(len(world.agents))
        ]
        weights = np.stack(columns, axis=1)
    else:
        weights = maviper_weights(world, expert, observations, state, wanted)
    return Dataset(observations, wanted, weights)


def grow_teams(
    world: World,
    data: Dataset,
    counts: Sequence[np.ndarray],
    settings: Settings,
    growth: Growth,
    rng: np.random.Generator,
) -> list[GrownTree]:
    """TrainJointTrees for each team; returns the trees in the world's order of agents."""
    trees: list[GrownTree | None] = [None] * len(world.agents)
    seeds = rng.integers(2**31, size=len(world.agents))
    for team in world.teams:
        members = world.members(team)
        # the ablation without prediction keeps every point, as a team that needs no right prediction does
        least_right = 0 if settings.algorithm == NO_PREDICTION else len(members) - 1
        grown = growth.team(members, data.observations, data.labels, counts, seeds, least_right)
        for agent, tree in zip(members, grown, strict=True):
            trees[agent] = tree
    return [tree for tree in trees if tree is not None]
