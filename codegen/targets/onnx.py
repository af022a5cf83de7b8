"""ONNX: a model for each agent, with the tree as an operator of today, or as the deprecated one.

Does: emits PREFIX_AGENT.onnx with TreeEnsemble of ai.onnx.ml 5, and PREFIX_AGENT.old.onnx with the operators before
  it: `x`, [N, n_features] in the agent's numbers, in; `action`, int64 [N], the action's number, or `outputs`, [N,
  n_outputs], out.
Assumes: the package onnx; a runtime with ai.onnx.ml whose elementwise operators round to their own type, one after
  the other, and that keeps subnormal numbers (onnxruntime does, unless told to set denormals to zero).
Does not: round for its user: doubles become float32 first, as for the reference, where float32 is compared; import
  onnx before a file is asked for.

One file per agent: agents observe different numbers of features, and a runtime's session holds one model, which
whoever deploys one agent loads alone. Every node of a tree tests `<=`, and missing values (NaN) do not track true, so
NaN goes right. A constant of a sum is its value times 1, of a column of ones. Sums of unlike length have a -0.0
behind their last term: adding it changes no number, not even a zero. No optimiser knows a term, so none leaves out
one that is 0. `Where` gives 0.0 for a -0.0 in its second place under onnxruntime: only bounds stand there.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from importlib import import_module
from operator import attrgetter
from typing import Any, NamedTuple

import numpy as np

from codegen import ir
from codegen.deciding import kind_decided
from codegen.errors import InputError, MissingToolError
from codegen.floats import FLOAT32, FLOAT64
from codegen.lowering.model import Agent, Model
from codegen.lowering.render import comment
from codegen.sums import CONSTANT, DOUBLE_SUMS, choose_numbers

DOMAIN = "ai.onnx.ml"
FEWEST_CLASSES = 2


def new(onnx: Any, tree: ir.Tree, numbers: str, rows: str, number: str) -> list[Any]:
    """Nodes of TreeEnsemble: `rows` [N, n] of these numbers in, the leaf's `number`, int64 [N], out."""
    make = onnx.helper.make_node
    # splits and leaves in two lists, each in preorder; a tree of one leaf is a split with that leaf on both sides
    splits, leaves = list(ir.splits(tree)), [int(leaf) for leaf in ir.leaves(tree)]
    alone = not splits
    place = {node: index for index, node in enumerate(splits)} | {leaf: index for index, leaf in enumerate(leaves)}
    sides = {
        side: [0] if alone else [int(getattr(tree, attribute)[node]) for node in splits]
        for side, attribute in (("true", "left"), ("false", "right"))
    }
    children = {f"nodes_{side}nodeids": [place[node] for node in nodes] for side, nodes in sides.items()}
    leaf = (tree.feature == ir.NO_FEATURE).astype(int)
    ends = {f"nodes_{side}leafs": leaf[nodes].tolist() for side, nodes in sides.items()}
    tensor = onnx.numpy_helper.from_array
    attributes = {
        **children,
        **ends,
        "n_targets": 1,
        "tree_roots": [0],
        "nodes_modes": tensor(np.zeros(max(1, len(splits)), np.uint8)),  # BRANCH_LEQ
        "nodes_featureids": [0] if alone else tree.feature[splits].tolist(),
        "nodes_splits": tensor(np.zeros(1, numbers) if alone else tree.threshold[splits].astype(numbers)),
        "nodes_missing_value_tracks_true": [0] * max(1, len(splits)),
        "leaf_targetids": [0] * len(leaves),
        "leaf_weights": tensor(tree.action[leaves].astype(numbers)),
    }
    return [
        make("TreeEnsemble", [rows], ["weight"], domain=DOMAIN, **attributes),
        make("Cast", ["weight"], ["weight_int"], to=onnx.TensorProto.INT64),
        make("Reshape", ["weight_int", "all_rows"], [number]),
    ]


