# pyright: basic
"""Joint tree growing: the trees of a team grow level by level and predict one another (paper, TrainJointTrees).

Does: Build (vote filter, best split) and Predict (projected trees), both over all points of a level at once; searches
  splits by histograms: all open leaves of a tree, and all its projected trees, in one vectorised pass per level.
Assumes: data sets as multiplicities of shared points; for histograms few classes, and class counts that are whole
  numbers, together below 2^26, so that sums of them and of their squares are exact in any order.
Does not: choose data or judge trees; try every threshold (exact.py). A feature with more than BINS distinct values
  is cut at BINS - 1 of them, spread evenly over its values by rank; with fewer, every midpoint is a candidate, and
  splits are CART's.

Reading of the paper: the vote counts every member of the team, i itself too; a point of D_i counts at a level when at
least N - 1 of N members, or as many as are asked for, are predicted right (who has left there is never wrong); removals
last for that level only; a node left without points uses its unfiltered ones. A projected tree has the remaining depth
and learns from the node's unfiltered points. Where no depth remains there is none: a finished tree votes by its own
leaves.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from codegen.ir import NO_ACTION, NO_CHILD, NO_FEATURE, Bool, Float32, Float64, GrownTree
from maviper.worlds.world import Int


def grow_jointly(
    team: Sequence["GrowingTree"],
    max_depth: int,
    least_right: int,
    alive: Bool | None = None,
    kept: list[float] | None = None,
) -> list[GrownTree]:
    """TrainJointTrees: each member grows a level in turn, on the points where enough members are predicted right.

    `least_right`: how many right predictions a point needs; `alive`: [n, N] who takes part in each point (None:
    everybody). A member that takes no part in a point cannot be wrong there, so that of the others as many may be as
    ever. `kept` gets, for each Build, the share of the member's data set that the votes keep.
    """
    everything = np.ones(len(team[0].labels), dtype=bool)
    absent = [np.False_] * len(team) if alive is None else list(~alive.T)
    for _ in range(max_depth):
        for agent in team:
            keep = everything  # where there is nothing to ask
            if least_right > 0:
                right = [member.check_predictions() | out for member, out in zip(team, absent, strict=True)]
                keep = np.sum(right, axis=0) >= least_right
            if kept is not None:
                kept.append(float(agent.counts[keep].sum() / max(1, agent.counts.sum())))
            agent.build(keep)
    return [agent.tree() for agent in team]


def grow_shared(
    tree: "GrowingTree", max_depth: int, least_right: int, alive: Bool, kept: list[float] | None = None
) -> list[GrownTree]:
    """Grows one tree for all members, like `grow_jointly`: [the tree] * N. Its points are those of `alive` [n, N], one
    row per member and point; a point that the votes drop loses all its rows.
    """
    n, members = alive.shape
    for _ in range(max_depth):
        keep = np.ones(n * members, dtype=bool)
        if least_right > 0:
            right = tree.check_predictions().reshape(n, members) | ~alive
            keep = np.repeat(right.sum(axis=1) >= least_right, members)
        if kept is not None:
            kept.append(float(tree.counts[keep].sum() / max(1, tree.counts.sum())))
        tree.build(keep)
    return [tree.tree()] * members


class GrowingTree(ABC):
    """One agent's tree while it grows level by level, over points that the team shares. Nodes are numbered as they are
    made.
    """

    def __init__(self, labels: Int, counts: Any, n_actions: int, max_depth: int) -> None:
        """`labels`: [n]; `counts`: [n] whole or float64, how often the agent's data set holds each point."""
        self.labels, self.counts, self.n_actions, self.max_depth = labels, counts, n_actions, max_depth
        self.feature: list[int] = []
        self.threshold: list[float] = []
        self.children: list[tuple[int, int]] = []
        self.action: list[int] = []
        self.place = np.zeros(len(labels), dtype=np.int64)  # the leaf that each point is in
        self.open = [self.add_leaf(int(np.bincount(labels, counts, n_actions).argmax()))]  # of the current level
        self.level = 0
        self._right: Bool | None = None  # kept until the tree grows

    def check_predictions(self) -> Bool:
        """Predict for all points: does the projected final tree act as the expert does? [n]"""
        if self._right is None:
            predicted, remaining = np.array(self.action)[self.place], self.max_depth - self.level
            if self.open and remaining:  # a finished tree votes by its own leaves
                said = self.project(self.slots(), remaining)
                predicted = np.where(said >= 0, said, predicted)
            self._right = np.equal(predicted, self.labels)
        return self._right

    def build(self, keep: Bool) -> None:
        """Build: grows one level, splits every open leaf on its kept points, on all its points where none is kept.
        `keep`: [n].
        """
        self.open = self.split_leaves(self.slots(), keep) if self.open else []
        self.level += 1
        self._right = None

    def tree(self) -> GrownTree:
        """The tree grown so far."""
        split = np.array(self.feature) != NO_FEATURE
        left, right = zip(*self.children, strict=True)
        action = np.where(split, NO_ACTION, self.action)
        return GrownTree(np.array(self.feature), np.array(self.threshold), np.array(left), np.array(right), action)

    @abstractmethod
    def project(self, slot: Int, depth: int) -> Int:
        """The actions of trees of `depth`, one for each open leaf and fitted to its points, at every point, [n], -1
        where there is none. `slot`: as of `slots`.
        """

    @abstractmethod
    def split_leaves(self, slot: Int, keep: Bool) -> list[int]:
        """Splits the open leaves; returns the new ones. `slot`: as of `slots`; `keep`: as of `build`."""

    def slots(self) -> Int:
        """The place of each point's leaf among the open ones, or -1."""
        place_of = np.full(len(self.feature), -1, dtype=np.int64)
        place_of[self.open] = np.arange(len(self.open))
        return place_of[self.place]

    def add_leaf(self, action: int) -> int:
        """Adds a leaf that takes an action; returns its node."""
        self.feature.append(NO_FEATURE)
        self.threshold.append(0.0)
        self.children.append((NO_CHILD, NO_CHILD))
        self.action.append(action)
        return len(self.feature) - 1


