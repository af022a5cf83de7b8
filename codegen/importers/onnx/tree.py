"""A tree ensemble of ONNX, of one tree: its attributes as arrays, where every one of them is understood.

Does: reads nodes, and labels and the class at each leaf, or the numbers there: of a classifier or a regressor, and of a
  TreeEnsemble (ai.onnx.ml 5), whose leaves are whole numbers, actions, or numbers that it gives.
Assumes: a node that ONNX's own checker found valid; for actions of a TreeEnsemble a Cast to whole numbers behind it
  (model.py).
Does not: guess. Several trees, other comparisons, scores that are changed, or leaves that runtimes read in different
  ways end in an InputError.
"""

from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, cast

import numpy as np

from codegen.errors import InputError
from codegen.floats import FLOAT64
from codegen.importers.reading import MAX_FEATURES
from codegen.ir import NO_ACTION, NO_CHILD, NO_FEATURE, Bool, Float32, Float64, GrownTree, Int32
from codegen.numbers import neighbour

CLASSIFIER, REGRESSOR = "TreeEnsembleClassifier", "TreeEnsembleRegressor"
TREES = {CLASSIFIER: "class", REGRESSOR: "target"}  # and how the attributes of its leaves begin
LABELS = {"classlabels_int64s": "the tree's label, INT64", "classlabels_strings": "the tree's label, STRING"}
LESS_EQUAL, LESS, LEAF = "BRANCH_LEQ", "BRANCH_LT", "LEAF"
FEWEST_CLASSES = 2
MAX_TARGETS = 64
NODE_LISTS = ("nodes_modes", "nodes_nodeids", "nodes_featureids", "nodes_truenodeids", "nodes_falsenodeids")
LEAF_LISTS = ("treeids", "nodeids", "ids")
HARMLESS = {"nodes_hitrates", "nodes_hitrates_as_tensor", "nodes_missing_value_tracks_true", "post_transform"}
SUMS = (b"SUM", b"AVERAGE")  # of one tree, both are its number
ADVICE = "export one decision tree, with no more than scalers and selections before it"


def describe_node(node: Any) -> str:
    """A node, for a person: every text is a repr, since names are anybody's."""
    operator = f"{node.domain}.{node.op_type}" if node.domain else node.op_type
    return f"operator {operator!r}, node {node.name!r}, output {list(node.output)!r}"


def make_error(node: Any, what: str, advice: str = ADVICE) -> InputError:
    """Why a node is not understood."""
    return InputError(what, describe_node(node), advice)


class Read(NamedTuple):
    """A tree, the labels of its classes, and what a regressor gives at each leaf, float32 [n_leaves, n_targets]."""

    grown: GrownTree
    labels: tuple[int | str, ...]
    gives: Float32 | None = None


def read_tree(onnx: Any, node: Any, double: bool) -> Read:
    """The tree of a node. `double`: whether it compares float64."""
    if node.op_type == REGRESSOR:
        if double:
            raise InputError("a regressor takes float64", describe_node(node), "export it with a float32 input")
        return _numbers(_attributes(onnx, node, double), node)
    given = _attributes(onnx, node, double)
    labels = tuple(
        each.decode(errors="replace") if isinstance(each, bytes) else each for name in LABELS for each in given[name]
    )
    return Read(_build_tree(given, node, lambda place, split: _classes(given, place, split, labels)), labels)


def _numbers(given: dict[str, Any], node: Any) -> Read:
    """A regressor's tree, whose leaves count in what it gives: weights plus the values that all have in common."""
    n = int(given["n_targets"] or 1)
    base = np.array(given["base_values"] or [0.0] * n, dtype=np.float32)
    if not 1 <= n <= MAX_TARGETS or len(base) != n or (given["aggregate_function"] or b"SUM") not in SUMS:
        raise InputError("the tree's numbers are put together in a way that is not understood", "base_values", ADVICE)
    leaf_numbers: list[Float32] = []

    def leaves(place: dict[int, int], split: Bool) -> Any:
        numbers, listed = _weights(given, "target", place, split, n)
        if (listed[~split] != 1).any():
            raise InputError("a leaf has no number, or two for one target", "target_weights", "export it again")
        leaf_numbers.append(numbers[~split].astype(np.float32) + base)
        return np.cumsum(~split) - 1

    grown = _build_tree(given, node, leaves)
    if not np.isfinite(leaf_numbers[0]).all():
        raise InputError("a leaf's number is not finite", "target_weights", "export it again")
    return Read(grown, (), leaf_numbers[0])


