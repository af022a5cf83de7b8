"""Passes over trees, each optional, each proved not to change a decision.

Does: merges what decides alike, drops leaves that no state of a region reaches, reorders tests for fewer on average;
  proves two trees equal box by box.
Assumes: sound trees; that leaves are dead is given as data, by whoever can prove it.
Does not: read regions, know worlds, or touch the profile's other parts.
"""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TypeAlias

import numpy as np

from codegen.boxes import find_point
from codegen.errors import DisagreementError
from codegen.ir import NO_FEATURE, ROOT, Floats, Tree
from codegen.paths import EVERYTHING, Box, in_preorder

MERGE, DROP, REORDER = "merge", "drop", "reorder"
PASSES = (DROP, MERGE, REORDER)  # in the order in which they run: each leaves more for the next
MAX_REORDERED = 500  # splits; the work grows with their square


@dataclass(frozen=True)
class _Split:
    feature: int
    threshold: float  # of the tree's numbers
    left: "_Node"
    right: "_Node"
    size: int  # splits in it
    levels: int


_Node: TypeAlias = _Split | int  # a leaf is its action


def merge_splits(tree: Tree) -> Tree:
    """Without splits whose sides decide alike, and without tests that the tests before them decide."""
    return _prove_pass(MERGE, tree, _arrays(_within(_nest_tree(tree), EVERYTHING), tree.numbers))


def drop_leaves(tree: Tree, dead: Collection[int]) -> Tree:
    """Without the leaves `dead` (ids): decisions change only for observations that reach one of them."""
    remaining = _without(tree, ROOT, frozenset(dead))
    if remaining is None:
        raise ValueError("every leaf is dead: nothing can be observed")
    return _prove_pass(DROP, tree, _arrays(remaining, tree.numbers), dead)


def reorder_tests(tree: Tree, seen: Floats) -> Tree:
    """With fewer tests on average over `seen` [n, n_features]; never more splits, nor a longer longest path.

    From the root on, of all tests of a subtree the one comes first with which the subtree's tests are fewest; that
    which is first already is among them, so that no step makes it worse. Trees beyond MAX_REORDERED splits stay.
    """
    nested = _nest_tree(tree)
    if isinstance(nested, int) or nested.size > MAX_REORDERED:
        return tree
    tests = sorted(set(_tests(nested)))
    number = tree.threshold.dtype.type
    signs = np.column_stack([seen[:, feature] <= number(threshold) for feature, threshold in tests])
    patterns, counts = np.unique(signs, axis=0, return_counts=True)
    column = {test: place for place, test in enumerate(tests)}
    improved = _better(nested, EVERYTHING, np.arange(len(patterns)), _Seen(patterns, counts, column), nested.levels)
    return _prove_pass(REORDER, tree, _arrays(improved, tree.numbers))


def confine_tree(tree: Tree, low: float, high: float) -> Tree:
    """What decides observations whose numbers are all from `low` to `high`: the other tests are left out."""
    tested = {*tree.feature[tree.feature != NO_FEATURE].tolist()}
    box = Box(dict.fromkeys(tested, low - 1), dict.fromkeys(tested, high))
    return _arrays(_within(_nest_tree(tree), box), tree.numbers)


def graft_parts(tree: Tree, parts: Mapping[int, Tree]) -> Tree:
    """`tree` with each node that `parts` names, and all below it, replaced by its part. KeyError for no node.

    No pass: what it changes is for the caller to prove, see `difference`.
    """
    for node in parts:
        if not 0 <= node < len(tree.feature):
            raise KeyError(node)
    return _arrays(_nest_tree(tree, parts), tree.numbers)


def difference(a: Tree, b: Tree, n_features: int, aside: Collection[int] = ()) -> Floats | None:
    """An observation [n_features] for which two trees act differently, or None: a proof that there is none.

    Every leaf's box of `a`, NaN and infinities included, is followed through `b`. `aside`: nodes of `a` below which
    decisions may differ. ValueError for trees that compare unlike numbers.
    """
    if a.numbers != b.numbers:
        raise ValueError(f"trees of {a.numbers} and of {b.numbers}")
    stack = [(ROOT, ROOT, EVERYTHING)]
    while stack:
        here, there, box = stack.pop()
        if here in aside:
            continue
        first = a.feature[here] != NO_FEATURE  # not by identity: both may be the same tree
        tree, node = (a, here) if first else (b, there)
        if tree.feature[node] == NO_FEATURE:
            if a.action[here] != b.action[there]:
                return find_point(box, n_features, a.numbers)
            continue
        sides = box.split_at(int(tree.feature[node]), float(tree.threshold[node]))
        for child, part in zip((int(tree.left[node]), int(tree.right[node])), sides, strict=True):
            if part is not None:
                stack.append((child, there, part) if first else (here, child, part))
    return None


def _prove_pass(name: str, before: Tree, after: Tree, aside: Collection[int] = ()) -> Tree:
    n_features = int(max(before.feature.max(initial=0), after.feature.max(initial=0))) + 1
    counterexample = difference(before, after, n_features, frozenset(aside))
    if counterexample is not None:
        values = ", ".join(repr(float(value)) for value in counterexample)
        raise DisagreementError(f"the pass {name} changes a decision", f"at x = ({values})", "this is a bug")
    return after