BINS = 256
FEW = 100  # points for each slot: below it, sorting them is quicker than counting them in bins
Codes = npt.NDArray[np.int32]


@dataclass(frozen=True)
class Bins:
    """Candidate thresholds of each feature, ascending; an observation goes left of edge k iff it is <= edges[k]."""

    edges: tuple[Float64, ...]

    @staticmethod
    def of(obs: Float32, most: int = BINS) -> "Bins":
        """Bins for the observations [n, n_features]: midpoints between neighbouring distinct values. `most`: how many
        bins that a feature may have.
        """
        edges = list[Float64]()
        for column in np.ascontiguousarray(obs.T):
            values = np.unique(column).astype(np.float64)
            middle = (values[1:] + values[:-1]) / 2
            if len(middle) > most - 1:
                ordered = np.sort(column)
                wanted = ordered[np.linspace(0, len(ordered) - 1, most + 1).astype(np.int64)[1:-1]]
                places = np.unique(np.minimum(np.searchsorted(values, wanted), len(middle) - 1))
                middle = middle[places]
            edges.append(middle)
        return Bins(tuple(edges))

    def codes(self, obs: Float32) -> Codes:
        """The bin of every observation, [n_features, n]."""
        codes = np.empty((obs.shape[1], len(obs)), dtype=np.int32)
        for code, column, edges in zip(codes, np.ascontiguousarray(obs.T), self.edges, strict=True):
            code[...] = np.searchsorted(edges, column.astype(np.float64), side="left")
        return codes


@dataclass(frozen=True)
class Splits:
    """The best split of each slot (a leaf, or a leaf of a projected tree)."""

    feature: Int  # [n_slots]
    code: Int  # [n_slots] points with a bin up to it go left
    found: Bool  # [n_slots] whether there is any: both sides hold points, and the slot is not pure
    totals: Float64  # [n_slots, n_actions] class counts


