"""Many zones at once: sets of start positions given by bounds on differences, as arrays.

Does: builds the start zones of a region, cuts batches of zones by a bound each, finds points inside a zone.
Assumes: lengths below LIMIT; bounds are whole multiples of 1 / SCALE, rounded outwards, which only makes zones larger.
Does not: know trees or dynamics (unroll.py).

A zone has one matrix an axis over its nodes: entry (p, q) bounds start(p) - start(q), node 0 stands for the number 0.
Matrices are closed: no entry can be lowered by going through a third node. The closure of bounds rounded up is closed.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import product
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError
from codegen.ir import Bool, Float64, WorldSpec
from verify.claims.region import Region

Int64 = npt.NDArray[np.int64]
Int8 = npt.NDArray[np.int8]
SCALE = 1 << 44
SLACK = 2.0**-30  # by which tests on positions are relaxed
GRID_SLACK = SCALE >> 30
LIMIT = 1 << 16  # sums of three bounds below 2 * LIMIT * SCALE stay within 64 bits
AXES = "xy"
ZERO = 0
MAX_STARTS = 1024  # zones that the "apart" pairs of a region may split it into
TRIED_POINTS = 16  # of a start zone, where a float64 start of a region is looked for
Matrix = list[list[Fraction]]


class Loose(NamedTuple):
    """The freedom that contacts leave to zones: offset and velocity may be larger by so much."""

    drift: Int64  # [n, agents, 2] of the offset, in 1 / SCALE
    gust: Float64  # [n, agents, 2] of the velocity


class Zones(NamedTuple):
    """A batch of zones, and how far each agent of the group has come: the same for all starts of a zone.

    Where contacts push, this is known between bounds only: then `offset` and `velocity` are the lower ones.
    """

    bounds: Int64  # [n, 2, nodes, nodes]
    offset: Int64  # [n, agents, 2] from the start, in 1 / SCALE
    velocity: Float64  # [n, agents, 2] the machine's own
    action: Int64  # [n, agents] the last choice; 0 before the first
    moved: Bool  # [n, agents, 2] whether it has ever had a speed; if not, it is bit for bit where it started
    went: Int8  # [n, tests] where tests on the start positions themselves led: 0 not asked, 1 left, 2 right
    origin: Int64  # [n] which of the start zones it is a part of
    loose: Loose | None  # None where nothing can push the group's agents

    def offsets(self, rows: Any, agent: int, axis: int) -> tuple[Int64, Int64]:
        """The bounds of an agent's offset in some zones, [n] each: the same where nobody collides."""
        low = self.offset[rows, agent, axis]
        return (low, low) if self.loose is None else (low, low + self.loose.drift[rows, agent, axis])

    def velocities(self, rows: Any, agent: int, axis: int) -> tuple[Int64, Int64]:
        """Bounds the velocity as `offsets` bounds the offset, in 1 / SCALE."""
        speed = self.velocity[rows, agent, axis]
        low = np.rint(speed * SCALE).astype(np.int64)
        if self.loose is None:
            return low, low
        return low, np.rint((speed + self.loose.gust[rows, agent, axis]) * SCALE).astype(np.int64)

    def take(self, rows: Any) -> "Zones":
        """Some of the zones, copied."""
        return self.part(rows, self.bounds[rows])

    def part(self, rows: Any, bounds: Int64) -> "Zones":
        """Some of the zones, with other bounds [rows, ...]; nothing is shared with these."""
        parts: list[Any] = [bounds, *(column[rows] for column in self[1:-1])]
        parts.append(self.loose and Loose(self.loose.drift[rows], self.loose.gust[rows]))
        return Zones(*parts)

    @staticmethod
    def at_start(bounds: Int64, origin: Int64, agents: int, tests: int, touching: bool = False) -> "Zones":
        """Zones of starts at rest; nobody has chosen yet. `touching`: contacts may push the agents, however little."""
        shape = (len(bounds), agents)
        nothing = np.zeros((*shape, 2), dtype=np.int64)
        moved, went = np.full((*shape, 2), touching), np.zeros((len(bounds), tests), dtype=np.int8)
        speed, action = np.zeros((*shape, 2)), np.zeros(shape, dtype=np.int64)
        loose = Loose(nothing.copy(), speed.copy()) if touching else None
        return Zones(bounds, nothing, speed, action, moved, went, origin, loose)

    @staticmethod
    def join(parts: Sequence["Zones"]) -> "Zones":
        """Several batches as one, in their order."""
        if len(parts) == 1:
            return parts[0]
        joined: list[Any] = [np.concatenate(columns) for columns in zip(*(part[:-1] for part in parts), strict=True)]
        loose = [part.loose for part in parts if part.loose is not None]
        joined.append(Loose(*map(np.concatenate, zip(*loose, strict=True))) if loose else None)
        return Zones(*joined)

    @property
    def count(self) -> int:  # pyright: ignore[reportIncompatibleMethodOverride]  # nobody counts a batch's members
        """The number of zones."""
        return self.bounds.shape[0]