def old_classes(onnx: Any, tree: ir.Tree, numbers: str, n_actions: int, rows: str, number: str) -> list[Any]:
    """The node of TreeEnsembleClassifier: a class for each action.

    Each leaf has a weight for every class, 1 for its own and 0 for the others, and there are two classes at least:
    runtimes read ensembles whose leaves name one class only as binary, and answer another class then.
    """
    leaves, classes = ir.leaves(tree), np.arange(max(n_actions, FEWEST_CLASSES))
    attributes = _nodes(tree) | {  # weights of a node lie side by side, as runtimes expect them
        "classlabels_int64s": classes.tolist(),
        "class_treeids": [0] * (len(leaves) * len(classes)),
        "class_nodeids": np.repeat(leaves, len(classes)).tolist(),
        "class_ids": np.tile(classes, len(leaves)).tolist(),
        "class_weights": (tree.action[leaves][:, None] == classes).astype(float).ravel().tolist(),
    }
    more = _pack_doubles(onnx, attributes, ("nodes_values", "class_weights"), numbers)
    node = onnx.helper.make_node
    return [node("TreeEnsembleClassifier", [rows], [number, "scores"], domain=DOMAIN, post_transform="NONE", **more)]


def old_numbers(onnx: Any, tree: ir.Tree, numbers: str, rows: str, number: str) -> list[Any]:
    """Nodes of TreeEnsembleRegressor, which gives the leaf's number."""
    leaves, make = ir.leaves(tree), onnx.helper.make_node
    attributes = _nodes(tree) | {
        "n_targets": [1],
        "target_treeids": [0] * len(leaves),
        "target_nodeids": leaves.tolist(),
        "target_ids": [0] * len(leaves),
        "target_weights": tree.action[leaves].astype(float).tolist(),
    }
    more = _pack_doubles(onnx, attributes, ("nodes_values", "target_weights"), numbers)
    more["n_targets"] = 1
    return [
        make("TreeEnsembleRegressor", [rows], ["weight"], domain=DOMAIN, post_transform="NONE", **more),
        make("Cast", ["weight"], ["weight_int"], to=onnx.TensorProto.INT64),
        make("Reshape", ["weight_int", "all_rows"], [number]),
    ]


def _pack_doubles(
    onnx: Any, attributes: Mapping[str, list[Any]], named: tuple[str, str], numbers: str
) -> dict[str, Any]:
    """The attributes, with numbers of float64 where that is compared: they are tensors there."""
    if numbers != FLOAT64:
        return dict(attributes)
    made = {f"{name}_as_tensor": onnx.numpy_helper.from_array(np.array(attributes[name])) for name in named}
    return {**{name: each for name, each in attributes.items() if name not in named}, **made}


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


