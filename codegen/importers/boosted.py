"""Trees of XGBoost and LightGBM, from the files that they save: one, or the sum of a few as one.

Does: reads XGBoost's JSON and LightGBM's text, with base score and link: two classes, or a number for each leaf, or
  of LightGBM a linear function. Sums are added in the order of their own predictors (XGBoost's on CPUs): float32 from
  the base score on, doubles from 0 on.
Assumes: the formats of XGBoost 1.6 to 3 and LightGBM 3 to 4.
Does not: take trees that together are large, categories, or zeros that stand for missing values.

XGBoost compares float32 numbers by `<`, LightGBM doubles by `<=`. Where NaN goes is part of their models; here it goes
right, and the profile says where that differs.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from codegen.errors import InputError, escape_text
from codegen.floats import FLOAT32, FLOAT64
from codegen.importers.documents import NEAR, second_class
from codegen.importers.nodes import Leaf, Source, Split, json_of, origin_of
from codegen.importers.origin import AGENT, DOUBLES, SINGLES, Origin
from codegen.importers.products import Product, Tree
from codegen.importers.symbolic.affine import Terms
from codegen.ir import CONSTANT

XGBOOST, LIGHTGBM = "XGBoost", "LightGBM"
ONE = "train one tree, or a few small ones, of an objective that is understood"
AGAIN = "save the model again"
NUMBERS = ("reg:squarederror", "reg:absoluteerror", "reg:pseudohubererror")
MULTI = ("multi:softmax", "multi:softprob")
REGRESSIONS = ("regression", "regression_l1", "huber", "fair")
ZERO = float(np.float32(1e-35))  # kZeroThreshold of LightGBM
CATEGORICAL, DEFAULT_LEFT, MISSING_ZERO, MISSING_NAN = 1, 2, 1 << 2, 2 << 2  # bits of LightGBM's decision_type


def from_xgboost(content: bytes, where: str) -> dict[str, Origin]:
    """The tree in XGBoost's JSON, or the sum of its trees as one. InputError for what is not numerical, or has another
    link.
    """
    document = json_of(content, where)
    try:
        learner = document["learner"]
        if int(learner["learner_model_param"].get("num_target", "1")) > 1:
            raise InputError("the model has several targets, one is needed", where, ONE)
        booster = learner["gradient_booster"]
        if booster["name"] != "gbtree" or not booster["model"]["trees"]:
            raise InputError(f"the booster {escape_text(booster['name'])} is not understood", where, "use gbtree")
        if "best_iteration" in learner.get("attributes", {}):
            what = "the model has a best_iteration, up to which some of XGBoost's functions predict, and others do not"
            raise InputError(what, where, "save the booster's slice: booster[: best_iteration + 1]")
        trees = [Tree(0, partial(_xgboost_node, tree, where)) for tree in booster["model"]["trees"]]
        names = [str(each) for each in learner.get("feature_names", ())]
        width = int(learner["learner_model_param"]["num_feature"])
        link = _Link(learner["objective"]["name"], _bases(learner["learner_model_param"]["base_score"]), where)
        if len(trees) == 1:
            read = link.alone(trees[0])
            origin = origin_of(Source(XGBOOST, where), 0, read, names, width)
        else:
            classes = [int(each) for each in booster["model"].get("tree_info", [0] * len(trees))]
            whole = Product(trees, partial(link.together, classes), where)
            origin = origin_of(Source(XGBOOST, where, FLOAT32), whole.root, whole.read, names, width)
        return {AGENT: replace(origin, given=SINGLES)}
    except (LookupError, TypeError, AttributeError, ValueError, OverflowError) as error:
        raise InputError(f"not XGBoost's JSON: {escape_text(error)[:100]}", where, AGAIN) from None


def _xgboost_node(tree: Mapping[str, Any], where: str, place: int) -> Split | Leaf:
    """A node; a leaf's label is its number."""
    if any(tree["split_type"]) or tree["categories"] or int(tree["tree_param"]["num_deleted"]):
        raise InputError("the tree has categories or deleted nodes", where, "train it on numbers, without pruning")
    then, otherwise = int(tree["left_children"][place]), int(tree["right_children"][place])
    number = float(np.float32(tree["split_conditions"][place]))
    if (then < 0) != (otherwise < 0):
        raise ValueError("a node has one child")
    if then == otherwise == -1:
        return Leaf(number)
    return Split(int(tree["split_indices"][place]), "<", number, then, otherwise, nan=bool(tree["default_left"][place]))


