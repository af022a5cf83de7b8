"""Random regions: the start region, narrow ones, degenerate ones, with differences and distances, now and then empty.

Does: draws a region as plain data, writes it as a table of a property file.
Assumes: a profile that says which coordinates are observed.
Does not: decide whether a region is empty.
"""

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

import numpy as np

from codegen.ir import AgentPolicy, FeatureSpec, PolicyProfile
from verify.claims.region_files import everywhere

ODD = (Fraction(1, 3), Fraction(1, 10), Fraction(-7, 10), Fraction(1, 7))
TRIES = 12
TINY = (Fraction(1, 2**20), Fraction(1, 2**40), Fraction(1, 10**9))


def drawn(rng: np.random.Generator, profile: PolicyProfile, team: str, edgy: float = 0.1) -> dict[str, Any]:
    """A region of a profile's world; with the chance `edgy` one where a test of the team just turns."""
    start = everywhere(profile)
    box = {name: (Fraction(low), Fraction(high)) for name, (low, high) in start.box.items()}
    kind = rng.random()
    goals = list(start.goals)
    if goals and rng.random() < 0.4:
        goals = [goals[int(rng.integers(len(goals)))]]
    found: dict[str, Any] = {"box": box, "differences": [], "apart": [], "goals": goals}
    if rng.random() < edgy:
        found["box"] = _edge(rng, profile, team, box, goals)
        return found
    if kind < 0.32:
        return found
    if kind < 0.62:
        found["box"] = _narrow(rng, box)
    elif kind < 0.8:
        found["box"] = _degenerate(rng, box)
    else:
        found["box"] = _around(rng, box)
    if rng.random() < 0.35:
        found["differences"] = _differences(rng, found["box"])
    if rng.random() < 0.25:
        found["apart"] = _apart(rng, found["box"])
    return found


def value(rng: np.random.Generator) -> Fraction:
    """A bound: of few binary digits, an odd fraction, or a float64 number."""
    kind = rng.random()
    if kind < 0.6:
        return Fraction(int(rng.integers(-16, 17)), 16)
    if kind < 0.7:
        return ODD[int(rng.integers(len(ODD)))]
    return Fraction(float(rng.uniform(-1, 1)))


def _narrow(rng: np.random.Generator, box: Mapping[str, Any]) -> dict[str, Any]:
    found = {}
    for name, bounds in box.items():
        low, high = sorted((value(rng), value(rng)))
        found[name] = (low, high) if rng.random() < 0.4 else bounds
    return found


def _around(rng: np.random.Generator, box: Mapping[str, Any]) -> dict[str, Any]:
    """Small intervals around a point."""
    half = Fraction(float(2.0 ** -float(rng.uniform(1, 12))))
    return {name: (middle - half, middle + half) for name in box for middle in [value(rng)]}


def _degenerate(rng: np.random.Generator, box: Mapping[str, Any]) -> dict[str, Any]:
    """Almost all coordinates fixed, most of them to float64 numbers; a free one on each axis, or on one."""
    found = {}
    for name in box:
        point = value(rng)
        found[name] = (point, point) if point.denominator & (point.denominator - 1) == 0 else (Fraction(0),) * 2
    for axis in ("x", "y")[: int(rng.integers(1, 3))]:
        names = [name for name in box if name.endswith(f".{axis}")]
        name = names[int(rng.integers(len(names)))]
        point = found[name][0]
        found[name] = box[name] if rng.random() < 0.6 else (point - TINY[int(rng.integers(3))], point + Fraction(1, 2))
    if rng.random() < 0.1:  # no float64 state is left
        name = list(box)[int(rng.integers(len(box)))]
        found[name] = (Fraction(1, 3), Fraction(1, 3))
    return found


def _edge(
    rng: np.random.Generator, profile: PolicyProfile, team: str, box: Mapping[str, Any], goals: list[str]
) -> dict[str, Any]:
    """A tiny region around a point at which a test on an agent's way just turns, or all but."""
    point = {name: Fraction(float(np.round(rng.uniform(-1, 1), int(rng.integers(1, 5))))) for name in box}
    policies = profile.team(team)
    policy = policies[int(rng.integers(len(policies)))]
    goal = goals[0] if goals else ""
    ways = _way(policy, point, goal)
    if ways:
        node = ways[int(rng.integers(len(ways)))]
        feature, threshold = policy.features[int(policy.tree.feature[node])], policy.tree.threshold[node]
        terms = _terms(feature, goal)
        weight, name = terms[int(rng.integers(len(terms)))]
        rest = sum((w * point.get(other, Fraction(0)) for w, other in terms), Fraction(0)) - weight * point[name]
        turn = Fraction(0) if feature.meaning and feature.meaning.function else Fraction(float(threshold))
        if name in point and abs(turn) < 4:
            point[name] = weight * (turn - rest) + int(rng.integers(-1, 2)) * Fraction(
                1, 2 ** int(rng.integers(25, 62))
            )
    halves = [Fraction(0), Fraction(1, 2 ** int(rng.integers(27, 60))), Fraction(1, 64)]
    kinds = rng.choice(3, len(point), p=[0.5, 0.4, 0.1])
    return {name: (value - halves[k], value + halves[k]) for (name, value), k in zip(point.items(), kinds, strict=True)}


