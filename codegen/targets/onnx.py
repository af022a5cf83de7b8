"""ONNX: a model for each agent, one TreeEnsembleClassifier, for runtimes that load files.

Does: emits PREFIX_AGENT.onnx: `x`, [N, n_features] in the agent's numbers, in; `action`, int64 [N], the action's
  number, out.
Assumes: the package onnx; a runtime with ai.onnx.ml that keeps subnormal numbers (onnxruntime does, unless told to set
  denormals to zero).
Does not: round for its user: doubles become float32 first, as for the reference, where float32 is compared.

One file per agent: agents observe different numbers of features, and a runtime's session holds one model, which whoever
deploys one agent loads alone. BRANCH_LEQ compares the input's numbers, and missing values (NaN) do not track true, so
NaN goes right. Each leaf has a weight for every class, 1 for its own and 0 for the others, and there are two classes at
least: runtimes read ensembles whose leaves name one class only as binary, and answer another class then.
"""

from importlib import import_module
from typing import Any

import numpy as np

from codegen import ir
from codegen.errors import MissingToolError
from codegen.lowering.model import Agent, Model
from codegen.lowering.render import comment

OPSETS = {"": 13, "ai.onnx.ml": 1}  # old ones, which every runtime of today reads
DOUBLE_OPSETS = {"": 13, "ai.onnx.ml": 3}  # the first with thresholds of float64
IR_VERSION = 7
INPUT, OUTPUT = "x", "action"
FEWEST_CLASSES = 2


def emit(model: Model, profile: ir.PolicyProfile) -> dict[str, bytes]:
    """The models. MissingToolError without the package onnx."""
    try:
        onnx: Any = import_module("onnx")
    except ImportError:
        raise MissingToolError("writing ONNX needs the package onnx", "--target onnx", "pip install onnx") from None
    return {
        f"{model.prefix}_{agent.lower}.onnx": _serialized(onnx, model, agent, policy.tree)
        for agent, policy in zip(model.agents, profile.agents, strict=True)
    }


def _serialized(onnx: Any, model: Model, agent: Agent, tree: ir.Tree) -> bytes:
    helper, kind = onnx.helper, onnx.TensorProto
    given = kind.FLOAT if agent.single else kind.DOUBLE
    names = helper.make_tensor_value_info(INPUT, given, ["N", len(agent.features)])
    answer = helper.make_tensor_value_info(OUTPUT, kind.INT64, ["N"])
    ensemble = helper.make_node(
        "TreeEnsembleClassifier",
        [INPUT],
        [OUTPUT, "scores"],
        domain="ai.onnx.ml",
        post_transform="NONE",
        **_typed(onnx, agent, _nodes(tree) | _classes(tree, max(len(agent.actions), FEWEST_CLASSES))),
    )
    made = helper.make_model(
        helper.make_graph([ensemble], f"{model.prefix}_{agent.lower}", [names], [answer]),
        opset_imports=[helper.make_opsetid(*each) for each in (OPSETS if agent.single else DOUBLE_OPSETS).items()],
        ir_version=IR_VERSION,
        producer_name=comment(model.tool),
    )
    helper.set_model_props(
        made,
        {
            "profile": model.content_hash,
            "agent": agent.name,
            "features": ",".join(feature.name for feature in agent.features),
            "actions": ",".join(action.name for action in agent.actions),
            **({"labels": agent.labels.json} if agent.labels else {}),
            "made_by": comment(f"{model.algorithm}, preset {model.preset}, seed {model.seed}"),
        },
    )
    onnx.checker.check_model(made, full_check=True)
    return made.SerializeToString(deterministic=True)


def _typed(onnx: Any, agent: Agent, attributes: dict[str, list[Any]]) -> dict[str, Any]:
    """The attributes, with numbers of float64 where that is compared: they are tensors there."""
    if agent.single:
        return attributes
    doubles = {name: attributes.pop(name) for name in ("nodes_values", "class_weights")}
    made = {f"{name}_as_tensor": onnx.numpy_helper.from_array(np.array(each)) for name, each in doubles.items()}
    return {**attributes, **made}


def _nodes(tree: ir.Tree) -> dict[str, list[Any]]:
    """The splits; a leaf's feature, threshold and children are 0, which nobody reads."""
    split, n = tree.feature != ir.NO_FEATURE, len(tree.feature)
    return {
        "nodes_treeids": [0] * n,
        "nodes_nodeids": list(range(n)),
        "nodes_modes": ["BRANCH_LEQ" if each else "LEAF" for each in split],
        "nodes_featureids": np.where(split, tree.feature, 0).tolist(),
        "nodes_values": tree.threshold.tolist(),
        "nodes_truenodeids": np.where(split, tree.left, 0).tolist(),
        "nodes_falsenodeids": np.where(split, tree.right, 0).tolist(),
        "nodes_missing_value_tracks_true": [0] * n,
    }


def _classes(tree: ir.Tree, n_classes: int) -> dict[str, list[Any]]:
    """The leaves: which class each one scores with 1. Weights of a node lie side by side, as runtimes expect them."""
    leaves = ir.leaves(tree)
    classes = np.arange(n_classes)
    return {
        "classlabels_int64s": classes.tolist(),
        "class_treeids": [0] * (len(leaves) * n_classes),
        "class_nodeids": np.repeat(leaves, n_classes).tolist(),
        "class_ids": np.tile(classes, len(leaves)).tolist(),
        "class_weights": (tree.action[leaves][:, None] == classes).astype(float).ravel().tolist(),
    }
