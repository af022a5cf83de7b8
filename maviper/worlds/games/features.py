"""What agents may observe: the features that games are made of, and groups of further ones that a user may add.

Does: offsets, own position and velocity; groups derived from what an agent observes already, or from its own sensors.
Assumes: mpe2's dynamics (for the ranges).
Does not: observe; a feature is a meaning, read by `codegen.observe`.
"""

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from codegen.dynamics import step_position, step_velocity
from codegen.errors import InputError, UnknownNameError
from codegen.ir import GOAL, WEIGHTS, FeatureSpec, Meaning, WorldSpec

SEPARATOR = "+"  # between groups in an option
COASTING = "coasting"


def relative(other: str, agent: str, spec: WorldSpec) -> list[FeatureSpec]:
    """Two features: where another entity is, seen from an agent."""
    reach = farthest(spec)
    moves = {entity.name for entity in spec.agents}
    bound = 2.0 + (2 * reach if other in moves else reach)
    meanings = [(axis, Meaning(((1, f"{other}.{axis}"), (-1, f"{agent}.{axis}")))) for axis in "xy"]
    return [FeatureSpec(f"{other}_d{axis}", "length", -bound, bound, meaning) for axis, meaning in meanings]


def own(agent: str, spec: WorldSpec) -> dict[str, list[FeatureSpec]]:
    """An agent's own `position` and `velocity`, two features each."""
    reach = 1.0 + farthest(spec)
    speed = top_speed(spec)
    position = [FeatureSpec(axis, "length", -reach, reach, Meaning(((1, f"{agent}.{axis}"),))) for axis in "xy"]
    return {"position": position, "velocity": velocity(agent, "", speed)}


def velocity(agent: str, prefix: str, speed: float) -> list[FeatureSpec]:
    """Two features: an agent's velocity."""
    return [
        FeatureSpec(f"{prefix}v{axis}", "length/s", -speed, speed, Meaning(((1, f"{agent}.v{axis}"),))) for axis in "xy"
    ]


def top_speed(spec: WorldSpec) -> float:
    """The highest speed along one axis that actions lead to, rounded up to a tenth; contacts may exceed it."""
    free = max(entity.force for entity in spec.agents) * spec.dt / spec.damping
    limits = [entity.max_speed for entity in spec.agents]
    return float(np.ceil(10 * max(limit for limit in limits if limit) if all(limits) else 10 * free) / 10)


def farthest(spec: WorldSpec) -> float:
    """Returns the distance an agent can travel from rest in an episode along one axis, rounded up to a tenth.

    Contacts can add to it: a range says what actions reach, and nothing depends on it but pictures and regions.
    """
    place = speed = 0.0
    limit, force = top_speed(spec), max(entity.force for entity in spec.agents)
    for _ in range(spec.episode_steps):
        place, speed = step_position(spec, place, speed), min(limit, step_velocity(spec, speed, force))
    return float(np.ceil(place * 10) / 10)


# --- groups that a user may add


def extend_features(
    features: Sequence[FeatureSpec], chosen: str, agent: str, mates: Sequence[str], spec: WorldSpec
) -> tuple[FeatureSpec, ...]:
    """An agent's features with those of the groups in `chosen`, without what it observes already."""
    all_features = list(features)
    for name in groups_of(chosen):
        known = {feature.meaning for feature in all_features}
        all_features += [
            feature for feature in GROUPS[name](features, agent, mates, spec) if feature.meaning not in known
        ]
    return tuple(all_features)


def groups_of(chosen: str) -> list[str]:
    """The groups that an option names; UnknownNameError, or InputError where one is named twice."""
    names = chosen.split(SEPARATOR) if chosen else []
    for name in names:
        if name not in GROUPS:
            raise UnknownNameError("group of features", name, GROUPS, "features")
        if names.count(name) > 1:
            raise InputError(f"the features '{name}' are named twice", "features", "name them once")
    return names


def _velocity(features: Sequence[FeatureSpec], agent: str, mates: Sequence[str], spec: WorldSpec) -> list[FeatureSpec]:
    """The agent's own velocity: a sensor that mpe2's deception does not have."""
    del features, mates
    return own(agent, spec)["velocity"]


def _goal(features: Sequence[FeatureSpec], agent: str, mates: Sequence[str], spec: WorldSpec) -> list[FeatureSpec]:
    """Returns features that mark the goal, for agents that observe it: 1 for it, 0 for others; the last follows."""
    del mates
    if f"{GOAL}.x" not in dict(_offsets(features, agent)):
        return []
    return [
        FeatureSpec(f"goal_is_{name}", "none", 0.0, 1.0, Meaning(((1, f"{GOAL}.x"), (-1, f"{name}.x")), "zero"))
        for name in spec.goals[:-1]
    ]


