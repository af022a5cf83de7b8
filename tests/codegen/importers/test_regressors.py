"""Regressors and boosters of scikit-learn with one tree: what they predict in a leaf is an action, if of a few."""

import numpy as np
import pytest
from sklearn.ensemble import (
    GradientBoostingClassifier,
    GradientBoostingRegressor,
    HistGradientBoostingClassifier,
    HistGradientBoostingRegressor,
    RandomForestRegressor,
)
from sklearn.linear_model import LinearRegression
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler
from sklearn.tree import DecisionTreeRegressor, ExtraTreeRegressor

from codegen import ir
from codegen.agreement import probes
from codegen.errors import InputError
from codegen.importers.scikit import from_sklearn

X = np.random.default_rng(0).normal(size=(400, 3)).astype(np.float32)
Y = (X[:, 0] > 0) + (X[:, 1] > 0.3) * 1.0
ONE = {"n_estimators": 1, "max_depth": 3, "random_state": 0}


@pytest.mark.parametrize(
    "model",
    [
        DecisionTreeRegressor(max_depth=4),
        DecisionTreeRegressor(max_depth=1),
        ExtraTreeRegressor(max_depth=3, random_state=0),
        RandomForestRegressor(**ONE),
        GradientBoostingRegressor(**ONE),
        GradientBoostingClassifier(**ONE),
        HistGradientBoostingRegressor(max_iter=1, max_depth=3),
        HistGradientBoostingRegressor(max_iter=1, max_leaf_nodes=5, loss="poisson"),
        HistGradientBoostingClassifier(max_iter=1, max_bins=16),
        make_pipeline(StandardScaler(), DecisionTreeRegressor(max_depth=3)),
        make_pipeline(StandardScaler(), HistGradientBoostingRegressor(max_iter=1, max_depth=3)),
    ],
    ids=str,
)
def test_what_is_predicted_is_the_action(model):
    model.fit(X, Y > 0 if hasattr(model, "predict_proba") else Y)
    (policy,) = from_sklearn(model).agents
    rows = probes.boundary(policy.tree, policy.features, np.random.default_rng(1)).astype(policy.numbers)
    rows = np.concatenate([rows[np.isfinite(rows).all(axis=1)], X.astype(policy.numbers)])
    labels = [place if each.label is None else each.label for place, each in enumerate(policy.actions)]
    assert [labels[action] for action in ir.act(policy, rows).tolist()] == model.predict(rows).tolist()


GIVING = [
    DecisionTreeRegressor(max_depth=6),
    ExtraTreeRegressor(max_depth=5, random_state=0),
    RandomForestRegressor(**ONE),
    RandomForestRegressor(n_estimators=3, max_depth=3, random_state=0),
    make_pipeline(StandardScaler(), DecisionTreeRegressor(max_depth=5)),
]


def given_as_predicted(model, y, rows):
    """A regressor gives what it predicts, to the last bit."""
    policy = from_sklearn(model.fit(X, y)).agents[0]
    near = probes.boundary(policy.tree, policy.features, np.random.default_rng(1)).astype(np.float32)
    asked = np.concatenate([near[np.isfinite(near).all(axis=1)], rows])
    assert ir.outputs(policy, asked).tolist() == model.predict(asked).reshape(len(asked), -1).tolist()
    return policy


@pytest.mark.parametrize("model", GIVING, ids=str)
@pytest.mark.parametrize("outputs", [2, 3])
def test_several_outputs_are_given(model, outputs):
    policy = given_as_predicted(model, np.column_stack([Y, X[:, 1], X[:, 0] * X[:, 2]])[:, :outputs], X)
    assert len(policy.outputs) == outputs and policy.tree.gives == "float64" and policy.numbers == "float32"


def test_a_regressor_of_many_values_gives_them():
    policy = given_as_predicted(DecisionTreeRegressor(), X[:, 0] + X[:, 1], X)
    assert len(policy.tree.vectors) > 64 and [each.name for each in policy.outputs] == ["y0"]


def random_regressor(seed):
    rng = np.random.default_rng(seed)
    x = rng.normal(size=(60, 3)).astype(np.float32)
    y = rng.normal(size=(60, int(rng.integers(2, 4)))) * 10.0 ** rng.integers(-3, 4)
    return DecisionTreeRegressor(max_depth=int(rng.integers(1, 6)), random_state=seed).fit(x, y), x


@pytest.mark.parametrize("count", [20, pytest.param(1_000, marks=pytest.mark.slow)])
def test_random_regressors_give_what_they_predict(count):
    for seed in range(count):
        model, rows = random_regressor(seed)
        policy = from_sklearn(model, output_names=None).agents[0]
        assert ir.outputs(policy, rows).tolist() == model.predict(rows).tolist()


def test_others_are_refused_with_what_would_pass():
    one, missing = {"max_iter": 1}, np.where(X > 1, np.nan, X)
    told = [
        (GradientBoostingRegressor(n_estimators=2), X, Y, "2 fitted trees, one is needed", "fit n_estimators=1"),
        (LinearRegression(), X, Y, "not a fitted decision tree", "fit it first"),
        (HistGradientBoostingRegressor(max_iter=2), X, Y, "2 fitted trees", "fit max_iter=1"),
        (HistGradientBoostingClassifier(**one), X, Y, "3 fitted trees", "boost two classes at most"),
        (HistGradientBoostingRegressor(**one), missing, Y, "missing values", "without missing"),
        (HistGradientBoostingRegressor(categorical_features=[2], **one), X > 0, X[:, 2], "categories", "on numbers"),
    ]
    for model, rows, wanted, said, advice in told:
        with pytest.raises(InputError, match=said) as caught:
            from_sklearn(model.fit(rows, wanted))
        assert advice in caught.value.next_step
