"""The checker's reading of episodes in which agents may push each other, and of claims that they keep apart.

Does: says who may push whom; bounds the force between two whose gap lies in a box; moves agents between bounds:
  offsets, velocities and pushes are intervals; asks how far apart the starts of two are that may touch, and whether
  pairs are too near.
Assumes: reading.py beside it, of which this is the form 3; `codegen.ir.WorldSpec`, of whose contacts this is a reading.
Does not: serve the zone engine (verify/episodes/contacts.py) or the simulator (codegen/dynamics.py), which have their
  own, or close branches (certificates.py).

Two entities whose centres are d apart, and that touch at the distance D, the sum of their sizes, push each other along
the line between their centres with C * overlap(d), where overlap(d) = k log(1 + exp((D - d) / k)), C is the force and k
the margin of contacts. So on one axis, with the gap g there and h on the other one, the first is pushed by
C overlap(d) g / d, where d^2 = g^2 + h^2. Overlap falls with d; g / d rises with g, and its size falls as |h| rises.
So over a box of gaps each of the two factors has its bounds at corners, and so has their product. Forces are integers
in 1 / GRID, a bound rounded away from what it bounds; no float takes part.

All starts of a branch have the same actions so far, but contacts push them differently. So each agent has an interval
of velocities and one of offsets from its start, and both hold what the machine has, for every start of the branch:

- A velocity's interval is stepped by exact rational arithmetic and then made larger by PAD = 2^-36 on each side. That
  covers the roundings of a step, in any order of its operations, and all pushes beyond Contact.reach; `_ensure` adds
  these up. Only an agent that has never had a speed, and that nothing can push, keeps exactly 0.
- An offset's interval adds the velocity's, so it lacks only the roundings of positions, which SLACK covers.
- An inequality about positions now is one about the starts whose bound is moved by the largest offset that lets it
  hold. Only where an answer may be given too seldom (being within a line: who is not beyond it), by the smallest.
- The force between two is that over the box of their gap: bounds of the starts' gap, offsets, SLACK.
  Bounds of the starts' gap come from the region's box. A proof may cut them: at any multiple of CUT, into a part with
  at most and one with at least so large a gap. Both parts are followed, so a cut needs no further reason.
- Agents that are not followed take any of their actions at every step. How far they get is bounded once, before any
  question, with everybody so (`_whatever`): they are pushed by all whom they may meet from anywhere in the region.
"""

from collections.abc import Iterable, Mapping, Sequence
from decimal import Context
from fractions import Fraction
from functools import lru_cache
from itertools import combinations
from math import exp, isqrt
from typing import Any, NamedTuple

