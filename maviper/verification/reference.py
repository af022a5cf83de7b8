"""The environment that a world file is about: how far the statement is from it, and what it says of a counterexample.

Does: measures steps; puts the environment into the start of a counterexample and plays it.
Assumes: a statement that was read.
Does not: run code that the file names, unless it is told to.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from codegen.errors import InputError
from codegen.ir import PolicyProfile, act
from maviper.worlds.stated.deviation import deviation
from maviper.worlds.stated.reference import Reference, is_known
from verify.claims.formula import holds
from verify.reports import systems
from verify.systems.claims import SystemClaim
from verify.systems.observing import observe_state
from verify.systems.statement import Statement
from verify.verdicts.systems import SystemResult


def measure_reference(statement: Statement, run: bool) -> dict[str, Any]:
    """Measures how far the statement is from its reference in 100,000 steps. InputError if farther than it says."""
    name = statement.system.reference
    if not name or not statement.rules:
        return {}
    if not (run or is_known(name)):
        said = f"{name} is code that the file names; it was not run, so nothing was measured (--run-reference runs it)"
        return {"name": name, "said": [said]}
    measurement = deviation(statement)
    if measurement.beyond:
        beyond = f"{measurement.beyond} of {measurement.steps} steps are beyond its error"
        what = f"the statement is not that of {name}: {beyond}"
        raise InputError(what, measurement.worst, "widen the error of the variable, narrow its range, or mend the rule")
    off = {variable: list(bounds) for variable, bounds in measurement.off.items()}
    reach = ", ".join(f"{variable} {systems.upwards(max(map(abs, bounds)), 2)}" for variable, bounds in off.items())
    said = f"{name}: {measurement.steps} steps were measured, off by at most {reach}"
    return {"name": name, "steps": measurement.steps, "anywhere": measurement.placed, "off": off, "said": [said]}


def replay_words(statement: Statement, profile: PolicyProfile, result: SystemResult) -> str:
    """Describes what the environment says of a counterexample."""
    if result.counterexample is None or result.claim.about_decisions:
        return ""
    name = statement.system.reference
    broken = breaks_in_reference(statement, profile, result.claim, result.counterexample.start_as_doubles)
    if broken is None:
        return f"{name} cannot be put into this start, so this is a counterexample of the statement only"
    if broken:
        return f"{name} breaks the claim from there too"
    return f"{name} does not break the claim from there: this is a counterexample of the statement only"


def breaks_in_reference(
    statement: Statement, profile: PolicyProfile, claim: SystemClaim, start: Mapping[str, float]
) -> bool | None:
    """Returns True if an episode of the reference from a start breaks a claim; None where it cannot be put there."""
    reference = Reference(statement)
    reference.reset(0)
    if not reference.placeable or not reference.place(dict(start)):
        return None
    for step in range(claim.steps + 1):
        state = {name: Fraction(number) for name, number in reference.state().items()}
        if holds(claim.violation_at(step), state, {}):
            return True
        if step == claim.steps or holds(claim.fulfilment_at(step), state, {}) or not reference.playing:
            return False
        seen = {policy.agent: observe_state(statement.system, policy, state) for policy in profile.agents}
        reference.step(
            {policy.agent: policy.actions[int(act(policy, seen[policy.agent])[0])].name for policy in profile.agents}
        )
    return False
