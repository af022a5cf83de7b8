"""Episodes of a flow in enclosures: one start, followed so narrowly that it surely breaks a claim, or nothing is said.

Does: follows a start with errors that stay, by the checker's steps; says whether and when it surely breaks the claim.
Assumes: a start within the start region, errors within their bounds; both are asked again here.
Does not: look for such starts.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from codegen.ir import PolicyProfile
from verify.checker.covers.rounding import ceiling, ensure_arithmetic, floor
from verify.checker.flows.series import FlowReading
from verify.checker.flows.spans import Spans
from verify.checker.flows.steps import EXACT, FlowStep, Frame, Stepping, build_frames
from verify.checker.flows.sweep import FlowSweep
from verify.flows.playing import FlowCourse
from verify.reach.replay import is_start
from verify.reach.results import SystemCounterexample, Values
from verify.systems.claims import SystemClaim
from verify.systems.system import Flow, Interval, System

ORDER, PARTS = 8, (4, 16, 64)  # of the series, and of a period: the next where enclosures are too wide
MAX_STEPS = 1_000_000  # of one replay


@dataclass
class StepsLeft:
    """How many steps replays may still take."""

    count: int = MAX_STEPS


def replay_course(
    profile: PolicyProfile, system: System, claim: SystemClaim, course: FlowCourse, left: StepsLeft | None = None
) -> SystemCounterexample | None:
    """The episode of a course as a counterexample; None where it does not surely break the claim in `left` steps."""
    left = left or StepsLeft()
    assert system.flow is not None
    bounds, (least, most) = system.flow.errors, system.flow.jitter
    within = all(low <= course.errors.get(name, Fraction(0)) <= high for name, (low, high) in bounds.items())
    within &= least <= course.longer <= most and 0 <= course.way < len(system.flow.seen)
    if not within or not course.errors.keys() <= bounds.keys() or not is_start(system, claim, course.start):
        return None
    ensure_arithmetic()
    with np.errstate(all="ignore"):  # what is not finite is not shown
        for parts in PARTS:
            episode = _Narrow(profile, system, claim, course, parts, left)
            counterexample = episode.follow()
            if counterexample is not None or not episode.lost:
                return counterexample
    return None


class _Narrow:
    """One episode in enclosures."""

    def __init__(
        self,
        profile: PolicyProfile,
        system: System,
        claim: SystemClaim,
        course: FlowCourse,
        parts: int,
        left: StepsLeft,
    ) -> None:
        assert system.flow is not None
        self._left = left
        self._parts, self.lost = parts, False  # whether an enclosure was not shown: steps are too long
        self._sweep, self._claim, self._system = FlowSweep(profile, system, claim), claim, system
        names = [one.name for one in system.variables]
        self._errors = {name: course.errors.get(name, Fraction(0)) for name in system.flow.errors}
        period = system.flow.period + course.longer
        how = Stepping(ORDER, period / parts)
        self._steps = [FlowStep(FlowReading(each, names), self._off(each), how) for each in system.flow.each]
        self._part, self._course, self._taken = how.seconds, course, list[int]()
        numbers = [course.start[name] for name in names]
        self._box = Spans(np.array([list(map(floor, numbers))]), np.array([list(map(ceiling, numbers))]))
        self._frames: tuple[Frame, ...] = (build_frames(self._box),)
        self._states: list[Values] = [dict(course.start)]
        self._actions: list[Mapping[str, str]] = []

    def _off(self, flow: Flow) -> list[Interval]:
        """The errors of a case: those of the course, cut to its bounds."""
        found: list[Interval] = []
        for name in flow.rates:
            low, high = flow.error.get(name, EXACT)
            error = min(max(self._errors.get(name, Fraction(0)), low), high)
            found.append((error, error))
        return found

    def follow(self) -> SystemCounterexample | None:
        """The counterexample; None where nothing sure is found."""
        claim = self._claim
        for period in range(claim.steps + 1):
            if not claim.says.once and self._surely_broken(self._box, period):
                return self._report_course(period, period * self._parts * self._part)
            if claim.says.once and not self._sweep.surely_outside(self._box):
                return None
            if period == claim.steps:
                break
            joint = self._sweep.only_action(self._box, self._course.way)
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
            for part in range(self._parts):
                self._left.count -= 1
                if self._left.count < 0:
                    return None
                moved = self._steps[self._taken[-1]].move_sets(self._box, self._frames, held)
                if not moved.shown.all() or moved.empty.any():
                    self.lost = True
                    return None
                self._box, self._frames = moved.box, moved.frames
                if claim.says.once and not claim.at_samples and not self._sweep.surely_outside(moved.tube):
                    return None
                between = not claim.says.once and not claim.at_samples and part + 1 < self._parts
                if between and self._surely_broken(self._box, period):
                    self._states.append(self._middle())
                    return self._report_course(period + 1, period * self._parts * self._part + (part + 1) * self._part)
            self._states.append(self._middle())
        return self._report_course(claim.steps, claim.steps * self._parts * self._part) if claim.says.once else None

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
        return {one.name: Fraction(float(value)) for one, value in zip(self._system.variables, middle, strict=True)}

    def _report_course(self, step: int, seconds: Fraction) -> SystemCounterexample:
        errors = tuple(dict(self._errors) for _ in self._actions) if self._errors else ()
        states, actions, course = tuple(self._states), tuple(self._actions), self._course
        flow = self._system.flow
        assert flow is not None
        pieces = tuple(self._taken) if flow.cases else ()
        taken = tuple(flow.cases[case].choice for case in pieces)
        return SystemCounterexample(
            states, actions, errors, pieces, step, taken, seconds, course.longer, course.way, course.rank
        )
