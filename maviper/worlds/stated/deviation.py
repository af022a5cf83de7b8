"""How far a statement is from the environment that it is about, measured.

Does: plays the environment at random from states all over the ranges; compares each step with the statement's.
Assumes: the environment shows its state (reference.py).
Does not: prove: between the states that were met it may be off by more.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, cast

import numpy as np

from codegen.errors import InputError
from codegen.ir import Float64, Int64
from maviper.worlds.stated.columns import RuleColumns
from maviper.worlds.stated.reference import Reference
from maviper.worlds.stated.systems import Floats, Moving
from verify.progress import tell
from verify.systems.statement import Statement
from verify.systems.system import ensure_in_steps

STEPS = 100_000
SEED = 0
AT_ONCE = 10_000  # steps that are compared together
PLACED = 0.75  # the share of episodes that begin anywhere in the ranges, where the environment allows that


@dataclass
class Deviation:
    """The measured deviation: of each variable the least and the most by which the environment is off the statement."""

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
    with reference.keep_quiet():
        _play(reference, moving, [RuleColumns(rule) for rule in statement.rules], so_far, steps)
    if not so_far.steps:
        began = f"{so_far.outside} steps of {statement.system.reference} began"
        what = f"nothing was measured: {began} where nothing is stated"
        raise InputError(what, statement.system.name, "widen the ranges to where its episodes lead")
    return so_far


class _Step(NamedTuple):
    """A step of the reference: the state before, the joint action by names, the state after."""

    before: Floats
    actions: Mapping[str, str]
    after: Floats


def _play(reference: Reference, moving: Moving, rules: Sequence[RuleColumns], so_far: Deviation, steps: int) -> None:
    """Plays so many steps, each compared."""
    rng, done, met = np.random.default_rng(SEED), 0, list[_Step]()
    while done < steps:
        tell(done, steps, "steps of the reference compared")
        reference.reset(int(cast("Any", rng.integers(2**31))))
        if reference.placeable and rng.random() < PLACED:
            reference.place({name: rng.uniform(low, high) for name, (low, high) in moving.ranges.items()})
        before = reference.state()
        while reference.playing and done < steps:
            actions = {agent: names[rng.integers(len(names))] for agent, names in reference.actions.items()}
            reference.step(actions)
            after = reference.state()
            met.append(_Step(before, actions, after))
            done += 1
            if not moving.within(after):
                break
            before = after
        if len(met) >= AT_ONCE or done == steps:
            _compare(moving, rules, so_far, met)
            met = []


def _compare(moving: Moving, rules: Sequence[RuleColumns], so_far: Deviation, met: Sequence[_Step]) -> None:
    """Adds steps to what was measured. Of several rules that hold, on a border, the first counts whose error allows
    what was met, or else the first.
    """
    before, after = (
        {name: np.array([each[name] for each in states]) for name in moving.ranges}
        for states in ([each.before for each in met], [each.after for each in met])
    )
    within = np.all([(before[name] >= low) & (before[name] <= high) for name, (low, high) in moving.ranges.items()], 0)
    holding, allowed = (np.zeros((len(rules), len(met)), dtype=np.bool_) for _ in range(2))
    offs = list[dict[str, Float64]]()
    for place, rule in enumerate(rules):
        holding[place] = within & rule.holding(before)
        rows = np.flatnonzero(holding[place])
        state = {name: column.take(rows) for name, column in before.items()}
        actions = {agent: [met[row].actions[agent] for row in rows.tolist()] for agent in met[0].actions}
        moved = rule.move_states(state, actions) if len(rows) else {}
        fits, offs = np.ones(len(rows), dtype=np.bool_), [*offs, dict[str, Float64]()]
        for name, column in moved.items():
            off = offs[-1][name] = np.zeros(len(met))
            off[rows] = after[name].take(rows) - column
            low, high = rule.error.get(name, (0.0, 0.0))
            fits &= (low <= off[rows]) & (off[rows] <= high)
        allowed[place, rows] = fits
    stated, fitting = holding.any(axis=0), allowed.any(axis=0)
    first: Int64 = allowed.argmax(axis=0)
    first[~fitting] = holding.argmax(axis=0)[~fitting]
    so_far.steps, so_far.outside = so_far.steps + int(stated.sum()), so_far.outside + int((~stated).sum())
    for place, off in enumerate(offs):
        rows = np.flatnonzero(stated & (first == place))
        for name, column in off.items() if len(rows) else ():
            numbers = column.take(rows).tolist()
            low, high = so_far.off.get(name, (numbers[0], numbers[0]))
            so_far.off[name] = min(low, *numbers), max(high, *numbers)
    beyond = np.flatnonzero(stated & ~fitting).tolist()
    so_far.beyond += len(beyond)
    if beyond and not so_far.worst:
        place = int(first[beyond[0]])
        off = {name: float(column[beyond[0]]) for name, column in offs[place].items()}
        so_far.worst = _describe_worst(rules[place], met[beyond[0]], off)


def _describe_worst(rule: RuleColumns, step: _Step, off: Floats) -> str:
    bounds = {name: rule.error.get(name, (0.0, 0.0)) for name in off}
    beyond = next(name for name, (low, high) in bounds.items() if not low <= off[name] <= high)
    state = ", ".join(f"{name} = {number:.6g}" for name, number in step.before.items())
    return f"{beyond} is off by {off[beyond]:.3g} after {', '.join(step.actions.values())} in {state}"
