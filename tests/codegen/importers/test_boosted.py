"""XGBoost's and LightGBM's single trees: no difference from the library, with base score and link."""

import json

import numpy as np
import pytest

from codegen import ir
from codegen.agreement import probes
from codegen.agreement.entries import same
from codegen.errors import InputError
from codegen.importers.boosted import from_lightgbm, from_xgboost
from codegen.importers.origin import Names, profile_of
from tests.codegen.importers.origins import asked, data, decided

pytestmark = pytest.mark.interop
SEEDS = pytest.mark.parametrize("seed", range(10))


def saved(model, tmp_path):
    model.save_model(tmp_path / "tree.json")
    return (tmp_path / "tree.json").read_bytes()


@SEEDS
def test_trees_of_xgboost(xgboost, seed, tmp_path):
    x, y = data(seed, classes=2)
    kind = xgboost.XGBClassifier if seed % 3 else xgboost.XGBRegressor
    model = kind(n_estimators=1, max_depth=2 + seed % 5, n_jobs=1, base_score=[None, 0.3][seed % 2])
    model.fit(x, y if not seed % 3 else y > 0)
    origins = from_xgboost(saved(model, tmp_path), "tree.json")
    policy, rows = asked(origins)
    said = model.predict(rows)
    assert decided(origins, policy, rows) == [float(each) for each in said]


def test_other_models_of_xgboost_are_refused(xgboost, tmp_path):
    x, y = data(0)
    counts = saved(xgboost.XGBRegressor(n_estimators=1, objective="count:poisson", n_jobs=1).fit(x, y), tmp_path)
    with pytest.raises(InputError, match="objective is not understood: count:poisson"):
        from_xgboost(counts, "tree.json")
    one = json.loads(saved(xgboost.XGBClassifier(n_estimators=1, n_jobs=1).fit(x, y > 0), tmp_path))
    (tree,) = one["learner"]["gradient_booster"]["model"]["trees"]
    tree["split_type"][0] = 1
    with pytest.raises(InputError, match="categories"):
        from_xgboost(json.dumps(one).encode(), "tree.json")
    with pytest.raises(InputError, match="not XGBoost's JSON"):
        from_xgboost(b"{}", "tree.json")


@SEEDS
def test_trees_of_lightgbm(lightgbm, seed):
    x, y = data(seed, classes=2)
    kind = lightgbm.LGBMClassifier if seed % 3 else lightgbm.LGBMRegressor
    model = kind(n_estimators=1, max_depth=2 + seed % 5, n_jobs=1, verbose=-1, min_child_samples=5)
    model.fit(x.astype(np.float64), y if not seed % 3 else y > 0)
    origins = from_lightgbm(model.booster_.model_to_string().encode(), "tree.txt")
    policy, rows = asked(origins)
    said = model.booster_.predict(rows.astype(np.float64))
    said = (said > 0.5).astype(int) if seed % 3 else said
    assert decided(origins, policy, rows) == said.tolist()


def test_other_models_of_lightgbm_are_refused(lightgbm):
    x, y = data(0)
    settings = {"n_estimators": 1, "n_jobs": 1, "verbose": -1, "min_child_samples": 5}

    def text(model, target):
        return model.fit(np.where(np.abs(x) < 0.3, 0.0, x), target).booster_.model_to_string()

    zeros = text(lightgbm.LGBMClassifier(**settings, zero_as_missing=True), y > 0)
    with pytest.raises(InputError, match="takes zeros for missing values"):
        from_lightgbm(zeros.encode(), "tree.txt")
    counts = text(lightgbm.LGBMRegressor(**settings, objective="poisson"), y)
    with pytest.raises(InputError, match="objective is not understood: poisson"):
        from_lightgbm(counts.encode(), "tree.txt")
    with pytest.raises(InputError, match="0 trees"):
        from_lightgbm(b"tree\nversion=v4\n", "tree.txt")
    with pytest.raises(InputError, match="not LightGBM's text"):
        from_lightgbm(b"tree\nversion=v4\n\nTree=0\n", "tree.txt")


def booster(left=(1, -1, -1), targets="1", number=0.5, base="0.5", objective="binary:logistic"):
    """A tree of one test as XGBoost saves it, without XGBoost."""
    tree = {
        "split_type": [0, 0, 0], "categories": [], "tree_param": {"num_deleted": "0"}, "left_children": left,
        "right_children": [2, -1, -1], "split_conditions": [number, 1.0, -1.0], "split_indices": [0, 0, 0],
        "default_left": [0, 0, 0],
    }  # fmt: skip
    learner = {
        "gradient_booster": {"name": "gbtree", "model": {"trees": [tree]}},
        "learner_model_param": {"base_score": base, "num_feature": "1", "num_target": targets},
        "objective": {"name": objective},
    }
    return json.dumps({"learner": learner}).encode()


