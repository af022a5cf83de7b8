"""The judge's reading of claims: what each says of world states and actions, from the definitions of the claims.

Does: regions and claims as three-valued truth over batches of states: exact for fractions, for float64 numbers "surely"
  and "possibly" with a bound on rounding.
Assumes: definitions as documented (closes, at, engaged, the properties by name); formulas as nested tuples.
Does not: import anything of ours.

A formula is ("and" | "or", part, ...), ("not", part), ("implies", part, part), ("acts", agent, name of an action),
("takes", agent, number of an action), ("goal", landmark), ("closes" | "at" | "engaged", agent, entity, bound), or
(relation, sum, sum) with a relation such as "<=". A sum is a fraction, a coordinate, ("+" | "-", sum, sum),
("*", fraction, sum), ("abs", sum), ("max" | "min", sum, ...) or ("distance", entity, entity).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import reduce
from itertools import combinations, permutations
from typing import Any

import numpy as np

from tests.hunting.reading import Agent, Array, At, Profile

ROUNDING = 2.0**-48  # more than what the few operations of one comparison lose, relative to the largest number in it


@dataclass(frozen=True)
class Truth:
    """Where something is true: surely, and possibly. Both are the same for exact numbers."""

    surely: Array
    possibly: Array

    def __and__(self, other: "Truth") -> "Truth":
        return Truth(self.surely & other.surely, self.possibly & other.possibly)

    def __or__(self, other: "Truth") -> "Truth":
        return Truth(self.surely | other.surely, self.possibly | other.possibly)

    def __invert__(self) -> "Truth":
        return Truth(~self.possibly, ~self.surely)


def always(count: int, value: bool = True) -> Truth:
    found = np.full(count, value)
    return Truth(found, found)


def every(parts: Sequence[Truth], count: int) -> Truth:
    return reduce(Truth.__and__, parts, always(count))


def some(parts: Sequence[Truth], count: int) -> Truth:
    return reduce(Truth.__or__, parts, always(count, False))


class Scene:
    """A batch of states with one goal, in which the agents have chosen: what claims are judged in.

    `at`: coordinate -> [batch], the goal's included; `actions`: agent -> [batch]; `scale`: exact numbers are this many
    times what they stand for, so that they are integers; 0 for float64 numbers.
    """

    def __init__(
        self, profile: Profile, at: At, goal: str | None, actions: Mapping[str, Array], scale: int = 0
    ) -> None:
        self.profile, self.at, self.goal, self.actions = profile, at, goal, actions
        self.count = len(next(iter(at.values())))
        self.exact, self._scale = scale != 0, scale

    def number(self, length: Any) -> Any:
        """A length in the batch's arithmetic."""
        if not self.exact:
            return float(length)
        found = Fraction(length) * self._scale
        return found.numerator if found.denominator == 1 else found

    def factor(self, number: Any) -> Any:
        """A number without a unit in the batch's arithmetic."""
        return Fraction(number) if self.exact else float(number)

    def _pushed(self, agent: Agent) -> tuple[Array, Array]:
        effects = agent.effects[self.actions[agent.name]]
        if not self.exact:
            return effects[:, 0], effects[:, 1]
        whole = effects.astype(int)  # directions are along an axis
        assert (whole == effects).all(), effects
        return whole[:, 0].astype(object), whole[:, 1].astype(object)

    def compare(self, left: Any, right: Any, size: Any, strict: bool) -> Truth:
        """left <= right, or left < right; `size`: at least every number that was added up."""
        gap = left - right
        gap = np.broadcast_to(np.asarray(gap, dtype=object if self.exact else float), (self.count,))
        if self.exact:
            found = (gap < 0 if strict else gap <= 0).astype(bool)
            return Truth(found, found)
        room = ROUNDING * np.broadcast_to(np.asarray(size, dtype=float), (self.count,)) + np.finfo(float).tiny
        return Truth(gap < -room, gap <= room)

    def gap(self, a: str, b: str, axis: str) -> tuple[Array, Array]:
        """a - b on an axis, and how large its parts are."""
        first, second = self.at[f"{a}.{axis}"], self.at[f"{b}.{axis}"]
        return first - second, abs(first) + abs(second)

    def closes(self, name: str, target: str, margin: Any) -> Truth:
        """u . (l - p) > margin."""
        ux, uy = self._pushed(self.profile.agent(name))
        (dx, sx), (dy, sy) = self.gap(target, name, "x"), self.gap(target, name, "y")
        return self.compare(self.number(margin), ux * dx + uy * dy, sx + sy + self.number(margin), True)

    def near(self, a: str, b: str, radius: Any) -> Truth:
        """The L-infinity distance is at most the radius."""
        limit, parts = self.number(radius), []
        for axis in "xy":
            gap, size = self.gap(a, b, axis)
            parts.append(self.compare(abs(gap), limit, size + limit, False))
        return every(parts, self.count)

    def engaged(self, name: str, target: str, margin: Any, radius: Any) -> Truth:
        """Closes on it or is at it."""
        return self.closes(name, target, margin) | self.near(name, target, radius)

    def straight(self, name: str, target: str, claim: Mapping[str, Any]) -> Truth:
        """At it, or closes on it and ahead by at least kappa times the sideways offset."""
        ux, uy = self._pushed(self.profile.agent(name))
        (dx, sx), (dy, sy) = self.gap(target, name, "x"), self.gap(target, name, "y")
        sideways = abs(ux * dy - uy * dx) * self.factor(claim["kappa"])
        ahead = self.compare(sideways, ux * dx + uy * dy, (sx + sy) * (1 + self.factor(claim["kappa"])), False)
        return self.near(name, target, claim["radius"]) | (self.closes(name, target, claim["margin"]) & ahead)

    def length(self, pairs: Sequence[tuple[str, str]]) -> tuple[Any, Any]:
        """The summed L1 distance of pairs, and how large its parts are."""
        gaps = [self.gap(a, b, axis) for a, b in pairs for axis in "xy"]
        return sum(abs(gap) for gap, _ in gaps), sum(size for _, size in gaps)


