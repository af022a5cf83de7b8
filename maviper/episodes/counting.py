"""What trees meet in episodes: how often each leaf decides, and the ranges of what they observe.

Does: a controller of trees that counts while it plays; the least and most of each feature, and its percentiles.
Assumes: trees in the world's order of agents.
Does not: choose episodes.

Ranges are kept for games of other people, whose features often have none that means anything. Ours state theirs.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from codegen import ir
from codegen.ir import Float32, Seen
from maviper.episodes.play import in_columns
from maviper.worlds import World
from maviper.worlds.outside.sources import is_named_by_user
from maviper.worlds.world import Int

KEPT = 20_000  # observations of an agent, at even distances, of which percentiles are taken
PERCENTILES = (1, 99)


class Ranges:
    """The ranges of some features, from batches of observations. What is not finite is left out."""

    def __init__(self, n_features: int) -> None:
        self._least, self._most = np.full(n_features, np.inf), np.full(n_features, -np.inf)
        self._kept, self._count = list[Float32](), 0
        self._stride, self._met = 1, 0

    def add(self, rows: Float32) -> None:
        """Takes a batch in, [batch, n_features]."""
        finite = np.isfinite(rows)
        self._least = np.minimum(self._least, np.where(finite, rows, np.inf).min(axis=0, initial=np.inf))
        self._most = np.maximum(self._most, np.where(finite, rows, -np.inf).max(axis=0, initial=-np.inf))
        taken = rows[-self._met % self._stride :: self._stride]
        self._met += len(rows)
        self._kept.append(taken)
        self._count += len(taken)
        while self._count > KEPT:  # half as many, twice as far apart
            self._kept = [np.concatenate(self._kept)[::2]]
            self._count, self._stride = len(self._kept[0]), 2 * self._stride

    def summarise(self) -> tuple[Seen, ...]:
        """Least, percentiles and most of each feature; () where some feature was never finite."""
        if not np.isfinite(self._least).all():
            return ()
        kept = np.concatenate(self._kept).astype(np.float64)
        kept = np.where(np.isfinite(kept), kept, np.nan)
        inner = np.nanpercentile(kept, PERCENTILES, axis=0, method="nearest")
        columns = zip(self._least.tolist(), *inner.tolist(), self._most.tolist(), strict=True)
        return tuple((least, low, high, most) for least, low, high, most in columns)


class Counting:
    """A controller of trees that counts how often each leaf decides, and what it observes, for agents that act."""

    def __init__(self, world: World, policies: Sequence[ir.AgentPolicy]) -> None:
        self.world, self.policies = world, tuple(policies)
        self.placed = {world.agents.index(policy.agent): policy for policy in policies}
        self.trees = {agent: policy.tree for agent, policy in self.placed.items()}
        self.visits = {agent: np.zeros(len(tree.feature), np.int64) for agent, tree in self.trees.items()}
        outside = is_named_by_user(world.name)
        self.ranges = {agent: Ranges(len(world.features[agent])) for agent in self.trees if outside}

    def act(self, agents: Sequence[int], observations: Sequence[Float32], state: Any) -> Int:
        """As `Controller.act`."""
        acting = self.world.alive(state)
        chosen: list[Any] = []
        for agent in agents:
            tree, rows = self.trees[agent], observations[agent]
            leaf = ir.apply(tree, rows)
            self.visits[agent] += np.bincount(leaf[acting[:, agent]], minlength=len(tree.feature))
            if agent in self.ranges:
                self.ranges[agent].add(rows[acting[:, agent]])
            policy = self.placed[agent]
            chosen.append(ir.outputs(policy, rows) if policy.outputs else tree.action[leaf])
        return in_columns(chosen)

    def annotate_policies(self) -> tuple[ir.AgentPolicy, ...]:
        """The policies with what was counted."""
        return tuple(
            replace(
                policy,
                tree=replace(tree, visits=self.visits[agent]),
                seen=self.ranges[agent].summarise() if agent in self.ranges else policy.seen,
            )
            for policy, (agent, tree) in zip(self.policies, self.trees.items(), strict=True)
        )
