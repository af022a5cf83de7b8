"""The closed loop as zones: all starts with the same actions so far move alike, so a step only shifts the tests.

Does: resolves trees for one group of agents and one goal, and follows all starts of a region step by step; bounds how
  far the rounded motion may be from the exact one.
Assumes: agents of the group start at rest and touch nobody; what other agents do is arbitrary.
Does not: find real starts (verdicts/episodes.py does, from what is left over here) or play (states/episodes.py). It
  steps by a reading of the world spec of its own, not by codegen/dynamics.py: the referee, which judges the starts left
  over, steps by that one, and the checker by a third.

Why a proof over zones holds for the machine. v does not depend on positions, so it is computed here by the machine's
own operations; only p += dt * v rounds differently for different starts. After T steps with positions up to X and
speeds up to V, position and model differ by at most T (2^-45 + 2^-53 X + 3 T dt 2^-53 V): the grid, the rounding of
each sum, and any other order of operations in v. For T = 25, X = 6, V = 2, dt = 0.1 that is 8e-13. A test compares a
difference of two positions: twice that, plus the roundings of the subtraction and of a threshold's tie point, is
below 2e-12. Every test is relaxed by SLACK = 2^-30 = 9e-10: going left needs d <= end + SLACK, going right d >= end -
SLACK, and having arrived counts from radius - SLACK on. `ensure_exact` refuses questions for which the sum exceeds
SLACK.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from codegen import ir
from codegen.errors import InputError
from codegen.floats import deciding_double
from codegen.ir import AgentPolicy, Bool, Float64, PolicyProfile, WorldSpec
from verify.claims.claim import read_by
from verify.episodes.contacts import (
    Body,
    Contacts,
    bound_neglected,
    colliders,
    contacts_of,
    farthest,
    fastest,
    split_known,
)
from verify.episodes.zones import AXES, GRID_SLACK, LIMIT, SCALE, SLACK, ZERO, Int8, Int64, Zones, constrain_zones
from verify.spending import tell
from verify.zones.tables import BeyondZonesError


def ensure_exact(world: WorldSpec, steps: int, largest: Fraction, push: float) -> None:
    """InputError unless the relaxation of tests covers all rounding, and numbers keep below LIMIT.

    `largest`: the region's largest coordinate; `push`: the most that an action adds to a velocity on an axis.
    """
    reach, speed, place = 0.0, 0.0, 0.0
    for _ in range(steps):
        place += speed * world.dt
        speed = speed * (1 - world.damping) + push
        reach = max(reach, speed)
    size = float(largest) + place
    apart = steps * (2.0**-45 + 2.0**-53 * size + 3 * steps * world.dt * 2.0**-53 * reach) + bound_neglected(
        world, steps
    )
    most = max(size + farthest(world, steps), reach + fastest(world, steps))
    if not (2 * apart + 2.0**-50 * size <= SLACK and most <= LIMIT / 8):
        raise InputError(
            f"rounding over {steps} steps from positions up to {float(largest):g} may exceed what the proof allows for",
            "--steps",
            "ask for fewer steps or a smaller region",
        )


CHUNK = 4096  # zones that are stepped together


class SideBound(NamedTuple):
    """A condition on the starts: start(p) - start(q) <= limit - sign * (what offsets have added to the test)."""

    p: int
    q: int
    limit: int
    sign: int


@dataclass(frozen=True)
class StartSplit:
    """A split in terms of start positions. `moved`: (weight, agent of the group, of its velocity) of its terms.

    Splits have the same number exactly if they send the same starts left, down to the ends of their half lines.
    """

    number: int
    axis: int
    moved: tuple[tuple[int, int, bool], ...]
    sides: tuple[tuple[SideBound, ...], tuple[SideBound, ...]]  # of left and right; none: that side is always possible
    children: "tuple[Node, Node]"


Node = StartSplit | int  # an int is the action of a leaf


@dataclass(frozen=True)
class Group:
    """Agents that are followed together, for one goal: their trees over the nodes of the zones, and how they move."""

    agents: tuple[str, ...]
    bodies: Mapping[str, Body]  # the entities of the zones' nodes 1, 2, ...; the agents come first
    trees: tuple[Node, ...]
    push: Float64  # [agents, actions, 2] what an action adds to the velocity
    max_speed: tuple[float | None, ...]
    dt: float
    damping: float
    tests: int  # how many different tests there are
    sees_speed: bool  # some test reads a velocity
    contacts: Contacts | None  # None where nothing can push the agents

    @property
    def entities(self) -> tuple[str, ...]:
        """The names of the zones' nodes 1, 2, ..."""
        return tuple(self.bodies)

    def node(self, entity: str) -> int:
        """The entity's node in the zones."""
        return self.bodies[entity].node


