"""Trees of XGBoost, LightGBM and treelite, from the files that they save: one, or the sum of a few as one.

Does: reads XGBoost's JSON and LightGBM's text, with base score and link: two classes, or a number for each leaf, or
  of LightGBM a linear function. Sums are added in the order of their own predictors (XGBoost's on CPUs): float32 from
  the base score on, doubles from 0 on. Of treelite it reads what `dump_as_json` says of one tree.
Assumes: the formats of XGBoost 1.6 to 3, LightGBM 3 to 4 and treelite 4.
Does not: take trees that together are large, several of treelite's, categories, or zeros for missing values.

XGBoost compares float32 numbers by `<`, LightGBM doubles by `<=`, treelite what its models say. Where NaN goes is part
of their models; here it goes right, and the profile says where that differs.
"""

import math
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any, cast

import numpy as np

from codegen.errors import InputError, escape_text
from codegen.floats import FLOAT32, FLOAT64, NUMBERS
from codegen.importers.nodes import Leaf, Split, Tree, json_of, origin_of, origin_of_sum
from codegen.importers.reading import AGENT, DOUBLES, MAX_VALUES, SINGLES, Origin
from codegen.importers.symbolic.feature import Terms
from codegen.importers.symbolic.paths import Described
from codegen.ir import CONSTANT

XGBOOST, LIGHTGBM, TREELITE = "XGBoost", "LightGBM", "treelite"
NEAR = 1e-5  # scores this close to the border may be rounded across it
CLASSES = ("identity_multiclass", "softmax", "max_index")  # of treelite: none changes which score is the largest
ONE = "train one tree, or a few small ones, of an objective that is understood"
AGAIN = "save the model again"
SIGN, LARGEST, NUMBER = "sign", "largest", "number"  # what scores stand for
LINKS = {  # of objectives, by library
    XGBOOST: {
        "binary:logistic": SIGN, "multi:softmax": LARGEST, "multi:softprob": LARGEST, "reg:squarederror": NUMBER,
        "reg:absoluteerror": NUMBER, "reg:pseudohubererror": NUMBER,
    },
    LIGHTGBM: {
        "binary": SIGN, "multiclass": LARGEST, "regression": NUMBER, "regression_l1": NUMBER, "huber": NUMBER,
        "fair": NUMBER,
    },
}  # fmt: skip
ZERO = float(np.float32(1e-35))  # kZeroThreshold of LightGBM
CATEGORICAL, DEFAULT_LEFT, MISSING_ZERO, MISSING_NAN = 1, 2, 1 << 2, 2 << 2  # bits of LightGBM's decision_type


def second_class(score: float, where: str) -> int:
    """1 for a score above 0, else 0. InputError for one so near to 0 that its probability is rounded to 1/2."""
    if not abs(score) >= NEAR:  # or no number at all
        raise InputError(f"a leaf's score, {score}, is too close to call", where, "train the tree again")
    return int(score > 0)


# --- XGBoost


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
        classes = [int(each) for each in booster["model"].get("tree_info", [0] * len(trees))]
        names = [str(each) for each in learner.get("feature_names", ())]
        width = int(learner["learner_model_param"]["num_feature"])
        objective = learner["objective"]["name"]
        # a number, or a list
        bases = [float(each) for each in str(learner["learner_model_param"]["base_score"]).strip("[]").split(",")]
        add = partial(_add_xgboost, objective, bases, classes, where)
        said = Described(kind=XGBOOST, features=names, n_features=width, numbers=FLOAT32, given=SINGLES)
        return {AGENT: origin_of_sum(trees, add, said, where)}
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


def _add_xgboost(
    objective: str, bases: Sequence[float], classes: Sequence[int], where: str, leaves: Sequence[Leaf]
) -> Leaf:
    """Returns the leaf that the leaves of a path add up to. `classes`: of the trees, where there are more than two."""
    link = LINKS[XGBOOST].get(objective)
    if link == SIGN:
        if len(bases) > 1 or not 0 < bases[0] < 1:
            raise InputError(f"the objective is not understood: {escape_text(objective)}", where, ONE)
        logit = math.log(bases[0] / (1 - bases[0]))
        score = math.fsum(map(_value, leaves)) + logit
        return _apply_link(link, objective, [score], where, alone=len(leaves) == 1)
    several = link == LARGEST and len(bases) == 1
    scores = [np.float32(base) for base in ([*bases] * (max(classes) + 1) if several else bases)]
    for place, leaf in zip(classes, leaves, strict=True):
        scores[place] = np.float32(scores[place] + np.float32(_value(leaf)))
    return _apply_link(link, objective, scores, where, alone=len(leaves) == 1)


def _value(leaf: Leaf) -> float:
    assert isinstance(leaf.label, float), "the label of a tree that is read alone is its number"
    return leaf.label


