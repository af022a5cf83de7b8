"""What a team may do when its features are off: reachable actions, errors that lead to them.

Does: per agent, the actions that errors within eps can cause, over batches; errors that make a world state a violation.
Assumes: one error a feature and agent, so an agent's leaf is reached iff each feature's interval meets the leaf's.
Does not: decide: it samples in float64, and the referee judges what it finds.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import product

import numpy as np

from codegen import ir
from codegen.ir import AgentPolicy, Bool, Float64, PolicyProfile, WorldSpec
from codegen.observe import observe
from verify.formula import given
from verify.properties import Property, formula
from verify.world import Point, batch, error_name, measurable, violates

Cell = dict[int, tuple[float, float]]  # feature -> (low, high] of its sum, where a leaf's path tests it
Cut = tuple[float, bool]  # where a line is cut: below a number, or above it when True
WHOLE: tuple[Cut, Cut] = (-math.inf, True), (math.inf, False)


def reachable(policy: AgentPolicy, coordinates: Float64, world: WorldSpec, eps: float) -> Bool:
    """Which actions errors of at most `eps` can cause in each world state, [batch, n_actions]."""
    sums, room = _sums(policy, coordinates, world, eps)
    found = np.zeros((len(coordinates), len(policy.actions)), dtype=bool)
    for leaf, cell in _cells(policy):
        meets = np.ones(len(coordinates), dtype=bool)
        for feature, (low, high) in cell.items():
            meets &= (sums[:, feature] + room[feature] > low) & (sums[:, feature] - room[feature] <= high)
        found[:, policy.tree.action[leaf]] |= meets
    return found


def changeable(profile: PolicyProfile, claim: Property, coordinates: Float64) -> Bool:
    """Where errors can change some agent's action, [batch]."""
    counts = [
        reachable(policy, coordinates, profile.world, float(claim.eps)).sum(axis=1)
        for policy in profile.team(claim.team)
    ]
    return np.logical_or.reduce([count > 1 for count in counts])


def violable(profile: PolicyProfile, claim: Property, coordinates: Float64) -> Bool:
    """Where some errors make the team violate the claim, [batch]."""
    team, stated = profile.team(claim.team), formula(profile, claim)
    ways = [reachable(policy, coordinates, profile.world, float(claim.eps)) for policy in team]
    states, found = batch(coordinates, profile.world), np.zeros(len(coordinates), dtype=bool)
    for joint in product(*(range(len(policy.actions)) for policy in team)):
        possible = np.logical_and.reduce([way[:, action] for way, action in zip(ways, joint, strict=True)])
        if possible.any():
            chosen = {policy.agent: action for policy, action in zip(team, joint, strict=True)}
            found |= possible & ~states.holds(given(stated, chosen), {})
    return found


def mistaken(profile: PolicyProfile, claim: Property, point: Point) -> Point | None:
    """The world state with errors that make the team violate the claim, confirmed by the referee; None if none is
    found.
    """
    coordinates = point.coordinates(profile)
    each = [ways(policy, coordinates, profile.world, claim.eps)[0] for policy in profile.team(claim.team)]
    for errors in product(*each):
        candidate = replace(point, errors=together(errors))
        if violates(profile, claim, candidate):
            return candidate
    return None


def together(errors: Iterable[Mapping[str, float]]) -> dict[str, float]:
    """The errors of several agents."""
    return {name: error for agent in errors for name, error in agent.items()}


def ways(policy: AgentPolicy, coordinates: Float64, world: WorldSpec, eps: Fraction) -> list[list[dict[str, float]]]:
    """For each world state, and each action that errors of at most `eps` can cause there, errors that lead to a leaf
    with it; sums are rounded to float32, so some may lead to its neighbour.
    """
    most = float(eps) if Fraction(float(eps)) <= eps else math.nextafter(float(eps), 0.0)
    sums, room = _sums(policy, coordinates, world, most)
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
            least, most = max(low - value, -room[feature]), min(high - value, room[feature])
            if least > most:
                break
            if not least < 0 <= most:
                errors[error_name(policy.agent, policy.features[feature].name)] = (least + most) / 2
        else:
            if action not in known:
                known.add(action)
                yield errors


def _sums(policy: AgentPolicy, coordinates: Float64, world: WorldSpec, eps: float) -> tuple[Float64, list[float]]:
    """What each feature measures before its function, [batch, n_features], and by how much it may be off."""
    plain = []
    for feature in policy.features:
        assert feature.meaning is not None
        kept = measurable(feature.meaning)
        plain.append(replace(feature, meaning=replace(feature.meaning, function="")) if kept else feature)
    room = [eps if one.meaning is not None and measurable(one.meaning) else 0.0 for one in policy.features]
    return observe(plain, coordinates, world).astype(np.float64), room


def _cells(policy: AgentPolicy) -> Iterator[tuple[int, Cell]]:
    """Every leaf with the bounds that its path puts on the features' sums, unless these contradict one another."""
    tree = policy.tree
    waiting: list[tuple[int, dict[int, tuple[Cut, Cut]]]] = [(ir.ROOT, {})]
    while waiting:
        node, cuts = waiting.pop()
        feature = int(tree.feature[node])
        if feature == ir.NO_FEATURE:
            yield node, {tested: (low, high) for tested, ((low, _), (high, _)) in cuts.items()}
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
