"""Regressors of ONNX: few numbers are labels, many or several at once are what leaves give, as onnxruntime has them."""

import numpy as np
import pytest
from sklearn.ensemble import RandomForestRegressor
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler
from sklearn.tree import DecisionTreeRegressor

from codegen import ir
from codegen.agreement import probes
from codegen.deciding import decide
from codegen.errors import InputError
from codegen.importers.onnx.model import from_onnx
from codegen.importers.scikit import from_sklearn
from codegen.policy_json import dumps
from codegen.profiles import loads
from tests.codegen.importers.onnx.graphs import (
    FLOAT,
    INT64,
    ROWS,
    STUMP,
    THREE,
    WIDTH,
    converted,
    graph,
    helper,
    onnx,
    runtime,
    same,
)

WANTED = np.stack([ROWS[:, 0] * 2 - ROWS[:, 1], np.abs(ROWS[:, 2])], axis=1)


def numbers(model, profile):
    """The profile's numbers, and the model's under onnxruntime, at thresholds, beside them and at random."""
    (policy,) = profile.agents
    rng = np.random.default_rng(1)
    more = rng.normal(size=(5_000, len(policy.features))).astype(np.float32)
    rows = np.concatenate([probes.boundary(policy.tree, policy.features, rng), more])
    session = runtime.InferenceSession(model.SerializeToString(), providers=["CPUExecutionProvider"])
    (theirs,) = session.run(None, {session.get_inputs()[0].name: rows})
    ours = decide(policy, rows)
    if not policy.outputs:
        ours = np.array([action.label for action in policy.actions])[ir.act(policy, rows)][:, None]
    return ours, theirs


@pytest.mark.parametrize(
    ("model", "y", "labels"),
    [
        (DecisionTreeRegressor(max_depth=3, random_state=0), THREE * 1.5 - 1, True),
        (DecisionTreeRegressor(max_depth=9, random_state=0), WANTED[:, 0], False),
        (DecisionTreeRegressor(max_depth=4, random_state=0), WANTED, False),
        (RandomForestRegressor(1, max_depth=3, random_state=0), WANTED[:, 1], True),
        (make_pipeline(StandardScaler(), DecisionTreeRegressor(max_depth=8, random_state=0)), WANTED[:, 1], False),
    ],
    ids=["few values", "many values", "two outputs", "forest of one", "scaled"],
)
def test_regressors_of_scikit_learn_give_what_onnxruntime_gives(model, y, labels):
    content = converted(model.fit(ROWS, y))
    profile = loads(dumps(from_onnx(content.SerializeToString())))
    ours, theirs = numbers(content, profile)
    assert np.array_equal(ours, theirs) and len(np.unique(theirs)) > 2
    assert bool(profile.agents[0].outputs) is not labels
    assert bool(from_sklearn(model).agents[0].outputs) is not labels  # the same rule


def stump(**more):
    """A node with STUMP's test and two targets at its leaves."""
    given = {
        "target_treeids": [0] * 4,
        "target_nodeids": [1, 1, 2, 2],
        "target_ids": [0, 1, 0, 1],
        "target_weights": [0.1, -2.0, 0.3, 7.0],
        "n_targets": 2,
    }
    given = {name: value for name, value in (STUMP | given | more).items() if value is not None}
    return helper.make_node("TreeEnsembleRegressor", ["x"], ["y"], name="the tree", domain="ai.onnx.ml", **given)


@pytest.mark.parametrize("more", [{}, {"base_values": [1e7, -0.3]}, {"aggregate_function": "AVERAGE"}])
def test_values_that_all_leaves_share_are_added_as_onnxruntime_adds_them(more):
    model = graph(stump(**more), made=["y"], label=FLOAT)
    ours, theirs = numbers(model, from_onnx(model.SerializeToString()))
    assert theirs.shape[1] == 2 and np.array_equal(ours, theirs)


def constant(name, values):
    """A node that gives float32 numbers."""
    tensor = onnx.numpy_helper.from_array(np.array(values, dtype=np.float32))
    return helper.make_node("Constant", [], [name], name=f"constant {name}", value=tensor)


def after(operator, *constants, given="y", made="z", **more):
    """A node behind the tree."""
    return helper.make_node(operator, [given, *constants], [made], name=f"my {operator}", **more)


TURNED = (after("Neg"), after("Clip", "a", given="z", made="w"))  # -0.0 is cut at 0
BEHIND = {
    "clipped": [constant("a", -1.5), constant("b", 0.25), after("Clip", "a", "b")],
    "clipped below": [constant("a", 0.2), after("Clip", "a")],
    "scaled": [
        constant("a", [3.0, -0.1]),
        after("Mul", "a"),
        constant("b", 0.7),
        after("Sub", "b", given="z", made="w"),
    ],
    "divided, then clipped": [
        constant("a", 0.3),
        after("Div", "a"),
        constant("b", -6.5),
        constant("c", 1.0),
        after("Clip", "b", "c", given="z", made="w"),
    ],
    "one of both": [
        helper.make_node("Constant", [], ["a"], name="places", value=onnx.numpy_helper.from_array(np.array([1]))),
        after("Gather", "a", axis=1),
    ],
    "turned": [after("Neg"), after("Identity", given="z", made="w")],
}


