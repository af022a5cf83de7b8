"""World states: points with names, batches of them, and what a team does there.

Does: evaluates a property exactly in one float64 world state (the referee), and over batches for shares.
Assumes: positions are finite float64; observations are made by `codegen.observe`.
Does not: search for world states.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np

from codegen import ir
from codegen.errors import InputError
from codegen.ir import Bool, Float32, Float64, Int32, PolicyProfile
from codegen.observe import observe
from verify.formula import Batch, Formula, for_goal, holds, worth
from verify.properties import Property, engaged, formula
from verify.spec import Region, start_region


@dataclass(frozen=True)
class Point:
    """One world state: coordinates (velocities that are left out are zero) and the goal landmark ("" without one).

    `errors`: by how much a feature is off as an agent measures it, by `error_name`; what is left out is exact.
    """

    position: Mapping[str, float]
    goal: str
    errors: Mapping[str, float] = field(default_factory=dict)

    def coordinates(self, profile: PolicyProfile) -> Float64:
        """All world coordinates in the world's order, [1, n_coordinates]."""
        world = profile.world
        values = dict.fromkeys(world.coordinates(), 0.0) | dict(self.position)
        if self.goal:
            values |= {f"goal.{axis}": self.position[f"{self.goal}.{axis}"] for axis in "xy"}
        return np.array([[values[name] for name in world.coordinates()]])


def verifiable(profile: PolicyProfile, team: str) -> tuple[ir.AgentPolicy, ...]:
    """The team's policies; InputError when a claim about world states cannot be made for them."""
    subnormal = np.finfo(np.float32).tiny
    for policy in profile.team(team):
        for feature in policy.features:
            if feature.meaning is None:
                raise InputError(
                    f"feature {feature.name} of {policy.agent} has no meaning", "", "claims need every meaning"
                )
        for action in policy.actions:
            if action.effect is None:
                raise InputError(
                    f"action {action.name} of {policy.agent} has no effect", "", "claims need every effect"
                )
        tiny = (policy.tree.threshold != 0) & (np.abs(policy.tree.threshold) < subnormal)
        for node in np.flatnonzero(tiny):
            raise InputError(
                f"node {node} of {policy.agent} has a subnormal threshold",
                "",
                "processors may flush such numbers to zero; round the threshold to 0 or to a normal number",
            )
    return profile.team(team)


def observed_velocities(profile: PolicyProfile) -> tuple[str, ...]:
    """The velocity coordinates that some agent observes, in the world's order."""
    meanings = [feature.meaning for policy in profile.agents for feature in policy.features if feature.meaning]
    seen = {name for meaning in meanings for _, name in meaning.terms}
    return tuple(name for name in profile.world.coordinates() if name in seen and name.endswith((".vx", ".vy")))


def everywhere(profile: PolicyProfile) -> Region:
    """The start region of a profile: every start position, any goal, every observed velocity that actions can cause."""
    return start_region(profile.world, observed_velocities(profile))


def error_name(agent: str, feature: str) -> str:
    """The name of the error of one feature as one agent measures it; no coordinate has a colon."""
    return f"{agent}:{feature}"


def measurable(meaning: ir.Meaning) -> bool:
    """Whether a feature is measured, and so may be off: what is constant, or says that two things are equal, is not."""
    return bool(meaning.terms) and meaning.function != "zero"


def observed(profile: PolicyProfile, policy: ir.AgentPolicy, point: Point) -> Float32:
    """What an agent observes in a world state, errors included, [1, n_features].

    An error is added to the exact coordinate or difference; then float64, the feature's function and float32 follow
    as without it.
    """
    coordinates = point.coordinates(profile)
    seen = observe(policy.features, coordinates, profile.world)
    at = dict(zip(profile.world.coordinates(), coordinates[0], strict=True))
    for place, feature in enumerate(policy.features):
        error = point.errors.get(error_name(policy.agent, feature.name), 0.0)
        if error and feature.meaning is not None and measurable(feature.meaning):
            exact = sum((weight * Fraction(float(at[name])) for weight, name in feature.meaning.terms), Fraction(error))
            function = feature.meaning.function
            value = {"": exact, "sign": (exact > 0) - (exact < 0), "positive": int(exact > 0)}[function]
            seen[0, place] = np.float32(float(value))
    return seen


def chosen(policy: ir.AgentPolicy, coordinates: Float64, world: ir.WorldSpec) -> Int32:
    """The actions of one agent in a batch of world states, by the reference semantics. [batch]"""
    return ir.act(policy, observe(policy.features, coordinates, world))


def violates(profile: PolicyProfile, claim: Property, point: Point) -> bool:
    """The referee: whether `claim` fails in this float64 world state, with exact arithmetic for the claim itself."""
    return not _true(profile, formula(profile, claim), point, _actions(profile, claim, point))


def shortfall(profile: PolicyProfile, claim: Property, point: Point) -> Fraction | float:
    """By how much `claim` fails in a world state that violates it, exact: the least s such that, actions as they are,
    it would hold with each bound of its inequalities relaxed by more than s. Infinite when no relaxing would do.

    In the unit of the bounds, which is a length for the built-in properties. It is the value of the claim in the usual
    quantitative semantics (`formula.worth`) without its sign.
    """
    stated = for_goal(formula(profile, claim), point.goal)
    return -worth(stated, _exactly(profile, point), _actions(profile, claim, point))


