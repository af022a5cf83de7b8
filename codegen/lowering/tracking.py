"""The lowered motion of a game: what follows a start of which something is proved, as long as all moves as stated.

Does: joins a lowered profile with the motion of its world, for monitors of claims about episodes.
Assumes: a checked profile of a world in which nobody pushes anybody and no speed has a limit.
Does not: know what is proved, or write text (codegen/targets/rendered.py).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from codegen import ir
from codegen.dynamics import accelerations, partners
from codegen.errors import InputError
from codegen.lowering.lower import region_of
from codegen.lowering.model import Agent, Double, Model, Place, Region
from codegen.world import RegionSpec

OFF = 2.0**-40  # by which a number may be off: proofs leave 2^-30 for all that adds up in an episode
MAX_OFF = 2.0**-32  # of a position: twice of a difference of two, and half of what proofs leave is for roundings
MAX_NOISE = 1.0  # beyond which nothing is near anything
MAX_STEPS = 100


@dataclass(frozen=True)
class Start:
    """Where episodes start of which something is proved, at rest, and whose actions count: of all others none does."""

    region: RegionSpec
    steps: int
    followed: frozenset[str]
    noise: float = 0.0  # by which each number that is given may be off


@dataclass(frozen=True)
class Edges:
    """Of which states something is proved for ever: a region, in which positions also have to be once each has moved by
    its velocity for `coasting` seconds: there agents come to rest that nobody pushes.
    """

    region: RegionSpec
    coasting: float


@dataclass(frozen=True)
class Tracked:
    """An agent: its positions, velocities, and what each of its actions adds to these, by axis."""

    agent: Agent
    number: int
    positions: tuple[Place, Place]
    velocities: tuple[Place, Place]
    pushes: tuple[tuple[Double, Double], ...]
    followed: bool


@dataclass(frozen=True)
class Track:
    """The check that a state follows from a start, by the motion of the world."""

    kind: ClassVar = "episode"
    count: ClassVar = "N_COORDINATES"  # the name of how many numbers a state has
    counted: ClassVar = True  # whether steps are counted since the start

    region: Region  # of the starts
    last: int  # step of the proof, from 0
    agents: tuple[Tracked, ...]
    still: tuple[Place, ...]  # what does not move
    kept: Double  # the share of a velocity that is left after a step
    off: Double
    dt: float
    noise: float  # 0: states are followed; else an episode of the proof that is near them
    near: float  # how far, for each number
    clamped: tuple[tuple[Place, Double, Double], ...]  # what the region bounds by numbers
    goal: tuple[Place, Place] | None
    goals: tuple[tuple[Place, Place], ...]  # where it may be

    @property
    def comparisons(self) -> int:
        """The most that one step takes."""
        both = 4 if self.noise else 16  # axes; also whether anything moves an agent along them
        moved = sum(both * (1 + len(each.pushes)) for each in self.agents) + 2 * len(self.still)
        begun = self.region.comparisons + 4 * len(self.agents)
        numbers = len(self.still) + 4 * len(self.agents)
        near = 2 * numbers + 2 * len(self.region.bounds) + 4 * len(self.region.goals)
        return max(moved, begun) + (near if self.noise else 0)

    def bound_coordinates(self, start: Mapping[str, tuple[float, float]]) -> dict[str, tuple[float, float]]:
        """Between which numbers each coordinate stays that starts between these, whatever agents do; all start at
        rest. By upper-case name.
        """
        bounds = {place.upper: start[place.upper] for place in self.still if place.upper in start}
        for each in self.agents:
            for axis, (place, speed) in enumerate(zip(each.positions, each.velocities, strict=True)):
                push = max(abs(float(pushes[axis].decimal)) for pushes in each.pushes)
                # a velocity is at most the sum of all pushes, twice for what rounding adds
                most = 2.0 * self.last * (push + OFF)
                bounds[speed.upper] = -most, most
                if place.upper in start:
                    low, high = start[place.upper]
                    far = 2.0 * self.last * (self.dt * most + OFF)
                    bounds[place.upper] = low - far, high + far
        return {upper: (low - self.near, high + self.near) for upper, (low, high) in bounds.items()}


def ensure_followed(world: ir.WorldSpec, steps: int) -> None:
    """InputError for worlds whose motion is not followed, and for episodes in which too much may add up."""
    if partners(world) or any(agent.max_speed is not None for agent in world.agents):
        what = "the proof is about episodes in which agents push each other or have a speed limit"
        why = "where agents push, what a number is off by grows more than the room that proofs leave for it"
        raise InputError(f"{what}: {why}", "--certificate", "take a certificate about decisions: it holds in any state")
    off = velocity = 0.0  # of a position and a velocity from those of an episode of the proof, each number being off
    for _ in range(min(steps, MAX_STEPS)):
        off += abs(world.dt) * velocity + OFF
        velocity = abs(1.0 - world.damping) * velocity + OFF
    if steps > MAX_STEPS or off > MAX_OFF:
        what = f"the proof is about {steps} steps, in which too much adds up"
        advice = f"a monitor follows at most {MAX_STEPS} steps, fewer where steps are long or nothing damps"
        raise InputError(what, "--certificate", advice)


def track(profile: ir.PolicyProfile, model: Model, start: Start) -> Track:
    """Returns how a profile's world moves after a start. InputError as `ensure_followed`."""
    ensure_followed(profile.world, start.steps)
    world, places = profile.world, {place.name: place for place in model.places.values()}
    agents: list[Tracked] = []
    for number, policy in enumerate(profile.agents):
        (entity,) = (one for one in world.agents if one.name == policy.agent)
        added = accelerations(entity, policy.actions) * world.dt
        pushes = tuple((Double.of(x), Double.of(y)) for x, y in added.tolist())
        x, y, vx, vy = (places[f"{policy.agent}.{axis}"] for axis in ("x", "y", "vx", "vy"))
        followed = policy.agent in start.followed
        agents.append(Tracked(model.agents[number], number, (x, y), (vx, vy), pushes, followed))
    moving = {place.upper for each in agents for place in (*each.positions, *each.velocities)}
    still = tuple(place for upper, place in model.places.items() if upper not in moving)
    region = region_of(start.region)
    near = max(OFF, 2.0 * start.noise)
    return Track(
        region=region,
        last=start.steps,
        agents=tuple(agents),
        still=still,
        kept=Double.of(1.0 - world.damping),
        off=Double.of(near),
        dt=world.dt,
        noise=start.noise,
        near=near,
        clamped=tuple((model.places[one], low, high) for one, other, low, high in region.bounds if not other),
        goal=_axes(model, "GOAL") if region.goals else None,
        goals=tuple(_axes(model, name) for name in region.goals),
    )


def _axes(model: Model, name: str) -> tuple[Place, Place]:
    return model.places[f"{name}_X"], model.places[f"{name}_Y"]
