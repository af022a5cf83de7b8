"""What the page importing says comes in, and what is near it and refused: all of it is tried."""

import json
import re
import textwrap

import numpy as np
import pytest
from sklearn.compose import make_column_transformer
from sklearn.decomposition import PCA
from sklearn.ensemble import HistGradientBoostingRegressor, RandomForestClassifier, RandomForestRegressor
from sklearn.feature_selection import SelectKBest
from sklearn.model_selection import GridSearchCV
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import Binarizer, MinMaxScaler, StandardScaler
from sklearn.tree import DecisionTreeClassifier, DecisionTreeRegressor

import maviper
from codegen.errors import InputError
from codegen.importers.reading import KINDS
from codegen.profiles import loads
from codegen.targets import emit
from tests.support.importing_page import EXACT, PAGE, REFUSED, ROOT

HEADER = ROOT / "generated/physical_deception/physical_deception.h"
HEADING = "## What can come in"
X = np.random.default_rng(0).normal(size=(300, 3)).astype(np.float32)
Y = (X[:, 0] > 0.1).astype(int) + (X[:, 1] > 0)
SCIKIT = "scikit-learn object"


def python(*lines):
    return "policy.py", "def act(x):\n" + "".join(f"    {line}\n" for line in (*lines, "return 0"))


def onnx(*steps, wanted=Y):
    from skl2onnx import convert_sklearn
    from skl2onnx.common.data_types import FloatTensorType

    pytest.importorskip("skl2onnx", reason="skl2onnx is not installed")
    fitted = make_pipeline(*steps).fit(X, wanted)
    return "tree.onnx", convert_sklearn(fitted, initial_types=[("x", FloatTensorType([None, 3]))]).SerializeToString()


def cut_behind():
    """A regressor whose numbers are cut at -0.5 and 0.5."""
    import onnx as library

    name, content = onnx(DecisionTreeRegressor(max_depth=3), wanted=X[:, 0])
    model = library.load_from_string(content)
    given, ends = model.graph.output[0].name, {"least": -0.5, "most": 0.5}
    for end, value in ends.items():
        model.graph.initializer.append(library.helper.make_tensor(end, library.TensorProto.FLOAT, [], [value]))
    model.graph.node.append(library.helper.make_node("Clip", [given, *ends], ["cut"]))
    model.graph.output[0].name = "cut"
    return name, model.SerializeToString()


def xgboost(n_trees):
    library = pytest.importorskip("xgboost", reason="xgboost is not installed")
    model = library.XGBClassifier(n_estimators=n_trees, max_depth=2, n_jobs=1).fit(X, Y > 0)
    return "tree.json", bytes(model.get_booster().save_raw("json"))


def stopped():
    name, content = xgboost(2)
    document = json.loads(content)
    document["learner"]["attributes"] = {"best_iteration": "0"}
    return name, json.dumps(document)


def lightgbm(**settings):
    library = pytest.importorskip("lightgbm", reason="lightgbm is not installed")
    model = library.LGBMClassifier(**{"n_estimators": 1, "n_jobs": 1, "verbose": -1, **settings})
    return "tree.txt", model.fit(np.where(np.abs(X) < 0.3, 0.0, X), Y > 0).booster_.model_to_string()


def linear():
    library = pytest.importorskip("lightgbm", reason="lightgbm is not installed")
    settings = {"objective": "regression", "linear_tree": True, "num_leaves": 4, "num_threads": 1, "verbose": -1}
    model = library.train(settings, library.Dataset(X, X[:, 0] + np.abs(X[:, 1])), 2)
    return "tree.txt", model.model_to_string(start_iteration=1, num_iteration=1)


def treelite(n_trees):
    library = pytest.importorskip("treelite", reason="treelite is not installed")
    return "tree.json", library.sklearn.import_model(
        RandomForestClassifier(n_trees, max_depth=2).fit(X, Y)
    ).dump_as_json()


def regressor():
    library = pytest.importorskip("treelite", reason="treelite is not installed")
    return "tree.json", library.sklearn.import_model(
        RandomForestRegressor(1, bootstrap=False).fit(X, X[:, 0])
    ).dump_as_json()


def m2cgen():
    library = pytest.importorskip("m2cgen", reason="m2cgen is not installed")
    return library.export_to_c(DecisionTreeClassifier(max_depth=3).fit(X, Y))


