"""The JSON form of profiles: the shape of their files, their nodes, how texts are laid out.

Does: states every object and field as a struct, from which the published JSON schema is made; encodes a tree as the
  list of its nodes and decodes it, naming the path of a fault; writes plain data as text, short lists and objects on
  one line; follows a damaged text to where it breaks off.
Assumes: JSON as RFC 8259 says; the meaning of each field is that of its namesake in ir.py.
Does not: read a whole profile (policy_json.py), or check what needs more than one field (check.py).
"""

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Any, Literal, cast

import msgspec
import numpy as np

from codegen.errors import ProfileError, escape_text, suggestion
from codegen.floats import FLOAT32, WHOLE, deciding_double, short_hex
from codegen.ir import CONSTANT, NO_ACTION, NO_CHILD, NO_FEATURE, UNSCALED, AgentPolicy, Int64, Sum, Tree
from codegen.sums import FLOAT32_STEPS, MAX_INNER, Weight, divisor_of

SCHEMA_VERSION = 1
SUMS_VERSION = 2  # of profiles in which any agent has sums or outputs, and none remembers anything
MEMORY_VERSION = 3  # of profiles in which any agent remembers something, and none observes whole numbers
WHOLE_VERSION = 4  # of profiles in which any agent observes whole numbers, and no sum weighs another one
INNER_VERSION = 5  # of profiles in which a sum weighs another one, and none divides
DIVIDING_VERSION = 6  # of profiles in which a sum divides a term
Number = float | int | str


class _Strict(msgspec.Struct, forbid_unknown_fields=True):
    pass


class TermJson(_Strict, array_like=True):
    """[weight, feature], [constant, null] or [weight, sum], in the order of the additions; "/3.0" divides by 3."""

    weight: float | str
    weighed: "str | list[TermJson] | None"


SumJson = list[TermJson]


class SplitJson(_Strict):
    """`x[feature] <= threshold` goes to node `left`, everything else to node `right`.

    An agent that compares float64 or whole numbers has no `float32`: `threshold` is what it compares.
    """

    feature: str
    threshold: float
    float32: str
    left: int
    right: int


class NodeJson(_Strict, omit_defaults=True):
    """Either a split (feature, threshold, left, right, and float32 where that is compared) or a leaf (action; visits:
    its decisions in held-out episodes, of all leaves or of none). A split may have a sum in place of feature and
    float32, a leaf outputs in place of action: a sum for each output of the agent.
    """

    feature: str | None = None
    sum: SumJson | None = None
    threshold: float | None = None
    float32: str | None = None
    left: int | None = None
    right: int | None = None
    action: str | None = None
    outputs: list[SumJson] | None = None
    visits: int | None = None


class GrownJson(_Strict):
    """The tree as it was learned, in arrays: float64 thresholds, -1 for what a node does not have."""

    feature: list[int]
    threshold: list[float]
    left: list[int]
    right: list[int]
    action: list[int]


class FeatureJson(_Strict):
    """`seen`: least, 1st and 99th percentile and most in episodes, of all features of an agent or of none. `initial`:
    of what is remembered, after a reset. `scale`: factor and offset of a whole number, which is
    factor * (number in the unit) + offset.
    """

    name: str
    unit: str
    range: tuple[float, float]
    meaning: str | None
    seen: tuple[float, float, float, float] | None = None
    initial: int | None = None
    scale: tuple[float, float] = UNSCALED


class ActionJson(_Strict):
    """`acts`: the action that is taken, where this one also updates what is remembered: [memory, how, number]."""

    name: str
    effect: tuple[float, float] | None
    legal_if: str = ""
    label: int | float | str | None = None
    acts: str = ""
    updates: list[tuple[str, Literal["set", "add"], int]] = []


class OutputJson(_Strict):
    """A number that an agent gives, clipped to low and high; null: no bound."""

    name: str
    unit: str
    low: float | None
    high: float | None


class EntityJson(_Strict):
    name: str
    size: float
    force: float
    max_speed: float | None
    collides: bool
    start_box: tuple[float, float] | None