class Adding:
    """The nodes and constants of one model's sums."""

    def __init__(self, onnx: Any, arithmetic: str) -> None:
        self._onnx, self._numbers = onnx, choose_numbers(arithmetic)
        self.nodes: list[Any] = []
        self.constants: list[Any] = []

    def widen(self, tree: ir.Tree, seen: str, n_features: int) -> tuple[str, ir.Tree]:
        """The observations `seen` with the values of inner sums as further columns, and the tree with sums of these."""
        column: dict[str, int] = {}  # by text, which tells -0.0 from 0.0

        def flatten(each: ir.Sum) -> ir.Sum:
            return ir.Sum(tuple((weight, column.get(repr(place), place)) for weight, place in each.terms))

        inner = [part for each in tree.all_sums for part in each.parts() if part is not each]
        for text, part in {repr(part): part for part in sorted(inner, key=attrgetter("depth"))}.items():
            seen = self.concat_columns(seen, self.emit_sums([flatten(part)], seen))
            column[text] = n_features + len(column)
        vectors = tuple(tuple(map(flatten, vector)) for vector in tree.vectors)
        return seen, replace(tree, sums=tuple(map(flatten, tree.sums)), vectors=vectors)

    def emit_sums(self, sums: Sequence[ir.Sum], seen: str) -> str:
        """The name of the values of sums, [N, n_sums], of the observations `seen`."""
        return self._add_terms(_places([list(sums)]), seen, None)

    def emit_outputs(self, policy: ir.AgentPolicy, tree: ir.Tree, seen: str, leaf: str, name: str) -> None:
        """Emits what the leaf numbered `leaf` [N] gives, cut and rounded, as `name` [N, n_outputs]."""
        if any(bound == 0 and np.signbit(bound) for each in policy.outputs for bound in (each.low, each.high)):
            what = f"a bound of {policy.agent} is -0.0, for which onnxruntime's Where gives 0.0"
            raise InputError(what, "--target onnx", "let the bound be 0.0, or leave the target out")
        value = self._add_terms(_places([list(vector) for vector in tree.vectors]), seen, leaf)
        low = [-np.inf if output.low is None else output.low for output in policy.outputs]
        high = [np.inf if output.high is None else output.high for output in policy.outputs]
        for bound, beyond in ((low, "Less"), (high, "Greater")):
            limit = self._constant(np.array(bound, self._numbers))
            value = self._node("Where", self._node(beyond, value, limit), limit, value)
        kind = self._onnx.helper.np_dtype_to_tensor_dtype(np.dtype(tree.gives))
        self.nodes.append(self._onnx.helper.make_node("Cast", [value], [name], to=kind))

    def cast(self, seen: str) -> str:
        """The observations in the numbers of sums."""
        kind = self._onnx.helper.np_dtype_to_tensor_dtype(np.dtype(self._numbers))
        return self._node("Cast", seen, to=kind)

    def concat_columns(self, *names: str) -> str:
        """Columns side by side."""
        return self._node("Concat", *names, axis=1)

    def _add_terms(self, places: "Sequence[_Place]", seen: str, leaf: str | None) -> str:
        one = self._constant(np.array(1, self._numbers))
        seen = self._node("Pad", seen, self._constant(np.array([0, 0, 0, 1], np.int64)), one)
        terms = [self._term(place, seen, leaf) for place in places]
        total = terms[0]
        for term in terms[1:]:
            total = self._node("Add", total, term)
        return total

    def _term(self, place: "_Place", seen: str, leaf: str | None) -> str:
        if leaf is None:
            feature = self._node("Gather", seen, self._constant(place.feature[0]), axis=1)
        else:
            feature = self._node("GatherElements", seen, self._look_up_row(place.feature, leaf), axis=1)
        return self._node("Mul", feature, self._look_up_row(place.weight.astype(self._numbers), leaf))

    def _look_up_row(self, table: Any, leaf: str | None) -> str:
        """A row of a table for each observation, by its leaf; or the only row."""
        return self._constant(table[0]) if leaf is None else self._node("Gather", self._constant(table), leaf, axis=0)

    def _constant(self, values: Any) -> str:
        name = f"constant_{len(self.constants)}"
        self.constants.append(self._onnx.numpy_helper.from_array(np.array(values, order="C"), name))
        return name

    def _node(self, operator: str, *inputs: str, **attributes: int) -> str:
        name = f"value_{len(self.nodes)}"
        self.nodes.append(self._onnx.helper.make_node(operator, list(inputs), [name], **attributes))
        return name


class _Place(NamedTuple):
    """The terms at one place in all sums, [rows, sums] each: a weight and its feature; -1: the last column, of ones."""

    weight: Any
    feature: Any


def _places(rows: Sequence[Sequence[ir.Sum]]) -> list[_Place]:
    """The terms of sums, one place after the other."""
    places: list[_Place] = []
    for place in range(max(len(each.terms) for row in rows for each in row)):
        terms = [[_term(each, place) for each in row] for row in rows]
        weights, features = ([[term[part] for term in row] for row in terms] for part in (0, 1))
        places.append(_Place(np.array(weights, np.float64), np.array(features, np.int64)))
    return places


