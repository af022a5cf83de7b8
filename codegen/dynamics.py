"""One step of a world: how actions, contacts, damping and speed limits move its entities, as in mpe2; and, for play
alone, as in the fork that MAVIPER's authors released.

Does: steps batches of states in float64, operation by operation as mpe2 does; says who may push whom, how strongly;
  the spec of a world whose motion nobody stated.
Assumes: a checked world spec.
Does not: serve proofs. The engine for episodes (verify/episodes) and its checker (verify/checker/episodes/reading.py)
  each read the world spec for themselves, and bound their roundings for themselves. Neither may trust the other, nor
  this module, with which the simulator and the verifier's referee step.
"""

from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from codegen.ir import MAX_LENGTH, ActionSpec, EntitySpec, Float64, WorldSpec

MPE2 = "mpe2"  # of the option PHYSICS of a world, which may be FORK instead
COINCIDENT = 1e-150  # centres so near to one another count as one place
Number = TypeVar("Number", float, Float64)

PUSHING_MARGINS = 746  # farther apart nobody pushes: exp(-746) is 0 in float64
PUSHED_AT_ONCE = 1_000  # in so many games all pairs are pushed at once; in more, one after the other is quicker
NEGLIGIBLE_MARGINS = 40  # farther apart a push is below 1e-17


def contact_force(
    world: WorldSpec, dx: Float64, dy: Float64, touching: float | Float64, margins: float = PUSHING_MARGINS
) -> tuple[npt.NDArray[np.int64], Float64]:
    """The contact force on the first of two entities that touch at a distance, one for all rows or [batch]. `dx`, `dy`:
    [batch] its gaps from the other.

    Returns the rows in which there is one, of entities at most so many `margins` beyond touching, and the force
    [2, rows], operation by operation as in mpe2.
    """
    reach = touching + margins * world.contact_margin
    squared = dx * dx + dy * dy
    near = np.flatnonzero((squared < reach * reach) & (squared > 0))
    distance = np.sqrt(squared[near])
    sizes = touching[near] if isinstance(touching, np.ndarray) else touching
    overlap = np.logaddexp(0, -(distance - sizes) / world.contact_margin) * world.contact_margin
    force = [world.contact_force * gap / distance * overlap for gap in (dx[near], dy[near])]
    return near, np.array(force).reshape(2, len(near))


def partners(world: WorldSpec) -> list[tuple[int, int, float]]:
    """Pairs of entities that may push each other, agents before landmarks, with the distance at which they touch."""
    if not world.contact_force:
        return []
    pairs = combinations(enumerate(world.agents + world.landmarks), 2)
    movable = len(world.agents)
    return [(i, j, a.size + b.size) for (i, a), (j, b) in pairs if a.collides and b.collides and i < movable]


def step_position(world: WorldSpec, place: Number, speed: Number) -> Number:
    """Where a step leads: positions move with the old velocity."""
    return place + speed * world.dt


def step_velocity(world: WorldSpec, speed: Number, push: Number) -> Number:
    """The velocity after a step, before any speed limit. `push`: the acceleration, length / s^2."""
    return speed * (1.0 - world.damping) + push * world.dt


def accelerations(entity: EntitySpec, actions: Sequence[ActionSpec]) -> Float64:
    """[n_actions, 2]: the acceleration that each action gives an entity; 0 for an action without an effect."""
    return np.array([action.effect or (0.0, 0.0) for action in actions]) * entity.force


