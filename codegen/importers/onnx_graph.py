"""The one decision tree of an ONNX model, where every node of its graph is understood.

Does: follows the observation to the tree and the tree's label to an output, and reads the tree's attributes as arrays.
Assumes: the package onnx; float32 observations, [N, n_features].
Does not: run a model, or guess. Another operator, another way for an observation or a label, or leaves that runtimes
  read in different ways end in an InputError that names them.
"""

from collections import Counter
from collections.abc import Sequence
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np

from codegen.errors import InputError, MissingToolError
from codegen.ir import NO_ACTION, NO_CHILD, NO_FEATURE, Bool, Float64, GrownTree

TREE, ML, MAIN = "TreeEnsembleClassifier", "ai.onnx.ml", ""
UNDERSTOOD = {(ML, TREE), (ML, "ZipMap"), (MAIN, "Identity"), (MAIN, "Cast")}
OBSERVATION, SCORES, UNKNOWN = "the observation", "the tree's scores", "no value of this graph"
LABELS = {"classlabels_int64s": "the tree's label, INT64", "classlabels_strings": "the tree's label, STRING"}
LESS_EQUAL, LESS, LEAF = "BRANCH_LEQ", "BRANCH_LT", "LEAF"
MAX_OPSET = 4  # of ai.onnx.ml; the operator ends there
FEWEST_CLASSES = 2
MAX_FEATURES = 1 << 20
NODE_LISTS = ("nodes_modes", "nodes_nodeids", "nodes_featureids", "nodes_truenodeids", "nodes_falsenodeids")
CLASS_LISTS = ("class_treeids", "class_nodeids", "class_ids")
HARMLESS = {"nodes_hitrates", "nodes_hitrates_as_tensor", "nodes_missing_value_tracks_true", "post_transform"}
READ = {*NODE_LISTS, *CLASS_LISTS, "nodes_treeids", "nodes_values", "class_weights"}
ADVICE = "export one decision tree classifier alone, fitted on the float32 observations as they are"


class OnnxTree(NamedTuple):
    """What a model decides by: the tree, the labels of its classes, and how many features an observation has."""

    grown: GrownTree
    labels: tuple[int | str, ...]
    n_features: int  # 0: the model does not say
    n_tested: int  # up to the last one that the tree tests
    input: str  # the observation's name in the graph
    output: str  # the name of an output that is the label


def decision_tree(model: bytes) -> OnnxTree:
    """The tree of a model. InputError where it is more than one tree that is understood in full, MissingToolError
    without the package onnx.
    """
    try:
        onnx: Any = import_module("onnx")
    except ImportError:
        raise MissingToolError("reading ONNX needs the package onnx", "", "pip install onnx") from None
    try:
        loaded = onnx.load_model_from_string(model)
    except Exception as error:  # the parser's own class, which moves between versions
        raise InputError("not an ONNX model", str(error)[:200], "is this the right file?") from None
    _ensure_understood(loaded)
    try:
        onnx.checker.check_model(loaded)
    except Exception as error:  # ValidationError, or what the parser of types raises
        raise InputError("not a valid ONNX model", str(error)[:200], "export it again") from None
    node, n_features, output = _only_tree(onnx, loaded.graph)
    given = _attributes(onnx, node)
    labels = tuple(
        each.decode(errors="replace") if isinstance(each, bytes) else each for name in LABELS for each in given[name]
    )
    grown = _grown(given, labels)
    n_tested = int(grown.feature.max()) + 1
    if 0 < n_features < n_tested:
        what = f"the tree tests feature {n_tested - 1}, the input has {n_features}"
        raise InputError(what, _shown(node), "export it again")
    return OnnxTree(grown, labels, n_features, n_tested, loaded.graph.input[0].name, output)


# --- the graph


def _shown(node: Any) -> str:
    """A node, for a person: every text is a repr, since names are anybody's."""
    operator = f"{node.domain}.{node.op_type}" if node.domain else node.op_type
    return f"operator {operator!r}, node {node.name!r}, output {list(node.output)!r}"


def _type(onnx: Any, number: int) -> str:
    """The name of a type of tensor's elements."""
    names = {value: name for name, value in onnx.TensorProto.DataType.items()}
    return names.get(number, f"type {number}")


def _ensure_understood(loaded: Any) -> None:
    if len(loaded.functions):
        raise InputError("the model defines operators of its own", repr(loaded.functions[0].name), ADVICE)
    for node in loaded.graph.node:
        if (MAIN if node.domain == "ai.onnx" else node.domain, node.op_type) not in UNDERSTOOD:
            raise InputError(f"the model has a node that is not understood: {node.op_type!r}", _shown(node), ADVICE)
    n_trees = sum(node.op_type == TREE for node in loaded.graph.node)
    if n_trees != 1:
        raise InputError(f"the model has {n_trees} nodes {TREE}, one is needed", "", ADVICE)
    versions = {each.version for each in loaded.opset_import if each.domain == ML}
    if len(versions) != 1 or not 1 <= min(versions) <= MAX_OPSET:
        found = ", ".join(map(str, sorted(versions))) or "none"
        raise InputError(
            f"version {found} of {ML} is not supported; 1 to {MAX_OPSET} are", "opset_import", "export it again"
        )


