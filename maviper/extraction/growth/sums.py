"""Tests of sums, by tree alternating optimisation (Carreira-Perpinan and Tavallali, NeurIPS 2018).

Does: goes through a grown tree from its lowest splits to the root, again and again. Each split becomes the test that
  sends its points to the side that serves them better, a sum of few features where that pays; leaves are fitted anew.
Assumes: a tree that was grown on these points, and what each leaf would lose at each of them (Answers).
Does not: add leaves. A split that all points pass on one side goes.

At a split a point cares whose loss differs between the two subtrees as they are. Its side is learned by logistic
regression with a ridge, each point weighing as much as it cares; then terms are left out, the smallest first. Every
candidate gets the threshold that loses least, and each of its terms costs TERM.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from codegen.ir import NO_ACTION, NO_CHILD, NO_FEATURE, ROOT, Bool, Float32, Float64, Floats, GrownTree
from codegen.lowering.deploy import SummedTree
from maviper.extraction.arena import merge_leaves
from maviper.extraction.growth.best_first import Leaves
from maviper.worlds.world import Int

SWEEPS = 4  # at most, from the lowest splits to the root
TERM = 1e-3  # what a term costs, in parts of what one leaf for all points would lose
POINTS = 20_000  # that a test is learned from, at most
STEPS = 4  # of Newton's method for a logistic regression
RIDGE = 1e-3  # of its weights, in parts of what all points weigh


class Answers(Protocol):
    """The answers that leaves may give."""

    def losses(self, rows: Sequence[Int]) -> Float64:
        """Returns the loss of each leaf, fitted to its own rows, at every point; [n_leaves, n]."""
        ...


@dataclass(frozen=True)
class Labels:
    """Leaves take an action. `labels`, `counts`: [n]."""

    labels: Int
    counts: Int
    n_actions: int

    def actions(self, rows: Sequence[Int]) -> Int:
        """The most frequent label of each leaf's rows, [n_leaves]."""
        majorities = [np.bincount(self.labels[each], self.counts[each], self.n_actions).argmax() for each in rows]
        return np.array(majorities, dtype=np.int64)

    def losses(self, rows: Sequence[Int]) -> Float64:
        """Returns the count of each point with another label than the leaf's; see `Answers.losses`."""
        return (self.actions(rows)[:, None] != self.labels) * self.counts.astype(np.float64)


@dataclass(frozen=True)
class Numbers:
    """Leaves give numbers. `counts`: [n]."""

    leaves: Leaves
    counts: Int

    def fit_leaves(self, rows: Sequence[Int]) -> Float64:
        """Fits each leaf's numbers, [n_leaves, n_outputs, n_features + 1]."""
        return np.array([self.leaves.fit_leaf(each, self.counts[each]) for each in rows])

    def losses(self, rows: Sequence[Int]) -> Float64:
        """Returns squared distances in parts of the ranges, of clipped numbers; see `Answers.losses`."""
        return np.array([self.leaves.off(each) for each in self.fit_leaves(rows)]) * self.counts


@dataclass(frozen=True)
class Test:
    """`weights . x <= threshold` goes left. `weights`: [n_features]."""

    weights: Float64
    threshold: float

    @property
    def terms(self) -> int:
        """The number of features that it tests."""
        return int(np.count_nonzero(self.weights))

    def left(self, obs: Float64) -> Bool:
        """Returns True for the points that go left, [n]."""
        return obs @ self.weights <= self.threshold


