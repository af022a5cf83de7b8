"""Operators before an ONNX tree: folded into its thresholds as onnxruntime computes them, or refused by name."""

import numpy as np
import pytest
from sklearn.compose import make_column_transformer
from sklearn.decomposition import PCA
from sklearn.feature_selection import SelectKBest
from sklearn.impute import SimpleImputer
from sklearn.pipeline import FeatureUnion, make_pipeline
from sklearn.preprocessing import Binarizer, KBinsDiscretizer, MaxAbsScaler, MinMaxScaler, RobustScaler, StandardScaler
from sklearn.tree import DecisionTreeClassifier

from codegen import ir
from codegen.errors import InputError
from codegen.importers.onnx.model import from_onnx
from tests.codegen.importers.onnx.graphs import (
    FLOAT,
    ROWS,
    THREE,
    TWO,
    WIDTH,
    converted,
    graph,
    helper,
    onnx,
    same,
    stump,
    value,
)  # fmt: skip

INT64, DOUBLE, BOOL = onnx.TensorProto.INT64, onnx.TensorProto.DOUBLE, onnx.TensorProto.BOOL
ML = "ai.onnx.ml"


def constant(name, numbers, kind=FLOAT):
    array = np.array(numbers)
    return helper.make_tensor(name, kind, array.shape, array.reshape(-1).tolist())


def before(*nodes, constants=(), main=13, tree=None):
    """A stump that tests column 1 of "x", which the nodes make of "y"."""
    made = [helper.make_node(kind, given, out, domain=domain, name=f"my {kind} {out[0]}", **more)
            for kind, given, out, domain, more in nodes]  # fmt: skip
    return graph(*made, tree or stump(), given=["y"], initializers=constants, main=main)


def one(kind, *given, domain="", **more):
    return (kind, list(given) or ["y"], ["x"], domain, more)


def step(kind, given, out, domain="", **more):
    return (kind, given, [out], domain, more)


FOUR = [0.3, -1.7, 2.0, 4.0]
C, S = constant("c", FOUR), constant("s", 0.3)
D = constant("d", FOUR, DOUBLE)
FOLDED = {
    "scaler": before(one("Scaler", domain=ML, offset=FOUR, scale=[1.1, 0.07, 2.0, 3.0])),
    "scaler, one number": before(one("Scaler", domain=ML, offset=[0.1], scale=[-0.7])),
    "add": before(one("Add", "y", "c"), constants=[C]),
    "add, the constant first": before(one("Add", "c", "y"), constants=[C]),
    "sub": before(one("Sub", "y", "s"), constants=[S]),
    "sub, the constant first": before(one("Sub", "c", "y"), constants=[C]),
    "mul": before(one("Mul", "y", "c"), constants=[C]),
    "mul, one row": before(one("Mul", "y", "c"), constants=[constant("c", [FOUR])]),
    "mul, tiny": before(one("Mul", "y", "c"), constants=[constant("c", 1e-39)]),
    "mul, huge": before(one("Mul", "y", "c"), constants=[constant("c", 3e38)]),
    "div": before(one("Div", "y", "c"), constants=[C]),
    "div, tiny": before(one("Div", "y", "c"), constants=[constant("c", -1e-30)]),
    "neg": before(one("Neg")),
    "clip": before(one("Clip", "y", "", "c"), constants=[constant("c", 2.0)]),
    "clip, both": before(one("Clip", "y", "s", "c"), constants=[S, constant("c", 2.0)]),
    "clip, as attributes": before(one("Clip", min=-1.0, max=0.7), main=6),
    "imputer": before(one("Imputer", domain=ML, imputed_value_floats=[0.1], replaced_value_float=float("nan"))),
    "binarizer": before(one("Binarizer", domain=ML, threshold=0.3)),
    "identity": before(step("Identity", ["y"], "z"), one("Identity", "z")),
    "flatten": before(one("Flatten")),
    "reshape": before(one("Reshape", "y", "k"), constants=[constant("k", [-1, WIDTH], INT64)]),
    "doubles": before(step("Cast", ["y"], "a", to=DOUBLE), step("Mul", ["a", "d"], "b"), one("Cast", "b", to=FLOAT),
                      constants=[D]),
    "extractor": before(one("ArrayFeatureExtractor", "y", "k", domain=ML), constants=[constant("k", [3, 2], INT64)]),
    "gather": before(one("Gather", "y", "k", axis=1), constants=[constant("k", [0, -1, 0], INT64)]),
    "slice": before(one("Slice", "y", "k", "l", "m"), constants=[
        constant("k", [1], INT64), constant("l", [99], INT64), constant("m", [1], INT64)]),
    "concat": before(step("Neg", ["y"], "a"), step("Mul", ["y", "s"], "b"), one("Concat", "b", "a", axis=1),
                     constants=[S], tree=stump(nodes_featureids=[5, 0, 0])),
    "constant": before(step("Constant", [], "c", value=C), one("Add", "y", "c")),
    "constant, a number": before(step("Constant", [], "c", value_float=0.1), one("Add", "y", "c")),
    **{f"{kind}{way}": before(step(kind, given, "b"), one("Cast", "b", to=FLOAT), constants=[C], main=16)
       for kind in ("Greater", "GreaterOrEqual", "Less", "LessOrEqual")
       for way, given in (("", ["y", "c"]), (", the constant first", ["c", "y"]))},
    "not": before(step("Less", ["y", "c"], "a"), step("Not", ["a"], "b"), one("Cast", "b", to=FLOAT), constants=[C]),
    "several": before(step("Sub", ["y", "c"], "a"), step("Div", ["a", "c"], "b"), step("Mul", ["b", "s"], "d"),
                      one("Add", "d", "s"), constants=[C, S]),
}  # fmt: skip