class VariableJson(_Strict):
    """A coordinate that belongs to no entity."""

    name: str
    unit: str
    range: tuple[float, float]


class WorldJson(_Strict):
    name: str
    reference: str
    agents: list[EntityJson]
    landmarks: list[EntityJson]
    goals: list[str]
    dt: float
    damping: float
    start_box: tuple[float, float]
    episode_steps: int
    contact_force: float
    contact_margin: float
    options: dict[str, int | str]
    variables: list[VariableJson] = []


class AgentJson(_Strict):
    """`numbers`: what the agent observes and compares, floats or one type of whole numbers. Of agents with sums or
    outputs also `arithmetic`, which sums are computed in, and of those that give numbers `outputs`, rounded to what the
    agent `gives`; these have no actions.
    """

    agent: str
    team: str
    features: list[FeatureJson]
    actions: list[ActionJson]
    tree: list[NodeJson]
    grown: GrownJson | None
    numbers: Literal["float32", "float64", "int8", "uint8", "int16", "uint16", "int32", "uint32"] = "float32"
    arithmetic: Literal["double sums", "float32 steps", "float64"] | None = None
    gives: Literal["float32", "float64"] = "float32"
    outputs: list[OutputJson] = []


class ProvenanceJson(_Strict):
    algorithm: str
    preset: str
    seed: int
    expert: str
    tool: str
    training: dict[str, Number]
    evaluation: dict[str, Number]


class RegionJson(_Strict):
    """World states: bounds of coordinates and of differences `a - b`, pairs kept apart; numbers are exact text."""

    goals: list[str]
    box: dict[str, tuple[str, str]]
    difference: dict[str, tuple[str, str]]
    apart: dict[str, str]


class ProfileJson(_Strict):
    """A policy profile. `content_hash` covers everything else; leave it out after an edit made on purpose.
    `region`: the world states that the trees are meant for; without it, all.
    """

    schema_version: int
    semantics: str
    world: WorldJson
    agents: list[AgentJson]
    provenance: ProvenanceJson
    region: RegionJson | None = None
    content_hash: str | None = None


MAX_VISITS = 2**53  # which every reader of JSON takes in exactly


# --- encoding


def nodes_of(policy: AgentPolicy) -> list[dict[str, Any]]:
    """The nodes of an agent's tree, as plain data."""
    tree = policy.tree
    names, stated = [feature.name for feature in policy.features], policy.whole or policy.numbers
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
        else {**_dump_test(tree, feature, threshold, names, stated), "left": left, "right": right}
        for (feature, threshold), (left, right, action), count in zip(splits, ends, visits, strict=True)
    ]


def _dump_test(tree: Tree, feature: int, threshold: float, names: Sequence[str], stated: str) -> dict[str, Any]:
    """Returns the comparison of a split, as JSON. `stated`: the numbers of the agent, as the profile states them."""
    if feature >= len(names):
        return {"sum": _dump_sum(tree.sums[feature - len(names)], names), "threshold": threshold}
    if stated != FLOAT32:
        return {"feature": names[feature], "threshold": int(threshold) if stated in WHOLE else threshold}
    return {"feature": names[feature], "threshold": deciding_double(threshold), "float32": short_hex(threshold)}


def _dump_sum(each: Sum, names: Sequence[str]) -> list[list[Any]]:
    def weighed(place: int | Sum) -> Any:
        return _dump_sum(place, names) if isinstance(place, Sum) else None if place == CONSTANT else names[place]

    divisors = [divisor_of(weight) for weight, _ in each.terms]
    weights = [
        float(weight) if over is None else f"/{over!r}" for over, (weight, _) in zip(divisors, each.terms, strict=True)
    ]
    return [[weight, weighed(place)] for weight, (_, place) in zip(weights, each.terms, strict=True)]


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
    """The names, sums and vectors that the nodes of one agent may refer to so far."""

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
        numbers=WHOLE.get(raw.numbers, raw.numbers),
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


def iterate_terms(raw: ProfileJson) -> Iterator[TermJson]:
    """Yields the terms of all sums of a profile, those in one another too."""
    nodes = [node for agent in raw.agents for node in agent.tree]
    terms = [term for node in nodes for each in [node.sum or [], *(node.outputs or [])] for term in each]
    for term in terms:
        yield term
        terms += term.weighed if isinstance(term.weighed, list) else []