def _only_tree(onnx: Any, graph: Any) -> tuple[Any, int, str]:
    """The tree's node, the input's width (0: not declared) and an output that is the label, where each value of the
    graph has a known origin.
    """
    constant = {each.name for each in graph.initializer} | {each.values.name for each in graph.sparse_initializer}
    if len(graph.input) != 1:
        raise InputError(f"the model has {len(graph.input)} inputs, one is needed", "graph.input", ADVICE)
    (given,) = graph.input
    if given.name in constant:
        raise InputError("the model's input has a constant value", repr(given.name), ADVICE)
    tensor = given.type.tensor_type
    if tensor.elem_type != onnx.TensorProto.FLOAT:
        what = f"the model's input is {_type(onnx, tensor.elem_type)}, but observations are FLOAT"
        raise InputError(what, repr(given.name), "export it with a float32 input")
    shape = tensor.shape.dim
    if tensor.HasField("shape") and len(shape) != 2:
        raise InputError(f"the model's input has {len(shape)} axes, two are needed", repr(given.name), ADVICE)
    origins = {given.name: OBSERVATION}
    for node in graph.node:
        made = _outcome(onnx, node, [origins.get(name, UNKNOWN) for name in node.input])
        origins |= dict(zip(node.output, made, strict=False))
    found = {each.name: origins.get(each.name, UNKNOWN) for each in graph.output}
    for name, origin in found.items():
        if origin not in (SCORES, *LABELS.values()):
            raise InputError(f"an output of the model is {origin}", repr(name), ADVICE)
    label = next((name for name, origin in found.items() if origin in LABELS.values()), None)
    if label is None:
        raise InputError("no output of the model is the tree's label", "graph.output", ADVICE)
    tree = next(node for node in graph.node if node.op_type == TREE)
    return tree, int(shape[1].dim_value) if tensor.HasField("shape") else 0, label


def _outcome(onnx: Any, node: Any, origins: Sequence[str]) -> Sequence[str]:
    """What a node's outputs are, given what its inputs are."""
    if len(origins) != 1:
        raise InputError(f"a node has {len(origins)} inputs, one is understood", _shown(node), ADVICE)
    (origin,) = origins
    if node.op_type == TREE and origin == OBSERVATION:
        kinds = [label for item in node.attribute for name, label in LABELS.items() if item.name == name]
        return [*(kinds or [UNKNOWN]), SCORES]
    if node.op_type == "Identity" or (node.op_type in ("ZipMap", "Cast") and origin == SCORES):
        return [origin]
    if node.op_type == "Cast" and origin in LABELS.values():
        to = next(onnx.helper.get_attribute_value(item) for item in node.attribute if item.name == "to")
        if origin.endswith(f", {_type(onnx, to)}"):
            return [origin]
        what = f"a Cast makes {_type(onnx, to)} of {origin}"
        raise InputError(what, _shown(node), "export the label as it is")
    raise InputError(f"a node works on {origin}: {node.op_type!r}", _shown(node), ADVICE)


# --- the tree


def _attributes(onnx: Any, node: Any) -> dict[str, Any]:
    """The attributes by name; missing lists are empty. InputError for one that would change what the tree decides."""
    given = {item.name: onnx.helper.get_attribute_value(item) for item in node.attribute}
    unknown = sorted(set(given) - READ - HARMLESS - {*LABELS})
    changing = [name for name in unknown if name.endswith("_as_tensor") or len(given[name])]
    if changing:
        raise InputError(f"the tree has the attribute {changing[0]!r}, which is not understood", _shown(node), ADVICE)
    transform = given.get("post_transform", b"NONE").decode(errors="replace")
    if transform != "NONE":
        raise InputError(
            f"the tree's scores go through {transform!r}", _shown(node), "export it with post_transform NONE"
        )
    if any(given.get("nodes_missing_value_tracks_true", ())):
        raise InputError(
            "a node sends missing values to the left", "", "NaN always goes right here: convert a tree without this"
        )
    found: dict[str, Any] = {name: given.get(name, []) for name in (*READ, *LABELS)}
    if len({*found["nodes_treeids"], *found["class_treeids"]}) > 1:
        raise InputError("the ensemble has several trees", _shown(node), ADVICE)
    for names, like in (
        (NODE_LISTS, "nodes_values"),
        (CLASS_LISTS, "class_weights"),
        (["nodes_treeids"], "nodes_values"),
    ):
        for name in names:
            if len(found[name]) != len(found[like]) or not found[like]:
                what = f"{name} has {len(found[name])} entries, {like} has {len(found[like])}"
                raise InputError(what, _shown(node), "export it again")
    if all(found[name] for name in LABELS):
        raise InputError("the tree has both integer and string labels", _shown(node), "export it again")
    return found


