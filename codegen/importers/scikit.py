"""Fitted trees of scikit-learn as profiles.

Does: reads a fitted decision tree by its attributes, also as the end of a Pipeline or search, or as the only tree of a
  forest or booster; folds the steps before it into its thresholds (steps.py, folding.py); replays the tree
  against the model's own `predict`.
Assumes: classes, or the few values of a regressor's leaves, are the actions; a regressor of many values, or of several
  outputs, gives them; observations are float32.
Does not: import scikit-learn, or open a file; scikit-learn's files are pickles, which run code.

What is kept: the decision for every float32 observation without NaN, given as float32. Steps compute in the type that
they are given: a Pipeline may decide the same numbers otherwise when they come as float64, as lists of numbers do.
NaN goes right here, whatever scikit-learn does with it at a node (its bigger side, if it was fitted without). Action k
is class k, in the classifier's own order: scikit-learn sorts its labels.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from codegen import ir
from codegen.errors import InputError, escape_text
from codegen.floats import neighbour, round_down
from codegen.importers import steps
from codegen.importers.folding import LARGEST, Asked, fold_steps
from codegen.importers.origin import AGENT, SINGLES, Names, Origin, profile_of
from codegen.importers.summed import giving
from codegen.ir import NO_ACTION, NO_CHILD, NO_FEATURE, Bool, Float32, Floats, GrownTree, Int32
from codegen.process.unwarned import silence_warnings

# what a subclass may have of its own: no prediction reads it
UNUSED = frozenset(
    """
    __abstractmethods__ __annotations__ __dict__ __doc__ __firstlineno__ __init__ __module__ __parameters__ __qualname__
    __orig_bases__ __repr__ __static_attributes__ __weakref__ _abc_impl _parameter_constraints fit set_fit_request
    set_score_request
    """.split()  # noqa: SIM905
)
READS = frozenset(("__getattr__", "__getattribute__", "__class__", "tree_", "classes_", "n_outputs_", "estimators_"))
TASKS = ("Classifier", "Regressor")
FORESTS = [f"sklearn.ensemble._forest.{kind}{task}" for kind in ("ExtraTrees", "RandomForest") for task in TASKS]
_HISTOGRAM = "_hist_gradient_boosting.gradient_boosting.HistGradientBoosting"
HISTOGRAMS = [f"sklearn.ensemble.{_HISTOGRAM}{task}" for task in TASKS]
BOOSTERS = [*(f"sklearn.ensemble._gb.GradientBoosting{task}" for task in TASKS), *HISTOGRAMS]
KIND, REPLAYED_BY = "scikit-learn", "its own predict"


def from_sklearn(
    classifier: Any,
    feature_names: Sequence[str] | None = None,
    action_names: Sequence[str] | None = None,
    name: str = "imported",
    output_names: Sequence[str] | None = None,
) -> ir.PolicyProfile:
    """A profile of one agent from a fitted decision tree, or a Pipeline, search, forest or booster of one.

    `feature_names`: default those it was fitted with, or x0, x1, ...; `action_names`: default its labels, one a class
    in the order of `classes_`. Both are made legal as names.py says. InputError for what is not a fitted classifier
    of one output, or regressor, whose `predict` is scikit-learn's, or was seen to learn from missing values.
    """
    return profile_of({AGENT: origin_of(classifier)}, Names(feature_names, action_names, name, output_names))


def origin_of(model: Any) -> Origin:
    """The tree of a fitted classifier, with the steps before it. InputError as for `from_sklearn`."""
    fitted, before = _unwrap_search(model), list[tuple[str, Any]]()
    if _of(fitted, "sklearn.pipeline.Pipeline"):
        *before, (_, fitted) = fitted.steps
        before = [each for each in before if each[1] is not None and each[1] != "passthrough"]
    estimator = _unwrap_search(fitted)
    single = _single(estimator)
    tree = _histogram_tree(estimator, single) if _of(estimator, *HISTOGRAMS) else getattr(single, "tree_", None)
    if tree is None or not (hasattr(estimator, "classes_") or hasattr(estimator, "predict")):
        advice = "fit it first; give a tree, a forest or booster of one, or a pipeline or search that ends in one"
        raise InputError("not a fitted decision tree", type(estimator).__name__, advice)
    regressor = not hasattr(estimator, "classes_")
    if tree.n_outputs != 1 and not regressor:
        raise InputError(f"the tree has {tree.n_outputs} outputs, one is needed", "", "fit one tree per agent")
    for each in {id(each): each for each in (model, _unwrap_search(model), estimator, single)}.values():
        _ensure_plain(each)
    _ensure_without_missing(tree)
    if regressor:
        given = _predict_leaves(estimator, tree)
        return giving(_origin(model, before, given.leaves, tree), given.values, lambda rows: _numbers(model, rows))
    return _origin(model, before, _leaves(estimator, tree), tree)


def _numbers(model: Any, rows: Floats) -> Any:
    """What a regressor predicts, as float64, [n, n_outputs]."""
    with silence_warnings():
        return np.asarray(model.predict(rows), dtype=np.float64).reshape(len(rows), -1)


def _single(estimator: Any) -> Any:
    """The only tree of a forest or booster; any other estimator itself."""
    if not _of(estimator, *FORESTS, *BOOSTERS):
        return estimator
    estimators = getattr(estimator, "_predictors" if _of(estimator, *HISTOGRAMS) else "estimators_", ())
    trees = np.array(estimators, dtype=object).ravel()
    if len(trees) != 1:
        what = f"the ensemble has {len(trees)} fitted trees, one is needed"
        one = "max_iter=1" if _of(estimator, *HISTOGRAMS) else "n_estimators=1"
        raise InputError(what, type(estimator).__name__, f"fit {one}, and boost two classes at most")
    return trees[0]


class _HistogramTree(NamedTuple):
    """A tree of histogram gradient boosting with the attributes that others have. It compares doubles."""

    feature: Any
    threshold: Any
    children_left: Any
    children_right: Any
    n_node_samples: Any
    missing_go_to_left: Any
    n_features: int
    n_outputs: int = 1

    @property
    def node_count(self) -> int:
        """How many nodes there are."""
        return len(self.feature)


def _histogram_tree(estimator: Any, single: Any) -> _HistogramTree:
    """The nodes of the one tree. InputError where it has categories."""
    nodes, leaf = single.nodes, single.nodes["is_leaf"].astype(bool)
    if nodes["is_categorical"][~leaf].any() or getattr(estimator, "_preprocessor", None) is not None:
        advice = "fit it on numbers, with categorical_features=None"
        raise InputError("the tree has categories", type(estimator).__name__, advice)
    left, right = (np.where(leaf, NO_CHILD, nodes[side].astype(np.int64)) for side in ("left", "right"))
    features, thresholds = nodes["feature_idx"].astype(np.int64), nodes["num_threshold"].astype(np.float64)
    missing = nodes["missing_go_to_left"]
    return _HistogramTree(features, thresholds, left, right, nodes["count"], missing, int(estimator.n_features_in_))


class _Leaves(NamedTuple):
    """What leaves stand for: labels, and the place of one for each node; those of splits count for nothing."""

    labels: list[Any]
    action: Any  # [n_nodes]


def _leaves(estimator: Any, tree: Any) -> _Leaves:
    """The classes of a classifier's leaves."""
    labels = list(estimator.classes_)
    if not _of(estimator, *BOOSTERS):
        return _Leaves(labels, tree.value[:, 0].argmax(axis=1))
    predicted = _predict_leaves(estimator, tree)
    place = {label: index for index, label in enumerate(np.asarray(labels).tolist())}
    action = np.zeros(tree.node_count, dtype=np.int64)
    action[predicted.nodes] = [place[label] for label in predicted.values[:, 0].tolist()]
    return _Leaves(labels, action)


