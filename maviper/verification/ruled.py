"""Episodes by the rules of a world file as they are written.

Does: finds one that breaks a claim beside an episode of the pieces that enclose the rules.
Assumes: a world file whose agents are those of the profile.
Does not: decide: the episode is played again in exact numbers, which judge the claim.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import pairwise

from codegen.ir import PolicyProfile
from maviper.worlds.stated.written import episodes
from verify.claims.formula import holds
from verify.reach.replay import Course, piece_of, replay_course
from verify.reach.results import SystemCounterexample
from verify.systems.claims import SystemClaim
from verify.systems.observing import choose_actions
from verify.systems.statement import Statement


def find_by_rules(
    statement: Statement, profile: PolicyProfile, claim: SystemClaim, counterexample: SystemCounterexample
) -> SystemCounterexample | None:
    """An episode by the rules as they are written, with errors that the file states, that breaks the claim too."""
    for states in episodes(statement, profile, claim.steps, counterexample.states):
        if _breaks(claim, states):
            again = replay_course(profile, statement.system, claim, _course(statement, profile, states))
            if again is not None:
                return again
    return None


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