def _grown(given: dict[str, Any], labels: Sequence[int | str]) -> GrownTree:
    modes = [mode.decode(errors="replace") for mode in given["nodes_modes"]]
    unknown = sorted(set(modes) - {LESS_EQUAL, LESS, LEAF})
    if unknown:
        raise InputError(f"a node compares by {unknown[0]!r}", "", f"only {LESS_EQUAL} and {LESS} are supported")
    place: dict[int, int] = {node: index for index, node in enumerate(given["nodes_nodeids"])}
    split = np.array([mode != LEAF for mode in modes])
    values = np.array(given["nodes_values"], dtype=np.float64)
    less = np.array([mode == LESS for mode in modes])
    features = np.array(given["nodes_featureids"])
    if not ((features[split] >= 0) & (features[split] < MAX_FEATURES) & np.isfinite(values[split])).all():
        raise InputError("a node tests no feature, or has no finite threshold", "", "export it again")
    sides = {side: [place.get(node) for node in given[f"nodes_{side}nodeids"]] for side in ("true", "false")}
    children = [side[node] for side in sides.values() for node in np.flatnonzero(split)]
    # each node but the first, where runtimes begin, is a child once: so no walk meets a node twice
    if sorted(place) != [*range(len(modes))] or Counter(children) != Counter(range(1, len(modes))):
        raise InputError("the nodes do not form a tree", "nodes_truenodeids, nodes_falsenodeids", "export it again")
    left, right = (np.array([NO_CHILD if each is None else each for each in side]) for side in sides.values())
    return GrownTree(
        np.where(split, features, NO_FEATURE),
        # x < t and x <= (the double before t) say the same of a float32 x
        np.where(split, np.where(less, np.nextafter(values, -np.inf), values), 0.0),
        np.where(split, left, NO_CHILD),
        np.where(split, right, NO_CHILD),
        np.where(split, NO_ACTION, _classes(given, place, split, labels)),
    )


def _classes(given: dict[str, Any], place: dict[int, int], split: Bool, labels: Sequence[int | str]) -> np.ndarray:
    """The class at each leaf (anything at splits), where onnxruntime and the reference of ONNX name the same one."""
    n, ids = len(labels), given["class_ids"]
    if n < FEWEST_CLASSES or len(set(labels)) != n:
        raise InputError(
            f"the tree has {len(set(labels))} labels for {n} classes",
            "",
            "at least two classes are needed, each with its own label",
        )
    weights, listed = np.zeros((len(split), n)), np.zeros((len(split), n), dtype=int)
    for node, label, weight in zip(given["class_nodeids"], ids, given["class_weights"], strict=True):
        if node not in place or split[place[node]] or not 0 <= label < n or not np.isfinite(weight):
            raise InputError(
                f"a weight of class {label} at node {node} does not belong to a leaf and a class, or is not finite",
                "class_weights",
                "export it again",
            )
        weights[place[node], label] += weight
        listed[place[node], label] += 1
    leaf = ~split
    if (listed > 1).any() or not listed[leaf].any(axis=1).all():
        raise InputError("a leaf has no weight, or two for one class", "class_weights", "export it again")
    runtime, reference = _readings(weights, listed > 0, labels)
    for index in np.flatnonzero(leaf & (runtime != reference))[:1].tolist():
        said = " or ".join(repr(labels[int(reading[index])]) for reading in (runtime, reference))
        what = f"runtimes differ in the class at leaf {given['nodes_nodeids'][index]}: {said}"
        raise InputError(what, "class_weights", ADVICE)
    return reference


def _readings(weights: Float64, listed: Bool, labels: Sequence[int | str]) -> tuple[np.ndarray, np.ndarray]:
    """The class at each leaf as onnxruntime chooses it, and as the reference of ONNX does.

    ONNX leaves two classes open. A weight for one class only is the second one's share for both, against 1/2, but
    onnxruntime compares with 0 where a weight is negative; with weights for both, it asks whether the second one's is
    above 0, and answers 0 or 1, whatever the labels are.
    """
    named = np.flatnonzero(listed.any(axis=0))
    if weights.shape[1] > FEWEST_CLASSES and len(named) == 1:
        raise InputError(f"only class {labels[named[0]]!r} has weights", "class_weights", ADVICE)
    if weights.shape[1] > FEWEST_CLASSES:
        return np.where(listed, weights, -np.inf).argmax(axis=1), weights.argmax(axis=1)
    if len(named) == 1:
        share = weights[:, named[0]]
        bar = 0.5 if (weights >= 0).all() else 0.0
        return (share > bar).astype(int), ((share > 0.5) & (named[0] == 0)).astype(int)
    if not isinstance(labels[0], str) and tuple(labels) != (0, 1):
        raise InputError(
            f"the two classes have the labels {list(labels)}",
            "class_weights",
            "label them 0 and 1, which is what runtimes answer",
        )
    second = np.where(listed[:, 1], weights[:, 1], weights[:, 0])
    return (second > 0).astype(int), weights.argmax(axis=1)
