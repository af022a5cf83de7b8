"""How far a statement is from the environment that it is about, measured.

Does: plays the environment at random from states all over the ranges; compares each step with the statement's.
Assumes: the environment shows its state, by an attribute or by what agents observe.
Does not: prove: between the states that were met it may be off by more.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from codegen.errors import InputError
from maviper.worlds.outside.sources import imported, made, named_by_user, parsed
from maviper.worlds.outside.systems import Floats, Moving, MovingRule
from maviper.worlds.processes import Copy
from verify.systems.statement import Statement
from verify.systems.system import Affine, Measure

STEPS = 100_000
SEED = 0


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
    be played, or does not show its state.
    """
    steps = STEPS if steps is None else steps
    watched, moving = _Watched(statement), Moving(statement)
    found = Deviation(placed=watched.placeable)
    rng = np.random.default_rng(SEED)
    while found.steps + found.outside < steps:
        watched.begin(rng)
        for before, actions, after in watched.episode(rng):
            _compared(moving, found, before, actions, after)
            if found.steps + found.outside >= steps or not moving.within(after):
                break
    return found


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


def _off(rule: MovingRule, before: Floats, actions: Mapping[str, str], after: Floats) -> Floats:
    return {name: after[name] - number for name, number in rule.moved(before, actions).items()}


def _allowed(rule: MovingRule, name: str, off: Floats) -> bool:
    low, high = rule.error.get(name, (0.0, 0.0))
    return low <= off[name] <= high


def _told(rule: MovingRule, before: Floats, actions: Mapping[str, str], off: Floats) -> str:
    beyond = next(name for name in off if not _allowed(rule, name, off))
    state = ", ".join(f"{name} = {number:.6g}" for name, number in before.items())
    return f"{beyond} is off by {off[beyond]:.3g} after {', '.join(actions.values())} in {state}"


class _Watched:
    """The reference environment, and the statement's variables in it."""

    def __init__(self, statement: Statement) -> None:
        self._statement, name = statement, statement.system.reference
        if not named_by_user(name):
            advice = "write gymnasium:ID or module:function"
            raise InputError("the reference is no environment that can be played", name, advice)
        source = parsed(name)
        self._copy = Copy(made(imported(source), source), source)
        self._agents = [agent.name for agent in statement.agents]
        self._actions = [tuple(agent.actions) for agent in statement.agents]
        self._names = [each.name for each in statement.system.variables]
        if len(self._agents) != len(self._copy.names):
            what = f"{len(self._agents)} agents, and {len(self._copy.names)} in the reference"
            raise InputError(what, name, "name the agents in the environment's order")
        for agent, actions, own in zip(self._agents, self._actions, self._copy.names, strict=True):
            n = int(self._copy.env.action_space(own).n)
            if n != len(actions):
                raise InputError(f"{agent} has {len(actions)} actions, and {n} in the reference", name, "list all")
        self._seen = {} if statement.state else _shown(statement, name)
        self.placeable = bool(statement.state) and self._place(np.random.default_rng(SEED))

    def begin(self, rng: np.random.Generator) -> None:
        """Starts an episode; every other one anywhere in the ranges, where the environment allows that."""
        self._observed = self._copy.ask("reset", int(rng.integers(2**31))).observations
        if self.placeable and rng.random() < 0.75:
            self._place(rng)

    def _holder(self) -> Any:
        """What holds the attribute: the innermost environment that has it."""
        env = self._copy.env
        inner = getattr(env, "env", env)
        for each in (getattr(inner, "unwrapped", inner), inner, env):
            if getattr(each, self._statement.state, None) is not None:
                return each
        what = f"the reference has no attribute {self._statement.state!r}"
        advice = "state names the attribute that holds the variables in order"
        raise InputError(what, self._statement.system.reference, advice)

    def _place(self, rng: np.random.Generator) -> bool:
        """Puts the environment anywhere in the ranges; whether it took that."""
        if not self._copy.env.agents:
            self._copy.ask("reset", SEED)
        holder = self._holder()
        if callable(getattr(holder, self._statement.state)) or not self._state():
            return False
        drawn = [rng.uniform(float(each.range[0]), float(each.range[1])) for each in self._statement.system.variables]
        with suppress(AttributeError, TypeError, ValueError):
            setattr(holder, self._statement.state, np.array(drawn))
            return list(self._state().values()) == drawn
        return False

    def _state(self) -> Floats:
        if not self._statement.state:
            return {name: float(self._observed[agent][index]) for name, (agent, index) in self._seen.items()}
        given = getattr(self._holder(), self._statement.state)
        given = given() if callable(given) else given
        if isinstance(given, Mapping):
            return {name: float(given[name]) for name in self._names}
        numbers = np.asarray(given, dtype=np.float64).reshape(-1)
        if len(numbers) != len(self._names):
            what = f"{self._statement.state} holds {len(numbers)} numbers, and there are {len(self._names)} variables"
            raise InputError(what, self._statement.system.reference, "list the variables in its order")
        return dict(zip(self._names, numbers.tolist(), strict=True))

    def episode(self, rng: np.random.Generator) -> Iterator[tuple[Floats, dict[str, str], Floats]]:
        """State, joint action and next state of each step, until the episode ends."""
        before = self._state()
        while True:
            chosen = [int(rng.integers(len(actions))) for actions in self._actions]
            outcome = self._copy.ask("step", chosen)
            self._observed = outcome.observations
            after = self._state()
            named = {agent: actions[k] for agent, actions, k in zip(self._agents, self._actions, chosen, strict=True)}
            yield before, named, after
            if all(outcome.done):
                return
            before = after


def _shown(statement: Statement, where: str) -> dict[str, tuple[int, int]]:
    """Which agent's which feature is each variable itself."""
    found: dict[str, tuple[int, int]] = {}
    for agent, features in enumerate(statement.system.features.values()):
        for index, feature in enumerate(features.values()):
            match feature.form, feature.measure:
                case Affine(((name, factor),), constant), Measure.VALUE if factor == 1 and not constant:
                    found.setdefault(name, (agent, index))
                case _:
                    pass
    hidden: Sequence[str] = [each.name for each in statement.system.variables if each.name not in found]
    if hidden:
        what = f"nothing shows {', '.join(hidden)} of the reference"
        raise InputError(what, where, 'write state = "..." for an attribute that holds the variables in order')
    return found
