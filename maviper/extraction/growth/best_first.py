"""A tree grown best first under a budget of leaves, from a vector for each point: clusters of action values, or labels.

Does: splits where that raises the purity of the leaves most, until the leaves are spent; a leaf takes the best action
  of its vectors together.
Assumes: for clusters, vectors of action values with one number taken off each, so that only differences between actions
  count; for labels, each point's weight in its action's place; for numbers, see regression.py.
Does not: make vectors.

The purity of a leaf is a function of the sum S of its vectors. Clusters take |S|: the loss of a cluster is the added
cosine distance of its vectors to their centre, each weighted by its length, which is sum |v| - |S|. Labels take
|S|^2 over the weight in the leaf: its loss to the whole weight is the weighted Gini impurity, as in CART. Regrets, as
vectors of what each action costs with the sign turned, take max S: its loss is what the leaf's best action costs.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from codegen.ir import NO_ACTION, NO_CHILD, NO_FEATURE, Float64, GrownTree
from maviper.extraction.growth.histogram import Bins, Codes
from maviper.extraction.selection.progress import count_leaves
from maviper.extraction.selection.stack import merge_leaves
from maviper.worlds.world import Int

LEAST_GAIN = 1e-9  # of the purity of single points: below it a gain is rounding
NEXT = 1e-4  # what clusters of regrets count beside what is saved
Purity = Callable[[Float64], Float64]  # of sums of vectors [..., n_actions], [...]


def cohesion(total: Float64) -> Float64:
    """The purity of clusters."""
    return np.linalg.norm(total, axis=-1)


def gini(total: Float64) -> Float64:
    """The purity of labels; 0 without weight."""
    return np.square(total).sum(axis=-1) / np.maximum(total.sum(axis=-1), np.finfo(np.float64).tiny)


def thrift(total: Float64) -> Float64:
    """The purity of regrets. Where both sides of a split keep the leaf's action nothing is saved, yet splits below may
    save: of such splits the one counts that clusters the regrets best, by so little that a saving goes before it.
    """
    return total.max(axis=-1) + NEXT * cohesion(total)


@dataclass(frozen=True)
class _Leaf:
    """An open leaf and its best split."""

    node: int
    rows: Int  # points in it
    depth: int
    gain: float  # of the split; 0: none
    feature: int
    code: int  # points with a bin up to it go left


class BestFirstTree:
    """A tree while it grows. `codes`: [n_features, n], the bins of all points; `vectors`: [n, n_actions]; `bins`:
    candidate thresholds; `spread`: the purity of single points, None where it is to be computed; `fewest`: points of a
    leaf.
    """

    def __init__(
        self,
        codes: Codes,
        vectors: Float64,
        bins: Bins,
        max_depth: int,
        purity: Purity = cohesion,
        spread: float | None = None,
        fewest: int = 1,
    ) -> None:
        self.codes, self.vectors, self.bins = codes, vectors, bins
        self.max_depth, self.purity, self.fewest = max_depth, purity, fewest
        self.least = LEAST_GAIN * (float(purity(vectors).sum()) if spread is None else spread)
        self.nodes: list[tuple[int, float, int, int, int]] = []  # feature, threshold, left, right, action
        self.open = [self._leaf(np.arange(len(vectors)), 0)]

    def grow_to(self, max_leaves: int) -> GrownTree:
        """The tree with at most so many leaves; of equal gains the older leaf is split."""
        while len(self.open) < max_leaves and self._grow():
            pass
        return self._tree()

    def deciding(self, max_leaves: int) -> GrownTree:
        """The tree with at most so many leaves after siblings of one action are merged: splits that decide nothing
        yet, on which later ones may stand, cost no leaf.
        """
        largest = merge_leaves(self._tree())
        while self._grow():
            tree = merge_leaves(self._tree())
            if count_leaves([tree]) > max_leaves:
                break
            largest = tree
        return largest

    def _tree(self) -> GrownTree:
        return GrownTree(*(np.array(column) for column in zip(*self.nodes, strict=True)))

    def _grow(self) -> bool:
        """Splits the best leaf; False where no split helps."""
        best = max(self.open, key=lambda leaf: leaf.gain)
        if best.gain <= self.least:
            return False
        self._split(best)
        return True

    def _leaf(self, rows: Int, depth: int) -> _Leaf:
        total = self.vectors[rows].sum(axis=0)
        self.nodes.append((NO_FEATURE, 0.0, NO_CHILD, NO_CHILD, int(total.argmax())))
        split = (0.0, NO_FEATURE, 0) if depth == self.max_depth else self._best(rows, total)
        return _Leaf(len(self.nodes) - 1, rows, depth, *split)

    def _best(self, rows: Int, total: Float64) -> tuple[float, int, int]:
        """The split that lowers the loss most; of equals the first feature's lowest threshold."""
        best, vectors, purity = (0.0, NO_FEATURE, 0), self.vectors[rows], self.purity
        for feature, edges in enumerate(self.bins.edges):
            if not len(edges):
                continue
            code, n_codes = self.codes[feature, rows], len(edges) + 1
            sums = [np.bincount(code, column, n_codes) for column in vectors.T]
            left = np.stack(sums, axis=1).cumsum(axis=0)[:-1]
            below = np.bincount(code, minlength=n_codes).cumsum()[:-1]
            gain = purity(left) + purity(total - left) - purity(total)
            gain = np.where((below >= self.fewest) & (below <= len(rows) - self.fewest), gain, 0.0)
            place = int(gain.argmax())
            if gain[place] > best[0]:
                best = (float(gain[place]), feature, place)
        return best

    def _split(self, leaf: _Leaf) -> None:
        goes_left = self.codes[leaf.feature, leaf.rows] <= leaf.code
        left = self._leaf(leaf.rows[goes_left], leaf.depth + 1)
        right = self._leaf(leaf.rows[~goes_left], leaf.depth + 1)
        threshold = float(self.bins.edges[leaf.feature][leaf.code])
        self.nodes[leaf.node] = (leaf.feature, threshold, left.node, right.node, NO_ACTION)
        self.open.remove(leaf)
        self.open += [left, right]