@pytest.mark.parametrize("name", FOLDED)
def test_operators_are_folded_as_onnxruntime_computes_them(name):
    tree = same(FOLDED[name]).agents[0].tree
    assert (tree.feature >= 0).sum() == 1, "both sides are reached"


def test_the_threshold_is_the_last_number_that_passes():
    """By arithmetic of its own: (y - o) * s in float32, upwards and downwards from the threshold."""
    offset, scale = np.float32(-1.7), np.float32(0.07)
    at = same(FOLDED["scaler"]).agents[0].tree.threshold[0]
    after = (np.array([at, np.nextafter(at, np.float32(np.inf))], dtype=np.float32) - offset) * scale
    assert after[0] <= 0.5 < after[1]


def test_what_falls_turns_the_tree():
    policy = same(FOLDED["neg"]).agents[0]
    assert ir.act(policy, [[0, -0.5, 0, 0], [0, -0.5001, 0, 0]]).tolist() == [0, 1]
    assert ir.act(policy, [[0, -np.inf, 0, 0], [0, np.inf, 0, 0]]).tolist() == [1, 0]


def test_a_test_that_everything_passes_is_left_out():
    for numbers, action in (([-1.0], 0), ([1.0], 1)):
        model = before(step("Binarizer", ["y"], "a", ML), one("Add", "a", "c"), constants=[constant("c", numbers)])
        assert same(model).agents[0].tree.action.tolist() == [action]


@pytest.mark.parametrize(
    ("name", "kept"),
    [("scaler", True), ("neg", False), ("binarizer", False), ("imputer", False), ("clip", False), ("several", False)],
)
def test_what_becomes_of_nan_is_said(name, kept):
    facts = from_onnx(FOLDED[name].SerializeToString()).provenance.training
    assert (facts["agent_0 NaN"] == "decided as in the origin") == kept


REFUSED = [
    (before(one("Abs")), "not understood: 'Abs'"),
    (before(one("Normalizer", domain=ML)), "not understood: 'Normalizer'"),
    (before(one("MatMul", "y", "c"), constants=[constant("c", np.eye(4))]), "not understood: 'MatMul'"),
    (before(one("OneHotEncoder", domain=ML, cats_strings=["a"])), "not understood: 'OneHotEncoder'"),
    (before(one("Mul", "y", "y")), "mixes columns"),
    (before(step("Neg", ["y"], "a"), one("Add", "y", "a")), "mixes columns"),
    (before(one("Div", "c", "y"), constants=[C]), "divided by a column"),
    (before(one("Mul", "y", "c"), constants=[constant("c", [1, 0, 1, 1])]), "a factor is 0"),
    (before(one("Div", "y", "c"), constants=[constant("c", 0.0)]), "a factor is 0"),
    (before(one("Add", "y", "c"), constants=[constant("c", np.inf)]), "is not finite"),
    (before(one("Add", "y", "c"), constants=[constant("c", [1.0, 2.0, 3.0])]), "no number for each column"),
    (before(one("Add", "y", "c"), constants=[constant("c", np.ones((4, 1)))]), "has the shape"),
    (before(one("Add", "y", "c"), constants=[constant("c", np.ones((1, 1, 4)))]), "has the shape"),
    (before(one("Add", "y", "d"), constants=[D]), "no FLOAT"),
    (before(one("Scaler", domain=ML)), "no number for each column"),
    (before(one("Scaler", domain=ML, offset=[0.0], scale=[0.0])), "a factor is 0"),
    (before(one("Imputer", domain=ML, imputed_value_floats=[0.1])), "a number that may be observed"),
    (before(one("Imputer", domain=ML, imputed_value_floats=[0.1], replaced_value_float=3.0)), "may be observed"),
    (before(step("Cast", ["y"], "a", to=INT64), one("Cast", "a", to=FLOAT)), "a Cast makes INT64"),
    (before(step("Cast", ["y"], "a", to=BOOL), one("Cast", "a", to=FLOAT)), "a Cast makes BOOL"),
    (before(one("Cast", to=DOUBLE)), "works on DOUBLE: 'TreeEnsembleClassifier'"),
    (before(one("Flatten", axis=0)), "changes what is an observation"),
    (before(one("Reshape", "y", "k"), constants=[constant("k", [-1, 2], INT64)]), "changes what is an"),
    (before(one("Reshape", "y", "k"), constants=[constant("k", [1, -1], INT64)]), "changes what is an"),
    (before(one("Gather", "y", "k"), constants=[constant("k", [1, 0], INT64)]), "along the columns"),
    (before(one("Gather", "y", "k", axis=1), constants=[constant("k", 1, INT64)]), "list of whole numbers"),
    (before(one("Gather", "y", "k", axis=1), constants=[constant("k", [4], INT64)]), "that there are not"),
    (before(one("Gather", "y", "k", axis=1), constants=[constant("k", [-5], INT64)]), "that there are not"),
    (before(one("Concat", "y", "y", axis=0)), "along the columns"),
    (before(one("Concat", "y", "c", axis=1), constants=[constant("c", [FOUR])]), "works on constants alone"),
    (before(one("Slice", "y", "k", "l"), constants=[constant(n, [1], INT64) for n in "kl"]), "in their order"),
    (before(one("Add", "c", "c"), constants=[C]), "on constants alone"),
    (before(step("Identity", ["y"], "label2"), one("Neg")), None),
]


