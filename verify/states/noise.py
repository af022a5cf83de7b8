"""What a team may do when its features are off: reachable actions, errors that lead to them.

Does: per agent, the actions that errors within eps can cause, over batches; errors that make a world state a violation.
Assumes: one error a feature and agent, so an agent's leaf is reached iff each feature's interval meets the leaf's.
Does not: decide: it samples in float64, and the referee judges what it finds.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import chain, product

import numpy as np

from codegen import ir
from codegen.ir import AgentPolicy, Bool, FeatureSpec, Float64, PolicyProfile, WorldSpec
from codegen.observe import observe
from verify.claims.formula import substitute_actions
from verify.kinds import MACHINE, REAL
from verify.question import DecisionQuestion
from verify.states.real import Value, comparable, measure_feature, value_of
from verify.states.state import State, batch, error_name, meaning_of, measurable, violates

Cut = tuple[float, bool]  # where a line is cut: below a number, or above it when True
Cell = dict[int, tuple[Cut, Cut]]  # feature -> between which cuts its sum lies, where a leaf's path tests it
WHOLE: tuple[Cut, Cut] = (-math.inf, True), (math.inf, False)


def reachable(
    policy: AgentPolicy, coordinates: Float64, world: WorldSpec, eps: float, semantics: str = MACHINE
) -> Bool:
    """Returns which actions errors of at most `eps` can cause in each world state, [batch, n_actions]."""
    sums, room = _sums(policy, coordinates, world, eps, semantics)
    possible = np.zeros((len(coordinates), len(policy.actions)), dtype=bool)
    for leaf, cell in _cells(policy):
        meets = np.ones(len(coordinates), dtype=bool)
        for feature, (low, high) in cell.items():
            most, least = sums[:, feature] + room[feature], sums[:, feature] - room[feature]
            meets &= most > low[0] if low[1] else most >= low[0]
            meets &= least <= high[0] if high[1] else least < high[0]
        possible[:, policy.tree.action[leaf]] |= meets
    return possible


def changeable(question: DecisionQuestion, coordinates: Float64) -> Bool:
    """Where errors can change some agent's action, [batch]."""
    world, eps = question.profile.world, float(question.claim.eps)
    counts = [
        reachable(policy, coordinates, world, eps, question.semantics).sum(axis=1)
        for policy in question.profile.team(question.claim.team)
    ]
    return np.logical_or.reduce([count > 1 for count in counts])


def violable(question: DecisionQuestion, coordinates: Float64) -> Bool:
    """Where some errors make the team violate the claim, [batch]."""
    team, world, eps = question.profile.team(question.claim.team), question.profile.world, float(question.claim.eps)
    ways = [reachable(policy, coordinates, world, eps, question.semantics) for policy in team]
    states, violated = batch(coordinates, world), np.zeros(len(coordinates), dtype=bool)
    for joint in product(*(range(len(policy.actions)) for policy in team)):
        possible = np.logical_and.reduce([way[:, action] for way, action in zip(ways, joint, strict=True)])
        if possible.any():
            chosen = {policy.agent: action for policy, action in zip(team, joint, strict=True)}
            violated |= possible & ~states.holds(substitute_actions(question.formula, chosen), {})
    return violated


def mistaken(question: DecisionQuestion, state: State) -> State | None:
    """The world state with errors that make the team violate the claim, confirmed by the referee; None if none is
    found, which in real arithmetic means that there are none.
    """
    profile, eps, semantics = question.profile, question.claim.eps, question.semantics
    team, tries = profile.team(question.claim.team), list[list[Sequence[Mapping[str, Value]]]]()
    if state.floats:
        at = state.coordinates(profile)
        tries.append([ways(policy, at, profile.world, eps, semantics)[0] for policy in team])
    if semantics == REAL:
        tries.append([list(_exact_ways(profile, policy, state, eps)) for policy in team])
    for errors in chain.from_iterable(product(*each) for each in tries):
        candidate = replace(state, errors=together(errors))
        if violates(question, candidate):
            return candidate
    return None


