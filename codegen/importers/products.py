"""Sums of a few trees as one tree: each path goes through the trees in turn.

Does: follows the trees as a program, so that tests which earlier tests on the path decide are left out; hands the
  leaves of a path to whoever adds them.
Assumes: readers of the single trees, as for nodes.py.
Does not: add anything itself, or take trees whose product is large.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from codegen.errors import InputError
from codegen.importers.nodes import Leaf, Split, ask, ensure_test, value_of
from codegen.importers.reading import Origin
from codegen.importers.symbolic.paths import Paths
from codegen.importers.symbolic.program import Described, origin_of

MAX_LEAVES = 4_096  # of the one tree: with more it is no longer looked at, and compilers take minutes


class Tree(NamedTuple):
    """One of the trees: its root, and what reads its nodes."""

    root: Any
    read: Callable[[Any], Split | Leaf]


def origin_of_sum(trees: Sequence[Tree], add: Callable[[Sequence[Leaf]], Leaf], said: Described, where: str) -> Origin:
    """The one tree. `add`: what the leaves of a path stand for together. InputError where several trees have more than
    MAX_LEAVES leaves, and as for a tree alone.
    """
    n_leaves = 0

    def run(paths: Paths, state: Any) -> Any:
        nonlocal n_leaves
        n_leaves = n_leaves + 1 if state else 1
        if n_leaves > MAX_LEAVES and len(trees) > 1:
            what = f"{len(trees)} trees together have more than {MAX_LEAVES:,} leaves"
            raise InputError(what, where, "train fewer or smaller trees (n_estimators, max_depth, num_leaves)")
        leaves, node = state or ((), trees[0].root)
        passed = set[tuple[int, Any]]()
        while True:
            each = trees[len(leaves)].read(node)
            if isinstance(each, Split):
                ensure_test(each, said.n_features, where)
                if (len(leaves), node) in passed:
                    raise InputError("a node leads back to itself", where, "simplify it first; nodes must form a tree")
                passed.add((len(leaves), node))
                paths.mark((leaves, node))
                node = ask(paths, each)
                continue
            leaves = (*leaves, each)
            if len(leaves) == len(trees):
                return value_of(add(leaves), where)
            node = trees[len(leaves)].root

    origin = origin_of(run, where, lambda: replace(said, places=range(said.n_features)), said.numbers)
    return replace(origin, finite=bool(origin.vectors))
