"""Bounds that programs cut their sums to come in as bounds of outputs, bit for bit, or are refused with the reason."""

import ctypes

import numpy as np
import pytest

from codegen import ir
from codegen.agreement import probes
from codegen.errors import InputError
from codegen.importers.c.source import from_c
from codegen.importers.origin import Names, profile_of
from codegen.importers.python.source import from_python
from codegen.importers.reading import Said
from tests.support.c_libraries import library
from tests.support.summed import bits

SUM = "{a} * x[0] - {b} * x[1]"
PYTHON = {  # how people cut, and the bounds
    "np.clip({}, -2.0, 1.5)": (-2.0, 1.5),
    "np.clip({}, -2, 2)": (-2.0, 2.0),
    "np.clip({}, a_min=-0.25, a_max=0.75)": (-0.25, 0.75),
    "np.clip({}, 0.0, 1.0)": (0.0, 1.0),
    "max(-2.0, min(1.5, {}))": (-2.0, 1.5),
    "min(max({}, -2.0), 1.5)": (-2.0, 1.5),
    "np.minimum(np.maximum({}, -1.5), 0.75)": (-1.5, 0.75),
    "max({}, 0.0)": (0.0, None),
    "min(max({}, 2.0), 1.0)": (1.0, 1.0),
    "max(min({}, 5.0), -1.0)": (-1.0, 5.0),
}
C = {
    "fmax(-2.0, fmin(1.5, {}))": (-2.0, 1.5),
    "fmin(fmax({}, -2.0), 1.5)": (-2.0, 1.5),
    "fmax({}, -0.5)": (-0.5, None),
}
ZERO = "the sign of the zero there is not known"
ELSEWHERE = "cut to bounds on some paths"


def taken(text, arrays="float64"):
    said = Said(arrays=arrays, outputs=("u",))
    return profile_of(from_python(text.encode(), "policy.py", said), Names(outputs=("u",))).agents[0]


def rows_of(policy):
    spans = tuple(ir.FeatureSpec(each.name, "none", -3.0, 3.0, None) for each in policy.features)
    about = ir.AgentPolicy(policy.agent, policy.team, spans, policy.actions, policy.tree, outputs=policy.outputs)
    rows = np.concatenate(list(probes.telling(about, np.random.default_rng(0))))
    zeros = np.array([[0.0, 0.0], [-0.0, 0.0], [0.0, -0.0], [-0.0, -0.0]], rows.dtype)
    rows = np.concatenate([zeros, rows[np.isfinite(rows).all(axis=1)][:300]])
    return rows[~np.isnan(ir.outputs(policy, rows)).any(axis=1)]  # max(a, NaN) may be a


@pytest.mark.parametrize("arrays", ["float64", "float32"])
@pytest.mark.parametrize(("form", "bounds"), PYTHON.items())
def test_pythons_bounds_are_those_of_outputs(form, bounds, arrays):
    text = f"import numpy as np\ndef act(x):\n    return {form.format(SUM.format(a=1.75, b=0.5))}\n"
    policy = taken(text, arrays)
    (output,) = policy.outputs
    assert (output.low, output.high) == bounds and len(policy.tree.feature) == 1
    space = {}
    exec(compile(text, "policy.py", "exec"), space)
    rows = rows_of(policy)
    with np.errstate(all="ignore"):
        wanted = [float(space["act"](row)) for row in (rows if arrays == "float32" else rows.tolist())]
    assert bits(ir.outputs(policy, rows)[:, 0].tolist()) == bits(wanted)


@pytest.mark.compile
def test_cs_bounds_are_those_of_outputs(tmp_path):
    head = "#include <math.h>\n#pragma STDC FP_CONTRACT OFF\n"
    said = [form.format(SUM.format(a=1.3, b=0.7)) for form in C]
    bodies = {
        f"act{place}": f"void act{place}(const double *x, double *u) {{ u[0] = {each}; }}\n"
        for place, each in enumerate(said)
    }
    compiled = library(head + "".join(bodies.values()), tmp_path)
    for (name, body), bounds in zip(bodies.items(), C.values(), strict=True):
        (policy,) = profile_of(from_c((head + body).encode(), "tree.c"), Names()).agents
        assert (policy.outputs[0].low, policy.outputs[0].high) == bounds
        rows, given = rows_of(policy), np.zeros(1)
        wanted = []
        for row in rows:
            compiled[name](*(each.ctypes.data_as(ctypes.c_void_p) for each in (row, given)))
            wanted.append(float(given[0]))
        assert bits(ir.outputs(policy, rows)[:, 0].tolist()) == bits(wanted)


def test_paths_that_cut_alike_share_bounds_and_others_are_refused():
    text = """
import numpy as np
def act(x):
    if x[0] > x[1]:
        return np.clip(2.0 * x[0], -1.0, 1.0)
    if x[2] > 0:
        return {}
    return np.clip(x[1] - 0.5 * x[2], -1.0, 1.0)
"""
    policy = taken(text.format("1.0"))
    assert (policy.outputs[0].low, policy.outputs[0].high) == (-1.0, 1.0)
    assert ir.outputs(policy, [[0.0, 1.0, 1.0]]).tolist() == [[1.0]]
    for other in ("1.5", "np.clip(x[1], -2.0, 1.0)", "x[1]", "np.clip(1.5, -2.0, 2.0)"):
        with pytest.raises(InputError, match=ELSEWHERE) as caught:
            taken(text.format(other))
        assert "on every path" in caught.value.next_step


def test_each_output_has_its_own_bounds():
    text = """
import numpy as np
def act(x):
    return np.array([np.clip(2.0 * x[0] - x[1], -1.0, 1.0), np.clip(x[1], 0.0, 0.5)])
"""
    said = Said(arrays="float64", outputs=("u", "v"))
    (policy,) = profile_of(from_python(text.encode(), "policy.py", said), Names(outputs=("u", "v"))).agents
    assert [(each.low, each.high) for each in policy.outputs] == [(-1.0, 1.0), (0.0, 0.5)]
    assert ir.outputs(policy, [[3.0, 2.0]]).tolist() == [[1.0, 0.5]]


@pytest.mark.parametrize(
    ("form", "says"),
    [
        ("np.maximum({}, 0.0)", ZERO),
        ("max(0.0, {})", ZERO),
        ("np.clip({}, 0.0, None)", "by what is no number"),
        ("2.0 * np.clip({}, -1.0, 1.0)", "no sum of weighted features"),
        ("np.clip({}, -1.0, 1.0) + x[2]", "two features are added|no sum|are joined"),
    ],
)
def test_what_is_no_bound_is_refused(form, says):
    with pytest.raises(InputError, match=says):
        taken(f"import numpy as np\ndef act(x):\n    return {form.format(SUM.format(a=2.0, b=0.5))}\n")
