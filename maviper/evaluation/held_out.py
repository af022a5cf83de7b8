"""Measures on held-out episodes, for a profile's provenance.

Does: every measure of the trees against expert opponents, beside the expert's; how often each leaf decides.
Assumes: trees in the world's order of agents.
Does not: choose trees.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from codegen import ir
from codegen.ir import Float32
from maviper.episodes import measures
from maviper.episodes.play import Controller
from maviper.experts.expert import Expert
from maviper.worlds import Measure, World
from maviper.worlds.world import Int

EVALUATION_EPISODES = 1_000


def evaluation(world: World, agents: Sequence[ir.AgentPolicy], expert: Expert) -> dict[str, float | int | str]:
    """Every measure of the trees against expert opponents and of the expert, on held-out episodes.

    An agent without a tree is played by the expert.
    """
    return evaluated(world, agents, expert)[0]


def evaluated(
    world: World, agents: Sequence[ir.AgentPolicy], expert: Expert
) -> tuple[dict[str, float | int | str], tuple[ir.AgentPolicy, ...]]:
    """As `evaluation`, and the trees with the visits of their leaves in the same episodes."""
    seeds = range(measures.MEASUREMENT_SEEDS, measures.MEASUREMENT_SEEDS + EVALUATION_EPISODES)
    experts: list[Controller] = [expert] * len(world.agents)
    counting = Counting(world, agents)
    controllers = [counting if agent in counting.trees else expert for agent in range(len(world.agents))]
    rows: dict[str, float | int | str] = {"episodes": EVALUATION_EPISODES}
    theirs = measures.evaluate(world, experts, seeds)
    for measure, ours in measures.evaluate_teams(world, controllers, experts, seeds).items():
        low, high = (round(end, 6) for end in ours.interval)
        rows |= {measure.label: ours.value, f"{measure.label} low": low, f"{measure.label} high": high}
        rows[f"{measure.team} expert {measure.name}"] = theirs[measure].value
    return rows, counting.counted()


class Counting:
    """A controller of trees that counts how often each leaf decides, for agents that act."""

    def __init__(self, world: World, policies: Sequence[ir.AgentPolicy]) -> None:
        self.world, self.policies = world, tuple(policies)
        self.trees = {world.agents.index(policy.agent): policy.tree for policy in policies}
        self.visits = {agent: np.zeros(len(tree.feature), np.int64) for agent, tree in self.trees.items()}

    def act(self, agents: Sequence[int], observations: Sequence[Float32], state: Any) -> Int:
        """As `Controller.act`."""
        acting, chosen = self.world.alive(state), []
        for agent in agents:
            tree = self.trees[agent]
            leaf = ir.apply(tree, observations[agent])
            self.visits[agent] += np.bincount(leaf[acting[:, agent]], minlength=len(tree.feature))
            chosen.append(tree.action[leaf])
        return np.stack(chosen, axis=1)

    def counted(self) -> tuple[ir.AgentPolicy, ...]:
        """The policies with what was counted."""
        found = zip(self.policies, self.trees.items(), strict=True)
        return tuple(replace(each, tree=replace(tree, visits=self.visits[agent])) for each, (agent, tree) in found)


def measured_of(rows: Mapping[str, float | int | str], measure: Measure) -> tuple[float, float]:
    """The trees' and the expert's value of a measure in what `evaluation` wrote."""
    return float(rows[measure.label]), float(rows[f"{measure.team} expert {measure.name}"])
