"""How far a statement is from the environment that it is about, measured.

Does: plays the environment at random from states all over the ranges; compares each step with the statement's.
Assumes: the environment shows its state (reference.py).
Does not: prove: between the states that were met it may be off by more.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, cast

import numpy as np

from codegen.errors import InputError
from maviper.worlds.stated.reference import Reference
from maviper.worlds.stated.systems import AnyRule, Floats, Moving
from verify.progress import tell
from verify.systems.statement import Statement
from verify.systems.system import ensure_in_steps

STEPS = 100_000
SEED = 0
PLACED = 0.75  # the share of episodes that begin anywhere in the ranges, where the environment allows that


@dataclass
class Deviation:
    """What was measured: of each variable the least and the most by which the environment is off the statement."""

    steps: int = 0
    outside: int = 0  # steps that began or ended where nothing is stated
    off: dict[str, tuple[float, float]] = field(default_factory=dict[str, tuple[float, float]])
    beyond: int = 0  # steps that were off by more than the stated error
    worst: str = ""  # the first of them, in words
    placed: bool = False  # whether episodes began all over the ranges, not only where the environment begins them


def deviation(statement: Statement, steps: int | None = None) -> Deviation:
    """The deviation of a statement from its reference over this many steps (None: STEPS). InputError where that cannot
    be played, does not show its state, or is nowhere where the statement says something.
    """
    ensure_in_steps(statement.system, "the comparison with an environment")
    steps = STEPS if steps is None else steps
    reference, moving = Reference(statement), Moving(statement)
    so_far = Deviation(placed=reference.placeable)
    with reference.kept_quiet():
        _play(reference, moving, so_far, steps)
    if not so_far.steps:
        began = f"{so_far.outside} steps of {statement.system.reference} began"
        what = f"nothing was measured: {began} where nothing is stated"
        raise InputError(what, statement.system.name, "widen the ranges to where its episodes lead")
    return so_far


def _play(reference: Reference, moving: Moving, so_far: Deviation, steps: int) -> None:
    """Plays so many steps, each compared."""
    rng = np.random.default_rng(SEED)
    while so_far.steps + so_far.outside < steps:
        tell(so_far.steps + so_far.outside, steps, "steps of the reference compared")
        reference.reset(int(cast("Any", rng.integers(2**31))))
        if reference.placeable and rng.random() < PLACED:
            reference.place({name: rng.uniform(low, high) for name, (low, high) in moving.ranges.items()})
        before = reference.state()
        while reference.playing and so_far.steps + so_far.outside < steps:
            actions = {agent: names[rng.integers(len(names))] for agent, names in reference.actions.items()}
            reference.step(actions)
            after = reference.state()
            _compared(moving, so_far, before, actions, after)
            if not moving.within(after):
                break
            before = after


def _compared(moving: Moving, found: Deviation, before: Floats, actions: Mapping[str, str], after: Floats) -> None:
    rules = moving.rules(before)
    if not rules:
        found.outside += 1
        return
    found.steps += 1
    offs = [_off(rule, before, actions, after) for rule in rules]
    fits = [index for index, off in enumerate(offs) if all(_allowed(rules[index], name, off) for name in off)]
    off = offs[fits[0] if fits else 0]
    for name, number in off.items():
        low, high = found.off.get(name, (number, number))
        found.off[name] = min(low, number), max(high, number)
    if not fits:
        found.beyond += 1
        found.worst = found.worst or _told(rules[0], before, actions, off)


def _off(rule: AnyRule, before: Floats, actions: Mapping[str, str], after: Floats) -> Floats:
    return {name: after[name] - number for name, number in rule.moved(before, actions).items()}


def _allowed(rule: AnyRule, name: str, off: Floats) -> bool:
    low, high = rule.error.get(name, (0.0, 0.0))
    return low <= off[name] <= high


def _told(rule: AnyRule, before: Floats, actions: Mapping[str, str], off: Floats) -> str:
    beyond = next(name for name in off if not _allowed(rule, name, off))
    state = ", ".join(f"{name} = {number:.6g}" for name, number in before.items())
    return f"{beyond} is off by {off[beyond]:.3g} after {', '.join(actions.values())} in {state}"