def _attributes(onnx: Any, node: Any, double: bool) -> dict[str, Any]:
    """The attributes by name; missing lists are empty. InputError for one that would change what the tree decides."""
    leaf = TREES[node.op_type]
    weights, leaf_lists = f"{leaf}_weights", [f"{leaf}_{name}" for name in LEAF_LISTS]
    more = ("n_targets", "base_values", "aggregate_function") if node.op_type == REGRESSOR else LABELS
    read = {*NODE_LISTS, *leaf_lists, "nodes_treeids", "nodes_values", weights, *more}
    given = {item.name: onnx.helper.get_attribute_value(item) for item in node.attribute}
    for name in ("nodes_values", weights) if double else ():
        tensor = given.pop(f"{name}_as_tensor", None)
        if tensor is None or name in given or tensor.external_data or tensor.data_type != onnx.TensorProto.DOUBLE:
            what = f"the model's input is DOUBLE, and the tree's {name} are no tensor of doubles"
            raise make_error(node, what, "export it with a float32 input")
        given[name] = onnx.numpy_helper.to_array(tensor).ravel().tolist()
    unknown = sorted(set(given) - read - HARMLESS)
    changing = [name for name in unknown if name.endswith("_as_tensor") or len(given[name])]
    if changing:
        raise make_error(node, f"the tree has the attribute {changing[0]!r}, which is not understood")
    transform = given.get("post_transform", b"NONE").decode(errors="replace")
    if transform != "NONE":
        raise make_error(node, f"the tree's scores go through {transform!r}", "export it with post_transform NONE")
    if any(given.get("nodes_missing_value_tracks_true", ())):
        what = "a node sends missing values to the left"
        raise make_error(node, what, "NaN always goes right here: convert a tree without this")
    attributes: dict[str, Any] = {name: given.get(name, []) for name in read}
    if len({*attributes["nodes_treeids"], *attributes[f"{leaf}_treeids"]}) > 1:
        raise make_error(node, "the ensemble has several trees")
    for names, like in (
        (NODE_LISTS, "nodes_values"),
        (leaf_lists, weights),
        (["nodes_treeids"], "nodes_values"),
    ):
        for name in names:
            if len(attributes[name]) != len(attributes[like]) or not attributes[like]:
                what = f"{name} has {len(attributes[name])} entries, {like} has {len(attributes[like])}"
                raise make_error(node, what, "export it again")
    if all(attributes.get(name) for name in LABELS):
        raise make_error(node, "the tree has both integer and string labels", "export it again")
    return attributes


class Nodes(NamedTuple):
    """Nodes by their places, [n] each; what stands at leaves counts for nothing, but for their actions."""

    split: Bool
    feature: Any
    number: Any  # that the feature is compared with
    less: Any  # whether by `<`; else by `<=`
    sides: tuple[Any, Any]  # the places of children
    action: Any


def build_tree(nodes: Nodes, node: Any) -> GrownTree:
    """The tree. InputError where the nodes form none, or one does not compare a feature with a finite number."""
    split, feature, number = nodes.split, nodes.feature, nodes.number
    if not ((feature[split] >= 0) & (feature[split] < MAX_FEATURES) & np.isfinite(number[split])).all():
        raise make_error(node, "a node tests no feature, or has no finite threshold", "export it again")
    children = [each for side in nodes.sides for each in side[split].tolist()]
    # each node but the first, where runtimes begin, is a child once: so no walk meets a node twice
    if Counter(children) != Counter(range(1, len(split))):
        raise make_error(node, "the nodes do not form a tree", "export it again")
    # x < t and x <= (the double before t) say the same
    threshold = cast("Any", np.where(nodes.less, neighbour(number, -np.inf, FLOAT64), number))
    left, right = (np.where(split, side, NO_CHILD) for side in nodes.sides)
    action = np.where(split, NO_ACTION, nodes.action)
    return GrownTree(np.where(split, feature, NO_FEATURE), np.where(split, threshold, 0.0), left, right, action)


