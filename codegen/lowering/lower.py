"""The last named level before text: legal names, exact literals, and the order in which text is written.

Does: turns a checked profile into the model that templates receive, which is plain data.
Assumes: `ir.check` found nothing (names are legal, trees sound).
Does not: write text of any language, or change a decision.
"""

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from codegen import ir
from codegen.check import identifier
from codegen.errors import InputError, UnknownNameError
from codegen.floats import deciding_double, decimal_literal, hex_literal, round_down, short_hex
from codegen.lowering.names import AgentNames, Names, ensure_distinct, of_agent, of_profile, taken
from codegen.policy_json import content_hash
from codegen.region import RegionSpec

NESTED, ORDERED, WALK, AUTO = "nested", "ordered", "walk", "auto"
STYLES = (NESTED, ORDERED, WALK, AUTO)
NESTED_LEVELS = 100  # MSVC stops at 128 nested blocks
NESTED_SPLITS = 10_000
COMPLETE_LEVELS = 8
SELECTS = 100  # splits up to which evaluating all of them beats walking
TILED = 5  # tested features from which on numpy copies columns faster in tiles than one by one
_BYTES = {"unsigned char": 1, "unsigned short": 2, "unsigned int": 4}
PREFIX = re.compile(r"[a-z][a-z0-9_]{0,40}")


@dataclass(frozen=True)
class Feature:
    """A feature and its place in the observation."""

    index: int
    name: str
    upper: str
    unit: str
    low: str
    high: str
    low_hex: str  # the range as float32, rounded outwards
    high_hex: str
    meaning: str
    function: str  # of the sum of `terms`; "" for the sum itself
    terms: tuple[tuple[str, str, str], ...] | None  # (sign, weight unless it is 1, coordinate); None: no meaning


@dataclass(frozen=True)
class Action:
    """An action and its number."""

    index: int
    name: str
    upper: str


@dataclass(frozen=True)
class Node:
    """A node of the tree. Splits compare feature `feature` with a threshold, leaves take `action`."""

    id: int
    feature: Feature | None
    action: Action | None
    float_hex: str  # the float32 threshold, exact, as a C literal
    bits: int  # of it as an unsigned number
    double: str  # the deciding double, shortest decimal
    shown: str  # for comments only
    left: int
    right: int

    @property
    def hex_bits(self) -> str:
        """`bits` in eight hexadecimal digits."""
        return f"0x{self.bits:08x}"

    @property
    def negative(self) -> bool:
        """Whether the threshold's sign is set, -0.0 included."""
        return self.bits >= 2**31


@dataclass(frozen=True)
class Line:
    """A line of nested-if code: `if` opens a split, `else` turns to its right side, `end` closes it, `leaf` decides."""

    kind: Literal["if", "else", "end", "leaf"]
    level: int
    node: Node

    def pad(self, width: int = 4, outer: int = 1) -> str:
        """The space before it, within `outer` levels of other code."""
        return " " * width * (self.level + outer)


@dataclass(frozen=True)
class Tables:
    """A tree as arrays. `complete`: the children of node i are 2 i + 1 and 2 i + 2, and `actions` has an entry for each
    path of `levels` tests; else `children` has two entries a node, a leaf being its own child.
    """

    complete: bool
    levels: int
    features: tuple[int, ...]
    thresholds: tuple[str, ...]  # hexadecimal floats
    children: tuple[int, ...]
    actions: tuple[int, ...]  # per path, or per node
    feature_type: str
    child_type: str
    action_type: str

    @property
    def size(self) -> int:
        """Bytes of all arrays."""
        widths = [
            (self.features, self.feature_type),
            (self.children, self.child_type),
            (self.actions, self.action_type),
        ]
        return 4 * len(self.thresholds) + sum(len(array) * _BYTES[kind] for array, kind in widths)


@dataclass(frozen=True)
class Agent:
    """One agent's policy, ready to be written."""

    name: str
    lower: str
    names: AgentNames
    team: str
    features: tuple[Feature, ...]
    actions: tuple[Action, ...]
    nodes: tuple[Node, ...]
    lines: tuple[Line, ...]
    tables: Tables
    used: tuple[Feature, ...]  # features that the tree tests
    repeated: frozenset[int]  # indices of those that it tests more than once
    comparisons: int  # in the worst case
    n_leaves: int
    selects: bool  # whether a batch over columns evaluates every split (else it walks)
    located: bool  # whether every feature has a meaning

    @property
    def observation_bytes(self) -> int:
        """Bytes of an observation of float32."""
        return 4 * len(self.features)

    @property
    def tiled(self) -> bool:
        """Whether a numpy batch first copies its columns, in tiles."""
        return len(self.used) >= TILED


