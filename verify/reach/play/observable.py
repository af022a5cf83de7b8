"""Counterexamples over observations: states whose numbers are floats, judged by the reference itself.

Does: looks beside a state that breaks a claim for one of numbers that an agent can be given; asks `codegen.ir` what the
  agents give and do there, and whether the formula as it was written fails of that.
Assumes: a statement and a profile as `as_played` reads them, of which a claim about decisions was read.
Does not: search. A state of other numbers is no observation, so it is no counterexample over observations.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from fractions import Fraction
from itertools import product

from codegen.floats import FLOAT32, FLOAT64
from codegen.ir import PolicyProfile, act, outputs
from codegen.numbers import nearest_number, neighbour
from verify.claims.formula import Formula, holds
from verify.reach.results import SystemCounterexample
from verify.reach.rounded import truly
from verify.systems.claims import SystemClaim
from verify.systems.observing import list_roundings, list_settings, observe_state
from verify.systems.statement import Statement
from verify.systems.system import State


def observable(
    statement: Statement, profile: PolicyProfile, claim: SystemClaim, counterexample: SystemCounterexample
) -> SystemCounterexample | None:
    """A counterexample of floats beside another one; None where those tried break nothing."""
    for state in _beside(statement, counterexample.start):
        again = truly(statement, profile, claim, replace(counterexample, states=(state,)))
        if again is not None:
            return again
    return None


def fails(statement: Statement, profile: PolicyProfile, formula: Formula, state: State) -> bool:
    """Returns True if a formula over variables, inputs and actions fails in a state, by what the reference does."""
    point: dict[str, Fraction] = dict(state)
    actions: dict[str, int] = {}
    for policy in profile.agents:
        read = statement.acting.get(policy.agent)
        real = policy if read is None else read.real
        row = observe_state(statement.system, real, state)
        if real.outputs:
            given = outputs(real, row)[0].tolist()
            names = [f"{real.agent}.{each.name}" for each in real.outputs]
            point |= {name: Fraction(value) for name, value in zip(names, given, strict=True)}
        else:
            actions[real.agent] = taken = int(act(real, row)[0])
            settings = list_settings(statement, real.agent, real.actions[taken].name)
            point |= {name: form.at(state) for name, form in settings.items()}
    return not holds(formula, point, actions)


def _beside(statement: Statement, state: State) -> Iterator[Mapping[str, Fraction]]:
    """States of float32 numbers and of float64 ones: the nearest, then one step up or down in all, away from an end of
    a range where there is one.
    """
    kept = set(list_roundings(statement))
    for numbers, step in product((FLOAT32, FLOAT64), (0, 1, -1)):
        moved = dict(state)
        for each in statement.system.variables:
            if each.name not in kept:
                moved[each.name] = _float_in(state[each.name], each.range, numbers, step)
        yield moved


def _float_in(exact: Fraction, ends: tuple[Fraction, Fraction], numbers: str, step: int) -> Fraction:
    near = nearest_number(exact, numbers)
    for _ in range(abs(step)):
        near = float(neighbour(near, step * float("inf"), numbers))
    if Fraction(near) > ends[1]:
        near = float(neighbour(near, -float("inf"), numbers))
    if Fraction(near) < ends[0]:
        near = float(neighbour(near, float("inf"), numbers))
    return Fraction(near)
