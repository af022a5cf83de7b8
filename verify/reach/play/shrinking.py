"""A counterexample made smaller: fewer digits, fewer errors, never more steps.

Does: replays rounded starts and errors, the short ones first, and keeps the first that breaks the claim as soon.
Assumes: an exact counterexample.
Does not: look for other episodes.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction

from codegen.ir import PolicyProfile
from verify.reach.replay import Course, replay_course
from verify.reach.results import SystemCounterexample, Values
from verify.systems.claims import SystemClaim
from verify.systems.system import System

DIGITS = (0, 1, 2, 3, 4, 6, 8, 12)  # after the point


def shrink_counterexample(
    profile: PolicyProfile, system: System, claim: SystemClaim, counterexample: SystemCounterexample
) -> SystemCounterexample:
    """The counterexample from a start with as few decimal digits as one of a few roundings has, and without errors if
    that does; its errors are rounded too. It takes no more steps.
    """
    for course in _shorter(counterexample):
        again = replay_course(profile, system, claim, course)
        if again is not None and again.step <= counterexample.step:
            return again
    return counterexample


def _shorter(counterexample: SystemCounterexample) -> Iterator[Course]:
    erring = any(any(each.values()) for each in counterexample.errors)
    for digits in DIGITS:
        start = _round_values(counterexample.start, digits)
        if erring:
            yield Course(start, (), counterexample.pieces)
        errors: Sequence[Values] = [_round_values(each, digits) for each in counterexample.errors]
        yield Course(start, errors, counterexample.pieces)
        if erring:
            yield Course(start, counterexample.errors, counterexample.pieces)


def _round_values(values: Values, digits: int) -> Mapping[str, Fraction]:
    return {name: round(value, digits) for name, value in values.items()}
