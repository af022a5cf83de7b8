# pyright: basic
"""A tree grown best first under a budget of leaves, from a vector for each point: action values, labels, or numbers.

Does: splits where that raises the purity of the leaves most, until the leaves are spent; a leaf takes the best action
  of its vectors together, or gives numbers: constants, or sums that ridge regression fits.
Assumes: for clusters, vectors of action values with one number taken off each, so that only differences between actions
  count; for labels, each point's weight in its action's place; for numbers, outputs with both bounds, and counts of
  points, so that a leaf's sums are those of its data set.
Does not: make vectors.

The purity of a leaf is a function of the sum S of its vectors. Clusters take |S|: the loss of a cluster is the added
cosine distance of its vectors to their centre, each weighted by its length, which is sum |v| - |S|. Labels take
|S|^2 over the weight in the leaf: its loss to the whole weight is the weighted Gini impurity, as in CART.

Numbers are learned in parts of their ranges, so that each counts alike. For constants, the purity of a leaf is the
squared sum of its labels over their count: its loss to the sum of all squares is their variance times their count.
Linear leaves take b' G^-1 b, where G are the sums of products of a point's features and 1, and b those with its labels:
what a ridge regression of the leaf explains. The ridge is on all weights but the constant's; it grows with the count,
so that a split never explains less.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from codegen.ir import NO_ACTION, NO_CHILD, NO_FEATURE, Float32, Float64, GrownTree, OutputSpec
from codegen.lowering.deploy import SummedTree
from maviper.extraction.arena import merge_leaves
from maviper.extraction.growth.joint import Bins, Codes
from maviper.extraction.journal import count_leaves
from maviper.extraction.settings import CONSTANT, LINEAR
from maviper.worlds.world import Int, bounds

LEAST_GAIN = 1e-9  # of the purity of single points: below it a gain is rounding
Purity = Callable[[Float64], Float64]  # of sums of vectors [..., n_actions], [...]


def cohesion(total: Float64) -> Float64:
    """The purity of clusters."""
    return np.linalg.norm(total, axis=-1)


def gini(total: Float64) -> Float64:
    """The purity of labels; 0 without weight."""
    return np.square(total).sum(axis=-1) / np.maximum(total.sum(axis=-1), np.finfo(np.float64).tiny)


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
        goes_left = self.codes[best.feature, best.rows] <= best.code
        left = self._leaf(best.rows[goes_left], best.depth + 1)
        right = self._leaf(best.rows[~goes_left], best.depth + 1)
        threshold = float(self.bins.edges[best.feature][best.code])
        self.nodes[best.node] = (best.feature, threshold, left.node, right.node, NO_ACTION)
        self.open.remove(best)
        self.open += [left, right]
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


RIDGE = 1e-3  # in parts of a feature's variance over all points
POINTS_A_WEIGHT = 5  # that a linear leaf must have at least, for each of its weights
BEYOND = 12  # regressions of a linear leaf's points that are not met yet, at most
TINY = 1e-9  # that keeps the equations of few points solvable


class Leaves(ABC):
    """The kind of one agent's leaves. `obs`: [n, n_features], all points; `labels`: [n, n_outputs]."""

    fewest = 1  # points of a leaf

    def __init__(self, obs: Float32, labels: Float32, outputs: Sequence[OutputSpec]) -> None:
        self.low, self.high = bounds(outputs)
        self.range = np.where(self.high > self.low, self.high - self.low, 1.0)
        self.obs = obs.astype(np.float64)
        self.parts = (labels[:, : len(outputs)].astype(np.float64) - self.low) / self.range

    @abstractmethod
    def vectors(self, counts: Int) -> Float64:
        """Returns the vector that each point adds to its leaf, [n, width]. `counts`: [n]."""

    @abstractmethod
    def purity(self, total: Float64) -> Float64:
        """Returns the part of the labels' squares that leaves explain, [...], by their points' sums, [..., width]."""

    @abstractmethod
    def fit_leaf(self, rows: Int, counts: Int) -> Float64:
        """The numbers that a leaf of these points gives, [n_outputs, n_features + 1], the constant last, in the
        outputs' units. `counts`: of the rows.
        """

    def off(self, given: Float64) -> Float64:
        """The squared distance of every point's labels to what a leaf gives, in parts of the ranges; [n]. `given`: as
        of `fit_leaf`.
        """
        numbers = np.clip(self.obs @ given[:, :-1].T + given[:, -1], self.low, self.high)
        return np.square((numbers - self.low) / self.range - self.parts).sum(axis=1)

    def spread(self, counts: Int) -> float:
        """The sum of all squares."""
        return float((np.square(self.parts).sum(axis=1) * counts).sum())

    def _in_units(self, scaled: Float64) -> Float64:
        scaled = scaled * self.range[:, None]
        scaled[:, -1] += self.low
        return scaled


class ConstantLeaves(Leaves):
    """Each leaf gives the means of its labels."""

    def vectors(self, counts: Int) -> Float64:
        """Returns the count, and the labels that many times; see `Leaves.vectors`."""
        return np.column_stack([counts, self.parts * counts[:, None]]).astype(np.float64)

    def purity(self, total: Float64) -> Float64:
        """Returns the part of the labels' squares that constants explain; see `Leaves.purity`."""
        return np.square(total[..., 1:]).sum(axis=-1) / np.maximum(total[..., 0], 1)

    def fit_leaf(self, rows: Int, counts: Int) -> Float64:
        """Returns the mean of the labels, with weights of 0; see `Leaves.fit_leaf`."""
        numbers = np.zeros((self.parts.shape[1], self.obs.shape[1] + 1))
        numbers[:, -1] = counts @ self.parts[rows] / counts.sum()
        return self._in_units(numbers)


