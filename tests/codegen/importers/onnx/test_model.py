"""ONNX models of others: each decides after its import as it does under onnxruntime, or it is refused by name."""

from dataclasses import replace

import numpy as np
import pytest
from sklearn.ensemble import RandomForestClassifier
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import FunctionTransformer
from sklearn.tree import DecisionTreeClassifier, DecisionTreeRegressor, ExtraTreeClassifier

from codegen import ir
from codegen.errors import InputError
from codegen.importers.onnx.model import from_onnx
from codegen.targets import emit
from tests.codegen.importers.onnx.graphs import (
    FIRST,
    FLOAT,
    INT64,
    ROWS,
    STRING,
    THREE,
    TWO,
    WIDTH,
    converted,
    graph,
    helper,
    node,
    onnx,
    same,
    stump,
)
from tests.support.strategies import with_trees
from tests.support.teams import tree


def labelled(y, labels):
    return np.array(labels)[y]


@pytest.mark.parametrize("classifier", [DecisionTreeClassifier, ExtraTreeClassifier])
@pytest.mark.parametrize(
    "y",
    [
        THREE,
        TWO,
        labelled(THREE, [5, -2, 9]),
        labelled(TWO, [7, -7]),
        labelled(THREE, ["wait", "go", "turn"]),
        labelled(TWO, ["wait", "go"]),
        TWO.astype(bool),
    ],
    ids=["three", "two", "other numbers", "two other numbers", "texts", "two texts", "truth"],
)
def test_trees_of_scikit_learn_decide_as_under_onnxruntime(classifier, y):
    for depth, weights in ((2, None), (4, np.linspace(0, 1, len(y))), (8, None)):
        fitted = classifier(max_depth=depth, min_samples_leaf=9, random_state=0).fit(ROWS, y, sample_weight=weights)
        profile = same(converted(fitted, options={id(fitted): {"zipmap": depth > 2}}))
        tested = profile.agents[0].tree
        assert len({*tested.action[tested.feature == ir.NO_FEATURE]}) > 1


def test_a_step_that_changes_nothing_is_let_through():
    assert same(converted(make_pipeline(FunctionTransformer(), DecisionTreeClassifier(max_depth=3)).fit(ROWS, THREE)))


@pytest.mark.parametrize(
    ("estimator", "kind", "said"),
    [
        (RandomForestClassifier(2, max_depth=2), "FloatTensorType", "several trees"),
        (DecisionTreeRegressor(max_depth=2), "DoubleTensorType", "takes float64"),
        (DecisionTreeClassifier(max_depth=2), "DoubleTensorType", "input is DOUBLE"),
        (DecisionTreeClassifier(max_depth=2), "Int64TensorType", "input is INT64"),
    ],
)
def test_other_estimators_and_inputs_are_refused(estimator, kind, said):
    with pytest.raises(InputError, match=said):
        from_onnx(converted(estimator.fit(ROWS, THREE), kind).SerializeToString())


@pytest.mark.parametrize(
    ("model", "names"),
    [
        (graph(stump()), {}),
        (graph(stump(), ml=4), {}),
        (graph(stump(FIRST)), {}),
        (graph(stump(FIRST, labels=(9, -5))), {}),
        (graph(stump(FIRST, labels=("p", "q")), label=STRING), {}),
        (graph(stump(labels=("p", "q")), label=STRING), {}),
        (graph(stump(({0: 0.5}, {0: 0.50000006}))), {}),
        (graph(stump(({2: 0.5}, {0: 0.25, 1: 0.25}), labels=(5, -2, 9))), {}),
        (graph(stump(nodes_modes=["BRANCH_LT", "LEAF", "LEAF"])), {}),
        (graph(stump(nodes_modes=["BRANCH_LT", "LEAF", "LEAF"], nodes_values=[0.0, 0.0, 0.0])), {}),
        (graph(stump(nodes_hitrates=[3.0, 1.0, 2.0])), {}),
        (graph(stump(nodes_nodeids=[2, 0, 1], nodes_truenodeids=[0] * 3, nodes_falsenodeids=[1] * 3,
                     class_nodeids=[0, 0, 1, 1])), {}),
        (graph(stump(), node("Identity", "label", "a_label"), made=["a_label", "scores"]), {}),
        (graph(stump(), node("Cast", "label", "a_label", to=INT64), made=["scores", "a_label"]), {}),
        (graph(node("Identity", "y", "x"), stump(), given=["y"]), {}),
        (graph(stump(), shape=("N", None)), {"feature_names": ["a", "b", "c", "d"]}),
    ],
    ids=range(16),
)  # fmt: skip
def test_what_is_understood_is_imported_exactly(model, names):
    profile = same(model, **names)
    assert len(profile.agents[0].features) == WIDTH


THREES = ({0: 1.0, 1: 0.0, 2: 0.0}, {0: 0.0, 1: 0.0, 2: 1.0})