def best_splits(codes: Codes, labels: Int, weights: Float64, slot: Int, n_slots: int, n_actions: int) -> Splits:
    """The split of least weighted Gini impurity in every slot; of equals the first feature's lowest threshold.

    `codes`: [n_features, n]; `labels`, `weights`, `slot`: [n].
    """
    counted = np.bincount(slot * n_actions + labels, weights, n_slots * n_actions)
    totals = counted.reshape(n_slots, n_actions).astype(np.float64)
    impure = (totals > 0).sum(axis=1) > 1
    several = np.flatnonzero((codes[:, 1:] != codes[:, :-1]).any(axis=1))  # a feature of one value splits nothing
    if len(labels) < FEW * n_slots:
        feature, code, found = _sorted_splits(codes[several], labels, weights, slot, totals)
        return Splits(several[feature] if len(several) else feature, code, found & impure, totals)
    best = np.full(n_slots, -np.inf)
    feature, code = np.zeros(n_slots, dtype=np.int64), np.zeros(n_slots, dtype=np.int64)
    everybody, of_action = np.arange(n_slots), np.ascontiguousarray(totals.T)
    everything, squared = totals.sum(axis=1, keepdims=True), np.square(totals).sum(axis=1, keepdims=True)
    base = (labels * n_slots + slot) * BINS  # actions outermost, so that sums over them run along whole rows
    counted = np.empty_like(base)
    for index in several:
        np.add(base, codes[index], out=counted)
        counts = np.bincount(counted, weights, n_actions * n_slots * BINS).reshape(n_actions, n_slots, BINS)
        left = counts.cumsum(axis=2)[:, :, :-1]
        below = left.sum(axis=0)
        above = everything - below
        of_left = np.einsum("asb,asb->sb", left, left)
        of_right = squared - 2 * np.einsum("asb,as->sb", left, of_action) + of_left  # exact: all are whole numbers
        purity = of_left / np.maximum(below, 1) + of_right / np.maximum(above, 1)
        purity = np.where((below > 0) & (above > 0), purity, -np.inf)
        place = purity.argmax(axis=1)
        reached = purity[everybody, place]
        better = reached > best
        best[better], feature[better], code[better] = reached[better], index, place[better]
    return Splits(feature, code, (best > -np.inf) & impure, totals)


def _sorted_splits(codes: Codes, labels: Int, weights: Float64, slot: Int, totals: Float64) -> tuple[Int, Int, Bool]:
    """Features, codes and whether there are any, as `best_splits` finds them by a histogram, by sorting the points of
    all features at once: quicker where there are fewer points than cells of histograms.
    """
    n_slots, n_actions = totals.shape
    feature, code = np.zeros(n_slots, dtype=np.int64), np.zeros(n_slots, dtype=np.int64)
    occupied = np.flatnonzero(np.bincount(slot, minlength=n_slots))
    best = np.full(n_slots, -np.inf)
    if not codes.size:
        return feature, code, best > -np.inf
    kind = np.uint16 if n_slots * BINS <= 2**16 else np.int64  # short ones are sorted in one pass
    key = (slot * BINS + codes).astype(kind)
    order = np.argsort(key, axis=1, kind="stable")
    key = np.take_along_axis(key, order, axis=1)
    place = key[0] // BINS  # whose slots stand in the same order in each row
    last = np.append(np.flatnonzero(np.diff(place)), len(place) - 1)  # of each occupied slot
    first = np.append(0, last[:-1] + 1)
    below, of_left, of_right = (np.zeros(key.shape) for _ in range(3))
    for action in range(n_actions):
        left = np.where(labels == action, weights, 0.0)[order].cumsum(axis=1)
        left -= np.append(0.0, left[0, last[:-1]])[np.searchsorted(last, np.arange(len(place)))]
        below += left
        of_left += left * left
        of_right += np.square(totals[place, action] - left)
    above = totals.sum(axis=1)[place] - below
    purity = of_left / np.maximum(below, 1) + of_right / np.maximum(above, 1)
    purity[:, :-1][key[:, 1:] == key[:, :-1]] = -np.inf  # the cell goes on
    purity[(below <= 0) | (above <= 0)] = -np.inf
    reached = np.maximum.reduceat(purity, first, axis=1)  # [n_features, n_occupied]
    feature[occupied] = reached.argmax(axis=0)
    best[occupied] = reached.max(axis=0)
    for where, low, high in zip(occupied, first, last + 1, strict=True):
        row = feature[where]
        code[where] = int(key[row, low + purity[row, low:high].argmax()]) % BINS
    return feature, code, best > -np.inf


