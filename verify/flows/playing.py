"""Episodes of a flow in float64, many at a time: Runge-Kutta steps, by a reading of the file that is no checker's.

Does: plays random starts, bounds among them, with errors that stay or change; tells which break a claim.
Assumes: nothing of what it finds is believed before it is replayed in enclosures.
Does not: bound anything.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from functools import cached_property
from typing import NamedTuple

import numpy as np

from codegen.ir import Bool, Float64, Int64, PolicyProfile, act
from codegen.numbers import nearest_double
from verify.claims.uncertified.values import Batch
from verify.reach.play.samples import observe_planes
from verify.systems.claims import SystemClaim
from verify.systems.observing import ARRAYS, function
from verify.systems.system import FlowCase, HalfSpace, Interval, System

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
            {name: function(value, ARRAYS) for name, value in each.jumps.items()} for each in system.flow.each
        ]
        zero = Fraction(0), Fraction(0)
        self._ends = [
            {name: _floats(each.error.get(name, zero)) for name in system.flow.errors} for each in system.flow.each
        ]
        self._period = float(system.flow.period)

    def breaking(self, count: int) -> Iterator[FlowCourse]:
        """Courses that break the claim in float64, at most MAX_FOUND of them."""
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
        yield from self._find_broken(start, chances, MAX_FOUND)

    def _find_broken(self, start: Planes, chances: _Chances, most: int) -> Iterator[FlowCourse]:
        """Courses that break the claim in float64, at most so many of them."""
        with np.errstate(all="ignore"):  # what overflows breaks nothing that could be replayed
            broken = self._mark_broken(start, chances)
        places = np.flatnonzero(broken)[:most].tolist()
        periods = range(self._periods if places else 0)
        drawn = [self._draw_sample(chances.turns, period) for period in periods]
        moved = [self._draw_errors(chances, period) for period in periods]
        bounds, ends = self._flow.errors, self._start_ranges
        for place in places:
            begun = {name: _exact(float(values[place]), ends[name]) for name, values in start.items()}
            off = [
                {name: _exact(float(values[place]), bounds[name]) for name, values in each.items()} for each in moved
            ]
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
            ends = _floats(self._flow.errors[name])
            later[name] = np.choose(
                kinds, [stays, np.array(ends)[(turns + period) % 2], random.choice(ends, len(turns))]
            )
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

    def _mark_broken(self, start: Planes, chances: _Chances) -> Bool:
        claim, state, count = self._claim, start, len(chances.turns)
        broken, alive = np.zeros(count, dtype=np.bool_), np.ones(count, dtype=np.bool_)
        for period in range(claim.steps + 1):
            bad, good = self._ask_claim(state, count, period)
            broken |= alive & bad
            alive &= ~bad & ~good
            if period == claim.steps or not alive.any():
                break
            (longer, way), errors = self._draw_sample(chances.turns, period), self._draw_errors(chances, period)
            held = self._hold_inputs(state, way)
            known, case = {**state, **held}, self._case(state, chances.rank)
            for number, jumps in enumerate(self._jumps):
                state = state | {
                    name: np.where(case == number, value(known), state[name]) for name, value in jumps.items()
                }
            for part in range(PARTS):
                state = self._move_state(state, held, (self._period + longer) / PARTS, errors, case)
                if part + 1 < PARTS and not claim.at_samples:
                    bad, good = self._ask_claim(state, count, period, between=True)
                    broken |= alive & bad
                    alive &= ~bad & ~good
        return broken

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
        holds = np.array([_holds(case, state, size) for case in cases])
        wanted = rank % np.maximum(holds.sum(axis=0), 1)
        return np.asarray((holds & (holds.cumsum(axis=0) == wanted + 1)).argmax(axis=0), dtype=np.int64)

    def _move_state(self, state: Planes, held: Planes, h: Float64, errors: Planes, case: Int64) -> Planes:
        """The states after a step of `h` seconds."""

        def slope(now: Planes) -> Planes:
            known, after = {**now, **held}, dict[str, Float64]()
            for number, (rates, ends) in enumerate(zip(self._rates, self._ends, strict=True)):
                for name, rate in rates.items():
                    each = rate(known) + (
                        np.clip(errors[name], ends[name][0], ends[name][1]) if name in errors else 0.0
                    )
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
        for half in self._system.start:
            ranges = {name: _narrow_range(half, name, *bounds) for name, bounds in ranges.items()}
        return ranges

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
                kept &= _value(half, planes, count) <= 0
        return {name: values[kept] for name, values in planes.items()} if kept.any() else None


def _holds(case: FlowCase, state: Planes, size: int) -> Bool:
    """Where a case holds states."""
    inside = np.ones(size, dtype=np.bool_)
    for name, (low, high) in case.where.items():
        inside &= (nearest_double(low) <= state[name]) & (state[name] <= nearest_double(high))
    for half in case.when:
        value = _value(half, state, size)
        inside &= value < 0 if half.strict else value <= 0
    return inside


def _exact(near: float, bounds: Interval) -> Fraction:
    """The exact number that a float stands for: an end of its bounds, or a number between them."""
    low, high = bounds
    ends = {nearest_double(low): low, nearest_double(high): high}
    return ends.get(near, min(max(Fraction(near), low), high))


def _floats(bounds: Interval) -> tuple[float, float]:
    return nearest_double(bounds[0]), nearest_double(bounds[1])


def _narrow_range(half: HalfSpace, name: str, low: Fraction, high: Fraction) -> tuple[Fraction, Fraction]:
    match half.form.terms:
        case ((named, factor),) if named == name:
            end = -half.form.constant / factor
            return (low, min(high, end)) if factor > 0 else (max(low, end), high)
        case _:
            return low, high


def _value(half: HalfSpace, state: Planes, count: int) -> Float64:
    total = np.full(count, nearest_double(half.form.constant))
    for name, factor in half.form.terms:
        total += nearest_double(factor) * state[name]
    return total