class Motion:
    """The steps of one world, bit for bit those of mpe2. `actions`: those of each agent, in the order of the world's.

    `quick`: pushes below 1e-17 are left out, as in play by thousands, which then takes half the time. They decide where
    an agent that rests sees an offset of exactly 0 and tests its sign. `velocity_first`: positions move with the new
    velocity, as in the authors' fork.

    Arrays are contiguous planes: positions [n_entities, 2, batch], velocities [n_agents, 2, batch].
    """

    def __init__(
        self,
        world: WorldSpec,
        actions: Sequence[Sequence[ActionSpec]],
        quick: bool = False,
        velocity_first: bool = False,
    ) -> None:
        self._world, self._margins = world, NEGLIGIBLE_MARGINS if quick else PUSHING_MARGINS
        self._velocity_first = velocity_first
        self._chosen = [
            np.ascontiguousarray(accelerations(entity, choices).T)
            for entity, choices in zip(world.agents, actions, strict=True)
        ]
        self._partners = partners(world)
        self._first, self._second = np.array([pair[:2] for pair in self._partners], dtype=np.int64).reshape(-1, 2).T
        self._touching = np.array([touching for _, _, touching in self._partners])

    def step(
        self, position: Float64, velocity: Float64, actions: npt.NDArray[np.integer[Any]]
    ) -> tuple[Float64, Float64]:
        """The next positions and velocities. `actions`: [batch, n_agents] indices."""
        push = np.empty_like(velocity)
        for agent, pushes in enumerate(self._chosen):
            chosen = np.ascontiguousarray(actions[:, agent])
            for axis in (0, 1):
                pushes[axis].take(chosen, out=push[agent, axis], mode="clip")
        return self.step_pushed(position, velocity, push)

    def step_pushed(self, position: Float64, velocity: Float64, push: Float64) -> tuple[Float64, Float64]:
        """Steps as `step` does, by the agents' own accelerations [n_agents, 2, batch], which are overwritten."""
        if len(self._partners) > 1 and position.shape[-1] <= PUSHED_AT_ONCE:
            self._push_all_apart(position, push)
        else:
            for pair in self._partners:
                self._push_apart(position, push, *pair)
        # what `step_position` and `step_velocity` give, in place: large batches are stepped a quarter faster
        push *= self._world.dt
        faster = velocity * (1.0 - self._world.damping)
        faster += push
        for agent, entity in enumerate(self._world.agents):
            if entity.max_speed is not None:
                x, y = faster[agent]
                speed = np.sqrt(x * x + y * y)
                fast = np.flatnonzero(speed > entity.max_speed)
                faster[agent][:, fast] = faster[agent][:, fast] / speed[fast] * entity.max_speed
        moved = position.copy()
        moved[: len(velocity)] += (faster if self._velocity_first else velocity) * self._world.dt
        return moved, faster

    def _push_apart(self, position: Float64, push: Float64, a: int, b: int, touching: float) -> None:
        """Adds the contact force of one pair to `push`. Where both centres coincide there is no direction to push in:
        mpe2 gives NaN there, and here nothing happens.
        """
        dx, dy = position[a] - position[b]
        near, force = contact_force(self._world, dx, dy, touching, self._margins)
        for axis in (0, 1):
            push[a, axis, near] += force[axis]
            if b < len(push):
                push[b, axis, near] -= force[axis]

    def _push_all_apart(self, position: Float64, push: Float64) -> None:
        """Does the same as `_push_apart` of one pair after the other, bit for bit: an agent gets its forces in the
        order of the pairs, and those in which it comes second precede those in which it comes first.
        """
        batch = position.shape[-1]
        dx, dy = (each[self._first] - each[self._second] for each in (position[:, 0], position[:, 1]))
        reach = self._touching + self._margins * self._world.contact_margin
        close = np.flatnonzero(dx * dx + dy * dy < (reach * reach)[:, None])  # few of all: the rest is of these
        pair, row = np.divmod(close, batch)
        gaps = dx.ravel()[close], dy.ravel()[close]
        near, force = contact_force(self._world, *gaps, self._touching[pair], self._margins)
        pair, row = pair[near], row[near]
        movable = self._second[pair] < len(push)
        for axis in (0, 1):
            np.subtract.at(push[:, axis], (self._second[pair[movable]], row[movable]), force[axis, movable])
            np.add.at(push[:, axis], (self._first[pair], row), force[axis])


def motionless(
    name: str, reference: str, agents: Sequence[str], steps: int = 1, options: Mapping[str, int | str] | None = None
) -> WorldSpec:
    """The spec of a world in which nothing is stated to move: without places, forces or time."""
    return WorldSpec(
        name=name,
        reference=reference,
        agents=tuple(EntitySpec(agent, size=0.0, force=0.0, max_speed=None, collides=False) for agent in agents),
        landmarks=(),
        goals=(),
        dt=0.0,
        damping=0.0,
        start_low=-MAX_LENGTH,
        start_high=MAX_LENGTH,
        episode_steps=steps,
        options=dict(options or {}),
    )