@dataclass(frozen=True)
class Region:
    """The world states that the code is meant for, as its check compares them: coordinates are upper-case names."""

    bounds: tuple[tuple[str, str, str, str], ...]  # coordinate, the one subtracted or "", low, high
    apart: tuple[tuple[str, str, str], ...]  # entity, entity, least distance
    goals: tuple[str, ...]


@dataclass(frozen=True)
class Model:
    """A whole profile, ready to be written."""

    prefix: str
    names: Names
    world: str
    content_hash: str
    tool: str
    algorithm: str
    preset: str
    seed: int
    style: str  # one of STYLES but `auto`
    agents: tuple[Agent, ...]
    region: Region | None

    @property
    def located(self) -> bool:
        """Whether every agent can decide from world coordinates."""
        return all(agent.located for agent in self.agents)

    @property
    def chosen(self) -> bool:
        """Whether any agent has a choice."""
        return any(agent.comparisons for agent in self.agents)

    @property
    def tiled(self) -> bool:
        """Whether any agent's numpy batch copies its columns in tiles."""
        return any(agent.tiled for agent in self.agents)

    @property
    def numpy_type(self) -> str:
        """The numpy type that holds every agent's actions."""
        return f"uint{8 * max(_BYTES[agent.tables.action_type] for agent in self.agents)}"

    @property
    def side_by_side(self) -> bool:
        """Whether all trees are walked in step: complete tables with a test in each."""
        return all(agent.tables.complete and agent.tables.levels for agent in self.agents)

    @property
    def max_levels(self) -> int:
        """Tests on the longest path of any tree."""
        return max(agent.tables.levels for agent in self.agents)


def lower(profile: ir.PolicyProfile, prefix: str | None = None, style: str = AUTO) -> Model:
    """The emission model of a profile. `prefix` starts every public name of the generated code; `style`: how C decides.

    `auto` is nested ifs, which read like the tree and decide NaN as stated, up to NESTED_LEVELS levels and
    NESTED_SPLITS splits a tree; beyond that compilers give up on nested code, and it is a walk over tables.
    """
    if style not in STYLES:
        raise UnknownNameError("style", style, STYLES, "--style")
    prefix = identifier(profile.world.name) if prefix is None else prefix
    if not PREFIX.fullmatch(prefix):
        raise InputError(
            f"not a usable prefix: {prefix!r}", "--prefix", "a lower-case letter, then letters, digits or _"
        )
    if taken(prefix):
        raise InputError(f"no file of code can be called {prefix!r}", "--prefix", "choose another with --prefix")
    digest = content_hash(profile)
    model = Model(
        prefix=prefix,
        names=of_profile(prefix, digest, [_upper(name) for name in profile.world.coordinates()]),
        world=profile.world.name,
        content_hash=digest,
        tool=profile.provenance.tool,
        algorithm=profile.provenance.algorithm,
        preset=profile.provenance.preset,
        seed=profile.provenance.seed,
        style=_automatic(profile) if style == AUTO else style,
        agents=tuple(_agent(policy, prefix) for policy in profile.agents),
        region=None if profile.region is None else _region(profile.region),
    )
    ensure_distinct(model.names, {agent.lower: agent.names for agent in model.agents})
    return model


def _agent(policy: ir.AgentPolicy, prefix: str) -> Agent:
    features = tuple(
        Feature(
            index,
            feature.name,
            identifier(feature.name).upper(),
            feature.unit,
            decimal_literal(feature.low),
            decimal_literal(feature.high),
            hex_literal(round_down(feature.low)),
            hex_literal(-round_down(-feature.high)),
            str(feature.meaning) if feature.meaning else "",
            feature.meaning.function if feature.meaning else "",
            None if feature.meaning is None else tuple(_term(*term) for term in feature.meaning.terms),
        )
        for index, feature in enumerate(policy.features)
    )
    actions = tuple(
        Action(index, action.name, identifier(action.name).upper()) for index, action in enumerate(policy.actions)
    )
    nodes = tuple(_node(policy.tree, node, features, actions) for node in range(len(policy.tree.feature)))
    lower_name = identifier(policy.agent)
    tested = Counter(node.feature.index for node in nodes if node.feature)
    comparisons = int(ir.depth(policy.tree).max())
    return Agent(
        name=policy.agent,
        lower=lower_name,
        names=of_agent(prefix, lower_name, [each.upper for each in features], [each.upper for each in actions]),
        team=policy.team,
        features=features,
        actions=actions,
        nodes=nodes,
        lines=tuple(_lines(nodes)),
        tables=_tables(policy, nodes, comparisons),
        used=tuple(feature for feature in features if feature.index in tested),
        repeated=frozenset(index for index, count in tested.items() if count > 1),
        comparisons=comparisons,
        n_leaves=len(ir.leaves(policy.tree)),
        selects=len(nodes) // 2 <= SELECTS,
        located=all(feature.terms is not None for feature in features),
    )


