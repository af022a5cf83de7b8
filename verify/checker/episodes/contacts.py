"""The checker's own reading of contacts: bounds of the forces by which entities that touch push each other apart.

Does: says who may push whom; bounds the force between two whose gap lies in a box, and velocities cut to a speed limit.
Assumes: `codegen.ir.WorldSpec`, of whose contacts this is a reading.
Does not: serve the zone engine (verify/episodes) or the simulator (codegen/dynamics.py), which have their own.

Two entities whose centres are d apart, and that touch at the distance D, the sum of their sizes, push each other along
the line between their centres with C * overlap(d), where overlap(d) = k log(1 + exp((D - d) / k)), C is the force and k
the margin of contacts. So on one axis, with the gap g there and h on the other one, the first is pushed by
C overlap(d) g / d, where d^2 = g^2 + h^2. Overlap falls with d; g / d rises with g, and its size falls as |h| rises.
So over a box of gaps each of the two factors has its bounds at corners, and so has their product.

All numbers here are integers in 1 / GRID, a bound rounded away from what it bounds; no float takes part.
"""

from collections.abc import Mapping
from decimal import Context
from fractions import Fraction
from itertools import combinations
from math import isqrt
from typing import NamedTuple

from codegen.ir import WorldSpec
from verify.checker.episodes.reading import GRID, Box, Interval

SURE_MARGINS = 32  # from so many margins beyond touching on, a force is below C k exp(-32); it is left out here
TAIL = 80  # beyond so many margins the overlap differs from max(0, D - d) by less than k exp(-80)
ONE_PLACE = Fraction(1, 10**150)  # claims are not about episodes in which two centres come so near: no force is stated
DIGITS = Context(prec=40, traps=[])  # what is computed with it is far nearer than 1 / GRID

NOTHING: Box = (0, 0), (0, 0)


class Sizes(NamedTuple):
    """Of an interval: how small and how large its numbers may be, signs aside."""

    least: int
    most: int


def sizes(interval: Interval) -> Sizes:
    """The sizes of an interval's numbers."""
    low, high = interval
    return Sizes(max(low, -high, 0), max(-low, high))


class Contact(NamedTuple):
    """Two entities that may push each other: numbers of agents, then of landmarks. The first is an agent."""

    first: int
    second: int
    force: Fraction  # C
    margin: Fraction  # k
    touching: Fraction  # D

    reach: int  # from this distance on what they push is left out

    @property
    def strongest(self) -> Fraction:
        """More than the force can be: the overlap is at most D + k."""
        return self.force * (self.touching + self.margin)

    def apart(self, gap: Box) -> bool:
        """Returns True if all gaps of a box are so large that pushes are left out."""
        (west, east), (south, north) = gap
        x, y = max(west, -east, 0), max(south, -north, 0)
        return x >= self.reach or y >= self.reach or x * x + y * y >= self.reach * self.reach

    def push(self, gap: Box) -> Box:
        """Bounds of the force on the first, where its gap from the second lies in a box."""
        if self.apart(gap):
            return NOTHING
        x, y = sizes(gap[0]), sizes(gap[1])
        most = _up(self.force * self.overlap(isqrt(x.least**2 + y.least**2))[1])
        least = _down(self.force * self.overlap(isqrt(x.most**2 + y.most**2) + 1)[0])
        return _along(gap[0], y, least, most), _along(gap[1], x, least, most)

    def overlap(self, distance: int) -> Interval:
        """Bounds of the overlap at a distance."""
        inside = self.touching * GRID - distance
        margins = abs(inside) / (self.margin * GRID)
        rest = Fraction(0)
        if margins < TAIL:
            share = DIGITS.exp(DIGITS.divide(-margins.numerator, margins.denominator))
            log = Fraction(DIGITS.ln(DIGITS.add(1, share)))
            rest = self.margin * GRID * log
        overlap = max(inside, Fraction(0)) + rest
        return max(0, _down(overlap) - 1), _up(overlap) + 1


def contacts(world: WorldSpec) -> tuple[Contact, ...]:
    """All pairs that may push each other: both collide, and an agent is one of them."""
    everything, agents = world.agents + world.landmarks, len(world.agents)
    force, margin = Fraction(world.contact_force), Fraction(world.contact_margin)
    pairs = [(i, j) for i, j in combinations(range(len(everything)), 2) if i < agents]
    touching = [(i, j) for i, j in pairs if everything[i].collides and everything[j].collides and force]
    # the machine adds the sizes as floats
    pushing: list[Contact] = []
    for i, j in touching:
        distance = Fraction(everything[i].size + everything[j].size)
        pushing.append(Contact(i, j, force, margin, distance, _up((distance + SURE_MARGINS * margin) * GRID)))
    return tuple(pushing)


def coincident(world: WorldSpec, start: Mapping[str, Fraction]) -> bool:
    """Returns True if the centres of two that push each other start in one place."""
    names = [entity.name for entity in world.agents + world.landmarks]
    pairs = [(names[pair.first], names[pair.second]) for pair in contacts(world)]
    return any(all(abs(start[f"{a}.{axis}"] - start[f"{b}.{axis}"]) <= ONE_PLACE for axis in "xy") for a, b in pairs)


def _along(gap: Interval, beside: Sizes, least: int, most: int) -> Interval:
    """Bounds of a force along one axis: its size between two bounds, its share there that of the gap in the distance.

    `beside`: the sizes of the gap on the other axis.
    """
    return -_greatest(-gap[0], beside, least, most), _greatest(gap[1], beside, least, most)


def _greatest(end: int, beside: Sizes, least: int, most: int) -> int:
    """The greatest force on an axis on which the gap is at most `end`: towards `end` for a gap that may be positive,
    else away from it, and then as weak as it may be.
    """
    if end > 0:
        return -(-most * end // isqrt(end * end + beside.least**2))
    return -(least * -end // (isqrt(end * end + beside.most**2) + 1))


def limit_speed(velocity: Box, limit: Fraction) -> Box:
    """Bounds of velocities between bounds whose speed is cut to a limit (length / s), their direction kept.

    A part of the velocity stays no smaller as it grows itself, and is cut the more the larger the other part is.
    """
    x, y = velocity
    return _cut(x, sizes(y), limit), _cut(y, sizes(x), limit)


def _cut(part: Interval, beside: Sizes, limit: Fraction) -> Interval:
    return -_greatest_cut(-part[0], beside, limit), _greatest_cut(part[1], beside, limit)


def _greatest_cut(end: int, beside: Sizes, limit: Fraction) -> int:
    speed = isqrt(end * end + beside.least**2) if end > 0 else isqrt(end * end + beside.most**2) + 1
    if speed <= limit * GRID:
        return end
    return _up(end * limit * GRID / speed)


def _up(value: Fraction) -> int:
    return -(-value.numerator // value.denominator)


def _down(value: Fraction) -> int:
    return value.numerator // value.denominator