def sliver(rng: np.random.Generator, profile: PolicyProfile, team: str) -> tuple[dict[str, Any], str, str] | None:
    """(region, agent, action): a region smaller than roundings, in one part of which an agent takes the action and in
    another part not, by a test that turns inside; None where none was found.
    """
    start = everywhere(profile)
    goals = [str(rng.choice(start.goals))] if start.goals else []
    for _ in range(TRIES):
        point = {name: Fraction(int(rng.integers(-64, 65)), 64) for name in start.box}
        policies = profile.team(team)
        policy = policies[int(rng.integers(len(policies)))]
        node = next(reversed(_way(policy, point, goals[0] if goals else "")), None)
        if node is None:
            continue
        feature, threshold = policy.features[int(policy.tree.feature[node])], float(policy.tree.threshold[node])
        weight, name = (terms := _terms(feature, goals[0] if goals else ""))[0]
        turn = Fraction(0) if feature.meaning and feature.meaning.function else Fraction(threshold)
        rest = sum((w * point[other] for w, other in terms), Fraction(0)) - weight * point[name]
        point[name] = weight * (turn - rest)
        half = Fraction(1, 2 ** int(rng.integers(27, 40)))
        sides = [
            _action(policy, point | {name: point[name] + side * half}, goals[0] if goals else "") for side in (-1, 1)
        ]
        if abs(turn) < 4 and sides[0] != sides[1]:
            box = {key: (value, value) for key, value in point.items()}
            box[name] = (point[name] - half, point[name] + half)
            action = policy.actions[sides[int(rng.integers(2))]].name
            return {"box": box, "differences": [], "apart": [], "goals": goals}, policy.agent, action
    return None


def _action(policy: AgentPolicy, point: Mapping[str, Fraction], goal: str) -> int:
    """What an agent does at a point in exact arithmetic."""
    return int(policy.tree.action[_walked(policy, point, goal)[-1]])


def _terms(feature: FeatureSpec, goal: str) -> list[tuple[int, str]]:
    assert feature.meaning is not None
    return [(weight, name.replace("goal.", f"{goal}.")) for weight, name in feature.meaning.terms]


def _walked(policy: AgentPolicy, point: Mapping[str, Fraction], goal: str) -> list[int]:
    """The nodes on an agent's way from a point, in exact arithmetic; coordinates that are left out are 0."""
    tree, found = policy.tree, [0]
    while tree.feature[found[-1]] >= 0:
        feature, threshold = policy.features[int(tree.feature[found[-1]])], float(tree.threshold[found[-1]])
        total = sum((weight * point.get(name, Fraction(0)) for weight, name in _terms(feature, goal)), Fraction(0))
        function = feature.meaning.function if feature.meaning else ""
        kinds = {"sign": (total > 0) - (total < 0), "positive": total > 0, "zero": total == 0}
        left = (kinds[function] if function else total) <= Fraction(threshold)
        found.append(int(tree.left[found[-1]] if left else tree.right[found[-1]]))
    return found


def _way(policy: AgentPolicy, point: Mapping[str, Fraction], goal: str) -> list[int]:
    """The splits on an agent's way from a point that coordinates of the point decide."""
    known = []
    for node in _walked(policy, point, goal)[:-1]:
        terms = _terms(policy.features[int(policy.tree.feature[node])], goal)
        known += [node] if terms and all(name in point for _, name in terms) else []
    return known


def _differences(rng: np.random.Generator, box: Mapping[str, Any]) -> list[Any]:
    axis = str(rng.choice(["x", "y"]))
    names = [name for name in box if name.endswith(f".{axis}")]
    a, b = (str(name) for name in rng.choice(names, 2, replace=False))
    low, high = box[a][0] - box[b][1], box[a][1] - box[b][0]
    ends = sorted(low + (high - low) * Fraction(int(rng.integers(0, 17)), 16) for _ in range(2))
    if rng.random() < 0.3:
        ends[1] = ends[0]
    return [(a, b, (ends[0], ends[1]))]


def _apart(rng: np.random.Generator, box: Mapping[str, Any]) -> list[Any]:
    entities = sorted({name[:-2] for name in box if name[-2] == "."})
    found = []
    for _ in range(int(rng.integers(1, 3))):
        a, b = (str(name) for name in rng.choice(entities, 2, replace=False))
        if all({a, b} != {one, other} for one, other, _ in found):
            found.append((a, b, Fraction(int(rng.integers(1, 13)), 10)))
    return found


def table(region: Mapping[str, Any]) -> str:
    """The region as an inline table of TOML."""
    box = ", ".join(f'"{name}" = ["{low}", "{high}"]' for name, (low, high) in region["box"].items())
    parts = [f"box = {{ {box} }}"]
    if region["goals"]:
        parts.append("goals = [" + ", ".join(f'"{goal}"' for goal in region["goals"]) + "]")
    if region["differences"]:
        rows = ", ".join(f'"{a} - {b}" = ["{low}", "{high}"]' for a, b, (low, high) in region["differences"])
        parts.append(f"difference = {{ {rows} }}")
    if region["apart"]:
        rows = ", ".join(f'"{a} - {b}" = "{least}"' for a, b, least in region["apart"])
        parts.append(f"apart = {{ {rows} }}")
    return "{ " + ", ".join(parts) + " }"
