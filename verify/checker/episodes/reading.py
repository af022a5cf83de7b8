"""The checker's own reading of a claim about episodes: trees and distances as questions, moves as shifts of them.

Does: states one part of a claim as questions about start positions, says what follows an answer, and how agents move
  that nobody can push (contacts.py adds pushes).
Assumes: nothing beyond checker/reading.py and thresholds.py; belongs to the trusted base (checker/README.md).
Does not: serve the zone engine (verify/episodes/unroll.py), which has its own reading, or close branches
  (certificates.py). Its step and its bound of roundings are second readings on purpose, and not those of
  codegen/dynamics.py either.

Why start positions are enough. All starts with the same actions so far have the same velocities, bit for bit, and have
come equally far but for rounding. So a question about positions now is one about start positions, its bound moved by
how far agents have come, in multiples of 1 / GRID. Where no coordinate of it has ever moved, the question is exactly
the one about the starts (thresholds.py). Elsewhere every answer is allowed SLACK, 2^-30, more than it says. That covers
all rounding: a step errs by at most 2^-45 (the grid) and by a unit in the last place of a position and of its change;
operations of a velocity in another order change it by a few such units per step. `_ensure_exact` adds this up with each
term doubled, and for a difference of two positions once more.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from itertools import permutations
from math import sqrt
from typing import Any, NamedTuple, TypeAlias

from codegen.ir import NO_FEATURE, EntitySpec, PolicyProfile, WorldSpec
from verify.checker.reading import LONGEST, Flat, Reading, RejectedError, region_formula
from verify.claims.episodes import EpisodeClaim, KeepsApart
from verify.claims.formula import Linear, Or
from verify.claims.region import Region
from verify.kinds import Semantics

GRID, SLACK = 1 << 44, 1 << 14  # lengths are in 1 / GRID; SLACK of them are 2^-30
FARTHEST = 1 << 13  # of positions, length units
REGION, CLAIM = -2, -1  # stages before the agents' trees, which are 0, 1, ...
AWAY, ARRIVED = 0, 1  # answers of the stage CLAIM
MAX_STEPS = 10_000
MAX_PAIRS = 12  # of an agent and a landmark in one question: it has up to 2^MAX_PAIRS answers
Matching: TypeAlias = tuple[tuple[str, str], ...]  # (agent, landmark), or whoever it is to keep apart from
Interval: TypeAlias = tuple[int, int]  # least and greatest, in 1 / GRID
Box: TypeAlias = tuple[Interval, Interval]  # of x and y


class Side(NamedTuple):
    """One answer to a question: upper - lower <= most, and `slack` more once one of them has moved."""

    upper: int  # number of a coordinate; 0 is the number 0
    lower: int
    most: int  # in units of the episode
    slack: int
    child: "Node"


@dataclass(frozen=True)
class Gap:
    """The question how far apart the starts of two are that may push each other: they may be told apart further."""

    pair: int
    starts: Box  # of the first's position less the second's, at the start

    def within(self, axis: int, part: Interval) -> "Gap":
        """The same question for other bounds along an axis."""
        x, y = self.starts
        return Gap(self.pair, (part, y) if axis == 0 else (x, part))


Node: TypeAlias = "tuple[Side, ...] | Gap | int"  # a question; or the end: an action, AWAY or ARRIVED
FREE = Side(0, 0, 0, 0, 0)  # an answer that asks nothing of the start


class Now(NamedTuple):
    """The state after some steps that all starts of a branch share."""

    step: int
    speeds: tuple[tuple[float, float], ...]  # [agents] the machine's own
    shift: list[int]  # [coordinates] how far each has come; at least so far, where pushes are known between bounds
    moved: list[bool]  # [coordinates] whether it may differ from the start, bit for bit, but for `shift`
    most: Sequence[int] = ()  # [coordinates] how far each has come at most, where pushes are known between bounds
    gaps: tuple[Box, ...] = ()  # [pairs] between what bounds those who may push each other started from one another


Place: TypeAlias = tuple[int, Node, tuple[int, ...], Now]  # stage, question, the agents' last choices, state


class OpenBranchError(RejectedError):
    """A branch does not close, so the claim may fail."""


def matchings(profile: PolicyProfile, claim: EpisodeClaim) -> list[Matching]:
    """Returns the matchings that fulfil a claim: who may arrive where, at the named landmarks, or one for each agent in
    any way; or the one set of all pairs that keep apart.
    """
    team = [policy.agent for policy in profile.team(claim.team)]
    if isinstance(claim, KeepsApart):
        claim.ensure(profile)
        claim.check_ranges()
        return [tuple(claim.pairs(profile))]
    if claim.arrival is None:
        raise RejectedError(f"{claim.name} is not read")
    landmarks = [entity.name for entity in profile.world.landmarks]
    own = claim.arrival.landmarks
    if not team:
        raise RejectedError(f"the profile has no team {ascii(claim.team)[1:-1]}")
    if own and (len(set(own)) != len(team) or len(own) != len(team) or not set(own) <= set(landmarks)):
        raise RejectedError("the claim does not name a landmark of its own for each agent of the team")
    if not own and len(team) * len(landmarks) > MAX_PAIRS:
        raise RejectedError(f"the claim is about more than {MAX_PAIRS} pairs of an agent and a landmark")
    return [tuple(zip(team, each, strict=True)) for each in ([own] if own else permutations(landmarks, len(team)))]


class EpisodeReading:
    """One part of a claim: that some matching of `allowed` is arrived at, when `followed` agents act by their trees.

    RejectedError for worlds and claims that this reading does not cover.
    """

    parting = False  # whether each part of a choice is an answer of its own; else a choice asks nothing

    def __init__(
        self, profile: PolicyProfile, claim: EpisodeClaim, region: Region, goal: str | None, followed: Sequence[str],
        allowed: Sequence[Matching],
    ) -> None:  # fmt: skip
        world, entities = profile.world, {entity.name: entity for entity in profile.world.agents}
        if len(set(followed)) != len(followed) or not {agent for own in allowed for agent, _ in own} <= set(followed):
            raise RejectedError("the agents in the claim are not followed, or are followed twice")
        self.steps, self._always = claim.steps, claim.always  # asked at every step, or at the last one
        self._dt, self._kept = world.dt, 1.0 - world.damping
        places = [f"{entity.name}.{axis}" for entity in world.agents + world.landmarks for axis in "xy"]
        speeds = [f"{name}.v{axis}" for name in entities for axis in "xy"]
        self.names = ["", *places, *speeds]
        self.nodes = 1 + len(places)  # velocities are known numbers, so they have coordinate 0 as their node
        self._number = {name: number for number, name in enumerate(self.names)}
        self._policies = [profile.policy(agent) for agent in followed]
        self._movers = [entities[agent] for agent in followed]
        self._pushes = [
            [compute_push(action.effect, mover, world) for action in policy.actions]
            for mover, policy in zip(self._movers, self._policies, strict=True)
        ]
        strongest = max(abs(part) for pushes in self._pushes for push in pushes for part in push)
        self._ensure(profile, claim, region, strongest)
        self.answers = max(1 + ARRIVED, *(len(policy.actions) for policy in self._policies))
        tested = [p.features[int(f)].meaning for p in self._policies for f in p.tree.feature if f != NO_FEATURE]
        self._sees_speed = any(name in speeds for meaning in tested if meaning for _, name in meaning.terms)
        self._unknown = {name for name in self.names if name.rpartition(".")[0] in entities.keys() - set(followed)}
        self._read(region, goal, claim.radius, allowed)
        still = [0] * len(self.names)
        self.start = Now(0, ((0.0, 0.0),) * len(followed), still, [False] * len(still))

    def _ensure(self, profile: PolicyProfile, claim: EpisodeClaim, region: Region, push: float) -> None:
        """RejectedError unless this reading covers world and claim. `push`: the most that a step adds to a speed."""
        if claim.arrival is None:
            raise RejectedError(f"{claim.name} has proofs of another form")
        if any(entity.collides for entity in profile.world.agents):
            raise RejectedError("agents of this world can push each other, so proofs have another form")
        _ensure_exact(profile.world, claim.steps, ensure_stated(profile.world, claim.steps, region), push)

    def _read(self, region: Region, goal: str | None, radius: Fraction, allowed: Sequence[Matching]) -> None:
        """The questions. Bounds are whole multiples of a unit that fits all of them, times LONGEST."""
        reading = Reading([], goal)
        grid = reading.flat(Linear(((Fraction(1), "grid"),), Fraction(1, GRID)), True)
        parts = [part.parts if isinstance(part, Or) else (part,) for part in region_formula(region).parts]
        started = [[reading.flat(part, True) for part in group] for group in parts]
        pairs = tuple(dict.fromkeys(pair for own in allowed for pair in own))
        near = {pair: [[reading.flat(f, True) for f in both] for both in _nearness(*pair, radius)] for pair in pairs}
        trees = [reading.tree(policy, Semantics()) for policy in self._policies]
        self._edges = reading.edges()
        assert grid is not None
        self.unit = self._edges[grid[0][0]][2]
        largest = max(abs(most) for _, _, most in self._edges)
        self.far = 4 * LONGEST * (largest + FARTHEST * GRID * self.unit)  # of what is not bounded
        region_asked: Node = 0
        for group in reversed(started):
            region_asked = tuple(self._side(flat, region_asked, 0) for flat in group if flat is not None)
        self.region = region_asked
        self.claim = self._build_claim(pairs, near, allowed)
        self.trees = [self._tree(tree, 0) for tree in trees]

    @property
    def questions(self) -> tuple[Node, ...]:
        """The questions asked after the region: the claim, then each agent's tree."""
        return self.claim, *self.trees

    def _side(self, flat: Flat, child: Node, slack: int, unknown: Collection[str] = ()) -> Side:
        """An answer that all bounds of `flat` hold, one after the other; those on `unknown` coordinates ask nothing.

        Choices ask nothing either, unless they are parted: the answer is then given by more starts.
        """
        assert flat is not None
        side = FREE._replace(child=child)
        for number in reversed(flat[0]):
            upper, lower, most = self._edges[number]
            known = all(name in self._number and name not in unknown for name in (upper, lower))
            ends = (self._number[upper], self._number[lower], most, slack * self.unit) if known else FREE[:4]
            side = Side(*ends, child)
            child = (side,)
        return side

    def _tree(self, tree: Sequence[Any], place: int) -> Node:
        """A subtree of what `Reading.tree` gives; one that always chooses the same is that action."""
        if isinstance(tree[place], int):
            return tree[place]
        sides = [(flat, self._tree(tree, child)) for flat, child in tree[place] if flat is not None]
        ends = {child if isinstance(child, int) else -1 for _, child in sides}
        if len(ends) == 1 and -1 not in ends:
            return ends.pop()
        answers: list[Side] = []
        for flat, child in sides:  # a side of a test is one answer, or one for each part of its choice
            parts = flat[1][0] if self.parting and flat[1] else (flat,)
            ways = [self._side(part, child, SLACK, self._unknown) for part in parts]
            answers += ways[:1] if ways[0][:4] == FREE[:4] else ways
        return tuple(answers)

    def _build_claim(
        self, pairs: Sequence[tuple[str, str]], near: Mapping[Any, Any], allowed: Sequence[Matching]
    ) -> Node:
        """Pair by pair: is the agent beyond one of four lines, or else near? Until a matching is near, or none can be.

        Who is not beyond a line is within it, so of that answer `slack` is taken away.
        """
        if len(pairs) > MAX_PAIRS:
            raise RejectedError(f"the claim is about more than {MAX_PAIRS} pairs of an agent and a landmark")

        @cache
        def build_node(done: frozenset[tuple[str, str]], left: int) -> Node:
            if any(done.issuperset(own) for own in allowed):
                return ARRIVED
            if not any(done.union(pairs[left:]).issuperset(own) for own in allowed):
                return AWAY
            away, node = build_node(done, left + 1), build_node(done | {pairs[left]}, left + 1)
            if isinstance(node, int) and away == node:
                return node
            for beyond, within in reversed(near[pairs[left]]):
                node = (self._side(beyond, away, SLACK), self._side(within, node, -SLACK))
            return node

        return build_node(frozenset[tuple[str, str]](), 0)

    def bound(self, side: Side, now: Now) -> tuple[int, int, int]:
        """Returns the bound that an answer sets on the starts: (upper, lower, most), the ends as nodes."""
        upper, lower, most, slack, _ = side
        most += now.shift[lower] - now.shift[upper] + (slack if now.moved[upper] or now.moved[lower] else 0)
        return (upper if upper < self.nodes else 0), (lower if lower < self.nodes else 0), most

    def cut(self, gap: Gap, number: int) -> tuple[Side, ...]:
        """The two parts into which a number of a proof cuts a gap; RejectedError where nobody can be pushed."""
        raise RejectedError(f"pair {gap.pair} is cut at {number}, but agents of this world cannot push each other")

    def onward(self, stage: int, answer: Node, chosen: tuple[int, ...], now: Now) -> Place | None:
        """The next question after an answer; None when nothing is left to show. OpenBranchError when it may fail.

        Nobody has moved when agents choose for the second time, so then, if no speed is read, all choose as before;
        the last choice moves nobody before the end.
        """
        assert isinstance(answer, int), answer
        if stage == REGION:
            return self._ask_claim(chosen, now)
        if stage == CLAIM:
            if answer == ARRIVED:
                return None
            if now.step == self.steps:
                raise OpenBranchError("a branch is left open at the last step: the claim may fail there")
            return self._going_on(chosen, now)
        chosen = (*chosen, answer)
        if len(chosen) < len(self.trees):
            return len(chosen), self.trees[len(chosen)], chosen, now
        return self._follow_choice(chosen, now)

    def _ask_claim(self, chosen: tuple[int, ...], now: Now) -> Place | None:
        """The claim, where it is asked now."""
        if self._always or now.step == self.steps:
            return CLAIM, self.claim, chosen, now
        return self._going_on(chosen, now)

    def _going_on(self, chosen: tuple[int, ...], now: Now) -> Place | None:
        if now.step < self.steps - 1 and (now.step != 1 or self._sees_speed):
            return 0, self.trees[0], (), now
        return self._ask_claim(chosen, self._later(now, chosen))

    def _follow_choice(self, chosen: tuple[int, ...], now: Now) -> Place | None:
        """Returns the place that follows when all agents that are followed have chosen."""
        return self._ask_claim(chosen, self._later(now, chosen))

    def _later(self, now: Now, chosen: Sequence[int]) -> Now:
        """One step: positions move with the old velocity, then actions push; who has not chosen yet is not pushed."""
        shift, moved = now.shift.copy(), now.moved.copy()
        speeds: list[tuple[float, float]] = []
        for place, mover in enumerate(self._movers):
            speed: list[float] = []
            pushes = self._pushes[place][chosen[place]] if chosen else (0.0, 0.0)
            for axis, old, push in zip("xy", now.speeds[place], pushes, strict=True):
                number = self._number[f"{mover.name}.{axis}"]
                shift[number] += round(old * self._dt * GRID) * self.unit
                moved[number] |= old != 0
                speed.append(old * self._kept + push)
            size = sqrt(speed[0] * speed[0] + speed[1] * speed[1])
            if mover.max_speed is not None and size > mover.max_speed:
                speed = [part / size * mover.max_speed for part in speed]
            for axis, part in zip("xy", speed, strict=True):
                number = self._number[f"{mover.name}.v{axis}"]
                shift[number], moved[number] = round(part * GRID) * self.unit, True
            speeds.append((speed[0], speed[1]))
        return Now(now.step + 1, tuple(speeds), shift, moved)