class _Predicted(NamedTuple):
    """What an estimator predicts in the leaves that observations reach."""

    nodes: Any  # [n_leaves]
    values: Any  # [n_leaves, n_outputs]
    n_nodes: int

    @property
    def leaves(self) -> _Leaves:
        """Each leaf as a label of its own."""
        action = np.zeros(self.n_nodes, dtype=np.int64)
        action[self.nodes] = np.arange(len(self.nodes))
        return _Leaves([*range(len(self.nodes))], action)


def _predict_leaves(estimator: Any, tree: Any) -> _Predicted:
    grown = read_sklearn_tree(tree, np.arange(tree.node_count))
    nodes, low, high = (np.array(each) for each in zip(*_boxes(grown, int(tree.n_features)), strict=True))
    with silence_warnings():
        # a number in each box: the largest one, or else the one after the bound below
        said = estimator.predict(np.where(np.isfinite(high), high, np.where(np.isfinite(low), low, 0)))
    return _Predicted(nodes, np.asarray(said).reshape(len(nodes), -1), int(tree.node_count))


def _boxes(grown: GrownTree, width: int) -> list[tuple[int, Float32, Float32]]:
    """Each leaf with the least and the largest float32 numbers that come to it, [width] each."""
    boxes: list[tuple[int, Float32, Float32]] = []
    open_ = [(0, np.full(width, -np.inf, np.float32), np.full(width, np.inf, np.float32))]
    while open_:
        node, low, high = open_.pop()
        feature = int(grown.feature[node])
        if feature == NO_FEATURE:
            boxes.append((node, low, high))
            continue
        at = round_down(float(grown.threshold[node]))
        below, above = high.copy(), low.copy()
        below[feature], above[feature] = min(high[feature], at), max(low[feature], neighbour(at, np.inf))
        open_ += [(int(grown.left[node]), low, below), (int(grown.right[node]), above, high)]
    return [each for each in boxes if (each[1] <= each[2]).all()]


def _of(model: Any, *kinds: str) -> bool:
    return f"{type(model).__module__}.{type(model).__qualname__}" in kinds


