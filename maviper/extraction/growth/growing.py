"""Growing trees by either way of searching splits: every threshold (scikit-learn's CART), or histograms.

Does: keeps the bins of a data set that only grows; grows a team jointly, or one agent alone, or one tree for a team.
Assumes: points are appended, never changed.
Does not: know where the points come from.
"""

from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from codegen.ir import Bool, FeatureSpec, Float32, Float64, GrownTree
from maviper.extraction.dataset import Dataset
from maviper.extraction.growth.alternating import Labels, Numbers, optimise_tests
from maviper.extraction.growth.best_first import BestFirstTree, gini, thrift
from maviper.extraction.growth.grow import CartTree, Growing, grow_jointly, grow_shared
from maviper.extraction.growth.histogram import Bins, Codes, HistogramTree
from maviper.extraction.growth.regression import KINDS, Leaves, grow_tree, testing
from maviper.extraction.settings import DIFFERENCES, EXACT, SUMS, Settings
from maviper.worlds import World
from maviper.worlds.world import Int

# Bins are those of the first REFIT_FACTOR**k points, k as large as there are points: a matter of their number alone, so
# that a run that goes on makes the same ones.
REFIT_FACTOR = 1.5


class Part(NamedTuple):
    """The points of one tree."""

    agent: int  # whose tree it is, or the first of those who share it
    obs: Float32  # [n, n_features]
    labels: Any  # [n], or [n, n_outputs]
    counts: Int  # [n] how often its data set holds each point
    alive: Bool  # [n] whether the agent takes part, and the point is of its data
    regrets: Float64 | None = None  # [n, n_actions] what each action costs, where that decides in place of labels


def _part(data: Dataset, agent: int, counts: Int) -> Part:
    labels = np.ascontiguousarray(data.labels[:, agent])
    return Part(agent, data.observations[agent], labels, counts, data.alive[:, agent], data.regrets.get(agent))


def pool_points(data: Dataset, members: Sequence[int], counts: Mapping[int, Int] | Sequence[Int]) -> Part:
    """The points of agents that share a tree: of each point one row per member, so that later points stand behind."""
    obs = np.stack([data.observations[agent] for agent in members], axis=1)
    columns = np.stack([counts[agent] for agent in members], axis=1)
    labels = data.labels[:, members].reshape(-1, *data.labels.shape[2:])
    costs: Any = np.stack([data.regrets[agent] for agent in members], axis=1) if data.regrets else None
    costs = None if costs is None else costs.reshape(-1, costs.shape[2])
    alive = data.alive[:, members].ravel()
    return Part(members[0], obs.reshape(-1, obs.shape[2]), labels, columns.ravel(), alive, costs)


def _pairs(features: Sequence[FeatureSpec]) -> list[tuple[int, int]]:
    """The places of two features of the same unit, whose difference means something."""
    places = range(len(features))
    return [(one, other) for one, other in combinations(places, 2) if features[one].unit == features[other].unit]


