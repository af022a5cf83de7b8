"""World states: points with names, batches of them, and what a team does there.

Does: evaluates a property exactly in one float64 world state (the referee), and over batches for shares.
Assumes: positions are finite float64; observations are made by `codegen.observe`.
Does not: search for world states.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from codegen import ir
from codegen.errors import InputError
from codegen.ir import Bool, Float64, Int32, PolicyProfile
from codegen.observe import observe
from verify.matching import matched
from verify.spec import Property, Region, positions


@dataclass(frozen=True)
class Point:
    """One world state at rest: every position (coordinate -> length) and the goal landmark ("" without one)."""

    position: Mapping[str, float]
    goal: str

    def coordinates(self, profile: PolicyProfile) -> Float64:
        """All world coordinates in the world's order, [1, n_coordinates]; velocities are zero."""
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


def chosen(policy: ir.AgentPolicy, coordinates: Float64, world: ir.WorldSpec) -> Int32:
    """The actions of one agent in a batch of world states, by the reference semantics. [batch]"""
    return ir.act(policy, observe(policy.features, coordinates, world))


def violates(profile: PolicyProfile, claim: Property, point: Point) -> bool:
    """The referee: whether `claim` fails in this float64 world state, with exact arithmetic for the claim itself."""
    team = profile.team(claim.team)
    coordinates = point.coordinates(profile)
    actions = [int(chosen(policy, coordinates, profile.world)[0]) for policy in team]
    return not bool(matched(engaged_exactly(profile, claim, point, actions)))


def engaged_exactly(profile: PolicyProfile, claim: Property, point: Point, actions: list[int]) -> Bool:
    """Who is engaged with which landmark, [n_agents, n_landmarks], in rational arithmetic."""
    team, landmarks = profile.team(claim.team), profile.world.landmarks
    engaged = np.zeros((len(team), len(landmarks)), dtype=bool)
    for i, policy in enumerate(team):
        effect = policy.actions[actions[i]].effect or (0.0, 0.0)
        for k, landmark in enumerate(landmarks):
            offset = [
                Fraction(point.position[f"{landmark.name}.{axis}"]) - Fraction(point.position[f"{policy.agent}.{axis}"])
                for axis in "xy"
            ]
            ahead = sum((Fraction(part) * gap for part, gap in zip(effect, offset, strict=True)), Fraction(0))
            engaged[i, k] = ahead > claim.margin or max(abs(gap) for gap in offset) <= claim.radius
    return engaged


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
    """Uniform world states of a region at rest: coordinates [n, n_coordinates] and goals [n] (landmark indices).

    At most `count`: states outside the region's differences and distances are drawn and dropped.
    """
    rng = np.random.default_rng(seed)
    names = world.coordinates()
    coordinates = np.zeros((count, len(names)))
    for name in positions(world):
        low, high = region.box[name]
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


def offsets(profile: PolicyProfile, claim: Property, coordinates: Float64) -> Float64:
    """Landmark minus agent, [batch, n_agents, n_landmarks, 2]."""
    index = {name: place for place, name in enumerate(profile.world.coordinates())}
    agents = [[index[f"{policy.agent}.{axis}"] for axis in "xy"] for policy in profile.team(claim.team)]
    landmarks = [[index[f"{entity.name}.{axis}"] for axis in "xy"] for entity in profile.world.landmarks]
    return coordinates[:, None, landmarks] - coordinates[:, agents][:, :, None]


def effects(profile: PolicyProfile, claim: Property) -> Float64:
    """Directions of all actions, [n_agents, most actions, 2]; agents with fewer actions are padded with zeros."""
    team = profile.team(claim.team)
    directions = np.zeros((len(team), max(len(policy.actions) for policy in team), 2))
    for agent, policy in enumerate(team):
        directions[agent, : len(policy.actions)] = [action.effect for action in policy.actions]
    return directions


def possible(profile: PolicyProfile, claim: Property, coordinates: Float64) -> tuple[Bool, Bool]:
    """For every action: (engaged, closes), each [batch, n_agents, n_actions, n_landmarks]."""
    gap = offsets(profile, claim, coordinates)
    closes = np.einsum("nad,bakd->bank", effects(profile, claim).transpose(1, 0, 2), gap) > float(claim.margin)
    at = (np.abs(gap).max(axis=3) <= float(claim.radius))[:, :, None, :]
    return closes | at, closes