def _region(region: RegionSpec) -> Region:
    return Region(
        tuple((_upper(a), _upper(b), short_hex(low), short_hex(high)) for a, b, low, high in region.bounds()),
        tuple((_upper(a), _upper(b), short_hex(least)) for a, b, least in region.distances()),
        tuple(_upper(goal) for goal in region.goals),
    )


def _upper(name: str) -> str:
    """A coordinate or an entity as names in code have it."""
    return identifier(name.replace(".", "_")).upper()


def _automatic(profile: ir.PolicyProfile) -> str:
    deepest = max(int(ir.depth(policy.tree).max()) for policy in profile.agents)
    largest = max(len(policy.tree.feature) // 2 for policy in profile.agents)
    return NESTED if deepest <= NESTED_LEVELS and largest <= NESTED_SPLITS else WALK


def _term(weight: float, coordinate: str) -> tuple[str, str, str]:
    size = "" if abs(weight) == 1 else decimal_literal(abs(weight))
    return ("-" if weight < 0 else "+", size, _upper(coordinate))


def _tables(policy: ir.AgentPolicy, nodes: tuple[Node, ...], levels: int) -> Tables:
    """Complete where that is not much larger than the tree: it needs no children and no test for the end."""
    types = (
        _unsigned(len(policy.features)),
        _unsigned(len(nodes)),
        _unsigned(len(policy.actions)),
    )
    zero = hex_literal(np.float32(0))
    if levels <= COMPLETE_LEVELS:
        n = 2**levels - 1
        features, thresholds, actions = [0] * n, [zero] * n, [0] * (n + 1)
        stack = [(nodes[ir.ROOT], 0)]
        while stack:
            node, place = stack.pop()
            children = (2 * place + 1, 2 * place + 2)
            if node.feature:
                features[place], thresholds[place] = node.feature.index, node.float_hex
                stack += [(nodes[node.left], children[0]), (nodes[node.right], children[1])]
            elif place >= n:
                assert node.action
                actions[place - n] = node.action.index
            else:  # both sides of what is never asked
                stack += [(node, children[0]), (node, children[1])]
        return Tables(True, levels, tuple(features), tuple(thresholds), (), tuple(actions), *types)
    return Tables(
        False,
        levels,
        tuple(node.feature.index if node.feature else 0 for node in nodes),
        tuple(node.float_hex if node.feature else zero for node in nodes),
        tuple(child for node in nodes for child in ((node.left, node.right) if node.feature else (node.id, node.id))),
        tuple(node.action.index if node.action else 0 for node in nodes),
        *types,
    )


def _unsigned(count: int) -> str:
    """The smallest C type that holds so many numbers from 0 on."""
    return next(kind for kind, width in _BYTES.items() if count <= 256**width)


def _node(tree: ir.Tree, node: int, features: tuple[Feature, ...], actions: tuple[Action, ...]) -> Node:
    if tree.feature[node] == ir.NO_FEATURE:
        leaf = actions[int(tree.action[node])]
        return Node(node, None, leaf, "", 0, "", "", ir.NO_CHILD, ir.NO_CHILD)
    threshold = tree.threshold[node]
    return Node(
        id=node,
        feature=features[int(tree.feature[node])],
        action=None,
        float_hex=hex_literal(threshold),
        bits=int(threshold.view(np.uint32)),
        double=decimal_literal(deciding_double(threshold)),
        shown=f"{float(threshold):.6g}",
        left=int(tree.left[node]),
        right=int(tree.right[node]),
    )


def _lines(nodes: tuple[Node, ...]) -> Iterator[Line]:
    stack: list[Line] = [_opening(nodes[ir.ROOT], 0)]
    while stack:
        line = stack.pop()
        yield line
        if line.kind == "if":
            node, inner = line.node, line.level + 1
            right = (Line("else", line.level, node), _opening(nodes[node.right], inner), Line("end", line.level, node))
            stack += [*reversed(right), _opening(nodes[node.left], inner)]


def _opening(node: Node, level: int) -> Line:
    return Line("leaf" if node.action else "if", level, node)
