"""What claims about episodes cut from zones: the starts that may still fail.

Does: the parts in which an agent may be away from a landmark, agents not matched to them, two entities too near.
Assumes: groups and zones of unroll.py and batch.py.
Does not: step zones.
"""

from collections.abc import Sequence
from fractions import Fraction
from itertools import combinations

import numpy as np

from verify.batch import GRID_SLACK, SCALE, Zones, constrained
from verify.contacts import Pair
from verify.unroll import Group


def away(zones: Zones, group: Group, agent: str, landmark: str, radius: Fraction, disjoint: bool = True) -> Zones:
    """The parts in which an agent may be farther than `radius` from a landmark, per axis and side.

    `disjoint`: no start twice, but on common edges; otherwise the four half planes, which overlap.
    """
    near = int(radius * SCALE // 1) - GRID_SLACK  # arrived for sure up to here
    mover, p, q = group.agents.index(agent), group.node(agent), group.node(landmark)
    found = []
    for axis in range(2):
        for low, high, sign in ((p, q, 1), (q, p, -1)):
            least, most = zones.offsets(slice(None), mover, axis)
            limit = near - sign * (most if sign > 0 else least)
            # one unit of room: starts on the edge itself have arrived, and edges of edges would never end
            rows, bounds = constrained(zones.bounds, axis, high, low, -limit, room=1)
            found.append(zones.take(rows).with_bounds(bounds))
            if disjoint:
                beyond = np.zeros(zones.count, dtype=bool)
                beyond[rows] = True
                inside = np.flatnonzero(~beyond | (limit > -zones.bounds[:, axis, high, low]))
                rest = zones.take(inside)
                kept, bounds = constrained(rest.bounds, axis, low, high, limit[inside])
                zones = rest.take(kept).with_bounds(bounds)
    return Zones.joined(found)


def unmatched(zones: Zones, group: Group, agents: Sequence[str], landmarks: Sequence[str], radius: Fraction) -> Zones:
    """The parts in which some agents of the group may not be matched to the landmarks: by Hall's theorem some of them
    and some landmarks, together more than there are landmarks, are all away from each other. Parts may overlap.
    """
    found = []
    for size in range(1, len(agents) + 1):
        for members in combinations(agents, size):
            for barred in combinations(landmarks, len(landmarks) - size + 1):
                part = zones
                for agent in members:
                    for landmark in barred:
                        part = away(part, group, agent, landmark, radius, disjoint=False)
                found.append(part)
    return Zones.joined(found)


def too_near(zones: Zones, group: Group, a: str, b: str, radius: Fraction, step: int) -> tuple[Zones, Zones]:
    """The parts in which two entities are for sure at least `radius` apart on some axis, and those where they may be
    nearer.
    """
    pair = Pair(group.bodies[a], group.bodies[b], within=-int(-radius * SCALE // 1))
    apart, near = pair.parted(zones, step)
    return Zones.joined(apart), near
