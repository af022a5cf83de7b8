"""Answers read from the JSON of an agent with sums, as a stranger's program would find them.

Does: walks the nodes and adds the sums, with numpy's scalars of the numbers that the JSON names.
Assumes: the JSON of a profile of schema version 2.
Does not: share code with the reference (ir.py), or with the reader that is handed out.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np


def answer(policy: Mapping[str, Any], row: Sequence[float]) -> Any:
    """The name of the action, or the list of numbers given, for an observation in the agent's numbers."""
    number = np.float32 if policy["arithmetic"] == "float32 steps" else np.float64
    seen = {each["name"]: value for each, value in zip(policy["features"], row, strict=True)}
    nodes: Any = policy["tree"]
    node = nodes[0]
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        while "threshold" in node:
            value = _sum(node["sum"], seen, number) if "sum" in node else seen[node["feature"]]
            node = nodes[node["left"] if value <= node["threshold"] else node["right"]]
        if "action" in node:
            return node["action"]
        given = np.float32 if policy["gives"] == "float32" else np.float64
        pairs = zip(node["outputs"], policy["outputs"], strict=True)
        return [float(given(_cut(_sum(terms, seen, number), output))) for terms, output in pairs]


def _sum(terms: Sequence[tuple[float, str | None]], seen: Mapping[str, float], number: Any) -> Any:
    weights, names = zip(*terms, strict=True)
    values = [
        number(w) if name is None else number(w) * number(seen[name]) for w, name in zip(weights, names, strict=True)
    ]
    total = values.pop(0)
    while values:
        total = number(total + values.pop(0))
    return total


def _cut(value: Any, output: Mapping[str, Any]) -> Any:
    low, high = output["low"], output["high"]
    if low is not None and value < low:
        return low
    return high if high is not None and value > high else value