def test_what_no_model_of_xgboost_says_is_refused():
    (origin,) = from_xgboost(booster(), "tree.json").values()
    assert origin.act(np.array([[0.4], [0.6]], dtype=np.float32)).tolist() == [1, 0]
    for content, said in (
        (booster(targets="2"), "several targets"),
        (booster(left=[-1, -1, -1]), "a node has one child"),
        (booster(number=10**400), "not XGBoost's JSON"),
        (booster(base="0"), "the objective is not understood"),
        (booster(base="1"), "the objective is not understood"),
        (booster(objective="multiclass"), "the objective is not understood"),
        (booster(objective="regression"), "the objective is not understood"),
    ):
        with pytest.raises(InputError, match=said):
            from_xgboost(content, "tree.json")


def test_a_model_of_lightgbm_that_squares_its_leaves_is_refused():
    text = "tree\nversion=v4\nmax_feature_idx=0\nobjective={}\n\nTree=0\nnum_cat=0\nleaf_value=2\nend of trees\n"
    (origin,) = from_lightgbm(text.format("regression").encode(), "tree.txt").values()
    assert origin.labels == (2.0,)
    with pytest.raises(InputError, match="reg_sqrt"):
        from_lightgbm(text.format("regression sqrt").encode(), "tree.txt")


@pytest.mark.parametrize("place", [-1, 0, 1])
def test_numbers_next_to_zero_are_zero_to_lightgbm(lightgbm, place):
    """Its predictor leaves out what is at most 1e-35, so that a threshold there is asked of 0."""
    zero = float(np.float32(1e-35))
    text = (
        "tree\nversion=v4\nnum_class=1\nnum_tree_per_iteration=1\nlabel_index=0\nmax_feature_idx=0\nobjective=regression\n"
        "feature_names=a\nfeature_infos=[-1:1]\ntree_sizes=400\n\nTree=0\nnum_leaves=2\nnum_cat=0\nsplit_feature=0\n"
        f"split_gain=1\nthreshold={place * zero!r}\ndecision_type=2\nleft_child=-1\nright_child=-2\nleaf_value=1 2\n"
        "leaf_weight=1 1\nleaf_count=1 1\ninternal_value=0\ninternal_weight=0\ninternal_count=2\nis_linear=0\n"
        "shrinkage=1\n\n\nend of trees\n"
    )
    booster = lightgbm.Booster(model_str=text)
    origins = from_lightgbm(text.encode(), "tree.txt")
    (policy,) = profile_of(origins, Names()).agents
    near = [zero, np.nextafter(zero, 1), np.nextafter(zero, 0), 5e-324, 1e-36, 0.0, 1.0]
    rows = np.array([near, np.negative(near)]).reshape(-1, 1)
    theirs = booster.predict(rows, num_threads=1).tolist()
    assert [float(each) for each in decided(origins, policy, rows)] == theirs


def linear(lightgbm, seed):
    """A tree of LightGBM with linear leaves, its text, and the booster of it alone (the first tree is constant)."""
    rng = np.random.default_rng(seed)
    x = rng.normal(size=(300, 4)) * 10.0 ** rng.integers(-2, 3)
    y = 2 * x[:, 0] + np.where(x[:, 1] > 0, x[:, 2], -x[:, 3]) + 1e-3 * rng.normal(size=len(x))
    settings = {"linear_tree": True, "num_leaves": int(rng.integers(2, 9)), "min_data_in_leaf": 20, "num_threads": 1}
    model = lightgbm.train({"objective": "regression", "verbose": -1, **settings}, lightgbm.Dataset(x, y), 2)
    text = model.model_to_string(start_iteration=1, num_iteration=1)
    return text, lightgbm.Booster(model_str=text)


@pytest.mark.parametrize("count", [12, pytest.param(1_000, marks=pytest.mark.slow)])
def test_linear_leaves_of_lightgbm(lightgbm, count):
    for seed in range(count):
        text, booster = linear(lightgbm, seed)
        (policy,) = profile_of(from_lightgbm(text.encode(), "tree.txt"), Names()).agents
        rng = np.random.default_rng(seed)
        rows = np.concatenate([probes.ties(policy, rng), probes.wide(4, rng, "float64")[::8]])
        rows = np.concatenate([rows[np.isfinite(rows).all(axis=1)], rng.normal(size=(200, 4))])
        ours, theirs = ir.outputs(policy, rows)[:, 0], booster.predict(rows, num_threads=1)
        assert same(ours, theirs).all(), seed
        assert policy.tree.arithmetic == "float64" and len(policy.outputs) == 1


def test_damaged_linear_leaves_are_refused(lightgbm):
    text, _ = linear(lightgbm, 0)
    sizes = next(line for line in text.splitlines() if line.startswith("num_features="))
    for damaged in (text.replace(sizes, sizes + " 1"), text.replace("objective=regression", "objective=poisson")):
        with pytest.raises(InputError) as caught:
            from_lightgbm(damaged.encode(), "tree.txt")
        assert caught.value.next_step