def build_group(
    profile: PolicyProfile,
    agents: Sequence[str],
    goal: str | None,
    claimed: Sequence[str],
    travel: Mapping[str, Int64] | None = None,
) -> Group:
    """The group of `agents` for one goal. `claimed`: entities that the claim speaks of. `travel`: how far agents that
    are not followed may get (`contacts.travels`), where they are claimed or collide.
    """
    world = profile.world
    policies = [profile.policy(agent) for agent in agents]
    seen = frozenset(claimed).union(*(read_by(policy) for policy in policies))
    if goal is not None and ir.GOAL in seen:
        seen |= {goal}
    movers = {entity.name: entity for entity in world.agents}
    touching = colliders(world, agents)
    landmarks = [entity.name for entity in world.landmarks if entity.name in seen | touching]
    others = [name for name in movers if name in touching | set(claimed) and name not in agents]
    bodies = {name: Body(node, node - 1) for node, name in enumerate(agents, 1)}
    for name in (*landmarks, *others):
        bodies[name] = Body(1 + len(bodies), travel=(travel or {})[name] if name in movers else None)
    most = max(len(policy.actions) for policy in policies)
    push = np.zeros((len(agents), most, 2))
    for place, policy in enumerate(policies):
        push[place, : len(policy.actions)] = _pushes(profile, policy)
    resolver = _Resolver(world, tuple(agents), (*agents, *landmarks), goal)
    trees = tuple(resolver.node(policy, ir.ROOT) for policy in policies)
    speeds = tuple(movers[agent].max_speed for agent in agents)
    tests = len(resolver.numbers)
    contacts = contacts_of(world, bodies, speeds)
    sees = resolver.sees_speed
    return Group(tuple(agents), bodies, trees, push, speeds, world.dt, world.damping, tests, sees, contacts)


def _pushes(profile: PolicyProfile, policy: AgentPolicy) -> Float64:
    """Returns what each action adds to the agent's velocity, [actions, 2]."""
    force = next(entity.force for entity in profile.world.agents if entity.name == policy.agent)
    return np.array([action.effect or (0.0, 0.0) for action in policy.actions]) * force * profile.world.dt


def strides(profile: PolicyProfile) -> dict[str, float]:
    """Agent -> the most that an action adds to its velocity on an axis."""
    return {policy.agent: float(np.abs(_pushes(profile, policy)).max()) for policy in profile.agents}


