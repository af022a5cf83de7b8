"""The last named level before text: legal names, exact literals, and the order in which text is written.

Does: turns a checked profile into the model that templates receive, which is plain data.
Assumes: `check.violations` finds nothing (names are legal, trees sound).
Does not: write text of any language, or change a decision.
"""

import re
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from codegen import ir
from codegen.boxes import read_bounds, read_distances
from codegen.check import identifier
from codegen.errors import InputError, UnknownNameError
from codegen.floats import FLOAT32, deciding_double, short_hex
from codegen.lowering.model import (
    Action,
    Agent,
    Change,
    Double,
    Feature,
    Given,
    Line,
    Machine,
    Memory,
    Model,
    Node,
    Output,
    Place,
    Region,
    Summed,
    SumNode,
    Tables,
    Term,
    choose_unsigned,
)
from codegen.lowering.names import Names, ensure_distinct, is_reserved, labels_of, name_member, of_agent, of_profile
from codegen.numbers import at_most, decimal_literal, hex_bits, hex_literal, neighbour, whole_literal
from codegen.policy_json import content_hash
from codegen.sums import FLOAT32_STEPS, divisor_of
from codegen.wording import describe_sum, holds
from codegen.world import RegionSpec

NESTED, ORDERED, FREESTANDING, WALK, AUTO = "nested", "ordered", "freestanding", "walk", "auto"
STYLES = (NESTED, ORDERED, FREESTANDING, WALK, AUTO)
NESTED_LEVELS = 100  # MSVC stops at 128 nested blocks
NESTED_SPLITS = 10_000
COMPLETE_LEVELS = 8
SELECTS = 100  # splits up to which evaluating all of them beats walking
WALKED = 10  # splits per level from which on numpy walks faster than it evaluates all of them
C_TYPES = {"float32": "float", "float64": "double"}
BITS = "int"  # the C type of a float's bits, where there are no floats
SHOWN_DIGITS = 3  # of what leaves give, where people read them
PREFIX = re.compile(r"[a-z][a-z0-9_]{0,40}")


