"""The world that a profile was learned in: entities, variables, and how they move; the states that it is meant for.

Does: frozen data, and the names of all coordinates; the region of a profile that is not meant for all states.
Assumes: lengths are in the world's own unit; coordinates of a region are named as in the world's spec.
Does not: move anything (dynamics.py), judge numbers (check.py), check states (boxes.py), or prove anything about a
  region (the verifier does).
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from types import MappingProxyType
from typing import Final

GOAL: Final = "goal"  # in coordinates: the landmark that is the goal


@dataclass(frozen=True)
class EntitySpec:
    """An agent or a landmark: `force` is the acceleration of a unit action (length / s^2), 0 for what cannot move."""

    name: str
    size: float  # radius
    force: float
    max_speed: float | None  # length / s
    collides: bool
    start: tuple[float, float] | None = None  # bounds of its start position on each axis; None: the world's


@dataclass(frozen=True)
class VariableSpec:
    """A coordinate that belongs to no entity, such as an angle, and what it ranges over (in `unit`)."""

    name: str  # such as "angle", or "agent_0.angle"
    unit: str
    low: float
    high: float


@dataclass(frozen=True)
class WorldSpec:
    """The world that a profile was learned in: its entities and dynamics.

    A step of `dt` seconds moves every position with the old velocity, then damps the velocity by the share `damping`,
    adds dt * (force * effect of the action + contacts) and cuts the speed at `max_speed`. Entities that collide push
    each other apart by contact_force * contact_margin * log(1 + exp(overlap / contact_margin)). Episodes start at rest,
    uniform in [start_low, start_high], and last `episode_steps` steps. `options` make this variant of the game.
    """

    name: str
    reference: str  # the environment that is the truth, e.g. "mpe2.simple_adversary_v3"
    agents: tuple[EntitySpec, ...]
    landmarks: tuple[EntitySpec, ...]
    goals: tuple[str, ...]  # landmarks that the coordinates "goal.x", "goal.y" may stand for; empty: no goal
    dt: float
    damping: float
    start_low: float
    start_high: float
    episode_steps: int
    contact_force: float = 0.0
    contact_margin: float = 0.0
    options: Mapping[str, int | str] = field(default_factory=lambda: MappingProxyType({}))
    variables: tuple[VariableSpec, ...] = ()

    def coordinates(self) -> tuple[str, ...]:
        """Names of all coordinates: positions of agents, landmarks and the goal, agents' velocities, variables."""
        return self._coordinates

    @cached_property
    def _coordinates(self) -> tuple[str, ...]:
        places = [entity.name for entity in self.agents + self.landmarks] + ([GOAL] if self.goals else [])
        position = [f"{name}.{axis}" for name in places for axis in "xy"]
        velocity = [f"{agent.name}.v{axis}" for agent in self.agents for axis in "xy"]
        return (*position, *velocity, *(variable.name for variable in self.variables))


@dataclass(frozen=True)
class RegionSpec:
    """A region as a file states it: numbers are exact text, decimals or fractions; differences are named `a - b`."""

    goals: tuple[str, ...]  # landmarks that may be the goal; empty: the world has no goal
    box: Mapping[str, tuple[str, str]]
    difference: Mapping[str, tuple[str, str]] = field(default_factory=lambda: MappingProxyType({}))
    apart: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))


def round_up(value: Fraction) -> float:
    """The smallest double not below a number."""
    near = float(value)
    return near if Fraction(near) >= value else math.nextafter(near, math.inf)
