"""A policy as rules that a person can read.

Does: writes each leaf as one if-then line, its tests merged into ranges.
Assumes: a checked profile.
Does not: draw.
"""

from collections.abc import Iterator

import numpy as np

from codegen import ir
from codegen.intervals import percent
from codegen.paths import parted
from codegen.wording import counted, within


def rules(policy: ir.AgentPolicy) -> Iterator[str]:
    """One line per leaf: the ranges that lead to it, the action, the leaf's id."""
    tree = policy.tree
    n = len(policy.features)
    stack = [(ir.ROOT, np.full(n, -np.inf, tree.numbers), np.full(n, np.inf, tree.numbers))]
    while stack:
        node, low, high = stack.pop()
        if tree.feature[node] == ir.NO_FEATURE:
            action = policy.actions[tree.action[node]].name
            yield f"{_condition(policy, low, high)} -> {action}  (leaf {node}{_visits(tree, node)})"
            continue
        left, right = parted(low, high, int(tree.feature[node]), tree.threshold[node])
        stack += [(int(tree.right[node]), *right), (int(tree.left[node]), *left)]


def _visits(tree: ir.Tree, node: int) -> str:
    """How often a leaf decided, where that was counted."""
    if not len(tree.visits):
        return ""
    visits = int(tree.visits.sum())
    return f", {percent(float(tree.visits[node] / max(1, visits)))} of {counted(visits, 'decision')}"


def _condition(policy: ir.AgentPolicy, low: ir.Floats, high: ir.Floats) -> str:
    parts = []
    for feature, least, most in zip(policy.features, low, high, strict=True):
        ends = [float(end) if np.isfinite(end) else None for end in (least, most)]
        if ends != [None, None]:
            parts.append(within(feature.name, *ends, digits=3))
    return "if " + " and ".join(parts) if parts else "always"
