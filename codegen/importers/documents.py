"""Trees in the JSON of dtControl and of treelite.

Does: reads dtControl's `default.json` and treelite's `dump_as_json`, one tree each.
Assumes: the formats of dtControl 2.1 and treelite 4.
Does not: take sums of features, categories, forests, or leaves that permit several actions.

dtControl compares doubles, treelite what its models say. dtControl writes numbers as labels with six digits; these
texts are the labels here.
"""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, cast

from codegen.errors import InputError, shown
from codegen.floats import FLOAT32, FLOAT64, NUMBERS
from codegen.importers.nodes import Leaf, Split, json_of, origin_of
from codegen.importers.origin import AGENT, DOUBLES, Origin
from codegen.wording import counted

DTCONTROL, TREELITE = "dtControl", "treelite"
AGAIN = "write the file again"
CLASSES = ("identity_multiclass", "softmax", "max_index")  # none changes which score is the largest
NEAR = 1e-5  # scores this close to the border may be rounded across it


def from_dtcontrol(content: bytes, where: str) -> dict[str, Origin]:
    """The tree in dtControl's JSON. InputError for what is no such tree with one action a leaf."""
    document = json_of(content, where)
    names = _Names()

    def read(node: Mapping[str, Any]) -> Split | Leaf:
        try:
            return _leaf(node, where) if node["split"] is None else _split(node, names, where)
        except (LookupError, TypeError, AttributeError, ValueError, OverflowError) as error:
            raise InputError(f"a node is not understood: {shown(error)[:100]}", where, AGAIN) from None

    try:
        origin = origin_of(DTCONTROL, document, read, names.given, 0, where)
        return {AGENT: replace(origin, numbers=FLOAT64, given=DOUBLES, keyed=bool(names.given))}
    except RecursionError:
        raise InputError("the file is nested too deeply", where, "simplify it first") from None


def _leaf(node: Mapping[str, Any], where: str) -> Leaf:
    labels = cast(list[object], node["actual_label"] or [])
    if len(labels) != 1 or not isinstance(labels[0], str):
        what = f"a leaf permits {counted(len(labels), 'action')}"
        raise InputError(what, where, "let dtControl determinise it: one action a leaf")
    return Leaf(labels[0])


@dataclass
class _Names:
    """The names of features in dtControl's JSON, or their numbers, which it also writes as x_0, x_1 and so on."""

    given: list[str] = field(default_factory=list[str])
    numbered: bool = False

    def place(self, var: object) -> int:
        """The place of a feature."""
        number = re.fullmatch(r"x_(\d{1,9})", var) if isinstance(var, str) else None
        if isinstance(var, str) and number is None and var not in self.given:
            self.given.append(var)
        self.numbered |= not isinstance(var, str) or number is not None
        if self.numbered and self.given:
            raise ValueError("features have names and numbers")
        return int(number[1]) if number else self.given.index(var) if isinstance(var, str) else int(cast(Any, var))


def _split(node: Mapping[str, Any], names: _Names, where: str) -> Split:
    split, children = node["split"], cast(list[Any], node["children"])
    side = split["lhs"]
    if split["op"] != "<=" or not isinstance(side, Mapping) or float(cast(Any, side["coeff"])) != 1.0:
        what = "a split is not of one feature: a sum, or categories"
        raise InputError(what, where, "use axis-aligned splits, or make the sum a feature of its own")
    by_edge = {child["edge_label"]: child for child in children}
    if len(children) != len(by_edge):
        raise InputError("two children have the same edge", where, AGAIN)
    then, otherwise = by_edge["true"], by_edge["false"]
    return Split(names.place(cast(object, side["var"])), "<=", float(split["rhs"]), then, otherwise, nan=False)


def from_treelite(content: bytes, where: str) -> dict[str, Origin]:
    """The tree in treelite's JSON. InputError for forests, categories, and links that are not understood."""
    document = json_of(content, where)
    try:
        trees = document["trees"]
        if len(trees) != 1:
            raise InputError(f"the model has {len(trees)} trees, one is needed", where, "export one tree")
        nodes = {int(node["node_id"]): node for node in trees[0]["nodes"]}
        width = int(document["num_feature"])

        def read(place: int) -> Split | Leaf:
            return _treelite(document, nodes[place], where)

        numbers = str(document.get("threshold_type", FLOAT32))
        if numbers not in NUMBERS:
            raise InputError(f"the type of thresholds is not understood: {shown(numbers)}", where, AGAIN)
        origin = origin_of(TREELITE, 0, read, (), width, where)
        return {AGENT: replace(origin, numbers=numbers, given=f"{numbers}, the type of its thresholds")}
    except (LookupError, TypeError, AttributeError, ValueError, OverflowError) as error:
        raise InputError(f"not treelite's JSON: {shown(error)[:100]}", where, AGAIN) from None


def _treelite(document: Mapping[str, Any], node: Mapping[str, Any], where: str) -> Split | Leaf:
    if "leaf_value" in node:
        return Leaf(_decision(document, node["leaf_value"], where))
    if node["node_type"] != "numerical_test_node":
        raise InputError(f"a node is not understood: {shown(node['node_type'])}", where, "export a numerical tree")
    then, otherwise = int(node["left_child"]), int(node["right_child"])
    number, sign = float(node["threshold"]), str(node["comparison_op"])
    return Split(int(node["split_feature_id"]), sign, number, then, otherwise, nan=bool(node["default_left"]))


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
    what = f"the link is not understood: {shown(task)}, {shown(link)}"
    raise InputError(what, where, "export a classifier of one tree")


def second_class(score: float, where: str) -> int:
    """1 for a score above 0, else 0. InputError for one so near to 0 that its probability is rounded to 1/2."""
    if not abs(score) >= NEAR:  # or no number at all
        raise InputError(f"a leaf's score, {score}, is too close to call", where, "train the tree again")
    return int(score > 0)
