"""A policy as rules that a person can read, and one of its decisions test by test.

Does: writes each leaf as one if-then line, its tests merged into ranges; reads an observation, or a world state, from
  text; says which tests it meets and by how much, and what is done.
Assumes: a checked profile; a state needs features with meanings.
Does not: draw, or say why the tree was grown so.
"""

from collections.abc import Iterator, Sequence
from math import isnan

import numpy as np

from codegen import ir
from codegen.boxes import split_corners
from codegen.deciding import compute_operands, describe_decision, describe_given, describe_leaf, list_operands
from codegen.errors import InputError, UnknownNameError
from codegen.floats import observations
from codegen.importers.names import format_first
from codegen.importers.reading import find_uncompared
from codegen.intervals import percent
from codegen.ir import GOAL
from codegen.memory import describe_update
from codegen.numbers import neighbour
from codegen.observe import observe
from codegen.wording import NO_UNIT, format_count, number
from verify.claims.region_files import positions
from verify.states.state import State, Step, path


def tell_rules(profile: ir.PolicyProfile, policies: Sequence[ir.AgentPolicy]) -> Iterator[str]:
    """The rules of some agents, each under its name."""
    uncompared = find_uncompared(profile)
    for policy in policies:
        told = ", its source was not compared" if policy.agent in uncompared else ""
        yield f"{policy.agent}, team {policy.team}{told}"
        yield from (f"  {line}" for line in (*bounds(policy), *rules(policy)))


def rules(policy: ir.AgentPolicy) -> Iterator[str]:
    """One line per leaf: the ranges that lead to it, the action or the numbers given, the leaf's id."""
    tree = policy.tree
    tested = list_operands(policy)
    ends = (np.full(len(tested), end, tree.compared) for end in (-np.inf, np.inf))
    stack = [(ir.ROOT, *ends)]
    while stack:
        node, low, high = stack.pop()
        if tree.feature[node] == ir.NO_FEATURE:
            for place in range(len(policy.features) - len(policy.memory), len(policy.features)):
                low[place], high[place] = _whole_ends(low[place], high[place])
            does = describe_leaf(policy, node)
            yield f"{_condition(tested, low, high)} -> {does}  (leaf {node}{_visits(tree, node)})"
            continue
        left, right = split_corners(low, high, int(tree.feature[node]), tree.threshold[node])
        stack += [(int(tree.right[node]), *right), (int(tree.left[node]), *left)]


def _whole_ends(low: np.floating, high: np.floating) -> tuple[np.floating, np.floating]:
    """The same whole numbers as above `low` and at most `high`, spelled by themselves: `1 <= x`, `x == 1`."""
    most = np.floor(high)
    if np.floor(low) + 1 == most:
        return neighbour(most, -np.inf, most.dtype.name), most
    return neighbour(np.floor(low) + 1, -np.inf, low.dtype.name) if np.isfinite(low) else low, most


def bounds(policy: ir.AgentPolicy) -> Iterator[str]:
    """A line for each thing that is remembered, and for each output that has bounds, with its unit."""
    for each in policy.memory:
        told = f"remembers {each.name}, {each.low:g} to {each.high:g}, {each.initial} after a reset"
        yield "; ".join([told, *_list_setters(policy, each.name)])
    for output in policy.outputs:
        if said := cut(output):
            unit = f" in {output.unit}" if output.unit not in NO_UNIT else ""
            yield f"{output.name}{unit}{said}"


def _list_setters(policy: ir.AgentPolicy, memory: str) -> Iterator[str]:
    """Each update of a memory, with the leaves that make it."""
    made = dict[ir.Update, list[str]]()
    for leaf in ir.leaves(policy.tree).tolist():
        for each in policy.actions[int(policy.tree.action[leaf])].updates:
            if each.memory == memory:
                made.setdefault(each, []).append(str(leaf))
    for each, leaves in made.items():
        noun = "leaf" if len(leaves) == 1 else "leaves"
        yield f"{describe_update(each).removeprefix(memory).lstrip()} in {noun} {format_first(leaves)}"


def cut(output: ir.OutputSpec) -> str:
    """Where an output is cut, in words: `, cut to [-2, 2]`; "": nowhere."""
    if output.low is None and output.high is None:
        return ""
    low = "-inf" if output.low is None else number(output.low)
    high = "inf" if output.high is None else number(output.high)
    return f", cut to [{low}, {high}]"


