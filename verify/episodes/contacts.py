"""Contacts in the closed loop: zones in which nothing touches stay exact, the others know pushes between bounds.

Does: states the contact force, splits zones by who may touch whom, bounds the pushes, says how far agents may get.
Assumes: agents start at rest; whoever is not followed may choose any action at any step.
Does not: know trees or claims (unroll.py, composition.py). Its steps are bounds, rounded outwards, and no numbers that
  codegen/dynamics.py could give; only who may push whom comes from there.

The force between entities at a distance d that touch at D is C k log(1 + exp((D - d) / k)) along the line between their
centres: at most C (D - d + k), and below C k exp(-m) from D + m k on. Why zones stay sound:

- Beyond D + SURE_MARGINS k a push counts as nothing. Velocities are linear in pushes, and cutting a speed brings no
  two velocities farther apart, so what is left out moves a position in T steps by at most (T dt)^2 C k
  exp(-SURE_MARGINS) a partner. `unroll.ensure_exact` counts it with the roundings.
- Elsewhere the push lies in an interval over the box of the gaps that a zone allows, larger by SLACK on each side,
  which is what positions may differ from the model. The force shrinks with the distance; its share on an axis, gap /
  distance, grows with that axis' gap and gets smaller in size as the other axis' gap grows. So bounds lie at corners.
- Agents that may have been pushed carry intervals of offset and velocity. Each step makes them larger by PAD on each
  side, far above the roundings of positions below 2^15 and of speeds. Cutting a speed to a disc is monotone in each
  coordinate, and in the size of the other, so its bounds lie at corners as well.
- Where centres coincide there is no direction: here nothing is pushed (mpe2 has no number there). The interval holds 0.
  Claims are not about episodes in which they do, within COINCIDENT, from where on squared distances keep their digits.

Zones in which two may touch are split by whether they do, then into CELLs of their gap, so that pushes stay narrow; a
zone in which somebody's place is known less well than MAX_DRIFT is given up, and what it holds is left open.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from codegen.dynamics import partners
from codegen.ir import Bool, Float64, WorldSpec
from verify.episodes.zones import GRID_SLACK, LIMIT, SCALE, Int64, Loose, Start, Zones, halves

SURE_MARGINS = 32  # so far apart a zone does
PAD = 2.0**-36
PAD_UNITS = SCALE >> 36
OUTWARDS = 1 + 2.0**-40  # more than the roundings of a force
CELL = SCALE // 32  # gaps of touching entities are told apart so far: each piece has a narrower push
MAX_PARTS = 1 << 15  # zones of one step; beyond it they stay whole, since parts only make pushes narrower
MAX_DRIFT = SCALE // 2  # zones in which somebody's place is known less well are given up, 1 / SCALE


def strongest(world: WorldSpec, touching: float) -> float:
    """More than any push of a contact, length / s^2."""
    return world.contact_force * (touching + world.contact_margin) * OUTWARDS


def fastest(world: WorldSpec, steps: int) -> float:
    """More than contacts may add to an agent's speed within so many steps, length / s."""
    pushes = [strongest(world, touching) for _, _, touching in partners(world)]
    return steps * world.dt * sum(pushes)


def farthest(world: WorldSpec, steps: int) -> float:
    """More than contacts may add to how far an agent gets within so many steps, length units."""
    return steps * world.dt * fastest(world, steps)


def colliders(world: WorldSpec, agents: Sequence[str]) -> frozenset[str]:
    """All that collide with some force, if one of the agents does; else nothing."""
    everything = world.agents + world.landmarks
    colliding = frozenset(entity.name for entity in everything if entity.collides and world.contact_force)
    return colliding if colliding & set(agents) else frozenset()


def bound_neglected(world: WorldSpec, steps: int) -> float:
    """Bounds how far pushes that zones leave out may move a position within so many steps, length units."""
    most = sum(entity.collides for entity in world.agents + world.landmarks)
    return (steps * world.dt) ** 2 * most * world.contact_force * world.contact_margin * float(np.exp(-SURE_MARGINS))


