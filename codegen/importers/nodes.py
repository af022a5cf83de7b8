"""Trees that a file holds as data, one or the sum of a few: as one sound tree, and as they decide by themselves.

Does: puts nodes that refer to nodes into an order, with limits for circles and for what is shared; follows the trees of
  a sum in turn, and hands the leaves of a path to whoever adds them; asks the nodes themselves, for the replay.
  Reads dtControl's `default.json`, one tree of axis-aligned and linear tests, as the format of dtControl 2.1 has it.
Assumes: a reader says what each node tests, and by which comparison.
Does not: read other formats (boosted.py), add anything itself, or take trees whose product is large. Of dtControl it
  takes no categories, and no leaf that permits several actions without being told which.

The replay compares as the format says, `x < c` or another test, where the tree has `x <= t`. It is a second reading of
the file; the library that wrote the file is asked in the tests.
"""

import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple, TypeVar, cast

import numpy as np

from codegen.errors import InputError, escape_text
from codegen.floats import FLOAT64
from codegen.importers.reading import AGENT, DOUBLES, MAX_FEATURES, NOTHING, SUMS, Origin, Said
from codegen.importers.symbolic.feature import SIGNS, Affine, Given, Sums, Terms, at_most, below, sum_terms
from codegen.importers.symbolic.paths import Described, Value, origin_of_tree, without_alike
from codegen.ir import MAX_DEPTH, MAX_NODES, Floats, GrownTree
from codegen.paths import EVERYTHING, Box, in_preorder
from codegen.wording import format_count

MAX_LEAVES = 4_096  # of a sum as one tree: with more it is no longer looked at, and compilers take minutes
UPWARDS = (">", ">=")  # comparisons that hold on the right side of a threshold, where a NaN goes, too
Node = TypeVar("Node")


class Split(NamedTuple):
    """A test: where it holds, observations go to the node `then`."""

    feature: int
    sign: str  # <, <=, > or >=
    number: float
    then: Any
    otherwise: Any
    nan: bool  # whether a NaN goes to `then`


class Leaf(NamedTuple):
    """An end."""

    label: Value
    terms: Terms = ()  # of the number that it gives, in place of a label
    permits: tuple[str, ...] = ()  # the labels that it permits, of which `label` was chosen


class Tree(NamedTuple):
    """One tree: its root, and what reads its nodes."""

    root: Any
    read: Callable[[Any], Split | Leaf]


class _Place(NamedTuple):
    """The point that a path has reached."""

    leaves: tuple[Leaf, ...]  # of the trees that it is through with
    node: Any  # of the next one
    box: Box = EVERYTHING  # the observations that come here, where tests that are decided are left out
    visited: int = 0  # nodes


def json_of(content: bytes, where: str) -> dict[str, Any]:
    """A JSON object. InputError for everything else."""
    try:
        document: object = json.loads(content)
    except (ValueError, RecursionError) as error:
        raise InputError(f"not JSON: {escape_text(error)[:200]}", where, "write the file again") from None
    if not isinstance(document, dict):
        raise InputError("not a JSON object", where, "write the file again")
    return cast(dict[str, Any], document)


def origin_of(
    root: Node, read: Callable[[Node], Split | Leaf], said: Described, where: str, sums: Sums | None = None
) -> Origin:
    """The tree below `root`, node by node as the file has it. `sums`: what tests name as feature SUMS + k, which a
    reader may make as it goes.

    Labels that are numbers are actions in ascending order, texts in the order of the leaves. InputError for circles,
    too many or too deep nodes, thresholds that are no numbers, and features that there are not.
    """
    grown = _Grown([Tree(root, read)], lambda leaves: leaves[0], said, where, sums)
    tree = grown.grow()
    inputs = [each.feature for each in grown.splits if each.feature < SUMS]
    inputs += [place for form in (sums.known if sums else ()) for place in form.places]
    width = max([said.n_features, *(place + 1 for place in inputs)])
    permits = tuple(leaf.permits for (leaf,) in grown.ends)
    return replace(grown.make_origin(tree, width), permits=permits)


