"""The rules that a policy profile must keep.

Does: yields every broken rule with its path in the JSON form, so that one run shows all of them.
Assumes: the dataclasses hold the right Python types (the JSON decoder or the extractor has seen to that).
Does not: judge whether a policy is any good.
"""

import math
import re
import sys
from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import Final, NamedTuple
from unicodedata import category

import numpy as np

from codegen import sum_rules
from codegen.errors import STEERING, ProfileError, escape_text, suggestion
from codegen.floats import FLOAT32, NUMBERS
from codegen.ir import (
    FUNCTIONS,
    GOAL,
    MAX_DEPTH,
    MAX_LENGTH,
    MAX_NODES,
    NAME,
    NO_ACTION,
    NO_CHILD,
    NO_FEATURE,
    WEIGHTS,
    ActionSpec,
    AgentPolicy,
    FeatureSpec,
    GrownTree,
    PolicyProfile,
    Tree,
    WorldSpec,
    depth,
)
from codegen.legality import illegal_leaves, mask_of
from codegen.region import RegionSpec, round_up

MAX_VIOLATIONS: Final = 20


class Violation(NamedTuple):
    """One broken invariant: where (path in the JSON form) and what."""

    path: str
    message: str


NUMBER = re.compile(r"-?\d{1,30}(\.\d{1,60})?|-?\d{1,99}/[1-9]\d{0,99}")  # as the verifier writes bounds
UNSEEN = STEERING | {"Cs"}  # also halves of pairs
MAX_LABEL = 2_000  # letters of one
MAX_PARTS = 2  # of a variable's name, between dots
LEAST_MARGIN = 1e-9  # of contacts: lengths divided by it stay far below the largest double


def violations(profile: PolicyProfile) -> Iterator[Violation]:
    """Every broken rule of `profile`."""
    yield from _world(profile.world)
    if not profile.agents:
        yield Violation("$.agents", "a profile needs at least one agent")
    yield from _names("$.agents", "agent", [policy.agent for policy in profile.agents])
    movers = [entity.name for entity in profile.world.agents]
    placeless = not movers and bool(profile.world.variables)  # of such a world agents need be no entities
    for index, policy in enumerate(profile.agents):
        path = f"$.agents[{index}]"
        if policy.agent not in movers and not placeless:
            yield Violation(
                f"{path}.agent", f"no agent '{policy.agent}' in the world; {suggestion(policy.agent, movers)}"
            )
        if not NAME.fullmatch(policy.team):
            yield Violation(f"{path}.team", f"not a legal name: {policy.team!r}")
        yield from _agent(path, policy, profile.world)
    if profile.region is not None:
        yield from _region(profile.region, profile.world)
    yield from _texts(profile)
    for group, values in (("training", profile.provenance.training), ("evaluation", profile.provenance.evaluation)):
        for key, value in values.items():
            if isinstance(value, float) and not math.isfinite(value):
                yield Violation(f"$.provenance.{group}.{key}", "must be finite")


def _texts(profile: PolicyProfile) -> Iterator[Violation]:
    """Texts that are no names are shown to people, so they hold nothing that steers a terminal or cannot be seen."""
    world, origin = profile.world, profile.provenance
    texts = [("world.reference", world.reference)]
    texts += [("world.options", f"{key}={value}") for key, value in world.options.items()]
    texts += [(f"world.variables[{index}].unit", each.unit) for index, each in enumerate(world.variables)]
    for index, policy in enumerate(profile.agents):
        texts += [(f"agents[{index}].features[{k}].unit", each.unit) for k, each in enumerate(policy.features)]
        texts += [(f"agents[{index}].outputs[{k}].unit", each.unit) for k, each in enumerate(policy.outputs)]
    texts += [(f"provenance.{name}", getattr(origin, name)) for name in ("algorithm", "preset", "expert", "tool")]
    for group, values in (("training", origin.training), ("evaluation", origin.evaluation)):
        texts += [(f"provenance.{group}", f"{key}={value}") for key, value in values.items()]
    for path, text in texts:
        if not text.isprintable() and any(category(letter) in UNSEEN for letter in text):
            yield Violation(f"$.{path}", f"contains an invisible character: {escape_text(text[:40])}")


