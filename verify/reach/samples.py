"""Starts and errors that may break a claim: played in float64, many at a time.

Does: plays random episodes of a stated system, with starts and errors at bounds among them; the courses that break it.
Assumes: nothing of what it finds is believed before it is replayed exactly.
Does not: replay.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from itertools import accumulate, islice

import numpy as np

from codegen.floats import nearest_double
from codegen.ir import AgentPolicy, Bool, Float64, Int32, Int64, PolicyProfile, act
from verify.checker.systems.reading import SystemReading
from verify.claims.uncertified.values import Batch
from verify.progress import tell
from verify.reach.boxes import Boxes
from verify.reach.cases import Cases, has_cases
from verify.reach.replay import Course
from verify.systems.claims import SystemClaim
from verify.systems.system import Affine, Feature, Interval, Measure, Piece, System

MAX_COURSES = 16
Planes = dict[str, Float64]  # variable -> [batch]


def courses(profile: PolicyProfile, system: System, claim: SystemClaim, count: int) -> Iterator[Course]:
    """Courses that break a claim in float64, at most MAX_COURSES."""
    random = np.random.default_rng(0)
    start = random_starts(system, claim, count, random)
    if start is None:
        return
    found = (
        _decided(profile, system, claim, start)
        if claim.about_decisions
        else Play(profile, system, claim).run(start, random)
    )
    with np.errstate(over="ignore", invalid="ignore"):  # a state beyond float64 is a proposal like any other
        yield from islice(found, MAX_COURSES)


def random_starts(system: System, claim: SystemClaim, count: int, random: np.random.Generator) -> Planes | None:
    """Random starts, half of the numbers at a bound in half of them; None where none was found."""
    polytope = () if claim.about_decisions else system.start
    reading = SystemReading(system, [one.name for one in system.variables])
    branch = reading.start(polytope)
    if branch is None:
        return None
    found: Planes = {}
    for name in reading.order:
        where = random.random(count)
        rounded = random.random(count) < np.where(np.arange(count) % 2, 0.5, 0.0)
        where = np.where(rounded, np.round(where), where)
        width = sum(map(float, branch.motion.weights[name].values()))
        found[name] = float(branch.at[name]) + width * where
    kept = np.ones(count, dtype=np.bool_)
    for half in polytope:
        kept &= value(half.form, found) <= 0
    if claim.about_decisions and claim.regions:
        kept &= Batch(found, count).holds(claim.inside, {})
    return {name: values[kept] for name, values in found.items()} if kept.any() else None


def _decided(profile: PolicyProfile, system: System, claim: SystemClaim, start: Planes) -> Iterator[Course]:
    count = len(next(iter(start.values())))
    actions = {policy.agent: act(policy, _seen(system, profile, policy.agent, start)) for policy in profile.agents}
    broken = ~Batch(start, count).holds(claim.formula, actions)
    for place in np.flatnonzero(broken):
        yield Course({name: Fraction(float(values[place])) for name, values in start.items()})


class Play:
    """Episodes, a batch at a time."""

    def __init__(self, profile: PolicyProfile, system: System, claim: SystemClaim) -> None:
        self.profile, self.system, self.claim = profile, system, claim
        self._boxes = Boxes(system)
        self._cases = Cases(system) if has_cases(system) else None
        self._errors: list[Planes] = []
        self._pieces: list[Int64] = []

    def run(self, start: Planes, random: np.random.Generator) -> Iterator[Course]:
        """The courses that break the claim, at the earliest step first."""
        for step, state, alive in self.walk(start, random):
            batch = Batch(state, len(alive))
            broken = alive & batch.holds(self.claim.broken(step), {})
            for place in np.flatnonzero(broken):
                yield self._course(start, int(place))
            alive &= ~broken & ~batch.holds(self.claim.fulfilled(step), {})

    def walk(self, start: Planes, random: np.random.Generator) -> Iterator[tuple[int, Planes, Bool]]:
        """Each step with the states and which episodes go on: whoever asks may end some of them."""
        state, count = start, len(next(iter(start.values())))
        alive = np.ones(count, dtype=np.bool_)
        extreme = random.random(count)
        for step in range(self.claim.steps + 1):
            tell(step, self.claim.steps, f"steps of {count:,} random episodes")
            yield step, state, alive
            if step < self.claim.steps and alive.any():
                state, moved = self._step(state, count, extreme, random)
                alive &= moved

    def _step(self, state: Planes, count: int, extreme: Float64, random: np.random.Generator) -> tuple[Planes, Bool]:
        """The next states, and which of them are stated."""
        after = {name: np.zeros(count) for name in state}
        errors = {name: np.zeros(count) for name in state}
        actions = {
            policy.agent: act(policy, _seen(self.system, self.profile, policy.agent, state))
            for policy in self.profile.agents
        }
        if self._cases is None:
            piece_of = self._boxes.holding(state, count)
        else:
            piece_of = self._cases.holding(state, count, _shares(extreme, random))
        draws = _Draws(random, self.system, count)
        held: set[int] = set(piece_of.tolist())
        for number in sorted(held - {-1}):
            draws.ahead_to(number)
            piece, here = self.system.pieces[number], piece_of == number
            stated = {name: values[here] for name, values in state.items()}
            for name, form in piece.move.items():
                error = _errors(piece.error.get(name), extreme, random)[here]
                errors[name][here] = error
                after[name][here] = value(form, stated) + error
            for policy in self.profile.agents:
                self._act(policy, actions[policy.agent], piece, here, state, after)
        draws.ahead_to(len(self.system.pieces))
        self._errors.append(errors)
        self._pieces.append(piece_of)
        return after, piece_of >= 0

    def _act(self, policy: AgentPolicy, actions: Int32, piece: Piece, here: Bool, state: Planes, after: Planes) -> None:
        """Adds what an agent does to the states that a piece moves."""
        for action, spec in enumerate(policy.actions):
            effect = piece.effect.get((policy.agent, spec.name), {})
            if effect:
                taken = here & (actions == action)
                acted = {name: values[taken] for name, values in state.items()}
                for name, form in effect.items():
                    after[name][taken] += value(form, acted)

    def _course(self, start: Planes, place: int) -> Course:
        def exactly(planes: Planes) -> Mapping[str, Fraction]:
            return {name: Fraction(float(values[place])) for name, values in planes.items()}

        return Course(exactly(start), list(map(exactly, self._errors)), [int(each[place]) for each in self._pieces])


class _Draws:
    """The place in a random stream from which each piece draws in a step, in order, whether a state lies in it or not.
    So what is played does not depend on where other episodes are.
    """

    def __init__(self, random: np.random.Generator, system: System, count: int) -> None:
        assert isinstance(random.bit_generator, np.random.PCG64)
        self._bits = random.bit_generator
        self._drawn = [0, *accumulate(count * len(piece.move) for piece in system.pieces)]
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


def _seen(system: System, profile: PolicyProfile, agent: str, state: Planes) -> Float64:
    """Observations of an agent, [batch, n_features]."""
    features = system.features[agent]
    columns = [_measured(features[feature.name], state) for feature in profile.policy(agent).features]
    return (
        np.stack(np.broadcast_arrays(*columns), axis=1) if columns else np.zeros((len(next(iter(state.values()))), 0))
    )


def _measured(feature: Feature, state: Planes) -> Float64:
    found = value(feature.form, state)
    if feature.measure is Measure.SIGN:
        return np.sign(found)
    if feature.measure is Measure.POSITIVE:
        return np.asarray(found > 0, dtype=np.float64)
    if feature.measure is Measure.EQUALS:
        return np.asarray(found == 0, dtype=np.float64)
    if feature.measure is Measure.CLIP and feature.bounds is not None:
        return np.clip(found, float(feature.bounds[0]), float(feature.bounds[1]))
    return found


def value(form: Affine, state: Planes) -> Float64:
    """What a form is in states, [batch]."""
    total = np.full(len(next(iter(state.values()))), nearest_double(form.constant))
    for name, factor in form.terms:
        total = total + nearest_double(factor) * state[name]
    return total
