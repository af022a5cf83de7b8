"""A TreeEnsemble of ONNX (ai.onnx.ml 5) as a tree whose leaves are whole numbers, actions, or numbers that it gives.

Does: reads splits, leaves and the number of each leaf, where every attribute is understood.
Assumes: a node that ONNX's own checker found valid; for actions a Cast to whole numbers behind it (graph.py).
Does not: take several trees or targets, or other comparisons.
"""

from typing import Any

import numpy as np

from codegen.importers.onnx.tree import Nodes, Read, build_tree, make_error
from codegen.ir import NO_CHILD, NO_FEATURE, GrownTree, Int32

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


def read_ensemble(onnx: Any, node: Any, double: bool, *, whole: bool) -> Read:
    """The tree of a node. `double`: whether it compares float64; `whole`: whether the numbers of its leaves are labels,
    ascending; else it gives them.
    """
    if double and not whole:
        raise make_error(node, "a regressor takes float64", "export it with a float32 input")
    given = _attributes(onnx, node, double)
    weights = given["leaf_weights"]
    if not whole:
        if not np.isfinite(weights).all():
            raise make_error(node, "a leaf's number is not finite", "export it again")
        grown = _build_tree(given, np.arange(len(weights), dtype=np.int32), node)
        return Read(grown, (), weights.astype(np.float32)[:, None])
    numbers = weights.astype(np.int64)
    if not ((numbers == weights) & (weights >= 0) & (weights < MAX_NUMBER)).all():
        raise make_error(node, "a leaf of the tree is no whole number")
    labels, actions = np.unique(numbers, return_inverse=True)
    return Read(_build_tree(given, actions.astype(np.int32), node), tuple(labels.tolist()))


def _attributes(onnx: Any, node: Any, double: bool) -> dict[str, Any]:
    """The attributes as arrays. InputError for one that would change what the tree decides."""
    given = {item.name: onnx.helper.get_attribute_value(item) for item in node.attribute}
    unknown = sorted(set(given) - READ - HARMLESS)
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
    return arrays


def _build_tree(given: dict[str, Any], actions: Int32, node: Any) -> GrownTree:
    """Splits first, then leaves, each numbered on."""
    n, n_leaves = len(given["nodes_splits"]), len(actions)
    modes, splits, features = given["nodes_modes"], given["nodes_splits"], given["nodes_featureids"]
    if not np.isin(modes, (LESS_EQUAL, LESS)).all():
        raise make_error(node, "a node compares otherwise than by <= and <")
    ends = [(given[f"nodes_{side}nodeids"], given[f"nodes_{side}leafs"].astype(bool)) for side in ("true", "false")]
    left, right = (ids + np.where(leaf, n, 0) for ids, leaf in ends)
    if n == n_leaves == 1 and left[0] == right[0] == 1:  # one leaf, on both sides of a test of nothing
        return GrownTree(np.array([NO_FEATURE]), np.zeros(1), np.array([NO_CHILD]), np.array([NO_CHILD]), actions)
    if not all(((ids >= 0) & (ids < np.where(leaf, n_leaves, n))).all() for ids, leaf in ends):
        raise make_error(node, "the nodes do not form a tree", "export it again")
    split = np.arange(n + n_leaves) < n
    feature, number, less, left, right = (
        np.pad(each, (0, n_leaves)) for each in (features, splits, modes == LESS, left, right)
    )
    return build_tree(Nodes(split, feature, number, less, (left, right), np.pad(actions, (n, 0))), node)