def _region(region: RegionSpec, world: WorldSpec) -> Iterator[Violation]:
    names = world.coordinates()
    entities = [entity.name for entity in world.agents + world.landmarks]
    readable = True
    if bool(region.goals) != bool(world.goals):
        yield Violation("$.region.goals", "must list the possible goals if the world has goals, and nothing otherwise")
    for goal in region.goals:
        if goal not in world.goals:
            yield Violation("$.region.goals", f"no goal '{goal}' in the world; {suggestion(goal, world.goals)}")
    for kind, pairs, known in (
        ("box", [(name, [name], bounds) for name, bounds in region.box.items()], names),
        ("difference", [(name, name.split(" - "), bounds) for name, bounds in region.difference.items()], names),
        ("apart", [(name, name.split(" - "), (least, least)) for name, least in region.apart.items()], entities),
    ):
        for name, parts, bounds in pairs:
            fault = _bounds_fault(kind, name, parts, bounds, known)
            if fault is not None:
                readable = False
                yield fault
    for name, (low, high) in region.box.items() if readable else ():
        if round_up(Fraction(low)) > -round_up(-Fraction(high)):
            yield Violation(f"$.region.box.{name}", "no double lies within the bounds")


def _bounds_fault(
    kind: str, name: str, parts: Sequence[str], bounds: Sequence[str], known: Sequence[str]
) -> Violation | None:
    """What is wrong with an entry of a region."""
    if len(parts) != (1 if kind == "box" else 2) or any(part not in known for part in parts):
        return Violation(f"$.region.{kind}", f"cannot read {name!r}")
    here = f"$.region.{kind}.{name}"
    if not all(NUMBER.fullmatch(text) for text in bounds):
        return Violation(here, f"not numbers: {bounds}")
    if len(set(parts)) < len(parts):
        return Violation(here, "compares a name with itself")
    if kind == "apart" and Fraction(bounds[0]) <= 0:
        return Violation(here, "a distance must be above 0")
    if Fraction(bounds[0]) > Fraction(bounds[1]):
        return Violation(here, f"the lower bound {bounds[0]} is above {bounds[1]}")
    return None


def _names(path: str, kind: str, names: Sequence[str], taken: Sequence[str] = ()) -> Iterator[Violation]:
    seen = {identifier(name) for name in taken}
    for index, name in enumerate(names):
        if not NAME.fullmatch(name):
            yield Violation(
                f"{path}[{index}]", f"not a legal {kind} name: {name!r} (a letter, then letters, digits, _ or -)"
            )
        # generated code folds case and turns '-' into '_', so names must differ after that
        if identifier(name) in seen:
            yield Violation(f"{path}[{index}]", f"{kind} '{name}' appears twice, or is taken")
        seen.add(identifier(name))


def identifier(name: str) -> str:
    """What generated code makes of a legal name: lower case, `_` for `-`."""
    return name.lower().replace("-", "_")


def _world(world: WorldSpec) -> Iterator[Violation]:
    path = "$.world"
    if not NAME.fullmatch(world.name):
        yield Violation(f"{path}.name", f"not a legal name: {world.name!r}")
    # one name, one coordinate: agents, landmarks and the alias of the goal share a name space, with goals or without
    taken = [GOAL]
    yield from _names(f"{path}.agents", "entity", [entity.name for entity in world.agents], taken)
    taken += [entity.name for entity in world.agents]
    yield from _names(f"{path}.landmarks", "entity", [entity.name for entity in world.landmarks], taken)
    yield from _numbers(world)
    yield from _variables(world)
    if world.episode_steps < 1:
        yield Violation(f"{path}.episode_steps", "must be at least 1")
    landmarks = [entity.name for entity in world.landmarks]
    for index, goal in enumerate(world.goals):
        if goal not in landmarks:
            yield Violation(f"{path}.goals[{index}]", f"no landmark '{goal}'; {suggestion(goal, landmarks)}")


