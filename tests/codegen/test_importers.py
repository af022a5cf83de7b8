"""Trees of others: the same decisions at every boundary, or an error that says why not."""

import numpy as np
import pytest
from sklearn.tree import DecisionTreeClassifier

from codegen import importers, ir, policy_json, probes, selfcheck
from codegen.errors import InputError
from codegen.targets import emit


def fitted(seed=0, n_features=4, depth=5, classes=("wait", "go", "turn")):
    rng = np.random.default_rng(seed)
    x = rng.normal(size=(600, n_features)).astype(np.float32)
    y = np.array(classes)[((x[:, 0] > x[:, 1]).astype(int) + (x[:, 2] > 0.3)) % len(classes)]
    return DecisionTreeClassifier(max_depth=depth, random_state=seed).fit(x, y), x


def boundary(policy):
    rng = np.random.default_rng(0)
    return np.concatenate(
        [probes.boundary(policy.tree, policy.features, rng), rng.normal(size=(500, len(policy.features)))]
    )


@pytest.mark.parametrize("seed", range(5))
def test_a_classifier_decides_as_before(seed):
    classifier, _ = fitted(seed)
    profile = importers.from_sklearn(classifier)
    (policy,) = profile.agents
    rows = boundary(policy).astype(np.float32)
    rows = rows[np.isfinite(rows).all(axis=1)]
    names = np.array([action.name for action in policy.actions])
    assert (names[ir.act(policy, rows)] == classifier.predict(rows)).all()
    assert [action.name for action in policy.actions] == sorted(["wait", "go", "turn"])
    assert policy_json.dumps(policy_json.loads(policy_json.dumps(profile))) == policy_json.dumps(profile)


@pytest.mark.compile
def test_it_compiles_like_ours():
    profile = importers.from_sklearn(fitted()[0], ["speed", "gap ahead", "class", "class"], name="Überholen 2")
    assert [feature.name for feature in profile.agents[0].features] == ["speed", "gap_ahead", "class", "class_2"]
    selfcheck.check_files(profile, emit(profile), random=500).ensure()


def test_names_come_from_a_data_frame():
    classifier, _ = fitted()
    classifier.feature_names_in_ = np.array(["a", "b", "3rd", "-"])
    assert [f.name for f in importers.from_sklearn(classifier).agents[0].features] == ["a", "b", "x_3rd", "x"]


def test_what_is_no_single_tree_is_refused():
    with pytest.raises(InputError, match="not a fitted"):
        importers.from_sklearn(DecisionTreeClassifier())
    with pytest.raises(InputError, match="not a fitted"):
        importers.from_sklearn(object())
    x, rng = np.zeros((4, 2)), np.random.default_rng(0)
    with pytest.raises(InputError, match="2 outputs"):
        importers.from_sklearn(DecisionTreeClassifier().fit(x, rng.integers(2, size=(4, 2))))
    with pytest.raises(InputError, match="3 feature names for 4"):
        importers.from_sklearn(fitted()[0], ["a", "b", "c"])
    with pytest.raises(InputError, match="1 action names"):
        importers.from_sklearn(fitted()[0], action_names=["a"])


@pytest.mark.parametrize("given", [["if", "IF", "i f", "", "ß"], ["x" * 90, "x" * 91], ["1", "_1", "1"]])
def test_cleaned_names_are_legal_and_different(given):
    found = importers.cleaned(given, "x")
    assert all(ir.NAME.fullmatch(name) for name in found)
    assert len({name.lower() for name in found}) == len(given)


def onnx_of(classifier, n_features):
    pytest.importorskip("onnx", reason="onnx is not installed")
    skl2onnx = pytest.importorskip("skl2onnx", reason="skl2onnx is not installed")
    from skl2onnx.common.data_types import FloatTensorType

    return skl2onnx.convert_sklearn(classifier, initial_types=[("x", FloatTensorType([None, n_features]))])


@pytest.mark.parametrize("seed", range(3))
def test_an_onnx_model_decides_as_before(seed):
    classifier, _ = fitted(seed)
    model = onnx_of(classifier, 4)
    (policy,) = importers.from_onnx(model.SerializeToString()).agents
    rows = boundary(policy).astype(np.float32)
    rows = rows[np.isfinite(rows).all(axis=1)]
    names = np.array([action.name for action in policy.actions])
    assert (names[ir.act(policy, rows)] == classifier.predict(rows)).all()


def test_other_onnx_models_are_refused(tmp_path):
    onnx = pytest.importorskip("onnx", reason="onnx is not installed")
    with pytest.raises(InputError, match="not an ONNX model"):
        importers.from_onnx(b"hello")
    with pytest.raises(InputError, match="cannot read"):
        importers.from_onnx(tmp_path / "nothing.onnx")
    model = onnx_of(fitted()[0], 4)
    node = next(each for each in model.graph.node if each.op_type == importers.ENSEMBLE)
    for change, said in (
        (lambda a: a.strings.__setitem__(0, b"BRANCH_GT") if a.name == "nodes_modes" else None, "tests by BRANCH_GT"),
        (lambda a: a.ints.__setitem__(0, 1) if a.name == "nodes_missing_value_tracks_true" else None, "missing values"),
        (lambda a: a.ints.__setitem__(0, 7) if a.name == "nodes_treeids" else None, "several trees"),
    ):
        changed = onnx.ModelProto()
        changed.CopyFrom(model)
        node = next(each for each in changed.graph.node if each.op_type == importers.ENSEMBLE)
        for attribute in node.attribute:
            change(attribute)
        with pytest.raises(InputError, match=said):
            importers.from_onnx(changed.SerializeToString())
    del model.graph.node[:]
    with pytest.raises(InputError, match="has 0 nodes"):
        importers.from_onnx(model.SerializeToString())