def _term(each: ir.Sum, place: int) -> tuple[float, int]:
    weight, weighed = each.terms[place] if place < len(each.terms) else (-0.0, CONSTANT)
    assert not isinstance(weight, Fraction), "sums that divide are refused before"
    assert not isinstance(weighed, ir.Sum), "inner sums are columns by now"
    return weight, weighed


NEW_OPSETS, NEW_IR = {"": 13, "ai.onnx.ml": 5}, 10  # onnxruntime 1.20 has them
OLD_OPSETS, OLD_IR = {"": 13, "ai.onnx.ml": 1}, 7  # which every runtime of today reads
DOUBLE_OPSETS = {"": 13, "ai.onnx.ml": 3}  # the first with thresholds of float64
INPUT, OUTPUT, NUMBERS = "x", "action", "outputs"
NEW_TARGET, OLD_TARGET = "onnx", "onnx-old"


def emit(model: Model, profile: ir.PolicyProfile, *, old: bool = False) -> dict[str, bytes]:
    """The models with TreeEnsemble; if `old`, with TreeEnsembleClassifier or TreeEnsembleRegressor. MissingToolError
    without the package onnx.
    """
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
    # from observations to actions or outputs: sums that are tested, the tree, sums that its leaf gives
    tree, adding = policy.tree, Adding(onnx, policy.tree.arithmetic)
    seen = adding.cast(INPUT) if tree.arithmetic == DOUBLE_SUMS else INPUT
    compared = tree.compared if tree.sums else policy.numbers
    wide, tree = adding.widen(tree, seen, len(policy.features))
    asked = INPUT if not tree.sums else adding.concat_columns(seen, adding.emit_sums(tree.sums, wide))
    leaf = "vector" if policy.outputs else OUTPUT
    if not old:
        chosen = new(onnx, tree, compared, asked, leaf)
    elif policy.outputs:
        chosen = old_numbers(onnx, tree, compared, asked, leaf)
    else:
        chosen = old_classes(onnx, tree, compared, len(policy.actions), asked, leaf)
    nodes = [*adding.nodes, *chosen]
    if policy.outputs:
        before = len(adding.nodes)
        adding.emit_outputs(policy, tree, wide, leaf, NUMBERS)
        nodes += adding.nodes[before:]
    reshaped = any(node.op_type == "Reshape" for node in chosen)
    flat = [onnx.numpy_helper.from_array(np.array([-1], np.int64), "all_rows")] if reshaped else []
    if policy.outputs:
        answer = helper.make_tensor_value_info(NUMBERS, _kind(onnx, tree.gives), ["N", len(policy.outputs)])
    else:
        answer = helper.make_tensor_value_info(OUTPUT, onnx.TensorProto.INT64, ["N"])
    graph = helper.make_graph(
        nodes,
        f"{model.prefix}_{agent.lower}",
        [helper.make_tensor_value_info(INPUT, _kind(onnx, policy.numbers), ["N", len(agent.features)])],
        [answer],
        initializer=[*adding.constants, *flat],
    )
    made = helper.make_model(
        graph,
        opset_imports=[helper.make_opsetid(*each) for each in opsets.items()],
        ir_version=OLD_IR if old else NEW_IR,
        producer_name=comment(model.tool),
    )
    stated = {
        "profile": model.content_hash,
        "agent": agent.name,
        "features": ",".join(feature.name for feature in agent.features),
        kind_decided(policy): ",".join(each.name for each in policy.outputs or agent.actions),
        **({"labels": agent.labels.json} if agent.labels else {}),
        "made_by": comment(f"{model.algorithm}, preset {model.preset}, seed {model.seed}"),
    }
    helper.set_model_props(made, stated)
    onnx.checker.check_model(made, full_check=True)
    return made.SerializeToString(deterministic=True)


def _kind(onnx: Any, numbers: str) -> int:
    return onnx.TensorProto.FLOAT if numbers == FLOAT32 else onnx.TensorProto.DOUBLE