def _variables(world: WorldSpec) -> Iterator[Violation]:
    """Rules about coordinates that belong to no entity; their names may have one dot, as in "agent_0.angle"."""
    own = len(world.variables)
    seen = {identifier(name) for name in world.coordinates()[: -own or None]}
    for index, variable in enumerate(world.variables):
        here = f"$.world.variables[{index}]"
        parts = variable.name.split(".")
        if len(parts) > MAX_PARTS or not all(NAME.fullmatch(part) for part in parts):
            yield Violation(here, f"not a legal name of a variable: {variable.name!r} (a name, or NAME.NAME)")
        if identifier(variable.name) in seen or identifier(parts[0]) == GOAL:
            yield Violation(here, f"variable '{variable.name}' appears twice, or is taken")
        seen.add(identifier(variable.name))
        if not -MAX_LENGTH <= variable.low <= variable.high <= MAX_LENGTH:
            what = f"needs a range with low <= high within {MAX_LENGTH:g}, has [{variable.low}, {variable.high}]"
            yield Violation(here, what)


def _numbers(world: WorldSpec) -> Iterator[Violation]:
    """Rules about how large things are, least and most inclusive; NaN keeps none of them."""
    least_margin = LEAST_MARGIN if 0 < world.contact_force <= MAX_LENGTH else 0.0
    rules = [
        ("dt", world.dt, 0.0, MAX_LENGTH, "seconds; 0: no motion is stated"),
        ("damping", world.damping, 0.0, 1.0, "a share"),
        ("start_low", world.start_low, -MAX_LENGTH, MAX_LENGTH, "a position"),
        ("start_high", world.start_high, -MAX_LENGTH, MAX_LENGTH, "a position"),
        ("contact_force", world.contact_force, 0.0, MAX_LENGTH, "contacts push apart"),
        ("contact_margin", world.contact_margin, least_margin, MAX_LENGTH, "a length"),
    ]
    for group, entities in (("agents", world.agents), ("landmarks", world.landmarks)):
        for index, entity in enumerate(entities):
            place = f"{group}[{index}]"
            rules += [
                (f"{place}.size", entity.size, 0.0, MAX_LENGTH, "a radius"),
                (f"{place}.force", entity.force, 0.0, MAX_LENGTH, "effects of actions have the sign"),
            ]
            if entity.max_speed is not None and not 0 < entity.max_speed <= MAX_LENGTH:
                yield Violation(f"$.world.{place}.max_speed", f"needs a speed above 0, at most {MAX_LENGTH:g}")
            if entity.start is not None and not -MAX_LENGTH <= entity.start[0] <= entity.start[1] <= MAX_LENGTH:
                yield Violation(f"$.world.{place}.start_box", f"needs low <= high within {MAX_LENGTH:g}")
    for name, value, least, most, says in rules:
        if not least <= value <= most:
            yield Violation(f"$.world.{name}", f"must be from {least:g} to {most:g} ({says}), not {value}")
    if world.start_low > world.start_high:
        yield Violation("$.world.start_low", "is above start_high")


def _agent(path: str, policy: AgentPolicy, world: WorldSpec) -> Iterator[Violation]:
    yield from _names(f"{path}.features", "feature", [feature.name for feature in policy.features])
    yield from _names(f"{path}.actions", "action", [action.name for action in policy.actions])
    if not policy.features:
        yield Violation(f"{path}.features", "an agent must observe something")
    if not policy.actions and not policy.outputs:
        yield Violation(f"{path}.actions", "an agent needs at least one action")
    yield from _names(f"{path}.outputs", "output", [output.name for output in policy.outputs])
    if policy.seen and len(policy.seen) != len(policy.features):
        yield Violation(f"{path}.features", "all of them have been seen, or none has")
    for index, ends in enumerate(policy.seen):
        if not all(abs(end) <= sys.float_info.max for end in ends) or list(ends) != sorted(ends):
            yield Violation(f"{path}.features[{index}].seen", "are finite numbers in ascending order")
    yield from _labels(f"{path}.actions", [action.label for action in policy.actions])
    known = world.coordinates()
    for index, feature in enumerate(policy.features):
        yield from _feature(f"{path}.features[{index}]", feature, known)
    names = [feature.name for feature in policy.features]
    for index, action in enumerate(policy.actions):
        yield from _action(f"{path}.actions[{index}]", action, names)
    yield from _trees(path, policy)


