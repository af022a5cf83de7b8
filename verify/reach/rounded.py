"""Episodes of agents that test sums or give numbers, with the roundings that they really make.

Does: plays the real agents from a start, in exact numbers but for their own floats; says whether that breaks a claim.
Assumes: a statement and a profile as `as_played` reads them.
Does not: look for counterexamples.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from codegen.ir import PolicyProfile
from verify.reach.replay import Course, piece_of, replay_course, within
from verify.reach.results import SystemCounterexample
from verify.systems.claims import SystemClaim
from verify.systems.observing import choose_actions, list_roundings, with_roundings
from verify.systems.statement import Statement


def truly(
    statement: Statement, profile: PolicyProfile, claim: SystemClaim, counterexample: SystemCounterexample
) -> SystemCounterexample | None:
    """The episode of the real agents from the start of another one, with its errors, where it breaks the claim too;
    None where it does not.
    """
    state, system = with_roundings(statement, counterexample.start), statement.system
    start, roundings = state, list_roundings(statement)
    errors: list[Mapping[str, Fraction]] = []
    for step in range(0 if claim.about_decisions else claim.steps):
        number = piece_of(system, state, counterexample.pieces[step] if step < len(counterexample.pieces) else None)
        if number is None:
            break
        given = counterexample.errors[step] if step < len(counterexample.errors) else dict[str, Fraction]()
        piece = system.pieces[number]
        error = within(piece, {name: value for name, value in given.items() if name not in roundings})
        actions = choose_actions(system, profile, state)
        joint = {policy.agent: policy.actions[actions[policy.agent]].name for policy in profile.agents}
        state = with_roundings(statement, piece.step(state, joint, error))
        errors.append({**error, **{name: state[name] for name in roundings}})
    return replay_course(profile, system, claim, Course(start, errors, counterexample.pieces))
