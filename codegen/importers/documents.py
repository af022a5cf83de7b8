"""Trees in the JSON of dtControl.

Does: reads dtControl's `default.json`, one tree of axis-aligned and linear tests.
Assumes: the format of dtControl 2.1, which compares doubles.
Does not: take categories, or leaves that permit several actions without being told which.

dtControl writes numbers as labels with six digits; these texts are the labels here.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, cast

from codegen.errors import InputError, escape_text
from codegen.floats import FLOAT64
from codegen.importers.nodes import Leaf, Split, json_of, origin_of
from codegen.importers.origin import AGENT, DOUBLES, NOTHING, Origin, Said
from codegen.importers.symbolic.affine import Affine, Sums, Terms
from codegen.importers.symbolic.program import Described
from codegen.wording import format_count

DTCONTROL = "dtControl"
AGAIN = "write the file again"


def from_dtcontrol(content: bytes, where: str, said: Said = NOTHING) -> dict[str, Origin]:
    """The tree in dtControl's JSON; linear predicates are added from left to right, as dtControl's C adds them.

    InputError for what is no such tree, and for a leaf that permits several actions of which none is preferred.
    """
    document = json_of(content, where)
    names, sums = _Names(), Sums(FLOAT64)
    facts = Described(kind=DTCONTROL, features=names.given, numbers=FLOAT64, given=DOUBLES)

    def read(node: Mapping[str, Any]) -> Split | Leaf:
        try:
            return _leaf(node, said.prefer, where) if node["split"] is None else _split(node, names, sums, where)
        except (LookupError, TypeError, AttributeError, ValueError, OverflowError) as error:
            raise InputError(f"a node is not understood: {escape_text(error)[:100]}", where, AGAIN) from None

    try:
        return {AGENT: replace(origin_of(document, read, facts, where, sums), keyed=bool(names.given))}
    except RecursionError:
        raise InputError("the file is nested too deeply", where, "simplify it first") from None


def _leaf(node: Mapping[str, Any], prefer: Sequence[str], where: str) -> Leaf:
    labels = cast(list[object], node["actual_label"] or [])
    texts = tuple(each for each in labels if isinstance(each, str))
    if not texts or len(texts) < len(labels) or len({*texts}) < len(texts):
        raise InputError(f"a leaf permits {format_count(len(labels), 'action')}, not all by a name", where, AGAIN)
    if len(texts) == 1:
        return Leaf(texts[0])
    chosen = next((each for each in prefer if each in texts), None)
    if chosen is None:
        what = f"a leaf permits {format_count(len(texts), 'action')}: {escape_text(', '.join(texts))}"
        advice = "say which with --prefer, the most wanted first; or let dtControl determinise it"
        raise InputError(what, where, advice)
    return Leaf(chosen, permits=texts)


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


def _split(node: Mapping[str, Any], names: _Names, sums: Sums, where: str) -> Split:
    split, children = node["split"], cast(list[Any], node["children"])
    side: object = split["lhs"]
    listed = cast("list[Mapping[str, Any]]", side) if isinstance(side, list) else []
    if split["op"] != "<=" or not (listed or _single(split["lhs"])):
        what = "a split is neither of one feature nor linear: categories, or another predicate"
        raise InputError(what, where, "use axis-aligned and linear splits")
    by_edge = {child["edge_label"]: child for child in children}
    if len(children) != len(by_edge):
        raise InputError("two children have the same edge", where, AGAIN)
    then, otherwise = by_edge["true"], by_edge["false"]
    if not listed:
        place = names.place(cast("Mapping[str, Any]", side)["var"])
        return Split(place, "<=", float(split["rhs"]), then, otherwise, nan=False)
    terms, limit = _linear(listed, names, float(split["rhs"]), where)
    if len(terms) == 1 and terms[0][0] == 1:
        return Split(terms[0][1], "<=", limit, then, otherwise, nan=False)
    return Split(sums.place(Affine(terms)), "<=", limit, then, otherwise, nan=False)


def _single(side: object) -> bool:
    """Returns True if the left side of a test is a feature alone."""
    return isinstance(side, Mapping) and float(cast("Mapping[str, Any]", side)["coeff"]) == 1.0


def _linear(side: Sequence[Mapping[str, Any]], names: _Names, right: float, where: str) -> tuple[Terms, float]:
    """A linear predicate: its products, and the number that their sum is compared with. The intercept comes last, and
    a rounded sum is at most 0 where the exact one is: so products are at most its opposite.
    """
    *products, last = side
    if right != 0 or "intercept" not in last or not products or any("coeff" not in each for each in products):
        raise InputError("a linear predicate is not of products and an intercept, at most 0", where, AGAIN)
    terms = tuple((float(each["coeff"]), names.place(each["var"])) for each in products)
    if len({place for _, place in terms}) < len(terms) or any(weight == 0 for weight, _ in terms):
        raise InputError("a linear predicate names a feature twice, or with weight 0", where, AGAIN)
    return terms, 0.0 - float(last["intercept"])
