"""Feature importances of one tree: the impurity that its splits remove, and the share of decisions that test a feature.

Does: both numbers for each feature, over given observations.
Assumes: trees that are compared get the same observations, such as those of common on-policy episodes.
Does not: collect observations, or average over trees.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from codegen import ir
from codegen.errors import InputError
from codegen.floats import observations as rounded
from codegen.ir import NO_FEATURE, Float64, Tree
from maviper.worlds.world import Int


@dataclass(frozen=True)
class Importances:
    """The importance of each feature of a policy, both [n_features], in the order of the policy's features."""

    decrease: Float64  # Gini impurity that its splits remove; sums to 1, or to 0 where no split removes any
    tested: Float64  # share of decisions whose path tests it, each from 0 to 1; a path tests several, so no fixed sum


def importances(policy: ir.AgentPolicy, observations: npt.ArrayLike, labels: Int | None = None) -> Importances:
    """The importances of a policy's features over observations [n, n_features].

    `labels`: [n] actions whose impurity is meant; None: the tree's own. With the data and labels that a tree was fitted
    to, `decrease` is scikit-learn's `feature_importances_`. InputError for no observations, another width or labels of
    another number.
    """
    x, n_actions = rounded(observations, len(policy.features), policy.agent), len(policy.actions)
    leaf = ir.apply(policy.tree, x)
    wanted = policy.tree.action[leaf] if labels is None else np.asarray(labels)
    if not len(x) or wanted.shape != (len(x),) or not 0 <= wanted.min() <= wanted.max() < n_actions:
        raise InputError("importances need observations, each with one of the actions as its label", policy.agent)
    classes = np.zeros((len(policy.tree.feature), n_actions))
    np.add.at(classes, (leaf, wanted), 1)
    for node in reversed(list(ir.splits(policy.tree))):  # children come after parents
        classes[node] = classes[policy.tree.left[node]] + classes[policy.tree.right[node]]
    removed = _decrease(policy.tree, classes, len(policy.features))
    return Importances(
        removed / (removed.sum() or 1.0), _compute_shares(policy.tree, classes.sum(axis=1), len(policy.features))
    )


def _decrease(tree: Tree, classes: Float64, n_features: int) -> Float64:
    """The decrease of impurity times observations by feature, added up. `classes`: [n_nodes, n_actions]."""
    count = classes.sum(axis=1)
    impurity = count - np.square(classes).sum(axis=1) / np.maximum(count, 1)  # Gini times observations
    decrease = np.zeros(n_features)
    for node in ir.splits(tree):
        left, right = tree.left[node], tree.right[node]
        decrease[tree.feature[node]] += max(0.0, impurity[node] - impurity[left] - impurity[right])
    return decrease


def _compute_shares(tree: Tree, count: Float64, n_features: int) -> Float64:
    """The share of observations on whose path each feature is tested. `count`: [n_nodes] that reach each node."""
    tested, passed = np.zeros(n_features), np.zeros((len(tree.feature), n_features), dtype=bool)
    for node, feature in enumerate(tree.feature):
        if feature == NO_FEATURE:
            tested += passed[node] * count[node]
            continue
        passed[[tree.left[node], tree.right[node]]] = passed[node]
        passed[[tree.left[node], tree.right[node]], feature] = True
    return tested / count[ir.ROOT]