def _feature(path: str, feature: FeatureSpec, known: Sequence[str]) -> Iterator[Violation]:
    if not -MAX_LENGTH <= feature.low <= feature.high <= MAX_LENGTH:
        what = f"needs a range with low <= high within {MAX_LENGTH:g}, has [{feature.low}, {feature.high}]"
        yield Violation(path, what)
    meaning = feature.meaning
    if meaning is None:
        return
    if meaning.function not in ("", *(FUNCTIONS if meaning.terms else ())):  # always 0 has one spelling
        yield Violation(f"{path}.meaning", f"must be 0, a sum, or {', '.join(FUNCTIONS)} of a sum")
    for weight, coordinate in meaning.terms:
        if abs(weight) not in ((1,) if meaning.function else WEIGHTS):
            yield Violation(f"{path}.meaning", f"weights are powers of two, +1 or -1 in functions, not {weight:g}")
        if coordinate not in known:
            yield Violation(f"{path}.meaning", f"no coordinate '{coordinate}'; {suggestion(coordinate, known)}")


def _action(path: str, action: ActionSpec, features: Sequence[str]) -> Iterator[Violation]:
    if action.legal_if and action.legal_if not in features:
        what = f"no feature '{escape_text(action.legal_if)}'; {suggestion(action.legal_if, features)}"
        yield Violation(f"{path}.legal_if", what)
    if action.effect is not None and not all(abs(part) <= MAX_LENGTH for part in action.effect):
        yield Violation(f"{path}.effect", f"must be within {MAX_LENGTH:g} on each axis")


def _trees(path: str, policy: AgentPolicy) -> Iterator[Violation]:
    """What is wrong with the tree that acts, its numbers and leaves, and with the tree that was grown."""
    tree, numbers = policy.tree, policy.numbers
    counts = (len(policy.features) + len(tree.sums), len(tree.vectors) if policy.outputs else len(policy.actions))
    broken = list(_tree(f"{path}.tree", policy.tree, *counts, preorder=True))
    yield from broken
    for where, what in sum_rules.find_faults(policy) if not broken else ():
        yield Violation(f"{path}.{where}", what)
    visits = policy.tree.visits
    if len(visits) and (len(visits) != len(policy.tree.feature) or (visits < 0).any()):
        yield Violation(f"{path}.tree", "visits are one number for each node, from 0")
    if not broken and int(depth(policy.tree).max()) > MAX_DEPTH:
        yield Violation(f"{path}.tree", f"deeper than {MAX_DEPTH} splits")
    if numbers not in NUMBERS:
        yield Violation(f"{path}.numbers", f"must be {' or '.join(NUMBERS)}")
    mask = mask_of(policy.features, policy.actions)
    for leaf in illegal_leaves(policy.tree, mask) if mask and not broken else ():
        action = policy.actions[int(policy.tree.action[leaf])].name
        yield Violation(f"{path}.tree[{leaf}]", f"takes '{escape_text(action)}' where it may be illegal")
    if policy.grown is not None and numbers != FLOAT32:
        yield Violation(f"{path}.grown", f"must be null: a tree that compares {numbers} is not rounded")
    elif policy.grown is not None:
        yield from _tree(f"{path}.grown", policy.grown, *counts, preorder=False)