def engaged_with(profile: PolicyProfile, claim: Property, point: Point) -> dict[str, tuple[str, ...]]:
    """Agent -> the landmarks that it is engaged with in a world state, exactly."""
    actions = _actions(profile, claim, point)
    return {
        policy.agent: tuple(
            landmark.name
            for landmark in profile.world.landmarks
            if _true(profile, engaged(policy, landmark.name, claim), point, actions)
        )
        for policy in profile.team(claim.team)
    }


def _actions(profile: PolicyProfile, claim: Property, point: Point) -> dict[str, int]:
    return {
        policy.agent: int(ir.act(policy, observed(profile, policy, point))[0]) for policy in profile.team(claim.team)
    }


def _true(profile: PolicyProfile, asked: Formula, point: Point, actions: Mapping[str, int]) -> bool:
    return holds(for_goal(asked, point.goal), _exactly(profile, point), actions)


def _exactly(profile: PolicyProfile, point: Point) -> dict[str, Fraction]:
    values = zip(profile.world.coordinates(), point.coordinates(profile)[0], strict=True)
    return {name: Fraction(float(value)) for name, value in values}


def inside(region: Region, point: Point) -> bool:
    """Whether a point lies in a region, exactly."""
    at = {name: Fraction(value) for name, value in point.position.items()}
    if region.goals and point.goal not in region.goals:
        return False
    if any(not low <= at[name] <= high for name, (low, high) in region.box.items()):
        return False
    if any(not low <= at[a] - at[b] <= high for a, b, (low, high) in region.differences):
        return False
    return all(max(abs(at[f"{a}.{axis}"] - at[f"{b}.{axis}"]) for axis in "xy") >= d for a, b, d in region.apart)


def nearest(model: Mapping[str, Fraction], region: Region, goal: str, eps: Fraction = Fraction(0)) -> Point:
    """The float64 point nearest to an exact one, each value rounded towards the inside of its interval.

    `model`: every coordinate of the region, and errors by `error_name`, at most `eps`.
    """
    values: dict[str, float] = {}
    for name, value in model.items():
        low, high = region.box.get(name, (-eps, eps))
        near = float(value)
        if Fraction(near) > high:
            near = math.nextafter(near, -math.inf)
        elif Fraction(near) < low:
            near = math.nextafter(near, math.inf)
        values[name] = near
    errors = {name: value for name, value in values.items() if name not in region.box and value}
    return Point({name: values[name] for name in region.box}, goal, errors)


# --- batches, for shares: float64 arithmetic, which can only misjudge states within a rounding of a boundary


def contains(region: Region, coordinates: Float64, world: ir.WorldSpec) -> Bool:
    """Which world states of a batch lie in a region's box, differences and distances (goals aside), [batch]."""
    at = {name: coordinates[:, place] for place, name in enumerate(world.coordinates())}
    within = np.ones(len(coordinates), dtype=bool)
    for name, (low, high) in region.box.items():
        within &= (at[name] >= float(low)) & (at[name] <= float(high))
    for a, b, (low, high) in region.differences:
        within &= (at[a] - at[b] >= float(low)) & (at[a] - at[b] <= float(high))
    for a, b, least in region.apart:
        gaps = [np.abs(at[f"{a}.{axis}"] - at[f"{b}.{axis}"]) for axis in "xy"]
        within &= np.maximum(*gaps) >= float(least)
    return within


def sample(region: Region, world: ir.WorldSpec, count: int, seed: int) -> tuple[Float64, Int32]:
    """Uniform world states of a region: coordinates [n, n_coordinates] and goals [n] (landmark indices).

    At most `count`: states outside the region's differences and distances are drawn and dropped.
    """
    rng = np.random.default_rng(seed)
    names = world.coordinates()
    coordinates = np.zeros((count, len(names)))
    for name, (low, high) in region.box.items():
        coordinates[:, names.index(name)] = rng.uniform(float(low), float(high), count)
    landmarks = [entity.name for entity in world.landmarks]
    allowed = np.array([landmarks.index(goal) for goal in region.goals] or [0], dtype=np.int32)
    goal = allowed[rng.integers(len(allowed), size=count)]
    if region.goals:
        for axis in "xy":
            columns = np.array([names.index(f"{landmark}.{axis}") for landmark in landmarks])
            coordinates[:, names.index(f"goal.{axis}")] = coordinates[np.arange(count), columns[goal]]
    within = contains(region, coordinates, world)
    return coordinates[within], goal[within]


def point_of(region: Region, world: ir.WorldSpec, coordinates: Float64, goal: int) -> Point:
    """One sampled world state (a row [n_coordinates] and its goal's index) as a point of the region."""
    names = world.coordinates()
    position = {name: float(coordinates[names.index(name)]) for name in region.box}
    return Point(position, world.landmarks[goal].name if region.goals else "")


def batch(coordinates: Float64, world: ir.WorldSpec) -> Batch:
    """Formulas over a batch of world states."""
    return Batch(dict(zip(world.coordinates(), coordinates.T, strict=True)), len(coordinates))