def _sum(given: SumJson, seen: _Reading, path: str, depth: int = 1) -> Sum:
    if depth > MAX_INNER:
        raise make_fault(f"{path}: more than {MAX_INNER} sums lie in one another")

    def weighed(name: str | SumJson | None) -> int | Sum:
        if isinstance(name, list):
            return _sum(name, seen, path, depth + 1)
        return CONSTANT if name is None else _place(seen.features, name, "feature", path)

    return Sum(tuple((_weight(term.weight, path), weighed(term.weighed)) for term in given))


def _weight(given: float | str, path: str) -> Weight:
    if not isinstance(given, str):
        return given
    try:
        divisor = Fraction(float(given.removeprefix("/")))
    except (ValueError, OverflowError):
        divisor = Fraction(0)
    if not divisor or given != f"/{float(divisor)!r}":
        raise make_fault(f"{path}: no weight, and no number to divide by: '{escape_text(given[:40])}'")
    return 1 / divisor


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


LINE_WIDTH = 140
_flat = json.JSONEncoder(ensure_ascii=False, allow_nan=False).encode


def layout(value: Any, indent: int = 0) -> str:
    """JSON text in which whatever fits on a line stays on one: one node, one feature, one line."""
    if not isinstance(value, (dict, list)):
        return _flat(value)
    mapping = cast(dict[str, Any], value) if isinstance(value, dict) else None
    items = list(mapping.values()) if mapping is not None else cast(list[Any], value)
    if not any(isinstance(item, (dict, list)) for item in items):
        flat = _flat(value)
        if len(flat) + indent <= LINE_WIDTH or (mapping is None and all(isinstance(i, (int, float)) for i in items)):
            return flat
    rows = [layout(item, indent + 2) for item in items]
    if not any("\n" in row for row in rows):  # what holds something too long for a line is too long for one
        named = rows if mapping is None else [f"{_flat(key)}: {row}" for key, row in zip(mapping, rows, strict=True)]
        flat = ", ".join(named).join("[]" if mapping is None else "{}")
        if len(flat) + indent <= LINE_WIDTH:
            return flat
    if mapping is not None:
        rows = [f"{json.dumps(key)}: {row}" for key, row in zip(mapping, rows, strict=True)]
    inner = "\n" + " " * (indent + 2)
    return f"{inner}{f',{inner}'.join(rows)}\n{' ' * indent}".join("[]" if mapping is None else "{}")


_TOKEN = re.compile(r'"(?:[^"\\]|\\.)*"|[{}\[\],:]|[^\s{}\[\],:"]+|"')


def place(text: str) -> str:
    """The path in `text` at its end, with the line, e.g. `$.agents[1].tree[3] (line 87)`."""
    stack: list[str | int] = []  # keys of open objects, indices into open lists
    kinds: list[str] = []
    key_next = False
    end = 0
    for match in _TOKEN.finditer(text):
        token, end = match[0], match.end()
        if token in "{[":
            kinds.append(token)
            stack.append("" if token == "{" else 0)
            key_next = token == "{"
        elif token in "}]" and kinds:
            kinds.pop()
            stack.pop()
            key_next = False
        elif token == "," and kinds:
            last = stack[-1]
            stack[-1] = last + 1 if isinstance(last, int) else ""
            key_next = kinds[-1] == "{"
        elif token == ":":
            key_next = False
        elif key_next and len(token) > 1 and token.startswith('"'):
            stack[-1] = token[1:-1]
    steps = [f"[{step}]" if isinstance(step, int) else f".{step}" for step in stack if step != ""]
    return f"${''.join(steps)} (line {text.count(chr(10), 0, end) + 1})"


INVALID = "not a valid policy profile"
ADVICE = "extract it again, or undo the edit"


def make_fault(where: str, advice: str = ADVICE) -> ProfileError:
    """The error for a damaged profile; `where`: the path, and what is wrong there."""
    return ProfileError(INVALID, where, advice)
