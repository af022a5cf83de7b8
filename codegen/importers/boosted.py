"""Single trees of XGBoost and LightGBM, from the files that they save.

Does: reads XGBoost's JSON and LightGBM's text, with base score and link: two classes, or a number for each leaf, or
  of LightGBM a linear function.
Assumes: the formats of XGBoost 1.6 to 3 and LightGBM 3 to 4.
Does not: take several trees, categories, or zeros that stand for missing values.

XGBoost compares float32 numbers by `<`, LightGBM doubles by `<=`. Where NaN goes is part of their models; here it goes
right, and the profile says where that differs.
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from codegen.errors import InputError, shown
from codegen.floats import FLOAT64
from codegen.importers.documents import second_class
from codegen.importers.nodes import Leaf, Split, json_of, origin_of
from codegen.importers.origin import AGENT, DOUBLES, SINGLES, Origin
from codegen.importers.symbolic.affine import Terms
from codegen.ir import CONSTANT

XGBOOST, LIGHTGBM = "XGBoost", "LightGBM"
ONE = "train one tree: n_estimators=1, and two classes at most"
AGAIN = "save the model again"
NUMBERS = ("reg:squarederror", "reg:absoluteerror", "reg:pseudohubererror")
CATEGORICAL, DEFAULT_LEFT, MISSING_ZERO, MISSING_NAN = 1, 2, 1 << 2, 2 << 2  # bits of LightGBM's decision_type


def from_xgboost(content: bytes, where: str) -> dict[str, Origin]:
    """The tree in XGBoost's JSON. InputError for what is more than one numerical tree with a known link."""
    document = json_of(content, where)
    try:
        learner = document["learner"]
        if int(learner["learner_model_param"].get("num_target", "1")) > 1:
            raise InputError("the model has several targets, one is needed", where, ONE)
        booster = learner["gradient_booster"]
        if booster["name"] != "gbtree" or len(booster["model"]["trees"]) != 1:
            count = len(booster.get("model", {}).get("trees", ()))
            raise InputError(f"the booster {shown(booster['name'])} has {count} trees, one is needed", where, ONE)
        (tree,) = booster["model"]["trees"]
        if any(tree["split_type"]) or tree["categories"] or int(tree["tree_param"]["num_deleted"]):
            raise InputError("the tree has categories or deleted nodes", where, "train it on numbers, without pruning")
        objective, base = learner["objective"]["name"], _base(learner["learner_model_param"]["base_score"])
        names = [str(each) for each in learner.get("feature_names", ())]

        def read(place: int) -> Split | Leaf:
            then, otherwise = int(tree["left_children"][place]), int(tree["right_children"][place])
            number = float(np.float32(tree["split_conditions"][place]))
            if (then < 0) != (otherwise < 0):
                raise ValueError("a node has one child")
            if then == otherwise == -1:
                return Leaf(_linked(objective, number, base, where))
            feature, left = int(tree["split_indices"][place]), bool(tree["default_left"][place])
            return Split(feature, "<", number, then, otherwise, nan=left)

        width = int(learner["learner_model_param"]["num_feature"])
        return {AGENT: replace(origin_of(XGBOOST, 0, read, names, width, where), given=SINGLES)}
    except (LookupError, TypeError, AttributeError, ValueError, OverflowError) as error:
        raise InputError(f"not XGBoost's JSON: {shown(error)[:100]}", where, AGAIN) from None


def _base(text: Any) -> float:
    """The base score, a number or a list of one."""
    return float(str(text).strip("[]"))


def _linked(objective: str, value: float, base: float, where: str) -> int | float:
    """What a leaf of XGBoost stands for."""
    if objective == "binary:logistic" and 0 < base < 1:
        return second_class(value + math.log(base / (1 - base)), where)
    if objective in NUMBERS:
        return float(np.float32(value) + np.float32(base))
    raise InputError(f"the objective is not understood: {shown(objective)}", where, ONE)


