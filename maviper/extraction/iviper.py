"""VIPER (Bastani et al. 2018) for one agent among experts, and IVIPER (paper): VIPER for every agent on its own.

Does: DAgger with resampling by Q for agent i, all others at their experts.
Assumes: a centralized critic (the others' expert actions stand in the weight) or value networks.
Does not: let agents know of each other's trees; choose among iterates (extraction/selection/race.py).
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from codegen.errors import InputError, UnknownNameError
from codegen.ir import Float32, Float64, GrownTree
from maviper.episodes.play import Controller
from maviper.episodes.trees import agent_policies, among
from maviper.experts.expert import Expert
from maviper.extraction.dataset import Dataset, Met, collect, resample
from maviper.extraction.extraction import Extraction, Running, unseen
from maviper.extraction.growth.growing import Growth
from maviper.extraction.growth.weights import iviper_weights
from maviper.extraction.released import released
from maviper.extraction.selection.race import KINDS, OnProgress, Selection
from maviper.extraction.settings import RELEASED, Settings
from maviper.files.jobs import side_by_side
from maviper.worlds import World
from maviper.worlds.world import Int


def agent_of(world: World, settings: Settings) -> int:
    """The one agent that VIPER is asked for."""
    if not settings.agent:
        raise InputError("VIPER extracts one agent", "--agent", f"name one of {', '.join(world.agents)}")
    if settings.agent not in world.agents:
        raise UnknownNameError("agent", settings.agent, world.agents, "--agent")
    return world.agents.index(settings.agent)


def viper(asked: Extraction, agent: int, selection: Selection) -> int:
    """Algorithm VIPER for agent i: offers every iterate; returns how many points there were in the end, beside the
    examples of the agent's team.
    """
    world, expert, settings = asked.world, asked.expert, asked.settings
    journal, examples = asked.journal, asked.examples
    growth = Growth(world, settings)
    experts: list[Controller] = [expert] * len(world.agents)
    policies: Sequence[Controller] = experts
    data: Dataset | None = None
    mine = examples.of_team(world.team_of(world.agents[agent]))
    for iteration in range(settings.iterations):
        step = f"{iteration:04d}"
        met = journal.met(f"{step}-rollouts", rollouts, world, expert, policies, settings, agent, iteration)
        selection.met(met.values, met.fidelity)
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
    drawn = resample(data.weights[:, 0], data.alive[:, agent], settings.max_samples, rng)
    counts = [drawn] * len(data.observations)
    seeds = [int(rng.integers(2**31))] * len(data.observations)
    return growth.team([agent], data, counts, seeds, 0)


def best_trees(asked: Extraction, agent: int, on_progress: OnProgress) -> tuple[list[GrownTree], dict[str, int]]:
    """VIPER for one agent: its best trees, the chosen one first, and what the provenance says of them."""
    world, settings = asked.world, asked.settings
    part = asked.journal.part(world.agents[agent])
    selection = KINDS[settings.selection](world, asked.expert, settings, part, on_progress, [agent])
    run = released.viper if settings.preset == RELEASED else viper
    found = run(replace(asked, journal=part), agent, selection)
    return selection.chosen()[0], {**selection.facts, "points": found}


def iviper(asked: Extraction, running: Running) -> tuple[list[list[GrownTree]], dict[str, int]]:
    """VIPER for every agent."""
    tasks = [(asked, agent) for agent in range(len(asked.world.agents))]
    if running.jobs == 1:
        found = [best_trees(*task, running.on_progress) for task in tasks]
    else:
        found = list(side_by_side(_quietly, tasks, running.jobs))
    stopped = max(facts["stopped_after"] for _, facts in found)
    return [trees for trees, _ in found], {"stopped_after": stopped}


def _quietly(asked: Extraction, agent: int) -> tuple[list[GrownTree], dict[str, int]]:
    return best_trees(asked, agent, unseen)
