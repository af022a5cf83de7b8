"""Other tests of sums for refinement by return (ours): a split's test with a term more, less, or of another weight.

Does: what a tree tests in observations, columns of sums behind those of features; copies of a tree with another test.
Assumes: trees whose leaves take actions.
Does not: judge trees, or look for the best test (growth/alternating.py learns tests from labels).
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from codegen.ir import NO_FEATURE, Float32, Float64, Floats, GrownTree
from codegen.lowering.deploy import SummedTree

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
    for _ in range(TRIED):
        tilted = _tilt(weights, spread, float(here[:, feature].std()), rng)
        yield with_sum(tree, node, tilted, float(np.quantile(seen @ tilted, rank, method="lower")))


def _tilt(weights: Float64, spread: Float64, deviation: float, rng: np.random.Generator) -> Float64:
    """Other weights of at most TERMS features, the largest 1 or -1: one is moved, or, of several, left out."""
    moved, used = weights.copy(), np.flatnonzero(weights)
    if len(used) > 1 and rng.random() < 1 / TRIED:
        moved[int(rng.choice(used))] = 0.0
    else:
        which = int(rng.choice(np.flatnonzero(spread)))
        moved[which] += rng.normal() * float(rng.choice(TILTS)) * (deviation or 1.0) / spread[which]
    least = np.argsort(-np.abs(moved) * spread, kind="stable")[TERMS:]
    moved[least] = 0.0
    rounded = np.asarray(np.round(moved / np.abs(moved).max(), DIGITS) if moved.any() else weights, dtype=np.float64)
    return rounded.astype(np.float32).astype(np.float64)