def _exact_ways(
    profile: PolicyProfile, policy: AgentPolicy, state: State, eps: Fraction
) -> Iterator[Mapping[str, Value]]:
    """For each action that errors of at most `eps` can cause in real arithmetic, errors that lead to a leaf with it."""
    at, known = state.exactly(profile), set[int]()
    for leaf, cell in _cells(policy):
        action, errors = int(policy.tree.action[leaf]), dict[str, Value]()
        for place, (low, high) in cell.items() if action not in known else ():
            feature, kept = policy.features[place], measurable(meaning_of(policy.features[place]))
            meaning, room = meaning_of(feature), eps if kept else Fraction(0)
            value = measure_feature(replace(meaning, function="") if kept else meaning, at)
            least, most = max(_move_cut(low, value), (-room, False)), min(_move_cut(high, value), (room, True))
            if not least < most:
                break
            if not (least <= (0, False) and most >= (0, True)):
                error = (Fraction(least[0]) + Fraction(most[0])) / 2
                errors[error_name(policy.agent, feature.name)] = value_of(error)
        else:
            if action not in known:
                known.add(action)
                yield errors


def _move_cut(cut: Cut, by: Fraction) -> tuple[Fraction | float, bool]:
    """Where a line of sums is cut, as a cut of errors."""
    return (Fraction(cut[0]) - by if math.isfinite(cut[0]) else cut[0]), cut[1]


def together(errors: Iterable[Mapping[str, Value]]) -> dict[str, Value]:
    """The errors of several agents."""
    return {name: error for agent in errors for name, error in agent.items()}


def ways(
    policy: AgentPolicy, coordinates: Float64, world: WorldSpec, eps: Fraction, semantics: str = MACHINE
) -> list[list[dict[str, float]]]:
    """For each world state, and each action that errors of at most `eps` can cause there, errors that lead to a leaf
    with it; sums are rounded (to float32 in the deployed arithmetic), so some may lead to its neighbour.
    """
    most = float(eps) if Fraction(float(eps)) <= eps else math.nextafter(float(eps), 0.0)
    sums, room = _sums(policy, coordinates, world, most, semantics)
    cells = [(int(policy.tree.action[leaf]), cell) for leaf, cell in _cells(policy)]
    return [list(_ways(policy, row, room, cells)) for row in sums.tolist()]


def _ways(
    policy: AgentPolicy, sums: Sequence[float], room: Sequence[float], cells: Sequence[tuple[int, Cell]]
) -> Iterator[dict[str, float]]:
    known: set[int] = set()
    for action, cell in cells:
        errors = dict[str, float]()
        for feature, (low, high) in cell.items() if action not in known else ():
            value = sums[feature]
            least, most = max(low[0] - value, -room[feature]), min(high[0] - value, room[feature])
            if least > most:
                break
            if not low <= (value, False) < (value, True) <= high:
                errors[error_name(policy.agent, policy.features[feature].name)] = (least + most) / 2
        else:
            if action not in known:
                known.add(action)
                yield errors


def _sums(
    policy: AgentPolicy, coordinates: Float64, world: WorldSpec, eps: float, semantics: str
) -> tuple[Float64, list[float]]:
    """Returns what each feature measures before its function, [batch, n_features], and by how much it may be off."""
    plain, room = list[FeatureSpec](), list[float]()
    for feature in policy.features:
        meaning = meaning_of(feature)
        kept = measurable(meaning)
        plain.append(replace(feature, meaning=replace(meaning, function="")) if kept else feature)
        room.append(eps if kept else 0.0)
    if semantics == REAL:
        return comparable(plain, coordinates, world), room
    return observe(tuple(plain), coordinates, world, policy.numbers).astype(np.float64), room


def _cells(policy: AgentPolicy) -> Iterator[tuple[int, Cell]]:
    """Every leaf with the cuts that its path puts on the features' sums, unless these contradict one another."""
    tree = policy.tree
    waiting: list[tuple[int, Cell]] = [(ir.ROOT, {})]
    while waiting:
        node, cuts = waiting.pop()
        feature = int(tree.feature[node])
        if feature == ir.NO_FEATURE:
            yield node, cuts
            continue
        low, high = cuts.get(feature, WHOLE)
        cut = _cut(policy.features[feature].meaning, float(tree.threshold[node]))
        if cut < high:
            waiting.append((int(tree.right[node]), {**cuts, feature: (max(low, cut), high)}))
        if low < cut:
            waiting.append((int(tree.left[node]), {**cuts, feature: (low, min(high, cut))}))


def _cut(meaning: ir.Meaning | None, threshold: float) -> Cut:
    """Where the test of a feature's value against a threshold divides its sums."""
    if meaning is None or meaning.function in ("", "zero"):
        return threshold, True
    lowest = -1 if meaning.function == "sign" else 0
    if threshold < lowest:
        return WHOLE[0]
    return WHOLE[1] if threshold >= 1 else (0.0, threshold >= 0)
