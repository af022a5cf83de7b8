"""VIPER (Bastani et al. 2018) for one agent among experts, and IVIPER (paper): VIPER for every agent on its own.

Does: DAgger with resampling by Q for agent i, all others at their experts; the best tree of each agent.
Assumes: a centralized critic (the others' expert actions stand in the weight) or value networks.
Does not: let agents know of each other's trees.
"""

from collections.abc import Sequence

import numpy as np

from codegen import ir
from codegen.errors import InputError, UnknownNameError
from codegen.ir import GrownTree
from maviper.evaluate import metrics
from maviper.evaluate.play import Controller, rollout
from maviper.experts.expert import Expert
from maviper.extract.dataset import Dataset, labels, points, resample
from maviper.extract.growing import Growth
from maviper.extract.outcome import OnIteration, Selection, agent_policies, among, profile_of
from maviper.extract.settings import EPISODES_PER_SEED, Settings
from maviper.extract.weights import iviper_weights
from maviper.jobs import side_by_side
from maviper.worlds import World


def viper(world: World, expert: Expert, settings: Settings, on_iteration: OnIteration) -> ir.PolicyProfile:
    """A profile with the tree of one agent, `settings.agent`."""
    if not settings.agent:
        raise InputError("VIPER extracts one agent", "--agent", f"name one of {', '.join(world.agents)}")
    if settings.agent not in world.agents:
        raise UnknownNameError("agent", settings.agent, world.agents, "--agent")
    selection = best_tree(world, expert, settings, world.agents.index(settings.agent), on_iteration)
    return selection.profile(expert, {})


def iviper(world: World, expert: Expert, settings: Settings, on_iteration: OnIteration, jobs: int) -> ir.PolicyProfile:
    """A profile of all agents, each with its own best tree. `jobs`: agents at the same time; the result is the same."""
    agents = range(len(world.agents))
    if jobs == 1:
        chosen = [best_tree(world, expert, settings, agent, on_iteration) for agent in agents]
        found = [(selection.trees, selection.seen) for selection in chosen]
    else:
        found = list(side_by_side(_quietly, [(world, expert, settings, agent) for agent in agents], jobs))
    grown = [trees[0] for trees, _ in found if trees]
    facts = {"stopped_after": max(seen for _, seen in found)}
    return profile_of(world, expert, settings, agent_policies(world, grown), facts)


def _quietly(world: World, expert: Expert, settings: Settings, agent: int) -> tuple[list[GrownTree] | None, int]:
    selection = best_tree(world, expert, settings, agent, lambda progress: None)
    return selection.trees, selection.seen


def best_tree(world: World, expert: Expert, settings: Settings, agent: int, on_iteration: OnIteration) -> Selection:
    """Algorithm VIPER for agent i, its candidates scored by what its team reaches with tree i among experts."""
    rng = np.random.default_rng([settings.seed, agent])
    selection = Selection(world, expert, settings, on_iteration, [agent])
    growth = Growth(world, settings)
    experts: list[Controller] = [expert] * len(world.agents)
    data: Dataset | None = None
    policies: Sequence[Controller] = experts
    for iteration in range(settings.iterations):
        first = metrics.ROLLOUT_SEEDS + settings.seed * EPISODES_PER_SEED + iteration * settings.rollouts
        for episodes in rollout(world, policies, range(first, first + settings.rollouts)):
            observations, state = points(episodes)
            wanted = labels(expert, observations, state)
            weights = iviper_weights(world, expert, observations, state, wanted, agent)
            met = Dataset(observations, wanted, weights[:, None])
            data = met if data is None else data + met
        assert data is not None
        counts = [resample(data.weights[:, 0], settings.max_samples, rng)] * len(world.agents)
        seeds = [int(rng.integers(2**31))] * len(world.agents)
        tree = growth.team([agent], data.observations, data.labels, counts, seeds, 0)
        policies = among(world, agent_policies(world, tree, [agent]), experts)
        if selection.offer(tree):
            break
    return selection