# --- formulas


def formula(node: Any, scene: Scene, claim: Mapping[str, Any]) -> Truth:
    """Where a formula is true."""
    kind, *parts = node
    if kind in ("and", "or"):
        found = [formula(part, scene, claim) for part in parts]
        return every(found, scene.count) if kind == "and" else some(found, scene.count)
    if kind == "not":
        return ~formula(parts[0], scene, claim)
    if kind == "implies":
        return ~formula(parts[0], scene, claim) | formula(parts[1], scene, claim)
    if kind == "goal":
        return always(scene.count, scene.goal == parts[0])
    if kind == "acts":
        chosen = scene.actions[parts[0]] == scene.profile.agent(parts[0]).actions.index(parts[1])
        return Truth(chosen, chosen)
    if kind == "takes":
        chosen = scene.actions[parts[0]] == parts[1]
        return Truth(chosen, chosen)
    if kind in ("closes", "at", "engaged"):
        name, target, *bound = parts
        if kind == "at":
            return scene.near(name, target, bound[0] if bound else claim["radius"])
        margin = bound[0] if bound else claim["margin"]
        return scene.closes(name, target, margin) | (
            scene.near(name, target, claim["radius"]) if kind == "engaged" else always(scene.count, False)
        )
    return _relation(kind, *(_sum(part, scene) for part in parts), scene)


def left_sides(node: Any) -> list[Any]:
    """What the implications among the conjuncts of a formula depend on: A of "A implies B", and of "not A or B"."""
    kind, *parts = node
    if kind == "and":
        return [each for part in parts for each in left_sides(part)]
    if kind == "implies":
        return [parts[0]]
    denied = [part[1] for part in parts if part[0] == "not"] if kind == "or" else []
    if len(denied) == len(parts):
        return denied
    return [("and", *denied)] if denied else []


def _relation(kind: str, left: tuple[Any, Any], right: tuple[Any, Any], scene: Scene) -> Truth:
    size = left[1] + right[1]
    if kind in (">", ">="):
        left, right, kind = right, left, {">": "<", ">=": "<="}[kind]
    if kind in ("<", "<="):
        return scene.compare(left[0], right[0], size, kind == "<")
    same = scene.compare(left[0], right[0], size, False) & scene.compare(right[0], left[0], size, False)
    return same if kind == "==" else ~same


