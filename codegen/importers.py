"""Trees of others as profiles, so that they compile like ours: scikit-learn's, and ONNX ensembles of one tree.

Does: turns a fitted DecisionTreeClassifier, or an ONNX model that is one such tree (onnx_graph.py), into a profile.
Assumes: classes are the actions; observations are float32.
Does not: import scikit-learn (a fitted object is read by its attributes), or run any code of a file.

What is kept: the decision for every float32 observation without NaN. NaN goes right here, whatever scikit-learn does
with it at a node (its bigger side, if it was fitted without); an ONNX node that sends NaN to the left is refused.

Action k is class k, in the classifier's own order: scikit-learn sorts its labels, so 5, -2, 9 are actions 0, 1, 2 as
action_minus_2, action_5, action_9. A name keeps a label's ASCII letters and digits, without accents; a minus sign
before a number becomes the word minus, what would begin with a number begins with action_, everything else becomes _.
Two labels with the same name are an error.
"""

import re
import unicodedata
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from codegen import ir
from codegen.check import MAX_LENGTH, ensure, identifier
from codegen.errors import InputError
from codegen.ir import NO_ACTION, NO_CHILD, NO_FEATURE, GrownTree
from codegen.lowering.deploy import deployed
from codegen.lowering.render import comment
from codegen.onnx_graph import decision_tree

AGENT, TEAM = "agent_0", "team"


def from_sklearn(
    classifier: Any,
    feature_names: Sequence[str] | None = None,
    action_names: Sequence[str] | None = None,
    name: str = "imported",
) -> ir.PolicyProfile:
    """A profile of one agent from a fitted `sklearn.tree.DecisionTreeClassifier`.

    `feature_names`: default those it was fitted with, or x0, x1, ...; `action_names`: default its labels, one a class
    in the order of `classes_`. Both are made legal as the module says. InputError for what is not a fitted classifier
    of one output whose `predict` is scikit-learn's, or was seen to learn from missing values.
    """
    tree = getattr(classifier, "tree_", None)
    if tree is None or not hasattr(classifier, "classes_"):
        advice = "fit it first; from a pipeline, give the tree alone, if no earlier step changes the observation"
        raise InputError("not a fitted DecisionTreeClassifier", type(classifier).__name__, advice)
    if tree.n_outputs != 1:
        raise InputError(f"the classifier has {tree.n_outputs} outputs, one is needed", "", "fit one tree per agent")
    _ensure_own(classifier, tree)
    grown = grown_from_sklearn(tree, tree.value[:, 0].argmax(axis=1))
    fitted = getattr(classifier, "feature_names_in_", None)
    features = feature_names if feature_names is not None or fitted is None else [str(each) for each in fitted]
    actions = _actions(classifier.classes_, action_names)
    return _profile(grown, int(tree.n_features), features, actions, name, "scikit-learn")


def _ensure_own(classifier: Any, tree: Any) -> None:
    """InputError for a classifier that does more than to walk its tree and take the class with most weight."""
    predict: Any = classifier.predict
    if "predict" in vars(classifier) or not predict.__module__.startswith("sklearn.tree."):
        what = "the classifier does not predict as scikit-learn's tree does"
        raise InputError(what, type(classifier).__name__, "give the tree itself")
    split = np.flatnonzero(tree.children_left != NO_CHILD)
    left, right = tree.children_left[split], tree.children_right[split]
    # without missing values in a node, scikit-learn says that they would follow its bigger side
    bigger = tree.n_node_samples[left] > tree.n_node_samples[right]
    odd = ~np.isfinite(tree.threshold[split]) | (tree.missing_go_to_left[split].astype(bool) != bigger)
    for node in split[odd][:1]:
        advice = "NaN always goes right here: fit it on data without missing values"
        raise InputError("the classifier was fitted on missing values", f"node {node}", advice)


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
    model: Path | str | bytes,
    feature_names: Sequence[str] | None = None,
    action_names: Sequence[str] | None = None,
    name: str = "imported",
) -> ir.PolicyProfile:
    """A profile of one agent from an ONNX model (bytes, or a path) that is one TreeEnsembleClassifier of one tree.

    It decides as the model does for every float32 observation. InputError for every other model: one with a node that
    is not understood, whatever stands before or after the tree; another type of input; tests other than `<=` and `<`;
    nodes that send NaN to the left; scores that are changed; leaves that runtimes read in different ways. Names as for
    `from_sklearn`, labels in the model's order. MissingToolError without the package onnx.
    """
    try:
        content = model if isinstance(model, bytes) else Path(model).read_bytes()
    except OSError as error:
        raise InputError("cannot read the file", f"{model}: {error.strerror}", "check the path") from None
    found = decision_tree(content)
    width = found.n_features or max(found.n_tested, len(feature_names or ()))
    if not found.n_features and feature_names is None:
        raise InputError("the model does not say how many features it takes", "its input", "give their names")
    return _profile(found.grown, width, feature_names, _actions(found.labels, action_names), name, "ONNX")