def lower(profile: ir.PolicyProfile, prefix: str | None = None, style: str = AUTO) -> Model:
    """The emission model of a profile. `prefix` starts every public name of the generated code; `style`: how C decides.

    `auto` is nested ifs, which read like the tree and decide NaN as stated, up to NESTED_LEVELS levels and
    NESTED_SPLITS splits a tree; beyond that compilers give up on nested code, and it is a walk over tables.
    """
    if style not in STYLES:
        raise UnknownNameError("style", style, STYLES, "--style")
    prefix = identifier(profile.world.name) if prefix is None else prefix
    if not PREFIX.fullmatch(prefix):
        form = "a lower-case letter, then up to 40 lower-case letters, digits or _"
        raise InputError(f"not a usable prefix: {prefix!r}", "--prefix", form)
    if is_reserved(prefix):
        raise InputError(f"no file of code can be called {prefix!r}", "--prefix", "choose another with --prefix")
    if style == AUTO:
        deepest = max(int(ir.depth(policy.tree).max()) for policy in profile.agents)
        largest = max(len(policy.tree.feature) // 2 for policy in profile.agents)
        style = NESTED if deepest <= NESTED_LEVELS and largest <= NESTED_SPLITS else WALK
    else:
        _ensure_taken(profile, style)
    agents = _sharing(profile, [_agent(policy, prefix, profile.world) for policy in profile.agents])
    if style == FREESTANDING:
        agents = tuple(replace(each, tables=replace(each.tables, threshold_type=BITS)) for each in agents)
    digest = content_hash(profile)
    names = of_profile(prefix, digest, [_upper(name) for name in profile.world.coordinates()])
    model = Model(
        prefix=prefix,
        names=names,
        world=profile.world.name,
        content_hash=digest,
        tool=profile.provenance.tool,
        algorithm=profile.provenance.algorithm,
        preset=profile.provenance.preset,
        seed=profile.provenance.seed,
        style=style,
        agents=agents,
        region=None if profile.region is None else region_of(profile.region),
        places=_places(profile, names),
        dt=decimal_literal(profile.world.dt),
        damping=decimal_literal(profile.world.damping),
    )
    ensure_distinct(model.names, {agent.lower: agent.names for agent in model.agents})
    return model


def _ensure_taken(profile: ir.PolicyProfile, style: str) -> None:
    """InputError for a style that does not take the numbers that agents compare, or without floats what calculates."""
    for policy in profile.agents:
        if style in (ORDERED, FREESTANDING) and policy.whole:
            what = f"the style {style} compares the bits of float32, and {policy.agent} compares {policy.whole}"
            raise InputError(what, "--style", f"use {NESTED} or {WALK}: no style has floats then")
        if style in (ORDERED, FREESTANDING) and policy.numbers != FLOAT32:
            what = f"the style {style} compares the bits of float32, and {policy.agent} compares {policy.numbers}"
            raise InputError(what, "--style", f"use {NESTED} or {WALK}")
        needs = "adds floats" if policy.tree.arithmetic else "remembers" if policy.memory else ""
        if style == FREESTANDING and needs:
            what = f"the style {style} has neither floats nor state, and {policy.agent} {needs}"
            raise InputError(what, "--style", f"use {NESTED}")
    if style == FREESTANDING and profile.region is not None:
        what = f"the style {style} has no floats, and the check of the profile's region adds them"
        raise InputError(what, "--style", f"use {ORDERED}")


def _places(profile: ir.PolicyProfile, names: Names) -> dict[str, Place]:
    """The coordinates of a world state, by upper-case name."""
    read = {
        policy.agent: {name for each in policy.features if each.meaning for _, name in each.meaning.terms}
        for policy in profile.agents
    }
    by_name: dict[str, Place] = {}
    for index, name in enumerate(profile.world.coordinates()):
        readers = tuple(agent for agent, places in read.items() if name in places)
        by_name[_upper(name)] = Place(index, name, _upper(name), names.coordinates[_upper(name)], readers)
    return by_name


def _feature(index: int, feature: ir.FeatureSpec, numbers: str, whole: str) -> Feature:
    (factor, offset), low, high = feature.scale, at_most(feature.low, numbers), -at_most(-feature.high, numbers)
    shown, ends, bounded = [decimal_literal(each) for each in (feature.low, feature.high)], (low, high), (True, True)
    literals = [hex_literal(each) for each in ends]
    if whole:
        limits, ends = np.iinfo(whole), (feature.low, feature.high)
        shown, literals = [str(int(each)) for each in ends], [whole_literal(each, whole) for each in ends]
        bounded = feature.low > limits.min, feature.high < limits.max
    terms = None
    if feature.meaning is not None:
        terms = tuple(
            ("-" if weight < 0 else "+", "" if abs(weight) == 1 else decimal_literal(abs(weight)), _upper(coordinate))
            for weight, coordinate in feature.meaning.terms
        )
    return Feature(
        index=index,
        name=feature.name,
        upper=identifier(feature.name).upper(),
        unit=feature.unit,
        low=shown[0],
        high=shown[1],
        low_hex=literals[0],
        high_hex=literals[1],
        bounded=bounded,
        low_seen=decimal_literal(low),
        high_seen=decimal_literal(high),
        below_low=hex_bits(neighbour(low, -np.inf, numbers)[()]),
        high_bits=hex_bits(high + 0.0),
        meaning=str(feature.meaning) if feature.meaning else "",
        scale="" if feature.scale == ir.UNSCALED else f"{factor:.17g} * {feature.name} + {offset:.17g}",
        function=feature.meaning.function if feature.meaning else "",
        terms=terms,
    )


def _action(index: int, action: ir.ActionSpec) -> Action:
    effect = None if action.effect is None else (decimal_literal(action.effect[0]), decimal_literal(action.effect[1]))
    return Action(index, action.name, identifier(action.name).upper(), effect, identifier(action.legal_if).upper())


def _agent(policy: ir.AgentPolicy, prefix: str, world: ir.WorldSpec) -> Agent:
    features = tuple(
        _feature(index, feature, policy.numbers, policy.whole) for index, feature in enumerate(policy.features)
    )
    actions = tuple(_action(index, action) for index, action in enumerate(policy.actions))
    summed = _lower_sums(policy, features, actions)
    plain = range(0 if summed else len(policy.tree.feature))
    nodes = tuple(_node(policy.tree, node, features, actions, policy.whole) for node in plain)
    kinds = (features, actions, summed.outputs if summed else ())
    lower_name = identifier(policy.agent)
    tested = Counter(node.feature.index for node in nodes if node.feature)
    comparisons = int(ir.depth(policy.tree).max())
    return Agent(
        name=policy.agent,
        lower=lower_name,
        names=of_agent(prefix, lower_name, *([each.upper for each in kind] for kind in kinds)),
        team=policy.team,
        numbers=policy.numbers,
        whole=policy.whole,
        features=features,
        actions=actions,
        nodes=nodes,
        lines=tuple(_lines(nodes)) if nodes else (),
        tables=_tables(policy, nodes, comparisons),
        used=tuple(feature for feature in features if feature.index in tested),
        repeated=frozenset(index for index, count in tested.items() if count > 1),
        comparisons=comparisons,
        n_leaves=len(ir.leaves(policy.tree)),
        selects=len(nodes) // 2 <= SELECTS,
        vast=len(nodes) // 2 > NESTED_SPLITS,
        walks=len(nodes) // 2 > WALKED * comparisons and not any(node.split and node.below_zero for node in nodes),
        located=all(feature.terms is not None for feature in features),
        labels=labels_of([policy.actions[place].label for place in policy.taken]),
        summed=summed,
        machine=_machine(policy, actions) if policy.memory else None,
        force=decimal_literal(next((each.force for each in world.agents if each.name == policy.agent), 0.0)),
    )


def _machine(policy: ir.AgentPolicy, actions: Sequence[Action]) -> Machine:
    observed = len(policy.features) - len(policy.memory)
    called = {each.name: name_member(identifier(each.name)) for each in policy.memory}
    changes = tuple(
        Change(
            actions[place],
            actions[policy.taken[place]],
            tuple((called[each.memory], "+=" if each.adds else "=", each.value) for each in action.updates),
        )
        for place, action in enumerate(policy.actions)
        if action.updates
    )
    memory = tuple(
        Memory(place, called[each.name], each.initial or 0, int(each.low), int(each.high))
        for place, each in enumerate(policy.memory, observed)
    )
    return Machine(memory, changes, observed)


def _sharing(profile: ir.PolicyProfile, agents: Sequence[Agent]) -> tuple[Agent, ...]:
    """The agents, each with the first one that has the same tree over as many features and actions."""
    first: dict[tuple[object, ...], Agent] = {}
    shared: list[Agent] = []
    # trees with sums are written one by one
    for policy, agent in zip(profile.agents, agents, strict=True):
        tree = policy.tree
        arrays = (tree.feature, tree.threshold, tree.left, tree.right, tree.action)
        alike = (len(agent.features), len(agent.actions), agent.compared, *(each.tobytes() for each in arrays))
        same = agent if agent.summed else first.setdefault(alike, agent)
        shared.append(agent if same is agent else replace(agent, twin=same.names))
    return tuple(shared)


def region_of(region: RegionSpec) -> Region:
    """A region as the code that checks it has it."""
    return Region(
        tuple((_upper(a), _upper(b), _literal(low), _literal(high)) for a, b, low, high in read_bounds(region)),
        tuple((_upper(a), _upper(b), _literal(least)) for a, b, least in read_distances(region)),
        tuple(_upper(goal) for goal in region.goals),
    )


def _literal(value: float, single: bool = False) -> Double:
    return Double(short_hex(value) + ("f" if single else ""), decimal_literal(value))


def _upper(name: str) -> str:
    """A coordinate or an entity as names in code have it."""
    return identifier(name.replace(".", "_")).upper()


def _tables(policy: ir.AgentPolicy, nodes: tuple[Node, ...], levels: int) -> Tables:
    """Complete where that is not much larger than the tree: it needs no children and no test for the end. Of a tree
    with sums, without nodes, the types alone.
    """
    types = (
        f"{policy.whole}_t" if policy.whole else C_TYPES[policy.numbers],
        *map(choose_unsigned, (len(policy.features), len(nodes), len(policy.actions))),
    )
    if not nodes:
        return Tables(True, 0, (), (), (), (), *types)
    zero = whole_literal(0, policy.whole) if policy.whole else hex_literal(np.dtype(policy.numbers).type(0))
    if levels <= COMPLETE_LEVELS:
        n = 2**levels - 1
        features, thresholds, actions = [0] * n, [zero] * n, [0] * (n + 1)
        stack = [(nodes[ir.ROOT], 0)]
        while stack:
            node, place = stack.pop()
            children = (2 * place + 1, 2 * place + 2)
            if node.feature:
                features[place], thresholds[place] = node.feature.index, node.in_table
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
        tuple(node.in_table if node.feature else zero for node in nodes),
        tuple(child for node in nodes for child in ((node.left, node.right) if node.feature else (node.id, node.id))),
        tuple(node.action.index if node.action else 0 for node in nodes),
        *types,
    )