def ensemble(**more):
    return helper.make_node(
        "TreeEnsemble", ["x"], ["label"], domain="ai.onnx.ml", name="new", tree_roots=[0], n_targets=1, **more
    )


@pytest.mark.parametrize(
    ("model", "said"),
    [
        # other operators, and trees that are not what decides
        (graph(node("Abs", "y", "x"), stump(), given=["y"]), "not understood: 'Abs'"),
        (graph(stump(), node("Neg", "label", "a_label"), made=["a_label"]), "works on the tree's label, INT64: 'Neg'"),
        (graph(stump(), node("Abs", "scores", "other"), made=["label", "other"]), "not understood: 'Abs'"),
        (graph(stump(domain="mine")), "not understood: 'TreeEnsembleClassifier'"),
        (graph(node("Identity", "x", "y", domain="mine"), stump()), "not understood: 'Identity'"),
        (graph(ensemble(), ml=5), "not a valid ONNX model"),
        (graph(ensemble(), ml=3), "version 3 of ai.onnx.ml is not supported; 5 to 5 are"),
        (graph(stump(), stump(outputs=["label2", "scores2"])), "has 2 nodes"),
        (graph(stump(), node("Cast", "label", "a_label", to=FLOAT), made=["a_label"]), "makes FLOAT of the tree's"),
        (graph(stump(), node("Cast", "label", "a_label", to=onnx.TensorProto.BOOL), made=["a_label"]), "makes BOOL"),
        (graph(stump(), node("Cast", "label", "a_label", to=onnx.TensorProto.INT8), made=["a_label"]), "makes INT8"),
        (graph(stump(), made=["scores"]), "no output of the model is the tree's label"),
        (graph(stump(), node("Identity", "x", "same"), made=["label", "same"]), "output of the model is the obs"),
        (graph(stump(), node("Identity", "x", "label2"), made=["label2"]), "output of the model is the obs"),
        # inputs
        (graph(stump(), given=["x", "z"]), "2 inputs"),
        (graph(stump(), given=["z"], initializers=[helper.make_tensor("x", FLOAT, [1, 4], [0.0] * 4)]), "a constant:"),
        (graph(stump(), initializers=[helper.make_tensor("x", FLOAT, [1, 4], [0.0] * 4)]), "constant value"),
        (graph(stump(), kind=onnx.TensorProto.DOUBLE), "input is DOUBLE"),
        (graph(stump(), kind=onnx.TensorProto.FLOAT16), "FLOAT16"),
        (graph(stump(), shape=("N",)), "1 axes"),
        (graph(stump(), shape=("N", 1)), "tests feature 1, the input has 1"),
        (graph(stump(), shape=("N", "M")), "does not say how many features"),
        (graph(stump(), ml=5), "version 5 of"),
        # attributes
        (graph(stump(FIRST, post_transform="LOGISTIC")), "go through 'LOGISTIC'"),
        (graph(stump(post_transform="SOFTMAX")), "go through 'SOFTMAX'"),
        (graph(stump(base_values=[0.4, 0.0])), "'base_values'"),
        (graph(stump(base_values=[0.0])), "'base_values'"),
        (graph(stump(nodes_values=None, nodes_values_as_tensor=helper.make_tensor("t", onnx.TensorProto.DOUBLE, [3],
                                                                                [0.1, 0, 0])), ml=3), "as_tensor"),
        (graph(stump(nodes_missing_value_tracks_true=[1, 0, 0])), "missing values"),
        *((graph(stump(nodes_modes=[mode, "LEAF", "LEAF"])), f"compares by '{mode}'")
          for mode in ("BRANCH_GT", "BRANCH_GTE", "BRANCH_EQ", "BRANCH_NEQ", "nothing")),
        (graph(stump(nodes_treeids=[0, 0, 1])), "several trees"),
        (graph(stump(class_treeids=[1, 1, 1, 1])), "several trees"),
        (graph(stump(nodes_values=None)), "nodes_values has 0"),
        (graph(stump(nodes_values=[0.5])), "nodes_values has 1"),
        (graph(stump(nodes_values=[np.inf, 0, 0])), "finite threshold"),
        (graph(stump(nodes_values=[np.nan, 0, 0])), "finite threshold"),
        (graph(stump(nodes_featureids=[-1, 0, 0])), "tests no feature"),
        (graph(stump(nodes_featureids=[1 << 32, 0, 0])), "tests no feature"),
        # nodes that do not form a tree
        (graph(stump(nodes_truenodeids=[0, 0, 0])), "do not form a tree"),
        (graph(stump(nodes_truenodeids=[2, 0, 0])), "do not form a tree"),
        (graph(stump(nodes_truenodeids=[7, 0, 0])), "do not form a tree"),
        (graph(stump(nodes_nodeids=[0, 1, 1])), "do not form a tree"),
        (graph(stump(nodes_nodeids=[0, 1, 9], nodes_falsenodeids=[9, 0, 0])), "do not form a tree"),
        # leaves that runtimes read in different ways, or not at all
        (graph(stump(({0: 0.3, 1: 0.7}, {0: 0.7, 1: 0.3}))), "differ in the class at leaf 2: 1 or 0"),
        (graph(stump(({0: 1.0}, {1: 1.0}))), "differ in the class at leaf 1"),
        (graph(stump(({0: -0.3}, {0: 0.2}))), "differ in the class at leaf 2: 1 or 0"),
        (graph(stump(({1: 0.3}, {1: 0.7}))), "differ in the class at leaf 2"),
        (graph(stump(labels=(5, -2))), r"two classes have the labels \[5, -2\]"),
        (graph(stump(({0: 1.0}, {0: 1.0}), labels=(7,))), "1 labels for 1 classes"),
        (graph(stump(labels=(7, 7))), "1 labels for 2 classes"),
        (graph(stump(({1: -1.0}, {2: 1.0}), labels=(1, 2, 3))), "differ in the class at leaf 1: 2 or 1"),
        (graph(stump(({1: 1.0}, {1: 1.0}), labels=(1, 2, 3))), "only class 2 has weights"),
        (graph(stump(THREES, labels=(1, 2, 3), class_ids=[0, 1, 2, 0, 1, 1])), "two for one class"),
        (graph(stump(({}, {0: 1.0, 1: 0.0}))), "no weight"),
        (graph(stump(({0: np.nan, 1: 1.0}, {0: 1.0, 1: 0.0}))), "weight of class 0 at node 1"),
        (graph(stump(class_nodeids=[0, 0, 1, 2])), "weight of class 0 at node 0"),
        (graph(stump(class_ids=[0, 1, 0, 2])), "weight of class 2 at node 2"),
    ],
)  # fmt: skip
def test_what_is_not_understood_is_refused(model, said):
    with pytest.raises(InputError, match=said):
        from_onnx(model.SerializeToString())


