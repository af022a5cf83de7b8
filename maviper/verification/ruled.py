"""Episodes by the rules of a world file as they are written.

Does: finds one that breaks a claim beside an episode of the pieces that enclose the rules.
Assumes: a world file whose agents are those of the profile.
Does not: decide: the episode is played again in exact numbers, which judge the claim.
"""

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import chain, pairwise

import numpy as np

from codegen.ir import PolicyProfile
from maviper.worlds.stated.written import WrittenPlay
from verify.claims.formula import holds
from verify.reach.play.samples import Starts, courses
from verify.reach.replay import Course, piece_of, replay_course
from verify.reach.results import SystemCounterexample
from verify.systems.claims import SystemClaim
from verify.systems.observing import choose_actions
from verify.systems.statement import Statement
from verify.systems.system import State

ANYWHERE, BESIDE = 4_096, 256  # starts that are played: of the whole region, and of each box around a known one
NEAR = tuple(2.0**-power for power in (4, 8, 12, 16))  # of a variable's range: how far starts lie from the known one


def find_by_rules(
    statement: Statement, profile: PolicyProfile, claim: SystemClaim, counterexample: SystemCounterexample
) -> SystemCounterexample | None:
    """An episode by the rules as they are written, with errors that the file states, that breaks the claim too."""
    play = WrittenPlay(statement, profile, claim.steps)
    drawn = map(play.follow, _courses(statement, profile, claim, counterexample.start))
    for states in chain([play.keep_near(counterexample.states)], drawn):
        if _breaks(claim, states):
            again = replay_course(profile, statement.system, claim, _course(statement, profile, states))
            if again is not None:
                return again
    return None


def _courses(statement: Statement, profile: PolicyProfile, claim: SystemClaim, start: State) -> Iterator[Course]:
    """Courses of the rules that seem to break the claim: from anywhere, then from ever nearer to a start."""
    ranges = [one.range for one in statement.system.variables]
    lowest, highest = (np.array([float(end) for end in ends]) for ends in zip(*ranges, strict=True))
    near = np.array([float(start[one.name]) for one in statement.system.variables])
    offs = [part * (highest - lowest) for part in NEAR]
    boxes = [(np.maximum(near - off, lowest), np.minimum(near + off, highest)) for off in offs]
    beside = [Starts(BESIDE, (low[None], high[None])) for low, high in boxes]
    for each in (Starts(ANYWHERE), *beside):
        found = courses(profile, statement.system, {0: claim}, each, statement.rules)
        yield from (course for _, course in found)


def _breaks(claim: SystemClaim, states: Sequence[Mapping[str, Fraction]]) -> bool:
    for step, state in enumerate(states):
        if holds(claim.violation_at(step), state, {}):
            return True
        if holds(claim.fulfilment_at(step), state, {}):
            return False
    return False


def _course(statement: Statement, profile: PolicyProfile, states: Sequence[Mapping[str, Fraction]]) -> Course:
    """How an episode of the pieces goes through given states, as far as their errors allow."""
    errors: list[Mapping[str, Fraction]] = []
    for state, after in pairwise(states):
        number = piece_of(statement.system, state)
        if number is None:
            break
        piece, actions = statement.system.pieces[number], choose_actions(statement.system, profile, state)
        joint = {policy.agent: policy.actions[actions[policy.agent]].name for policy in profile.agents}
        exact = piece.step(state, joint, {})
        errors.append({name: after[name] - exact[name] for name in piece.error})
    return Course(states[0], errors)
