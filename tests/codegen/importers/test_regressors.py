"""Regressors and boosters of scikit-learn with one tree: what they predict in a leaf is an action, if of a few."""

import numpy as np
import pytest
from sklearn.ensemble import GradientBoostingClassifier, GradientBoostingRegressor, RandomForestRegressor
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
        make_pipeline(StandardScaler(), DecisionTreeRegressor(max_depth=3)),
    ],
    ids=str,
)
def test_what_is_predicted_is_the_action(model):
    model.fit(X, Y > 0 if isinstance(model, GradientBoostingClassifier) else Y)
    (policy,) = from_sklearn(model).agents
    rows = probes.boundary(policy.tree, policy.features, np.random.default_rng(1)).astype(np.float32)
    rows = np.concatenate([rows[np.isfinite(rows).all(axis=1)], X])
    labels = [place if each.label is None else each.label for place, each in enumerate(policy.actions)]
    assert [labels[action] for action in ir.act(policy, rows).tolist()] == model.predict(rows).tolist()


@pytest.mark.parametrize(
    ("model", "said"),
    [
        (DecisionTreeRegressor(), "different numbers, at most 64 are actions"),
        (GradientBoostingRegressor(n_estimators=2), "2 fitted trees, one is needed"),
        (LinearRegression(), "not a fitted decision tree"),
    ],
    ids=str,
)
def test_others_are_refused_with_what_would_pass(model, said):
    with pytest.raises(InputError, match=said) as caught:
        from_sklearn(model.fit(X, X[:, 0] + X[:, 1]))
    assert caught.value.next_step