class _Resolver:
    """Turns trees into splits over start positions; notes whether a test that matters reads a velocity."""

    def __init__(self, world: WorldSpec, agents: tuple[str, ...], entities: tuple[str, ...], goal: str | None) -> None:
        self._world, self._agents, self._entities, self._goal = world, agents, entities, goal
        self.sees_speed = False
        self.numbers: dict[tuple[object, ...], int] = {}

    def node(self, policy: AgentPolicy, place: int) -> Node:
        """The subtree at a node, without splits that do not matter."""
        tree = policy.tree
        if tree.feature[place] == ir.NO_FEATURE:
            return int(tree.action[place])
        children = self.node(policy, int(tree.left[place])), self.node(policy, int(tree.right[place]))
        if children[0] == children[1]:
            return children[0]
        return self._split(policy.features[int(tree.feature[place])], tree.threshold[place], children)

    def _split(self, feature: ir.FeatureSpec, threshold: np.floating, children: tuple[Node, Node]) -> Node:
        meaning = feature.meaning
        if meaning and len(meaning.terms) > 2:  # what cancels would still round
            raise BeyondZonesError(f"feature {feature.name} is not a coordinate or a difference of two")
        weights: dict[str, float] = {}
        for weight, name in meaning.terms if meaning else ():
            if self._goal is not None and name.startswith(f"{ir.GOAL}."):
                name = f"{self._goal}{name.removeprefix(ir.GOAL)}"
            weights[name] = weights.get(name, 0) + weight
        weights = {name: weight for name, weight in weights.items() if weight}
        function = meaning.function if meaning else ""
        if not weights:  # such as the goal's offset from the landmark that it is
            return children[0] if (1.0 if function == "zero" else 0.0) <= threshold else children[1]
        line = _line(function, threshold)
        if isinstance(line, bool):
            return children[0] if line else children[1]
        axis, p, q, moved = self._terms(feature, weights)
        if moved is None:
            return StartSplit(self._number(feature, threshold), axis, (), ((), ()), children)
        up, down = _grid(line[0]) + GRID_SLACK, _grid(-line[0]) + GRID_SLACK
        left, right = (SideBound(p, q, up, 1),), (SideBound(q, p, down, -1),)
        number = self._number(axis, p, q, moved, line, function == "zero")
        return StartSplit(number, axis, moved, ((), left + right) if function == "zero" else (left, right), children)

    def _number(self, *asked: object) -> int:
        return self.numbers.setdefault(asked, len(self.numbers))

    def _terms(
        self, feature: ir.FeatureSpec, weights: Mapping[str, float]
    ) -> tuple[int, int, int, tuple[tuple[int, int, bool], ...] | None]:
        """(axis, p, q, moved) of a test on start(p) - start(q); moved is None where other agents decide."""
        axes, ends, moved = set[str](), {1: ZERO, -1: ZERO}, list[tuple[int, int, bool]]()
        self.sees_speed |= any(name.rpartition(".")[2].startswith("v") for name in weights)
        for name, weight in weights.items():
            entity, _, part = name.rpartition(".")
            axes.add(part[-1])
            if entity in self._agents:
                moved.append((int(weight), self._agents.index(entity), part.startswith("v")))
            elif entity not in self._entities:
                return 0, ZERO, ZERO, None  # nothing is asked of other agents, so any test on them can go both ways
            if not part.startswith("v"):
                if ends.get(int(weight)) != ZERO:
                    raise BeyondZonesError(f"feature {feature.name} is not a difference of two coordinates")
                ends[int(weight)] = 1 + self._entities.index(entity)
        if len(axes) > 1 or any(abs(weight) != 1 for weight in weights.values()):
            raise BeyondZonesError(f"feature {feature.name} mixes two axes, or weighs its coordinates")
        return AXES.index(axes.pop()), ends[1], ends[-1], tuple(moved)


def _line(function: str, threshold: np.floating) -> tuple[float, bool] | bool:
    """(end, strict) of the sums that go left: up to the end, below it when strict; for "zero" those beside it. A bool
    when all or none go left. A threshold has the type of the numbers that are compared.
    """
    at = float(threshold)
    if function == "":
        return (deciding_double(at) if threshold.dtype == np.float32 else at), False
    low = -1 if function == "sign" else 0
    return (0.0, at < 0) if low <= at < 1 else at >= 1


