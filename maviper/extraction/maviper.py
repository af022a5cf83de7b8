"""MAVIPER: joint extraction of the trees of all teams (paper, Algorithm MAVIPER, mixed cooperative-competitive form).

Does: the algorithm, line by line, with both of the paper's ablations.
Assumes: an expert with a critic, or one of value networks.
Does not: choose among iterates (extraction/selection/race.py), write files or print.
"""

from collections.abc import Sequence
from functools import partial

import numpy as np

from codegen import ir
from codegen.ir import Float32, Float64, GrownTree
from maviper.episodes.play import Controller, tree_policies
from maviper.episodes.trees import agent_policies
from maviper.experts.expert import Expert
from maviper.extraction.dataset import Dataset, Met, collect, resample
from maviper.extraction.examples import NO_EXAMPLES, Examples
from maviper.extraction.growth.growing import Growth
from maviper.extraction.growth.weights import iviper_weights, maviper_weights
from maviper.extraction.journal import Arrays, Journal, packed, unpacked
from maviper.extraction.selection.race import Selection
from maviper.extraction.settings import IVIPER_RESAMPLING, NO_PREDICTION, Settings
from maviper.worlds import World
from maviper.worlds.world import Int

FIGURES = "figures"


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
        arrays = journal.arrays(f"{step}-trees", _grown, world, known, settings, growth, iteration)  # lines 5 and 6
        grown = unpacked({name: array for name, array in arrays.items() if name != FIGURES})
        selection.grown(dict(zip(figure_names(world), map(float, arrays[FIGURES]), strict=True)))
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


def _grown(world: World, data: Dataset, settings: Settings, growth: Growth, iteration: int) -> Arrays:
    trees, kept = grow_teams(world, data, settings, growth, iteration)
    figures = [figure for team in world.teams for figure in (kept[team], *accuracies(world, data, trees, team))]
    return packed(trees) | {FIGURES: np.array(figures)}


def figure_names(world: World) -> list[str]:
    """What `metrics.jsonl` calls the figures of a round's growth: of each team, how much of its data the votes kept, in
    what share of the points in which all its members act all of them do right, and what that share would be if their
    errors had nothing to do with each other.
    """
    names = ("kept", "joint accuracy", "product of accuracies")
    return [f"{name} {team}" for team in world.teams for name in names]


def accuracies(world: World, data: Dataset, trees: Sequence[GrownTree], team: str) -> tuple[float, float]:
    """The share of a data set's points in which all members act as the expert, and the product of each one's share."""
    members = world.members(team)
    together = data.alive[:, members].all(axis=1)
    right = [
        trees[agent].action[ir.apply(trees[agent], data.observations[agent][together])] == data.labels[together, agent]
        for agent in members
    ]
    if not together.any():
        return 1.0, 1.0
    return float(np.all(right, axis=0).mean()), float(np.prod([each.mean() for each in right]))


def grow_teams(
    world: World, data: Dataset, settings: Settings, growth: Growth, iteration: int
) -> tuple[list[GrownTree], dict[str, float]]:
    """Resampling and TrainJointTrees for each team: the trees in the world's order of agents, and the share of its data
    that each team's votes kept.
    """
    rng = np.random.default_rng([settings.seed, iteration])
    columns = zip(data.weights.T, data.alive.T, strict=True)
    counts = [resample(column, alive, settings.max_samples, rng) for column, alive in columns]
    seeds = rng.integers(2**31, size=len(world.agents))
    trees: dict[int, GrownTree] = {}
    shares: dict[str, float] = {}
    for team in world.teams:
        members, kept = world.members(team), []
        # the ablation without prediction keeps every point, as a team that needs no right prediction does
        least_right = 0 if settings.algorithm == NO_PREDICTION else settings.votes_of(len(members))
        grown = growth.team(members, data, counts, seeds, least_right, kept)
        trees |= dict(zip(members, grown, strict=True))
        shares[team] = float(np.mean(kept))
    return [trees[agent] for agent in range(len(world.agents))], shares
