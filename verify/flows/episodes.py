"""Episodes of a flow: many at a time in float64, and one so narrowly in enclosures that it surely breaks a claim.

Does: plays random starts, bounds among them, by Runge-Kutta steps, with errors that stay or change, and tells which
  break a claim; follows one course by the checker's steps, and says whether and when it surely breaks the claim.
Assumes: nothing of what is played is believed before it is replayed in enclosures; a start within the start region,
  errors within their bounds, which are asked again here.
Does not: prove a claim.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from functools import cached_property
from typing import NamedTuple, TypeVar

import numpy as np

from codegen.ir import Bool, Float64, Int64, PolicyProfile, act
from codegen.numbers import nearest_double
from verify.checker.covers.rounding import ceiling, ensure_arithmetic, floor
from verify.checker.flows.intervals import Spans
from verify.checker.flows.series import FlowReading, Stepping
from verify.checker.flows.steps import EXACT, FlowStep, Frame, build_frames
from verify.checker.flows.sweep import FlowSweep
from verify.reach.play import holds_states, observe_planes, value
from verify.reach.replay import is_start
from verify.reach.results import SystemCounterexample, Values
from verify.states.values import Batch
from verify.systems.claims import SystemClaim
from verify.systems.observing import ARRAYS, function
from verify.systems.system import Interval, System, bounds_of

PARTS = 8  # of a period
MAX_FOUND = 16
SEED = 0
Planes = dict[str, Float64]  # variable -> [batch]


class FlowCourse(NamedTuple):
    """The course of an episode: its start; and of each period in turn the errors of the derivatives, by how many
    seconds it is longer than stated, and which of the flow's ways to observe late its sample is. The last ones stay.
    """

    start: Mapping[str, Fraction]
    errors: Sequence[Mapping[str, Fraction]] = ({},)
    longer: Sequence[Fraction] = (Fraction(0),)
    ways: Sequence[int] = (0,)
    rank: int = 0  # which of the cases that hold a state is taken, in turn

    def errors_at(self, period: int) -> Mapping[str, Fraction]:
        """The errors in one period, by variable; 0 where none is named."""
        return self.errors[min(period, len(self.errors) - 1)]

    def longer_at(self, period: int) -> Fraction:
        """By how much one period is longer."""
        return self.longer[min(period, len(self.longer) - 1)]

    def way_at(self, period: int) -> int:
        """Returns the way in which one sample is observed late."""
        return self.ways[min(period, len(self.ways) - 1)]


class _Chances(NamedTuple):
    """The same of many episodes: errors that stay, in float64 by variable, [batch] each; the number of each, which says
    how its errors and samples change (`_draw_errors`, `_draw_sample`); and ranks.
    """

    errors: Planes
    turns: Int64
    rank: Int64


class FlowPlay:
    """Episodes of a team in a flow."""

    def __init__(self, profile: PolicyProfile, system: System, claim: SystemClaim) -> None:
        assert system.flow is not None
        self._profile, self._system, self._claim, self._flow = profile, system, claim, system.flow
        self._rates = [{name: function(rate, ARRAYS) for name, rate in each.rates.items()} for each in system.flow.each]
        self._jumps = [
            {name: function(after, ARRAYS) for name, after in each.jumps.items()} for each in system.flow.each
        ]
        errors = system.flow.errors
        self._ends = [{name: _floats(each.error.get(name, EXACT)) for name in errors} for each in system.flow.each]
        self._period = float(system.flow.period)

    def breaking(self, count: int, soonest: bool = False) -> Iterator[FlowCourse]:
        """Courses that break the claim in float64, at most MAX_FOUND of them. `soonest`: those that do so first."""
        random = np.random.default_rng(SEED)
        start = self._starts(count, random)
        if start is None:
            return
        size = len(next(iter(start.values())))
        bounds = self._flow.errors
        ends = {name: (nearest_double(low), nearest_double(high)) for name, (low, high) in bounds.items()}
        errors = {name: random.choice([low, high, 0.5 * (low + high)], size) for name, (low, high) in ends.items()}
        turns = np.arange(size)
        chances = _Chances(errors, turns, turns // 5 * bool(self._flow.cases))
        yield from self._find_broken(start, chances, MAX_FOUND, soonest)

    def _find_broken(self, start: Planes, chances: _Chances, most: int, soonest: bool = False) -> Iterator[FlowCourse]:
        """Courses that break the claim in float64, at most so many of them."""
        with np.errstate(all="ignore"):  # what overflows breaks nothing that could be replayed
            moments = self._find_moments(start, chances)
        broken = np.flatnonzero(moments >= 0)
        places = (broken[np.argsort(moments[broken], kind="stable")] if soonest else broken)[:most].tolist()
        periods = range(self._periods if places else 0)
        drawn = [self._draw_sample(chances.turns, period) for period in periods]
        moved = [self._draw_errors(chances, period) for period in periods]
        bounds, ends = self._flow.errors, self._start_ranges
        for place in places:
            begun = {x: _exact(float(values[place]), ends[x]) for x, values in start.items()}
            off = [{x: _exact(float(values[place]), bounds[x]) for x, values in each.items()} for each in moved]
            longer = [_exact(float(each[place]), self._flow.jitter) for each, _ in drawn]
            yield FlowCourse(begun, off, longer, [int(each[place]) for _, each in drawn], int(chances.rank[place]))

    @property
    def _periods(self) -> int:
        """The number of periods that may differ from one another."""
        changing = any(self._flow.jitter) or len(self._flow.seen) > 1 or self._flow.errors
        return max(self._claim.steps, 1) if changing else 1

    def _draw_errors(self, chances: _Chances, period: int) -> Planes:
        """The errors of a period: those that stay, those that alternate between their ends, and those that are drawn
        anew each time, in turn.
        """
        turns, random = chances.turns, np.random.default_rng((SEED + 1, period))
        kinds, later = np.where(turns < 0, 0, turns // 2 % 3), dict[str, Float64]()
        for name, stays in chances.errors.items():
            ends = np.array(_floats(self._flow.errors[name]))
            later[name] = np.choose(kinds, [stays, ends[(turns + period) % 2], random.choice(ends, len(turns))])
        return later

    def _draw_sample(self, turns: Int64, period: int) -> tuple[Float64, Int64]:
        """By how much a period is longer, and the way in which its sample is late, of episodes by their numbers: what
        stays, what alternates between the ends, and what is drawn anew each time, in turn. Below 0: what is stated.
        """
        ends = low, high = _floats(self._flow.jitter)
        count, random = len(self._flow.seen), np.random.default_rng((SEED, period))
        kinds = np.where(turns < 0, 0, 1 + turns // (3 * count) % 3)
        longer = [
            np.full(len(turns), min(max(0.0, low), high)),
            np.array([low, high, 0.5 * (low + high)])[turns % 3],
            np.array(ends)[(turns + period) % 2],
            random.choice(ends, len(turns)),
        ]
        ways = [
            np.zeros(len(turns), dtype=np.int64),
            turns // 3 % count,
            (turns // 2 + period) % 2 * (count - 1),
            random.integers(count, size=len(turns)),
        ]
        return np.choose(kinds, longer), np.choose(kinds, ways)

    def from_starts(self, starts: Sequence[Mapping[str, float]]) -> Iterator[FlowCourse]:
        """Courses from some starts that break the claim in float64: with samples as they are stated and the least
        errors, then with others.
        """
        if not starts:
            return
        tries = 9 * len(self._flow.seen) if self._periods > 1 else 0
        numbers = np.repeat(np.arange(-1, tries), len(starts))
        planes = {name: np.tile([start[name] for start in starts], 1 + tries) for name in starts[0]}
        planes |= {name: planes[of] for name, of in self._flow.kept.items()}
        least = {name: np.full(len(numbers), np.clip(0.0, *_floats(ends))) for name, ends in self._flow.errors.items()}
        chances = _Chances(least, numbers, np.zeros(len(numbers), dtype=np.int64))
        yield from self._find_broken(planes, chances, len(starts))

    def _find_moments(self, start: Planes, chances: _Chances) -> Int64:
        """The number of the moment at which each episode first breaks the claim, -1 where it does not."""
        claim, state, count = self._claim, start, len(chances.turns)
        moments, alive = np.full(count, -1), np.ones(count, dtype=np.bool_)
        for period in range(claim.steps + 1):
            bad, good = self._ask_claim(state, count, period)
            moments[alive & bad] = PARTS * period
            alive &= ~bad & ~good
            if period == claim.steps or not alive.any():
                break
            (longer, way), errors = self._draw_sample(chances.turns, period), self._draw_errors(chances, period)
            held = self._hold_inputs(state, way)
            known, case = {**state, **held}, self._case(state, chances.rank)
            for number, jumps in enumerate(self._jumps):
                state = state | {x: np.where(case == number, after(known), state[x]) for x, after in jumps.items()}
            for part in range(PARTS):
                state = self._move_state(state, held, (self._period + longer) / PARTS, errors, case)
                if part + 1 < PARTS and not claim.at_samples:
                    bad, good = self._ask_claim(state, count, period, between=True)
                    moments[alive & bad] = PARTS * period + part + 1
                    alive &= ~bad & ~good
        return moments

    def _ask_claim(self, state: Planes, count: int, period: int, between: bool = False) -> tuple[Bool, Bool]:
        """Where the claim is broken, and where it is fulfilled whatever comes."""
        claim, batch = self._claim, Batch(state, count)
        if claim.says.once:
            inside = batch.holds(claim.inside, {})
            last = period == claim.steps and not between
            return (~inside if last else np.zeros(count, dtype=np.bool_)), inside
        return batch.holds(claim.violation_at(period), {}), np.zeros(count, dtype=np.bool_)

    def _case(self, state: Planes, rank: Int64) -> Int64:
        """The case that each state is in; the first where none holds it, of which nothing is believed."""
        cases, size = self._flow.cases, len(rank)
        if not cases:
            return np.zeros(size, dtype=np.int64)
        holds = np.array([holds_states(case, state, size) for case in cases])
        wanted = rank % np.maximum(holds.sum(axis=0), 1)
        return np.asarray((holds & (holds.cumsum(axis=0) == wanted + 1)).argmax(axis=0), dtype=np.int64)

    def _move_state(self, state: Planes, held: Planes, h: Float64, errors: Planes, case: Int64) -> Planes:
        """The states after a step of `h` seconds."""

        def slope(now: Planes) -> Planes:
            known, after = {**now, **held}, dict[str, Float64]()
            for number, (rates, ends) in enumerate(zip(self._rates, self._ends, strict=True)):
                for name, rate in rates.items():
                    each = rate(known) + (np.clip(errors[name], *ends[name]) if name in errors else 0.0)
                    after[name] = np.where(case == number, each, after[name]) if number else each
            return after

        def along(rates: Planes, time: Float64) -> Planes:
            return {name: value + time * rates[name] for name, value in state.items()}

        first = slope(state)
        second = slope(along(first, h / 2))
        third = slope(along(second, h / 2))
        last = slope(along(third, h))
        return along({x: (first[x] + 2.0 * second[x] + 2.0 * third[x] + last[x]) / 6.0 for x in state}, h)

    def _hold_inputs(self, state: Planes, way: Int64) -> Planes:
        inputs: Planes = {}
        late = {name for each in self._flow.seen for name in each}
        observed = state | {
            name: np.choose(way, [state[each.get(name, name)] for each in self._flow.seen]) for name in late
        }
        for policy in self._profile.agents:
            chosen = act(policy, observe_planes(self._system, policy, observed))
            values = [self._flow.held[policy.agent, action.name] for action in policy.actions]
            for name in values[0]:
                inputs[name] = np.array([nearest_double(each[name]) for each in values])[chosen]
        return inputs

    @cached_property
    def _start_ranges(self) -> dict[str, Interval]:
        """The bounds of starts, by variable."""
        ranges = {one.name: one.range for one in self._system.variables}
        return bounds_of(self._system.start, ranges)

    def _starts(self, count: int, random: np.random.Generator) -> Planes | None:
        """Random starts, half of the numbers at a bound in half of them; None where none was found."""
        planes: Planes = {}
        for name, bounds in self._start_ranges.items():
            where = random.random(count)
            rounded = random.random(count) < np.where(np.arange(count) % 2, 0.5, 0.0)
            where = np.where(rounded, np.round(where), where)
            ends = _floats(bounds)
            planes[name] = np.clip(ends[0] + (ends[1] - ends[0]) * where, *ends)
        planes |= {name: planes[of] for name, of in self._flow.kept.items()}
        kept = np.ones(count, dtype=np.bool_)
        for half in self._system.start:
            if len(half.form.terms) > 1:
                kept &= value(half.form, planes) <= 0
        return {name: values[kept] for name, values in planes.items()} if kept.any() else None


def _exact(near: float, bounds: Interval) -> Fraction:
    """The exact number that a float stands for: an end of its bounds, or a number between them."""
    low, high = bounds
    ends = {nearest_double(low): low, nearest_double(high): high}
    return ends.get(near, min(max(Fraction(near), low), high))


def _floats(bounds: Interval) -> tuple[float, float]:
    return nearest_double(bounds[0]), nearest_double(bounds[1])


ORDER, FINER = 8, (4, 16, 64)  # of the series, and of a period: the next where enclosures are too wide
MAX_STEPS = 1_000_000  # of one replay
Value = TypeVar("Value")


def replay_course(
    profile: PolicyProfile, system: System, claim: SystemClaim, course: FlowCourse
) -> SystemCounterexample | None:
    """The episode of a course as a counterexample; None where it does not surely break the claim."""
    return FlowReplay(profile, system, claim).follow_course(course)


class FlowReplay:
    """Episodes of one question in enclosures. `left`: how many steps they may still take, all together."""

    def __init__(self, profile: PolicyProfile, system: System, claim: SystemClaim, left: int = MAX_STEPS) -> None:
        assert system.flow is not None
        self.system, self.flow, self.claim, self.left = system, system.flow, claim, left
        self.sweep = FlowSweep(profile, system, claim)
        names = [one.name for one in system.variables]
        self._readings = [FlowReading(each, names) for each in system.flow.each]
        self._steps: dict[tuple[int, Stepping], FlowStep] = {}

    def follow_course(self, course: FlowCourse) -> SystemCounterexample | None:
        """Replays a course as `replay_course` does, in the steps that are left."""
        bounds, (least, most) = self.flow.errors, self.flow.jitter
        within = all(each.keys() <= bounds.keys() for each in course.errors)
        for off in course.errors:
            within &= all(low <= off.get(name, Fraction(0)) <= high for name, (low, high) in bounds.items())
        within &= all(least <= each <= most for each in course.longer)
        within &= all(0 <= each < len(self.flow.seen) for each in course.ways)
        if not within or not is_start(self.system, self.claim, course.start):
            return None
        ensure_arithmetic()
        with np.errstate(all="ignore"):  # what is not finite is not shown
            for parts in FINER:
                episode = _Narrow(self, course, parts)
                counterexample = episode.follow()
                if counterexample is not None or not episode.lost:
                    return counterexample
        return None

    def step_of(self, case: int, how: Stepping, off: Mapping[str, Fraction]) -> FlowStep:
        """The step of a case, with some errors within its bounds."""
        flow = self.flow.each[case]
        if (case, how) not in self._steps:
            bounds = [flow.error.get(name, EXACT) for name in flow.rates]
            self._steps[case, how] = FlowStep(self._readings[case], bounds, how)
        exact = [off.get(name, Fraction(0)) for name in flow.rates]
        return self._steps[case, how].with_errors([(each, each) for each in exact])

    def cut_errors(self, case: int, off: Mapping[str, Fraction]) -> dict[str, Fraction]:
        """Errors of all variables that have any, each cut to the bounds of a case."""
        bounds = {name: self.flow.each[case].error.get(name, EXACT) for name in self.flow.errors}
        return {name: min(max(off.get(name, Fraction(0)), low), high) for name, (low, high) in bounds.items()}


class _Narrow:
    """One episode in enclosures."""

    def __init__(self, replay: FlowReplay, course: FlowCourse, parts: int) -> None:
        self._replay, self._sweep, self._claim = replay, replay.sweep, replay.claim
        self._parts, self.lost = parts, False  # whether an enclosure was not shown: steps are too long
        self._names = [one.name for one in replay.system.variables]
        self._course, self._taken, self._seconds = course, list[int](), Fraction(0)
        numbers = [course.start[name] for name in self._names]
        self._box = Spans(np.array([list(map(floor, numbers))]), np.array([list(map(ceiling, numbers))]))
        self._frames: tuple[Frame, ...] = (build_frames(self._box),)
        self._states: list[Values] = [dict(course.start)]
        self._actions: list[Mapping[str, str]] = []
        self._errors: list[Values] = []
        self._broken_between = False

    def follow(self) -> SystemCounterexample | None:
        """The counterexample; None where nothing sure is found."""
        claim = self._claim
        for period in range(claim.steps + 1):
            if not claim.says.once and self._surely_broken(self._box, period):
                return self._report_course(period)
            if claim.says.once and not self._sweep.surely_outside(self._box):
                return None
            if period == claim.steps:
                break
            joint = self._sweep.only_action(self._box, self._course.way_at(period))
            if joint is None:
                return None
            self._actions.append(self._sweep.name_actions(joint))
            held = self._sweep.inputs(np.array([joint]))
            cases = self._sweep.cases_of(self._box)
            if not cases:
                return None
            self._taken.append(cases[self._course.rank % len(cases)])
            jump = self._sweep.jumps[self._taken[-1]]
            if jump is not None:
                moved = jump.jump_sets(self._box, self._frames, held)
                self._box, self._frames = moved.box, moved.frames
                if not moved.shown.all() or moved.empty.any():
                    return None
            if not self._follow_period(period, held):
                return None
            middle = self._box.middle[0]
            self._states.append({name: Fraction(float(value)) for name, value in zip(self._names, middle, strict=True)})
            if self._broken_between:
                return self._report_course(period + 1)
        return self._report_course(claim.steps) if claim.says.once else None

    def _follow_period(self, period: int, held: Mapping[str, Spans]) -> bool:
        """Follows a period up to where it surely breaks the claim; whether all of that was shown."""
        claim, length = self._claim, self._replay.flow.period + self._course.longer_at(period)
        how = Stepping(ORDER, length / self._parts)
        self._errors.append(self._replay.cut_errors(self._taken[-1], self._course.errors_at(period)))
        step = self._replay.step_of(self._taken[-1], how, self._errors[-1])
        for part in range(self._parts):
            self._replay.left -= 1
            if self._replay.left < 0:
                return False
            moved = step.move_sets(self._box, self._frames, held)
            if not moved.shown.all() or moved.empty.any():
                self.lost = True
                return False
            self._box, self._frames = moved.box, moved.frames
            self._seconds += how.seconds
            if claim.says.once and not claim.at_samples and not self._sweep.surely_outside(moved.tube):
                return False
            between = not claim.says.once and not claim.at_samples and part + 1 < self._parts
            self._broken_between = between and self._surely_broken(self._box, period)
            if self._broken_between:
                break
        return True

    def _surely_broken(self, box: Spans, period: int) -> bool:
        if self._claim.says.avoided:
            return self._sweep.surely_inside(box)
        return period >= self._claim.by and self._sweep.surely_outside(box)

    def _report_course(self, step: int) -> SystemCounterexample:
        course, cases, periods = self._course, self._replay.flow.cases, range(max(len(self._actions), 1))
        pieces = tuple(self._taken) if cases else ()
        return SystemCounterexample(
            tuple(self._states),
            tuple(self._actions),
            tuple(self._errors) if self._replay.flow.errors else (),
            pieces,
            step,
            tuple(cases[case].choice for case in pieces),
            self._seconds,
            _shorten([course.longer_at(period) for period in periods]),
            _shorten([course.way_at(period) for period in periods]),
            course.rank,
        )


def _shorten(values: Sequence[Value]) -> tuple[Value, ...]:
    """Values of which the last stays, as few as say the same."""
    count = len(values)
    while count > 1 and values[count - 2] == values[-1]:
        count -= 1
    return tuple(values[:count])
