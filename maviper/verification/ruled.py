"""Episodes by the rules of a world file as they are written.

Does: finds one that breaks a claim where an episode of the pieces that enclose the rules does: beside it, or elsewhere.
Assumes: a world file whose agents are those of the profile.
Does not: decide: verify/reach/written.py says what surely breaks a claim. The episode is played again by pieces.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from itertools import chain, pairwise

import numpy as np

from codegen.errors import InputError
from codegen.ir import PolicyProfile
from maviper.worlds.stated.systems import box
from maviper.worlds.stated.systems import start as draw_start
from verify.reach.play import Starts, courses
from verify.reach.replay import Course, replay_course, within
from verify.reach.results import SystemCounterexample
from verify.reach.written import WrittenReplay
from verify.systems.claims import SystemClaim
from verify.systems.observing import choose_actions
from verify.systems.statement import Statement
from verify.systems.system import State

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