class Growth:
    """Trees of a world's agents from points that accumulate."""

    def __init__(self, world: World, settings: Settings) -> None:
        self.settings, self.outputs = settings, world.outputs
        self.n_actions = [len(choices) for choices in world.actions]
        differ = settings.splits == DIFFERENCES
        self.pairs = [_pairs(world.features[agent]) if differ else [] for agent in range(len(world.actions))]
        self._bins: dict[int, tuple[Bins, int, Codes]] = {}  # agent -> bins, points that they are of, codes so far

    def team(
        self,
        members: Sequence[int],
        data: Dataset,
        counts: Mapping[int, Int] | Sequence[Int],
        seeds: Mapping[int, int] | Sequence[int],
        least_right: int,
        kept: list[float] | None = None,
    ) -> list[GrownTree]:
        """TrainJointTrees for agents over shared points; with a budget of leaves, or where what actions cost is known,
        each tree best first by itself.

        `counts`, `seeds`: by agent. A point counts at a level when at least `least_right` members are predicted right,
        or take no part in it. `kept`: as in `grow_jointly`. Members that share a tree get the same one.
        """
        alive = data.alive[:, members]
        shared = bool(self.settings.share) and len(members) > 1
        parts = (
            [pool_points(data, members, counts)] if shared else [_part(data, agent, counts[agent]) for agent in members]
        )
        if self.settings.max_leaves or self.outputs or data.regrets:
            assert not least_right, "growth with votes goes level by level"
            if kept is not None:
                kept += [1.0] * len(members)
            trees = [self._best_first(part) for part in parts]
            return trees * len(members) if shared else trees
        if shared:
            (part,) = parts
            member, depth = self._member(part, seeds[part.agent]), self.settings.max_depth
            return [self._testing(part, grow_shared(member, depth, least_right, alive, kept)[0])] * len(members)
        return self.jointly(parts, seeds, least_right, alive, kept)

    def jointly(
        self,
        parts: Sequence[Part],
        seeds: Mapping[int, int] | Sequence[int],
        least_right: int,
        alive: Bool,
        kept: list[float] | None = None,
    ) -> list[GrownTree]:
        """TrainJointTrees for members over shared points, of which each has data of its own: those that it counts.
        `alive`: [n, N] who takes part in each point, in the order of `parts`.
        """
        growing = [self._member(part, seeds[part.agent]) for part in parts]
        trees = grow_jointly(growing, self.settings.max_depth, least_right, alive, kept)
        return [self._testing(part, tree) for part, tree in zip(parts, trees, strict=True)]

    def _best_first(self, part: Part) -> GrownTree:
        rows, settings = np.flatnonzero(part.counts), self.settings
        if settings.splits == EXACT:
            bins = Bins.of(part.obs[rows], len(rows) + 1)
            codes = bins.codes(part.obs[rows])
        else:
            bins, codes = self._code_points(part.agent, part.obs, part.alive)
            codes = codes[:, rows]
        if self.outputs:
            kind = KINDS[settings.leaf]
            leaves = kind(part.obs[rows], part.labels[rows], self.outputs[part.agent])
            summed_tree = grow_tree(leaves, part.counts[rows], codes, bins, settings.max_depth, settings.leaves)
            return self._testing(part, summed_tree, leaves)
        if part.regrets is None:
            purity, vectors = gini, np.zeros((len(rows), self.n_actions[part.agent]))
            vectors[np.arange(len(rows)), part.labels[rows]] = part.counts[rows]
        else:
            purity, vectors = thrift, -part.regrets[rows] * part.counts[rows, None]
        tree = BestFirstTree(codes, vectors, bins, settings.max_depth, purity).deciding(settings.leaves)
        return self._testing(part, tree)

    def _testing(self, part: Part, tree: GrownTree, leaves: Leaves | None = None) -> GrownTree:
        """The tree with the differences that it tests, or with tests of sums, where they are asked for."""
        if self.settings.splits != SUMS:
            return testing(tree, self.pairs[part.agent], part.obs.shape[1])
        rows = np.flatnonzero(part.counts)
        counts, n_actions = part.counts[rows], self.n_actions[part.agent]
        answers = Numbers(leaves, counts) if leaves else Labels(part.labels[rows], counts, n_actions)
        return optimise_tests(tree, part.obs[rows], answers)

    def _columns(self, agent: int, obs: Float32) -> Any:
        """Returns the tested columns, [n, n_columns]: features, then differences of two, as double sums have them."""
        if not self.pairs[agent]:
            return obs
        wide = obs.astype(np.float64)
        return np.column_stack([wide, *(wide[:, one] - wide[:, other] for one, other in self.pairs[agent])])

    def _member(self, part: Part, seed: int) -> Growing:
        obs, labels, counts = part.obs, part.labels, part.counts
        depth, n_actions = self.settings.max_depth, self.n_actions[part.agent]
        if self.settings.splits == EXACT:
            return CartTree(obs, labels, counts, n_actions, depth, seed)
        return HistogramTree(*self._code_points(part.agent, obs, part.alive), labels, counts, n_actions, depth)

    def _code_points(self, agent: int, obs: Float32, alive: Bool) -> tuple[Bins, Codes]:
        """An agent's bins and the codes of all points; only new points are coded. Bins are of points in which it takes
        part, `alive`.
        """
        count = int(alive.sum())
        fitted = int(REFIT_FACTOR ** np.floor(np.log(count) / np.log(REFIT_FACTOR) + 1e-9))
        if agent not in self._bins or fitted != self._bins[agent][1]:
            bins = Bins.of(self._columns(agent, (obs if count == len(obs) else obs[alive])[:fitted]))
            self._bins[agent] = bins, fitted, bins.codes(self._columns(agent, obs))
        bins, _, codes = self._bins[agent]
        known = codes.shape[1]
        if len(obs) > known:
            codes = np.concatenate([codes, bins.codes(self._columns(agent, obs[known:]))], axis=1)
            self._bins[agent] = bins, fitted, codes
        return bins, codes
