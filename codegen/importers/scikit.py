"""Fitted trees of scikit-learn as profiles.

Does: reads a fitted DecisionTreeClassifier by its attributes, and replays the tree against its own `predict`.
Assumes: classes are the actions; observations are float32.
Does not: import scikit-learn, or open a file; scikit-learn's files are pickles, which run code.

What is kept: the decision for every float32 observation without NaN. NaN goes right here, whatever scikit-learn does
with it at a node (its bigger side, if it was fitted without). Action k is class k, in the classifier's own order:
scikit-learn sorts its labels.
"""

import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np

from codegen import ir
from codegen.errors import InputError
from codegen.importers.origin import AGENT, Names, Origin, profile_of
from codegen.ir import NO_ACTION, NO_CHILD, NO_FEATURE, Float32, GrownTree, Int32

KIND, REPLAYED_BY = "scikit-learn", "its own predict"


def from_sklearn(
    classifier: Any,
    feature_names: Sequence[str] | None = None,
    action_names: Sequence[str] | None = None,
    name: str = "imported",
) -> ir.PolicyProfile:
    """A profile of one agent from a fitted `sklearn.tree.DecisionTreeClassifier`.

    `feature_names`: default those it was fitted with, or x0, x1, ...; `action_names`: default its labels, one a class
    in the order of `classes_`. Both are made legal as names.py says. InputError for what is not a fitted classifier
    of one output whose `predict` is scikit-learn's, or was seen to learn from missing values.
    """
    return profile_of({AGENT: origin_of(classifier)}, Names(feature_names, action_names, name))


def origin_of(classifier: Any) -> Origin:
    """The tree of a fitted classifier. InputError as for `from_sklearn`."""
    tree = getattr(classifier, "tree_", None)
    if tree is None or not hasattr(classifier, "classes_"):
        advice = "fit it first; from a pipeline, give the tree alone, if no earlier step changes the observation"
        raise InputError("not a fitted DecisionTreeClassifier", type(classifier).__name__, advice)
    if tree.n_outputs != 1:
        raise InputError(f"the classifier has {tree.n_outputs} outputs, one is needed", "", "fit one tree per agent")
    _ensure_own(classifier, tree)
    place = {label: index for index, label in enumerate(classifier.classes_.tolist())}

    def act(rows: Float32) -> Int32:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # arrays have no names, and its search for infinities adds everything up
            said = classifier.predict(rows).tolist()
        return np.array([place[label] for label in said], dtype=np.int32)

    return Origin(
        kind=KIND,
        grown=grown_from_sklearn(tree, tree.value[:, 0].argmax(axis=1)),
        labels=tuple(classifier.classes_),
        act=act,
        replayed_by=REPLAYED_BY,
        features=tuple(str(each) for each in getattr(classifier, "feature_names_in_", ())),
        n_features=int(tree.n_features),
        finite=True,
    )


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
