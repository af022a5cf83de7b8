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

from codegen import ir
from codegen.check import identifier
from codegen.errors import InputError
from codegen.floats import deciding_double, decimal_literal, hex_literal
from codegen.policy_json import content_hash

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
    meaning: str


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
    double: str  # the deciding double, shortest decimal
    shown: str  # for comments only
    left: int
    right: int


@dataclass(frozen=True)
class Line:
    """A line of nested-if code: `if` opens a split, `else` turns to its right side, `end` closes it, `leaf` decides."""

    kind: Literal["if", "else", "end", "leaf"]
    level: int
    node: Node


@dataclass(frozen=True)
class Agent:
    """One agent's policy, ready to be written."""

    name: str
    lower: str
    upper: str
    team: str
    features: tuple[Feature, ...]
    actions: tuple[Action, ...]
    nodes: tuple[Node, ...]
    lines: tuple[Line, ...]
    comparisons: int  # in the worst case
    n_leaves: int


@dataclass(frozen=True)
class Model:
    """A whole profile, ready to be written."""

    prefix: str
    guard: str
    world: str
    content_hash: str
    tool: str
    algorithm: str
    preset: str
    seed: int
    agents: tuple[Agent, ...]


def lower(profile: ir.PolicyProfile, prefix: str | None = None) -> Model:
    """The emission model of a profile. `prefix` starts every public name of the generated code."""
    prefix = identifier(profile.world.name) if prefix is None else prefix
    if not PREFIX.fullmatch(prefix):
        raise InputError(
            f"not a usable prefix: {prefix!r}", "--prefix", "a lower-case letter, then letters, digits or _"
        )
    digest = content_hash(profile)
    model = Model(
        prefix=prefix,
        guard=f"{prefix.upper()}_{digest[:16].upper()}_H",
        world=profile.world.name,
        content_hash=digest,
        tool=profile.provenance.tool,
        algorithm=profile.provenance.algorithm,
        preset=profile.provenance.preset,
        seed=profile.provenance.seed,
        agents=tuple(_agent(policy) for policy in profile.agents),
    )
    _distinct(model)
    return model


def _distinct(model: Model) -> None:
    """Names that are legal one by one may meet once prefixes are joined to them."""
    names: list[str] = []
    for agent in model.agents:
        names += [f"{agent.lower}_act", f"{agent.lower}_finite"]
        names += [f"{agent.upper}_X_{feature.upper}" for feature in agent.features]
        names += [f"{agent.upper}_{action.upper}" for action in agent.actions]
        names += [
            f"{agent.upper}_N_FEATURES",
            f"{agent.upper}_N_ACTIONS",
            f"act_{agent.lower}",
            f"act_{agent.lower}_batch",
        ]
    twice = sorted(name for name, count in Counter(names).items() if count > 1)
    if twice:
        raise InputError(f"two names of the profile become the same name in code: {twice[0]}", "", "rename one of them")


def _agent(policy: ir.AgentPolicy) -> Agent:
    features = tuple(
        Feature(
            index,
            feature.name,
            identifier(feature.name).upper(),
            feature.unit,
            decimal_literal(feature.low),
            decimal_literal(feature.high),
            str(feature.meaning) if feature.meaning else "",
        )
        for index, feature in enumerate(policy.features)
    )
    actions = tuple(
        Action(index, action.name, identifier(action.name).upper()) for index, action in enumerate(policy.actions)
    )
    nodes = tuple(_node(policy.tree, node, features, actions) for node in range(len(policy.tree.feature)))
    lower_name = identifier(policy.agent)
    return Agent(
        name=policy.agent,
        lower=lower_name,
        upper=lower_name.upper(),
        team=policy.team,
        features=features,
        actions=actions,
        nodes=nodes,
        lines=tuple(_lines(nodes)),
        comparisons=int(ir.depth(policy.tree).max()),
        n_leaves=len(ir.leaves(policy.tree)),
    )


def _node(tree: ir.Tree, node: int, features: tuple[Feature, ...], actions: tuple[Action, ...]) -> Node:
    if tree.feature[node] == ir.NO_FEATURE:
        return Node(node, None, actions[int(tree.action[node])], "", "", "", ir.NO_CHILD, ir.NO_CHILD)
    threshold = tree.threshold[node]
    return Node(
        id=node,
        feature=features[int(tree.feature[node])],
        action=None,
        float_hex=hex_literal(threshold),
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
