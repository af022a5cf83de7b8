"""A tree whose leaves are clusters of action values, grown best first under a budget of leaves.

Does: splits where that lowers the clustering loss most, until the leaves are spent; a leaf takes its centre's best
  action.
Assumes: vectors of action values with one number taken off each, so that only differences between actions count.
Does not: make vectors.

The loss of a cluster is the summed cosine distance of its vectors to their centre, each weighted by its length. With
the centre along the sum S of the vectors that is sum |v| - |S|, so a split lowers it by |S left| + |S right| - |S|.
"""

from dataclasses import dataclass

import numpy as np

from codegen.ir import NO_ACTION, NO_CHILD, NO_FEATURE, Float32, Float64, GrownTree
from maviper.extraction.growth.histogram import Bins, Codes
from maviper.worlds.world import Int

LEAST_GAIN = 1e-9  # of the summed lengths: below it a gain is rounding


@dataclass(frozen=True)
class _Leaf:
    """An open leaf and its best split."""

    node: int
    rows: Int  # points in it
    depth: int
    gain: float  # of the split; 0: none
    feature: int
    code: int  # points with a bin up to it go left


class ClusterTree:
    """A tree while it grows. `obs`: [n, n_features]; `vectors`: [n, n_actions]; `bins`: candidate thresholds."""

    def __init__(self, obs: Float32, vectors: Float64, bins: Bins, max_depth: int) -> None:
        self.vectors, self.bins, self.max_depth = vectors, bins, max_depth
        self.codes: Codes = bins.codes(obs)
        self.least = LEAST_GAIN * float(np.linalg.norm(vectors, axis=1).sum())
        self.nodes: list[tuple[int, float, int, int, int]] = []  # feature, threshold, left, right, action
        self.open = [self._leaf(np.arange(len(obs)), 0)]

    def grown(self, max_leaves: int) -> GrownTree:
        """The tree with at most so many leaves; of equal gains the older leaf is split."""
        while len(self.open) < max_leaves:
            best = max(self.open, key=lambda leaf: leaf.gain)
            if best.gain <= self.least:
                break
            self._split(best)
        return GrownTree(*(np.array(column) for column in zip(*self.nodes, strict=True)))

    def _leaf(self, rows: Int, depth: int) -> _Leaf:
        total = self.vectors[rows].sum(axis=0)
        self.nodes.append((NO_FEATURE, 0.0, NO_CHILD, NO_CHILD, int(total.argmax())))
        split = (0.0, NO_FEATURE, 0) if depth == self.max_depth else self._best(rows, total)
        return _Leaf(len(self.nodes) - 1, rows, depth, *split)

    def _best(self, rows: Int, total: Float64) -> tuple[float, int, int]:
        """The split that lowers the loss most; of equals the first feature's lowest threshold."""
        found, vectors = (0.0, NO_FEATURE, 0), self.vectors[rows]
        for feature, edges in enumerate(self.bins.edges):
            if not len(edges):
                continue
            code, n_codes = self.codes[feature, rows], len(edges) + 1
            sums = [np.bincount(code, column, n_codes) for column in vectors.T]
            left = np.stack(sums, axis=1).cumsum(axis=0)[:-1]
            below = np.bincount(code, minlength=n_codes).cumsum()[:-1]
            gain = np.linalg.norm(left, axis=1) + np.linalg.norm(total - left, axis=1) - np.linalg.norm(total)
            gain = np.where((below > 0) & (below < len(rows)), gain, 0.0)
            place = int(gain.argmax())
            if gain[place] > found[0]:
                found = (float(gain[place]), feature, place)
        return found

    def _split(self, leaf: _Leaf) -> None:
        goes_left = self.codes[leaf.feature, leaf.rows] <= leaf.code
        left = self._leaf(leaf.rows[goes_left], leaf.depth + 1)
        right = self._leaf(leaf.rows[~goes_left], leaf.depth + 1)
        threshold = float(self.bins.edges[leaf.feature][leaf.code])
        self.nodes[leaf.node] = (leaf.feature, threshold, left.node, right.node, NO_ACTION)
        self.open.remove(leaf)
        self.open += [left, right]