def _node(tree: ir.Tree, node: int, features: Sequence[Feature], actions: Sequence[Action], whole: str = "") -> Node:
    if tree.feature[node] == ir.NO_FEATURE:
        leaf = actions[int(tree.action[node])]
        return Node(node, None, leaf, "", "", 0, 0, "", "", "", ir.NO_CHILD, ir.NO_CHILD)
    threshold = np.dtype(tree.numbers).type(tree.threshold[node])
    test, double = holds(float(threshold)), deciding_double(threshold) if tree.numbers == FLOAT32 else threshold
    return Node(
        id=node,
        feature=features[int(tree.feature[node])],
        action=None,
        literal=hex_literal(threshold),
        whole=whole_literal(threshold, whole) if whole else "",
        bits=int.from_bytes(threshold.tobytes(), sys.byteorder),
        width=8 * threshold.itemsize,
        double=str(int(threshold)) if whole else decimal_literal(double),
        shown=test.removeprefix("<= "),
        test=test,
        left=int(tree.left[node]),
        right=int(tree.right[node]),
    )


def _lines(nodes: Sequence[Node] | Sequence[SumNode]) -> Iterator[Line]:
    def opening(node: int, level: int) -> Line:
        return Line("if" if nodes[node].split else "leaf", level, nodes[node])

    stack = [opening(ir.ROOT, 0)]
    while stack:
        line = stack.pop()
        yield line
        if line.kind == "if":
            node, level = line.node, line.level
            stack += [Line("end", level, node), opening(node.right, level + 1)]
            stack += [Line("else", level, node), opening(node.left, level + 1)]


