"""What a page knows of agents that test sums or give numbers.

Does: sums, vectors and outputs as plain data; which numbers an output may be over the ranges of sliders; which two
  outputs are a force in the plane.
Assumes: a checked profile; `templates/play/engine.js` computes the sums, `slice.js` draws them.
Does not: decide.
"""

from collections.abc import Sequence
from typing import Any

from codegen import ir
from codegen.sums import CONSTANT, Sum
from codegen.wording import describe_sum

DIGITS = 3  # of weights, where people read them


def tree_data(policy: ir.AgentPolicy) -> dict[str, Any]:
    """What the tree of such an agent has beside its arrays: its sums and those of its leaves, with words."""
    tree, names = policy.tree, [feature.name for feature in policy.features]
    if not tree.arithmetic:
        return {}
    return {
        "arithmetic": tree.arithmetic,
        "gives": tree.gives,
        "sums": [_sum(each, names) for each in tree.sums],
        "vectors": [[_sum(each, names) for each in vector] for vector in tree.vectors],
    }


def _sum(each: Sum, names: Sequence[str]) -> dict[str, Any]:
    return {"terms": [list(term) for term in each.terms], "words": describe_sum(each.terms, names, DIGITS)}


def outputs_data(policy: ir.AgentPolicy, ranges: Sequence[tuple[float, float]]) -> list[dict[str, Any]]:
    """The outputs of an agent. `ranges`: of its features, as sliders show them."""
    return [
        {
            "name": output.name,
            "unit": output.unit,
            "low": output.low,
            "high": output.high,
            "span": _span(policy, place, ranges),
        }
        for place, output in enumerate(policy.outputs)
    ]


def _span(policy: ir.AgentPolicy, place: int, ranges: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """The least and most that a bar shows: the output's bounds, where it has none what intervals say of its sums."""
    output = policy.outputs[place]
    reached = [_bound_sum(vector[place], ranges) for vector in policy.tree.vectors]
    least, most = min(low for low, _ in reached), max(high for _, high in reached)
    return least if output.low is None else output.low, most if output.high is None else output.high


def _bound_sum(each: Sum, ranges: Sequence[tuple[float, float]]) -> tuple[float, float]:
    ends = [
        (weight, weight) if place == CONSTANT else sorted(weight * end for end in ranges[place])
        for weight, place in each.terms
    ]
    return sum(low for low, _ in ends), sum(high for _, high in ends)


def plane(policy: ir.AgentPolicy) -> tuple[int, int] | None:
    """The outputs that are the two parts of an arrow: of one unit, with names that differ in an x and a y alone."""
    for first, one in enumerate(policy.outputs):
        for second, other in enumerate(policy.outputs):
            unlike = [pair for pair in zip(one.name.lower(), other.name.lower(), strict=False) if pair[0] != pair[1]]
            if len(one.name) == len(other.name) and one.unit == other.unit and unlike == [("x", "y")]:
                return first, second
    return None