def test_operators_of_a_models_own_are_refused():
    model = graph(stump(), main=18)
    body = [helper.make_node("Neg", ["a"], ["b"])]
    model.functions.append(
        helper.make_function("ai.onnx.ml", "TreeEnsembleClassifier", ["a"], ["b"], body, [helper.make_opsetid("", 18)])
    )
    with pytest.raises(InputError, match="operators of its own"):
        from_onnx(model.SerializeToString())


def test_hostile_names_are_shown_escaped():
    odd = helper.make_node("Neg\u200b\n", ["x"], ["label"], name="\x1b[31mred\r")
    with pytest.raises(InputError) as caught:
        from_onnx(graph(odd).SerializeToString())
    assert [part.isprintable() for part in str(caught.value).splitlines()] == [True] * 3


def test_what_is_no_model_is_said(tmp_path):
    (tmp_path / "model.onnx").write_bytes(graph(stump()).SerializeToString())
    for path in (tmp_path / "model.onnx", str(tmp_path / "model.onnx")):
        assert from_onnx(path).agents[0].tree.threshold[0] == 0.5
    with pytest.raises(InputError, match="not an ONNX model"):
        from_onnx(b"hello")
    with pytest.raises(InputError, match="cannot read"):
        from_onnx(str(tmp_path / "nothing.onnx"))
    with pytest.raises(InputError, match="has 0 nodes"):
        from_onnx(b"")
    twice = graph(stump(), node("Identity", "scores", "label"))
    with pytest.raises(InputError, match="not a valid ONNX model"):
        from_onnx(twice.SerializeToString())


@pytest.mark.parametrize("n_actions", [2, 3])
def test_our_own_models_come_back(profile, n_actions):
    profile = with_trees({"agent_0": tree((3, 0.1, 1, 2), 1, 0)}, profile)
    policy = profile.policy("agent_0")
    agents = (replace(policy, actions=policy.actions[:n_actions]), *(p for p in profile.agents if p is not policy))
    files = emit(replace(profile, agents=agents), ["onnx-old"])  # which onnxruntime before ai.onnx.ml 5 runs, too
    (content,) = (each for name, each in files.items() if "agent_0" in name)
    back = same(onnx.load_model_from_string(content)).agents[0]
    assert len(back.actions) == n_actions and back.tree.threshold[0] == policy.tree.threshold[0]


def test_a_classifier_that_has_seen_one_class_is_one_leaf():
    skl2onnx = pytest.importorskip("skl2onnx", reason="skl2onnx is not installed")
    model = skl2onnx.to_onnx(DecisionTreeClassifier().fit(np.zeros((4, 2)), [3] * 4), np.zeros((1, 2), np.float32))
    (policy,) = from_onnx(model.SerializeToString()).agents
    assert len(policy.features) == 2 and ir.act(policy, np.ones((5, 2), np.float32)).tolist() == [3] * 5
