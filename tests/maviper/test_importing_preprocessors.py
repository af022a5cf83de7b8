"""Every preprocessor that skl2onnx knows, before a tree: exact or refused, and the page says which."""

import re
import warnings

import numpy as np
import pytest
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import MinMaxScaler, StandardScaler
from sklearn.tree import DecisionTreeClassifier

import maviper
from codegen import ir
from codegen.errors import InputError
from tests.support.importing_page import EXACT, PAGE, REFUSED, ROOT

pytestmark = pytest.mark.interop
skl2onnx = pytest.importorskip("skl2onnx", reason="the extra maviper[interop] is not installed")
runtime = pytest.importorskip("onnxruntime", reason="onnxruntime is not installed")

UNCONVERTED = "not converted"  # by skl2onnx, in a pipeline with a tree
HEADING = "## Preprocessors of scikit-learn"
X = np.abs(np.random.default_rng(0).normal(size=(200, 4))).astype(np.float32)
Y = (X[:, 0] > X[:, 1]).astype(int)
OTHER = {  # no preprocessors of numbers: of texts, records or labels; models; or combinations of other steps
    "CountVectorizer", "DictVectorizer", "FeatureHasher", "TfidfVectorizer", "LabelBinarizer", "LabelEncoder",
    "KernelCenterer", "KMeans", "MiniBatchKMeans", "LinearDiscriminantAnalysis", "PLSRegression", "StackingClassifier",
    "StackingRegressor", "VotingClassifier", "VotingRegressor", "GridSearchCV",
}  # fmt: skip
TREE = DecisionTreeClassifier(max_depth=2, random_state=0)
MADE = {  # parameters, where a preprocessor needs some
    "ColumnTransformer": [([("a", StandardScaler(), [0, 2]), ("b", "passthrough", [1])],), {}],
    "FeatureUnion": [([("a", StandardScaler()), ("b", MinMaxScaler())],), {}],
    "Pipeline": [([("a", StandardScaler()), ("b", MinMaxScaler())],), {}],
    "RFE": [(TREE,), {"n_features_to_select": 2}],
    "RFECV": [(TREE,), {}],
    "SelectFromModel": [(TREE,), {}],
    "SelectKBest": [(), {"k": 2}],
    "SelectPercentile": [(), {"percentile": 50}],
    "SelectFdr": [(), {"alpha": 0.9}],
    "SelectFwe": [(), {"alpha": 0.9}],
    "SelectFpr": [(), {"alpha": 0.9}],
    "GenericUnivariateSelect": [(), {"mode": "k_best", "param": 2}],
    "GaussianRandomProjection": [(), {"n_components": 2, "random_state": 0}],
    "KBinsDiscretizer": [(), {"n_bins": 3, "encode": "ordinal"}],
    "KNeighborsTransformer": [(), {"mode": "distance", "n_neighbors": 2}],
    "MinMaxScaler": [(), {"clip": True}],
    "OneHotEncoder": [(), {"sparse_output": False}],
    "RandomTreesEmbedding": [(), {"n_estimators": 2, "sparse_output": False}],
    "TargetEncoder": [(), {"random_state": 0}],
}
WHOLE = {"OneHotEncoder", "OrdinalEncoder", "TargetEncoder"}  # these take whole numbers
FOUND = {}  # what happened, by preprocessor


def preprocessors():
    from skl2onnx._supported_operators import sklearn_operator_name_map

    found = {each.__name__: each for each in sklearn_operator_name_map if hasattr(each, "transform")}
    return {name: found[name] for name in sorted(found) if name not in OTHER}


def outcome(profile_of, predict):
    """Exact, after a comparison at random, or refused."""
    try:
        profile = profile_of()
    except InputError as error:
        assert error.what and error.next_step
        return REFUSED
    rows = np.random.default_rng(1).normal(size=(2_000, 4)).astype(np.float32)
    assert ir.act(profile.agents[0], rows).tolist() == predict(rows).tolist()
    return EXACT


def converted(fitted, kind):
    from skl2onnx.common import data_types

    content = skl2onnx.convert_sklearn(fitted, initial_types=[("x", getattr(data_types, kind)([None, 4]))])
    content = content.SerializeToString()
    session = runtime.InferenceSession(content, providers=["CPUExecutionProvider"])
    return content, lambda rows: session.run([session.get_outputs()[0].name], {"x": rows})[0]


@pytest.fixture(autouse=True)
def operators_are_not_asked_along_every_path(monkeypatch):
    """skl2onnx asks each operator of a graph whether it is in the graph, once a path: 85 million times for one of
    these. What it writes is loaded and run here.
    """
    from skl2onnx.algebra.onnx_operator import OnnxOperator

    monkeypatch.setattr(OnnxOperator, "_verify_add_to_", lambda operator: None)


@pytest.mark.parametrize("name", preprocessors())
def test_a_preprocessor_ends_in_exact_or_refused(name):
    given, named = MADE.get(name, [(), {}])
    whole = name in WHOLE
    rows = np.floor(X * 2).astype(np.int64) if whole else X
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        fitted = make_pipeline(preprocessors()[name](*given, **named), TREE).fit(rows, Y)
        as_object = outcome(lambda: maviper.from_sklearn(fitted), fitted.predict)
        try:
            content, predict = converted(fitted, "Int64TensorType" if whole else "FloatTensorType")
        except Exception:  # whatever skl2onnx raises, or onnxruntime for what skl2onnx wrote
            FOUND[name] = (UNCONVERTED, as_object)
            return
        FOUND[name] = (outcome(lambda: maviper.from_onnx(content), predict), as_object)


def test_the_page_names_what_was_found():
    if len(FOUND) < len(preprocessors()):
        pytest.skip("needs the tests before it")
    section = (ROOT / PAGE).read_text().split(f"{HEADING}\n")[1].split("\n#")[0]
    converted_ones, _, others = section.partition("As objects")
    converted_ones = converted_ones.partition("skl2onnx converted:")[2]
    found = set(re.findall(r"`(\w+)`", converted_ones))
    assert found == {name for name, (as_onnx, _) in FOUND.items() if as_onnx == EXACT}
    assert found - set(re.findall(r"`(\w+)`", others)) == {name for name, both in FOUND.items() if both[1] == EXACT}