def _apply_link(link: str | None, objective: str, scores: Sequence[Any], where: str, *, alone: bool) -> Leaf:
    """Turns scores into a leaf: a class, or a number, which is a label where the tree stands `alone`."""
    if link == LARGEST:
        scores = [float(score) for score in scores]
        first, second = sorted(scores)[::-1][:2]  # which rounding must not turn
        if not first - second >= NEAR:
            what = f"two classes have scores too close to call, {first} and {second}"
            raise InputError(what, where, "train it again")
        return Leaf(scores.index(first))
    if link is None or len(scores) > 1:
        raise InputError(f"the objective is not understood: {escape_text(objective)}", where, ONE)
    score = float(scores[0])
    if link == SIGN:
        return Leaf(second_class(score, where))
    return Leaf(score) if alone else Leaf(0, ((score, CONSTANT),))


# --- LightGBM


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
        read = [_LightGbm(tree, link, where) for tree in fields]
        if len(read) > 1 and any(each.forms for each in read):
            raise InputError("several trees have linear leaves, whose sums are added to sums", where, ONE)
        add = partial(_add_lightgbm, link, int(model.get("num_tree_per_iteration", "1")), where)
        named = names if len(names) == width else ()
        said = Described(kind=LIGHTGBM, features=named, n_features=width, numbers=FLOAT64, given=DOUBLES)
        return {AGENT: origin_of_sum([Tree(each.root, each.read) for each in read], add, said, where)}
    except (LookupError, ValueError, OverflowError) as error:
        raise InputError(f"not LightGBM's text: {escape_text(error)[:100]}", where, AGAIN) from None


def _add_lightgbm(link: str, count: int, where: str, leaves: Sequence[Leaf]) -> Leaf:
    """Adds the leaves of a path: doubles, added to 0 in their order, for each of `count` classes."""
    if leaves[0].terms:
        return leaves[0]
    scores = [0.0] * count
    for place, leaf in enumerate(leaves):
        scores[place % count] += _value(leaf)
    return _apply_link(LINKS[LIGHTGBM].get(link), link, scores, where, alone=len(leaves) == 1)


def _fields(text: str) -> Mapping[str, str]:
    """The lines `name=value`."""
    return {name: value for name, _, value in (line.partition("=") for line in text.splitlines())}


def _linear(lists: Mapping[str, list[str]], count: int) -> tuple[Terms, ...]:
    """Reads the terms of linear leaves: a constant, then products in the order of the file, as LightGBM adds them."""
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


# --- treelite


def from_treelite(content: bytes, where: str) -> dict[str, Origin]:
    """The tree in treelite's JSON. InputError for forests, categories, and links that are not understood."""
    document = json_of(content, where)
    try:
        trees = document["trees"]
        if len(trees) != 1:
            raise InputError(f"the model has {len(trees)} trees, one is needed", where, "export one tree")
        nodes = {int(node["node_id"]): node for node in trees[0]["nodes"]}
        values = {str(node["leaf_value"]) for node in nodes.values() if "leaf_value" in node}
        giving = document["task_type"] == "kRegressor" and len(values) > MAX_VALUES  # which are too many for actions

        def read(place: int) -> Split | Leaf:
            node = nodes[place]
            if "leaf_value" in node:
                decision = _decision(document, node["leaf_value"], where)
                return Leaf(0, ((float(decision), CONSTANT),)) if giving else Leaf(decision)
            if node["node_type"] != "numerical_test_node":
                what = f"a node is not understood: {escape_text(node['node_type'])}"
                raise InputError(what, where, "export a numerical tree")
            then, otherwise = int(node["left_child"]), int(node["right_child"])
            number, sign = float(node["threshold"]), str(node["comparison_op"])
            return Split(int(node["split_feature_id"]), sign, number, then, otherwise, nan=bool(node["default_left"]))

        numbers = str(document.get("threshold_type", FLOAT32))
        if numbers not in NUMBERS:
            raise InputError(f"the type of thresholds is not understood: {escape_text(numbers)}", where, AGAIN)
        given, width = f"{numbers}, the type of its thresholds", int(document["num_feature"])
        said = Described(kind=TREELITE, n_features=width, numbers=numbers, given=given)
        return {AGENT: origin_of(0, read, said, where)}
    except (LookupError, TypeError, AttributeError, ValueError, OverflowError) as error:
        raise InputError(f"not treelite's JSON: {escape_text(error)[:100]}", where, AGAIN) from None


def _decision(document: Mapping[str, Any], value: Any, where: str) -> int | float:
    """The class that a leaf stands for, or its number."""
    task, link = document["task_type"], document["postprocessor"]
    base = [float(each) for each in document["base_scores"]]
    if document["num_target"] != 1:
        raise InputError(f"the model has {document['num_target']} targets, one is needed", where, "one tree per agent")
    if task == "kMultiClf" and link in CLASSES and isinstance(value, list) and len(set(base)) == 1:
        scores = [float(each) for each in cast(Sequence[Any], value)]
        if not all(map(math.isfinite, scores)):
            raise InputError(f"a leaf's scores are {scores[:10]}", where, AGAIN)
        return scores.index(max(scores))
    if task == "kBinaryClf" and link == "sigmoid" and not isinstance(value, list):
        return second_class(float(value) + base[0], where)
    if task == "kRegressor" and link == "identity" and not any(base) and not isinstance(value, list):
        return float(value)
    what = f"the link is not understood: {escape_text(task)}, {escape_text(link)}"
    raise InputError(what, where, "export a classifier of one tree")
