"""Joint growth as the authors' released code does it.

Does: nodes are filtered when they are made, on what their ancestors kept; projected trees learn from filtered points.
Assumes: data sets as multiplicities of shared points.
Does not: choose data or judge trees.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from codegen.ir import NO_ACTION, NO_CHILD, NO_FEATURE, Bool, Float32, Float64, GrownTree
from maviper.extraction.growth.grow import cart
from maviper.worlds.world import Int

FEWEST = 2  # points that a node needs


class _Node:
    """A node: the filtered points that made it, its class, its projected tree, and in time its split."""

    def __init__(self, rows: Int, depth: int, action: int, projected: Any) -> None:
        self.rows, self.depth, self.action, self.projected = rows, depth, action, projected
        self.feature, self.threshold = NO_FEATURE, 0.0
        self.left: _Node | None = None
        self.right: _Node | None = None


class _Growing:
    """One agent's tree while it grows."""

    def __init__(self, obs: Float32, labels: Int, counts: Int, n_actions: int, max_depth: int, seed: int) -> None:
        self.obs, self.labels, self.counts = obs, labels, counts
        self.n_actions, self.max_depth, self.seed = n_actions, max_depth, seed
        self.everything = np.flatnonzero(counts)
        self.root: _Node | None = None
        self.whole = self._fit(self.everything, max_depth)  # predicts until there is a root

    def _fit(self, rows: Int, depth: int) -> Any:
        return cart(self.obs[rows], self.labels[rows], self.counts[rows], depth, self.seed)

    def right(self) -> Bool:
        """Returns True for each point that is predicted as the expert acts, [n]."""
        if self.root is None:
            return np.equal(self.whole.predict(self.obs), self.labels)
        said = np.empty(len(self.obs), dtype=np.int64)
        stack = [(self.root, np.arange(len(self.obs)))]
        while stack:
            node, here = stack.pop()
            if not here.size:
                continue
            if node.left is not None and node.right is not None:
                goes_left = self.obs[here, node.feature] < node.threshold
                stack += [(node.left, here[goes_left]), (node.right, here[~goes_left])]
            else:
                said[here] = node.action if node.projected is None else node.projected.predict(self.obs[here])
        return np.equal(said, self.labels)

    def make_node(self, rows: Int, depth: int, keep: Bool) -> _Node:
        """A node from the points that reach it, filtered; from all of them where none is left."""
        kept = rows[keep[rows]]
        rows = kept if kept.size else rows
        action = int(np.bincount(self.labels[rows], self.counts[rows], self.n_actions).argmax())
        projected = None if depth >= self.max_depth else self._fit(rows, max(1, self.max_depth - depth))
        return _Node(rows, depth, action, projected)

    def grow(self, level: int, keep: Bool) -> None:
        """A pass: makes the root, or splits every node above `level` that has no children; the root is made anew first
        where it has none.
        """
        if self.root is None or (level == 1 and self.root.left is None):
            self.root = self.make_node(self.everything, 0, keep)
        stack = [self.root]
        while stack:
            node = stack.pop()
            if node.depth >= level:
                continue
            if node.left is None or node.right is None:
                self._split(node, keep)
            else:
                stack += [node.right, node.left]

    def _split(self, node: _Node, keep: Bool) -> None:
        split = best_split(self.obs[node.rows], self.labels[node.rows], self.counts[node.rows], self.n_actions)
        if split is None:
            return
        node.feature, node.threshold = split
        goes_left = self.obs[node.rows, node.feature] < node.threshold
        parts = node.rows[goes_left], node.rows[~goes_left]
        if all(self.counts[part].sum() >= FEWEST for part in parts):
            node.left, node.right = (self.make_node(part, node.depth + 1, keep) for part in parts)

    def tree(self) -> GrownTree:
        """The tree grown so far; "less goes left" is "at most the float64 before it"."""
        rows: list[list[float]] = []

        def add(node: _Node) -> int:
            place = len(rows)
            rows.append([NO_FEATURE, 0.0, NO_CHILD, NO_CHILD, node.action])
            if node.left is not None and node.right is not None:
                before = float(np.nextafter(node.threshold, -np.inf))
                rows[place] = [node.feature, before, add(node.left), add(node.right), NO_ACTION]
            return place

        assert self.root is not None
        add(self.root)
        return GrownTree(*(np.array(column) for column in zip(*rows, strict=True)))


def best_split(obs: Float32, labels: Int, counts: Int, n_actions: int) -> tuple[int, float] | None:
    """The split of least weighted Gini impurity among the midpoints of neighbouring values, if it is an improvement;
    of equals the first feature's lowest.
    """
    weights = np.eye(n_actions)[labels] * counts[:, None]
    totals = weights.sum(axis=0)
    best, split = _purity(totals[None])[0] + 1e-9, None  # strictly better
    for feature, column in enumerate(np.ascontiguousarray(obs.T)):
        order = np.argsort(column, kind="stable")
        values = column[order].astype(np.float64)
        left = weights[order].cumsum(axis=0)[:-1]
        purity = np.where(values[1:] > values[:-1], _purity(left) + _purity(totals - left), -np.inf)
        if len(purity) and purity.max() > best:
            place = int(purity.argmax())
            best, split = purity[place], (feature, float((values[place] + values[place + 1]) / 2))
    return split


def _purity(counts: Float64) -> Float64:
    """Summed squares of class counts over their sum, per row; the impurity of two parts falls as theirs rises."""
    return np.square(counts).sum(axis=1) / np.maximum(counts.sum(axis=1), 1e-300)


def grow_team(
    observations: Sequence[Float32],
    labels: Int,
    counts: Sequence[Int],
    n_actions: Sequence[int],
    max_depth: int,
    rng: np.random.Generator,
    predicts: bool,
    alive: Bool,
) -> list[GrownTree]:
    """The trees of one team of N agents over n shared points. `observations`: per agent [n, n_features]; `labels`,
    `alive`: [n, N]; `counts`: per agent [n], how often its data set holds each point; `predicts`: whether points are
    filtered by votes. Who takes no part in a point has no vote.
    """
    team = [
        _Growing(obs, labels[:, agent], counts[agent], n_actions[agent], max_depth, int(rng.integers(2**31)))
        for agent, obs in enumerate(observations)
    ]
    keep = np.ones(len(labels), dtype=bool)
    for level in range(max_depth + 1):
        for agent in map(int, rng.permutation(len(team))):
            if predicts:  # more than half of the team
                right = [member.right() & votes for member, votes in zip(team, alive.T, strict=True)]
                keep = 2 * np.sum(right, axis=0) > alive.sum(axis=1)
            team[agent].grow(level, keep)
    return [member.tree() for member in team]