class _Link:
    """What the leaves of XGBoost stand for, alone and together: float32 numbers, added to the base in their order."""

    def __init__(self, objective: str, bases: Sequence[float], where: str) -> None:
        self.objective, self.bases, self.where = objective, bases, where

    def alone(self, tree: Tree) -> Callable[[int], Split | Leaf]:
        """The nodes of the only tree."""

        def read(place: int) -> Split | Leaf:
            each = tree.read(place)
            return (
                each
                if isinstance(each, Split)
                else Leaf(_apply_link(self.objective, _value(each), self.base, self.where))
            )

        return read

    @property
    def base(self) -> float:
        """The only base."""
        (base,) = self.bases
        return base

    def together(self, classes: Sequence[int], leaves: Sequence[Leaf]) -> Leaf:
        """What the leaves of a path stand for. `classes`: of the trees, where there are more than two."""
        numbers = [np.float32(_value(leaf)) for leaf in leaves]
        if self.objective in MULTI:
            bases = self.bases if len(self.bases) > 1 else [*self.bases] * (max(classes) + 1)
            scores = [np.float32(base) for base in bases]
            for place, number in zip(classes, numbers, strict=True):
                scores[place] = np.float32(scores[place] + number)
            return Leaf(best_class([float(score) for score in scores], self.where))
        if self.objective in NUMBERS:
            total = np.float32(self.base)
            for number in numbers:
                total = np.float32(total + number)
            return Leaf(0, ((float(total), CONSTANT),))
        return Leaf(_apply_link(self.objective, math.fsum(map(float, numbers)), self.base, self.where))


def _value(leaf: Leaf) -> float:
    assert isinstance(leaf.label, float), "the label of a tree that is read alone is its number"
    return leaf.label


def best_class(scores: Sequence[float], where: str) -> int:
    """The place of the largest score. InputError where another is so near that rounding may decide."""
    first, second = sorted(scores)[::-1][:2]
    if not first - second >= NEAR:
        raise InputError(f"two classes have scores too close to call, {first} and {second}", where, "train it again")
    return scores.index(first)


def _bases(text: Any) -> list[float]:
    """The base scores: a number, or a list."""
    return [float(each) for each in str(text).strip("[]").split(",")]


def _apply_link(objective: str, value: float, base: float, where: str) -> int | float:
    """What a leaf of XGBoost stands for."""
    if objective == "binary:logistic" and 0 < base < 1:
        return second_class(value + math.log(base / (1 - base)), where)
    if objective in NUMBERS:
        return float(np.float32(value) + np.float32(base))
    raise InputError(f"the objective is not understood: {escape_text(objective)}", where, ONE)


def from_lightgbm(content: bytes, where: str) -> dict[str, Origin]:
    """The tree in LightGBM's text, or the sum of its trees as one. InputError for what is not numerical, or has another
    link.
    """
    try:
        head, *trees = content.decode().partition("\nend of trees")[0].split("\nTree=")
        if not trees:
            raise InputError("the model has 0 trees, one is needed", where, ONE)
        model, fields = _fields(head), [_fields(tree) for tree in trees]
        if any(int(tree["num_cat"]) for tree in fields):
            raise InputError("the tree has categories", where, "train it on numbers")
        link, *how = model["objective"].split()
        if "sqrt" in how:
            raise InputError("the model squares what its leaves say (reg_sqrt)", where, "train it without reg_sqrt")
        if "average_output" in model:
            raise InputError("the model gives the mean of its trees (boosting rf)", where, "use boosting gbdt")
        names = model.get("feature_names", "").split(" ")
        width = int(model["max_feature_idx"]) + 1
        named = names if len(names) == width else ()
        read = [_LightGbm(tree, link, where) for tree in fields]
        if len(read) == 1:
            origin = origin_of(Source(LIGHTGBM, where), read[0].root, read[0].read, named, width)
        else:
            if any(each.forms for each in read):
                raise InputError("several trees have linear leaves, whose sums are added to sums", where, ONE)
            whole = Product([Tree(each.root, each.raw) for each in read], partial(_together, link, model, where), where)
            origin = origin_of(Source(LIGHTGBM, where), whole.root, whole.read, named, width)
        return {AGENT: replace(origin, numbers=FLOAT64, given=DOUBLES)}
    except (LookupError, ValueError, OverflowError) as error:
        raise InputError(f"not LightGBM's text: {escape_text(error)[:100]}", where, AGAIN) from None


