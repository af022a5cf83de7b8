"""The JSON form of the nodes of a tree, and of the sums that they test or give.

Does: encodes a tree as the list of its nodes; decodes the list, naming the fault's path.
Assumes: the shapes of schema.py; whoever decodes checks the tree (check.py).
Does not: know the rest of a profile.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, cast

import numpy as np

from codegen.errors import ProfileError, escape_text, suggestion
from codegen.floats import FLOAT32, FLOAT64, deciding_double, short_hex
from codegen.form.fault import make_fault
from codegen.form.schema import AgentJson, NodeJson, SplitJson, SumJson
from codegen.ir import CONSTANT, NO_ACTION, NO_CHILD, NO_FEATURE, AgentPolicy, Int64, Sum, Tree
from codegen.sums import FLOAT32_STEPS

MAX_VISITS = 2**53  # which every reader of JSON takes in exactly


# --- encoding


def nodes_of(policy: AgentPolicy) -> list[dict[str, Any]]:
    """The nodes of an agent's tree, as plain data."""
    tree = policy.tree
    names = [feature.name for feature in policy.features]
    if policy.outputs:
        leaves = [{"outputs": [_dump_sum(each, names) for each in vector]} for vector in tree.vectors]
    else:
        leaves = [{"action": action.name} for action in policy.actions]
    visits = [{"visits": count} for count in tree.visits.tolist()] or [{}] * len(tree.feature)
    splits: Iterator[tuple[int, float]] = zip(tree.feature.tolist(), tree.threshold.tolist(), strict=True)
    ends: Iterator[tuple[int, int, int]] = zip(
        tree.left.tolist(), tree.right.tolist(), tree.action.tolist(), strict=True
    )
    return [
        leaves[action] | count
        if feature == NO_FEATURE
        else {**_dump_test(tree, feature, threshold, names), "left": left, "right": right}
        for (feature, threshold), (left, right, action), count in zip(splits, ends, visits, strict=True)
    ]


def _dump_test(tree: Tree, feature: int, threshold: float, names: Sequence[str]) -> dict[str, Any]:
    """What a split compares."""
    if feature >= len(names):
        return {"sum": _dump_sum(tree.sums[feature - len(names)], names), "threshold": threshold}
    if tree.numbers == FLOAT64:
        return {"feature": names[feature], "threshold": threshold}
    return {"feature": names[feature], "threshold": deciding_double(threshold), "float32": short_hex(threshold)}


def _dump_sum(each: Sum, names: Sequence[str]) -> list[list[float | str | None]]:
    return [[float(weight), None if place == CONSTANT else names[place]] for weight, place in each.terms]


# --- decoding


class _Known:
    """Sums, or vectors of them, each once, in the order in which nodes name them."""

    def __init__(self) -> None:
        self.found: list[Any] = []
        self._places: dict[str, int] = {}  # by text, which tells -0.0 from 0.0

    def place(self, each: Any) -> int:
        """Its place among those that are known."""
        key = repr(each)
        if key not in self._places:
            self._places[key] = len(self.found)
            self.found.append(each)
        return self._places[key]


class _Reading:
    """What the nodes of one agent have named so far."""

    def __init__(self, raw: AgentJson) -> None:
        self.features: Mapping[str, int] = {each.name: place for place, each in enumerate(raw.features)}
        self.actions: Mapping[str, int] = {each.name: place for place, each in enumerate(raw.actions)}
        self.numbers, self.arithmetic, self.n_features = raw.numbers, raw.arithmetic, len(raw.features)
        self.sums, self.vectors = _Known(), _Known()


def tree_of(raw: AgentJson, path: str) -> Tree:
    """The tree of an agent at a path. ProfileError for what is no node, or names what there is not."""
    seen = _Reading(raw)
    rows = [_row(node, seen, f"{path}.tree[{index}]") for index, node in enumerate(raw.tree)]
    return Tree(
        *(np.array([row[column] for row in rows]) for column in range(5)),
        visits=_visits(raw.tree, path),
        numbers=raw.numbers,
        arithmetic=raw.arithmetic or "",
        sums=tuple(seen.sums.found),
        vectors=tuple(seen.vectors.found),
        gives=raw.gives,
    )


