"""A policy as rules that a person can read.

Does: writes each leaf as one if-then line, its tests merged into ranges.
Assumes: a checked profile.
Does not: draw.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from codegen import ir
from codegen.boxes import split_corners
from codegen.intervals import percent
from codegen.numbers import neighbour
from codegen.wording import NO_UNIT, describe_sum, format_count, number


def rules(policy: ir.AgentPolicy) -> Iterator[str]:
    """One line per leaf: the ranges that lead to it, the action or the numbers given, the leaf's id."""
    tree = policy.tree
    tested = _name_operands(policy)
    ends = (np.full(len(tested), end, tree.compared) for end in (-np.inf, np.inf))
    stack = [(ir.ROOT, *ends)]
    while stack:
        node, low, high = stack.pop()
        if tree.feature[node] == ir.NO_FEATURE:
            yield f"{_condition(tested, low, high)} -> {_does(policy, node)}  (leaf {node}{_visits(tree, node)})"
            continue
        left, right = split_corners(low, high, int(tree.feature[node]), tree.threshold[node])
        stack += [(int(tree.right[node]), *right), (int(tree.left[node]), *left)]


def bounds(policy: ir.AgentPolicy) -> Iterator[str]:
    """A line for each output that has bounds, with its unit."""
    for output in policy.outputs:
        if said := cut(output):
            unit = f" in {output.unit}" if output.unit not in NO_UNIT else ""
            yield f"{output.name}{unit}{said}"


def cut(output: ir.OutputSpec) -> str:
    """Where an output is cut, in words: `, cut to [-2, 2]`; "": nowhere."""
    if output.low is None and output.high is None:
        return ""
    low = "-inf" if output.low is None else number(output.low)
    high = "inf" if output.high is None else number(output.high)
    return f", cut to [{low}, {high}]"


def _name_operands(policy: ir.AgentPolicy) -> list[str]:
    """The features, and the sums that are tested, in words."""
    names = [feature.name for feature in policy.features]
    return names + [describe_sum(each.terms, names, digits=3) for each in policy.tree.sums]


def _does(policy: ir.AgentPolicy, leaf: int) -> str:
    """The action of a leaf, or what it gives."""
    chosen, names = int(policy.tree.action[leaf]), [feature.name for feature in policy.features]
    if not policy.outputs:
        return policy.actions[chosen].name
    pairs = zip(policy.outputs, policy.tree.vectors[chosen], strict=True)
    return ", ".join(f"{output.name} = {describe_sum(each.terms, names, digits=3)}" for output, each in pairs)


def _visits(tree: ir.Tree, node: int) -> str:
    """How often a leaf decided, where that was counted."""
    if not len(tree.visits):
        return ""
    visits = int(tree.visits.sum())
    return f", {percent(float(tree.visits[node] / max(1, visits)))} of {format_count(visits, 'decision')}"


def _condition(tested: Sequence[str], low: ir.Floats, high: ir.Floats) -> str:
    ends = zip(tested, low, high, strict=True)
    parts = [_spell_range(*each) for each in ends if np.isfinite(each[1:]).any()]
    return "if " + " and ".join(parts) if parts else "always"


def _spell_range(name: str, low: np.floating, high: np.floating) -> str:
    """The numbers above `low` and at most `high`, so that a copy in a claim means the same: `0 <= x < 0.5`."""
    if np.isfinite(low) and neighbour(low, np.inf, low.dtype.name) == high:
        return f"{name} == {_shorten(high)}"
    (after, least), (before, most) = map(_spell_end, (low, high))
    if not np.isfinite(low):
        return f"{name} {'<' if before else '<='} {most}"
    if not np.isfinite(high):
        return f"{name} {'>=' if after else '>'} {least}"
    return f"{least} {'<=' if after else '<'} {name} {'<' if before else '<='} {most}"


def _spell_end(end: np.floating) -> tuple[bool, str]:
    """A threshold, or the number after it where that is shorter, as 0.1 beside 0.09999999; and whether it is that."""
    texts = _shorten(end), _shorten(neighbour(end, np.inf, end.dtype.name))
    beyond = len(texts[1]) + 1 < len(texts[0])
    return beyond, texts[beyond]


def _shorten(value: np.floating) -> str:
    """The shortest decimal that is read as a number of its type."""
    return str(value + 0).removesuffix(".0")
