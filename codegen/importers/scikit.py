"""Fitted trees of scikit-learn as profiles.

Does: reads a fitted decision tree by its attributes, also as the end of a Pipeline or search, or as the only tree of a
  booster; makes one tree of a small forest (nodes.py); folds scalers, selectors and binarizers before it into its
  thresholds (onnx/fitted.py); replays the tree against the model's own `predict`.
Assumes: classes, or the few values of a regressor's leaves, are the actions; a regressor of many values, or of several
  outputs, gives them. Observations are float32, but of HistGradientBoosting, which compares doubles.
Does not: import scikit-learn, or open a file; scikit-learn's files are pickles, which run code.

What is kept: the decision for every float32 observation without NaN, given as float32. Steps compute in the type that
they are given: a Pipeline may decide the same numbers otherwise when they come as float64, as lists of numbers do.
NaN goes right here. scikit-learn sends it to the bigger side at each split, unless the tree was fitted on missing
values there: a note counts the splits that send it left, and what shows such fitting is refused. Action k is class k,
in the classifier's own order: scikit-learn sorts its labels.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from typing import Any, NamedTuple, cast

import numpy as np

from codegen import ir
from codegen.boxes import find_point
from codegen.errors import DisagreementError, InputError, escape_text
from codegen.floats import FLOAT32, FLOAT64
from codegen.importers.nodes import Leaf, Split, Tree, origin_of_sum
from codegen.importers.onnx.fitted import LARGEST, Asked, fold_steps, giving
from codegen.importers.origin import Names, profile_of
from codegen.importers.reading import AGENT, DOUBLES, SINGLES, Origin
from codegen.importers.symbolic.paths import Described
from codegen.ir import NO_ACTION, NO_CHILD, NO_FEATURE, ROOT, Bool, Float32, Floats, GrownTree, Int32
from codegen.numbers import round_down
from codegen.paths import EVERYTHING, Box
from codegen.process import silence_warnings

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
POSITIVE = {  # steps of scikit-learn, and what their columns are multiplied with or divided by
    "sklearn.preprocessing._data.StandardScaler": "scale_",
    "sklearn.preprocessing._data.RobustScaler": "scale_",
    "sklearn.preprocessing._data.MinMaxScaler": "scale_",
    "sklearn.preprocessing._data.MaxAbsScaler": "scale_",
    "sklearn.preprocessing._data.Binarizer": "",
}
SELECTORS = "sklearn.feature_selection."
USED = ("mean_", "scale_", "center_", "min_", "data_min_", "data_max_", "max_abs_")  # by transform


def from_sklearn(
    classifier: Any,
    feature_names: Sequence[str] | None = None,
    action_names: Sequence[str] | None = None,
    name: str = "imported",
    output_names: Sequence[str] | None = None,
    numbers: str | None = None,
) -> ir.PolicyProfile:
    """A profile of one agent from a fitted decision tree, or a Pipeline, search, forest or booster of one.

    `feature_names`: default those it was fitted with, or x0, x1, ...; `action_names`: default its labels, one a class
    in the order of `classes_`. Both are made legal as names.py says. `numbers`: that are observed; default float32, or
    float64 where the model compares that. InputError for what is not a fitted classifier
    of one output, or regressor, whose `predict` is scikit-learn's, or was seen to learn from missing values.
    """
    return profile_of({AGENT: origin_of(classifier)}, Names(feature_names, action_names, name, output_names), numbers)


def origin_of(model: Any) -> Origin:
    """The tree of a fitted classifier, with the steps before it. InputError as for `from_sklearn`."""
    fitted, before = _unwrap_search(model), list[tuple[str, Any]]()
    if _of(fitted, "sklearn.pipeline.Pipeline"):
        *before, (_, fitted) = fitted.steps
        before = [each for each in before if each[1] is not None and each[1] != "passthrough"]
    estimator = _unwrap_search(fitted)
    single = _trees(estimator)
    trees = [_histogram_tree(estimator, each) if _of(estimator, *HISTOGRAMS) else each.tree_ for each in single]
    regressor = not hasattr(estimator, "classes_")
    if trees[0].n_outputs != 1 and not regressor:
        raise InputError(f"the tree has {trees[0].n_outputs} outputs, one is needed", "", "fit one tree per agent")
    for each in {id(each): each for each in (model, _unwrap_search(model), estimator, *single)}.values():
        _ensure_plain(each)
    for tree in trees:
        _ensure_without_missing(tree)
    if len(trees) > 1:
        grown, values = _sum_forest(estimator, trees, regressor=regressor)
    elif not regressor and not _of(estimator, *BOOSTERS):
        grown, values = read_sklearn_tree(trees[0], trees[0].value[:, 0].argmax(axis=1)), ()
    else:
        nodes, values = _predict_leaves(estimator, trees[0])
        action = np.zeros(trees[0].node_count, dtype=np.int64)
        place = None if regressor else _places(estimator.classes_)
        action[nodes] = np.arange(len(nodes)) if place is None else [place[label] for label in values[:, 0].tolist()]
        grown = read_sklearn_tree(trees[0], action)
    fitted = _Fitted(model, before, estimator, trees)
    if not regressor:
        return _origin(fitted, list(estimator.classes_), grown)

    def predict_numbers(rows: Floats) -> Any:
        return _predict(fitted, rows).astype(np.float64).reshape(len(rows), -1)

    return giving(_origin(fitted, range(len(values)), grown), values, predict_numbers)


class _Fitted(NamedTuple):
    """A model in its parts."""

    model: Any
    before: Sequence[tuple[str, Any]]  # steps with their names
    estimator: Any
    trees: Sequence[Any]  # their attributes are those of a `tree_`


def _predict(fitted: _Fitted, rows: Floats) -> Any:
    """Returns a model's predictions. A tree of float32 numbers is asked beside each of them too, among doubles that
    round to the same float32: DisagreementError where it tells them apart.
    """
    with silence_warnings():
        said = np.asarray(fitted.model.predict(rows))
        for side in () if fitted.before or rows.dtype == np.float64 else (-np.inf, np.inf):
            if (np.asarray(fitted.model.predict(np.nextafter(rows.astype(np.float64), side))) != said).any():
                what = "the model tells doubles apart that are one float32 number"
                raise DisagreementError(what, type(fitted.model).__name__, "nothing was written; please report it")
    return said


def _takes_nan(fitted: _Fitted) -> bool:
    """Returns True if a model predicts for missing values, whatever it was fitted on."""
    try:
        _predict(fitted, np.full((1, int(fitted.trees[0].n_features)), np.nan))
    except ValueError:
        return False
    return True


def _trees(estimator: Any) -> list[Any]:
    """The fitted trees of an estimator: several of a forest, one of any other. InputError where there is none."""
    if not _of(estimator, *FORESTS, *BOOSTERS):
        trees = [estimator] if hasattr(estimator, "tree_") and hasattr(estimator, "predict") else []
    else:
        held = getattr(estimator, "_predictors" if _of(estimator, *HISTOGRAMS) else "estimators_", ())
        trees = list(np.array(held, dtype=object).ravel())
    if not trees:
        advice = "fit it first; give a tree, a forest, a booster of one, or a pipeline or search that ends in one"
        raise InputError("not a fitted decision tree", type(estimator).__name__, advice)
    if len(trees) > 1 and not _of(estimator, *FORESTS):
        what = f"the ensemble has {len(trees)} fitted trees, one is needed"
        one = "max_iter=1" if _of(estimator, *HISTOGRAMS) else "n_estimators=1"
        raise InputError(what, type(estimator).__name__, f"fit {one}, and boost two classes at most")
    if len(trees) > 1 and estimator.n_jobs not in (None, 1):
        what = f"with n_jobs={estimator.n_jobs} the trees of a forest are added in any order, and rounded so"
        raise InputError(what, type(estimator).__name__, "say set_params(n_jobs=1), and predict so")
    return trees


def _sum_forest(estimator: Any, trees: Sequence[Any], *, regressor: bool) -> tuple[GrownTree, Any]:
    """The trees of a forest as one. Its actions are places of classes, or of the rows of what is given,
    [n, n_outputs].

    As `predict` of a forest does, means are added tree by tree and divided by their number; of equal probabilities the
    first class is taken.
    """
    kept = dict[tuple[float, ...], int]()

    def read(tree: Any, node: int) -> Split | Leaf:
        if tree.children_left[node] == NO_CHILD:
            return Leaf(node)
        then, otherwise = int(tree.children_left[node]), int(tree.children_right[node])
        limit = float(round_down(float(tree.threshold[node])))
        return Split(int(tree.feature[node]), "<=", limit, then, otherwise, nan=False)

    def add(leaves: Sequence[Leaf]) -> Leaf:
        total = np.zeros_like(trees[0].value[0])
        for tree, leaf in zip(trees, leaves, strict=True):
            total += tree.value[leaf.label]
        total /= len(trees)
        return Leaf(kept.setdefault(tuple(total[:, 0].tolist()), len(kept)) if regressor else int(total[0].argmax()))

    said = Described(kind=KIND, n_features=int(trees[0].n_features), numbers=FLOAT32)
    origin = origin_of_sum([Tree(ROOT, partial(read, tree)) for tree in trees], add, said, type(estimator).__name__)
    labels = np.array([*origin.labels, NO_ACTION])  # of splits the action is the last
    return replace(origin.grown, action=labels[origin.grown.action]), np.array([*kept])


def _histogram_tree(estimator: Any, single: Any) -> SimpleNamespace:
    """The one tree, which compares doubles, with the attributes that others have. InputError for categories."""
    nodes, leaf = single.nodes, single.nodes["is_leaf"].astype(bool)
    if nodes["is_categorical"][~leaf].any() or getattr(estimator, "_preprocessor", None) is not None:
        advice = "fit it on numbers, with categorical_features=None"
        raise InputError("the tree has categories", type(estimator).__name__, advice)
    return SimpleNamespace(
        feature=nodes["feature_idx"].astype(np.int64),
        threshold=nodes["num_threshold"].astype(np.float64),
        children_left=np.where(leaf, NO_CHILD, nodes["left"].astype(np.int64)),
        children_right=np.where(leaf, NO_CHILD, nodes["right"].astype(np.int64)),
        n_node_samples=nodes["count"],
        missing_go_to_left=nodes["missing_go_to_left"],
        node_count=len(nodes),
        n_features=int(estimator.n_features_in_),
        n_outputs=1,
    )


def _predict_leaves(estimator: Any, tree: Any) -> tuple[Any, Any]:
    """The leaves that observations reach, [n_leaves], and what an estimator predicts there, [n_leaves, n_outputs]."""
    grown = read_sklearn_tree(tree, np.arange(tree.node_count))
    numbers = FLOAT64 if _of(estimator, *HISTOGRAMS) else FLOAT32
    nodes, rows = zip(*_reach_leaves(grown, int(tree.n_features), numbers), strict=True)
    with silence_warnings():
        return np.array(nodes), np.asarray(estimator.predict(np.array(rows))).reshape(len(nodes), -1)


def _reach_leaves(grown: GrownTree, width: int, numbers: str) -> Iterator[tuple[int, Floats]]:
    """Each leaf that finite observations reach, and one of them, [width]."""
    open_: list[tuple[int, Box | None]] = [(ROOT, EVERYTHING)]
    while open_:
        node, box = open_.pop()
        if box is None:
            continue
        if grown.feature[node] != NO_FEATURE:
            threshold = float(grown.threshold[node])
            threshold = threshold if numbers == FLOAT64 else float(round_down(threshold))
            left, right = box.split_at(int(grown.feature[node]), threshold)
            open_ += [(int(grown.left[node]), left), (int(grown.right[node]), right)]
        elif np.isfinite(point := find_point(box, width, numbers)).all():
            yield node, point


def _places(labels: Any) -> dict[Any, int]:
    return {label: index for index, label in enumerate(np.asarray(labels).tolist())}


def _of(model: Any, *kinds: str) -> bool:
    return f"{type(model).__module__}.{type(model).__qualname__}" in kinds


def _unwrap_search(model: Any) -> Any:
    """The best estimator of a search for parameters; any other model itself."""
    if type(model).__module__.startswith("sklearn.model_selection.") and "predict" not in vars(model):
        if not hasattr(model, "best_estimator_"):
            raise InputError("the search has no best estimator", type(model).__name__, "fit it, with refit=True")
        return model.best_estimator_
    return model


def _origin(fitted: _Fitted, labels: Sequence[Any], grown: GrownTree) -> Origin:
    """The origin of a tree, whose actions are places of labels."""
    model, before, estimator, trees = fitted
    place, width = _places(labels), int(trees[0].n_features)
    n_features = int(getattr(before[0][1], "n_features_in_", width)) if before else width
    source = _columns(before, n_features)
    doubles = _of(estimator, *HISTOGRAMS)
    left = sum(int(tree.missing_go_to_left[tree.children_left != NO_CHILD].sum()) for tree in trees)
    splits = sum(int((tree.children_left != NO_CHILD).sum()) for tree in trees)

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
        return np.array([place[label] for label in _predict(fitted, rows).tolist()], dtype=np.int32)

    return Origin(
        kind=KIND,
        grown=_fold_steps(grown, lambda rows: transform_rows(rows)[0], source, n_features) if before else grown,
        labels=tuple(labels),
        act=act,
        replayed_by=REPLAYED_BY,
        features=tuple(str(each) for each in getattr(model, "feature_names_in_", ())),
        n_features=n_features,
        nan=not left and not before and _takes_nan(fitted),
        finite=True,
        numbers=FLOAT64 if doubles and not before else FLOAT32,
        given="float32 arrays" if before else DOUBLES if doubles else SINGLES,
        takes=(lambda rows: transform_rows(rows)[1]) if before else None,
        notes=(f"NaN: scikit-learn sends it left at {left} of {splits} splits",) if left else (),
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


# --- steps before a tree


def _columns(steps: Sequence[tuple[str, Any]], width: int) -> list[int]:
    """Returns the observation's column that each one after the steps is made of. InputError with its name for a step
    that is not known to keep columns apart and in order: each known one maps one column by subtractions, additions,
    products with and quotients by positive numbers, clipping or a comparison, and so never falls where its input rises.
    """
    places: list[int] = list(range(width))
    for name, step in steps:
        kind = f"{type(step).__module__}.{type(step).__qualname__}"
        for attribute, value in cast("dict[str, Any]", vars(step)).items():
            array = np.asarray(value) if attribute.endswith("_") and isinstance(value, np.ndarray | float) else None
            if attribute in USED and array is not None and array.dtype.kind == "f" and not np.isfinite(array).all():
                step_name = f"the step {escape_text(name)!r} before the tree"
                what = f"{step_name} has learned numbers that are not finite: {attribute}"
                raise InputError(what, type(step).__name__, "fit it on data without missing or infinite values")
        if kind.startswith(SELECTORS) and "transform" not in vars(step) and hasattr(step, "get_support"):
            kept: list[int] = step.get_support(indices=True).tolist()
            places = [places[place] for place in kept]
        elif kind not in POSITIVE or "transform" in vars(step) or not _rising(step, POSITIVE[kind]):
            what = f"the step {escape_text(name)!r} before the tree is not understood: {type(step).__name__}"
            raise InputError(what, "", "use scalers, selectors and binarizers, or give the tree alone")
    return places


def _rising(step: Any, attribute: str) -> bool:
    factor = getattr(step, attribute, None) if attribute else None
    return factor is None or bool((np.isfinite(factor) & (np.asarray(factor) > 0)).all())