def _differences(
    features: Sequence[FeatureSpec], agent: str, mates: Sequence[str], spec: WorldSpec
) -> list[FeatureSpec]:
    """Differences between observed offsets along an axis: where one entity is, seen from another."""
    del mates, spec
    differences: list[FeatureSpec] = []
    for (of_a, a), (of_b, b) in combinations(_offsets(features, agent), 2):
        if of_a[-2:] == of_b[-2:]:
            name = f"{of_a[:-2]}_{of_b[:-2]}_d{of_a[-1]}"
            meaning = Meaning(((1, of_a), (-1, of_b)))
            differences.append(FeatureSpec(name, a.unit, a.low - b.high, a.high - b.low, meaning))
    return differences


def _signs(features: Sequence[FeatureSpec], agent: str, mates: Sequence[str], spec: WorldSpec) -> list[FeatureSpec]:
    """The signs of observed offsets of team-mates."""
    del spec
    places = {f"{mate}.{axis}" for mate in mates for axis in "xy"}
    return [
        FeatureSpec(f"{feature.name}_sign", "sign", -1.0, 1.0, Meaning(feature.meaning.terms, "sign"))
        for offset, feature in _offsets(features, agent)
        if feature.meaning and offset in places
    ]


def _ahead(features: Sequence[FeatureSpec], agent: str, mates: Sequence[str], spec: WorldSpec) -> list[FeatureSpec]:
    """Sums and differences of both axes of an observed offset: their signs say which axis is ahead, and which way."""
    del mates, spec
    places = dict(_offsets(features, agent))
    return [
        each
        for place, x in places.items()
        if place.endswith(".x") and f"{place[:-1]}y" in places
        for each in _diagonals(place[:-2], x, places[f"{place[:-1]}y"])
    ]


def _diagonals(name: str, x: FeatureSpec, y: FeatureSpec) -> list[FeatureSpec]:
    """The sum and the difference of two features."""
    assert x.meaning and y.meaning
    less = tuple((-weight, coordinate) for weight, coordinate in y.meaning.terms)
    plus = Meaning(x.meaning.terms + y.meaning.terms)
    return [
        FeatureSpec(f"{name}_dx_plus_dy", x.unit, x.low + y.low, x.high + y.high, plus),
        FeatureSpec(f"{name}_dx_less_dy", x.unit, x.low - y.high, x.high - y.low, Meaning(x.meaning.terms + less)),
    ]


def _coasting(features: Sequence[FeatureSpec], agent: str, mates: Sequence[str], spec: WorldSpec) -> list[FeatureSpec]:
    """Observed offsets of what the agent may make for, as they will be once it has come to rest without a push: both
    axes, their sum and their difference. Team-mates' are left out.
    """
    places = dict(_offsets(features, agent))
    coasting: list[FeatureSpec] = []
    if not spec.damping:  # nothing ever comes to rest
        return coasting
    for entity in (entity.name for entity in (*spec.landmarks, *spec.agents) if entity.name not in mates):
        if {f"{entity}.{axis}" for axis in "xy"} <= places.keys():
            ends = [_at_rest(places[f"{entity}.{axis}"], agent, axis, spec) for axis in "xy"]
            coasting += [*ends, *_diagonals(f"{entity}_rest", *ends)]
    return coasting


def _at_rest(offset: FeatureSpec, agent: str, axis: str, spec: WorldSpec) -> FeatureSpec:
    """An offset less the way that an agent still coasts, which takes dt / damping seconds at its present speed."""
    assert offset.meaning
    time = spec.dt / spec.damping
    # two weights of terms, whose sum comes near to the time from below
    first = max((weight for weight in WEIGHTS if weight <= time), default=WEIGHTS[0])
    weights = first, max((weight for weight in WEIGHTS if weight <= time - first), default=WEIGHTS[0])
    coasted = tuple((-weight, f"{agent}.v{axis}") for weight in weights)
    reach = top_speed(spec) * sum(weights)
    name = f"{offset.name.removesuffix(f'_d{axis}')}_rest_d{axis}"
    return FeatureSpec(
        name, offset.unit, offset.low - reach, offset.high + reach, Meaning(offset.meaning.terms + coasted)
    )


def _offsets(features: Sequence[FeatureSpec], agent: str) -> list[tuple[str, FeatureSpec]]:
    """The features that are offsets from the agent, each behind the coordinate whose offset it is."""
    offsets: list[tuple[str, FeatureSpec]] = []
    for feature in features:
        match feature.meaning:
            case Meaning(((1, other), (-1, own_)), "") if own_ == f"{agent}{other[-2:]}":
                offsets.append((other, feature))
            case _:
                pass
    return offsets


GROUPS = {
    "velocity": _velocity,
    "goal": _goal,
    "differences": _differences,
    "signs": _signs,
    "ahead": _ahead,
    COASTING: _coasting,
}
DERIVED = ("goal", "differences", "signs")  # from what an agent observes already, by two coordinates each