# --- trees whose tests or leaves have sums


def _lower_sums(policy: ir.AgentPolicy, features: Sequence[Feature], actions: Sequence[Action]) -> Summed | None:
    """The tree of an agent whose tests or leaves have sums, what leaves give being clipped and rounded; else None."""
    tree = policy.tree
    if not tree.arithmetic:
        return None
    outputs = tuple(
        Output(
            index,
            each.name,
            identifier(each.name).upper(),
            each.unit,
            *(None if bound is None else _literal(bound) for bound in (each.low, each.high)),
        )
        for index, each in enumerate(policy.outputs)
    )
    nodes = tuple(_sum_node(policy, node, features, actions, outputs) for node in range(len(tree.feature)))
    return Summed(tree.arithmetic, tree.gives, outputs, nodes, tuple(_lines(nodes)))


def _sum_node(
    policy: ir.AgentPolicy,
    node: int,
    features: Sequence[Feature],
    actions: Sequence[Action],
    outputs: Sequence[Output],
) -> SumNode:
    tree, place = policy.tree, int(policy.tree.feature[node])
    children = int(tree.left[node]), int(tree.right[node])
    if place == ir.NO_FEATURE:
        chosen = int(tree.action[node])
        if not outputs:
            return SumNode(node, None, (), None, "", actions[chosen], (), *children)
        pairs = zip(outputs, tree.vectors[chosen], strict=True)
        given = tuple(_lower_given(policy, output, each, features) for output, each in pairs)
        return SumNode(node, None, (), None, "", None, given, *children)
    if place < len(features):
        plain = _node(tree, node, features, actions)
        return SumNode(node, plain, (), None, f"{features[place].name} {plain.test}", None, (), *children)
    tested, threshold = tree.sums[place - len(features)], float(tree.threshold[node])
    shown = f"{describe_sum(tested.terms, [each.name for each in features])} {holds(threshold)}"
    limit = _literal(threshold, tree.arithmetic == FLOAT32_STEPS)
    return SumNode(node, None, _terms(tested, features, tree.arithmetic), limit, shown, None, (), *children)


def _terms(each: ir.Sum, features: Sequence[Feature], arithmetic: str) -> tuple[Term, ...]:
    terms: list[Term] = []
    for weight, place in each.terms:
        divisor = divisor_of(weight)
        number = float(weight) if divisor is None else divisor
        sign = "-" if np.signbit(number) else "+"
        size = None if abs(number) == 1 and place != ir.CONSTANT else _literal(abs(number), arithmetic == FLOAT32_STEPS)
        inner = _terms(place, features, arithmetic) if isinstance(place, ir.Sum) else ()
        feature = None if isinstance(place, ir.Sum) or place == ir.CONSTANT else features[place]
        terms.append(Term(sign, size, feature, inner, divisor is not None))
    return tuple(terms)


def _lower_given(policy: ir.AgentPolicy, output: Output, each: ir.Sum, features: Sequence[Feature]) -> Given:
    tree, spec = policy.tree, policy.outputs[output.index]
    if each.places:
        shown = describe_sum(each.terms, [feature.name for feature in features], SHOWN_DIGITS)
        return Given(output, _terms(each, features, tree.arithmetic), None, shown)
    value = ir.clip_values(
        each.value(np.zeros((1, len(features)), policy.numbers), tree.arithmetic), spec.low, spec.high
    )
    number = float(value.astype(tree.gives)[0])
    return Given(output, (), _literal(number, tree.gives == FLOAT32), f"{number:.{SHOWN_DIGITS}g}")