class PartedReading(EpisodeReading):
    """The same, where each part of a choice is an answer of its own: that something is not 0 has two."""

    parting = True


def compute_push(effect: tuple[float, float] | None, mover: EntitySpec, world: WorldSpec) -> tuple[float, float]:
    """Returns what an action adds to the velocity in a step."""
    if effect is None:
        raise RejectedError(f"the profile does not say how {mover.name}'s actions push")
    return effect[0] * mover.force * world.dt, effect[1] * mover.force * world.dt


def _nearness(agent: str, landmark: str, radius: Fraction) -> list[tuple[Linear, Linear]]:
    """(beyond, within) for each of the four sides of the square around a landmark; its edge is within."""
    sides: list[tuple[Linear, Linear]] = []
    for axis in "xy":
        for sign in (1, -1):
            ahead = ((Fraction(sign), f"{agent}.{axis}"), (Fraction(-sign), f"{landmark}.{axis}"))
            back = tuple((-weight, name) for weight, name in ahead)
            sides.append((Linear(back, -radius, True), Linear(ahead, radius)))
    return sides


def ensure_stated(world: WorldSpec, steps: int, region: Region) -> float:
    """The region's largest coordinate. RejectedError unless the world's spec says how agents move, and the region
    bounds where they start.
    """
    if not (world.dt > 0 and 0 <= world.damping <= 1):
        raise RejectedError("the world's spec does not say how agents move")
    if not 0 <= steps <= MAX_STEPS:
        raise RejectedError(f"the claim's steps must be 0 to {MAX_STEPS}")
    if not {f"{entity.name}.{axis}" for entity in world.agents + world.landmarks for axis in "xy"} <= region.box.keys():
        raise RejectedError("the region does not bound all positions")
    largest = max(abs(bound) for bounds in region.box.values() for bound in bounds)
    if largest > FARTHEST:
        raise RejectedError(f"the region reaches beyond {FARTHEST}")
    return float(largest)


def _ensure_exact(world: WorldSpec, steps: int, largest: float, push: float) -> None:
    """RejectedError unless SLACK covers all rounding. `push`: the most that a step adds to the speed along an axis."""
    place = largest
    speed = fastest = 0.0
    for _ in range(steps):
        place += speed * world.dt
        speed = speed * (1 - world.damping) + push
        fastest = max(fastest, speed)
    error = steps * (2.0**-44 + 2.0**-52 * place + 6 * steps * world.dt * 2.0**-53 * fastest)
    if not (2 * error + 2.0**-49 * place <= SLACK / GRID and max(place, fastest) <= FARTHEST):
        raise RejectedError(f"rounding over {steps} steps may exceed the slack of the tests")
