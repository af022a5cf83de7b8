"""Trees that a file holds as data, one or the sum of a few: as one sound tree, and as they decide by themselves.

Does: puts nodes that refer to nodes into an order, with limits for circles and for what is shared; follows the trees of
  a sum in turn, and hands the leaves of a path to whoever adds them; asks the nodes themselves, for the replay.
Assumes: a reader says what each node tests, and by which comparison.
Does not: read a format (documents.py, boosted.py), add anything itself, or take trees whose product is large.

The replay compares as the format says, `x < c` or another test, where the tree has `x <= t`. It is a second reading of
the file; the library that wrote the file is asked in the tests.
"""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple, TypeVar, cast

import numpy as np

from codegen.errors import InputError, escape_text
from codegen.floats import FLOAT64
from codegen.importers.reading import MAX_FEATURES, SUMS, Origin
from codegen.importers.symbolic.affine import Affine, Given, Sums, Terms, sum_terms
from codegen.importers.symbolic.feature import SIGNS, at_most, below
from codegen.importers.symbolic.paths import without_alike
from codegen.importers.symbolic.program import Described, Value, origin_of_tree
from codegen.ir import MAX_DEPTH, MAX_NODES, Floats, GrownTree
from codegen.paths import EVERYTHING, Box, in_preorder

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
    inputs += [place for form in (sums.known if sums else ()) for _, place in form.terms]
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
            self._ensure_few(visited)
            each = self.trees[len(leaves)].read(node)
            if isinstance(each, Leaf):
                leaves = (*leaves, each)
                if len(leaves) == len(self.trees):
                    self.ends.append(leaves)
                    return self.values.setdefault(value_of(self.add(leaves), self.where), len(self.values))
                node = self.trees[len(leaves)].root
                continue
            _ensure_test(each, self.said.n_features, self.where, self.sums)
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

    def _ensure_few(self, visited: int) -> None:
        """InputError for a path through too many nodes, and for too many of them."""
        if len(self.ends) == MAX_LEAVES and len(self.trees) > 1:
            what = f"{len(self.trees)} trees together have more than {MAX_LEAVES:,} leaves"
            advice = "train fewer or smaller trees (n_estimators, max_depth, num_leaves)"
            raise InputError(what, self.where, advice)
        if visited > (1 + MAX_DEPTH) * len(self.trees) or len(self.splits) + len(self.ends) == MAX_NODES:
            what = f"the tree has more than {MAX_NODES} nodes, or is deeper than {MAX_DEPTH} splits"
            what += ", or a node leads back to itself"
            raise InputError(what, self.where, "simplify it first; nodes must form a tree")

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


def _ensure_test(split: Split, n_features: int, where: str, sums: Sums | None) -> None:
    """InputError for a comparison with what is no finite number, and for features that there are not."""
    known = 0 <= split.feature < MAX_FEATURES or SUMS <= split.feature < SUMS + len(sums.known if sums else ())
    if not known or not np.isfinite(split.number) or split.sign not in ("<", "<=", *UPWARDS):
        what = f"a test is not understood: feature {split.feature} {escape_text(split.sign)} {split.number}"
        raise InputError(what, where, "features are compared with finite numbers")
    if n_features and n_features <= split.feature < SUMS:
        what = f"the tree tests feature {split.feature}, there are {n_features}"
        raise InputError(what, where, "write the file again")


def value_of(leaf: Leaf, where: str) -> Any:
    """Returns a leaf's label, or the number that it gives. InputError for a label that is no finite number."""
    if isinstance(leaf.label, float) and not np.isfinite(leaf.label):
        raise InputError(f"a leaf's number is {leaf.label}", where, "train the tree again")
    return Given([Affine(leaf.terms)]) if leaf.terms else leaf.label
