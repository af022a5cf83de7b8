"""A TreeEnsemble of ONNX (ai.onnx.ml 5) as a tree whose leaves are whole numbers, actions, or numbers that it gives.

Does: reads splits, leaves and the number of each leaf, where every attribute is understood.
Assumes: a node that ONNX's own checker found valid; for actions a Cast to whole numbers behind it (graph.py).
Does not: take several trees or targets, or other comparisons.
"""

from collections import Counter
from typing import Any, cast

import numpy as np

from codegen.errors import InputError
from codegen.floats import FLOAT64, neighbour
from codegen.importers.onnx.tree import ADVICE, MAX_FEATURES, describe_node
from codegen.ir import NO_ACTION, NO_CHILD, NO_FEATURE, Float32, GrownTree, Int32

ENSEMBLE = "TreeEnsemble"
NUMBER, WHOLE = "the tree's number", "the tree's number as INT64"
LESS_EQUAL, LESS = 0, 1  # of nodes_modes
SUM, NONE = 1, 0  # of aggregate_function, post_transform
MAX_NUMBER = 1 << 24  # up to which a float32 has every whole number
CHILDREN = ("nodes_truenodeids", "nodes_trueleafs", "nodes_falsenodeids", "nodes_falseleafs")
READ = {
    *CHILDREN, "nodes_modes", "nodes_featureids", "nodes_splits", "leaf_targetids", "leaf_weights", "tree_roots",
}  # fmt: skip
HARMLESS = {"nodes_hitrates", "n_targets", "aggregate_function", "post_transform", "nodes_missing_value_tracks_true"}


def read_ensemble(onnx: Any, node: Any, double: bool) -> tuple[GrownTree, tuple[int, ...], None]:
    """The tree of a node, the numbers of its leaves, ascending, and that it gives none. `double`: whether it compares
    float64.
    """
    given = _attributes(onnx, node, double)
    weights = given["leaf_weights"]
    whole = weights.astype(np.int64)
    if not ((whole == weights) & (weights >= 0) & (weights < MAX_NUMBER)).all():
        raise InputError("a leaf of the tree is no whole number", describe_node(node), ADVICE)
    labels = tuple(sorted({*whole.tolist()}))
    actions: Int32 = np.array([labels.index(each) for each in whole.tolist()], np.int32)
    return _build_tree(given, actions, node), labels, None


def read_given(onnx: Any, node: Any, double: bool) -> tuple[GrownTree, tuple[int, ...], Float32]:
    """The tree of a node whose leaves count in what it gives, which is the third, [n_leaves, 1] float32."""
    if double:
        raise InputError("a regressor takes float64", describe_node(node), "export it with a float32 input")
    given = _attributes(onnx, node, double)
    weights = given["leaf_weights"]
    if not np.isfinite(weights).all():
        raise InputError("a leaf's number is not finite", describe_node(node), "export it again")
    return _build_tree(given, np.arange(len(weights), dtype=np.int32), node), (), weights.astype(np.float32)[:, None]


def _attributes(onnx: Any, node: Any, double: bool) -> dict[str, Any]:
    """The attributes as arrays. InputError for one that would change what the tree decides."""
    given = {item.name: onnx.helper.get_attribute_value(item) for item in node.attribute}
    unknown = sorted(set(given) - READ - HARMLESS)
    if unknown:
        raise InputError(
            f"the tree has the attribute {unknown[0]!r}, which is not understood", describe_node(node), ADVICE
        )
    plain = (given.get("n_targets", 1), given.get("aggregate_function", SUM), given.get("post_transform", NONE))
    if plain != (1, SUM, NONE) or list(given.get("tree_roots", [])) != [0] or any(given["leaf_targetids"]):
        raise InputError(
            "the ensemble has several trees or targets, or changes its numbers", describe_node(node), ADVICE
        )
    if any(given.get("nodes_missing_value_tracks_true", ())):
        what = "a node sends missing values to the left"
        raise InputError(what, describe_node(node), "NaN always goes right here: convert a tree without this")
    arrays: dict[str, Any] = {name: np.array(given[name]) for name in (*CHILDREN, "nodes_featureids")}
    wanted = onnx.TensorProto.DOUBLE if double else onnx.TensorProto.FLOAT
    for name in ("nodes_modes", "nodes_splits", "leaf_weights"):
        tensor = given[name]
        if tensor.external_data or (name != "nodes_modes" and tensor.data_type != wanted):
            raise InputError(f"the tree's {name} are not of the input's type", describe_node(node), "export it again")
        arrays[name] = onnx.numpy_helper.to_array(tensor).ravel().astype(np.float64)
    if len({len(arrays[name]) for name in arrays if name.startswith("nodes")}) != 1:
        raise InputError("the tree's nodes have attributes of unlike length", describe_node(node), "export it again")
    return arrays


def _build_tree(given: dict[str, Any], actions: Int32, node: Any) -> GrownTree:
    """Splits first, then leaves, each numbered on."""
    n, n_leaves = len(given["nodes_splits"]), len(actions)
    modes, splits, features = given["nodes_modes"], given["nodes_splits"], given["nodes_featureids"]
    if not np.isin(modes, (LESS_EQUAL, LESS)).all():
        raise InputError("a node compares otherwise than by <= and <", describe_node(node), ADVICE)
    if not (np.isfinite(splits) & (features >= 0) & (features < MAX_FEATURES)).all():
        raise InputError("a node tests no feature, or has no finite threshold", describe_node(node), "export it again")
    left, right = (
        given[f"nodes_{side}nodeids"] + np.where(given[f"nodes_{side}leafs"], n, 0) for side in ("true", "false")
    )
    ends = [(given[f"nodes_{side}nodeids"], given[f"nodes_{side}leafs"].astype(bool)) for side in ("true", "false")]
    within = all(((ids >= 0) & (ids < np.where(leaf, n_leaves, n))).all() for ids, leaf in ends)
    if n == n_leaves == 1 and left[0] == right[0] == 1:  # one leaf, on both sides of a test of nothing
        return GrownTree(np.array([NO_FEATURE]), np.zeros(1), np.array([NO_CHILD]), np.array([NO_CHILD]), actions)
    if not within or Counter([*left.tolist(), *right.tolist()]) != Counter(range(1, n + n_leaves)):
        raise InputError("the nodes do not form a tree", describe_node(node), "export it again")
    threshold = cast("Any", np.where(modes == LESS, neighbour(splits, -np.inf, FLOAT64), splits))
    none, zero = np.full(n_leaves, NO_CHILD), np.zeros(n_leaves)
    return GrownTree(
        np.concatenate([features, np.full(n_leaves, NO_FEATURE)]),
        np.concatenate([threshold, zero]),
        np.concatenate([left, none]),
        np.concatenate([right, none]),
        np.concatenate([np.full(n, NO_ACTION), actions]),
    )
