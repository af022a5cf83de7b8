"""What a world file is measured by: the environment that it is about, and episodes by its rules as they are written.

Does: how far the statement is from the environment, and what that says of a counterexample; plays episodes by the
  rules.
Assumes: a statement and a profile that plays in it.
Does not: decide.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from itertools import chain, pairwise
from typing import Any

import numpy as np

from codegen.errors import InputError
from codegen.ir import PolicyProfile, act
from maviper.worlds.stated.deviation import Reference, deviation, is_known
from maviper.worlds.stated.systems import box
from maviper.worlds.stated.systems import start as draw_start
from verify.claims.formula import holds
from verify.reach.play import Starts, courses
from verify.reach.replay import Course, replay_course, within
from verify.reach.results import SystemCounterexample
from verify.reach.written import WrittenReplay
from verify.reports import systems
from verify.systems.claims import SystemClaim
from verify.systems.observing import choose_actions, observe_state
from verify.systems.statement import Statement
from verify.systems.system import State
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


ANYWHERE, BESIDE = 4_096, 256  # starts that are played: of the whole region, and of each box around a known one
NEAR = tuple(2.0**-power for power in (4, 8, 12, 16))  # half a box's width, as a share of what starts range over


def find_by_rules(
    statement: Statement, profile: PolicyProfile, claim: SystemClaim, counterexample: SystemCounterexample
) -> SystemCounterexample | None:
    """An episode by the rules as they are written, with errors that the file states, that surely breaks the claim."""
    replay = WrittenReplay(statement, profile, claim)
    drawn = map(replay.follow, _courses(statement, profile, claim, counterexample.start))
    for states in chain([replay.keep_near(counterexample.states)], drawn):
        if states is not None:
            again = replay_course(profile, statement.system, claim, _course(statement, profile, states))
            if again is not None:
                return again
    return None


def _courses(statement: Statement, profile: PolicyProfile, claim: SystemClaim, start: State) -> Iterator[Course]:
    """Courses of the rules that seem to break the claim: from anywhere, then from ever nearer to a start."""
    bounds = box(statement)
    lowest, highest = (np.array([float(end) for end in ends]) for ends in zip(*bounds.values(), strict=True))
    near = np.array([float(start[name]) for name in bounds])
    offs = [part * (highest - lowest) for part in NEAR]
    boxes = [(np.maximum(near - off, lowest), np.minimum(near + off, highest)) for off in offs]
    beside = [Starts(BESIDE, (low[None], high[None])) for low, high in boxes]
    for each in (Starts(ANYWHERE), *_thin(statement), *beside):
        for course in courses(profile, statement.system, claim, each, statement.rules):
            exact = {name: min(max(course.start[name], low), high) for name, (low, high) in bounds.items()}
            yield replace(course, start=exact)  # a bound that is no float64 is met exactly


def _thin(statement: Statement) -> Iterator[Starts]:
    """Some starts that meet all conditions where some are about several variables: of numbers drawn at once most may
    fail these, and those that pass may all lie at bounds.
    """
    if any(len(half.form.terms) > 1 for half in statement.system.start):
        random = np.random.default_rng(0)
        with suppress(InputError):  # no start was found
            drawn = [list(draw_start(statement, random).values()) for _ in range(BESIDE)]
            yield Starts(BESIDE, (np.array(drawn), np.array(drawn)))


def _course(statement: Statement, profile: PolicyProfile, states: Sequence[State]) -> Course:
    """Returns the course of an episode of the pieces through given states, as far as their errors allow: of several
    pieces that hold a state, as where there is a choice, by the one that comes nearest to the next.
    """
    errors, pieces = list[Mapping[str, Fraction]](), list[int]()
    for state, after in pairwise(states):
        holding = [number for number, piece in enumerate(statement.system.pieces) if piece.holds(state)]
        if not holding:
            break
        actions = choose_actions(statement.system, profile, state)
        joint = {policy.agent: policy.actions[actions[policy.agent]].name for policy in profile.agents}
        ways: list[tuple[Fraction, int, Mapping[str, Fraction]]] = []
        for number in holding:
            piece = statement.system.pieces[number]
            exact = piece.step(state, joint, {})
            asked = {name: after[name] - exact[name] for name in exact}
            cut = {name: asked[name] - error for name, error in within(piece, asked).items()}
            ways.append((sum(map(abs, ({**asked, **cut}).values()), Fraction(0)), number, asked))
        _, number, asked = min(ways, key=lambda way: way[:2])
        errors.append({name: asked[name] for name in statement.system.pieces[number].error})
        pieces.append(number)
    return Course(states[0], errors, pieces)
