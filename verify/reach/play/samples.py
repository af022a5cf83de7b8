"""Starts and errors that may break claims: played in float64, many at a time.

Does: plays random episodes of a stated system, with starts and errors at bounds among them, by its pieces or by rules
  as they are written; the courses that break claims. Starts lie anywhere, or in boxes that were left open.
Assumes: nothing of what it finds is believed before it is replayed exactly.
Does not: replay.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import accumulate, islice
from typing import NamedTuple

import numpy as np

from codegen.ir import AgentPolicy, Bool, Float64, Int32, Int64, PolicyProfile, act
from codegen.numbers import nearest_double
from verify.checker.systems.reading import SystemReading
from verify.claims.uncertified.values import Batch
from verify.progress import tell
from verify.reach.play.boxes import Boxes
from verify.reach.play.cases import Cases, has_cases
from verify.reach.replay import Course
from verify.systems.claims import SystemClaim
from verify.systems.expressions import Expression
from verify.systems.observing import ARRAYS, function
from verify.systems.statement import Rule
from verify.systems.system import Affine, Feature, Interval, Measure, Piece, System

MAX_COURSES = 16
ENOUGH, REDRAWS = 256, 24  # starts that meet all conditions; how often more are drawn until there are so many
Planes = dict[str, Float64]  # variable -> [batch]


class Starts(NamedTuple):
    """The number of episodes that start, and the boxes they start in, bounds [n, variables]; None: anywhere."""

    episodes: int
    boxes: tuple[Float64, Float64] | None = None


def courses(
    profile: PolicyProfile, system: System, claim: SystemClaim, starts: Starts, rules: Sequence[Rule] = ()
) -> Iterator[Course]:
    """Courses that break a claim in float64, at most MAX_COURSES, the short ones first. `rules`: those that move the
    state, in place of the system's pieces; then a course numbers rules, and its errors are theirs.
    """
    random = np.random.default_rng(0)
    start = random_starts(system, claim, starts, random)
    if start is None:
        return
    with np.errstate(all="ignore"):  # a state beyond float64 is a proposal like any other
        if claim.about_decisions:
            yield from _sample_decisions(profile, system, claim, start)
        else:
            yield from islice(_sample_courses(Play(profile, system, rules), claim, start, random), MAX_COURSES)


def random_starts(system: System, claim: SystemClaim, starts: Starts, random: np.random.Generator) -> Planes | None:
    """Random starts, half of the numbers at a bound in half of them; None where none was found. Where conditions leave
    few of those that are drawn, more are.
    """
    still, count = claim.about_decisions, starts.episodes
    polytope = () if still else system.start
    reading = SystemReading(system, [one.name for one in system.variables])
    branch = reading.start(polytope)
    if branch is None:
        return None

    def draw() -> Planes:
        planes: Planes = {}
        columns = {one.name: column for column, one in enumerate(system.variables)}
        for name in reading.order:
            where = random.random(count)
            rounded = random.random(count) < np.where(np.arange(count) % 2, 0.5, 0.0)
            where = np.where(rounded, np.round(where), where)
            if starts.boxes is None:
                width = sum(map(float, branch.motion.weights[name].values()))
                planes[name] = float(branch.at[name]) + width * where
            else:
                low, high = (ends[np.arange(count) % len(ends), columns[name]] for ends in starts.boxes)
                planes[name] = np.where(where == 1, high, low + (high - low) * where)  # a bound is met exactly
        kept = np.ones(count, dtype=np.bool_)
        for half in polytope:
            kept &= value(half.form, planes) <= 0
        if still and claim.regions:
            kept &= Batch(planes, count).holds(claim.inside, {})
        return {name: values[kept] for name, values in planes.items()}

    drawn = draw()
    for _ in range(REDRAWS):
        if len(next(iter(drawn.values()))) >= min(count, ENOUGH):
            break
        more = draw()
        drawn = {name: np.concatenate([values, more[name]])[:count] for name, values in drawn.items()}
    return drawn if len(next(iter(drawn.values()))) else None


def _sample_decisions(profile: PolicyProfile, system: System, claim: SystemClaim, start: Planes) -> Iterator[Course]:
    count = len(next(iter(start.values())))
    actions = {policy.agent: act(policy, observe_planes(system, policy, start)) for policy in profile.agents}
    broken = ~Batch(start, count).holds(claim.formula, actions)
    for place in np.flatnonzero(broken)[:MAX_COURSES]:
        yield Course({name: Fraction(float(values[place])) for name, values in start.items()})


def _sample_courses(play: Play, claim: SystemClaim, start: Planes, random: np.random.Generator) -> Iterator[Course]:
    """The courses that break a claim, at the earliest step first."""
    count = len(next(iter(start.values())))
    for step, state, going in play.walk(start, random, claim.steps):
        batch = Batch(state, count)
        broken = going & batch.holds(claim.violation_at(step), {})
        for place in np.flatnonzero(broken)[:MAX_COURSES]:
            yield play.course(start, int(place))
        going &= ~broken & ~batch.holds(claim.fulfilment_at(step), {})


class Play:
    """Episodes, a batch at a time."""

    def __init__(self, profile: PolicyProfile, system: System, rules: Sequence[Rule] = ()) -> None:
        """`rules`: as in `courses`."""
        self.profile, self.system = profile, system
        self._moving = rules or system.pieces
        self._boxes = Boxes(system)
        self._cases = Cases(self._moving) if rules or has_cases(system) else None
        self._errors: list[Planes] = []
        self._pieces: list[Int64] = []

    def walk(self, start: Planes, random: np.random.Generator, steps: int) -> Iterator[tuple[int, Planes, Bool]]:
        """Each step with the states and which episodes go on: whoever asks may end some of them."""
        state, count = start, len(next(iter(start.values())))
        alive = np.ones(count, dtype=np.bool_)
        extreme = random.random(count)
        for step in range(steps + 1):
            tell(step, steps, f"steps of {count:,} random episodes")
            yield step, state, alive
            if step < steps and alive.any():
                state, moved = self._step(state, count, extreme, random)
                alive &= moved

    def _step(self, state: Planes, count: int, extreme: Float64, random: np.random.Generator) -> tuple[Planes, Bool]:
        """The next states, and which of them are stated."""
        after = {name: np.zeros(count) for name in state}
        errors = {name: np.zeros(count) for name in state}
        actions = {
            policy.agent: act(policy, observe_planes(self.system, policy, state)) for policy in self.profile.agents
        }
        piece_of = self._holding(state, count, extreme, random)
        draws = _Draws(random, self._moving, count)
        held: set[int] = set(piece_of.tolist())
        for number in sorted(held - {-1}):
            draws.ahead_to(number)
            piece, here = self._moving[number], piece_of == number
            stated = {name: values[here] for name, values in state.items()}
            for name, form in piece.move.items():
                error = _errors(piece.error.get(name), extreme, random)[here]
                errors[name][here] = error
                after[name][here] = value(form, stated) + error
            for policy in self.profile.agents:
                self._act(policy, actions[policy.agent], piece, here, state, after)
        draws.ahead_to(len(self._moving))
        self._errors.append(errors)
        self._pieces.append(piece_of)
        return after, piece_of >= 0

    def _holding(self, state: Planes, count: int, extreme: Float64, random: np.random.Generator) -> Int64:
        """The number of what moves each state, [count]; -1 where nothing is stated."""
        if self._cases is None:
            return self._boxes.holding(state, count)
        held = self._cases.holding(state, count, _shares(extreme, random))
        if self._moving is self.system.pieces:
            return held
        # a rule without a box holds where no piece does
        return np.where(self._boxes.holding(state, count) < 0, -1, held)

    def _act(
        self, policy: AgentPolicy, actions: Int32, piece: Piece | Rule, here: Bool, state: Planes, after: Planes
    ) -> None:
        """Adds what an agent does to the states that a piece moves."""
        for action, spec in enumerate(policy.actions):
            effect = piece.effect.get((policy.agent, spec.name), {})
            if effect:
                taken = here & (actions == action)
                acted = {name: values[taken] for name, values in state.items()}
                for name, form in effect.items():
                    after[name][taken] += value(form, acted)

    def course(self, start: Planes, place: int) -> Course:
        """Returns the course of an episode so far."""

        def exactly(planes: Planes) -> Mapping[str, Fraction]:
            return {name: Fraction(float(values[place])) for name, values in planes.items()}

        return Course(exactly(start), list(map(exactly, self._errors)), [int(each[place]) for each in self._pieces])


class _Draws:
    """The place in a random stream from which each piece draws in a step, in order, whether a state lies in it or not.
    So what is played does not depend on where other episodes are.
    """

    def __init__(self, random: np.random.Generator, pieces: Sequence[Piece | Rule], count: int) -> None:
        assert isinstance(random.bit_generator, np.random.PCG64)
        self._bits = random.bit_generator
        self._drawn = [0, *accumulate(count * len(piece.move) for piece in pieces)]
        self._next = 0  # the first piece that has not drawn

    def ahead_to(self, piece: int) -> None:
        """Passes over the draws of all pieces up to one, which draws next."""
        self._bits.advance(self._drawn[piece] - self._drawn[self._next])
        self._next = piece + 1


def _errors(bounds: Interval | None, extreme: Float64, random: np.random.Generator) -> Float64:
    """Errors of a step: for a third always the lower bound, for a third always the upper one, else anywhere."""
    low, high = map(float, bounds or (0, 0))
    return low + (high - low) * _shares(extreme, random)


def _shares(extreme: Float64, random: np.random.Generator) -> Float64:
    """Numbers of a step in [0, 1]: for a third of the episodes always 0, for a third always 1, else anywhere."""
    return np.where(extreme < 1 / 3, 0.0, np.where(extreme < 2 / 3, 1.0, random.random(len(extreme))))


def observe_planes(system: System, policy: AgentPolicy, state: Planes) -> Float64:
    """Observations of an agent, [batch, n_features], not rounded."""
    features = system.features[policy.agent]
    columns = [_measure_feature(features[feature.name], state) for feature in policy.features]
    return (
        np.stack(np.broadcast_arrays(*columns), axis=1) if columns else np.zeros((len(next(iter(state.values()))), 0))
    )


def _measure_feature(feature: Feature, state: Planes) -> Float64:
    values = value(feature.form, state)
    if feature.measure is Measure.SIGN:
        return np.sign(values)
    if feature.measure is Measure.POSITIVE:
        return np.asarray(values > 0, dtype=np.float64)
    if feature.measure is Measure.EQUALS:
        return np.asarray(values == 0, dtype=np.float64)
    if feature.measure is Measure.CLIP and feature.bounds is not None:
        return np.clip(values, float(feature.bounds[0]), float(feature.bounds[1]))
    return values


def value(form: Affine | Expression, state: Planes) -> Float64:
    """Evaluates a form, or an expression, in states, [batch]."""
    if not isinstance(form, Affine):
        return np.broadcast_to(function(form, ARRAYS)(state), len(next(iter(state.values()))))
    total = np.full(len(next(iter(state.values()))), nearest_double(form.constant))
    for name, factor in form.terms:
        total = total + nearest_double(factor) * state[name]
    return total