def constrain_zones(bounds: Int64, axis: int, p: int, q: int, limit: Int64, room: int = 0) -> tuple[Int64, Int64]:
    """The zones cut by start(p) - start(q) <= limit [n]: (rows of those that are left, their bounds).

    `room`: by how much some start of a zone must stay below its limit, or the zone is dropped.
    """
    rows = np.flatnonzero(limit + bounds[:, axis, q, p] >= room)
    kept = bounds[rows]
    least = limit[rows]
    tight = np.flatnonzero(least < kept[:, axis, p, q])
    if tight.size:
        matrix = kept[tight, axis]
        through = matrix[:, :, p, None] + (least[tight, None] + matrix[:, q, :])[:, None, :]
        kept[tight, axis] = np.minimum(matrix, through)
    return rows, kept


def halves(zones: Zones, axis: int, p: int, q: int, limit: Int64) -> tuple[Zones, Zones]:
    """The parts with start(p) - start(q) <= limit [n], and those with more; edges belong to the first."""
    rows, bounds = constrain_zones(zones.bounds, axis, p, q, limit)
    # one unit of room: edges of edges would never end
    beyond, others = constrain_zones(zones.bounds, axis, q, p, -limit, room=1)
    return zones.part(rows, bounds), zones.part(beyond, others)


def intersect(whole: Int64, part: Int64, place: Sequence[int]) -> Int64:
    """Zones [n, 2, nodes, nodes] cut by others over some of their nodes, which are the first's nodes `place`."""
    bounds = whole.copy()
    nodes = np.array(place)
    bounds[..., nodes[:, None], nodes] = np.minimum(bounds[..., nodes[:, None], nodes], part)
    for node in range(bounds.shape[-1]):
        through = bounds[..., :, node, None] + bounds[..., None, node, :]
        np.minimum(bounds, through, out=bounds)
    return bounds


def hulls(bounds: Int64, origin: Int64) -> tuple[Int64, Int64]:
    """The smallest zone around all zones [n, ...] of the same origin, for each origin; and these origins."""
    origins, which = np.unique(origin, return_inverse=True)
    # the larger of two closed matrices, entry by entry, is closed
    around = np.full((len(origins), *bounds.shape[1:]), -4 * LIMIT * SCALE)
    np.maximum.at(around, which, bounds)
    return around, origins


# --- the region as exact start zones


@dataclass(frozen=True)
class Start:
    """One convex part of a region: an exact closed matrix for each axis over `names`, node 0 being the number 0."""

    names: tuple[str, ...]  # entities; node 1 is the first
    matrices: tuple[Matrix, Matrix]

    def project(self, entities: Sequence[str]) -> Int64:
        """Bounds over some entities only, rounded outwards, [2, nodes, nodes]."""
        place = [ZERO, *(1 + self.names.index(name) for name in entities)]
        return np.array([[[_up(matrix[p][q]) for q in place] for p in place] for matrix in self.matrices])