def _visits(tree: ir.Tree, node: int) -> str:
    """Describes how often a leaf decided, where that was counted."""
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


def room(step: Step) -> float:
    """By how much the value may change, in its unit, before the test turns."""
    return abs(float(step.value) - step.threshold)


def lines(policy: ir.AgentPolicy, observation: ir.Floats) -> Iterator[str]:
    """A decision for one observation [n_features], for a reader: what is done, then each test."""
    leaf = int(ir.apply(policy.tree, observation[None])[0])
    yield f"{policy.agent}, team {policy.team}: {describe_decision(policy, observation)} (leaf {leaf})"
    for step in path(policy, compute_operands(policy, observation)):
        yield f"  {step}" if isnan(float(step.value)) else f"  {step}, by {room(step):.3g}"
    for output, given in zip(policy.outputs, describe_given(policy, leaf), strict=True):
        yield f"  {given}{cut(output)}"


def observation_of(policy: ir.AgentPolicy, text: str) -> ir.Floats:
    """The observation that a text states: its numbers in order, or NAME=NUMBER for each feature, [n_features], in the
    numbers that it compares.

    InputError for what is no number, UnknownNameError for no feature, InputError where one is missing.
    """
    parts = [part.strip() for part in text.split(",")]
    names = [feature.name for feature in policy.features]
    if "=" not in text and len(parts) != len(names):
        what = f"{format_count(len(parts), 'number')} for {format_count(len(names), 'feature')} of {policy.agent}"
        raise InputError(what, "--obs", f"in order: {format_first(names)}")
    if "=" not in text:
        return observations([[_number(part, "--obs") for part in parts]], len(names), policy.agent, policy.numbers)[0]
    given = _parse_values(parts, names, "feature", "--obs")
    missing = [name for name in names if name not in given]
    if missing:
        raise InputError(f"{policy.agent} also observes {', '.join(missing)}", "--obs", "give each as NAME=NUMBER")
    return observations([[given[name] for name in names]], len(names), policy.agent, policy.numbers)[0]


def observe_state(profile: ir.PolicyProfile, text: str) -> dict[str, ir.Floats]:
    """Returns each agent's observation of the world state that a text states: NAME=NUMBER for each position,
    `goal=LANDMARK` where there is a goal; velocities that are left out are 0. Errors as `observation_of`.
    """
    world, parts = profile.world, [part.strip() for part in text.split(",")]
    goals = [part.partition("=")[2].strip() for part in parts if part.partition("=")[0].strip() == GOAL]
    places = [part for part in parts if part.partition("=")[0].strip() != GOAL]
    known = [name for name in world.coordinates() if not name.startswith(f"{GOAL}.")]
    for policy in profile.agents:
        for feature in policy.features:
            if feature.meaning is None:
                what = f"feature {feature.name} of {policy.agent} has no meaning"
                raise InputError(what, "--state", f"give its observation: --agent {policy.agent} --obs ...")
    given = _parse_values(places, known, "coordinate", "--state")
    missing = [name for name in positions(world) if name not in given]
    missing += [GOAL] if world.goals and not goals else []
    if missing:
        raise InputError(f"the state also needs {', '.join(missing)}", "--state", "give each as NAME=VALUE")
    for goal in goals:
        if goal not in world.goals:
            raise UnknownNameError("goal", goal, world.goals, "--state")
    at = State(given, goals[-1] if goals else None).coordinates(profile)
    return {policy.agent: observe(policy.features, at, world, policy.numbers)[0] for policy in profile.agents}


def _parse_values(parts: list[str], known: list[str], what: str, where: str) -> dict[str, float]:
    by_name: dict[str, float] = {}
    for part in parts:
        name, equals, value = part.partition("=")
        if not equals:
            raise InputError(f"not a {what} with its value: {part!r}", where, f"write {known[0]}=0.25")
        if name.strip() not in known:
            raise UnknownNameError(what, name.strip(), known, where)
        by_name[name.strip()] = _number(value, where)
    return by_name


def _number(text: str, where: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise InputError(f"not a number: {text.strip()!r}", where, "write 0.25") from None
