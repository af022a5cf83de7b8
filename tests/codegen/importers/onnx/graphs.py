"""Models of ONNX for tests: converted ones, graphs made by hand, and the comparison with onnxruntime."""

import numpy as np
import pytest

from codegen import ir
from codegen.agreement import probes
from codegen.importers.onnx.model import decision_tree, from_onnx
from codegen.importers.origin import NAN_RIGHT

onnx = pytest.importorskip("onnx", reason="onnx is not installed")
runtime = pytest.importorskip("onnxruntime", reason="onnxruntime is not installed")
helper, FLOAT, INT64, STRING = onnx.helper, onnx.TensorProto.FLOAT, onnx.TensorProto.INT64, onnx.TensorProto.STRING

WIDTH = 4
ROWS = np.random.default_rng(0).normal(size=(600, WIDTH)).astype(np.float32)
THREE = (ROWS[:, 0] > ROWS[:, 1]).astype(int) + (ROWS[:, 2] > 0.3)
TWO = (ROWS[:, 0] + 0.3 * ROWS[:, 3] > 0.1).astype(int)


def converted(model, kind="FloatTensorType", width=WIDTH, **options):
    skl2onnx = pytest.importorskip("skl2onnx", reason="skl2onnx is not installed")
    from skl2onnx.common import data_types

    types = [("x", getattr(data_types, kind)([None, width]))]
    return skl2onnx.convert_sklearn(model, initial_types=types, **options)


def same(model, **names):
    """The imported profile, after its decisions were compared with the model's under onnxruntime."""
    content = model.SerializeToString()
    profile = from_onnx(content, **names)
    (policy,) = profile.agents
    session = runtime.InferenceSession(content, providers=["CPUExecutionProvider"])
    kinds = {each.name: each.type for each in session.get_outputs()}
    label = next(name for name, kind in kinds.items() if kind in ("tensor(int64)", "tensor(string)"))
    rng = np.random.default_rng(1)
    rows = np.concatenate(
        [
            probes.boundary(policy.tree, policy.features, rng),
            probes.special(policy.features, rng),
            rng.normal(size=(20_000, len(policy.features))).astype(np.float32),
        ]
    )
    if profile.provenance.training[f"{policy.agent} NaN"] == NAN_RIGHT:
        rows = rows[~np.isnan(rows).any(axis=1)]
    labels = decision_tree(content).labels
    (said,) = session.run([label], {session.get_inputs()[0].name: rows})
    assert [labels[action] for action in ir.act(policy, rows)] == said.tolist()
    return profile


BOTH, FIRST = ({0: 1.0, 1: 0.0}, {0: 0.0, 1: 1.0}), ({0: 0.25}, {0: 0.75})


STUMP = {  # nodes with one test of the second feature
    "nodes_treeids": [0, 0, 0],
    "nodes_nodeids": [0, 1, 2],
    "nodes_modes": ["BRANCH_LEQ", "LEAF", "LEAF"],
    "nodes_featureids": [1, 0, 0],
    "nodes_values": [0.5, 0.0, 0.0],
    "nodes_truenodeids": [1, 0, 0],
    "nodes_falsenodeids": [2, 0, 0],
}


def stump(leaves=BOTH, labels=(0, 1), domain="ai.onnx.ml", outputs=("label", "scores"), **more):
    """A node with STUMP's test, and these weights by class at its leaves."""
    weights = [(place + 1, label, weight) for place, leaf in enumerate(leaves) for label, weight in leaf.items()]
    given = {
        "class_treeids": [0] * len(weights),
        "class_nodeids": [node for node, _, _ in weights],
        "class_ids": [label for _, label, _ in weights],
        "class_weights": [float(weight) for _, _, weight in weights],
        "classlabels_strings" if isinstance(labels[0], str) else "classlabels_int64s": list(labels),
        "post_transform": "NONE",
    }
    given = {name: value for name, value in (STUMP | given | more).items() if value is not None}
    return helper.make_node("TreeEnsembleClassifier", ["x"], list(outputs), name="the tree", domain=domain, **given)


def node(operator, given, made, domain="", **more):
    return helper.make_node(operator, [given], [made], name=f"my {operator}", domain=domain, **more)


def value(name, kind=FLOAT, shape=("N", WIDTH)):
    return helper.make_tensor_value_info(name, kind, shape)


def graph(*nodes, given=("x",), made=("label",), label=INT64, initializers=(), ml=1, main=13, **shape):
    inputs = [each if not isinstance(each, str) else value(each, **shape) for each in given]
    outputs = [value(name, label if "label" in name else FLOAT, ["N"]) for name in made]
    return helper.make_model(
        helper.make_graph(nodes, "g", inputs, outputs, initializer=list(initializers)),
        opset_imports=[helper.make_opsetid("", main), helper.make_opsetid("ai.onnx.ml", ml)],
        ir_version=7,
    )
