"""Keeps the part of each zone that may still violate a claim about episodes.

Does: the parts in which an agent may be away from a landmark, agents not matched to them, two entities too near.
Assumes: groups and zones of unroll.py and zones.py.
Does not: step zones.
"""

from collections.abc import Sequence
from fractions import Fraction
from itertools import product

import numpy as np

from codegen.ir import Bool
from verify.claims.values import has_matching
from verify.episodes.contacts import Pair
from verify.episodes.unroll import Group
from verify.episodes.zones import GRID_SLACK, SCALE, Int64, Zones, constrain_zones


def away(zones: Zones, group: Group, agent: str, landmark: str, radius: Fraction) -> Zones:
    """The parts in which an agent may be farther than `radius` from a landmark. No start twice, but on common edges."""
    return _split_by_arrival(zones, _Target(group, agent, landmark, radius))[0]


class _Target:
    """An agent's arrival at a landmark."""

    def __init__(self, group: Group, agent: str, landmark: str, radius: Fraction) -> None:
        self._mover, self._ends = group.agents.index(agent), (group.node(agent), group.node(landmark))
        self._near = int(radius * SCALE // 1) - GRID_SLACK  # arrived for sure up to here

    def sides(self, zones: Zones) -> list[tuple[int, int, int, Int64]]:
        """(axis, p, q, limit [n]) for the four sides: who has start(p) - start(q) <= limit on all has arrived."""
        (p, q), limits = self._ends, list[tuple[int, int, int, Int64]]()
        for axis in range(2):
            least, most = zones.offsets(slice(None), self._mover, axis)
            limits += [(axis, p, q, self._near - most), (axis, q, p, self._near + least)]
        return limits

    def possible(self, zones: Zones) -> Bool:
        """Zones of which some part has arrived for sure, [n]."""
        arrives = np.ones(zones.count, dtype=bool)
        limits: list[Int64] = []
        for axis, p, q, limit in self.sides(zones):
            arrives &= limit > -zones.bounds[:, axis, q, p]
            limits.append(limit)
        # contacts may leave open more than the radius
        return arrives & (limits[0] + limits[1] > 0) & (limits[2] + limits[3] > 0)


def _split_by_arrival(zones: Zones, target: _Target) -> tuple[Zones, Zones]:
    """The parts in which the agent may be away, and those in which it has arrived for sure. Zones in which it cannot
    have arrived stay whole.
    """
    possible = target.possible(zones)
    if not possible.any():
        return zones, zones.take(slice(0))
    parts = [zones.take(~possible)]
    zones = zones.take(possible)
    for number in range(4):
        axis, p, q, limit = target.sides(zones)[number]
        # one unit of room: starts on the edge itself have arrived, and edges of edges would never end
        rows, bounds = constrain_zones(zones.bounds, axis, q, p, -limit, room=1)
        parts.append(zones.part(rows, bounds))
        zones = zones.part(*constrain_zones(zones.bounds, axis, p, q, limit))
    return Zones.join(parts), zones


def find_unmatched(
    zones: Zones, group: Group, agents: Sequence[str], landmarks: Sequence[str], radius: Fraction
) -> Zones:
    """The parts in which these agents of the group may not be matched to the landmarks. No start twice but on edges."""
    targets = [[_Target(group, agent, landmark, radius) for landmark in landmarks] for agent in agents]
    pairs = list(product(range(len(agents)), range(len(landmarks))))
    waiting, unmatchable = [(zones, np.zeros((len(agents), len(landmarks)), dtype=bool), 0)], [zones.take(slice(0))]
    while waiting:
        zones, arrived, asked = waiting.pop()
        if not zones.count or has_matching(arrived):
            continue
        may = np.repeat(arrived[None], zones.count, axis=0)
        for agent, landmark in pairs[asked:]:
            may[:, agent, landmark] = targets[agent][landmark].possible(zones)
        matchable = has_matching(may)
        unmatchable.append(zones.take(~matchable))
        if matchable.any():
            apart, near = _split_by_arrival(zones.take(matchable), targets[pairs[asked][0]][pairs[asked][1]])
            also = arrived.copy()
            also[pairs[asked]] = True
            waiting += [(apart, arrived, asked + 1), (near, also, asked + 1)]
    return Zones.join(unmatchable)


def too_near(zones: Zones, group: Group, a: str, b: str, radius: Fraction, step: int) -> tuple[Zones, Zones]:
    """The parts in which two entities are for sure at least `radius` apart on some axis, and those where they may be
    nearer.
    """
    pair = Pair(group.bodies[a], group.bodies[b], within=-int(-radius * SCALE // 1))
    apart, near = pair.split_apart(zones, step)
    return Zones.join(apart), near