def _profile(
    grown: GrownTree, width: int, features: Sequence[str] | None, actions: Sequence[str], name: str, origin: str
) -> ir.PolicyProfile:
    names = [f"x{index}" for index in range(width)] if features is None else list(features)
    if len(names) != width:
        raise InputError(f"{len(names)} feature names for {width} features", "", "name each feature once")
    feature_specs = [ir.FeatureSpec(each, "none", -MAX_LENGTH, MAX_LENGTH, None) for each in cleaned(names, "x")]
    action_specs = [ir.ActionSpec(each, None) for each in actions]
    policy = ir.AgentPolicy(AGENT, TEAM, tuple(feature_specs), tuple(action_specs), deployed(grown), grown)
    world = ir.WorldSpec(
        name=cleaned([name], "imported")[0],
        reference="",
        agents=(ir.EntitySpec(AGENT, size=0.0, force=0.0, max_speed=None, collides=False),),
        landmarks=(),
        goals=(),
        dt=0.0,
        damping=0.0,
        start_low=-MAX_LENGTH,
        start_high=MAX_LENGTH,
        episode_steps=1,
    )
    provenance = ir.Provenance("imported", "none", 0, "", comment(origin))
    return ensure(ir.PolicyProfile(world, (policy,), provenance))


def _actions(labels: Sequence[Any], names: Sequence[str] | None) -> list[str]:
    """The name of each class. InputError where there are more or fewer names, or two become the same one."""
    given = list(labels if names is None else names)
    if len(given) != len(labels):
        raise InputError(f"{len(given)} action names for {len(labels)} classes", "", "name each class once")
    found: dict[str, Any] = {}
    for label in given:
        name = _legal(label, "action")
        same = [other for other in found if identifier(other) == identifier(name)]
        if same:
            what = f"the labels {found[same[0]]!r} and {label!r} become the same action name, {name}"
            raise InputError(what, "", "give action_names, one per class")
        found[name] = label
    return list(found)


SIGN = re.compile(r"(?<![A-Za-z0-9])-(?=\.?[0-9])")
MAX_LETTERS = 56  # with room for a number after them


def _legal(given: Any, prefix: str) -> str:
    """The legal name of a text or a number, as the module says."""
    text = given.decode(errors="replace") if isinstance(given, bytes) else str(given)
    text = unicodedata.normalize("NFKD", text).replace("\N{MINUS SIGN}", "-").strip()
    text = "".join(letter for letter in text if not unicodedata.combining(letter))
    signed = SIGN.match(text)
    text = SIGN.sub("minus_", text)
    text = "".join(letter if letter.isascii() and letter.isalnum() else "_" for letter in text).strip("_")
    return (f"{prefix}_{text}".rstrip("_") if signed or not text or not text[0].isalpha() else text)[:MAX_LETTERS]


def cleaned(names: Sequence[str], prefix: str) -> list[str]:
    """Legal names that keep what they can of those given; equal ones are numbered."""
    found: list[str] = []
    taken: set[str] = set()
    for given in names:
        text, number = _legal(given, prefix), 2
        unique = text
        while identifier(unique) in taken:
            unique, number = f"{text}_{number}", number + 1
        taken.add(identifier(unique))
        found.append(unique)
    return found