def origin_of_sum(trees: Sequence[Tree], add: Callable[[Sequence[Leaf]], Leaf], said: Described, where: str) -> Origin:
    """The sum of trees as one tree, without tests that earlier ones decide. `add`: what the leaves of a path stand for
    together. InputError where several trees have more than MAX_LEAVES leaves, and as for a tree alone.
    """
    grown = _Grown(trees, add, said, where, decided=True)
    return grown.make_origin(without_alike(grown.grow()), said.n_features)


@dataclass
class _Grown:
    """One tree of all, whose actions count in `values`."""

    trees: Sequence[Tree]
    add: Callable[[Sequence[Leaf]], Leaf]
    said: Described
    where: str
    sums: Sums | None = None
    decided: bool = False  # whether tests that earlier ones decide are left out
    values: dict[Any, int] = field(default_factory=dict[Any, int])
    splits: list[Split] = field(default_factory=list[Split])
    ends: list[tuple[Leaf, ...]] = field(default_factory=list[tuple[Leaf, ...]])
    nan: bool = True  # whether a NaN, which goes right, goes where the file sends it

    def grow(self) -> GrownTree:
        """The tree, in preorder."""
        tree = in_preorder(_Place((), self.trees[0].root), self._read_parts, FLOAT64)
        return GrownTree(tree.feature, tree.threshold.astype(np.float64), tree.left, tree.right, tree.action)

    def _read_parts(self, at: _Place) -> int | tuple[int, float, _Place, _Place]:
        """A leaf's value, or a split with the places to the left and to the right."""
        leaves, node, box, visited = at
        while True:
            visited += 1
            if len(self.ends) == MAX_LEAVES and len(self.trees) > 1:
                what = f"{len(self.trees)} trees together have more than {MAX_LEAVES:,} leaves"
                advice = "train fewer or smaller trees (n_estimators, max_depth, num_leaves)"
                raise InputError(what, self.where, advice)
            if visited > (1 + MAX_DEPTH) * len(self.trees) or len(self.splits) + len(self.ends) == MAX_NODES:
                what = f"the tree has more than {MAX_NODES} nodes, or is deeper than {MAX_DEPTH} splits"
                what += ", or a node leads back to itself"
                raise InputError(what, self.where, "simplify it first; nodes must form a tree")
            each = self.trees[len(leaves)].read(node)
            if isinstance(each, Leaf):
                leaves = (*leaves, each)
                if len(leaves) == len(self.trees):
                    self.ends.append(leaves)
                    return self.values.setdefault(value_of(self.add(leaves), self.where), len(self.values))
                node = self.trees[len(leaves)].root
                continue
            sums = SUMS + len(self.sums.known if self.sums else ())
            known = 0 <= each.feature < MAX_FEATURES or SUMS <= each.feature < sums
            if not known or not np.isfinite(each.number) or each.sign not in ("<", "<=", *UPWARDS):
                what = f"a test is not understood: feature {each.feature} {escape_text(each.sign)} {each.number}"
                raise InputError(what, self.where, "features are compared with finite numbers")
            if self.said.n_features and self.said.n_features <= each.feature < SUMS:
                what = f"the tree tests feature {each.feature}, there are {self.said.n_features}"
                raise InputError(what, self.where, "write the file again")
            threshold = at_most(each.number) if each.sign in ("<=", ">") else below(each.number)
            sides = (each.otherwise, each.then) if each.sign in UPWARDS else (each.then, each.otherwise)
            if each.feature not in box.high:  # else no NaN comes here
                self.nan &= each.nan == (each.sign in UPWARDS)
            left, right = box.split_at(each.feature, threshold) if self.decided else (box, box)
            if left is not None and right is not None:
                self.splits.append(each)
                low, high = _Place(leaves, sides[0], left, visited), _Place(leaves, sides[1], right, visited)
                return each.feature, threshold, low, high
            node = sides[0] if right is None else sides[1]

    def make_origin(self, tree: GrownTree, width: int) -> Origin:
        """The origin of a tree over so many features, which the nodes themselves answer for."""
        said = replace(self.said, nan=self.nan, places=range(width))
        origin = origin_of_tree(tree, list(self.values), said, self.where, self.sums)
        place = {label: at for at, label in enumerate(origin.labels)}
        numbers = self.sums.numbers if self.sums else said.numbers

        def act(rows: Floats) -> Any:
            columns = dict(enumerate(rows.T.astype(np.float64)))
            ends, end_of = self._follow_rows(columns, len(rows))
            if not origin.vectors:
                return np.array([place.get(end, -1) for end in ends], np.int32)[end_of]
            given = np.zeros((len(rows), len(origin.vectors[0])))
            starts = np.cumsum(np.bincount(end_of, minlength=len(ends)))[:-1]
            for end, there in zip(ends, np.split(np.argsort(end_of, kind="stable"), starts), strict=True):
                here = [columns[place][there] for place in range(rows.shape[1])]
                for output, form in enumerate(end.vector):
                    given[there, output] = sum_terms(form.terms, here, numbers)
            return given

        return replace(origin, act=act, finite=bool(origin.vectors))

    def _follow_rows(self, columns: dict[int, Floats], count: int) -> tuple[list[Any], Any]:
        """Returns the values of observations by the nodes' own comparisons, and each observation's place among them."""
        sums = self.sums or Sums(FLOAT64)
        for place in range(SUMS, SUMS + len(sums.known)):
            columns[place] = sums.column(place, columns)
        leaves, which = list[Leaf](), np.zeros((count, len(self.trees)), np.int32)
        for k, tree in enumerate(self.trees):
            for leaf, rows in _leaves_of(tree, columns, np.arange(count)):
                which[rows, k] = len(leaves)
                leaves.append(leaf)
        paths, path_of = np.unique(which, axis=0, return_inverse=True)
        listed: list[list[int]] = paths.tolist()
        ends = [value_of(self.add([leaves[k] for k in path]), self.where) for path in listed]
        return ends, path_of.ravel()


