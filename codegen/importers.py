"""Trees of others as profiles, so that they compile like ours: scikit-learn's, and ONNX ensembles of one tree.

Does: turns a fitted DecisionTreeClassifier, or a TreeEnsembleClassifier node of an ONNX model, into a policy profile.
Assumes: classes are the actions; observations are float32.
Does not: import scikit-learn (a fitted object is read by its attributes), or run any code of a file.

What is kept: the decision for every float32 observation without NaN. NaN goes right here, whatever scikit-learn does
with it at a node (its bigger side, if it was fitted without); an ONNX node that sends NaN to the left is refused.
"""

from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from codegen import ir
from codegen.check import MOST_LENGTH, identifier
from codegen.deploy import deployed
from codegen.errors import InputError, MissingToolError
from codegen.ir import NO_ACTION, NO_CHILD, NO_FEATURE, GrownTree
from codegen.render import comment

AGENT, TEAM = "agent_0", "team"
ENSEMBLE, LESS_EQUAL, LEAF = "TreeEnsembleClassifier", "BRANCH_LEQ", "LEAF"
LESS = "BRANCH_LT"


def from_sklearn(
    classifier: Any,
    feature_names: Sequence[str] | None = None,
    action_names: Sequence[str] | None = None,
    name: str = "imported",
) -> ir.PolicyProfile:
    """A profile of one agent from a fitted `sklearn.tree.DecisionTreeClassifier`.

    `feature_names`: default those it was fitted with, or x0, x1, ...; `action_names`: default its classes. InputError
    for what is not a fitted classifier of one output.
    """
    tree = getattr(classifier, "tree_", None)
    if tree is None or not hasattr(classifier, "classes_"):
        raise InputError("not a fitted DecisionTreeClassifier", type(classifier).__name__, "fit it first")
    if tree.n_outputs != 1:
        raise InputError(f"the classifier has {tree.n_outputs} outputs, one is needed", "", "fit one tree an agent")
    grown = grown_from_sklearn(tree, tree.value[:, 0].argmax(axis=1))
    fitted = getattr(classifier, "feature_names_in_", None)
    features = feature_names or (None if fitted is None else [str(each) for each in fitted])
    actions = action_names or [str(each) for each in classifier.classes_]
    return _profile(grown, int(tree.n_features), features, actions, name, "scikit-learn")


def grown_from_sklearn(tree: Any, action: Any) -> GrownTree:
    """A fitted estimator's `tree_` with these actions, one a node; those of splits count for nothing."""
    split = tree.children_left != NO_CHILD
    return GrownTree(
        np.where(split, tree.feature, NO_FEATURE),
        np.where(split, tree.threshold, 0.0),
        np.where(split, tree.children_left, NO_CHILD),
        np.where(split, tree.children_right, NO_CHILD),
        np.where(split, NO_ACTION, action),
    )


def from_onnx(
    model: Path | bytes,
    feature_names: Sequence[str] | None = None,
    action_names: Sequence[str] | None = None,
    name: str = "imported",
) -> ir.PolicyProfile:
    """A profile of one agent from an ONNX model whose decisions are one TreeEnsembleClassifier of one tree.

    InputError for other models, for tests other than `<=` and `<`, and for nodes that send NaN to the left.
    MissingToolError without the package onnx.
    """
    try:
        onnx: Any = import_module("onnx")
    except ImportError:
        raise MissingToolError("reading ONNX needs the package onnx", "", "pip install onnx") from None
    try:
        loaded = onnx.load_model_from_string(model if isinstance(model, bytes) else model.read_bytes())
    except OSError as error:
        raise InputError("cannot read the file", f"{model}: {error.strerror}", "check the path") from None
    except Exception as error:  # the parser's own class, which moves between versions
        raise InputError("not an ONNX model", str(error)[:200], "is this the right file?") from None
    found = [node for node in loaded.graph.node if node.op_type == ENSEMBLE]
    if len(found) != 1:
        what = f"the model has {len(found)} nodes {ENSEMBLE}, one is needed"
        raise InputError(what, "", "convert one decision tree classifier")
    given = {item.name: onnx.helper.get_attribute_value(item) for item in found[0].attribute}
    if len(set(given["nodes_treeids"])) != 1:
        raise InputError("the ensemble has several trees", "", "convert one decision tree classifier")
    labels = given.get("classlabels_int64s") or [label.decode() for label in given.get("classlabels_strings", [])]
    grown, n_tested = _ensemble(given, len(labels))
    shape = loaded.graph.input[0].type.tensor_type.shape.dim
    width = max(n_tested, shape[1].dim_value if len(shape) > 1 else 0, len(feature_names or ()))
    return _profile(grown, width, feature_names, action_names or [str(label) for label in labels], name, "ONNX")