@pytest.mark.parametrize("name", BEHIND)
def test_operators_behind_a_regressor_change_what_leaves_give(name):
    nodes = BEHIND[name]
    model = graph(stump(), *nodes, made=[nodes[-1].output[0]], label=FLOAT)
    ours, theirs = numbers(model, from_onnx(model.SerializeToString()))
    assert ours.shape == theirs.shape and np.array_equal(ours, theirs)
    plain = numbers(graph(stump(), made=["y"], label=FLOAT), from_onnx(model.SerializeToString()))[1]
    assert not np.array_equal(plain[: len(theirs)], theirs)


@pytest.mark.parametrize(
    ("nodes", "made", "said"),
    [
        ([stump(aggregate_function="MIN")], "y", "not understood"),
        ([stump(post_transform="PROBIT")], "y", "'PROBIT'"),
        ([stump(base_values=[1.0])], "y", "put together"),
        ([stump(target_weights=[0.1, np.inf, 0.3, 7.0])], "y", "not finite"),
        ([stump(target_ids=[0, 0, 0, 1])], "y", "two for one target"),
        ([stump(target_treeids=[0, 0, 1, 1])], "y", "several trees"),
        ([stump(), after("Abs")], "z", "a node that is not understood: 'Abs'"),
        ([stump(), after("Cast", to=onnx.TensorProto.DOUBLE)], "z", "given as DOUBLE"),
        ([stump(), constant("a", [2.0, 0.0]), after("Mul", "a")], "z", "a factor is 0"),
        (
            [stump(), constant("a", [3e38, 1.0]), after("Mul", "a"), after("Mul", "a", given="z", made="w")],
            "w",
            "finite",
        ),
        ([stump(), after("Add", "x")], "z", "mixes the tree's numbers"),
        ([stump(target_weights=[0.0, 1.0, 2.0, 3.0]), constant("a", 0.0), *TURNED], "w", "either sign"),
        ([stump(), after("Identity")], "y z", "given twice"),
    ],
)
def test_what_would_change_the_numbers_is_refused(nodes, made, said):
    with pytest.raises(InputError, match=said):
        from_onnx(graph(*nodes, made=made.split(), label=FLOAT).SerializeToString())


def ensemble(**more):
    """A node of ai.onnx.ml 5 with two tests and one target."""
    tensor = onnx.numpy_helper.from_array
    given = {
        "n_targets": 1,
        "tree_roots": [0],
        "nodes_featureids": [1, 0],
        "nodes_modes": tensor(np.array([0, 1], np.uint8)),
        "nodes_splits": tensor(np.array([0.5, -0.25], np.float32)),
        "nodes_truenodeids": [1, 0],
        "nodes_trueleafs": [0, 1],
        "nodes_falsenodeids": [2, 1],
        "nodes_falseleafs": [1, 1],
        "leaf_targetids": [0, 0, 0],
        "leaf_weights": tensor(np.array([0.1, -2.5, 7.0], np.float32)),
    }
    return helper.make_node("TreeEnsemble", ["x"], ["y"], name="the tree", domain="ai.onnx.ml", **(given | more))


@pytest.mark.parametrize("behind", [[], [constant("a", -1.0), after("Clip", "a")]], ids=["alone", "clipped"])
def test_the_newer_operator_gives_numbers_too(behind):
    model = graph(ensemble(), *behind, made=["z" if behind else "y"], label=FLOAT, ml=5, main=20)
    model.ir_version = 10
    ours, theirs = numbers(model, from_onnx(model.SerializeToString()))
    assert np.array_equal(ours, theirs) and len(np.unique(theirs)) == 3


@pytest.mark.parametrize("between", [(), ("Identity",), ("Identity", "Identity")], ids=len)
def test_numbers_of_the_newer_operator_that_are_made_whole_are_actions(between):
    names = ["y", *(f"same_{place}" for place in range(len(between)))]
    nodes = [helper.make_node(each, [names[place]], [names[place + 1]]) for place, each in enumerate(between)]
    whole = onnx.numpy_helper.from_array(np.array([2.0, 0.0, 1.0], np.float32))
    nodes.append(helper.make_node("Cast", [names[-1]], ["whole"], to=INT64))
    shape = onnx.numpy_helper.from_array(np.array([-1]), "shape")
    nodes.append(helper.make_node("Reshape", ["whole", "shape"], ["label"]))
    model = graph(ensemble(leaf_weights=whole), *nodes, initializers=[shape], ml=5, main=20)
    model.ir_version = 10
    assert len(same(model).agents[0].actions) == 3


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"leaf_weights": onnx.numpy_helper.from_array(np.array([0.1, np.inf, 7.0], np.float32))}, "not finite"),
        ({"n_targets": 2}, "several trees or targets"),
        ({"post_transform": 4}, "changes its numbers"),
    ],
)
def test_what_would_change_the_numbers_of_the_newer_operator_is_refused(more, said):
    with pytest.raises(InputError, match=said):
        from_onnx(graph(ensemble(**more), made=["y"], label=FLOAT, ml=5, main=20).SerializeToString())


def test_the_width_of_the_input_bounds_what_the_tree_tests():
    with pytest.raises(InputError, match=f"tests feature 9, the input has {WIDTH}"):
        from_onnx(graph(stump(nodes_featureids=[9, 0, 0]), made=["y"], label=FLOAT).SerializeToString())