def _unwrap_search(model: Any) -> Any:
    """The best estimator of a search for parameters; any other model itself."""
    if type(model).__module__.startswith("sklearn.model_selection.") and "predict" not in vars(model):
        if not hasattr(model, "best_estimator_"):
            raise InputError("the search has no best estimator", type(model).__name__, "fit it, with refit=True")
        return model.best_estimator_
    return model


def _origin(model: Any, before: Sequence[tuple[str, Any]], leaves: _Leaves, tree: Any) -> Origin:
    place = {label: index for index, label in enumerate(np.asarray(leaves.labels).tolist())}
    n_features = int(getattr(before[0][1], "n_features_in_", tree.n_features)) if before else int(tree.n_features)
    grown = read_sklearn_tree(tree, leaves.action)
    source = steps.columns(before, n_features)

    def transform_rows(rows: Floats) -> tuple[Float32, Bool]:
        taken = np.ones(len(rows), dtype=np.bool_)
        with silence_warnings():  # arrays have no names, and its search for infinities adds everything up
            for _, step in before:
                after = np.asarray(step.transform(rows))
                taken &= np.isfinite(after.astype(np.float32)).all(axis=1)
                # what is too large is refused by the next step; here it only has to stay in order
                rows = np.clip(after, -LARGEST, LARGEST)
        return rows.astype(np.float32), taken

    def act(rows: Floats) -> Int32:
        with silence_warnings():
            said = model.predict(rows).tolist()
        return np.array([place[label] for label in said], dtype=np.int32)

    return Origin(
        kind=KIND,
        grown=_fold_steps(grown, lambda rows: transform_rows(rows)[0], source, n_features) if before else grown,
        labels=tuple(leaves.labels),
        act=act,
        replayed_by=REPLAYED_BY,
        features=tuple(str(each) for each in getattr(model, "feature_names_in_", ())),
        n_features=n_features,
        finite=True,
        given="float32 arrays" if before else SINGLES,
        takes=(lambda rows: transform_rows(rows)[1]) if before else None,
    )


def _fold_steps(
    grown: GrownTree, transform: Callable[[Float32], Float32], source: Sequence[int], width: int
) -> GrownTree:
    """The tree over the observations before the steps, which take finite numbers only."""
    split = np.flatnonzero(grown.feature != NO_FEATURE)
    features = np.array(source, dtype=np.int64)[grown.feature[split]]

    def passes(numbers: Float32) -> Bool:
        rows = np.zeros((len(split), width), dtype=np.float32)
        rows[np.arange(len(split)), features] = np.where(np.isnan(numbers), 0, numbers)
        after = transform(rows)
        return after[np.arange(len(split)), grown.feature[split]] <= grown.threshold[split]

    tests = Asked(features, np.ones(len(split), dtype=np.bool_), passes)
    return fold_steps(grown, tests, LARGEST).tree


def _ensure_plain(model: Any) -> None:
    """InputError for a model of no class of scikit-learn, or whose class, or the model itself, replaces anything of
    scikit-learn's own but for how it is fitted: whatever prediction uses, such as `_validate_X_predict` or `classes_`,
    could differ.
    """
    kinds: tuple[type[Any], ...] = type(model).__mro__
    own = next((kind for kind in kinds if kind.__module__.startswith("sklearn.")), None)
    strange = [kind for kind in kinds if own and kind not in own.__mro__]
    added = [name for kind in strange for name in map(str, vars(kind)) if name not in UNUSED]
    replaced = [name for name in added if hasattr(own, name) or name in vars(model) or name in READS]
    replaced += [name for name in model.__dict__ if callable(getattr(own, name, None))]
    if own is None or replaced:
        what = "the classifier does not predict as scikit-learn's own"
        what += f": it replaces {escape_text(replaced[0])}" if replaced else ""
        raise InputError(what, type(model).__name__, "fit scikit-learn's own class")


def _ensure_without_missing(tree: Any) -> None:
    """InputError for a tree that was seen to learn where missing values go."""
    split = np.flatnonzero(tree.children_left != NO_CHILD)
    left, right = tree.children_left[split], tree.children_right[split]
    # without missing values in a node, scikit-learn says that they would follow its bigger side
    bigger = tree.n_node_samples[left] > tree.n_node_samples[right]
    odd = ~np.isfinite(tree.threshold[split]) | (tree.missing_go_to_left[split].astype(bool) != bigger)
    for node in split[odd][:1]:
        advice = "NaN always goes right here: fit it on data without missing values"
        raise InputError("the classifier was fitted on missing values", f"node {node}", advice)


def read_sklearn_tree(tree: Any, action: Any) -> GrownTree:
    """A fitted estimator's `tree_` with these actions, one per node; those of splits count for nothing."""
    split = tree.children_left != NO_CHILD
    return GrownTree(
        np.where(split, tree.feature, NO_FEATURE),
        np.where(split, tree.threshold, 0.0),
        np.where(split, tree.children_left, NO_CHILD),
        np.where(split, tree.children_right, NO_CHILD),
        np.where(split, NO_ACTION, action),
    )