def _together(link: str, model: Mapping[str, str], where: str, leaves: Sequence[Leaf]) -> Leaf:
    """What the leaves of a path stand for: doubles, added to 0 in their order."""
    count = int(model.get("num_tree_per_iteration", "1"))
    scores = [0.0] * count
    for place, leaf in enumerate(leaves):
        scores[place % count] += _value(leaf)
    if link == "multiclass":
        return Leaf(best_class(scores, where))
    if link in REGRESSIONS and count == 1:
        return Leaf(0, ((scores[0], CONSTANT),))
    return Leaf(_label(scores[0], link, where))


def _fields(text: str) -> Mapping[str, str]:
    """The lines `name=value`."""
    return {name: value for name, _, value in (line.partition("=") for line in text.splitlines())}


def _linear(lists: Mapping[str, list[str]], count: int) -> tuple[Terms, ...]:
    """What linear leaves give: a constant, then products in the order of the file, as LightGBM adds them."""
    sizes = [int(each) for each in lists["num_features"]]
    places, weights = (iter(lists[name]) for name in ("leaf_features", "leaf_coeff"))
    if len(sizes) != count or sum(sizes) != len(lists["leaf_features"]) or sum(sizes) != len(lists["leaf_coeff"]):
        raise ValueError("the linear leaves have other numbers of features")
    leaf_terms: list[Terms] = []
    for constant, size in zip(lists["leaf_const"], sizes, strict=True):
        # LightGBM adds what a tree says to 0, and so gives no -0.0
        terms = [(float(constant) + 0.0, CONSTANT)]
        for _ in range(size):
            place, weight = int(next(places)), float(next(weights))
            terms += [(weight, place)] if weight else []
        leaf_terms.append(tuple(terms))
    return tuple(leaf_terms)


def _beyond_zero(threshold: float) -> float:
    """The threshold that decides as LightGBM's predictor, which takes numbers up to ZERO for 0, of either sign."""
    if not -ZERO <= threshold < ZERO:
        return threshold
    return ZERO if threshold >= 0 else math.nextafter(-ZERO, -math.inf)


class _LightGbm:
    """The arrays of a tree: splits from 0 on, leaves as -1, -2 and so on."""

    def __init__(self, tree: Mapping[str, str], link: str, where: str) -> None:
        lists = {name: tree.get(name, "").split() for name in tree}
        self.features = [int(each) for each in lists.get("split_feature", ())]
        self.thresholds = [_beyond_zero(float(each)) for each in lists.get("threshold", ())]
        self.types = [int(each) for each in lists.get("decision_type", ())]
        self.sides = [[int(each) for each in lists.get(f"{side}_child", ())] for side in ("left", "right")]
        self.values = [float(each) for each in lists["leaf_value"]]
        self.link, self.where = link, where
        self.forms = _linear(lists, len(self.values)) if int(tree.get("is_linear", "0")) else ()
        if self.forms and link != "regression":
            raise InputError(f"linear leaves of the objective {escape_text(link)} are not understood", where, ONE)

    @property
    def root(self) -> int:
        """The first split, or the only leaf."""
        return 0 if self.features else -1

    def read(self, place: int) -> Split | Leaf:
        """A split, or a leaf with what it stands for."""
        each = self.raw(place)
        if isinstance(each, Split) or each.terms:
            return each
        return Leaf(_label(_value(each), self.link, self.where))

    def raw(self, place: int) -> Split | Leaf:
        """A split, or a leaf with its number."""
        if place < 0:
            return Leaf(0, self.forms[-place - 1]) if self.forms else Leaf(self.values[-place - 1])
        kind, number = self.types[place], self.thresholds[place]
        if kind & CATEGORICAL:
            raise InputError("a split is by categories", self.where, "train it on numbers")
        if kind & MISSING_ZERO:
            what = f"a split takes zeros for missing values, at feature {self.features[place]}"
            raise InputError(what, self.where, "train it with zero_as_missing=false")
        # without missing values in training, a NaN counts as 0
        nan = bool(kind & DEFAULT_LEFT) if kind & MISSING_NAN else number >= 0
        return Split(self.features[place], "<=", number, self.sides[0][place], self.sides[1][place], nan)


def _label(value: float, link: str, where: str) -> int | float:
    """What a number of LightGBM stands for."""
    if link == "binary":
        return second_class(value, where)
    if link in REGRESSIONS:
        return value
    raise InputError(f"the objective is not understood: {escape_text(link)}", where, ONE)
