# pyright: basic
"""Every threshold tried: one agent's tree while it grows as scikit-learn's CART does, bit for bit.

Does: searches the best splits of all leaves of a level at once, over columns that are sorted once; asks CART itself
  where leaves are small, or where splits are as good as one another, between which CART draws.
Assumes: data sets as multiplicities of shared points; class counts that are whole numbers, so that sums of them and of
  their squares are exact in any order.
Does not: decide who grows when (joint.py).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from codegen.ir import Bool, Float32, Float64
from maviper.extraction.growth.joint import FEW, GrowingTree
from maviper.worlds.world import Int

APART = np.float32(1e-7)  # values no farther apart count as one, as CART has it
ALIKE = 1e-9  # of a slot's weight: purities no farther apart may be one, by CART's own rounding


@dataclass(frozen=True)
class ExactSplits:
    """The best splits of all slots, those that are as good among them, the first feature's first."""

    slot: Int  # [n_splits]
    feature: Int  # [n_splits]
    threshold: Float64  # [n_splits] points with a value up to it go left

    def first(self, n_slots: int) -> tuple[Int, Bool]:
        """The place of each slot's first split, and whether it is the only one; len(self.slot) where there is none."""
        count, place = np.bincount(self.slot, minlength=n_slots), np.full(n_slots, len(self.slot))
        np.minimum.at(place, self.slot, np.arange(len(self.slot)))
        return place, count <= 1


NO_SPLITS = ExactSplits(np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0))


class Columns:
    """The points of a data set, by the order of each feature's values. `obs`: [n, n_features]; `labels`: [n]."""

    def __init__(self, obs: Float32, labels: Int, n_actions: int) -> None:
        self.values, self.labels, self.n_actions = np.ascontiguousarray(obs.T), labels, n_actions
        self.order = [np.argsort(values) for values in self.values]

    def best_splits(self, weights: Float64, slot: Int, n_slots: int) -> ExactSplits:
        """The splits of least weighted Gini impurity in every slot, of the points that have weight. `weights`, `slot`:
        [n]; in slot -1 are points without one.
        """
        used, n_actions = (slot >= 0) & (weights > 0), self.n_actions
        code = slot * n_actions + self.labels
        counted = np.bincount(code[used], weights[used], n_slots * n_actions).astype(np.float64)
        totals = counted.reshape(n_slots, n_actions)
        weight, squares = totals.sum(axis=1), np.square(totals).sum(axis=1)
        earlier = [np.cumsum(each) - each for each in (counted, weight, squares)]
        impure, alike = (totals > 0).sum(axis=1) > 1, ALIKE * weight
        kind = np.uint16 if counted.size < 2**16 else np.int64  # short ones are sorted in one pass
        code, short = code.astype(kind), slot.astype(kind)
        best = np.full(n_slots, -np.inf)
        found: list[tuple[Any, ...]] = []  # slots, features, purities, values on either side
        for index, (values, order) in enumerate(zip(self.values, self.order, strict=True)):
            rows = order if used.all() else order[used[order]]
            if n_slots > 1:
                rows = rows[np.argsort(short[rows], kind="stable")]
            place, group, here, seen = slot[rows], code[rows], weights[rows], values[rows]
            inner = np.argsort(group, kind="stable")
            own = np.empty(len(rows))  # weight of the own action up to each point
            own[inner] = here[inner].cumsum()
            own -= earlier[0][group]
            below = here.cumsum() - earlier[1][place]
            of_left = (here * (2 * own - here)).cumsum() - earlier[2][place]
            crossed = (here * counted[group]).cumsum() - earlier[2][place]
            above = weight[place] - below
            purity = of_left / below + (squares[place] - 2 * crossed + of_left) / np.maximum(above, 1)
            follows = seen[1:] > seen[:-1] + APART
            purity[:-1][~follows], purity[above <= 0] = -np.inf, -np.inf
            first = np.flatnonzero(np.append(True, place[1:] != place[:-1]))
            best[place[first]] = np.maximum(best[place[first]], np.maximum.reduceat(purity, first))
            near = np.flatnonzero((purity >= (best - alike)[place]) & (purity > -np.inf) & impure[place])
            found.append((place[near], np.full(len(near), index), purity[near], seen[near], seen[near + 1]))
        place, feature, purity, low, high = map(np.concatenate, zip(*found, strict=True))
        kept = purity >= (best - alike)[place]
        low, high = low[kept].astype(np.float64), high[kept].astype(np.float64)
        middle = low / 2 + high / 2  # as CART has it
        return ExactSplits(place[kept], feature[kept], np.where(middle == high, low, middle))


