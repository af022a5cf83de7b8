# pyright: basic
"""Joint tree growing: the trees of a team grow level by level and predict one another (paper, TrainJointTrees).

Does: Build (vote filter, best split) and Predict (projected trees), both over all points of a level at once.
Assumes: scikit-learn's CART for single splits and for projected trees; data sets as multiplicities of shared points.
Does not: choose data or judge trees.

Reading of the paper: the vote counts every member of the team, i itself too; a point of D_i counts at a level when at
least N - 1 of N members, or as many as are asked for, are predicted right (who has left there is never wrong); removals
last for that level only; a node left without points uses its unfiltered ones. A projected tree has the remaining depth
and learns from the node's unfiltered points. Where no depth remains there is none: a finished tree votes by its own
leaves.
"""

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

from codegen.ir import NO_ACTION, NO_CHILD, NO_FEATURE, Bool, Float32, Float64, GrownTree
from maviper.worlds.games.particle import Int


class CartTree:
    """One agent's tree while it grows, every threshold tried. Nodes are numbered as they are made: level by level."""

    def __init__(self, obs: Float32, labels: Int, counts: Int, n_actions: int, max_depth: int, seed: int) -> None:
        """`obs`: [n, n_features]; `labels`: [n]; `counts`: [n], how often the agent's data set holds each point;
        `seed`: for ties between features.
        """
        self.obs, self.labels, self.counts = obs, labels, counts
        self.n_actions, self.max_depth, self.seed = n_actions, max_depth, seed
        self.feature: list[int] = []
        self.threshold: list[float] = []
        self.children: list[tuple[int, int]] = []
        self.action: list[int] = []
        self.place = np.zeros(len(obs), dtype=np.int64)  # the leaf that each point is in
        self.open = [self._leaf(np.flatnonzero(counts))]  # leaves of the current level that may still split
        self.level = 0
        self._right: Bool | None = None  # cached until the tree grows

    def _leaf(self, rows: Int) -> int:
        self.feature.append(NO_FEATURE)
        self.threshold.append(0.0)
        self.children.append((NO_CHILD, NO_CHILD))
        self.action.append(self._majority(rows))
        return len(self.feature) - 1

    def _majority(self, rows: Int) -> int:
        return int(np.argmax(np.bincount(self.labels[rows], self.counts[rows], self.n_actions)))

    def _fit(self, rows: Int, max_depth: int) -> Any:
        return cart(self.obs[rows], self.labels[rows], self.counts[rows], max_depth, self.seed)

    def check_predictions(self) -> Bool:
        """Predict for all points: does the projected final tree act as the expert does? [n]"""
        if self._right is None:
            predicted = np.array(self.action)[self.place]
            remaining = self.max_depth - self.level
            for leaf in self.open if remaining else ():
                here = np.flatnonzero(self.place == leaf)
                own = here[self.counts[here] > 0]
                if here.size and own.size:
                    predicted[here] = self._fit(own, remaining).predict(self.obs[here])
            self._right = np.equal(predicted, self.labels)
        return self._right

    def build(self, keep: Bool) -> None:
        """Grows one level: splits every open leaf on its kept points. `keep`: [n]."""
        grown: list[int] = []
        for leaf in self.open:
            here = np.flatnonzero(self.place == leaf)
            own = here[self.counts[here] > 0]
            kept = own[keep[own]]
            rows = kept if kept.size else own
            if rows.size:
                grown += self._split(leaf, here, rows)
        self.open = grown
        self.level += 1
        self._right = None

    def _split(self, leaf: int, here: Int, rows: Int) -> list[int]:
        """Splits a leaf where that lowers the impurity of `rows`; returns the new leaves."""
        self.action[leaf] = self._majority(rows)
        stump = self._fit(rows, 1).tree_
        if stump.node_count == 1:
            return []
        feature, threshold = int(stump.feature[0]), np.float64(stump.threshold[0])
        # float32 against float64, as scikit-learn compares; numpy would round a Python float to float32 first
        goes_left = self.obs[:, feature] <= threshold
        children = (self._leaf(rows[goes_left[rows]]), self._leaf(rows[~goes_left[rows]]))
        self.feature[leaf], self.threshold[leaf], self.children[leaf] = feature, float(threshold), children
        self.place[here] = np.where(goes_left[here], *children)
        return list(children)

    def tree(self) -> GrownTree:
        """The tree grown so far."""
        return build_tree(self.feature, self.threshold, self.children, self.action)


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


class Growing(Protocol):
    """A tree that grows level by level, over points that the team shares."""

    labels: Int  # [n]

    @property
    def counts(self) -> Int | Float64:
        """The count of each point in its data set, [n]."""
        ...

    def check_predictions(self) -> Bool:
        """Returns True for the points, of all [n], in which the projected final tree acts as the expert does."""
        ...

    def build(self, keep: Bool) -> None:
        """Grows one level, on the points that are kept [n]."""
        ...

    def tree(self) -> GrownTree:
        """The tree grown so far."""
        ...


def grow_jointly(
    team: Sequence[Growing],
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
    tree: Growing, max_depth: int, least_right: int, alive: Bool, kept: list[float] | None = None
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


def build_tree(
    feature: Sequence[int], threshold: Sequence[float], children: Sequence[tuple[int, int]], action: Sequence[int]
) -> GrownTree:
    """A tree from lists over its nodes; `action` has an entry for splits too, which counts for nothing."""
    split = np.array(feature) != NO_FEATURE
    left, right = zip(*children, strict=True)
    action_ = np.where(split, NO_ACTION, action)
    return GrownTree(np.array(feature), np.array(threshold), np.array(left), np.array(right), action_)