@pytest.mark.parametrize(("model", "said"), REFUSED)
def test_what_is_not_known_to_rise_or_fall_is_refused(model, said):
    if said is None:
        assert same(model)
        return
    with pytest.raises(InputError, match=said) as caught:
        from_onnx(model.SerializeToString())
    assert "node" in caught.value.where


def test_constants_in_other_files_are_not_read(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    outside = constant("c", FOUR)
    outside.ClearField("float_data")
    outside.data_location = onnx.TensorProto.EXTERNAL
    outside.external_data.add(key="location", value="c")
    (tmp_path / "c").write_bytes(np.array(FOUR, dtype=np.float32).tobytes())
    with pytest.raises(InputError, match="another file"):
        from_onnx(before(one("Add", "y", "c"), constants=[outside]).SerializeToString())


def test_graphs_that_grow_without_end_are_refused():
    doubled = [step("Concat", [f"v{place}", f"v{place}"], f"v{place + 1}", axis=1) for place in range(30)]
    with pytest.raises(InputError, match="columns"):
        from_onnx(before(step("Identity", ["y"], "v0"), *doubled, one("Identity", "v30")).SerializeToString())
    chain = [step("Add", [f"v{place}", "c"], f"v{place + 1}") for place in range(400)]
    with pytest.raises(InputError, match="256 operators"):
        model = before(step("Identity", ["y"], "v0"), *chain, one("Identity", "v400"), constants=[C])
        from_onnx(model.SerializeToString())


def test_a_model_of_unknown_width_needs_names():
    model = before(one("Scaler", domain=ML, offset=FOUR, scale=[1.0] * 4))
    model.graph.input[0].CopyFrom(value("y", shape=("N", "M")))
    with pytest.raises(InputError, match="how many features"):
        from_onnx(model.SerializeToString())
    assert len(from_onnx(model.SerializeToString(), ["a", "b", "c", "d"]).agents[0].features) == WIDTH


PIPELINES = [
    [StandardScaler()],
    [MinMaxScaler()],
    [MinMaxScaler((-3, 7), clip=True)],
    [MaxAbsScaler(), RobustScaler()],
    [Binarizer(threshold=0.2)],
    [SelectKBest(k=2), StandardScaler()],
    [SimpleImputer()],
    [FeatureUnion([("a", StandardScaler()), ("b", MinMaxScaler())])],
    [make_column_transformer((StandardScaler(), [2, 0]), (Binarizer(), [1]), remainder="passthrough")],
]


@pytest.mark.parametrize("y", [TWO, THREE], ids=["two", "three"])
@pytest.mark.parametrize("steps", PIPELINES, ids=range(len(PIPELINES)))
def test_pipelines_of_scikit_learn_are_folded(steps, y):
    for depth in (3, 7):
        fitted = make_pipeline(*steps, DecisionTreeClassifier(max_depth=depth, random_state=0)).fit(ROWS, y)
        assert same(converted(fitted))


@pytest.mark.parametrize("step", [PCA(2), KBinsDiscretizer(3, encode="ordinal")], ids=lambda each: type(each).__name__)
def test_other_steps_are_refused_by_name(step):
    model = converted(make_pipeline(step, DecisionTreeClassifier(max_depth=4)).fit(ROWS, TWO))
    with pytest.raises(InputError, match=r"not understood: '\w+'") as caught:
        from_onnx(model.SerializeToString())
    assert "operator" in caught.value.where
