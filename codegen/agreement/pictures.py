"""Decisions read from pictures: the attributes of an SVG's elements say what its tree decides.

Does: walks a picture's nodes, as a stranger would; adds sums as those of the JSON are added (json_sums.py).
Assumes: a picture of `codegen.targets.svg`.
Does not: share code with the emitter.
"""

from collections.abc import Mapping
from typing import Any
from xml.etree import ElementTree

import numpy as np

from codegen.agreement import json_sums
from codegen.ir import Floats

_SVG = "{http://www.w3.org/2000/svg}"


def svg_act(text: str, agent: str, rows: Floats) -> Any:
    """Decisions read from the attributes of a picture's elements, or what is given. `agent`: whose picture it is."""
    root = ElementTree.fromstring(text)
    nodes = {int(group.attrib["data-node"]): group.attrib for group in root.iter(f"{_SVG}g")}
    if "data-arithmetic" in root.attrib:
        policy = _policy(root.attrib, nodes, rows.shape[1])
        answers = [json_sums.answer(policy, row) for row in rows.tolist()]
        return np.array(answers)
    actions = np.empty(len(rows), dtype=np.int32)
    for place, row in enumerate(rows):
        node = nodes[0]
        while "data-feature" in node:
            threshold = float.fromhex(node["data-threshold"].rstrip("f"))
            goes_left = float(row[int(node["data-feature"])]) <= threshold
            node = nodes[int(node["data-left" if goes_left else "data-right"])]
        actions[place] = int(node["data-action"])
    return actions


def _policy(root: Mapping[str, str], nodes: Mapping[int, Mapping[str, str]], n_features: int) -> dict[str, Any]:
    """The picture of a tree with sums in the form of the JSON."""
    bounds = [each.split(":") for each in root["data-bounds"].split(";") if each]
    return {
        "arithmetic": root["data-arithmetic"],
        "gives": root["data-gives"],
        "features": [{"name": str(place)} for place in range(n_features)],
        "outputs": [{"low": _number(low), "high": _number(high)} for low, high in bounds],
        "tree": [_node(nodes[place]) for place in sorted(nodes)],
    }


def _node(node: Mapping[str, str]) -> dict[str, Any]:
    if "data-outputs" in node:
        return {"outputs": [_sum(each) for each in node["data-outputs"].split(";")]}
    if "data-action" in node:
        return {"action": int(node["data-action"])}
    tested = {"sum": _sum(node["data-sum"])} if "data-sum" in node else {"feature": node["data-feature"]}
    limit = {"threshold": _number(node["data-threshold"])}
    return {**tested, **limit, "left": int(node["data-left"]), "right": int(node["data-right"])}


def _sum(text: str) -> list[tuple[float, str | None]]:
    parts = [each.split(":") for each in text.split(",")]
    return [(float.fromhex(weight), None if place == "-1" else place) for weight, place in parts]


def _number(text: str) -> float | None:
    return float.fromhex(text.rstrip("f")) if text else None