class CartTree(GrowingTree):
    """A tree that grows as CART's does."""

    def __init__(self, obs: Float32, labels: Int, counts: Int, n_actions: int, max_depth: int, seed: int) -> None:
        """`obs`: [n, n_features]; `labels`: [n]; `counts`: [n], how often the agent's data set holds each point;
        `seed`: for ties between features.
        """
        super().__init__(labels, counts, n_actions, max_depth)
        self.obs, self.seed, self.own = obs, seed, np.flatnonzero(counts)
        self.columns = Columns(obs[self.own], labels[self.own], n_actions) if np.isfinite(obs).all() else None

    def _majority(self, rows: Int) -> int:
        return int(np.argmax(np.bincount(self.labels[rows], self.counts[rows], self.n_actions)))

    def _fit(self, rows: Int, max_depth: int) -> Any:
        return cart(self.obs[rows], self.labels[rows], self.counts[rows], max_depth, self.seed)

    def _large(self, slot: Int, parts: int) -> Bool:
        """The open leaves whose points are enough for so many parts, to be searched at once."""
        known = np.bincount(slot[self.own][slot[self.own] >= 0], minlength=len(self.open))
        return (known >= FEW * parts) & (self.columns is not None)

    def project(self, slot: Int, depth: int) -> Int:
        """Fits large leaves' trees at once, others by CART; see `GrowingTree.project`."""
        said, sure = self._project(slot, depth)
        for place in np.flatnonzero(~sure):
            here = np.flatnonzero(slot == place)
            own = here[self.counts[here] > 0]
            if own.size:
                said[here] = self._fit(own, depth).predict(self.obs[here])
        return said

    def _project(self, slot: Int, depth: int) -> tuple[Int, Bool]:
        """The actions of trees of `depth`, one for each open leaf and fitted to its points, at every point, [n], -1
        where there is none; and the leaves whose trees are surely CART's.
        """
        sure, said = self._large(slot, 2**depth), np.full(len(slot), -1, dtype=np.int64)
        if self.columns is None or not sure.any():
            return said, sure
        inside = np.flatnonzero((slot >= 0) & sure[slot])
        weights, slot = self.counts[self.own].astype(np.float64), np.where(sure[slot], slot, -1)
        n_slots = len(sure)
        for _ in range(depth):
            splits = self.columns.best_splits(weights, slot[self.own], n_slots)
            first, alone = splits.first(n_slots)
            here = slot[inside]
            feature, threshold = np.append(splits.feature, 0)[first], np.append(splits.threshold, np.inf)[first]
            right = self.obs[inside, feature[here]] > threshold[here]
            # which of two CART draws is all the same where all points go the same way by either
            for place in np.flatnonzero(~alone[splits.slot]):
                whose = splits.slot[place]
                leaf, among = whose * len(sure) // n_slots, here == whose
                if sure[leaf]:
                    otherwise = self.obs[inside[among], splits.feature[place]] > splits.threshold[place]
                    sure[leaf] = (otherwise == right[among]).all()
            slot[inside], n_slots = 2 * here + right, 2 * n_slots
        own = self.own[slot[self.own] >= 0]
        code = slot[own] * self.n_actions + self.labels[own]
        totals = np.bincount(code, self.counts[own], n_slots * self.n_actions)
        said[inside] = totals.reshape(n_slots, -1).argmax(axis=1)[slot[inside]]
        return np.where((slot >= 0) & sure[slot >> depth], said, -1), sure

    def split_leaves(self, slot: Int, keep: Bool) -> list[int]:
        """Searches large leaves at once, others by CART; see `GrowingTree.split_leaves`."""
        grown: list[int] = []
        kept = (self.counts > 0) & keep
        emptied = np.bincount(slot[kept][slot[kept] >= 0], minlength=len(self.open)) == 0
        kept |= (self.counts > 0) & emptied[slot]
        large, found = self._large(slot, 1), NO_SPLITS
        if self.columns is not None and large.any():
            found = self.columns.best_splits((self.counts * kept)[self.own], slot[self.own], len(large))
        first, alone = found.first(len(large))
        for index, leaf in enumerate(self.open):
            here = np.flatnonzero(self.place == leaf)
            rows = here[kept[here]]
            if not rows.size:
                continue
            self.action[leaf] = self._majority(rows)
            place = int(first[index])
            if large[index] and alone[index]:
                split = (found.feature[place], found.threshold[place]) if place < len(found.slot) else None
            else:
                stump = self._fit(rows, 1).tree_
                split = (stump.feature[0], np.float64(stump.threshold[0])) if stump.node_count > 1 else None
            if split is not None:
                feature, threshold = split
                # float32 against float64, as scikit-learn compares; numpy would round a Python float to float32 first
                goes_left = self.obs[:, feature] <= threshold
                left, right = (self.add_leaf(self._majority(rows[side[rows]])) for side in (goes_left, ~goes_left))
                self.feature[leaf], self.threshold[leaf] = int(feature), float(threshold)
                self.children[leaf] = left, right
                self.place[here] = np.where(goes_left[here], left, right)
                grown += [left, right]
        return grown


def cart(obs: Float32, labels: Int, counts: Int, max_depth: int, seed: int) -> Any:
    """scikit-learn's tree of the points `obs` [n, n_features], each `counts` times. That arguments are what they are
    declared to be it looks up at each fit, which takes longer than a fit to a few points.
    """
    from sklearn import config_context
    from sklearn.tree import DecisionTreeClassifier

    obs = np.ascontiguousarray(obs, dtype=np.float32)
    tree = DecisionTreeClassifier(max_depth=max_depth, random_state=seed)
    with config_context(skip_parameter_validation=True):
        return tree.fit(obs, labels, sample_weight=counts, check_input=not bool(np.isfinite(obs).all()))
