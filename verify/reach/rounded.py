"""States and episodes of real agents, which test sums or give numbers, with the roundings that they really make.

Does: plays the real agents from a start, in exact numbers but for their own floats; says whether that breaks a claim;
  looks beside a state that breaks a claim for one of floats; draws states anywhere in a claim's regions in which a
  formula fails by what `codegen.ir` says that agents give and do.
Assumes: a statement and a profile as `as_played` reads them.
Does not: prove. A state of other numbers than floats is no observation, so it is no counterexample over observations.

A state that breaks a claim by a rounding alone says nothing of states far from it, in which the agents may break it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from fractions import Fraction
from itertools import product

import numpy as np

from codegen.deciding import name_outputs
from codegen.floats import FLOAT32, FLOAT64
from codegen.ir import Int32, PolicyProfile, act
from codegen.numbers import nearest_number, neighbour
from verify.claims.formula import Formula, holds
from verify.reach.play import Planes, Starts, observe_planes, random_starts, value
from verify.reach.replay import Course, replay_course, take_step
from verify.reach.results import SystemCounterexample
from verify.states.values import Batch
from verify.systems.claims import SystemClaim
from verify.systems.observing import list_roundings, list_settings, observe_state, with_roundings
from verify.systems.statement import Statement
from verify.systems.system import State


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
        given = counterexample.errors[step] if step < len(counterexample.errors) else dict[str, Fraction]()
        stated = {name: value for name, value in given.items() if name not in roundings}
        wanted = counterexample.pieces[step] if step < len(counterexample.pieces) else None
        taken = take_step(profile, system, state, stated, wanted)
        if taken is None:
            break
        state = with_roundings(statement, taken.after)
        errors.append({**taken.error, **{name: state[name] for name in roundings}})
    return replay_course(profile, system, claim, Course(start, errors, counterexample.pieces))


def observable(
    statement: Statement, profile: PolicyProfile, claim: SystemClaim, counterexample: SystemCounterexample
) -> SystemCounterexample | None:
    """A counterexample of float32 numbers, or of float64 ones, beside another one: the nearest, then one step up or
    down in all, away from an end of a range where there is one. None where those tried break nothing.
    """
    kept, state = set(list_roundings(statement)), counterexample.start
    for numbers, step in product((FLOAT32, FLOAT64), (0, 1, -1)):
        moved = dict(state)
        for each in statement.system.variables:
            if each.name in kept:
                continue
            (low, high), near = each.range, nearest_number(state[each.name], numbers)
            if step:
                near = float(neighbour(near, step * float("inf"), numbers))
            if Fraction(near) > high:
                near = float(neighbour(near, -float("inf"), numbers))
            if Fraction(near) < low:
                near = float(neighbour(near, float("inf"), numbers))
            moved[each.name] = Fraction(near)
        again = truly(statement, profile, claim, replace(counterexample, states=(moved,)))
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
        point |= (given := {name: Fraction(float(value[0])) for name, value in name_outputs(real, row).items()})
        if not given:
            actions[real.agent] = taken = int(act(real, row)[0])
            settings = list_settings(statement, real.agent, real.actions[taken].name)
            point |= {name: form.at(state) for name, form in settings.items()}
    return not holds(formula, point, actions)


DRAWN, TRIED, SEED = 16_384, 8, 0  # states; of those that seem to break the claim, the ones that are told


def iterate_failing(
    statement: Statement, profile: PolicyProfile, claim: SystemClaim, written: Formula
) -> Iterator[State]:
    """Some states of a claim's regions in which the formula seems to fail; roundings are as they are drawn."""
    system = statement.system
    drawn = random_starts(system, claim, Starts(DRAWN), np.random.default_rng(SEED))
    if drawn is None:
        return
    point: Planes = dict(drawn)
    actions: dict[str, Int32] = {}
    for policy in profile.agents:
        read = statement.acting.get(policy.agent)
        real = policy if read is None else read.real
        rows = observe_planes(system, real, drawn)
        point |= (given := {name: values.astype(np.float64) for name, values in name_outputs(real, rows).items()})
        if not given:
            actions[real.agent] = taken = act(real, rows)
            for number, action in enumerate(real.actions):
                for name, form in list_settings(statement, real.agent, action.name).items():
                    point[name] = np.where(taken == number, value(form, drawn), point.get(name, 0.0))
    asked = Batch(point, len(next(iter(drawn.values()))))
    broken = ~asked.holds(written, actions)
    if claim.regions:
        broken &= asked.holds(claim.inside, {})
    for row in np.flatnonzero(broken)[:TRIED]:
        yield {name: Fraction(float(values[row])) for name, values in drawn.items()}
