"""Feature importances: against scikit-learn's on a tree that it fitted, and decisions counted by walking them."""

import numpy as np
import pytest
from sklearn.tree import DecisionTreeClassifier

from codegen.errors import InputError
from codegen.ir import NO_FEATURE
from maviper import from_sklearn
from maviper.reproduction.cells.making import importances

N, FEATURES = 3_000, 5


@pytest.fixture(scope="module")
def fitted():
    rng = np.random.default_rng(7)
    x = rng.normal(size=(N, FEATURES)).astype(np.float32)
    y = (x[:, 0] > 0) * 2 + (x[:, 1] + x[:, 2] > 0.3) + (rng.random(N) < 0.1)
    tree = DecisionTreeClassifier(max_depth=5, random_state=0).fit(x, y)
    return tree, from_sklearn(tree).agents[0], x, y


def test_the_decrease_on_the_fitted_data_is_scikit_learns(fitted):
    tree, policy, x, y = fitted
    found = importances(policy, x, y).decrease
    assert (tree.feature_importances_ > 0).sum() >= 3
    np.testing.assert_allclose(found, tree.feature_importances_, rtol=0, atol=1e-12)
    assert found.sum() == pytest.approx(1)


def test_without_labels_the_trees_own_actions_are_meant(fitted):
    tree, policy, x, _ = fitted
    own = importances(policy, x, tree.predict(x).astype(int))
    assert importances(policy, x).decrease.tolist() == own.decrease.tolist()


def test_tested_counts_decisions_once_however_often_they_test_a_feature(fitted):
    _, policy, x, _ = fitted
    tree, counted = policy.tree, np.zeros(FEATURES)
    for row in x:
        node, met = 0, set()
        while tree.feature[node] != NO_FEATURE:
            feature = int(tree.feature[node])
            met.add(feature)
            node = tree.left[node] if row[feature] <= tree.threshold[node] else tree.right[node]
        counted[list(met)] += 1
    found = importances(policy, x).tested
    np.testing.assert_allclose(found, counted / N, rtol=0, atol=1e-12)
    assert found.max() == 1, "the root's feature is tested in every decision"


def test_a_leaf_alone_has_no_importances():
    policy = from_sklearn(DecisionTreeClassifier().fit(np.zeros((2, 2)), [0, 0])).agents[0]
    found = importances(policy, np.zeros((4, 2)))
    assert found.decrease.tolist() == found.tested.tolist() == [0, 0]


def test_bad_input_is_refused(fitted):
    _, policy, x, y = fitted
    for observations, labels in ((x[:, :2], None), (np.zeros((0, FEATURES)), None), (x, y[:3]), (x, y + 9)):
        with pytest.raises(InputError):
            importances(policy, observations, labels)