def _build_tree(given: dict[str, Any], node: Any, leaves: Callable[[dict[int, int], Bool], Any]) -> GrownTree:
    """The tree. `leaves`: the action at each leaf, anything at splits, from places of nodes and which are splits."""
    modes = [mode.decode(errors="replace") for mode in given["nodes_modes"]]
    unknown = sorted(set(modes) - {LESS_EQUAL, LESS, LEAF})
    if unknown:
        raise make_error(node, f"a node compares by {unknown[0]!r}", f"only {LESS_EQUAL} and {LESS} are supported")
    place: dict[int, int] = {each: index for index, each in enumerate(given["nodes_nodeids"])}
    if sorted(place) != [*range(len(modes))]:
        raise make_error(node, "the nodes do not form a tree", "export it again")
    split, less = np.array([mode != LEAF for mode in modes]), np.array([mode == LESS for mode in modes])
    true, false = (
        np.array([place.get(each, NO_CHILD) for each in given[f"nodes_{side}nodeids"]]) for side in ("true", "false")
    )
    features, numbers = np.array(given["nodes_featureids"]), np.array(given["nodes_values"], dtype=np.float64)
    return build_tree(Nodes(split, features, numbers, less, (true, false), leaves(place, split)), node)


def _classes(given: dict[str, Any], place: dict[int, int], split: Bool, labels: Sequence[int | str]) -> np.ndarray:
    """The class at each leaf (anything at splits), where onnxruntime and the reference of ONNX name the same one."""
    n = len(labels)
    if n < FEWEST_CLASSES or len(set(labels)) != n:
        what = f"the tree has {len(set(labels))} labels for {n} classes"
        raise InputError(what, "", "at least two classes are needed, each with its own label")
    weights, listed = _weights(given, "class", place, split, n)
    leaf = ~split
    if (listed > 1).any() or not listed[leaf].any(axis=1).all():
        raise InputError("a leaf has no weight, or two for one class", "class_weights", "export it again")
    runtime, reference = _readings(weights, listed > 0, labels)
    for index in np.flatnonzero(leaf & (runtime != reference))[:1].tolist():
        said = " or ".join(repr(labels[int(reading[index])]) for reading in (runtime, reference))
        what = f"runtimes differ in the class at leaf {given['nodes_nodeids'][index]}: {said}"
        raise InputError(what, "class_weights", ADVICE)
    return reference


def _weights(
    given: dict[str, Any], leaf: str, place: dict[int, int], split: Bool, n: int
) -> tuple[Float64, np.ndarray]:
    """The weight of each class or target at each node, [n_nodes, n], and how many it has there."""
    weights, listed = np.zeros((len(split), n)), np.zeros((len(split), n), dtype=int)
    ids, nodes = given[f"{leaf}_ids"], given[f"{leaf}_nodeids"]
    for node, label, weight in zip(nodes, ids, given[f"{leaf}_weights"], strict=True):
        if node not in place or split[place[node]] or not 0 <= label < n or not np.isfinite(weight):
            weight_of = f"a weight of {leaf} {label} at node {node}"
            what = f"{weight_of} does not belong to a leaf and a {leaf}, or is not finite"
            raise InputError(what, f"{leaf}_weights", "export it again")
        weights[place[node], label] += weight
        listed[place[node], label] += 1
    return weights, listed


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
        what = f"the two classes have the labels {list(labels)}"
        raise InputError(what, "class_weights", "label them 0 and 1, which is what runtimes answer")
    second = np.where(listed[:, 1], weights[:, 1], weights[:, 0])
    return (second > 0).astype(int), weights.argmax(axis=1)


# --- TreeEnsemble, of ai.onnx.ml 5

ENSEMBLE = "TreeEnsemble"
NUMBER, WHOLE = "the tree's number", "the tree's number as INT64"
MODES = (0, 1)  # of nodes_modes: <=, <
SUM, NONE = 1, 0  # of aggregate_function, post_transform
MAX_NUMBER = 1 << 24  # up to which a float32 has every whole number
CHILDREN = ("nodes_truenodeids", "nodes_trueleafs", "nodes_falsenodeids", "nodes_falseleafs")
READ = {
    *CHILDREN, "nodes_modes", "nodes_featureids", "nodes_splits", "leaf_targetids", "leaf_weights", "tree_roots",
}  # fmt: skip
UNREAD = {"nodes_hitrates", "n_targets", "aggregate_function", "post_transform", "nodes_missing_value_tracks_true"}


