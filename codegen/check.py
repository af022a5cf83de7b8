"""The rules on which it rests what a policy profile means and decides.

Does: yields every broken rule with its path in the JSON form, so that one run shows all of them.
Assumes: the dataclasses hold the right Python types (the JSON decoder or the extractor has seen to that).
Does not: judge texts, labels, evidence and the region that come with a policy (profiles.py), or whether it is any
  good.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Final, NamedTuple, TypeAlias

import numpy as np

from codegen.errors import ProfileError, escape_text, suggestion
from codegen.floats import FLOAT32, FLOAT64, NUMBERS, WHOLE
from codegen.ir import (
    CONSTANT,
    FUNCTIONS,
    GOAL,
    MAX_DEPTH,
    MAX_LENGTH,
    MAX_NODES,
    NAME,
    NO_ACTION,
    NO_CHILD,
    NO_FEATURE,
    UNSCALED,
    WEIGHTS,
    AgentPolicy,
    FeatureSpec,
    GrownTree,
    OutputSpec,
    PolicyProfile,
    Sum,
    Tree,
    WorldSpec,
    depth,
)
from codegen.memory import MAX_VALUE, describe_update, values_in
from codegen.paths import boxes_of, illegal_leaves, mask_of
from codegen.sums import ARITHMETICS, DOUBLE_SUMS, MAX_INNER, OBSERVED, choose_numbers, divisor_of

MAX_VIOLATIONS: Final = 20
MAX_TERMS = 1_000  # of a sum
MAX_PARTS = 2  # of a variable's name, between dots
LEAST_MARGIN = 1e-9  # of contacts: lengths divided by it stay far below the largest double


class Violation(NamedTuple):
    """One broken invariant: where (path in the JSON form) and what."""

    path: str
    message: str


Besides: TypeAlias = Callable[[PolicyProfile], Iterable[Violation]]  # of further rules
Found: TypeAlias = Iterator[tuple[str, str]]  # path below the agent's, and what is wrong


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
    """Turns a legal name into the identifier of generated code: lower case, `_` for `-`."""
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
    # coordinates that belong to no entity; their names may have one dot, as in "agent_0.angle"
    seen = {identifier(name) for name in world.coordinates()[: -len(world.variables) or None]}
    for index, variable in enumerate(world.variables):
        here = f"{path}.variables[{index}]"
        parts = variable.name.split(".")
        if len(parts) > MAX_PARTS or not all(NAME.fullmatch(part) for part in parts):
            yield Violation(here, f"not a legal name of a variable: {variable.name!r} (a name, or NAME.NAME)")
        if identifier(variable.name) in seen or identifier(parts[0]) == GOAL:
            yield Violation(here, f"variable '{variable.name}' appears twice, or is taken")
        seen.add(identifier(variable.name))
        if not -MAX_LENGTH <= variable.low <= variable.high <= MAX_LENGTH:
            what = f"needs a range with low <= high within {MAX_LENGTH:g}, has [{variable.low}, {variable.high}]"
            yield Violation(here, what)
    if world.episode_steps < 1:
        yield Violation(f"{path}.episode_steps", "must be at least 1")
    landmarks = [entity.name for entity in world.landmarks]
    for index, goal in enumerate(world.goals):
        if goal not in landmarks:
            yield Violation(f"{path}.goals[{index}]", f"no landmark '{goal}'; {suggestion(goal, landmarks)}")


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
    known = world.coordinates()
    for index, feature in enumerate(policy.features):
        yield from _feature(f"{path}.features[{index}]", feature, known, 2.0**32 if policy.whole else MAX_LENGTH)
    names = [feature.name for feature in policy.features]
    for index, action in enumerate(policy.actions):
        here = f"{path}.actions[{index}]"
        if action.legal_if and action.legal_if not in names:
            what = f"no feature '{escape_text(action.legal_if)}'; {suggestion(action.legal_if, names)}"
            yield Violation(f"{here}.legal_if", what)
        if action.effect is not None and not all(abs(part) <= MAX_LENGTH for part in action.effect):
            yield Violation(f"{here}.effect", f"must be within {MAX_LENGTH:g} on each axis")
    for index, feature in enumerate(policy.features):
        factor, offset = feature.scale
        plain = feature.scale == UNSCALED or (policy.whole and feature.initial is None)
        if not (plain and 0 < factor <= MAX_LENGTH and abs(offset) <= MAX_LENGTH):
            what = "is for whole numbers that are observed: a factor above 0 and an offset"
            yield Violation(f"{path}.features[{index}].scale", what)
    yield from _trees(path, policy)


def _feature(path: str, feature: FeatureSpec, known: Sequence[str], most: float) -> Iterator[Violation]:
    if not -most <= feature.low <= feature.high <= most:
        what = f"needs a range with low <= high within {most:g}, has [{feature.low}, {feature.high}]"
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


def _trees(path: str, policy: AgentPolicy) -> Iterator[Violation]:
    """Yields the faults of the tree that acts, of its numbers and leaves, and of the tree that was grown."""
    tree, numbers = policy.tree, policy.numbers
    counts = (len(policy.features) + len(tree.sums), len(tree.vectors) if policy.outputs else len(policy.actions))
    broken = list(_tree(f"{path}.tree", policy.tree, *counts, preorder=True))
    yield from broken
    for where, what in (*_sum_faults(policy), *_memory_faults(policy)) if not broken else ():
        yield Violation(f"{path}.{where}", what)
    if not broken and int(depth(policy.tree).max()) > MAX_DEPTH:
        yield Violation(f"{path}.tree", f"deeper than {MAX_DEPTH} splits")
    if numbers not in NUMBERS:
        yield Violation(f"{path}.numbers", f"must be {' or '.join(NUMBERS)}")
    for where, what in _whole_faults(policy) if policy.whole and not broken else ():
        yield Violation(f"{path}.{where}", what)
    mask = mask_of(policy.features, policy.actions)
    for leaf in illegal_leaves(policy.tree, mask) if mask and not broken else ():
        action = policy.actions[int(policy.tree.action[leaf])].name
        yield Violation(f"{path}.tree[{leaf}]", f"takes '{escape_text(action)}' where it may be illegal")
    if policy.grown is not None and (numbers != FLOAT32 or policy.whole):
        told = policy.whole or numbers
        yield Violation(f"{path}.grown", f"must be null: a tree that compares {told} is not rounded")
    elif policy.grown is not None:
        yield from _tree(f"{path}.grown", policy.grown, *counts, preorder=False)


def _tree(path: str, tree: Tree | GrownTree, n_features: int, n_actions: int, preorder: bool) -> Iterator[Violation]:
    arrays = (tree.feature, tree.threshold, tree.left, tree.right, tree.action)
    n = len(tree.feature)
    if any(array.shape != (n,) for array in arrays):
        yield Violation(path, f"arrays of different lengths: {[len(array) for array in arrays]}")
        return
    if not 1 <= n <= MAX_NODES:
        yield Violation(path, f"{n} nodes; 1 to {MAX_NODES} are allowed")
        return
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
    if any(bad.any() for _, bad, _ in rules):
        return
    # every node is reached exactly once from the root: no cycle, nothing shared or left over
    seen, stack, reached = np.zeros(n, dtype=bool), [0], 0
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
        if split[node]:
            stack += [int(tree.right[node]), int(tree.left[node])]
    for node in np.flatnonzero(~seen)[:1]:
        yield Violation(f"{path}[{node}]", "cannot be reached from the root")


def _whole_faults(policy: AgentPolicy) -> Found:
    """Yields every broken rule of an agent that observes whole numbers: its ranges and thresholds are numbers of the
    type, and nothing is added.
    """
    tree = policy.tree
    if WHOLE.get(policy.whole) != policy.numbers:
        yield "numbers", f"must be one of {', '.join(WHOLE)} for whole numbers"
        return
    if tree.arithmetic:
        yield "arithmetic", f"must be left out: sums of {policy.whole} are not computed"
    low, high = np.iinfo(policy.whole).min, np.iinfo(policy.whole).max
    for index, feature in enumerate(policy.features):
        if not (low <= feature.low and feature.high <= high and {feature.low % 1, feature.high % 1} == {0}):
            yield f"features[{index}].range", f"must be whole numbers of {policy.whole}"
    for node in np.flatnonzero(tree.feature != NO_FEATURE):
        threshold = float(tree.threshold[node])
        if threshold % 1 or not low <= threshold < high:
            yield f"tree[{node}].threshold", f"is no {policy.whole} below the largest"


def _sum_faults(policy: AgentPolicy) -> Found:
    """Yields every broken rule of an agent's sums and outputs.

    Weights, constants and bounds that are subnormal are refused: a thread that takes them for zero would compute
    otherwise.
    """
    tree = policy.tree
    if not (tree.sums or tree.vectors or policy.outputs):
        if tree.arithmetic:
            yield "arithmetic", "is for sums and outputs, and there are none"
        return
    if policy.actions and policy.outputs:
        yield "outputs", "an agent has actions or outputs, not both"
    if bool(policy.outputs) != bool(tree.vectors):
        yield "tree", "leaves give numbers where the agent has outputs, and actions elsewhere"
    if policy.grown is not None:
        yield "grown", "must be null: no learner's tree of single tests belongs to sums"
    if tree.arithmetic not in ARITHMETICS:
        yield "arithmetic", f"must be {', '.join(ARITHMETICS[:-1])} or {ARITHMETICS[-1]}"
        return
    if tree.numbers != OBSERVED[tree.arithmetic]:
        yield "numbers", f"must be {OBSERVED[tree.arithmetic]} where sums are {tree.arithmetic}"
    both = tree.arithmetic == DOUBLE_SUMS  # of which sums may be rounded once more
    kept = (FLOAT32, FLOAT64) if both else (choose_numbers(tree.arithmetic),)
    if tree.gives not in (kept if policy.outputs else (FLOAT32,)):
        yield "gives", f"must be {' or '.join(kept if policy.outputs else (FLOAT32,))} here"
    yield from _all_sums(policy)
    if tree.numbers == FLOAT32 and tree.compared == FLOAT64:  # a single feature is compared with one of its own numbers
        single = (tree.feature != NO_FEATURE) & (tree.feature < len(policy.features))
        with np.errstate(over="ignore"):
            rounded = tree.threshold.astype(np.float32) != tree.threshold
        for node in np.flatnonzero(single & rounded):
            yield f"tree[{node}].threshold", "is no float32, which the feature is"
    for index, output in enumerate(policy.outputs):
        for fault in _output(output, tree):
            yield f"outputs[{index}]", fault


def _all_sums(policy: AgentPolicy) -> Found:
    """Of all sums, in tests and in leaves, and of the order in which nodes name them."""
    tree, n = policy.tree, len(policy.features)
    yield from _order(tree.feature[tree.feature >= n] - n, tree.sums, "tree", "sum")
    leaves = tree.action[tree.feature == NO_FEATURE]
    if tree.vectors:
        yield from _order(leaves, tree.vectors, "tree", "vector")
    for node in np.flatnonzero(tree.feature >= n):
        each = tree.sums[int(tree.feature[node]) - n]
        for fault in _sum(each, tree.arithmetic, n):
            yield f"tree[{node}].sum", fault
        if not each.places or (len(each.terms) == 1 and each.terms[0][0] == 1):
            yield f"tree[{node}].sum", "a test of a sum has a feature, and more than one feature alone"
    for node in np.flatnonzero(tree.feature == NO_FEATURE) if tree.vectors else ():
        vector = tree.vectors[int(tree.action[node])]
        if len(vector) != len(policy.outputs):
            yield f"tree[{node}].outputs", f"has {len(vector)} sums for {len(policy.outputs)} outputs"
        for index, each in enumerate(vector):
            for fault in _sum(each, tree.arithmetic, n):
                yield f"tree[{node}].outputs[{index}]", fault


def _order(named: np.ndarray, known: Sequence[object], path: str, kind: str) -> Found:
    first = list(dict.fromkeys(named.tolist()))
    if first != list(range(len(known))) or len({repr(each) for each in known}) < len(known):
        yield path, f"each {kind} stands once, in the order in which nodes first name it"


def _sum(each: Sum, arithmetic: str, n_features: int) -> Iterator[str]:
    parts = [*each.parts()]
    if not all(part.terms for part in parts) or sum(len(part.terms) for part in parts) > MAX_TERMS:
        yield f"a sum has 1 to {MAX_TERMS} terms"
    if each.depth > MAX_INNER:
        yield f"more than {MAX_INNER} sums lie in one another"
    for part in parts:
        places = [place for _, place in part.terms if not isinstance(place, Sum)]
        if any(not CONSTANT <= place < n_features for place in places):
            yield f"features are 0 to {n_features - 1}"
        if len({*places}) < len(places):
            yield "a feature, or the constant, stands twice"
        for weight, place in part.terms:
            what = "a constant" if place == CONSTANT else "a weight"
            numbers = choose_numbers(arithmetic) if place == CONSTANT else OBSERVED[arithmetic]
            divisor = divisor_of(weight)
            if divisor is not None and (place == CONSTANT or arithmetic == DOUBLE_SUMS):
                yield "features and sums are divided, and not in double sums"
            if isinstance(place, Sum) and arithmetic == DOUBLE_SUMS and abs(weight) != 1:
                yield "in double sums an inner sum weighs 1 or -1"
            if weight == 0 and place != CONSTANT:
                yield "a weight is 0: leave its term out"
            elif (fault := _number(float(weight) if divisor is None else divisor, numbers)) is not None:
                yield f"{what} {fault}"


def _number(value: float, numbers: str) -> str | None:
    """Returns what is wrong with a weight, constant or bound, or None."""
    if not math.isfinite(value):
        return f"must be finite, not {value}"
    with np.errstate(over="ignore", under="ignore"):
        held = float(np.dtype(numbers).type(value))
    if held != value:
        return f"is no {numbers}: {value!r}"
    if value != 0 and abs(value) < float(np.finfo(numbers).tiny):
        return f"is subnormal: {value!r}"
    return None


def _output(output: OutputSpec, tree: Tree) -> Iterator[str]:
    for bound in (output.low, output.high):
        if bound is None:
            if tree.gives != choose_numbers(tree.arithmetic):
                yield f"needs both bounds: it is rounded from {choose_numbers(tree.arithmetic)} to {tree.gives}"
        elif (fault := _number(bound, tree.gives)) is not None:
            yield f"a bound {fault}"
    if output.low is not None and output.high is not None and not output.low <= output.high:
        yield f"needs low <= high, has [{output.low}, {output.high}]"


def _memory_faults(policy: AgentPolicy) -> Found:
    """Yields every broken rule about memory, of a policy whose tree is sound."""
    known = {each.name: each for each in policy.memory}
    if not known and not any(each.acts or each.updates for each in policy.actions):
        return
    if policy.features[-len(known) :] != policy.memory or len(known) == len(policy.features):
        yield "features", "some are observed, and those that are remembered come last"
    for each in policy.memory:
        ends = (each.low, each.initial or 0, each.high)
        if any(not abs(end) <= MAX_VALUE or end != int(end) for end in ends) or not ends[0] <= ends[1] <= ends[2]:
            yield "features", f"{each.name} is remembered: low <= initial <= high, whole numbers up to {MAX_VALUE}"
        if each.meaning is not None:
            yield "features", f"{each.name} is remembered, and measures nothing"
    if policy.outputs or any(each.legal_if or each.effect for each in policy.actions):
        yield "actions", "an agent that remembers has no outputs, effects or masks"
    plain = [each.name for each in policy.actions if not each.acts]
    if any(each.acts for each in policy.actions[: len(plain)]):
        yield "actions", "those that are taken come first"
    for place, action in enumerate(policy.actions):
        named = [each.memory for each in action.updates]
        if bool(action.acts) != bool(named) or (action.acts and action.acts not in plain):
            yield f"actions[{place}]", "acts names an action without updates, where there are updates"
        if len({*named}) < len(named) or any(each not in known for each in named):
            yield f"actions[{place}].updates", "each names one thing that is remembered"
        elif any(
            each.value == 0 if each.adds else not known[each.memory].low <= each.value <= known[each.memory].high
            for each in action.updates
        ):
            yield f"actions[{place}].updates", "what is set lies in its range, and nothing adds 0"
        elif any(each.adds for each in action.updates):
            yield from _leaving(policy, place, known)


def _leaving(policy: AgentPolicy, action: int, known: dict[str, FeatureSpec]) -> Found:
    """The leaves of an action whose additions may leave a range: their tests have to keep a counter below its end."""
    places = {each.name: place for place, each in enumerate(policy.features)}
    for leaf, box in boxes_of(policy.tree):
        for each in policy.actions[action].updates if policy.tree.action[leaf] == action else ():
            spec = known[each.memory]
            least, most = values_in(box, places[each.memory], spec)
            stays = spec.low <= least + each.value and most + each.value <= spec.high
            if each.adds and least <= most and not stays:
                yield f"tree[{leaf}]", f"{describe_update(each)} may leave its range: test it before"


def ensure(profile: PolicyProfile, where: str = "profile", besides: Besides | None = None) -> PolicyProfile:
    """The profile itself when it keeps these rules, and those that `besides` yields the breaches of; otherwise
    ProfileError with all that is broken.
    """
    broken = [*violations(profile), *(besides(profile) if besides else ())]
    if broken:
        lines = [f"{where}: {escape_text(item.path)}: {escape_text(item.message)}" for item in broken[:MAX_VIOLATIONS]]
        more = [f"... and {len(broken) - MAX_VIOLATIONS} more"] if len(broken) > MAX_VIOLATIONS else []
        raise ProfileError("not a valid policy profile", "\n".join(lines + more), "extract it again, or undo the edit")
    return profile