def _ensemble(given: dict[str, Any], n_classes: int) -> tuple[GrownTree, int]:
    modes = [mode.decode() for mode in given["nodes_modes"]]
    unknown = sorted(set(modes) - {LESS_EQUAL, LESS, LEAF})
    if unknown:
        raise InputError(f"a node tests by {unknown[0]}", "", f"only {LESS_EQUAL} and {LESS} have a place here")
    if any(given.get("nodes_missing_value_tracks_true", ())):
        raise InputError("a node sends missing values to the left", "", "NaN goes right here: convert a tree without")
    place = {node: index for index, node in enumerate(given["nodes_nodeids"])}
    weights = np.zeros((len(place), n_classes))
    for node, label, weight in zip(given["class_nodeids"], given["class_ids"], given["class_weights"], strict=True):
        weights[place[node], label] += weight
    split = np.array([mode != LEAF for mode in modes])
    values = np.array(given["nodes_values"], dtype=np.float64)
    less = np.array([mode == LESS for mode in modes])

    def children(side: str) -> np.ndarray:
        return np.array([place.get(node, ir.ROOT) for node in given[side]]) * split + NO_CHILD * ~split

    return (
        GrownTree(
            np.where(split, given["nodes_featureids"], NO_FEATURE),
            np.where(split, np.where(less, np.nextafter(values, -np.inf), values), 0.0),
            children("nodes_truenodeids"),
            children("nodes_falsenodeids"),
            np.where(split, NO_ACTION, weights.argmax(axis=1)),
        ),
        1 + max(given["nodes_featureids"]),
    )


def _profile(
    grown: GrownTree, width: int, features: Sequence[str] | None, actions: Sequence[str], name: str, origin: str
) -> ir.PolicyProfile:
    names = list(features) if features else [f"x{index}" for index in range(width)]
    if len(names) != width:
        raise InputError(f"{len(names)} feature names for {width} features", "", "name each feature once")
    n_actions = int(grown.action.max()) + 1
    if len(actions) < n_actions:
        raise InputError(f"{len(actions)} action names for {n_actions} actions", "", "name each class once")
    feature_specs = [ir.FeatureSpec(each, "none", -MOST_LENGTH, MOST_LENGTH, None) for each in cleaned(names, "x")]
    action_specs = [ir.ActionSpec(each, None) for each in cleaned(actions, "action")]
    policy = ir.AgentPolicy(AGENT, TEAM, tuple(feature_specs), tuple(action_specs), deployed(grown), grown)
    world = ir.WorldSpec(
        name=cleaned([name], "imported")[0],
        reference="",
        agents=(ir.EntitySpec(AGENT, size=0.0, force=0.0, max_speed=None, collides=False),),
        landmarks=(),
        goals=(),
        dt=0.0,
        damping=0.0,
        start_low=-MOST_LENGTH,
        start_high=MOST_LENGTH,
        episode_steps=1,
    )
    provenance = ir.Provenance("imported", "none", 0, "", comment(origin))
    return ir.ensure(ir.PolicyProfile(world, (policy,), provenance))


def cleaned(names: Sequence[str], prefix: str) -> list[str]:
    """Legal names, all different, that keep what they can of those given."""
    found: list[str] = []
    taken: set[str] = set()
    for given in names:
        text = "".join(letter if letter.isascii() and letter.isalnum() else "_" for letter in str(given)).strip("_")
        text = text if text and text[0].isalpha() else f"{prefix}_{text}".rstrip("_")
        text, number = text[:56], 2
        unique = text
        while identifier(unique) in taken:
            unique, number = f"{text}_{number}", number + 1
        taken.add(identifier(unique))
        found.append(unique)
    return found