def _up(bound: Fraction) -> int:
    return -(-bound.numerator * SCALE // bound.denominator)


def starts(region: Region, world: WorldSpec) -> list[Start]:
    """The start zones of a region, all agents at rest; none when no world state at rest lies in it."""
    if any(not low <= 0 <= high for name, (low, high) in region.box.items() if _at_rest(name)):
        return []
    names = tuple(entity.name for entity in world.agents + world.landmarks)
    boxes: list[Matrix] = []
    for axis in AXES:
        intervals = [region.box[f"{name}.{axis}"] for name in names]
        upper, lower = [Fraction(0)] + [b[1] for b in intervals], [Fraction(0)] + [b[0] for b in intervals]
        nodes = range(len(upper))
        boxes.append([[Fraction(0) if p == q else upper[p] - lower[q] for q in nodes] for p in nodes])
    parts: list[tuple[Matrix, Matrix] | None] = [(boxes[0], boxes[1])]
    for a, b, (low, high) in region.differences:
        cut = [_below(part, names, a, b, high) for part in parts if part]
        parts = [_below(part, names, b, a, -low) for part in cut if part]
    for a, b, least in region.apart:
        sides = product(AXES, ((a, b), (b, a)))
        pairs = [(f"{near}.{axis}", f"{far}.{axis}") for axis, (near, far) in sides]
        parts = [_below(part, names, near, far, -least) for part in parts if part for near, far in pairs]
        parts = [part for part in parts if part]
        if len(parts) > MAX_STARTS:
            raise InputError(f"the region falls into more than {MAX_STARTS} parts", "apart", "keep fewer pairs apart")
    return [Start(names, part) for part in parts if part]


def _at_rest(name: str) -> bool:
    return name.endswith((".vx", ".vy"))


def _below(
    part: tuple[Matrix, Matrix], names: Sequence[str], a: str, b: str, limit: Fraction
) -> tuple[Matrix, Matrix] | None:
    """The part of a start zone with a - b <= limit; velocities are 0, coordinates of two axes cannot be compared."""
    axes = {name[-1] for name in (a, b) if not _at_rest(name)}
    if len(axes) > 1:
        raise InputError(
            f"{a} - {b} mixes two axes", "difference", "claims about episodes need differences on one axis"
        )
    axis = AXES.index(axes.pop()) if axes else 0
    p, q = (ZERO if _at_rest(name) else 1 + names.index(name[:-2]) for name in (a, b))
    cut = tighten_matrix(part[axis], p, q, limit)
    if cut is None:
        return None
    return (cut, part[1]) if axis == 0 else (part[0], cut)


def tighten_matrix(matrix: Matrix, p: int, q: int, limit: Fraction) -> Matrix | None:
    """An exact closed matrix with start(p) - start(q) <= limit added; None when nothing is left."""
    if limit + matrix[q][p] < 0:
        return None
    if limit >= matrix[p][q]:
        return matrix
    columns = range(len(matrix))
    onward = [limit + matrix[q][j] for j in columns]
    return [[min(row[j], row[p] + onward[j]) for j in columns] for row in matrix]


# --- points of a zone


def narrow_start(start: Start, entities: Sequence[str], bounds: Int64) -> Start | None:
    """A start zone within the bounds of a zone that came from it; None where nothing is left."""
    place = [ZERO, *(1 + start.names.index(name) for name in entities)]
    matrices: list[Matrix] = []
    for axis, exact in enumerate(start.matrices):
        matrix: Matrix | None = exact
        for p, q in product(range(len(place)), repeat=2):
            if matrix is not None:
                matrix = tighten_matrix(matrix, place[p], place[q], Fraction(int(bounds[axis, p, q]), SCALE))
        if matrix is None:
            return None
        matrices.append(matrix)
    return replace(start, matrices=(matrices[0], matrices[1]))


def point_in(start: Start, share: Float64) -> dict[str, float]:
    """A float64 point of a start zone: every position at its `share` [2, n] of what earlier positions leave open.

    Rounding may move the point by 2^-44.
    """
    point: dict[str, float] = {}
    for axis, matrix in enumerate(start.matrices):
        highest, lowest = [row[ZERO] for row in matrix], list(matrix[ZERO])  # the latter with the opposite sign
        for node, name in enumerate(start.names, 1):
            value = _between(-lowest[node], highest[node], float(share[axis, node - 1]))
            point[f"{name}.{AXES[axis]}"] = float(value)
            highest = [min(most, row[node] + value) for most, row in zip(highest, matrix, strict=True)]
            lowest = [min(most, gap - value) for most, gap in zip(lowest, matrix[node], strict=True)]
    return point


def points_of(parts: Sequence[Start], seed: int) -> Iterator[dict[str, float]]:
    """Float64 points near start zones, most of them inside: the middle of each part, then random ones of each."""
    rng = np.random.default_rng(seed)
    for trial in range(max(1, min(TRIED_POINTS, MAX_STARTS // max(1, len(parts))))):
        for part in parts:
            shape = (2, len(part.names))
            yield point_in(part, rng.uniform(0, 1, shape) if trial else np.full(shape, 0.5))


def _between(low: Fraction, high: Fraction, share: float) -> Fraction:
    """The number at `share` of an interval, with as few binary places as keep it inside it."""
    wanted = low + (high - low) * Fraction(share)
    for places in range(4, 52, 4):
        near = Fraction(round(wanted * 2**places), 2**places)
        if low <= near <= high and abs(near - wanted) * 8 <= high - low:
            return near
    return Fraction(float(wanted)) if low <= Fraction(float(wanted)) <= high else wanted
