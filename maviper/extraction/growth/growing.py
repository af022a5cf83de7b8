"""Growing trees by either way of searching splits: every threshold (scikit-learn's CART), or histograms.

Does: keeps the bins of a data set that only grows; grows a team jointly, or one agent alone, or one tree for a team;
  gives trees the tests of a mask of legal actions that they need. The mask is tested before a leaf's action, where the
  path to the leaf has not made sure that the action is legal; then comes the action that most labels there name, and
  the last one needs no test.
Assumes: points are appended, never changed; features of a mask are 0 or 1, and in every state in which an agent acts
  some action is legal, and labels are.
Does not: know where the points come from.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from codegen.ir import NO_ACTION, NO_CHILD, NO_FEATURE, ROOT, Bool, FeatureSpec, Float32, GrownTree
from codegen.paths import LEGAL, Mask
from maviper.extraction.dataset import Dataset
from maviper.extraction.growth.best_first import KINDS, BestFirstTree, Leaves, gini, grow_tree, testing
from maviper.extraction.growth.exact import CartTree
from maviper.extraction.growth.joint import Bins, Codes, GrowingTree, HistogramTree, grow_jointly, grow_shared
from maviper.extraction.growth.sums import Labels, Numbers, optimise_tests
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


def _part(data: Dataset, agent: int, counts: Int) -> Part:
    labels = np.ascontiguousarray(data.labels[:, agent])
    return Part(agent, data.observations[agent], labels, counts, data.alive[:, agent])


def pool_points(data: Dataset, members: Sequence[int], counts: Mapping[int, Int] | Sequence[Int]) -> Part:
    """The points of agents that share a tree: of each point one row per member, so that later points stand behind."""
    obs = np.stack([data.observations[agent] for agent in members], axis=1)
    columns = np.stack([counts[agent] for agent in members], axis=1)
    labels = data.labels[:, members].reshape(-1, *data.labels.shape[2:])
    alive = data.alive[:, members].ravel()
    return Part(members[0], obs.reshape(-1, obs.shape[2]), labels, columns.ravel(), alive)


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
        """TrainJointTrees for agents over shared points; with a budget of leaves, each tree best first by itself.

        `counts`, `seeds`: by agent. A point counts at a level when at least `least_right` members are predicted right,
        or take no part in it. `kept`: as in `grow_jointly`. Members that share a tree get the same one.
        """
        alive = data.alive[:, members]
        shared = bool(self.settings.share) and len(members) > 1
        parts = (
            [pool_points(data, members, counts)] if shared else [_part(data, agent, counts[agent]) for agent in members]
        )
        if self.settings.max_leaves or self.outputs:
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
        vectors = np.zeros((len(rows), self.n_actions[part.agent]))
        vectors[np.arange(len(rows)), part.labels[rows]] = part.counts[rows]
        tree = BestFirstTree(codes, vectors, bins, settings.max_depth, gini).deciding(settings.leaves)
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

    def _member(self, part: Part, seed: int) -> GrowingTree:
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


Legal = Mapping[int, bool]  # of some actions, whether they are legal


@dataclass(frozen=True)
class Labelled:
    """The points that one agent's second choices are learned from."""

    observations: Float32  # [n, n_features]
    labels: Int  # [n]


def lawful(tree: GrownTree, mask: Mask, known: Labelled) -> GrownTree:
    """The tree with the tests of the mask that it needs: it decides as before wherever its own action is legal."""
    completion = _Completion(tree, mask, known)
    always = {action: True for action, place in enumerate(mask) if place is None}
    completion.below(ROOT, np.arange(len(known.labels)), always)
    return GrownTree(*(np.array(column) for column in zip(*completion.rows, strict=True)))


class _Completion:
    """A tree while it is written anew, node by node. Each method returns where in `rows` its part begins."""

    def __init__(self, tree: GrownTree, mask: Mask, known: Labelled) -> None:
        self.tree, self.mask, self.known = tree, mask, known
        self.rows: list[tuple[int, float, int, int, int]] = []
        self.asked = {place: action for action, place in enumerate(mask) if place is not None}
        self.usual = np.bincount(known.labels, minlength=len(mask))

    def below(self, node: int, here: Int, legal: Legal) -> int:
        """The part of the tree from a node on. `here`: the points that reach it."""
        tree, feature = self.tree, int(self.tree.feature[node])
        if feature == NO_FEATURE:
            return self._choice(int(tree.action[node]), here, legal)
        left, right, threshold = int(tree.left[node]), int(tree.right[node]), float(tree.threshold[node])
        action = self.asked.get(feature)
        if action is None:
            sides = self._split_points(here, feature, threshold)
            return self._split(feature, threshold, ((left, sides[0], legal), (right, sides[1], legal)))
        if not 0 <= threshold < 1 or action in legal:  # decided before it is asked
            goes_left = threshold >= 1 or (threshold >= 0 and not legal[action])
            return self.below(left if goes_left else right, here, legal)
        sides = self._split_points(here, feature, LEGAL)  # one threshold says what any other in [0, 1) does
        known = ({**legal, action: False}, {**legal, action: True})
        return self._split(feature, LEGAL, ((left, sides[0], known[0]), (right, sides[1], known[1])))

    def _split(self, feature: int, threshold: float, sides: Sequence[tuple[int, Int, Legal]]) -> int:
        place = self._leaf(NO_ACTION)
        left, right = (self.below(*side) for side in sides)
        self.rows[place] = (feature, threshold, left, right, NO_ACTION)
        return place

    def _choice(self, action: int, here: Int, legal: Legal) -> int:
        """An action where it is legal, else the others in their order."""
        others = [other for other in range(len(self.mask)) if other != action and legal.get(other, True)]
        if legal.get(action) or not others:  # also where the path says that none is legal: nobody gets there
            return self._leaf(action)
        if not legal.get(action, True):
            return self._choice(self._best(others, here), here, legal)
        feature = self.mask[action]
        assert feature is not None
        place, illegal = self._leaf(NO_ACTION), self._split_points(here, feature, LEGAL)[0]
        left = self._choice(self._best(others, illegal), illegal, {**legal, action: False})
        self.rows[place] = (feature, LEGAL, left, self._leaf(action), NO_ACTION)
        return place

    def _best(self, actions: Sequence[int], here: Int) -> int:
        """The action that most of some points are labelled with, of equals the one that most of all points are."""
        counts = np.bincount(self.known.labels[here], minlength=len(self.mask))
        return max(actions, key=lambda action: (counts[action], self.usual[action], -action))

    def _split_points(self, here: Int, feature: int, threshold: float) -> tuple[Int, Int]:
        # float32 against float64, as scikit-learn compares
        goes_left = self.known.observations[here, feature] <= np.float64(threshold)
        return here[goes_left], here[~goes_left]

    def _leaf(self, action: int) -> int:
        self.rows.append((NO_FEATURE, 0.0, NO_CHILD, NO_CHILD, action))
        return len(self.rows) - 1