@dataclass
class _Nodes:
    """The tree while it changes; children come after their parents."""

    tests: dict[int, Test]
    left: list[int]
    right: list[int]

    @staticmethod
    def of(tree: GrownTree, n_features: int) -> "_Nodes":
        tests: dict[int, Test] = {}
        for node in np.flatnonzero(tree.feature != NO_FEATURE).tolist():
            feature, weights = int(tree.feature[node]), np.zeros(n_features)
            if feature >= n_features:
                assert isinstance(tree, SummedTree)
                weights[:] = tree.tests[feature - n_features]
            else:
                weights[feature] = 1.0
            tests[node] = Test(weights, float(tree.threshold[node]))
        return _Nodes(tests, tree.left.tolist(), tree.right.tolist())

    def reaching(self, obs: Float64) -> list[Int]:
        """The points that pass each node, those of nodes that nobody passes among them."""
        rows: list[Int] = [np.arange(0)] * len(self.left)
        rows[ROOT] = np.arange(len(obs))
        for node in self.down():
            goes = self.tests[node].left(obs[rows[node]])
            rows[self.left[node]], rows[self.right[node]] = rows[node][goes], rows[node][~goes]
        return rows

    def down(self) -> Iterator[int]:
        """The splits, parents first."""
        stack = [ROOT]
        while stack:
            node = stack.pop()
            if node in self.tests:
                yield node
                stack += [self.left[node], self.right[node]]

    def leaves(self) -> list[int]:
        """The leaves that the root leads to."""
        below = [child for node in self.down() for child in (self.left[node], self.right[node])]
        return [node for node in below or [ROOT] if node not in self.tests]


def optimise_tests(tree: GrownTree, obs: Float32, answers: Labels | Numbers) -> GrownTree:
    """The tree with tests of sums, its leaves fitted to the points that reach them. `obs`: [n, n_features]."""
    wide = obs.astype(np.float64)
    nodes, spread = _Nodes.of(tree, wide.shape[1]), wide.std(axis=0)
    price = TERM * float(answers.losses([np.arange(len(wide))]).sum())
    before = np.inf
    for _ in range(SWEEPS):
        _prune_nodes(nodes, wide)
        rows, leaves = nodes.reaching(wide), nodes.leaves()
        # what each point would lose below each node
        below = dict(zip(leaves, answers.losses([rows[leaf] for leaf in leaves]), strict=True))
        for node in [*nodes.down()][::-1]:
            here, (one, other) = rows[node], (below.pop(nodes.left[node]), below.pop(nodes.right[node]))
            better, swap = _better(nodes.tests[node], wide[here], one[here], other[here], spread, price)
            nodes.tests[node] = better
            if swap:
                nodes.left[node], nodes.right[node], one, other = nodes.right[node], nodes.left[node], other, one
            below[node] = np.where(better.left(wide), one, other)
        total = float(below[ROOT].sum()) + price * sum(test.terms for test in nodes.tests.values())
        if total >= before - price:
            break
        before = total
    _prune_nodes(nodes, wide)
    return _build_tree(nodes, wide, answers)


def _prune_nodes(nodes: _Nodes, obs: Float64) -> None:
    """Takes away splits that all points pass on one side."""
    changed = True
    while changed:
        rows, changed = nodes.reaching(obs), False
        for node in list(nodes.down()):
            sides = nodes.left[node], nodes.right[node]
            empty = [not len(rows[side]) for side in sides]
            if any(empty):
                kept = sides[0] if empty[1] else sides[1]
                del nodes.tests[node]
                if kept in nodes.tests:
                    nodes.tests[node] = nodes.tests.pop(kept)
                    nodes.left[node], nodes.right[node] = nodes.left[kept], nodes.right[kept]
                changed = True
                break


def _better(test: Test, obs: Float64, one: Float64, other: Float64, spread: Float64, price: float) -> tuple[Test, bool]:
    """The test that loses least, where `one` is lost on the left and `other` on the right, [n] each; and whether it is
    for exchanged children.
    """
    care = one - other  # above 0: better on the right
    cares = np.flatnonzero(care)
    if not len(cares):
        return test, False
    if len(cares) > POINTS:
        cares = cares[np.linspace(0, len(cares) - 1, POINTS).astype(np.int64)]
    best, swapped, share = test, False, len(cares) / np.count_nonzero(care)  # terms cost less beside a sample of points
    least = float(care[cares][test.left(obs[cares])].sum()) + price * test.terms * share
    seen, wanted = obs[cares], care[cares]
    for weights in _directions(seen, wanted, spread):
        for sign in (1.0, -1.0) if np.count_nonzero(weights) == 1 else (1.0,):
            threshold, lost = _threshold(seen @ weights, sign * wanted)
            lost += (sign < 0) * float(wanted.sum())
            candidate = Test(weights, threshold)
            lost += price * candidate.terms * share
            if lost < least - 1e-9 * price:
                best, swapped, least = candidate, sign < 0, lost
    return best, swapped