def _leaves_of(tree: Tree, columns: Mapping[int, Floats], rows: Any) -> Iterator[tuple[Leaf, Any]]:
    """Each leaf that some rows come to, and these."""
    open_ = [(tree.root, rows)]
    while open_:
        node, rows = open_.pop()
        if not len(rows):
            continue
        each = tree.read(node)
        if isinstance(each, Leaf):
            yield each, rows
            continue
        given = columns[each.feature][rows]
        holds = SIGNS[each.sign](given, each.number) | (np.isnan(given) & each.nan)
        open_ += [(each.then, rows[holds]), (each.otherwise, rows[~holds])]


def value_of(leaf: Leaf, where: str) -> Any:
    """Returns a leaf's label, or the number that it gives. InputError for a label that is no finite number."""
    if isinstance(leaf.label, float) and not np.isfinite(leaf.label):
        raise InputError(f"a leaf's number is {leaf.label}", where, "train the tree again")
    return Given([Affine(leaf.terms)]) if leaf.terms else leaf.label


# --- dtControl, which writes numbers as labels with six digits: these texts are the labels

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
    single = isinstance(side, Mapping) and float(cast("Mapping[str, Any]", side)["coeff"]) == 1.0
    if split["op"] != "<=" or not (listed or single):
        what = "a split is neither of one feature nor linear: categories, or another predicate"
        raise InputError(what, where, "use axis-aligned and linear splits")
    by_edge = {child["edge_label"]: child for child in children}
    if len(children) != len(by_edge):
        raise InputError("two children have the same edge", where, AGAIN)
    then, otherwise = by_edge["true"], by_edge["false"]
    if not listed:
        place = names.place(cast("Mapping[str, Any]", side)["var"])
        return Split(place, "<=", float(split["rhs"]), then, otherwise, nan=False)
    # the intercept comes last, and a rounded sum is at most 0 where the exact one is: products are at most its opposite
    *products, last = listed
    plain = float(split["rhs"]) == 0 and "intercept" in last and products
    if not plain or any("coeff" not in each for each in products):
        raise InputError("a linear predicate is not of products and an intercept, at most 0", where, AGAIN)
    terms = tuple((float(each["coeff"]), names.place(each["var"])) for each in products)
    if len({place for _, place in terms}) < len(terms) or any(weight == 0 for weight, _ in terms):
        raise InputError("a linear predicate names a feature twice, or with weight 0", where, AGAIN)
    limit = 0.0 - float(last["intercept"])
    if len(terms) == 1 and terms[0][0] == 1:
        return Split(Affine(terms).places[0], "<=", limit, then, otherwise, nan=False)
    return Split(sums.place(Affine(terms)), "<=", limit, then, otherwise, nan=False)
