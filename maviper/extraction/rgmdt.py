"""RGMDT (Chen et al., NeurIPS 2024, arXiv 2410.16517), built after its description: no code of theirs was seen.

Does: rounds in which each agent's tree is grown anew as a clustering of action values under a budget of leaves, the
  values being those of the expert's Q with all others at their current trees.
Assumes: an expert with a critic, or one of value networks.
Does not: claim to repeat published numbers, which are for other games.

What the description leaves open, and the reading chosen:
- Vectors are Q_i(x, a_i, the others' current actions) over a_i, less their mean: cosine distances then depend on
  differences between actions alone. Lengths are weights, so a state in which every action is worth the same is none.
- The description trains a network that assigns clusters and fits trees to it. Here the leaves are the clusters: splits
  are searched by the clustering loss itself (growth/best_first.py), so that nothing is lost between the two.
- A split tests one feature. Others act by their experts until they have a tree. Each round adds episodes of all current
  trees, the first round's being the experts'; one round is chosen as for the other algorithms.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from codegen import ir
from codegen.errors import InputError
from codegen.ir import Float32, Float64, GrownTree
from maviper.episodes.play import Controller
from maviper.episodes.trees import agent_policies, among
from maviper.experts.wrapped import critic_of
from maviper.extraction.dataset import Dataset, Met, collect
from maviper.extraction.extraction import Extraction
from maviper.extraction.growth.best_first import BestFirstTree
from maviper.extraction.growth.histogram import BINS, Bins
from maviper.extraction.growth.weights import ROWS_AT_ONCE, joint_actions, parts
from maviper.extraction.selection.selection import Selection
from maviper.extraction.selection.stack import merge_leaves
from maviper.extraction.settings import HISTOGRAM
from maviper.worlds.world import Int


def rgmdt(asked: Extraction, agents: Sequence[int], selection: Selection) -> int:
    """Offers the trees of every round to `selection`; returns how many points there were in the end.

    Rounds are made again when a run goes on. InputError for an expert without a critic.
    """
    world, settings = asked.world, asked.settings
    if critic_of(asked.expert) == "none":
        raise InputError("rgmdt clusters the expert's Q", "--critic none", "choose --critic learned or measured")
    points, trees = _Points(asked, agents), dict[int, GrownTree]()
    controllers: Sequence[Controller] = [asked.expert] * len(world.agents)
    for iteration in range(settings.iterations):
        met = points.play(controllers, settings.rollout_episodes(iteration))
        selection.note_rollouts(met.values, met.fidelity)
        for agent in agents:
            trees[agent] = points.tree(agent, trees)
        if selection.offer([trees[agent] for agent in agents]):
            break
        controllers = among(world, agent_policies(world, [trees[agent] for agent in agents], agents), controllers)
    return len(points.data)


class _Points:
    """All states met so far, in which Q is asked."""

    data: Dataset

    def __init__(self, asked: Extraction, agents: Sequence[int]) -> None:
        self.asked, self.agents = asked, list(agents)
        self.state: Any = None

    def play(self, controllers: Sequence[Controller], seeds: range) -> Met:
        """More episodes, whose points join the others."""
        asked, states = self.asked, [] if self.state is None else [self.state]

        def keep_state(observations: tuple[Float32, ...], state: Any, wanted: Int) -> Float64:
            states.append(state)
            return np.ones((len(wanted), len(self.agents)))

        met = collect(asked.world, asked.expert, controllers, self.agents, seeds, keep_state)
        self.data = met.data if self.state is None else self.data + met.data
        self.state = states[0].concatenate(states)
        return met

    def tree(self, agent: int, trees: Mapping[int, GrownTree]) -> GrownTree:
        """An agent's tree, the others acting by `trees`, or by their experts where they have none."""
        settings = self.asked.settings
        rows = np.flatnonzero(self.data.alive[:, agent])[-settings.max_samples :]
        seen, values = self.data.observations[agent][rows], self._values(agent, trees, rows)
        bins = Bins.of(seen, BINS if settings.splits == HISTOGRAM else len(seen) + 1)
        vectors = values - values.mean(axis=1, keepdims=True)
        grown = BestFirstTree(bins.codes(seen), vectors, bins, settings.max_depth).grow_to(settings.leaves)
        return merge_leaves(grown)

    def _values(self, agent: int, trees: Mapping[int, GrownTree], rows: Int) -> Float64:
        """Q of each of an agent's actions, [len(rows), n_actions]."""
        world, expert, data = self.asked.world, self.asked.expert, self.data
        acting = data.labels[rows].copy()
        others = [other for other in trees if other != agent]
        policies = agent_policies(world, [trees[other] for other in others], others)
        for other, policy in zip(others, policies, strict=True):
            acting[:, other] = ir.act(policy, data.observations[other][rows])
        joint = joint_actions(world, agent, [])
        q_values = np.empty((len(rows), len(joint)))
        for part in parts(slice(None), len(rows), max(1, ROWS_AT_ONCE // len(joint))):
            here = [seen[rows[part]] for seen in data.observations]
            q_values[part] = expert.q(agent, here, self.state[rows[part]], joint, acting[part])
        return q_values