def project_trees(
    codes: Codes, labels: Int, weights: Float64, slot: Int, n_slots: int, n_actions: int, depth: int
) -> Int:
    """Returns the actions of trees of `depth`, one for each slot and fitted to its points, at every point, [n].

    A point in slot -1 has no tree and gets -1, as do the points of a slot without weight.
    """
    some = np.bincount(slot[slot >= 0], weights[slot >= 0], n_slots) > 0
    inside = np.flatnonzero((slot >= 0) & some[slot])
    said = np.full(len(slot), -1, dtype=np.int64)
    slot, codes = slot[inside], codes[:, inside]
    fitted = np.flatnonzero(weights[inside] > 0)
    own_codes, own_labels, own_weights = codes[:, fitted], labels[inside][fitted], weights[inside][fitted]
    points = np.arange(len(inside))
    for _ in range(depth):
        splits = best_splits(own_codes, own_labels, own_weights, slot[fitted], n_slots, n_actions)
        right = splits.found[slot] & (codes[splits.feature[slot], points] > splits.code[slot])
        slot, n_slots = 2 * slot + right, 2 * n_slots
    totals = np.bincount(slot[fitted] * n_actions + own_labels, own_weights, n_slots * n_actions)
    said[inside] = totals.reshape(n_slots, n_actions).argmax(axis=1)[slot]
    return said


class HistogramTree(GrowingTree):
    """A tree that grows by histograms."""

    def __init__(self, bins: Bins, codes: Codes, labels: Int, counts: Int, n_actions: int, max_depth: int) -> None:
        """`codes`: [n_features, n] of all points; `counts`: [n], how often the agent's data set holds each."""
        super().__init__(labels, counts.astype(np.float64), n_actions, max_depth)
        self.bins, self.codes = bins, codes

    def project(self, slot: Int, depth: int) -> Int:
        """Fits the trees by histograms; see `GrowingTree.project`."""
        return project_trees(self.codes, self.labels, self.counts, slot, len(self.open), self.n_actions, depth)

    def split_leaves(self, slot: Int, keep: Bool) -> list[int]:
        """Splits all open leaves in one pass; see `GrowingTree.split_leaves`."""
        n_slots, inside = len(self.open), slot >= 0
        weights = self.counts * keep
        emptied = np.bincount(slot[inside], weights[inside], n_slots) == 0
        weights = np.where(inside & emptied[slot], self.counts, weights)
        rows = np.flatnonzero(inside & (weights > 0))
        labels, weights = self.labels[rows], weights[rows]
        splits = best_splits(self.codes[:, rows], labels, weights, slot[rows], n_slots, self.n_actions)
        some = splits.totals.sum(axis=1) > 0
        right = self.codes[splits.feature[slot], np.arange(len(slot))] > splits.code[slot]
        parts = np.bincount(
            (2 * slot[rows] + right[rows]) * self.n_actions + labels, weights, 2 * n_slots * self.n_actions
        )
        actions = parts.reshape(n_slots, 2, self.n_actions).argmax(axis=2)
        grown: list[int] = []
        for index, leaf in enumerate(self.open):
            if some[index]:
                self.action[leaf] = int(splits.totals[index].argmax())
            if not splits.found[index]:
                continue
            feature = int(splits.feature[index])
            self.feature[leaf], self.threshold[leaf] = feature, float(self.bins.edges[feature][splits.code[index]])
            left, other = (self.add_leaf(int(action)) for action in actions[index])
            self.children[leaf] = left, other
            grown += [left, other]
        first = np.array([left for left, _ in self.children])
        moved = inside & splits.found[slot]
        self.place = np.where(moved, first[self.place] + right, self.place)
        return grown