def _threshold(values: Float64, care: Float64) -> tuple[float, float]:
    """The threshold for which least is lost by going left, and what is: the sum of `care` up to it."""
    order = np.argsort(values, kind="stable")
    ordered, lost = values[order], np.cumsum(care[order])
    ends = np.flatnonzero(ordered[1:] > ordered[:-1])
    if not len(ends):
        return float(ordered[-1]), float(lost[-1])
    place = ends[lost[ends].argmin()]
    low, high = float(ordered[place]), float(ordered[place + 1])
    middle = (low + high) / 2
    return middle if middle < high else low, float(lost[place])


def _directions(obs: Float64, care: Float64, spread: Float64) -> Iterator[Float64]:
    """Weights that are worth a try, the largest 1 or -1: each feature alone, then sums of ever fewer."""
    used = np.flatnonzero(spread > 0)
    yield from np.eye(obs.shape[1])[used]
    scale = np.where(spread > 0, spread, 1.0)
    scaled = (obs - obs.mean(axis=0)) / scale
    chosen = used
    while len(chosen) > 1:
        fitted = _logistic(scaled[:, chosen], care)
        if len(chosen) <= TERMS:
            weights = np.zeros(obs.shape[1])
            weights[chosen] = fitted / scale[chosen]
            if (largest := np.abs(weights).max()) > 0:
                rounded = np.asarray(np.round(weights / largest, DIGITS), dtype=np.float64)
                if np.count_nonzero(rounded) > 1:
                    yield rounded.astype(np.float32).astype(np.float64)
        kept = min(TERMS, len(chosen) - 1)
        chosen = np.sort(chosen[np.argsort(-np.abs(fitted), kind="stable")[:kept]])


def _logistic(scaled: Float64, care: Float64) -> Float64:
    """Weights whose sum is large where points had better go right, [n_features]."""
    points = np.asarray(np.column_stack([scaled, np.ones(len(scaled))]), dtype=np.float64)
    side, weight = (care > 0).astype(np.float64), np.abs(care) / np.abs(care).sum()
    fitted = np.zeros(scaled.shape[1] + 1)
    ridge = RIDGE * np.eye(points.shape[1])
    for _ in range(STEPS):
        chance = 1 / (1 + np.exp(-np.clip(points @ fitted, -30, 30)))
        slope = points.T @ (weight * (chance - side)) + ridge @ fitted
        curve = (points.T * (weight * np.maximum(chance * (1 - chance), 1e-3))) @ points + ridge
        fitted = fitted - np.asarray(np.linalg.solve(curve, slope), dtype=np.float64)
    return fitted[:-1]


def _build_tree(nodes: _Nodes, obs: Float64, answers: Labels | Numbers) -> GrownTree:
    """The tree, with leaves for the points that reach them."""
    rows, leaves, n = nodes.reaching(obs), nodes.leaves(), obs.shape[1]
    size = len(nodes.left)
    feature, threshold, action = np.full(size, NO_FEATURE), np.zeros(size), np.full(size, NO_ACTION)
    left, right = np.full(size, NO_CHILD), np.full(size, NO_CHILD)
    tests: list[Float64] = []
    for node, test in nodes.tests.items():
        single = np.flatnonzero(test.weights)
        threshold[node], left[node], right[node] = test.threshold, nodes.left[node], nodes.right[node]
        if len(single) == 1 and test.weights[single[0]] == 1:
            feature[node] = single[0]
        else:
            feature[node] = n + len(tests)
            tests.append(test.weights)
    numbers = isinstance(answers, Numbers)
    action[leaves] = range(len(leaves)) if numbers else answers.actions([rows[leaf] for leaf in leaves])
    plain = merge_leaves(GrownTree(feature, threshold, left, right, action))
    if not tests and not numbers:
        return plain
    given = answers.fit_leaves([rows[leaf] for leaf in leaves]) if numbers else np.zeros((0, 0, n + 1))
    arrays = plain.feature, plain.threshold, plain.left, plain.right, plain.action
    return SummedTree(*arrays, np.array(tests, np.float32).reshape(-1, n), given)