def from_lightgbm(content: bytes, where: str) -> dict[str, Origin]:
    """The tree in LightGBM's text. InputError for what is more than one numerical tree with a known link."""
    try:
        head, *trees = content.decode().partition("\nend of trees")[0].split("\nTree=")
        if len(trees) != 1:
            raise InputError(f"the model has {len(trees)} trees, one is needed", where, ONE)
        model, tree = _fields(head), _fields(trees[0])
        if int(tree["num_cat"]):
            raise InputError("the tree has categories", where, "train it on numbers")
        link, *how = model["objective"].split()
        if "sqrt" in how:
            raise InputError("the model squares what its leaves say (reg_sqrt)", where, "train it without reg_sqrt")
        splits = _LightGbm(tree, link, where)
        names = model.get("feature_names", "").split(" ")
        width = int(model["max_feature_idx"]) + 1
        root = 0 if splits.features else -1
        origin = origin_of(LIGHTGBM, root, splits.read, names if len(names) == width else (), width, where)
        return {AGENT: replace(origin, numbers=FLOAT64, given=DOUBLES)}
    except (LookupError, ValueError, OverflowError) as error:
        raise InputError(f"not LightGBM's text: {shown(error)[:100]}", where, AGAIN) from None


def _fields(text: str) -> Mapping[str, str]:
    """The lines `name=value`."""
    return {name: value for name, _, value in (line.partition("=") for line in text.splitlines())}


def _linear(lists: Mapping[str, list[str]], count: int) -> tuple[Terms, ...]:
    """What linear leaves give: a constant, then products in the order of the file, as LightGBM adds them."""
    sizes = [int(each) for each in lists["num_features"]]
    places, weights = (iter(lists[name]) for name in ("leaf_features", "leaf_coeff"))
    if len(sizes) != count or sum(sizes) != len(lists["leaf_features"]) or sum(sizes) != len(lists["leaf_coeff"]):
        raise ValueError("the linear leaves have other numbers of features")
    found: list[Terms] = []
    for constant, size in zip(lists["leaf_const"], sizes, strict=True):
        # LightGBM adds what a tree says to 0, and so gives no -0.0
        terms = [(float(constant) + 0.0, CONSTANT)]
        for _ in range(size):
            place, weight = int(next(places)), float(next(weights))
            terms += [(weight, place)] if weight else []
        found.append(tuple(terms))
    return tuple(found)


class _LightGbm:
    """The arrays of a tree: splits from 0 on, leaves as -1, -2 and so on."""

    def __init__(self, tree: Mapping[str, str], link: str, where: str) -> None:
        lists = {name: tree.get(name, "").split() for name in tree}
        self.features = [int(each) for each in lists.get("split_feature", ())]
        self.thresholds = [float(each) for each in lists.get("threshold", ())]
        self.types = [int(each) for each in lists.get("decision_type", ())]
        self.sides = [[int(each) for each in lists.get(f"{side}_child", ())] for side in ("left", "right")]
        self.values = [float(each) for each in lists["leaf_value"]]
        self.link, self.where = link, where
        self.forms = _linear(lists, len(self.values)) if int(tree.get("is_linear", "0")) else ()
        if self.forms and link != "regression":
            raise InputError(f"linear leaves of the objective {shown(link)} are not understood", where, ONE)

    def read(self, place: int) -> Split | Leaf:
        """A split or leaf."""
        if place < 0:
            return Leaf(0, self.forms[-place - 1]) if self.forms else Leaf(self.label(self.values[-place - 1]))
        kind, number = self.types[place], self.thresholds[place]
        if kind & CATEGORICAL:
            raise InputError("a split is by categories", self.where, "train it on numbers")
        if kind & MISSING_ZERO:
            what = f"a split takes zeros for missing values, at feature {self.features[place]}"
            raise InputError(what, self.where, "train it with zero_as_missing=false")
        # without missing values in training, a NaN counts as 0
        nan = bool(kind & DEFAULT_LEFT) if kind & MISSING_NAN else number >= 0
        return Split(self.features[place], "<=", number, self.sides[0][place], self.sides[1][place], nan)

    def label(self, value: float) -> int | float:
        """What a leaf stands for."""
        if self.link == "binary":
            return second_class(value, self.where)
        if self.link in ("regression", "regression_l1", "huber", "fair"):
            return value
        raise InputError(f"the objective is not understood: {shown(self.link)}", self.where, ONE)