def dtcontrol(*labels):
    leaf = {"actual_label": list(labels), "children": [], "split": None}
    sides = [leaf | {"edge_label": "true"}, leaf | {"actual_label": ["right"], "edge_label": "false"}]
    linear = [{"coeff": 0.5, "var": "speed"}, {"coeff": -1.0, "var": "gap"}, {"intercept": 0.1}]
    split = {"lhs": linear, "op": "<=", "rhs": 0}
    return "default.json", json.dumps({"actual_label": None, "children": sides, "split": split})


def summing():
    (header,) = emit(loads((ROOT / "generated/differences/profile.json").read_bytes()), ["c"]).values()
    return header


CASES = [  # from, what, what happens, what it is: a file's name and content, or an object
    ("if/else Python", "`if`, `elif`, `else`, `match`, `a if test else b`, loops over literals", EXACT,
     lambda: python("if x[0] < 0.1:", "    if x[1] >= 2: return 1", "elif x[2] == 0: return 2",
                    "for k, limit in enumerate((0.1, 3)):", "    if x[1] < limit: return k")),
    ("if/else Python", "`and`, `or`, `not`, chained comparisons, `in`, conditions in variables", EXACT,
     lambda: python("fast = 0.1 < x[0] <= 2", "if fast and not (x[1] > 1 or x[2] in (0, 3)): return 1")),
    ("if/else Python", "constants, Enum, classes, helper functions, lambdas", EXACT,
     lambda: ("policy.py", "A = 0.2 * 3\nabove = lambda v: v > A\nclass Cart:\n    def __init__(self, go=2):\n"
              "        self.go = go\n    def act(self, x):\n        return self.go if above(x['v']) else 1\n")),
    ("if/else Python", "arithmetic on one feature, `abs`, `min`, `max`, `int`, `np.clip`", EXACT,
     lambda: python("if abs(2 * x[0] - 1) > 0.5: return int(min(max(x[1], 0), 3))")),
    ("if/else Python", "comparisons of two features, such as `x > y`", EXACT,
     lambda: python("if x[0] > x[1]: return 1")),
    ("if/else Python", "sums of weighted features, with `--arrays`", EXACT,
     lambda: python("if 0.1 * x[0] + 0.3 * x[1] > 0.5: return 1")),
    ("if/else Python", "such sums without it, where roundings depend on it", REFUSED,
     lambda: python("if 0.1 * x[0] + 0.3 * x[1] > 0.5: return 1")),
    ("if/else Python", "returned lists, tuples and arrays of numbers and sums", EXACT,
     lambda: python("if x[0] < 0.1: return [x[1], -x[2]]", "return (1, x[0])")),
    ("if/else Python", "a product of two features, a sum of two sums, a feature twice in a sum", REFUSED,
     lambda: python("if x[0] * x[1] < 1: return 1")),
    ("if/else Python", "state between calls, randomness, files, loops without an end", REFUSED,
     lambda: ("policy.py", "SEEN = []\ndef act(x):\n    SEEN.append(x[0])\n    return len(SEEN)\n")),
    ("ONNX", "one decision tree classifier", EXACT, lambda: onnx(DecisionTreeClassifier(max_depth=3))),
    (
        "ONNX",
        "one decision tree regressor, also of several outputs",
        EXACT,
        lambda: onnx(DecisionTreeRegressor(max_depth=3), wanted=X[:, :2]),
    ),
    ("ONNX", "sums, products with constants, `Clip`, selections behind a regressor", EXACT, lambda: cut_behind()),
    ("ONNX", "scalers, sums and products with constants, clipping before it", EXACT,
     lambda: onnx(StandardScaler(), MinMaxScaler(clip=True), DecisionTreeClassifier(max_depth=3))),
    ("ONNX", "selections, casts, `Concat`, comparisons with constants before it", EXACT,
     lambda: onnx(make_column_transformer((Binarizer(), [2]), (StandardScaler(), [0])),
                  DecisionTreeClassifier(max_depth=3))),
    ("ONNX", "operators that mix features, or may both rise and fall", REFUSED,
     lambda: onnx(PCA(2), DecisionTreeClassifier(max_depth=3))),
    ("our own C header", "every style, with all agents", EXACT, lambda: ("team.h", HEADER.read_text())),
    ("our own C header", "agents that test sums or give numbers", REFUSED, lambda: ("sums.h", summing())),
    ("our own C header", "one with other lines or tests than ours", REFUSED,
     lambda: ("team.h", HEADER.read_text().replace("<= ", "< "))),
    ("if/else C", "arrays, parameters, structs of numbers; `enum`, `#define`, headers", EXACT,
     lambda: ("tree.c", "#include <stdbool.h>\n#define LOW 0.1f\nenum { GO, HALT };\n"
              "struct seen { float v; bool on; };\n"
              "int act(const struct seen *s, double y) { return s->v <= LOW && s->on ? HALT : y < 0.1; }\n")),
    ("if/else C", "`switch`, loops that end, `static` helper functions, tables", EXACT,
     lambda: ("tree.c", "static const float t[] = {1, 2}; static int level(float v) { int i; for (i = 0; i < 2; i++)\n"
              "if (v < t[i]) break; return i; }\nint act(const float *x) { switch (level(x[0])) { case 1: return 5; }\n"
              "return x[1] > 0; }")),
    ("if/else C", "arithmetic on one feature, also in whole numbers; `fabs`, `fmin`", EXACT,
     lambda: ("tree.c", "int act(float v, unsigned char adc) { return fabs(v * 3.6) > 1 ? adc * 5 / 255 : 9; }")),
    ("if/else C", "m2cgen's C, with `--scores`", EXACT, lambda: ("tree.c", m2cgen())),
    ("if/else C", "comparisons and sums of features, numbers that depend on them", EXACT,
     lambda: ("tree.c", "void act(const float *x, float *y) { y[0] = x[0] > x[1] ? x[2] - x[1] : 0.5f; }")),
    ("if/else C", "bits, shifts and wraps of whole numbers of at most 16 bits; `assert`", EXACT,
     lambda: ("tree.c", "#include <assert.h>\n#include <stdint.h>\nint act(uint16_t flags, int8_t level) {\n"
              "assert(level >= 0); return (flags >> 4 & 3) == 2 ? (uint8_t)(level * 3) > 100 : 0; }")),
    ("if/else C", "products that a compiler may join with a sum, products of two features", REFUSED,
     lambda: ("tree.c", "int act(const float *x) { return 0.1f * x[0] > x[1] + 0.3f * x[2]; }")),
    ("if/else C", "state, `goto`, unknown functions, 64-bit features, other wraps", REFUSED,
     lambda: ("tree.c", "static int n; int act(const float *x) { return x[0] > n++; }")),
    ("XGBoost", "one tree, two classes or a number for each leaf, as saved JSON", EXACT, lambda: xgboost(1)),
    ("XGBoost", "the sum of a few trees, as one of at most 4,096 leaves", EXACT, lambda: xgboost(2)),
    ("XGBoost", "larger sums, `best_iteration`, categories, other objectives", REFUSED, lambda: stopped()),
    ("LightGBM", "one tree, two classes or a number for each leaf, as saved text", EXACT, lambda: lightgbm()),
    ("LightGBM", "one tree with linear leaves, of the objective `regression`", EXACT, lambda: linear()),
    ("LightGBM", "the sum of a few trees, as one of at most 4,096 leaves", EXACT, lambda: lightgbm(n_estimators=2)),
    ("LightGBM", "larger sums, means of forests, zeros as missing values, categories", REFUSED,
     lambda: lightgbm(zero_as_missing=True)),
    ("treelite", "one classification tree, as `dump_as_json` writes it", EXACT, lambda: treelite(1)),
    ("treelite", "one regression tree, with numbers to give beyond 64 values", EXACT, lambda: regressor()),
    ("treelite", "forests, categories, other links", REFUSED, lambda: treelite(2)),
    ("dtControl", "`default.json` with axis-aligned and linear splits", EXACT, lambda: dtcontrol("left")),
    ("dtControl", "leaves that permit several actions, with `--prefer`", EXACT, lambda: dtcontrol("left", "up")),
    ("dtControl", "several actions without it, categories, other predicates", REFUSED, lambda: dtcontrol("left", "up")),
    (SCIKIT, "a `DecisionTreeClassifier`", EXACT, lambda: DecisionTreeClassifier(max_depth=3).fit(X, Y)),
    (SCIKIT, "a `GridSearchCV`; a forest, as one tree of at most 4,096 leaves", EXACT,
     lambda: GridSearchCV(RandomForestClassifier(3, random_state=0), {"max_depth": [2, 3]}).fit(X, Y)),
    (SCIKIT, "larger forests, boosters of several trees", REFUSED,
     lambda: RandomForestClassifier(60, random_state=0).fit(X, Y)),
    (SCIKIT, "a `Pipeline` of scalers, selectors and `Binarizer`", EXACT,
     lambda: make_pipeline(StandardScaler(), SelectKBest(k=2), DecisionTreeClassifier(max_depth=3)).fit(X, Y)),
    (SCIKIT, "a `Pipeline` with other steps, such as `PCA`", REFUSED,
     lambda: make_pipeline(PCA(2), DecisionTreeClassifier(max_depth=3)).fit(X, Y)),
    (SCIKIT, "a regressor, or a `GradientBoosting` of one tree, with few values", EXACT,
     lambda: DecisionTreeRegressor(max_depth=3).fit(X, Y)),
    (SCIKIT, "a regressor of several outputs, or of more than 64 values", EXACT,
     lambda: DecisionTreeRegressor().fit(X, X[:, 0] + X[:, 1])),
    (SCIKIT, "a `HistGradientBoosting` with `max_iter=1`, two classes at most", EXACT,
     lambda: HistGradientBoostingRegressor(max_iter=1, max_depth=3).fit(X, Y)),
    ("pickle", "anything: it runs code when it is opened", REFUSED, lambda: ("tree.pkl", b"\x80\x04N.")),
]  # fmt: skip