TERMS = 4  # of a sum, at most
DIGITS = 2  # of a weight, whose sum's largest is 1
TILTS = (0.2, 1.0)  # how far a weight goes, in deviations of what is tested
TRIED = 3  # of a split


def as_summed(tree: GrownTree, n_features: int) -> SummedTree:
    """The tree as one that may test sums, with no other sums than it tests."""
    if not isinstance(tree, SummedTree):
        arrays = tree.feature, tree.threshold, tree.left, tree.right, tree.action
        return SummedTree(*arrays, np.zeros((0, n_features), np.float32), np.zeros((0, 0, n_features + 1)))
    tested = np.unique(tree.feature[tree.feature >= n_features])
    place = dict(zip(tested.tolist(), range(n_features, n_features + len(tested)), strict=True))
    feature = np.array([place.get(each, each) for each in tree.feature.tolist()], tree.feature.dtype)
    return replace(tree, feature=feature, tests=tree.tests[tested - n_features])


def with_own_sums(tree: GrownTree, n_features: int) -> SummedTree:
    """The tree with a sum of its own for each split that tests one, so that one may change without the others."""
    tree = as_summed(tree, n_features)
    summed, feature = np.flatnonzero(tree.feature >= n_features), tree.feature.copy()
    feature[summed] = n_features + np.arange(len(summed))
    return replace(tree, feature=feature, tests=tree.tests[tree.feature[summed] - n_features])


def columns_of(tree: SummedTree, obs: Float32) -> Float64:
    """Returns the columns that it may test, [n, n_features + n_sums]."""
    wide = obs.astype(np.float64)
    return np.concatenate([wide, wide @ tree.tests.T.astype(np.float64)], axis=1)


def with_sum(tree: SummedTree, node: int, weights: Float64, threshold: float) -> SummedTree:
    """The tree with another test at the split `node`, a sum of weighted features."""
    feature, thresholds, n_features = tree.feature.copy(), tree.threshold.copy(), tree.tests.shape[1]
    single = np.flatnonzero(weights)
    thresholds[node] = threshold
    if len(single) == 1 and weights[single[0]] == 1:
        feature[node] = single[0]
        return as_summed(replace(tree, feature=feature, threshold=thresholds), n_features)
    feature[node] = n_features + len(tree.tests)
    tests = np.concatenate([tree.tests, weights[None].astype(np.float32)])
    return as_summed(replace(tree, feature=feature, threshold=thresholds, tests=tests), n_features)


def tilt_tests(tree: SummedTree, node: int, here: Floats, rng: np.random.Generator) -> Iterator[SummedTree]:
    """The tree with other sums at the split `node`, as many observations passing on each side as before. `here`:
    [n, n_features + n_sums], what is tested in those that reach it.
    """
    n_features = tree.tests.shape[1]
    seen, feature = here[:, :n_features].astype(np.float64), int(tree.feature[node])
    assert feature != NO_FEATURE
    weights = np.zeros(n_features)
    if feature < n_features:
        weights[feature] = 1.0
    else:
        weights[:] = tree.tests[feature - n_features]
    rank = float((here[:, feature] <= tree.threshold[node]).mean())
    spread = seen.std(axis=0)
    if not spread.any():
        return
    deviation = float(here[:, feature].std()) or 1.0
    for _ in range(TRIED):
        # one weight is moved, or, of several, left out; at most TERMS stay, the largest 1 or -1
        moved, used = weights.copy(), np.flatnonzero(weights)
        if len(used) > 1 and rng.random() < 1 / TRIED:
            moved[int(rng.choice(used))] = 0.0
        else:
            which = int(rng.choice(np.flatnonzero(spread)))
            moved[which] += rng.normal() * float(rng.choice(TILTS)) * deviation / spread[which]
        moved[np.argsort(-np.abs(moved) * spread, kind="stable")[TERMS:]] = 0.0
        largest = float(np.abs(moved).max())
        rounded = np.asarray(np.round(moved / largest, DIGITS), dtype=np.float64) if largest else weights
        tilted = rounded.astype(np.float32).astype(np.float64)
        yield with_sum(tree, node, tilted, float(np.quantile(seen @ tilted, rank, method="lower")))
