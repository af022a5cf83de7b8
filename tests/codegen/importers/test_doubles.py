"""What compares doubles comes in as it is: no difference from the origin for doubles beside its thresholds."""

import math
import re

import numpy as np
import pytest

from codegen import ir
from codegen.errors import InputError
from codegen.importers import reading as kinds
from codegen.importers.c.header import from_header
from codegen.importers.c.source import from_c
from codegen.importers.onnx.model import from_onnx
from codegen.importers.origin import Names, profile_of
from codegen.importers.python.source import from_python
from codegen.importers.scikit import from_sklearn
from codegen.targets import emit
from tests.support.games import NAMES, doubled, random_profile

PYTHON = "def act(x):\n    if x[0] < 0.1 and x[1] >= 1e-3:\n        return 1\n    return 2 if x[1] == 0.3 else 0\n"


def beside(*numbers):
    """Each number and both its neighbours among doubles."""
    return [each for at in numbers for each in (math.nextafter(at, -math.inf), at, math.nextafter(at, math.inf))]


def test_python_decides_doubles_as_python_does():
    (policy,) = profile_of(from_python(PYTHON.encode(), "p.py"), Names()).agents
    assert policy.numbers == "float64" and policy.grown is None
    space = {}
    exec(PYTHON, space)
    rows = [[a, b] for a in beside(0.1, float(np.float32(0.1))) for b in beside(1e-3, 0.3, float(np.float32(0.3)))]
    labels = [int(action.name[-1]) for action in policy.actions]
    assert [labels[action] for action in ir.act(policy, rows)] == [space["act"](row) for row in rows]


def test_float32_can_be_asked_for():
    (policy,) = profile_of(from_python(PYTHON.encode(), "p.py"), Names(), "float32").agents
    assert policy.numbers == "float32" and policy.grown is not None
    assert np.float32(0.1) not in policy.tree.threshold  # x < 0.1: the float32 number beside 0.1 lies above it


@pytest.mark.parametrize(
    "given, numbers",
    [
        ("const float *x", "float32"),
        ("const double *x", "float64"),
        ("double *x", "float64"),
        ("double a, double b", "float64"),
        ("float a, double b", "float64"),
        ("float a, int b", "float64"),  # of 32 bits
        ("float a, short b", "float32"),
    ],
)
def test_c_compares_what_its_parameters_are(given, numbers):
    first, second = ("x[0]", "x[1]") if "*" in given else ("a", "b")
    text = f"int act({given}) {{ if ({first} <= 0.1) {{ return {second} > 0.3 ? 1 : 2; }} return 0; }}"
    (origin,) = from_c(text.encode(), "t.c").values()
    assert origin.numbers == numbers
    (policy,) = profile_of({"act": origin}, Names()).agents
    assert policy.numbers == numbers


@pytest.mark.parametrize("how", ["all", "mixed"])
@pytest.mark.parametrize("style", ["nested", "walk"])
def test_our_header_comes_back(how, style):
    whole = random_profile(NAMES[1])
    profile = doubled(whole, *([whole.agents[0].agent] if how == "mixed" else []))
    (header,) = emit(profile, ["c"], style=style).values()
    found = profile_of(from_header(header.encode(), "team.h"), Names())
    for ours, theirs in zip(profile.agents, found.agents, strict=True):
        assert ours.numbers == theirs.numbers
        assert ours.tree.threshold.tobytes() == theirs.tree.threshold.tobytes()


def test_a_header_whose_tables_round_is_refused():
    header = next(iter(emit(doubled(random_profile(NAMES[1])), ["c"], style="walk").values()))
    rounded = re.sub(r"(extern const|_TABLE) double (\w+_threshold\[)", r"\1 float \2", header)
    assert rounded != header
    with pytest.raises(InputError, match="threshold are of float"):
        from_header(rounded.encode(), "t.h")


def test_onnx_of_float64_comes_back():
    pytest.importorskip("onnx", reason="onnx is not installed")
    profile = doubled(random_profile(NAMES[1]))
    for policy, model in zip(profile.agents, emit(profile, ["onnx"]).values(), strict=True):
        names = [feature.name for feature in policy.features]
        (found,) = from_onnx(model, names, [action.name for action in policy.actions]).agents
        assert found.numbers == "float64"
        assert found.tree.threshold.tobytes() == policy.tree.threshold.tobytes()


def test_scikit_learn_compares_float32():
    """It makes float32 of what it is given, so that a float32 agent decides as it does for every double too."""
    from sklearn.tree import DecisionTreeClassifier

    rng = np.random.default_rng(0)
    x = rng.normal(size=(300, 3))
    model = DecisionTreeClassifier(max_depth=5, random_state=0).fit(x, (x[:, 0] > x[:, 1]).astype(int))
    (policy,) = from_sklearn(model).agents
    assert policy.numbers == "float32"
    rows = rng.normal(size=(2_000, 3))
    for node in ir.splits(policy.tree):
        near = np.repeat(beside(float(model.tree_.threshold[node]), float(policy.tree.threshold[node])), 20)
        part = rng.normal(size=(len(near), 3))
        part[:, policy.tree.feature[node]] = near * (1 + rng.uniform(-1, 1, len(near)) * 2.0**-24)
        rows = np.concatenate([rows, part])
    assert ir.act(policy, rows).tolist() == model.predict(rows).tolist()


def test_what_compares_float32_is_not_made_float64():
    text = b"int act(const float *x) { if (x[0] <= 0.1f) { return 1; } return 0; }"
    with pytest.raises(InputError, match="compares float32, not float64"):
        profile_of(kinds.read(text, "t.c"), Names(), "float64")
