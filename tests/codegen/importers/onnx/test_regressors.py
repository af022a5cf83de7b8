"""Regressors of ONNX: few numbers are labels, many or several at once are what leaves give, as onnxruntime has them."""

import numpy as np
import pytest
from sklearn.ensemble import RandomForestRegressor
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler
from sklearn.tree import DecisionTreeRegressor

from codegen import ir
from codegen.agreement import probes
from codegen.agreement.entries import reference
from codegen.errors import InputError
from codegen.importers.onnx.model import from_onnx
from codegen.importers.scikit import from_sklearn
from codegen.policy_json import dumps, loads
from tests.codegen.importers.onnx.graphs import FLOAT, ROWS, THREE, WIDTH, converted, graph, helper, node, runtime

WANTED = np.stack([ROWS[:, 0] * 2 - ROWS[:, 1], np.abs(ROWS[:, 2])], axis=1)


def numbers(model, profile):
    """The profile's numbers, and the model's under onnxruntime, at thresholds, beside them and at random."""
    (policy,) = profile.agents
    rng = np.random.default_rng(1)
    more = rng.normal(size=(5_000, len(policy.features))).astype(np.float32)
    rows = np.concatenate([probes.boundary(policy.tree, policy.features, rng), more])
    session = runtime.InferenceSession(model.SerializeToString(), providers=["CPUExecutionProvider"])
    (theirs,) = session.run(None, {session.get_inputs()[0].name: rows})
    ours = reference(policy, rows)
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
    """A node with one test of the second feature and two targets at its leaves."""
    given = {
        "nodes_treeids": [0, 0, 0],
        "nodes_nodeids": [0, 1, 2],
        "nodes_modes": ["BRANCH_LEQ", "LEAF", "LEAF"],
        "nodes_featureids": [1, 0, 0],
        "nodes_values": [0.5, 0.0, 0.0],
        "nodes_truenodeids": [1, 0, 0],
        "nodes_falsenodeids": [2, 0, 0],
        "target_treeids": [0] * 4,
        "target_nodeids": [1, 1, 2, 2],
        "target_ids": [0, 1, 0, 1],
        "target_weights": [0.1, -2.0, 0.3, 7.0],
        "n_targets": 2,
    }
    given = {name: value for name, value in (given | more).items() if value is not None}
    return helper.make_node("TreeEnsembleRegressor", ["x"], ["y"], name="the tree", domain="ai.onnx.ml", **given)


@pytest.mark.parametrize("more", [{}, {"base_values": [1e7, -0.3]}, {"aggregate_function": "AVERAGE"}])
def test_values_that_all_leaves_share_are_added_as_onnxruntime_adds_them(more):
    model = graph(stump(**more), made=["y"], label=FLOAT)
    ours, theirs = numbers(model, from_onnx(model.SerializeToString()))
    assert theirs.shape[1] == 2 and np.array_equal(ours, theirs)


@pytest.mark.parametrize(
    ("nodes", "made", "said"),
    [
        ([stump(aggregate_function="MIN")], "y", "not understood"),
        ([stump(post_transform="PROBIT")], "y", "'PROBIT'"),
        ([stump(base_values=[1.0])], "y", "put together"),
        ([stump(target_weights=[0.1, np.inf, 0.3, 7.0])], "y", "not finite"),
        ([stump(target_ids=[0, 0, 0, 1])], "y", "two for one target"),
        ([stump(target_treeids=[0, 0, 1, 1])], "y", "several trees"),
        ([stump(), node("Neg", "y", "z")], "z", "works on the tree's numbers: 'Neg'"),
    ],
)
def test_what_would_change_the_numbers_is_refused(nodes, made, said):
    with pytest.raises(InputError, match=said):
        from_onnx(graph(*nodes, made=[made], label=FLOAT).SerializeToString())


def test_the_width_of_the_input_bounds_what_the_tree_tests():
    with pytest.raises(InputError, match=f"tests feature 9, the input has {WIDTH}"):
        from_onnx(graph(stump(nodes_featureids=[9, 0, 0]), made=["y"], label=FLOAT).SerializeToString())