from codegen.ir import PolicyProfile, WorldSpec
from verify.checker.episodes.reading import (
    ARRIVED,
    AWAY,
    CLAIM,
    FARTHEST,
    FREE,
    GRID,
    SLACK,
    Box,
    Gap,
    Interval,
    Matching,
    Node,
    Now,
    OpenBranchError,
    PartedReading,
    Place,
    Side,
    compute_push,
    ensure_stated,
)
from verify.checker.reading import RejectedError
from verify.claims.episodes import EpisodeClaim
from verify.claims.region import Region

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
    pushing: list[Contact] = []
    for i, j in combinations(range(len(everything)), 2):
        if i < agents and everything[i].collides and everything[j].collides and force:
            distance = Fraction(everything[i].size + everything[j].size)  # the machine adds the sizes as floats
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

    def greatest(end: int) -> int:
        if end > 0:  # towards the end of a gap that may be positive; else away from it, as weak as it may be
            return -(-most * end // isqrt(end * end + beside.least**2))
        return -(least * -end // (isqrt(end * end + beside.most**2) + 1))

    return -greatest(-gap[0]), greatest(gap[1])


def limit_speed(velocity: Box, limit: Fraction) -> Box:
    """Bounds of velocities between bounds whose speed is cut to a limit (length / s), their direction kept.

    A part of the velocity stays no smaller as it grows itself, and is cut the more the larger the other part is.
    """
    x, y = velocity
    return _cut(x, sizes(y), limit), _cut(y, sizes(x), limit)


def _cut(part: Interval, beside: Sizes, limit: Fraction) -> Interval:
    def greatest(end: int) -> int:
        speed = isqrt(end * end + beside.least**2) if end > 0 else isqrt(end * end + beside.most**2) + 1
        return end if speed <= limit * GRID else _up(end * limit * GRID / speed)

    return -greatest(-part[0]), greatest(part[1])


def _up(value: Fraction) -> int:
    return -(-value.numerator // value.denominator)


def _down(value: Fraction) -> int:
    return value.numerator // value.denominator


PAD = GRID >> 36
CUT = GRID >> 20  # the starts' gaps are cut at multiples of this
MAX_KNOWN = 1 << 16  # velocities that are looked up
GAP = -3  # the stage in which the gaps of those who may touch are asked, after the last agent's tree


class ContactReading(PartedReading):
    """One part of a claim, as in `EpisodeReading`, where pushes are known between bounds."""

    def __init__(
        self, profile: PolicyProfile, claim: EpisodeClaim, region: Region, goal: str | None, followed: Sequence[str],
        allowed: Sequence[Matching],
    ) -> None:  # fmt: skip
        world = profile.world
        self._apart, self.contacts = claim.apart, contacts(world)
        self._actions: list[list[Box]] = []  # what each action adds to the velocity in a step
        for one in world.agents:
            pushes = [compute_push(action.effect, one, world) for action in profile.policy(one.name).actions]
            exact = [(Fraction(x), Fraction(y)) for x, y in pushes]
            self._actions.append([(_around(x, x), _around(y, y)) for x, y in exact])
        super().__init__(profile, claim, region, goal, followed, allowed)
        entities = world.agents + world.landmarks
        self.places = [[self._number[f"{one.name}.{axis}"] for axis in "xy"] for one in entities]
        self._velocities = [[self._number[f"{one.name}.v{axis}"] for axis in "xy"] for one in world.agents]
        self._agents = world.agents
        self._touched = {number for pair in self.contacts for number in (pair.first, pair.second)}
        order = {agent: place for place, agent in enumerate(followed)}
        self._place = [order.get(one.name) for one in world.agents]  # of each agent among those followed
        self._step, self._damped = Fraction(world.dt), Fraction(1.0 - world.damping)
        boxes: list[Box] = [
            (_around(*region.box[f"{one.name}.x"]), _around(*region.box[f"{one.name}.y"])) for one in entities
        ]
        gaps = tuple(_less(boxes[pair.first], boxes[pair.second]) for pair in self.contacts)
        still = [0] * len(self.names)
        self.start = Now(0, (), still, [False] * len(still), still, gaps)
        self._asking = [number for number in range(len(gaps)) if set(self._find_places(number)) != {None}]
        self._velocity = lru_cache(MAX_KNOWN)(self._bound_velocity)  # most branches share their actions so far
        self._whatever = self._bound_places()

    def _bound_places(self) -> list[Now]:
        """Of each step where agents may be that do anything, from anywhere in the region."""
        bounds, number = [self.start], len(self._agents)
        everybody, pairs = [(agent, None) for agent in range(number)], range(len(self.contacts))
        for _ in range(self.steps):
            bounds.append(self._step_agents(bounds[-1], everybody, pairs, self.start))
        return bounds

    def strange(self, gap: Gap) -> bool:
        """Returns True if one of a pair may do anything."""
        return None in self._find_places(gap.pair)

    def _find_places(self, number: int) -> list[int | None]:
        """Of the agents in a pair their places among those followed."""
        pair = self.contacts[number]
        return [self._place[one] for one in (pair.first, pair.second) if one < len(self._agents)]

    def apart(self, gap: Gap, now: Now) -> bool:
        """Returns True if two whose starts differ so are too far apart to push each other."""
        return self.contacts[gap.pair].apart(self.gap(gap, now))

    @property
    def questions(self) -> tuple[Node, ...]:
        """The questions asked after the region: the claim, each agent's tree, and the gaps of those who may touch."""
        gaps = [Gap(number, starts) for number, starts in enumerate(self.start.gaps)]
        return *super().questions, *(self._halves(gap, axis, 0) for gap in gaps for axis in (0, 1))

    def _ensure(self, profile: PolicyProfile, claim: EpisodeClaim, region: Region, push: float) -> None:
        """See `EpisodeReading`; also ensures that PAD covers roundings of velocities and pushes left out."""
        world, pushing = profile.world, [0.0] * len(profile.world.agents + profile.world.landmarks)
        largest = ensure_stated(world, claim.steps, region)
        for pair in self.contacts:
            for number in pair[:2]:
                pushing[number] += float(pair.strongest)
        strongest = max(pushing)
        of_actions = [abs(end) for pushes in self._actions for box in pushes for part in box for end in part]
        push = max(push, max(of_actions) / GRID)
        place, speed, fastest = largest, 0.0, 0.0
        for _ in range(claim.steps):
            place += speed * world.dt
            speed = speed * (1 - world.damping) + push + world.dt * strongest
            fastest = max(fastest, speed)
        left_out = world.dt * len(self.contacts) * world.contact_force * world.contact_margin * exp(-SURE_MARGINS)
        of_velocity = 2.0**-50 * (fastest + push) + 2.0**-42 * world.dt * strongest + left_out
        of_position = claim.steps * 2.0**-51 * (place + world.dt * fastest)
        if not (2 * of_position + 2.0**-49 * place <= SLACK / GRID and max(place, fastest, strongest) <= FARTHEST):
            raise RejectedError(f"rounding over {claim.steps} steps may exceed the slack of the tests")
        if not of_velocity <= PAD / GRID / 2:
            raise RejectedError("roundings of this world's velocities may exceed what proofs allow for")

    def _build_claim(
        self, pairs: Sequence[tuple[str, str]], near: Mapping[Any, Any], allowed: Sequence[Matching]
    ) -> Node:
        """For `keeps_apart`, pair by pair: are they within all four lines, and so too near? All are left to the next.

        AWAY is then the answer that the claim fails, and ARRIVED that it does not.
        """
        if not self._apart:
            return super()._build_claim(pairs, near, allowed)
        node: Node = ARRIVED
        for pair in reversed(pairs):
            inside: Node = AWAY
            for _, within in near[pair]:
                inside = (self._side(within, inside, SLACK),)
            assert isinstance(inside, tuple)
            node = (FREE._replace(child=node), *inside)
        return node

    def bound(self, side: Side, now: Now) -> tuple[int, int, int]:
        """See `EpisodeReading`; reads the offset by which most starts give the answer, fewest where slack is taken."""
        upper, lower, most, slack, child = side
        if not isinstance(child, Gap):
            ends = (now.shift[lower] - now.most[upper]) if slack < 0 else (now.most[lower] - now.shift[upper])
            most += ends * self.unit + (slack if now.moved[upper] or now.moved[lower] else 0)
        return (upper if upper < self.nodes else 0), (lower if lower < self.nodes else 0), most

    def cut(self, gap: Gap, number: int) -> tuple[Side, ...]:
        """The two parts of a gap's starts that a number above 0 says: its axis, and where it is cut.

        RejectedError where that is not between its bounds.
        """
        place, axis = divmod(number - 1, 2)
        at = (place >> 1 if place % 2 == 0 else -(place + 1 >> 1)) * CUT
        low, high = gap.starts[axis]
        if not low < at < high:
            raise RejectedError("a gap is cut where it is not")
        return self._halves(gap, axis, at)

    def _halves(self, gap: Gap, axis: int, at: int) -> tuple[Side, Side]:
        pair, (low, high) = self.contacts[gap.pair], gap.starts[axis]
        first, second = self.places[pair.first][axis], self.places[pair.second][axis]
        most = at * self.unit
        below, above = gap.within(axis, (low, at)), gap.within(axis, (at, high))
        return Side(first, second, most, 0, below), Side(second, first, -most, 0, above)

    def onward(self, stage: int, answer: Node, chosen: tuple[int, ...], now: Now) -> Place | None:
        """See `EpisodeReading`; before a step the gaps are asked of all pairs that are not known to be apart."""
        if isinstance(answer, Gap):
            now = now._replace(gaps=(*now.gaps[: answer.pair], answer.starts, *now.gaps[answer.pair + 1 :]))
            return self._follow_choice(chosen, now, answer.pair + 1)
        assert stage != GAP and isinstance(answer, int)
        if stage == CLAIM and self._apart:
            if answer != ARRIVED:
                raise OpenBranchError(f"a branch is left open at step {now.step}: two may be too near there")
            return self._going_on(chosen, now) if now.step < self.steps else None
        return super().onward(stage, answer, chosen, now)

    def _follow_choice(self, chosen: tuple[int, ...], now: Now, pair: int = 0) -> Place | None:
        for number in self._asking:
            if number < pair:
                continue
            gap = Gap(number, now.gaps[number])
            if not self.apart(gap, now):
                return GAP, gap, chosen, now
        return super()._follow_choice(chosen, now)

    def gap(self, gap: Gap, now: Now) -> Box:
        """Bounds of the gap itself, as the machine has it, of bounds of the starts' gap."""
        pair = self.contacts[gap.pair]
        first, second = self.places[pair.first], self.places[pair.second]

        def along(axis: int) -> Interval:
            (low, high), p, q = gap.starts[axis], first[axis], second[axis]
            return low + now.shift[p] - now.most[q] - SLACK, high + now.most[p] - now.shift[q] + SLACK

        return along(0), along(1)

    def _later(self, now: Now, chosen: Sequence[int]) -> Now:
        """One step, between bounds: positions move with the old velocity, then actions and contacts push."""
        acting = [
            (agent, chosen[place] if chosen else None) for agent, place in enumerate(self._place) if place is not None
        ]
        return self._step_agents(now, acting, self._asking, self._whatever[now.step + 1])

    def _step_agents(
        self, now: Now, acting: Iterable[tuple[int, int | None]], pairs: Iterable[int], others: Now
    ) -> Now:
        """The step of some agents, each with its action (None: any), as some pairs push them. `others`: where those are
        that do not act here.
        """
        least, most, moved = others.shift.copy(), [*others.most], others.moved.copy()
        forces = self._forces(now, pairs)
        for agent, action in acting:
            first, second = self._velocities[agent]
            before = (now.shift[first], now.most[first]), (now.shift[second], now.most[second])
            after = self._velocity(agent, action, before, forces.get(agent, NOTHING))
            for axis, ((slow, fast), (low, high)) in enumerate(zip(before, after, strict=True)):
                place, velocity = self.places[agent][axis], self._velocities[agent][axis]
                least[place] = now.shift[place] + _times(self._step, slow)
                most[place] = now.most[place] - _times(self._step, -fast)
                moved[place] = now.moved[place] or (slow, fast) != (0, 0)
                least[velocity], most[velocity], moved[velocity] = low, high, True
        return Now(now.step + 1, (), least, moved, most, now.gaps)

    def _bound_velocity(self, agent: int, action: int | None, before: Box, force: Box) -> Box:
        """Bounds of an agent's velocity after a step: of its pushes and forces, of the limit, and of roundings."""
        actions = self._actions[agent] if action is None else [self._actions[agent][action]]

        def along(axis: int) -> Interval:
            low, high = min(push[axis][0] for push in actions), max(push[axis][1] for push in actions)
            (slow, fast), (weakest, strongest) = before[axis], force[axis]
            low += _times(self._damped, slow) + _times(self._step, weakest)
            high -= _times(self._damped, -fast) + _times(self._step, -strongest)
            return low, high

        speed, limit = (along(0), along(1)), self._agents[agent].max_speed
        (west, east), (south, north) = speed if limit is None else limit_speed(speed, Fraction(limit))
        room = 0 if west == east == south == north == 0 and agent not in self._touched else PAD
        return (west - room, east + room), (south - room, north + room)

    def _forces(self, now: Now, pairs: Iterable[int]) -> dict[int, Box]:
        """Bounds of what contacts push agents and landmarks, by number, length / s^2."""
        forces: dict[int, Box] = {}
        for number in pairs:
            pair, gap = self.contacts[number], self.gap(Gap(number, now.gaps[number]), now)
            if not pair.apart(gap):
                force = pair.push(gap)
                forces[pair.first] = _sum(forces.get(pair.first, NOTHING), force)
                forces[pair.second] = _less(forces.get(pair.second, NOTHING), force)
        return forces


def _around(low: Fraction, high: Fraction) -> Interval:
    """The interval between two numbers, in 1 / GRID."""
    return low * GRID // 1, -(-high * GRID // 1)


def _times(factor: Fraction, value: int) -> int:
    """Rounded down; of the negative value, and negated, it is rounded up."""
    return value * factor.numerator // factor.denominator


def _sum(one: Box, other: Box) -> Box:
    (x, y), (v, w) = one, other
    return (x[0] + v[0], x[1] + v[1]), (y[0] + w[0], y[1] + w[1])


def _less(one: Box, other: Box) -> Box:
    (x, y), (v, w) = one, other
    return (x[0] - v[1], x[1] - v[0]), (y[0] - w[1], y[1] - w[0])