def stated(cases):
    """What comes in: an item of Markdown for each kind. What is refused says so itself."""
    lines = []
    for kind in dict.fromkeys(case[0] for case in cases if case[2] == EXACT):
        said = "; ".join(what for k, what, outcome, _ in cases if (k, outcome) == (kind, EXACT))
        text = f"- **{kind}**: {said}."
        lines += textwrap.wrap(text, 100, subsequent_indent="  ", break_long_words=False, break_on_hyphens=False)
    return "\n".join(lines) + "\n"


def test_the_page_says_what_is_tried(request):
    text = (ROOT / PAGE).read_text()
    found = re.search(rf"{HEADING}\n\n.*?\n\n((?:- |  )(?:[^\n]+\n)+)", text, re.DOTALL)
    if request.config.getoption("--update-golden"):
        (ROOT / PAGE).write_text(text.replace(found[1], stated(CASES)))
        return
    assert found[1] == stated(CASES)


def test_every_kind_has_an_exact_row_and_a_refused_one():
    for kind in KINDS:
        assert {case[2] for case in CASES if case[0] == kind.called} == {EXACT, REFUSED}, kind.called


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case[0]}: {case[1]}")
def test_what_the_page_says_happens(case, tmp_path):
    given = case[3]()
    if isinstance(given, tuple):
        name, content = given
        (tmp_path / name).write_bytes(content.encode() if isinstance(content, str) else content)
    try:
        if isinstance(given, tuple):
            prefer = ["up", "left"] if "with `--prefer`" in case[1] else None
            arrays = "float64" if "with `--arrays`" in case[1] else None
            scores = "--scores" in case[1]
            profile = maviper.from_file(tmp_path / name, scores=scores, prefer=prefer, arrays=arrays)
        else:
            profile = maviper.from_sklearn(given)
    except InputError as error:
        assert case[2] == REFUSED and error.next_step
        return
    assert case[2] == EXACT and (profile.agents[0].actions or profile.agents[0].outputs)


def test_a_header_with_sums_says_why_it_is_not_read(tmp_path):
    (tmp_path / "sums.h").write_text(summing())
    with pytest.raises(InputError, match=r"agents that test sums or give numbers, which are not read back(.|\n)*hash"):
        maviper.from_file(tmp_path / "sums.h")


def test_an_action_that_was_changed_in_a_header_is_read_as_it_stands(tmp_path):
    changed = re.sub(r"return (\w+_AGENT_0)_UP;", r"return \1_DOWN;", HEADER.read_text())
    (tmp_path / "team.h").write_text(changed)
    policy = next(each for each in maviper.from_file(tmp_path / "team.h").agents if each.agent == "agent_0")
    names = {policy.actions[action].name for action in policy.tree.action[policy.tree.action >= 0]}
    assert changed != HEADER.read_text() and "down" in names and "up" not in names