@dataclass(frozen=True, eq=False)
class Body:
    """The motion of an entity of the zones: as the group's agent, within bounds, or not at all."""

    node: int
    agent: int = -1  # its place in the group; -1: it is not followed
    travel: Int64 | None = None  # [steps + 1] how far an agent that is not followed may have come on each axis

    def span(self, zones: Zones, axis: int, step: int) -> tuple[Int64, Int64]:
        """Bounds of its offset from its start, [n] each."""
        if self.agent >= 0:
            return zones.offsets(slice(None), self.agent, axis)
        far = np.full(zones.count, 0 if self.travel is None else self.travel[step])
        return -far, far


@dataclass(frozen=True, eq=False)
class Pair:
    """Two entities of the zones, and a distance that matters between them, in 1 / SCALE."""

    first: Body
    second: Body
    within: int

    def gaps(self, zones: Zones, axis: int, step: int) -> tuple[Int64, Int64]:
        """Bounds of what movements have added to the first's gap from the second."""
        (low, high), (least, most) = self.first.span(zones, axis, step), self.second.span(zones, axis, step)
        return low - most, high - least

    def box(self, zones: Zones, step: int) -> tuple[Int64, Int64]:
        """Bounds of the gap itself, [n, 2] each, with room for the roundings of positions."""
        p, q = self.first.node, self.second.node
        added = [self.gaps(zones, axis, step) for axis in range(2)]
        low = np.stack([added[axis][0] - zones.bounds[:, axis, q, p] for axis in range(2)], axis=1)
        high = np.stack([added[axis][1] + zones.bounds[:, axis, p, q] for axis in range(2)], axis=1)
        return low - GRID_SLACK, high + GRID_SLACK

    def split_apart(self, zones: Zones, step: int) -> tuple[list[Zones], Zones]:
        """Parts in which the two are for sure at least `within` apart on some axis, and the part that is left. Zones
        that need no cut for it stay whole.
        """
        p, q = self.first.node, self.second.node
        clear = self.within + GRID_SLACK
        low, high = self.box(zones, step)
        far = (nearest(low, high) >= self.within).any(axis=1)
        apart = [zones.take(far)]
        zones = zones.take(~far)
        for axis in range(2):
            low, _ = self.gaps(zones, axis, step)
            zones, above = halves(zones, axis, p, q, clear - low)
            _, high = self.gaps(zones, axis, step)
            zones, below = halves(zones, axis, q, p, clear + high)
            apart += [above, below]
        return apart, zones

    def cells(self, zones: Zones) -> list[Zones]:
        """The zones in parts in which the two start at gaps that differ by at most CELL on each axis; whole where one
        of them is not followed, so that its place is too little known for this to help, and beyond MAX_PARTS.
        """
        p, q = self.first.node, self.second.node
        widths = zones.bounds[:, :, p, q] + zones.bounds[:, :, q, p]
        if self.second.travel is not None or np.prod(widths / CELL + 1, axis=1).sum() > MAX_PARTS:
            return [zones]
        waiting = [zones]
        for axis in range(2):
            small: list[Zones] = []
            while waiting:
                part = waiting.pop()
                low, high = -part.bounds[:, axis, q, p], part.bounds[:, axis, p, q]
                large = high - low > CELL
                small.append(part.take(~large))
                if large.any():
                    waiting += halves(part.take(large), axis, p, q, (low + (high - low) // 2)[large])
            waiting = small
        return waiting


def nearest(low: Int64, high: Int64) -> Int64:
    """The least size of numbers between bounds."""
    return np.maximum(np.maximum(low, -high), 0)


@dataclass(frozen=True, eq=False)
class Contacts:
    """The contacts that may push the agents of a group: each pair's first is one of them."""

    world: WorldSpec
    pairs: tuple[Pair, ...]
    touching: tuple[float, ...]  # a pair
    max_speed: tuple[float | None, ...]  # an agent of the group

    def split_by_contact(self, zones: Zones, step: int) -> Zones:
        """The zones split by who may touch whom now; those in which nobody may stay whole."""
        for pair in self.pairs:
            low, high = pair.box(zones, step)
            near = nearest(low, high) / SCALE
            close = np.hypot(near[:, 0], near[:, 1]) * SCALE < pair.within
            if close.any() and zones.count <= MAX_PARTS:
                apart, rest = pair.split_apart(zones.take(close), step)
                zones = Zones.join([zones.take(~close), *apart, *pair.cells(rest)])
        return zones

    def apply_pushes(self, before: Zones, after: Zones, push: Float64, step: int) -> Zones:
        """`after`, the zones one step later without contacts, with what contacts may do. `push`: [agents, actions, 2]
        what an action adds to the velocity.
        """
        assert before.loose is not None
        drift, gust = before.loose.drift, before.loose.gust
        low, high = np.zeros(before.offset.shape), np.zeros(before.offset.shape)  # of the forces on each agent
        for pair, touching in zip(self.pairs, self.touching, strict=True):
            least, most = _force(self.world, touching, *pair.box(before, step))
            low[:, pair.first.agent] += least
            high[:, pair.first.agent] += most
            if pair.second.agent >= 0:
                low[:, pair.second.agent] -= most
                high[:, pair.second.agent] -= least
        loose = ((gust != 0) | (drift != 0) | (low != 0) | (high != 0)).any(axis=2)
        rows = np.flatnonzero(loose.any(axis=1))
        if not rows.size:
            return after
        choice = push[np.arange(before.action.shape[1]), before.action]
        dt, kept = self.world.dt, 1.0 - self.world.damping
        slowest = before.velocity[rows] * kept + choice[rows] + dt * low[rows]
        fastest = (before.velocity[rows] + gust[rows]) * kept + choice[rows] + dt * high[rows]
        for place, limit in enumerate(self.max_speed):
            if limit is not None:
                slowest[:, place], fastest[:, place] = _limit_speed(slowest[:, place], fastest[:, place], limit)
        which = loose[rows][:, :, None]
        farther = np.ceil(gust[rows] * dt * SCALE).astype(np.int64)
        offset, velocity = after.offset.copy(), after.velocity.copy()
        drift, gust = drift.copy(), gust.copy()
        offset[rows] -= np.where(which, PAD_UNITS, 0)
        drift[rows] += np.where(which, farther + 2 * PAD_UNITS, 0)
        velocity[rows] = np.where(which, slowest - PAD, velocity[rows])
        gust[rows] = np.where(which, fastest - slowest + 2 * PAD, 0.0)
        return after._replace(offset=offset, velocity=velocity, loose=Loose(drift, gust))


def contacts_of(world: WorldSpec, bodies: Mapping[str, Body], max_speed: tuple[float | None, ...]) -> Contacts | None:
    """Returns what may push a group's agents; `max_speed` are their speed limits. None where nothing pushes."""
    entities = [entity.name for entity in world.agents + world.landmarks]
    pairs, distances = list[Pair](), list[float]()
    for i, j, touching in partners(world):
        known_as = [bodies[name] for name in (entities[i], entities[j]) if name in bodies]
        known_as.sort(key=lambda body: body.agent < 0)  # who is not followed comes last
        if len(known_as) == 2 and known_as[0].agent >= 0:
            reach = touching + SURE_MARGINS * world.contact_margin
            pairs.append(Pair(*known_as, within=int(np.ceil(reach * SCALE))))
            distances.append(touching)
    return Contacts(world, tuple(pairs), tuple(distances), max_speed) if pairs else None


def _force(world: WorldSpec, touching: float, low: Int64, high: Int64) -> tuple[Float64, Float64]:
    """Bounds [n, 2] of the force on the first of two entities whose gap lies between bounds [n, 2] in 1 / SCALE."""
    near, far = nearest(low, high) / SCALE, np.maximum(-low, high) / SCALE
    margin = world.contact_margin

    def size(distance: Float64) -> Float64:
        return world.contact_force * margin * np.logaddexp(0, (touching - distance) / margin)

    closest = np.hypot(near[:, 0], near[:, 1])
    reach = closest < touching + SURE_MARGINS * margin
    most, least = size(closest) * OUTWARDS, size(np.hypot(far[:, 0], far[:, 1])) / OUTWARDS

    def largest(end: Float64, axis: int) -> Float64:
        """The largest share on an axis of a force whose gap there is at most `end`, times its size."""
        beside = np.where(end > 0, near[:, 1 - axis], far[:, 1 - axis])
        share = end / np.maximum(np.hypot(end, beside), np.finfo(np.float64).tiny)
        share = np.where(closest == 0, 1.0, share)  # any direction
        strength = np.where(share > 0, share * most * OUTWARDS, share * least / OUTWARDS)
        return np.where(reach, strength, 0.0)

    upper = [largest(high[:, axis] / SCALE, axis) for axis in range(2)]
    lower = [-largest(-low[:, axis] / SCALE, axis) for axis in range(2)]
    return np.stack(lower, axis=1), np.stack(upper, axis=1)


def _limit_speed(low: Float64, high: Float64, limit: float) -> tuple[Float64, Float64]:
    """Bounds [n, 2] of velocities between bounds, once their speed is cut to a limit."""
    least, most = np.maximum(np.maximum(low, -high), 0.0), np.maximum(-low, high)

    def largest(end: Float64, axis: int) -> Float64:
        beside = np.where(end > 0, least[:, 1 - axis], most[:, 1 - axis])
        return end * np.minimum(1.0, limit / np.maximum(np.hypot(end, beside), limit))

    upper = [largest(high[:, axis], axis) for axis in range(2)]
    lower = [-largest(-low[:, axis], axis) for axis in range(2)]
    return np.stack(lower, axis=1), np.stack(upper, axis=1)


def split_known(zones: Zones) -> tuple[Zones, Zones]:
    """The zones in which all places are known well enough to go on, and those that are given up."""
    if zones.loose is None:
        return zones, zones.take(slice(0))
    given_up: Bool = np.asarray((zones.loose.drift > MAX_DRIFT).any(axis=(1, 2)))
    return zones.take(~given_up), zones.take(given_up)


def travels(world: WorldSpec, pushes: Mapping[str, float], parts: Sequence[Start], steps: int) -> Mapping[str, Int64]:
    """Bounds how far each agent comes from its start on an axis, [steps + 1] in 1 / SCALE, whatever anybody does.

    `pushes`: agent -> the most that an action adds to its velocity on an axis.
    """
    entities = [entity.name for entity in world.agents + world.landmarks]
    count, movable = len(entities), len(world.agents)
    bounds = np.array([part.project(entities) for part in parts])[:, :, 1:, 1:] / SCALE  # of start differences
    speed, place = np.zeros(count), np.zeros(count)
    added = np.array([pushes.get(name, 0.0) for name in entities])
    travelled = [place]
    for _ in range(steps):
        shoved = np.zeros(count)
        for a, b, touching in partners(world):
            reach = touching + SURE_MARGINS * world.contact_margin + 2.0**-20 + place[a] + place[b]
            if (np.maximum(-bounds[:, :, a, b], -bounds[:, :, b, a]).max(axis=1) < reach).any():
                shoved[[a, b]] += world.dt * strongest(world, touching)
        place = (place + speed * world.dt) * OUTWARDS
        speed = (speed * (1.0 - world.damping) + added + shoved) * OUTWARDS
        speed[movable:] = 0.0
        for number, entity in enumerate(world.agents):
            if entity.max_speed is not None:
                speed[number] = min(speed[number], entity.max_speed * OUTWARDS)
        travelled.append(place)
    grid = np.ceil(np.minimum(np.array(travelled), LIMIT / 4) * SCALE).astype(np.int64)
    return {name: grid[:, number] for number, name in enumerate(entities[:movable])}
