"""Trees that a file holds as data: nodes that refer to nodes, as one sound tree, and as they decide by themselves.

Does: puts nodes into an order, with limits for circles and for what is shared; follows them for many observations.
Assumes: a reader says what each node tests, and by which comparison.
Does not: read a format (documents.py, boosted.py).

The replay compares as the format says, `x < c` or another test, where the tree has `x <= t`. It is a second reading of
the file; the library that wrote the file is asked in the tests.
"""

import json
import operator
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple, TypeVar, cast

import numpy as np

from codegen.errors import InputError, escape_text
from codegen.floats import FLOAT64
from codegen.importers.reading import SUMS, Origin
from codegen.importers.summed import with_sums
from codegen.importers.symbolic.affine import Terms, sum_terms
from codegen.importers.symbolic.labels import Value
from codegen.importers.symbolic.line import at_most, below
from codegen.ir import MAX_DEPTH, MAX_NODES, NO_ACTION, NO_CHILD, NO_FEATURE, ROOT, Floats, GrownTree, Int32

REPLAYED_BY = "a second reading of the file"
MAX_FEATURES = 1 << 20
SIGNS: dict[str, Callable[[Any, Any], Any]] = {
    "<=": operator.le, "<": operator.lt, ">": operator.gt, ">=": operator.ge,
}  # fmt: skip
Node = TypeVar("Node")


class Split(NamedTuple):
    """A test: where it holds, observations go to the node `then`."""

    feature: int
    sign: str  # one of SIGNS
    number: float
    then: Any
    otherwise: Any
    nan: bool  # whether a NaN goes to `then`


class Leaf(NamedTuple):
    """An end."""

    label: Value
    terms: Terms = ()  # of the number that it gives, in place of a label
    permits: tuple[str, ...] = ()  # the labels that it permits, of which `label` was chosen


def json_of(content: bytes, where: str) -> dict[str, Any]:
    """A JSON object. InputError for everything else."""
    try:
        document: object = json.loads(content)
    except (ValueError, RecursionError) as error:
        raise InputError(f"not JSON: {escape_text(error)[:200]}", where, "write the file again") from None
    if not isinstance(document, dict):
        raise InputError("not a JSON object", where, "write the file again")
    return cast(dict[str, Any], document)


class Source(NamedTuple):
    """What kind of file is read, where it is, and the sums in it: the numbers that they are computed in, and those that
    tests name as feature SUMS + k, which a reader may make as it goes.
    """

    kind: str
    where: str
    numbers: str = FLOAT64
    sums: Sequence[Terms] = ()


def origin_of(
    source: Source,
    root: Node,
    read: Callable[[Node], Split | Leaf],
    features: Sequence[str],
    n_features: int,
) -> Origin:
    """The tree below `root`. `features`: names, or none; `n_features`: 0 where the file does not say.

    Labels that are numbers are actions in ascending order, texts in the order of the leaves. InputError for circles,
    too many or too deep nodes, thresholds that are no numbers, and features that there are not.
    """
    kind, where, numbers, sums = source
    nodes, leaves = _order_nodes(root, read, sums, where)
    values = list(dict.fromkeys(leaf.label for leaf in leaves))
    # all of one kind, which the annotation cannot say
    given = list(dict.fromkeys(leaf.terms for leaf in leaves)) if all(leaf.terms for leaf in leaves) else []
    if given:
        return _giving(source, root, read, nodes, given, (features, n_features))
    labels: list[Any] = values if isinstance(values[0], str) else sorted(values)  # pyright: ignore
    place = {label: index for index, label in enumerate(labels)}
    rows = [[NO_FEATURE, 0.0, *each, place[leaf.label]] if isinstance(leaf, Leaf) else each for each, leaf in nodes]
    grown = GrownTree(*np.array(rows, dtype=np.float64).T)
    single = grown.feature[grown.feature < SUMS]
    if n_features and int(single.max(initial=NO_FEATURE)) >= n_features:
        what = f"the tree tests feature {int(single.max())}, there are {n_features}"
        raise InputError(what, where, "write the file again")
    kept = all(_keeps(node) for _, node in nodes if isinstance(node, Split))

    def act(rows: Floats) -> Int32:
        return np.array([place[leaf.label] for leaf in _ends(root, read, rows, sums)], dtype=np.int32)

    permits = tuple(leaf.permits for leaf in leaves)
    origin = Origin(kind, grown, tuple(labels), act, REPLAYED_BY, tuple(features), n_features, kept, permits=permits)
    if not sums:
        return origin
    width = 1 + max(place for terms in sums for _, place in terms)
    return with_sums(replace(origin, numbers=numbers), sums, (), range(max(n_features, width)))