class LinearLeaves(Leaves):
    """Each leaf gives sums of its features, by ridge regression of its labels. Features are scaled to a mean of 0 and
    a variance of 1 over all points while they are learned.
    """

    def __init__(self, obs: Float32, labels: Float32, outputs: Sequence[OutputSpec]) -> None:
        super().__init__(obs, labels, outputs)
        self.mean, deviation = self.obs.mean(axis=0), self.obs.std(axis=0)
        self.scale = np.where(deviation > 0, deviation, 1.0)
        self.points = np.column_stack([(self.obs - self.mean) / self.scale, np.ones(len(obs))])
        self.width = self.points.shape[1]
        self.fewest = POINTS_A_WEIGHT * self.width
        self.upper = np.triu_indices(self.width)
        self.ridge = RIDGE * np.diag([1.0] * (self.width - 1) + [0.0])

    def vectors(self, counts: Int) -> Float64:
        """Returns products of scaled features and 1, then those with the labels; see `Leaves.vectors`."""
        rows, columns = self.upper
        products = self.points[:, rows] * self.points[:, columns]
        answers = (self.points[:, :, None] * self.parts[:, None, :]).reshape(len(products), -1)
        return np.column_stack([products, answers]) * counts[:, None]

    def purity(self, total: Float64) -> Float64:
        """Returns the part of the labels' squares that the ridge regression explains; see `Leaves.purity`."""
        rows, columns = self.upper
        products = np.empty((*total.shape[:-1], self.width, self.width))
        products[..., rows, columns] = products[..., columns, rows] = total[..., : len(rows)]
        answers = total[..., len(rows) :].reshape(*total.shape[:-1], self.width, -1)  # products with the labels
        count = np.maximum(products[..., -1:, -1:], 1)  # an empty side explains nothing, whatever it is divided by
        last = np.zeros((self.width, self.width))
        last[-1, -1] = 1.0
        weights = np.linalg.solve(products + count * self.ridge + (products[..., -1:, -1:] < 1) * last, answers)
        return (answers * weights).sum(axis=(-1, -2))

    def fit_leaf(self, rows: Int, counts: Int) -> Float64:
        """Fits a leaf; weights as float32 holds them. A label at a bound is met by any number beyond it, since that is
        clipped: the ridge regression is one of the points that are not met yet, until these stay the same.
        """
        points, parts = self.points[rows], self.parts[rows]
        weights = np.stack([self._beyond(points, column, counts) for column in parts.T])
        numbers = np.empty_like(weights)
        numbers[:, :-1] = (weights[:, :-1] / self.scale * self.range[:, None]).astype(np.float32) / self.range[:, None]
        numbers[:, -1] = weights[:, -1] - numbers[:, :-1] @ self.mean
        return self._in_units(numbers)

    def _beyond(self, points: Float64, labels: Float64, counts: Int) -> Float64:
        """The weights of one output, [width]: the best of some Newton steps."""
        missing, best, least = np.ones(len(points), dtype=bool), np.zeros(self.width), np.inf
        for _ in range(BEYOND):
            some, weighted = points[missing], points[missing].T * counts[missing]
            ridge = counts[missing].sum() * self.ridge + TINY * np.eye(self.width)
            weights = np.linalg.solve(weighted @ some + ridge, weighted @ labels[missing])
            given = points @ weights
            lost = float((np.square(np.clip(given, 0, 1) - labels) * counts).sum())
            if lost < least:
                best, least = weights, lost
            met = ((labels >= 1) & (given >= 1)) | ((labels <= 0) & (given <= 0))
            if (met != missing).all() or met.all():
                break
            missing = ~met
        return best


KINDS: dict[str, type[Leaves]] = {CONSTANT: ConstantLeaves, LINEAR: LinearLeaves}


def grow_tree(leaves: Leaves, counts: Int, codes: Codes, bins: Bins, max_depth: int, max_leaves: int) -> SummedTree:
    """A tree with at most so many leaves that give numbers; it may test more columns than there are features, and
    names none of them. `counts`: [n]; `codes`: [n_columns, n].
    """
    vectors = leaves.vectors(counts)
    purity: Purity = leaves.purity
    growing = BestFirstTree(codes, vectors, bins, max_depth, purity, leaves.spread(counts), leaves.fewest)
    tree, action = growing.grow_to(max_leaves), np.full(len(growing.nodes), -1)
    given: list[Any] = []
    for leaf in growing.open:
        action[leaf.node] = len(given)
        given.append(leaves.fit_leaf(leaf.rows, counts[leaf.rows]))
    assert (np.equal(action, -1) == (tree.feature != NO_FEATURE)).all()
    arrays = tree.feature, tree.threshold, tree.left, tree.right, action
    return SummedTree(*arrays, np.zeros((0, leaves.obs.shape[1]), np.float32), np.array(given))


def testing(tree: GrownTree, pairs: Sequence[tuple[int, int]], n_features: int) -> GrownTree:
    """The tree, whose tests from `n_features` on count in differences of two features, with those that it tests."""
    named = list(dict.fromkeys((tree.feature[tree.feature >= n_features] - n_features).tolist()))
    if not named:
        return tree
    tests = np.zeros((len(named), n_features), np.float32)
    for row, (first, second) in zip(tests, (pairs[each] for each in named), strict=True):
        row[first], row[second] = 1.0, -1.0
    place = {n_features + old: n_features + new for new, old in enumerate(named)}
    feature = np.array([place.get(each, each) for each in tree.feature.tolist()])
    given = tree.given if isinstance(tree, SummedTree) else np.zeros((0, 0, n_features + 1))
    return SummedTree(feature, tree.threshold, tree.left, tree.right, tree.action, tests, given)
