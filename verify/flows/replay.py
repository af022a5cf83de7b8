"""Episodes of a flow in enclosures: one start, followed so narrowly that it surely breaks a claim, or nothing is said.

Does: follows a start with the errors of its course, by the checker's steps; says whether and when it surely breaks the
  claim.
Assumes: a start within the start region, errors within their bounds; both are asked again here.
Does not: look for such starts.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import TypeVar

import numpy as np

from codegen.ir import PolicyProfile
from verify.checker.covers.rounding import ceiling, ensure_arithmetic, floor
from verify.checker.flows.programs import Stepping
from verify.checker.flows.series import FlowReading
from verify.checker.flows.spans import Spans
from verify.checker.flows.steps import EXACT, FlowStep, Frame, build_frames
from verify.checker.flows.sweep import FlowSweep
from verify.flows.playing import FlowCourse
from verify.reach.replay import is_start
from verify.reach.results import SystemCounterexample, Values
from verify.systems.claims import SystemClaim
from verify.systems.system import System

ORDER, PARTS = 8, (4, 16, 64)  # of the series, and of a period: the next where enclosures are too wide
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
        within = all(
            low <= each.get(name, Fraction(0)) <= high for each in course.errors for name, (low, high) in bounds.items()
        )
        within &= all(each.keys() <= bounds.keys() for each in course.errors)
        within &= all(least <= each <= most for each in course.longer)
        within &= all(0 <= each < len(self.flow.seen) for each in course.ways)
        if not within or not is_start(self.system, self.claim, course.start):
            return None
        ensure_arithmetic()
        with np.errstate(all="ignore"):  # what is not finite is not shown
            for parts in PARTS:
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
            if not self._make_jump(held, self._taken[-1]):
                return None
            if not self._follow_period(period, held):
                return None
            self._states.append(self._middle())
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

    def _make_jump(self, held: Mapping[str, Spans], case: int) -> bool:
        """Makes the jump of a sample; whether it was enclosed."""
        jump = self._sweep.jumps[case]
        if jump is None:
            return True
        moved = jump.jump_sets(self._box, self._frames, held)
        self._box, self._frames = moved.box, moved.frames
        return bool(moved.shown.all() and not moved.empty.any())

    def _surely_broken(self, box: Spans, period: int) -> bool:
        if self._claim.says.avoided:
            return self._sweep.surely_inside(box)
        return period >= self._claim.by and self._sweep.surely_outside(box)

    def _middle(self) -> Values:
        middle = self._box.middle[0]
        return {name: Fraction(float(value)) for name, value in zip(self._names, middle, strict=True)}

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
