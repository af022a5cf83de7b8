"""Trees as players, and what they meet in episodes.

Does: deploys grown trees as policies, seats policies among other controllers; plays a profile's own trees; counts while
  it plays how often each leaf decides, and the ranges and percentiles of what trees observe.
Assumes: trees in the world's order of agents.
Does not: choose episodes, or measure.

Ranges are kept for games of other people, whose features often have none that means anything. Ours state theirs.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from codegen import ir
from codegen.deciding import decide_at, take_actions
from codegen.errors import InputError
from codegen.ir import NO_ACTION, Float32, GrownTree, Seen
from codegen.lowering.deploy import SummedTree, deploy_tree
from maviper.episodes import measures
from maviper.episodes.play import Controller, Episodes, in_columns, play, tree_policies
from maviper.worlds import World
from maviper.worlds.outside.sources import is_named_by_user
from maviper.worlds.world import Int


def agent_policies(
    world: World, grown: Sequence[GrownTree], agents: Sequence[int] | None = None
) -> tuple[ir.AgentPolicy, ...]:
    """The grown trees of some agents (None: of all) as deployed policies."""
    policies: list[ir.AgentPolicy] = []
    for agent, tree in zip(range(len(world.agents)) if agents is None else agents, grown, strict=True):
        name = world.agents[agent]
        tree = world.deploy(agent, tree)
        kept = None if isinstance(tree, SummedTree) else tree
        given = (world.features[agent], world.policy_actions[agent], deploy_tree(tree), kept)
        policies.append(ir.AgentPolicy(name, world.team_of(name), *given, outputs=world.given[agent]))
    return tuple(policies)


def among(world: World, policies: Sequence[ir.AgentPolicy], others: Sequence[Controller]) -> list[Controller]:
    """A controller for each agent: its tree, or `others` where it has none."""
    trees = {policy.agent: policy for policy in policies}
    if len(trees) == len(world.agents):
        return [tree_policies([trees[agent] for agent in world.agents])] * len(world.agents)
    # a controller is asked by the agent's place, so the one tree stands in every place
    return [
        tree_policies([trees[agent]] * len(world.agents)) if agent in trees else other
        for agent, other in zip(world.agents, others, strict=True)
    ]


def reopen_tree(policy: ir.AgentPolicy) -> GrownTree:
    """A policy's deployed tree as one that can be changed; deployed again, it is the same. InputError where its sums
    are no double sums of different features, as imported ones may be.
    """
    tree = policy.tree
    action = np.where(tree.action == NO_ACTION, NO_ACTION, take_actions(policy, tree.action))
    arrays = tree.feature, tree.threshold.astype(np.float64), tree.left, tree.right, action
    if not tree.sums and not tree.vectors:
        return GrownTree(*arrays)
    n_features = len(policy.features)
    tests = np.zeros((len(tree.sums), n_features + 1))
    given = np.zeros((len(tree.vectors), len(policy.outputs), n_features + 1))
    for row, each in zip([*tests, *given.reshape(-1, n_features + 1)], tree.all_sums, strict=True):
        for feature, weight in each.expand().items():
            row[feature] = float(weight)  # CONSTANT is the last place
    grown = SummedTree(*arrays, tests[:, :-1].astype(np.float32), given)
    again = deploy_tree(grown)
    if (again.sums, again.vectors, again.arithmetic) != (tree.sums, tree.vectors, tree.arithmetic):
        what, advice = "its sums cannot be changed", "extract the tree anew, with double sums of different features"
        raise InputError(what, policy.agent, advice)
    return grown


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
        """Returns the actions of some agents, and counts the leaves they reach; see `Controller.act`."""
        acting = self.world.alive(state)
        chosen: list[Any] = []
        for agent in agents:
            tree, rows = self.trees[agent], observations[agent]
            leaf = ir.apply(tree, rows)
            self.visits[agent] += np.bincount(leaf[acting[:, agent]], minlength=len(tree.feature))
            if agent in self.ranges:
                self.ranges[agent].add(rows[acting[:, agent]])
            policy = self.placed[agent]
            chosen.append(decide_at(policy, leaf, rows))
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


ON_POLICY_EPISODES = 4_000  # of 25 steps: 100,000 observations per agent
AT_ONCE = 1 << 24  # numbers that agents observe in a part of the episodes


def all_seeds() -> range:
    """The seeds of all on-policy episodes."""
    return range(measures.ON_POLICY_SEEDS, measures.ON_POLICY_SEEDS + ON_POLICY_EPISODES)


def in_parts(profile: ir.PolicyProfile) -> Iterator[range]:
    """The seeds of on-policy episodes in parts of bounded memory: one part, unless agents observe much."""
    numbers = profile.world.episode_steps * sum(len(policy.features) for policy in profile.agents)
    count, seeds = max(1, AT_ONCE // max(1, numbers)), all_seeds()
    return (seeds[low : low + count] for low in range(0, len(seeds), count))


def on_policy(
    profile: ir.PolicyProfile,
    world: World,
    driver: Controller | None = None,
    keep: bool = True,
    seeds: Sequence[int] | None = None,
) -> Episodes:
    """Episodes of the profile's own trees, or the same episodes driven by `driver`. `keep`: as in `play`; `seeds`: of
    which episodes, None for all.
    """
    controller = tree_policies(profile.agents) if driver is None else driver
    start = world.start_from_seeds(all_seeds() if seeds is None else seeds)
    return play(world, [controller] * len(profile.agents), start, keep)