def _grid(value: float) -> int:
    """A number in 1 / SCALE, rounded up; beyond LIMIT, where no position is, LIMIT."""
    return -int(-Fraction(min(max(value, -LIMIT), LIMIT)) * SCALE // 1)


# --- following the zones


Cut = Callable[[Zones, int], Zones]  # (zones, step) -> the parts in which the claim may still fail


class EpisodeSearch:
    """Depth first in batches: the zones of the deepest step that has a full batch are stepped, else the earliest."""

    def __init__(self, group: Group, steps: int, cut: Cut, budget: int) -> None:
        self.visited = self.touched = self.given_up = 0  # zones; with pushes known between bounds; that were left so
        self._group, self._steps, self._cut, self._budget = group, steps, cut, budget

    def run(self, first: Zones, failed: Callable[[Zones], None]) -> bool:
        """Returns True if the search ended within the budget. `failed` gets the zones left after the last step."""
        waiting: list[list[Zones]] = [[first], *([] for _ in range(self._steps))]
        while True:
            sizes = [sum(zones.count for zones in batch) for batch in waiting]
            unfinished = [step for step, size in enumerate(sizes) if size]
            if not unfinished:
                return True
            step = next((step for step in reversed(unfinished) if sizes[step] >= CHUNK), unfinished[0])
            zones = Zones.join(waiting[step])
            waiting[step] = [zones.take(slice(CHUNK, None))] if zones.count > CHUNK else []
            zones = zones.take(slice(CHUNK))
            if self.visited + zones.count > self._budget:
                return False
            self.visited += zones.count
            tell(
                self.visited, self._budget, f"zones visited of {' with '.join(self._group.agents)}, {sum(sizes):,} open"
            )
            zones = self._cut(zones, step)
            if zones.count and step == self._steps:
                failed(zones)
            elif zones.count:
                stepped, given_up = split_known(self._step_zones(zones, step))
                if stepped.loose is not None:
                    self.touched += int(stepped.loose.gust.any(axis=(1, 2)).sum())
                if given_up.count:
                    self.given_up += given_up.count
                    self.visited += given_up.count
                    failed(given_up)
                waiting[step + 1].append(stepped)

    def _step_zones(self, zones: Zones, step: int) -> Zones:
        """The zones after one more step, split by what the trees choose."""
        group = self._group
        # after the first step nobody has moved, so all choose again what they chose; the last choice moves nobody
        # before the end
        if step < self._steps - 1 and (step != 1 or group.sees_speed):
            for place in range(len(group.agents)):
                zones = split_by_tree(zones, group, place)
        if step < self._steps - 1 and group.contacts is not None:
            zones = group.contacts.split_by_contact(zones, step)
        moved = zones.offset + np.rint(zones.velocity * group.dt * SCALE).astype(np.int64)
        velocity = zones.velocity * (1.0 - group.damping)
        for place, limit in enumerate(group.max_speed):
            velocity[:, place] += group.push[place][zones.action[:, place]]
            if limit is not None:
                speed = np.sqrt((velocity[:, place] ** 2).sum(axis=1))
                fast = np.flatnonzero(speed > limit)
                velocity[fast, place] = velocity[fast, place] / speed[fast, None] * limit
        after = zones._replace(offset=moved, velocity=velocity, moved=zones.moved | (velocity != 0))
        return after if group.contacts is None else group.contacts.apply_pushes(zones, after, group.push, step)


class _Pieces(NamedTuple):
    """Parts of zones on their way through a tree."""

    rows: Int64  # [n] of the zones that they are parts of
    bounds: Int64
    went: Int8


MIXED, NOWHERE = -1, -2


class _Asked(NamedTuple):
    """Pieces that came to a node, and what they choose: an action, MIXED, or NOWHERE if no start is left."""

    pieces: _Pieces
    action: Int64  # [n]
    sides: "list[tuple[Int64, _Asked]]"  # which of the pieces may go there, and what they choose there


def split_by_tree(zones: Zones, group: Group, place: int) -> Zones:
    """The zones split by one agent's tree. Below each node, a piece all of whose parts choose the same stays whole."""
    asked = _ask_node(zones, group.trees[place], _Pieces(np.arange(zones.count), zones.bounds, zones.went))
    gathered: list[tuple[_Pieces, Int64]] = []
    _gather(asked, np.ones(zones.count, dtype=bool), gathered)
    rows, bounds, went = (np.concatenate(column) for column in zip(*(pieces for pieces, _ in gathered), strict=True))
    chosen = zones.part(rows, bounds)._replace(went=went)
    chosen.action[:, place] = np.concatenate([action for _, action in gathered])
    return chosen


def _ask_node(zones: Zones, node: Node, pieces: _Pieces) -> _Asked:
    """Returns what pieces choose below a node."""
    if isinstance(node, int):
        return _Asked(pieces, np.full(len(pieces.rows), node), [])
    action, sides = np.full(len(pieces.rows), NOWHERE), list[tuple[Int64, _Asked]]()
    for child, (kept, part) in zip(node.children, _sides(zones, node, pieces), strict=True):
        if len(kept):
            below = _ask_node(zones, child, part)
            before = action[kept]
            alike = (before == NOWHERE) | (before == below.action)
            action[kept] = np.where(alike, below.action, MIXED)
            sides.append((kept, below))
    return _Asked(pieces, action, sides if (action == MIXED).any() else [])


def _gather(asked: _Asked, wanted: Bool, gathered: list[tuple[_Pieces, Int64]]) -> None:
    """Adds the largest pieces that choose one action, of those `wanted` [n]."""
    rows = np.flatnonzero(wanted & (asked.action >= 0))
    if len(rows):
        pieces = asked.pieces
        gathered.append((_Pieces(pieces.rows[rows], pieces.bounds[rows], pieces.went[rows]), asked.action[rows]))
    mixed = wanted & (asked.action == MIXED)
    for kept, below in asked.sides:
        _gather(below, mixed[kept], gathered)


def _sides(zones: Zones, node: StartSplit, pieces: _Pieces) -> list[tuple[Int64, _Pieces]]:
    """The pieces that may go left, with the part that may, and those that may go right.

    Where no position in the test has changed since the start, neither has its outcome: it is looked up. Tests are
    relaxed, so asking again would each time split off the few starts that the relaxation leaves to both sides.
    """
    rows = pieces.rows
    shifts = _shift(zones, rows, node)
    unmoved = np.full(len(rows), bool(node.sides[1]))
    for _, agent, of_velocity in node.moved:
        unmoved &= ~zones.moved[rows, agent, node.axis] & (not of_velocity)
    known = np.where(unmoved, pieces.went[:, node.number], 0)
    sides: list[tuple[Int64, _Pieces]] = []
    for number, side in enumerate(node.sides, 1):
        kept = np.flatnonzero((known == 0) | (known == number))
        # a test that was answered is in the bounds already: its limits cut nothing more
        bounds = pieces.bounds[kept]
        for bound in side:
            shift = shifts[0 if bound.sign > 0 else 1][kept]
            left, bounds = constrain_zones(bounds, node.axis, bound.p, bound.q, bound.limit - bound.sign * shift)
            kept = kept[left]
        went = pieces.went[kept]
        went[unmoved[kept], node.number] = number
        sides.append((kept, _Pieces(rows[kept], bounds, went)))
    return sides


def _shift(zones: Zones, rows: Int64, node: StartSplit) -> tuple[Int64, Int64]:
    """Bounds of what the agents' movements have added to a test since the start, [n] each."""
    low = np.zeros(len(rows), dtype=np.int64)
    high = low if zones.loose is None else low.copy()
    for weight, agent, of_velocity in node.moved:
        ends = (zones.velocities if of_velocity else zones.offsets)(rows, agent, node.axis)
        low += weight * ends[weight < 0]
        if high is not low:
            high += weight * ends[weight > 0]
    return low, high
