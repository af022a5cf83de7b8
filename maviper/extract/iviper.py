"""VIPER (Bastani et al. 2018) for one agent among experts, and IVIPER (paper): VIPER for every agent on its own.

Does: DAgger with resampling by Q for agent i, all others at their experts.
Assumes: a centralized critic (the others' expert actions stand in the weight) or value networks.
Does not: let agents know of each other's trees; choose among iterates (selection.py).
"""

from collections.abc import Sequence

import numpy as np

from codegen.errors import InputError, UnknownNameError
from codegen.ir import Float32, Float64, GrownTree
from maviper.evaluate.play import Controller
from maviper.experts.expert import Expert
from maviper.extract import released
from maviper.extract.dataset import Dataset, Met, collect, resample
from maviper.extract.examples import NO_EXAMPLES, Examples
from maviper.extract.growing import Growth
from maviper.extract.journal import Journal
from maviper.extract.outcome import agent_policies, among
from maviper.extract.selection import KINDS, OnProgress, Selection
from maviper.extract.settings import RELEASED, Settings
from maviper.extract.weights import iviper_weights
from maviper.jobs import side_by_side
from maviper.worlds import World
from maviper.worlds.world import Int


def agent_of(world: World, settings: Settings) -> int:
    """The one agent that VIPER is asked for."""
    if not settings.agent:
        raise InputError("VIPER extracts one agent", "--agent", f"name one of {', '.join(world.agents)}")
    if settings.agent not in world.agents:
        raise UnknownNameError("agent", settings.agent, world.agents, "--agent")
    return world.agents.index(settings.agent)


def viper(
    world: World,
    expert: Expert,
    settings: Settings,
    agent: int,
    selection: Selection,
    journal: Journal,
    examples: Examples = NO_EXAMPLES,
) -> int:
    """Algorithm VIPER for agent i: offers every iterate; returns how many points there were in the end, beside the
    examples of the agent's team.
    """
    growth = Growth(world, settings)
    experts: list[Controller] = [expert] * len(world.agents)
    policies: Sequence[Controller] = experts
    data: Dataset | None = None
    mine = examples.of_team(world.team_of(world.agents[agent]))
    for iteration in range(settings.iterations):
        step = f"{iteration:04d}"
        met = journal.met(f"{step}-rollouts", rollouts, world, expert, policies, settings, agent, iteration)
        selection.met(met.values, met.agreement)
        data = met.data if data is None else data + met.data
        known = mine.before(world, data, agent)
        tree = journal.trees(f"{step}-trees", grow, known, settings, growth, agent, iteration)
        policies = among(world, agent_policies(world, tree, [agent]), experts)
        if selection.offer(tree):
            break
    return len(data) if data else 0


def rollouts(
    world: World, expert: Expert, policies: Sequence[Controller], settings: Settings, agent: int, iteration: int
) -> Met:
    """Episodes of tree i among experts, labelled by them, with the agent's weights."""

    def weigh(observations: tuple[Float32, ...], state: object, wanted: Int) -> Float64:
        return iviper_weights(world, expert, observations, state, wanted, agent)[:, None]

    return collect(world, expert, policies, [agent], settings.rollout_episodes(iteration), weigh)


def grow(data: Dataset, settings: Settings, growth: Growth, agent: int, iteration: int) -> list[GrownTree]:
    """The agent's tree from its resampled data."""
    rng = np.random.default_rng([settings.seed, agent, iteration])
    counts = [resample(data.weights[:, 0], settings.max_samples, rng)] * len(data.observations)
    seeds = [int(rng.integers(2**31))] * len(data.observations)
    return growth.team([agent], data.observations, data.labels, counts, seeds, 0)


def best_trees(
    world: World,
    expert: Expert,
    settings: Settings,
    agent: int,
    journal: Journal,
    examples: Examples,
    on_progress: OnProgress,
) -> tuple[list[GrownTree], dict[str, int]]:
    """VIPER for one agent: its best trees, the chosen one first, and what the provenance says of them."""
    part = journal.part(world.agents[agent])
    selection = KINDS[settings.selection](world, expert, settings, part, on_progress, [agent])
    run = released.viper if settings.preset == RELEASED else viper
    found = run(world, expert, settings, agent, selection, part, examples)
    return selection.chosen()[0], {**selection.facts, "points": found}


def iviper(
    world: World,
    expert: Expert,
    settings: Settings,
    journal: Journal,
    examples: Examples,
    on_progress: OnProgress,
    jobs: int,
) -> tuple[list[list[GrownTree]], dict[str, int]]:
    """VIPER for every agent. `jobs`: agents at the same time; the result is the same."""
    tasks = [(world, expert, settings, agent, journal, examples) for agent in range(len(world.agents))]
    if jobs == 1:
        found = [best_trees(*task, on_progress) for task in tasks]
    else:
        found = list(side_by_side(_quietly, tasks, jobs))
    stopped = max(facts["stopped_after"] for _, facts in found)
    return [trees for trees, _ in found], {"stopped_after": stopped}


def _quietly(
    world: World, expert: Expert, settings: Settings, agent: int, journal: Journal, examples: Examples
) -> tuple[list[GrownTree], dict[str, int]]:
    return best_trees(world, expert, settings, agent, journal, examples, lambda progress: None)
