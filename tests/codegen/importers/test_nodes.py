"""Sums of a few trees of XGBoost and LightGBM: one tree, with no bit other than their own predictors give."""

import json

import numpy as np
import pytest

from codegen import ir
from codegen.agreement.entries import same
from codegen.errors import InputError
from codegen.importers import nodes, replay
from codegen.importers.boosted import from_lightgbm, from_xgboost
from codegen.importers.nodes import Leaf, Split, Tree, origin_of, origin_of_sum
from codegen.importers.origin import Names, profile_of
from codegen.importers.symbolic.paths import Described

pytestmark = pytest.mark.interop
LONG = [pytest.mark.nightly, pytest.mark.timeout(3_600)]
COUNTS = [3, pytest.param(150, marks=pytest.mark.slow), pytest.param(1_000, marks=LONG)]
ROWS = 400  # of those at thresholds and neighbours, beside random ones


def drawn(seed, kind):
    """Data whose numbers lie on a coarse grid, so that trees share thresholds; and how many trees of what depth."""
    rng = np.random.default_rng(seed)
    x = rng.normal(size=(200, 3)).round(int(rng.integers(1, 4)))
    y = x[:, 0] * 10.0 ** rng.uniform(-2, 3) + np.where(x[:, 1] > 0, x[:, 2], rng.normal()) + rng.uniform(-9, 9)
    if kind != "number":
        levels = np.quantile(y, [0.5] if kind == "two" else [0.3, 0.6])
        y = np.searchsorted(levels, y)
    return rng, x, y, int(rng.integers(2, 4)), int(rng.integers(1, 4))


def asked(rng, origins):
    """The policy, and finite observations at thresholds, beside them and anywhere."""
    (policy,) = profile_of(origins, Names()).agents
    rows = replay.observations(policy, nan=False, finite=True)
    rows = rows[rng.permutation(len(rows))[:ROWS]]
    return policy, np.concatenate([rows, rng.normal(size=(100, 3)).astype(policy.numbers)])


def told(policy, rows):
    """What the policy gives, or the whole numbers that its actions stand for."""
    if policy.outputs:
        return ir.outputs(policy, rows)[:, 0]
    return np.array([int(policy.actions[each].name.removeprefix("action_")) for each in ir.act(policy, rows)])


KINDS = ("number", "two", "three")


@pytest.mark.parametrize("count", COUNTS)
def test_sums_of_xgboost(xgboost, count):
    taken = 0
    for seed in range(count):
        kind = KINDS[seed % 3]
        rng, x, y, n_trees, depth = drawn(seed, kind)
        model = (xgboost.XGBRegressor if kind == "number" else xgboost.XGBClassifier)(
            n_estimators=n_trees, max_depth=depth if kind != "three" else 1, n_jobs=1, base_score=[None, 0.3][seed % 2],
            learning_rate=float(rng.choice([0.3, 1.0])),
        ).fit(x.astype(np.float32), y)  # fmt: skip
        try:
            policy, rows = asked(rng, from_xgboost(bytes(model.get_booster().save_raw("json")), "tree.json"))
        except InputError as error:
            assert "too close to call" in error.what or "more than 4,096 leaves" in error.what
            continue
        taken += 1
        theirs = model.predict(rows)
        assert bool(policy.outputs) == (kind == "number")
        assert (same(told(policy, rows), theirs) if kind == "number" else told(policy, rows) == theirs).all(), seed
    assert taken > 0.8 * count


@pytest.mark.parametrize("count", COUNTS)
def test_sums_of_lightgbm(lightgbm, count):
    taken = 0
    for seed in range(count):
        kind = KINDS[seed % 3]
        rng, x, y, n_trees, depth = drawn(seed, kind)
        settings = {"number": {"objective": "regression"}, "two": {"objective": "binary"}}
        more = settings.get(kind, {"objective": "multiclass", "num_class": 3})
        shape = {"num_leaves": 2 if kind == "three" else 2**depth, "min_data_in_leaf": 10}
        given = {"verbose": -1, "num_threads": 1, "boost_from_average": bool(seed % 2), **more, **shape}
        model = lightgbm.train(given, lightgbm.Dataset(x, y), n_trees)
        try:
            policy, rows = asked(rng, from_lightgbm(model.model_to_string().encode(), "tree.txt"))
        except InputError as error:
            assert "too close to call" in error.what or "more than 4,096 leaves" in error.what
            continue
        taken += 1
        theirs = model.predict(rows, num_threads=1)
        if kind == "number":
            assert same(told(policy, rows), theirs).all(), seed
        else:
            theirs = theirs > 0.5 if kind == "two" else theirs.argmax(axis=1)
            assert (told(policy, rows) == theirs).all(), seed
    assert taken > 0.8 * count