def _sum(node: Any, scene: Scene) -> tuple[Any, Any]:
    """A sum's value, and how large its parts are."""
    if isinstance(node, str):
        return scene.at[node], abs(scene.at[node])
    if isinstance(node, Fraction):
        return scene.number(node), abs(scene.number(node))
    kind, *parts = node
    if kind == "distance":
        gaps = [scene.gap(*parts, axis) for axis in "xy"]
        return np.maximum(*(abs(gap) for gap, _ in gaps)), sum(size for _, size in gaps)
    if kind == "*":
        (value, size), factor = _sum(parts[1], scene), scene.factor(parts[0])
        return value * factor, size * abs(factor)
    values = [_sum(part, scene) for part in parts]
    size = sum(size for _, size in values)
    if kind in ("+", "-"):
        return (values[0][0] + values[1][0] if kind == "+" else values[0][0] - values[1][0]), size
    if kind == "abs":
        return abs(values[0][0]), size
    return reduce(np.maximum if kind == "max" else np.minimum, [value for value, _ in values]), size


# --- claims


def holds(claim: Mapping[str, Any], scene: Scene) -> Truth:
    """Where a claim about decisions holds, or its assumption does not."""
    found = _stated(claim, scene)
    return ~formula(claim["assume"], scene, claim) | found if claim.get("assume") else found


def _stated(claim: Mapping[str, Any], scene: Scene) -> Truth:
    name = claim["of"] if claim["name"] == "steady" else claim["name"]
    if name == "formula":
        return formula(claim["formula"], scene, claim)
    team = [agent.name for agent in scene.profile.team(claim["team"])]
    marks = scene.profile.landmarks
    if not team:
        return always(scene.count, False)  # nothing is claimed of nobody
    if name == "no_double":
        return _no_double(team, marks, claim, scene)
    own = claim.get("landmarks") or marks[: len(team)]
    ways = [own] if name == "own_target" else list(permutations(marks, len(team)))
    found = []
    for way in ways:
        if name == "aligned":
            parts = [scene.straight(a, k, claim) for a, k in zip(team, way, strict=True)]
        else:
            parts = [scene.engaged(a, k, claim["margin"], claim["radius"]) for a, k in zip(team, way, strict=True)]
        least = [_no_longer(team, way, other, scene) for other in ways] if name == "assignment" else []
        found.append(every(parts + least, scene.count))
    return some(found, scene.count)


def _no_double(team: Sequence[str], marks: Sequence[str], claim: Mapping[str, Any], scene: Scene) -> Truth:
    towards = {(a, k): scene.closes(a, k, claim["margin"]) for a in team for k in marks}

    def only(a: str, k: str) -> Truth:
        return every([towards[a, k], *(~towards[a, other] for other in marks if other != k)], scene.count)

    return every([~(only(a, k) & only(b, k)) for a, b in combinations(team, 2) for k in marks], scene.count)


def _no_longer(team: Sequence[str], way: Sequence[str], other: Sequence[str], scene: Scene) -> Truth:
    own, size = scene.length(list(zip(team, way, strict=True)))
    theirs, more = scene.length(list(zip(team, other, strict=True)))
    return scene.compare(own, theirs, size + more, False)


def related(region: Mapping[str, Any], scene: Scene) -> Truth:
    """Where the states of a batch have a region's differences and distances; its box is another thing."""
    parts = []
    for a, b, (low, high) in region["differences"]:
        gap, size = scene.at[a] - scene.at[b], abs(scene.at[a]) + abs(scene.at[b])
        parts.append(scene.compare(scene.number(low), gap, size + abs(scene.number(low)), False))
        parts.append(scene.compare(gap, scene.number(high), size + abs(scene.number(high)), False))
    for a, b, least in region["apart"]:
        sides = [(scene.gap(a, b, axis), scene.number(least)) for axis in "xy"]
        parts.append(some([scene.compare(far, abs(gap), size + far, False) for (gap, size), far in sides], scene.count))
    return every(parts, scene.count)
