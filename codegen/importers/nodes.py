"""Trees that a file holds as data: nodes that refer to nodes, as one sound tree, and as they decide by themselves.

Does: puts nodes into an order, with limits for circles and for what is shared; asks what nodes ask, for the replay.
Assumes: a reader says what each node tests, and by which comparison.
Does not: read a format (documents.py, boosted.py).

The replay compares as the format says, `x < c` or another test, where the tree has `x <= t`. It is a second reading of
the file; the library that wrote the file is asked in the tests.
"""

import json
from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple, TypeVar, cast

import numpy as np

from codegen.errors import InputError, escape_text
from codegen.floats import FLOAT64
from codegen.importers.reading import MAX_FEATURES, SUMS, Origin
from codegen.importers.symbolic.affine import Affine, Given, Sums, Terms
from codegen.importers.symbolic.feature import Feature, Test, at_most, below
from codegen.importers.symbolic.paths import Paths
from codegen.importers.symbolic.program import Described, Value, origin_of_tree
from codegen.ir import MAX_DEPTH, MAX_NODES, GrownTree
from codegen.paths import in_preorder

OPPOSITE = {"<=": ">", "<": ">=", ">": "<=", ">=": "<"}
Node = TypeVar("Node")


class Split(NamedTuple):
    """A test: where it holds, observations go to the node `then`."""

    feature: int
    sign: str  # one of OPPOSITE
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


def origin_of(
    root: Node, read: Callable[[Node], Split | Leaf], said: Described, where: str, sums: Sums | None = None
) -> Origin:
    """The tree below `root`, node by node as the file has it. `sums`: what tests name as feature SUMS + k, which a
    reader may make as it goes.

    Labels that are numbers are actions in ascending order, texts in the order of the leaves. InputError for circles,
    too many or too deep nodes, thresholds that are no numbers, and features that there are not.
    """
    nodes, values = list[Split | Leaf](), dict[Any, int]()

    def parts(given: tuple[Node, int]) -> int | tuple[int, float, tuple[Node, int], tuple[Node, int]]:
        node, depth = given
        if len(nodes) == MAX_NODES or depth > MAX_DEPTH:
            what = f"the tree has more than {MAX_NODES} nodes, or is deeper than {MAX_DEPTH} splits"
            raise InputError(what, where, "simplify it first; nodes must form a tree")
        nodes.append(each := read(node))
        if isinstance(each, Leaf):
            return values.setdefault(value_of(each, where), len(values))
        ensure_test(each, said.n_features, where, sums)
        threshold = at_most(each.number) if each.sign in ("<=", ">") else below(each.number)
        then, otherwise = (each.then, depth + 1), (each.otherwise, depth + 1)
        return each.feature, threshold, *((otherwise, then) if each.sign in (">", ">=") else (then, otherwise))

    def run(paths: Paths, state: Any) -> Any:
        node = root if state is None else state[0]
        while isinstance(each := read(node), Split):
            paths.mark((node,))
            node = ask(paths, each)
        return value_of(each, where)

    tree = in_preorder((root, 0), parts, FLOAT64)
    grown = GrownTree(tree.feature, tree.threshold.astype(np.float64), tree.left, tree.right, tree.action)
    splits = [each for each in nodes if isinstance(each, Split)]
    inputs = [each.feature for each in splits if each.feature < SUMS]
    inputs += [place for form in (sums.known if sums else ()) for _, place in form.terms]
    # a NaN, which goes right, goes where the file sends it: left is where x <= t
    nan = all(each.nan == (each.sign in (">", ">=")) for each in splits)
    said = replace(said, nan=nan, places=range(max([said.n_features, *(place + 1 for place in inputs)])))
    origin = origin_of_tree(grown, list(values), run, said, where, sums)
    permits = tuple(each.permits for each in nodes if isinstance(each, Leaf))
    return replace(origin, permits=permits, finite=bool(origin.vectors))


def ensure_test(split: Split, n_features: int, where: str, sums: Sums | None = None) -> None:
    """InputError for a comparison with what is no finite number, and for features that there are not."""
    known = 0 <= split.feature < MAX_FEATURES or SUMS <= split.feature < SUMS + len(sums.known if sums else ())
    if not known or not np.isfinite(split.number) or split.sign not in OPPOSITE:
        what = f"a test is not understood: feature {split.feature} {escape_text(split.sign)} {split.number}"
        raise InputError(what, where, "features are compared with finite numbers")
    if n_features and n_features <= split.feature < SUMS:
        what = f"the tree tests feature {split.feature}, there are {n_features}"
        raise InputError(what, where, "write the file again")


def ask(paths: Paths, split: Split) -> Any:
    """The node that follows. A NaN passes no comparison: where it goes to `then`, the opposite is asked."""
    paths.step()
    test = Test(Feature(split.feature), OPPOSITE[split.sign] if split.nan else split.sign, split.number)
    return split.then if paths.holds(test) != split.nan else split.otherwise


def value_of(leaf: Leaf, where: str) -> Any:
    """What a leaf returns: its label, or the number that it gives. InputError for a label that is no finite number."""
    if isinstance(leaf.label, float) and not np.isfinite(leaf.label):
        raise InputError(f"a leaf's number is {leaf.label}", where, "train the tree again")
    return Given([Affine(leaf.terms)]) if leaf.terms else leaf.label