def _giving(
    source: Source,
    root: Node,
    read: Callable[[Node], Split | Leaf],
    nodes: Sequence[tuple[list[float], Split | Leaf]],
    given: Sequence[Terms],
    named: tuple[Sequence[str], int],
) -> Origin:
    """The origin of a tree whose leaves give sums, in these numbers."""
    place = {terms: index for index, terms in enumerate(given)}
    rows = [[NO_FEATURE, 0.0, *each, place[leaf.terms]] if isinstance(leaf, Leaf) else each for each, leaf in nodes]

    def act(rows: Floats) -> Any:
        columns, ends = list(rows.astype(np.float64).T), _ends(root, read, rows, ())
        outputs = np.zeros((len(rows), 1))
        for terms in {leaf.terms for leaf in ends}:
            here = np.array([leaf.terms == terms for leaf in ends])
            outputs[here, 0] = sum_terms(terms, [column[here] for column in columns], source.numbers)
        return outputs

    grown = GrownTree(*np.array(rows, dtype=np.float64).T)
    width = named[1]
    names, numbers = tuple(named[0]), source.numbers
    origin = Origin(source.kind, grown, (), act, REPLAYED_BY, names, width, finite=True, numbers=numbers)
    return with_sums(origin, (), [[terms] for terms in given], range(width))


def _keeps(split: Split) -> bool:
    """Whether a NaN, which goes right, goes where the file sends it: left is where x <= t."""
    return split.nan == (split.sign in (">", ">="))


def _order_nodes(
    root: Node, read: Callable[[Node], Split | Leaf], sums: Sequence[Terms], where: str
) -> tuple[list[tuple[list[float], Split | Leaf]], list[Leaf]]:
    """The nodes in preorder, each as a row of a grown tree and as it was read; and the leaves."""
    nodes: list[tuple[list[float], Split | Leaf]] = []
    leaves: list[Leaf] = []
    open_: list[tuple[Node, int, int, int]] = [(root, NO_CHILD, 0, 0)]
    while open_:
        node, parent, column, depth = open_.pop()
        if len(nodes) == MAX_NODES or depth > MAX_DEPTH:
            what = f"the tree has more than {MAX_NODES} nodes, or is deeper than {MAX_DEPTH} splits"
            raise InputError(what, where, "simplify it first; nodes must form a tree")
        if parent != NO_CHILD:
            nodes[parent][0][column] = len(nodes)
        each = read(node)
        if isinstance(each, Leaf):
            if isinstance(each.label, float) and not np.isfinite(each.label):
                raise InputError(f"a leaf's number is {each.label}", where, "train the tree again")
            leaves.append(each)
            nodes.append(([NO_CHILD, NO_CHILD], each))
            continue
        known = 0 <= each.feature < MAX_FEATURES or SUMS <= each.feature < SUMS + len(sums)
        if not known or not np.isfinite(each.number) or each.sign not in SIGNS:
            what = f"a test is not understood: feature {each.feature} {escape_text(each.sign)} {each.number}"
            raise InputError(what, where, "features are compared with finite numbers")
        turned = each.sign in (">", ">=")
        threshold = at_most(each.number) if each.sign in ("<=", ">") else below(each.number)
        sides = (each.otherwise, each.then) if turned else (each.then, each.otherwise)
        place = len(nodes)
        nodes.append(([each.feature, threshold, NO_CHILD, NO_CHILD, NO_ACTION], each))
        open_ += [(sides[1], place, 3, depth + 1), (sides[0], place, 2, depth + 1)]
    return nodes, leaves


def _ends(root: Node, read: Callable[[Node], Split | Leaf], rows: Floats, sums: Sequence[Terms]) -> list[Leaf]:
    """The leaf of each observation, by the file's own comparisons."""
    doubles = rows.astype(np.float64)
    columns = {SUMS + place: sum_terms(terms, list(doubles.T), FLOAT64) for place, terms in enumerate(sums)}
    leaves: list[Leaf] = [Leaf(ROOT)] * len(rows)
    open_: list[tuple[Node, np.ndarray]] = [(root, np.arange(len(rows)))]
    while open_:
        node, reached = open_.pop()
        each = read(node)
        if isinstance(each, Leaf):
            for place in reached.tolist():
                leaves[place] = each
        elif len(reached):
            x = columns[each.feature][reached] if each.feature in columns else doubles[reached, each.feature]
            holds = np.where(np.isnan(x), each.nan, SIGNS[each.sign](x, each.number))
            open_ += [(each.then, reached[holds]), (each.otherwise, reached[~holds])]
    return leaves