# --- nested form


def _split(feature: int, threshold: float, left: _Node, right: _Node) -> _Node:
    """The split, or one of its sides where both are equal."""
    return left if left == right else _join_sides(feature, threshold, left, right)


def _join_sides(feature: int, threshold: float, left: _Node, right: _Node) -> _Split:
    """The split as it is."""
    levels = 1 + max(_levels(left), _levels(right))
    return _Split(feature, threshold, left, right, 1 + _size(left) + _size(right), levels)


def _size(node: _Node) -> int:
    return node.size if isinstance(node, _Split) else 0


def _levels(node: _Node) -> int:
    return node.levels if isinstance(node, _Split) else 0


def _nest_tree(tree: Tree, parts: Mapping[int, Tree] = MappingProxyType({})) -> _Node:
    """The tree as it is, equal sides included, with `parts` for some of its nodes."""
    nodes: dict[int, _Node] = {}
    for node in reversed(range(len(tree.feature))):  # preorder: children come after their parents
        if tree.feature[node] == NO_FEATURE:
            nodes[node] = _nest_tree(parts[node]) if node in parts else int(tree.action[node])
            continue
        left, right = nodes.pop(int(tree.left[node])), nodes.pop(int(tree.right[node]))
        if node in parts:
            nodes[node] = _nest_tree(parts[node])
            continue
        nodes[node] = _join_sides(int(tree.feature[node]), float(tree.threshold[node]), left, right)
    return nodes[ROOT]


def _arrays(root: _Node, numbers: str) -> Tree:
    def parts(node: _Node) -> int | tuple[int, float, _Node, _Node]:
        return node if isinstance(node, int) else (node.feature, node.threshold, node.left, node.right)

    return in_preorder(root, parts, numbers)


def _tests(node: _Node) -> Iterator[tuple[int, float]]:
    if isinstance(node, _Split):
        yield node.feature, node.threshold
        yield from _tests(node.left)
        yield from _tests(node.right)


def _within(node: _Node, box: Box) -> _Node:
    """Returns what is left of a subtree for the observations of a box."""
    if isinstance(node, int):
        return node
    left, right = box.split_at(node.feature, node.threshold)
    if left is None or right is None:
        return _within(node.left if right is None else node.right, box)
    return _split(node.feature, node.threshold, _within(node.left, left), _within(node.right, right))


def _without(tree: Tree, node: int, dead: frozenset[int]) -> _Node | None:
    """The subtree without its dead leaves; None when no leaf is left."""
    if tree.feature[node] == NO_FEATURE:
        return None if node in dead else int(tree.action[node])
    left, right = (_without(tree, int(child), dead) for child in (tree.left[node], tree.right[node]))
    if left is None or right is None:
        return right if left is None else left
    return _join_sides(int(tree.feature[node]), float(tree.threshold[node]), left, right)


# --- the order of tests


@dataclass(frozen=True)
class _Seen:
    """The patterns of answers to all tests that were observed, and how often each was."""

    patterns: np.ndarray  # [n, n_tests] bool
    counts: np.ndarray  # [n]
    column: dict[tuple[int, float], int]

    def split_rows(self, rows: np.ndarray, feature: int, threshold: float) -> tuple[np.ndarray, np.ndarray]:
        left = self.patterns[rows, self.column[feature, threshold]]
        return rows[left], rows[~left]


def _count_tests(node: _Node, rows: np.ndarray, seen: _Seen) -> float:
    """Counts the tests that a subtree makes for the patterns `rows`, all together."""
    if isinstance(node, int) or not len(rows):
        return 0.0
    left, right = seen.split_rows(rows, node.feature, node.threshold)
    return float(seen.counts[rows].sum()) + _count_tests(node.left, left, seen) + _count_tests(node.right, right, seen)


def _better(node: _Node, box: Box, rows: np.ndarray, seen: _Seen, levels: int) -> _Node:
    """The subtree of a box with its tests in the better order, at most `levels` deep and no larger than it is."""
    if isinstance(node, int):
        return node
    best, least = (node.feature, node.threshold, node.left, node.right), _count_tests(node, rows, seen)
    total = float(seen.counts[rows].sum())
    for feature, threshold in sorted(set(_tests(node))):
        below, above = box.split_at(feature, threshold)
        if below is None or above is None:
            continue
        left, right = _within(node, below), _within(node, above)
        if 1 + _size(left) + _size(right) > node.size or 1 + max(_levels(left), _levels(right)) > levels:
            continue
        sides = seen.split_rows(rows, feature, threshold)
        asked = total + _count_tests(left, sides[0], seen) + _count_tests(right, sides[1], seen)
        if asked < least:
            best, least = (feature, threshold, left, right), asked
    feature, threshold, left, right = best
    below, above = box.split_at(feature, threshold)
    if below is None or above is None:  # decided by the tests before
        return _better(left if above is None else right, box, rows, seen, levels)
    sides = seen.split_rows(rows, feature, threshold)
    return _split(
        feature,
        threshold,
        _better(left, below, sides[0], seen, levels - 1),
        _better(right, above, sides[1], seen, levels - 1),
    )
