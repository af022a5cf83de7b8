"""Wrong readings of a source, each of which the hunt must notice.

Does: changes the first agent of a profile as a reader that errs would: by one neighbouring threshold, by two labels.
Assumes: a profile that was read from a source of one agent.
Does not: look for them.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from codegen.ir import PolicyProfile, Tree, splits


def _with(profile: PolicyProfile, **changes: Any) -> PolicyProfile:
    """The profile with a changed first agent."""
    return replace(profile, agents=(replace(profile.agents[0], **changes), *profile.agents[1:]))


def _tree(profile: PolicyProfile, **arrays: Any) -> PolicyProfile:
    tree: Tree = profile.agents[0].tree
    return _with(profile, tree=replace(tree, **arrays))


def _last(tree: Tree) -> int:
    """A split between two leaves that take different actions, which every tree of two actions has in some place."""
    pairs = [node for node in splits(tree) if tree.action[tree.left[node]] != tree.action[tree.right[node]]]
    both = [node for node in pairs if tree.action[tree.left[node]] >= 0 and tree.action[tree.right[node]] >= 0]
    return both[-1]


def _threshold(profile: PolicyProfile, towards: float) -> PolicyProfile:
    """A threshold is a neighbour of the right one."""
    tree = profile.agents[0].tree
    moved, node = tree.threshold.copy(), _last(tree)
    moved[node] = np.nextafter(moved[node], moved.dtype.type(towards))
    return _tree(profile, threshold=moved)


def _labels(profile: PolicyProfile) -> PolicyProfile:
    tree = profile.agents[0].tree
    node = _last(tree)
    one, other = tree.action[tree.left[node]], tree.action[tree.right[node]]
    return _tree(profile, action=np.where(tree.action == one, other, np.where(tree.action == other, one, tree.action)))


def _leaf(profile: PolicyProfile) -> PolicyProfile:
    tree = profile.agents[0].tree
    changed, node = tree.action.copy(), _last(tree)
    changed[tree.left[node]] = changed[tree.right[node]]
    return _tree(profile, action=changed)


def _sides(profile: PolicyProfile) -> PolicyProfile:
    tree = profile.agents[0].tree
    left, right, node = tree.left.copy(), tree.right.copy(), _last(tree)
    left[node], right[node] = right[node], left[node]
    return _tree(profile, left=left, right=right)


FAULTS: dict[str, Callable[[PolicyProfile], PolicyProfile]] = {
    "a threshold is the next number": lambda profile: _threshold(profile, np.inf),
    "a threshold is the number before": lambda profile: _threshold(profile, -np.inf),
    "two labels are swapped": _labels,
    "a leaf takes another action": _leaf,
    "two sides are swapped": _sides,
}
