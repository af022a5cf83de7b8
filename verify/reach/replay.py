"""Exact episodes of a stated system: played in rationals, judged by a claim, made smaller.

Does: plays a start with given errors; says whether and where the episode breaks the claim; finds one with fewer digits
  and errors, never more steps, that breaks it as soon.
Assumes: a start within the start region, errors within their bounds; both are asked again here.
Does not: look for counterexamples.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

from codegen.ir import PolicyProfile
from verify.claims.formula import holds
from verify.reach.results import SystemCounterexample, Values
from verify.systems.claims import SystemClaim
from verify.systems.observing import choose_actions
from verify.systems.system import Piece, State, System, ensure_in_steps


@dataclass(frozen=True)
class Course:
    """The course of an episode: its start, the errors of each step, and the piece wherever two share a border."""

    start: Values
    errors: Sequence[Values] = ()  # what is not named is the bound nearest to 0
    pieces: Sequence[int] = ()


def replay_course(
    profile: PolicyProfile, system: System, claim: SystemClaim, course: Course
) -> SystemCounterexample | None:
    """The episode of a course as a counterexample; None where it breaks nothing, or leaves what is stated."""
    if not is_start(system, claim, course.start):
        return None
    if claim.about_decisions:
        actions = choose_actions(system, profile, course.start)
        kept = holds(claim.formula, course.start, actions)
        return (
            None if kept else SystemCounterexample((dict(course.start),), (_name_actions(profile, actions),), (), (), 0)
        )
    ensure_in_steps(system, "the replay of steps")
    taken, state = list[ExactStep](), course.start
    for number in range(claim.steps + 1):
        if holds(claim.violation_at(number), state, {}):
            return SystemCounterexample(
                (dict(course.start), *(step.after for step in taken)),
                tuple(step.actions for step in taken),
                tuple(step.error for step in taken),
                tuple(step.piece for step in taken),
                number,
                tuple(system.pieces[step.piece].choice for step in taken),
            )
        if number == claim.steps or holds(claim.fulfilment_at(number), state, {}):
            return None
        wanted = course.pieces[number] if number < len(course.pieces) else None
        errors: Values = course.errors[number] if number < len(course.errors) else {}
        step = take_step(profile, system, state, errors, wanted)
        if step is None:
            return None
        taken.append(step)
        state = step.after
    return None


def is_start(system: System, claim: SystemClaim, state: State) -> bool:
    """Returns True if a claim is about episodes that start in a state, or about decisions there."""
    if not all(one.range[0] <= state[one.name] <= one.range[1] for one in system.variables):
        return False
    if any(one.modes and state[one.name].denominator > 1 for one in system.variables):
        return False
    if claim.about_decisions:
        return not claim.regions or holds(claim.inside, state, {})
    return all(half.holds(state) for half in system.start) and holds(claim.spoken_of, state, {})


class ExactStep(NamedTuple):
    """A step: which piece moves the state, what agents do, its errors, and the next state."""

    piece: int
    actions: Mapping[str, str]
    error: Values
    after: Values


def take_step(
    profile: PolicyProfile, system: System, state: State, errors: Values, wanted: int | None = None
) -> ExactStep | None:
    """The step from a state by the wanted piece, if it holds that, and errors that are cut to their bounds; None where
    nothing is stated.
    """
    number = piece_of(system, state, wanted)
    if number is None:
        return None
    piece, actions = system.pieces[number], _name_actions(profile, choose_actions(system, profile, state))
    error = within(piece, errors)
    return ExactStep(number, actions, error, piece.step(state, actions, error))


def within(piece: Piece, given: Values) -> dict[str, Fraction]:
    """The errors of a step, each cut to its bounds."""
    return {name: min(max(given.get(name, Fraction(0)), low), high) for name, (low, high) in piece.error.items()}


def piece_of(system: System, state: State, wanted: int | None = None) -> int | None:
    """The first piece that holds a state, or the one wanted if it does; None where nothing is stated."""
    if wanted is not None and 0 <= wanted < len(system.pieces) and system.pieces[wanted].holds(state):
        return wanted
    return next((number for number, piece in enumerate(system.pieces) if piece.holds(state)), None)


def _name_actions(profile: PolicyProfile, actions: Mapping[str, int]) -> dict[str, str]:
    return {policy.agent: policy.actions[actions[policy.agent]].name for policy in profile.agents}


DIGITS = (0, 1, 2, 3, 4, 6, 8, 12)  # after the point


def shrink_counterexample(
    profile: PolicyProfile, system: System, claim: SystemClaim, counterexample: SystemCounterexample
) -> SystemCounterexample:
    """The counterexample from a start with as few decimal digits as one of a few roundings has, and without errors if
    that does; its errors are rounded too. It takes no more steps.
    """
    erring = any(any(each.values()) for each in counterexample.errors)
    for digits in DIGITS:
        start = _round_values(counterexample.start, digits)
        rounded: Sequence[Values] = [_round_values(each, digits) for each in counterexample.errors]
        for errors in ((), rounded, counterexample.errors) if erring else (rounded,):
            again = replay_course(profile, system, claim, Course(start, errors, counterexample.pieces))
            if again is not None and again.step <= counterexample.step:
                return again
    return counterexample


def _round_values(values: Values, digits: int) -> Mapping[str, Fraction]:
    return {name: round(value, digits) for name, value in values.items()}