def _labels(path: str, labels: Sequence[int | float | str | None]) -> Iterator[Violation]:
    """Actions have labels of one kind, numbers or texts, or none has."""
    if not labels or all(each is None for each in labels):
        return
    texts = [each for each in labels if isinstance(each, str)]
    if len(texts) not in (0, len(labels)) or None in labels or len({*labels}) < len(labels):
        yield Violation(path, "labels are as many numbers or texts as there are actions, all different, or none")
    for each in labels:
        odd = isinstance(each, str) and (len(each) > MAX_LABEL or any(category(letter) in UNSEEN for letter in each))
        if odd or (isinstance(each, int | float) and not (math.isfinite(each) and abs(each) <= sys.float_info.max)):
            yield Violation(path, f"not a label: {escape_text(each)[:40]}")


def _tree(path: str, tree: Tree | GrownTree, n_features: int, n_actions: int, preorder: bool) -> Iterator[Violation]:
    arrays = (tree.feature, tree.threshold, tree.left, tree.right, tree.action)
    n = len(tree.feature)
    if any(array.shape != (n,) for array in arrays):
        yield Violation(path, f"arrays of different lengths: {[len(array) for array in arrays]}")
        return
    if not 1 <= n <= MAX_NODES:
        yield Violation(path, f"{n} nodes; 1 to {MAX_NODES} are allowed")
        return
    broken = False
    for violation in _nodes(path, tree, n_features, n_actions):
        broken = True
        yield violation
    if not broken:
        yield from _shape(path, tree, preorder)


def _nodes(path: str, tree: Tree | GrownTree, n_features: int, n_actions: int) -> Iterator[Violation]:
    """Rules about single nodes."""
    n = len(tree.feature)
    split = tree.feature != NO_FEATURE
    child_ok = (tree.left > 0) & (tree.left < n) & (tree.right > 0) & (tree.right < n)
    no_child = (tree.left == NO_CHILD) & (tree.right == NO_CHILD)
    action_ok = (tree.action >= 0) & (tree.action < n_actions)
    rules = (
        ("feature", (tree.feature < NO_FEATURE) | (tree.feature >= n_features), f"must be below {n_features}"),
        ("threshold", ~np.isfinite(tree.threshold), "must be finite"),
        ("left, right", split & ~child_ok, f"a split's children must be nodes 1 to {n - 1}"),
        ("left, right", ~split & ~no_child, "a leaf has no children"),
        ("action", split & (tree.action != NO_ACTION), "a split has no action"),
        ("action", ~split & ~action_ok, f"a leaf's action must be 0 to {n_actions - 1}"),
    )
    for name, bad, message in rules:
        for node in np.flatnonzero(bad):
            yield Violation(f"{path}[{node}].{name}", message)


def _shape(path: str, tree: Tree | GrownTree, preorder: bool) -> Iterator[Violation]:
    """Every node is reached exactly once from the root (no cycle, nothing shared or left over)."""
    seen = np.zeros(len(tree.feature), dtype=bool)
    stack = [0]
    reached = 0
    while stack:
        node = stack.pop()
        if seen[node]:
            yield Violation(f"{path}[{node}]", "is reached twice (a cycle or a shared subtree)")
            return
        if preorder and node != reached:
            yield Violation(f"{path}[{node}]", f"nodes must be in preorder; here node {reached} was expected")
            return
        seen[node] = True
        reached += 1
        if tree.feature[node] != NO_FEATURE:
            stack += [int(tree.right[node]), int(tree.left[node])]
    for node in np.flatnonzero(~seen)[:1]:
        yield Violation(f"{path}[{node}]", "cannot be reached from the root")


def check(profile: PolicyProfile) -> tuple[Violation, ...]:
    """Every broken invariant of a profile, each with its path; empty when the profile is sound."""
    return tuple(violations(profile))


def ensure(profile: PolicyProfile, where: str = "profile") -> PolicyProfile:
    """The profile itself when it is sound; otherwise ProfileError with all broken invariants."""
    broken = check(profile)
    if broken:
        lines = [f"{where}: {escape_text(item.path)}: {escape_text(item.message)}" for item in broken[:MAX_VIOLATIONS]]
        more = [f"... and {len(broken) - MAX_VIOLATIONS} more"] if len(broken) > MAX_VIOLATIONS else []
        raise ProfileError("not a valid policy profile", "\n".join(lines + more), "extract it again, or undo the edit")
    return profile