def read_ensemble(onnx: Any, node: Any, double: bool, *, whole: bool) -> Read:
    """The tree of a node. `double`: whether it compares float64; `whole`: whether the numbers of its leaves are labels,
    ascending; else it gives them.
    """
    if double and not whole:
        raise make_error(node, "a regressor takes float64", "export it with a float32 input")
    given = {item.name: onnx.helper.get_attribute_value(item) for item in node.attribute}
    unknown = sorted(set(given) - READ - UNREAD)
    if unknown:
        raise make_error(node, f"the tree has the attribute {unknown[0]!r}, which is not understood")
    plain = (given.get("n_targets", 1), given.get("aggregate_function", SUM), given.get("post_transform", NONE))
    if plain != (1, SUM, NONE) or list(given.get("tree_roots", [])) != [0] or any(given["leaf_targetids"]):
        raise make_error(node, "the ensemble has several trees or targets, or changes its numbers")
    if any(given.get("nodes_missing_value_tracks_true", ())):
        what = "a node sends missing values to the left"
        raise make_error(node, what, "NaN always goes right here: convert a tree without this")
    arrays: dict[str, Any] = {name: np.array(given[name]) for name in (*CHILDREN, "nodes_featureids")}
    wanted = onnx.TensorProto.DOUBLE if double else onnx.TensorProto.FLOAT
    for name in ("nodes_modes", "nodes_splits", "leaf_weights"):
        tensor = given[name]
        if tensor.external_data or (name != "nodes_modes" and tensor.data_type != wanted):
            raise make_error(node, f"the tree's {name} are not of the input's type", "export it again")
        arrays[name] = onnx.numpy_helper.to_array(tensor).ravel().astype(np.float64)
    if len({len(arrays[name]) for name in arrays if name.startswith("nodes")}) != 1:
        raise make_error(node, "the tree's nodes have attributes of unlike length", "export it again")
    weights = arrays["leaf_weights"]
    if not whole:
        if not np.isfinite(weights).all():
            raise make_error(node, "a leaf's number is not finite", "export it again")
        grown = _number_nodes(arrays, np.arange(len(weights), dtype=np.int32), node)
        return Read(grown, (), weights.astype(np.float32)[:, None])
    numbers = weights.astype(np.int64)
    if not ((numbers == weights) & (weights >= 0) & (weights < MAX_NUMBER)).all():
        raise make_error(node, "a leaf of the tree is no whole number")
    labels, actions = np.unique(numbers, return_inverse=True)
    return Read(_number_nodes(arrays, actions.astype(np.int32), node), tuple(labels.tolist()))


def _number_nodes(given: dict[str, Any], actions: Int32, node: Any) -> GrownTree:
    """Splits first, then leaves, each numbered on."""
    n, n_leaves = len(given["nodes_splits"]), len(actions)
    modes, splits, features = given["nodes_modes"], given["nodes_splits"], given["nodes_featureids"]
    if not np.isin(modes, MODES).all():
        raise make_error(node, "a node compares otherwise than by <= and <")
    ends = [(given[f"nodes_{side}nodeids"], given[f"nodes_{side}leafs"].astype(bool)) for side in ("true", "false")]
    left, right = (ids + np.where(leaf, n, 0) for ids, leaf in ends)
    if n == n_leaves == 1 and left[0] == right[0] == 1:  # one leaf, on both sides of a test of nothing
        return GrownTree(np.array([NO_FEATURE]), np.zeros(1), np.array([NO_CHILD]), np.array([NO_CHILD]), actions)
    if not all(((ids >= 0) & (ids < np.where(leaf, n_leaves, n))).all() for ids, leaf in ends):
        raise make_error(node, "the nodes do not form a tree", "export it again")
    split = np.arange(n + n_leaves) < n
    feature, number, less, left, right = (
        np.pad(each, (0, n_leaves)) for each in (features, splits, modes == MODES[1], left, right)
    )
    return build_tree(Nodes(split, feature, number, less, (left, right), np.pad(actions, (n, 0))), node)
