"""Trees as operators of ai.onnx.ml: TreeEnsemble of its version 5, and the deprecated ones before it.

Does: makes the nodes that turn rows of numbers into the leaf's number: its action, or its vector.
Assumes: a checked tree of at most 2^20 nodes, whose numbers a float32 holds.
Does not: know what stands before or after the tree.

Every node of a tree tests `<=`, and missing values (NaN) do not track true, so NaN goes right.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from codegen import ir
from codegen.floats import FLOAT64

DOMAIN = "ai.onnx.ml"
FEWEST_CLASSES = 2


def new(onnx: Any, tree: ir.Tree, numbers: str, rows: str, number: str) -> list[Any]:
    """Nodes of TreeEnsemble: `rows` [N, n] of these numbers in, the leaf's `number`, int64 [N], out."""
    make = onnx.helper.make_node
    attributes = _ensemble(onnx, tree, numbers)
    return [
        make("TreeEnsemble", [rows], ["weight"], domain=DOMAIN, **attributes),
        make("Cast", ["weight"], ["weight_int"], to=onnx.TensorProto.INT64),
        make("Reshape", ["weight_int", "all_rows"], [number]),
    ]


def _ensemble(onnx: Any, tree: ir.Tree, numbers: str) -> dict[str, Any]:
    """Splits and leaves in two lists, each in preorder; a tree of one leaf is a split with that leaf on both sides."""
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
    return {
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


def old_classes(onnx: Any, tree: ir.Tree, numbers: str, n_actions: int, rows: str, number: str) -> list[Any]:
    """The node of TreeEnsembleClassifier: a class for each action.

    Each leaf has a weight for every class, 1 for its own and 0 for the others, and there are two classes at least:
    runtimes read ensembles whose leaves name one class only as binary, and answer another class then.
    """
    attributes = _nodes(tree) | _classes(tree, max(n_actions, FEWEST_CLASSES))
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