def _row(node: NodeJson, seen: _Reading, path: str) -> tuple[int, float, int, int, int]:
    """One node as (feature, threshold, left, right, action)."""
    given = {name for name in NodeJson.__struct_fields__ if getattr(node, name) is not None} - {"visits"}
    if given == {"action"}:
        action = _place(seen.actions, cast(str, node.action), "action", f"{path}.action")
        return NO_FEATURE, 0.0, NO_CHILD, NO_CHILD, action
    if given == {"outputs"}:
        vector = tuple(_sum(each, seen, f"{path}.outputs") for each in cast(list[SumJson], node.outputs))
        return NO_FEATURE, 0.0, NO_CHILD, NO_CHILD, seen.vectors.place(vector)
    wanted = [name for name in SplitJson.__struct_fields__ if seen.numbers == FLOAT32 or name != FLOAT32]
    if given not in ({*wanted}, {"sum", "threshold", "left", "right"}):
        present = ", ".join(sorted(given)) or "nothing"
        fault = f"{path}: a node has {', '.join(wanted[:-1])} and {wanted[-1]}, or only action; found {present}"
        raise make_fault(fault)
    threshold = cast(float, node.threshold)
    if node.sum is not None:
        feature = seen.n_features + seen.sums.place(_sum(node.sum, seen, f"{path}.sum"))
        with np.errstate(over="ignore"):
            if seen.arithmetic == FLOAT32_STEPS and float(np.float32(threshold)) != threshold:
                raise make_fault(f"{path}.threshold: {threshold!r} is no float32")
    else:
        feature = _place(seen.features, cast(str, node.feature), "feature", f"{path}.feature")
        if seen.numbers == FLOAT32:
            threshold = _single(threshold, cast(str, node.float32), path)
    children = (cast(int, node.left), cast(int, node.right))
    if any(abs(child) >= 2**31 for child in children):
        raise make_fault(f"{path}: a child's number is out of range")
    return feature, threshold, *children, NO_ACTION


def _sum(given: SumJson, seen: _Reading, path: str) -> Sum:
    return Sum(
        tuple(
            (weight, CONSTANT if name is None else _place(seen.features, name, "feature", path))
            for weight, name in given
        )
    )


def _place(known: Mapping[str, int], name: str, kind: str, path: str) -> int:
    if name not in known:
        raise ProfileError(f"unknown {kind} '{escape_text(name)}'", path, suggestion(name, known))
    return known[name]


def _is_leaf(node: NodeJson) -> bool:
    return node.action is not None or node.outputs is not None


def _visits(nodes: Sequence[NodeJson], path: str) -> Int64:
    """The leaves' visits, [n], 0 at splits; [0] where no leaf has any."""
    known = [node.visits for node in nodes if node.visits is not None]
    if not known:
        return np.zeros(0, np.int64)
    leaves = sum(_is_leaf(node) for node in nodes)
    splits = [place for place, node in enumerate(nodes) if node.visits is not None and not _is_leaf(node)]
    if splits or len(known) != leaves:
        fault = f"[{splits[0]}]: a split has visits" if splits else f": {len(known)} of {leaves} leaves have visits"
        raise make_fault(f"{path}.tree{fault}")
    if not all(0 <= count <= MAX_VISITS for count in known):
        raise make_fault(f"{path}.tree: visits are from 0 to {MAX_VISITS}")
    return np.array([node.visits or 0 for node in nodes], np.int64)


def _single(double: float, text: str, path: str) -> float:
    """The float32 threshold that a split states twice."""
    try:
        exact = float.fromhex(text)
    except (ValueError, OverflowError):
        raise make_fault(f"{path}.float32: not a hexadecimal float: '{escape_text(text[:40])}'") from None
    with np.errstate(over="ignore"):
        single = np.float32(exact)
    if not np.isfinite(single) or float(single) != exact:
        raise make_fault(f"{path}.float32: {escape_text(text)} is not a finite float32")
    if deciding_double(single) != double:
        right = deciding_double(single)
        fault = f"{path}.threshold: {double!r} does not belong to float32 {escape_text(text)}; {right!r} does"
        raise make_fault(fault)
    return exact
