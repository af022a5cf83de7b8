"""Growing trees by either way of searching splits: every threshold (scikit-learn's CART), or histograms.

Does: keeps the bins of a data set that only grows; grows a team jointly, or one agent alone.
Assumes: points are appended, never changed.
Does not: know where the points come from.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from codegen.ir import Bool, Float32, GrownTree
from maviper.extraction.dataset import Dataset
from maviper.extraction.growth.best_first import BestFirstTree, gini
from maviper.extraction.growth.grow import CartTree, Growing, grow_jointly
from maviper.extraction.growth.histogram import Bins, Codes, HistogramTree
from maviper.extraction.settings import EXACT, Settings
from maviper.worlds import World
from maviper.worlds.world import Int

# Bins are those of the first REFIT_FACTOR**k points, k as large as there are points: a matter of their number alone, so
# that a run that goes on makes the same ones.
REFIT_FACTOR = 1.5


class Growth:
    """Trees of a world's agents from points that accumulate."""

    def __init__(self, world: World, settings: Settings) -> None:
        self.settings = settings
        self.n_actions = [len(choices) for choices in world.actions]
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
        """TrainJointTrees for agents over shared points; with a budget of leaves, each tree best first by itself.

        `counts`, `seeds`: by agent. A point counts at a level when at least `least_right` members are predicted right,
        or take no part in it. `kept`: as in `grow_jointly`.
        """
        if self.settings.max_leaves:
            assert not least_right, "growth with votes goes level by level"
            if kept is not None:
                kept += [1.0] * len(members)
            return [self._best_first(agent, data, counts[agent]) for agent in members]
        team = [self._member(agent, data, counts[agent], seeds[agent]) for agent in members]
        return grow_jointly(team, self.settings.max_depth, least_right, data.alive[:, members], kept)

    def _best_first(self, agent: int, data: Dataset, counts: Int) -> GrownTree:
        obs, rows, settings = data.observations[agent], np.flatnonzero(counts), self.settings
        if settings.splits == EXACT:
            bins = Bins.of(obs[rows], len(rows) + 1)
            codes = bins.codes(obs[rows])
        else:
            bins, codes = self._coded(agent, obs, data.alive[:, agent])
            codes = codes[:, rows]
        vectors = np.zeros((len(rows), self.n_actions[agent]))
        vectors[np.arange(len(rows)), data.labels[rows, agent]] = counts[rows]
        return BestFirstTree(codes, vectors, bins, settings.max_depth, gini).deciding(settings.max_leaves)

    def _member(self, agent: int, data: Dataset, counts: Int, seed: int) -> Growing:
        obs, labels = data.observations[agent], np.ascontiguousarray(data.labels[:, agent])
        depth, n_actions = self.settings.max_depth, self.n_actions[agent]
        if self.settings.splits == EXACT:
            return CartTree(obs, labels, counts, n_actions, depth, seed)
        return HistogramTree(*self._coded(agent, obs, data.alive[:, agent]), labels, counts, n_actions, depth)

    def _coded(self, agent: int, obs: Float32, alive: Bool) -> tuple[Bins, Codes]:
        """An agent's bins and the codes of all points; only new points are coded. Bins are of points in which it takes
        part, `alive`.
        """
        count = int(alive.sum())
        fitted = int(REFIT_FACTOR ** np.floor(np.log(count) / np.log(REFIT_FACTOR) + 1e-9))
        if agent not in self._bins or fitted != self._bins[agent][1]:
            bins = Bins.of((obs if count == len(obs) else obs[alive])[:fitted])
            self._bins[agent] = bins, fitted, bins.codes(obs)
        bins, _, codes = self._bins[agent]
        known = codes.shape[1]
        if len(obs) > known:
            codes = np.concatenate([codes, bins.codes(obs[known:])], axis=1)
            self._bins[agent] = bins, fitted, codes
        return bins, codes