def test_what_is_not_their_sum_is_refused(xgboost, lightgbm, monkeypatch):
    x = np.random.default_rng(0).normal(size=(300, 3))
    y = x[:, 0] + x[:, 1] * x[:, 2]
    model = xgboost.XGBRegressor(n_estimators=3, max_depth=3, n_jobs=1).fit(x, y)
    text = bytes(model.get_booster().save_raw("json"))
    stopped = json.loads(text)
    stopped["learner"]["attributes"] = {"best_iteration": "1"}
    with pytest.raises(InputError, match="has a best_iteration"):
        from_xgboost(json.dumps(stopped).encode(), "tree.json")
    monkeypatch.setattr(nodes, "MAX_LEAVES", 20)
    with pytest.raises(InputError, match="3 trees together have more than 20 leaves"):
        from_xgboost(text, "tree.json")
    forest = {"boosting": "rf", "bagging_freq": 1, "bagging_fraction": 0.5}
    for settings, said in (
        (forest, "the mean of its trees"),
        ({"linear_tree": True}, "several trees have linear leaves"),
    ):
        given = {"objective": "regression", "verbose": -1, "num_leaves": 3, **settings}
        text = lightgbm.train(given, lightgbm.Dataset(x, y), 3).model_to_string().encode()
        with pytest.raises(InputError, match=said):
            from_lightgbm(text, "tree.txt")


def test_tests_that_are_decided_are_left_out():
    one = {0: Split(0, "<", 1.0, 1, 2, nan=False), 1: Leaf(1.0), 2: Leaf(2.0)}
    other = {0: Split(0, "<=", 0.5, 1, 2, nan=False), 1: Leaf(10.0), 2: Leaf(20.0)}
    trees = [Tree(0, one.__getitem__), Tree(0, other.__getitem__)]
    said = Described(kind="two trees", n_features=1, numbers="float64")
    origin = origin_of_sum(trees, lambda leaves: Leaf(sum(leaf.label for leaf in leaves)), said, "here")
    assert origin.labels == (11.0, 21.0, 22.0), "x >= 1 is above 0.5: 12 is no sum"
    assert np.count_nonzero(origin.grown.feature == 0) == 2
    assert origin.act(np.array([[0.5], [0.75], [1.0]])).tolist() == [0, 1, 2]


@pytest.mark.parametrize(("sign", "then"), [("<", True), ("<=", False), (">", True), (">=", False)])
def test_a_nan_goes_where_the_node_says_and_is_kept_where_that_is_the_right_side(sign, then):
    nodes = {0: Split(0, sign, 1.0, 1, 2, nan=then), 1: Leaf(1.0), 2: Leaf(2.0)}
    said, rows = Described(kind="a tree", n_features=1, numbers="float64"), np.array([[np.nan]])
    single = origin_of(0, nodes.__getitem__, said, "here")
    assert single.nan == (then == (sign in (">", ">=")))
    assert [single.labels[each] for each in single.act(rows)] == [1.0 if then else 2.0]
    plain = {
        0: Split(0, "<", 2.0, 1, 2, nan=False),
        1: Leaf(10.0),
        2: Leaf(20.0),
    }  # decides it on its right
    trees = [Tree(0, plain.__getitem__), Tree(0, nodes.__getitem__)]
    both = origin_of_sum(trees, lambda leaves: Leaf(sum(leaf.label for leaf in leaves)), said, "here")
    assert both.nan == single.nan and both.labels[0] == 11.0


def test_a_node_that_leads_back_to_itself_is_refused():
    circle = {0: Split(0, "<", 1.0, 0, 1, nan=False), 1: Leaf(1.0)}
    trees = [Tree(0, circle.__getitem__), Tree(0, circle.__getitem__)]
    with pytest.raises(InputError, match="leads back to itself"):
        origin_of_sum(trees, lambda leaves: leaves[0], Described(kind="two trees", n_features=1), "here")
