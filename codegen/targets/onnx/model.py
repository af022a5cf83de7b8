"""A model of ONNX for each agent, with the tree as an operator of today, or as the deprecated one.

Does: emits PREFIX_AGENT.onnx with TreeEnsemble of ai.onnx.ml 5, and PREFIX_AGENT.old.onnx with the operators before it:
  `x`, [N, n_features] in the agent's numbers, in; `action`, int64 [N], the action's number, or `outputs`,
  [N, n_outputs], out.
Assumes: the package onnx.
Does not: round for its user: doubles become float32 first, as for the reference, where float32 is compared.

One file per agent: agents observe different numbers of features, and a runtime's session holds one model, which whoever
deploys one agent loads alone.
"""

from importlib import import_module
from typing import Any, NamedTuple

import numpy as np

from codegen import ir
from codegen.errors import MissingToolError
from codegen.floats import FLOAT32
from codegen.lowering.model import Agent, Model
from codegen.lowering.render import comment
from codegen.sums import DOUBLE_SUMS
from codegen.targets.onnx import ensembles
from codegen.targets.onnx.sums import Adding

NEW_OPSETS, NEW_IR = {"": 13, "ai.onnx.ml": 5}, 10  # onnxruntime 1.20 has them
OLD_OPSETS, OLD_IR = {"": 13, "ai.onnx.ml": 1}, 7  # which every runtime of today reads
DOUBLE_OPSETS = {"": 13, "ai.onnx.ml": 3}  # the first with thresholds of float64
INPUT, OUTPUT, NUMBERS = "x", "action", "outputs"
NEW_TARGET, OLD_TARGET = "onnx", "onnx-old"


class _Body(NamedTuple):
    """The nodes of a graph and its constants."""

    nodes: list[Any]
    constants: list[Any]


def emit(model: Model, profile: ir.PolicyProfile) -> dict[str, bytes]:
    """The models with TreeEnsemble. MissingToolError without the package onnx."""
    return _files(model, profile, old=False)


def emit_old(model: Model, profile: ir.PolicyProfile) -> dict[str, bytes]:
    """The models with TreeEnsembleClassifier or TreeEnsembleRegressor. Errors as `emit`."""
    return _files(model, profile, old=True)


def _files(model: Model, profile: ir.PolicyProfile, *, old: bool) -> dict[str, bytes]:
    try:
        onnx: Any = import_module("onnx")
    except ImportError:
        target = OLD_TARGET if old else NEW_TARGET
        what = "writing ONNX needs the package onnx"
        raise MissingToolError(what, f"--target {target}", "pip install onnx") from None
    return {
        f"{model.prefix}_{agent.lower}{'.old' if old else ''}.onnx": _serialize_model(
            onnx, model, agent, policy, old=old
        )
        for agent, policy in zip(model.agents, profile.agents, strict=True)
    }


def _serialize_model(onnx: Any, model: Model, agent: Agent, policy: ir.AgentPolicy, *, old: bool) -> bytes:
    helper, opsets = onnx.helper, NEW_OPSETS
    if old:
        opsets = OLD_OPSETS if policy.tree.compared == FLOAT32 and agent.single else DOUBLE_OPSETS
    body = _body(onnx, policy, old=old)
    graph = helper.make_graph(
        body.nodes,
        f"{model.prefix}_{agent.lower}",
        [helper.make_tensor_value_info(INPUT, _kind(onnx, policy.numbers), ["N", len(agent.features)])],
        [_answer(onnx, policy)],
        initializer=body.constants,
    )
    made = helper.make_model(
        graph,
        opset_imports=[helper.make_opsetid(*each) for each in opsets.items()],
        ir_version=OLD_IR if old else NEW_IR,
        producer_name=comment(model.tool),
    )
    helper.set_model_props(made, _facts(model, agent, policy))
    onnx.checker.check_model(made, full_check=True)
    return made.SerializeToString(deterministic=True)


def _kind(onnx: Any, numbers: str) -> int:
    return onnx.TensorProto.FLOAT if numbers == FLOAT32 else onnx.TensorProto.DOUBLE


def _answer(onnx: Any, policy: ir.AgentPolicy) -> Any:
    make = onnx.helper.make_tensor_value_info
    if policy.outputs:
        return make(NUMBERS, _kind(onnx, policy.tree.gives), ["N", len(policy.outputs)])
    return make(OUTPUT, onnx.TensorProto.INT64, ["N"])


def _body(onnx: Any, policy: ir.AgentPolicy, *, old: bool) -> _Body:
    """From observations to actions or outputs: sums that are tested, the tree, sums that its leaf gives."""
    tree, adding = policy.tree, Adding(onnx, policy.tree.arithmetic)
    seen = adding.cast(INPUT) if tree.arithmetic == DOUBLE_SUMS else INPUT
    compared = tree.compared if tree.sums else policy.numbers
    asked = INPUT if not tree.sums else adding.concat_columns(seen, adding.emit_sums(tree.sums, seen))
    leaf = "vector" if policy.outputs else OUTPUT
    if not old:
        chosen = ensembles.new(onnx, tree, compared, asked, leaf)
    elif policy.outputs:
        chosen = ensembles.old_numbers(onnx, tree, compared, asked, leaf)
    else:
        chosen = ensembles.old_classes(onnx, tree, compared, len(policy.actions), asked, leaf)
    nodes = [*adding.nodes, *chosen]
    if policy.outputs:
        before = len(adding.nodes)
        adding.emit_outputs(policy, seen, leaf, NUMBERS)
        nodes += adding.nodes[before:]
    reshaped = any(node.op_type == "Reshape" for node in chosen)
    flat = [onnx.numpy_helper.from_array(np.array([-1], np.int64), "all_rows")] if reshaped else []
    return _Body(nodes, [*adding.constants, *flat])


def _facts(model: Model, agent: Agent, policy: ir.AgentPolicy) -> dict[str, str]:
    """Returns the facts that the file states about itself."""
    given = {"outputs": ",".join(output.name for output in policy.outputs)} if policy.outputs else {}
    return {
        "profile": model.content_hash,
        "agent": agent.name,
        "features": ",".join(feature.name for feature in agent.features),
        **({} if given else {"actions": ",".join(action.name for action in agent.actions)}),
        **given,
        **({"labels": agent.labels.json} if agent.labels else {}),
        "made_by": comment(f"{model.algorithm}, preset {model.preset}, seed {model.seed}"),
    }
