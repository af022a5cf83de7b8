"""Findings on a world file: what it states, whether its enclosures hold, how far it is from its reference.

Does: findings with their marks and words, one for each thing that was looked at; enclosures are those that the checker
  shows again; of flows, the motion in play is compared with scipy's, from states all over the ranges.
Assumes: a file that could be read.
Does not: print, play or prove.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from codegen.wording import format_count, visible
from maviper.worlds.stated.deviation import deviation, is_known
from maviper.worlds.stated.systems import flow_rules, start
from verify.checker.reading import RejectedError
from verify.checker.systems.enclosures import ensure_enclosed
from verify.decimals import plain
from verify.systems.properties import ensure_claims
from verify.systems.statement import Statement
from verify.systems.system import Variable


class Mark(StrEnum):
    """The mark of a finding; only what is wrong prevents use."""

    OK = "ok"
    MISSING = "missing"
    WRONG = "wrong"


@dataclass(frozen=True)
class Finding:
    """One thing that was looked at, and what to do about it where something is to be done."""

    mark: Mark
    what: str
    next_step: str = ""

    def __str__(self) -> str:
        said = "; ".join(part for part in (self.what, self.next_step) if part)
        return visible(f"{self.mark:<8} {' '.join(said.split())}")


def usable(findings: Sequence[Finding]) -> bool:
    """Returns True if nothing was found that prevents use."""
    return all(finding.mark is not Mark.WRONG for finding in findings)


PERIODS, SEED = 200, 0
NEAR = 1e-3  # beside the size of a state, of which play may be off
ADVICE = "a shorter period, or slower motion: play integrates a period in 8 parts"
UNDEFINED = "narrow the ranges: over them a derivative must be defined"


def check_integration(statement: Statement) -> Finding:
    """Measures how far play is from scipy's integration, over periods from starts and from anywhere in the ranges."""
    flow, rng = statement.system.flow, np.random.default_rng(SEED)
    assert flow is not None
    rules, worst, least = flow_rules(flow), dict.fromkeys(flow.rates, 0.0), 0.0
    for number in range(PERIODS):
        anywhere = {each.name: _within(each, rng) for each in statement.system.variables}
        state = start(statement, rng) if number % 2 else anywhere
        rule = next((each for each in rules if each.holds(state)), rules[0])
        chosen = {agent.name: str(rng.choice(list(agent.actions))) for agent in statement.agents}
        try:
            longer = float(rng.uniform(*rule.jitter)) if any(rule.jitter) else 0.0
            after = rule.move_state(state, chosen, longer)
            ends = rule.integrate_states(state, chosen, np.array([rule.period + longer]))[-1].tolist()
            exact = dict(zip(state, ends, strict=True))
        except (ArithmeticError, ValueError) as error:
            where = ", ".join(f"{name} = {value:.6g}" for name, value in state.items())
            return Finding(Mark.WRONG, f"flow: a derivative is not defined from {where}: {error}", UNDEFINED)
        for name, value in exact.items():
            worst[name] = max(worst[name], abs(after[name] - value))
            least = max(least, abs(after[name] - value) / (1 + abs(value)))
    off = ", ".join(f"{name} {value:.2g}" for name, value in worst.items() if name not in flow.kept)
    said = f"integration: {format_count(PERIODS, 'period')} by scipy, of which play is off by at most {off}"
    return Finding(Mark.OK, said) if least <= NEAR else Finding(Mark.MISSING, said, ADVICE)


def _within(variable: Variable, rng: np.random.Generator) -> float:
    """A value of a variable from its range, of a mode a whole number."""
    low, high = float(variable.range[0]), float(variable.range[1])
    return float(rng.integers(int(low), int(high) + 1)) if variable.modes else float(rng.uniform(low, high))


NO_CLAIMS = "add [[claim]], or give `maviper verify` a file of them"


def check_statement(statement: Statement) -> Iterator[Finding]:
    """Lists what a file states."""
    system = statement.system
    yield Finding(Mark.OK, f"file: {system.name}, units fit, and every number is exact")
    variables = ", ".join(f"{each.name} {each.unit}".removesuffix(" 1") for each in system.variables)
    yield Finding(Mark.OK, f"variables: {variables}")
    sizes = ", ".join(
        f"{agent.name} {len(system.features[agent.name])} and {len(agent.actions)}" for agent in statement.agents
    )
    yield Finding(Mark.OK, f"features and actions: {sizes}")
    claims = ensure_claims(statement, system.name)
    yield Finding(Mark.OK, f"claims: {claims}") if claims else Finding(Mark.MISSING, "claims: none", NO_CLAIMS)
    if not statement.moves:
        said = "dynamics: none, so claims are about single decisions"
        yield Finding(Mark.MISSING, said, "add [dynamics.next] or [dynamics.flow] for claims about episodes")
        return
    if system.flow is not None:
        told = f"{format_count(len(system.flow.rates), 'derivative')}, a period of {plain(system.flow.period)} s"
        yield Finding(Mark.OK, f"flow: {told}, {format_count(system.steps, 'period')}")
        yield check_integration(statement)
        return
    pieces = "one piece" if len(system.pieces) == 1 else f"{len(system.pieces)} pieces"
    yield Finding(Mark.OK, f"dynamics: {pieces}, {format_count(system.steps, 'step')}")
    yield _check_enclosures(statement)


def _check_enclosures(statement: Statement) -> Finding:
    """Checks by the checker that the pieces hold what the rules say."""
    try:
        shown = ensure_enclosed(statement)
    except RejectedError as error:
        return Finding(Mark.WRONG, f"enclosures: {error}", "cut the ranges of more variables, or into more parts")
    return Finding(Mark.OK, f"enclosures: {shown} bounds shown" if shown else "enclosures: none, every rule is affine")


def measure_reference(statement: Statement, run: bool) -> Iterator[Finding]:
    """Measures the distance of a statement from its reference. `run`: also where that is code that the file names."""
    name = statement.system.reference
    if not (run or is_known(name)):
        said = f"reference: {name} is code that the file names, and was not run"
        yield Finding(Mark.MISSING, said, "add --run-reference to run it and measure the statement")
        return
    measurement = deviation(statement)
    reach = ", ".join(f"{name} [{low:.2g}, {high:.2g}]" for name, (low, high) in measurement.off.items())
    where = "all over the ranges" if measurement.placed else "where its episodes lead"
    yield Finding(Mark.OK, f"reference: {name}, {measurement.steps} steps {where}, off by {reach}")
    if measurement.outside:
        yield Finding(Mark.MISSING, f"reference: {measurement.outside} steps began where nothing is stated")
    if measurement.beyond:
        advice = "widen the error of the variable, narrow its range, or mend the rule"
        yield Finding(
            Mark.WRONG, f"reference: {measurement.beyond} steps beyond the stated error; {measurement.worst}", advice
        )
    else:
        yield Finding(Mark.OK, "error: no step is off by more than stated")
