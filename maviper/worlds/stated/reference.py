"""The environment that a statement is about, with the statement's variables in it.

Does: makes and steps it; reads and sets its state, by an attribute or by what agents observe.
Assumes: whoever calls it means to run the environment's code.
Does not: compare (deviation.py).
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import contextmanager, suppress
from typing import Any, cast

import numpy as np

from codegen.errors import InputError
from codegen.ir import Float32
from codegen.wording import format_count
from maviper.worlds.outside.making import import_maker, make_environment
from maviper.worlds.outside.processes import Copy
from maviper.worlds.outside.silence import output_aside
from maviper.worlds.outside.sources import GYMNASIUM, fault, is_named_by_user, parse_source
from maviper.worlds.outside.together import steps_alone
from maviper.worlds.stated.systems import Floats
from verify.systems.statement import Statement
from verify.systems.system import Affine, Measure


def is_known(name: str) -> bool:
    """Returns True if a file may name this environment to be run: one that Gymnasium registers, no user's module."""
    module, _, function = name.partition(":")
    return module == GYMNASIUM and ":" not in function


class Reference:
    """The reference environment of a statement. InputError where it cannot be played, or does not show its state."""

    def __init__(self, statement: Statement) -> None:
        self._statement, self._where = statement, statement.system.reference
        if not is_named_by_user(self._where):
            advice = "write gymnasium:ID or module:function"
            raise InputError("the reference is no environment that can be played", self._where, advice)
        source = parse_source(self._where)
        self._copy = Copy(make_environment(import_maker(source), source), source)
        self._ask = self._copy.ask
        self._step_alone: Callable[[int], tuple[Any, ...]] | None = None
        self.actions = {agent.name: tuple(agent.actions) for agent in statement.agents}
        self._names = [each.name for each in statement.system.variables]
        self._ensure_agents()
        self._seen = {} if statement.state else _locate_variables(statement)
        self._observations: Sequence[Float32] = ()
        self.playing = False
        self.placeable = bool(statement.state) and self._takes_states()

    def _ensure_agents(self) -> None:
        if len(self.actions) != len(self._copy.names):
            what = f"{format_count(len(self.actions), 'agent')}, and {len(self._copy.names)} in the reference"
            raise InputError(what, self._where, "name the agents in the environment's order")
        for (agent, actions), own in zip(self.actions.items(), self._copy.names, strict=True):
            n = int(getattr(self._copy.env.action_space(own), "n", 0))
            if n != len(actions):
                what = f"{agent} has {format_count(len(actions), 'action')}, and {n} in the reference"
                raise InputError(what, self._where, "list all of them, in the environment's order")

    def _takes_states(self) -> bool:
        """Returns True if the state can be set."""
        self.reset(0)
        at = self.state()
        return not callable(getattr(self._holder(), self._statement.state)) and self.place(at)

    @contextmanager
    def keep_quiet(self) -> Generator[None]:
        """Sends its output meanwhile to standard error: to see to that at each step takes as long as a small one. Where
        the state is read from an environment of one agent, so does what else a step tells, which nobody reads.
        """
        env = self._copy.env
        with output_aside():
            self._ask = self._copy.answer
            self._step_alone = env.step_alone if self._statement.state and steps_alone(env) else None
            try:
                yield
            finally:
                self._ask, self._step_alone = self._copy.ask, None

    def reset(self, seed: int) -> None:
        """Starts an episode as the environment does."""
        self._observations, self.playing = self._ask("reset", seed).observations, True

    def place(self, state: Floats) -> bool:
        """Puts the environment, which was reset, into a state; whether it took that. What agents observe follows with
        the next step.
        """
        wanted = [state[name] for name in self._names]
        with suppress(AttributeError, TypeError, ValueError):
            setattr(self._holder(), self._statement.state, np.array(wanted))
            return list(self.state().values()) == wanted
        return False

    def step(self, actions: Mapping[str, str]) -> None:
        """One step, for a joint action by names."""
        chosen = [names.index(actions[agent]) for agent, names in self.actions.items()]
        if self._step_alone is not None:
            try:
                _, _, ended, cut, _ = self._step_alone(chosen[0])
            except (Exception, SystemExit) as error:
                raise fault(error, self._copy.source, "the environment's step") from error
            self.playing = not (ended or cut)
            return
        outcome = self._ask("step", chosen)
        self._observations, self.playing = outcome.observations, not all(outcome.done)

    def state(self) -> Floats:
        """The statement's variables."""
        if not self._statement.state:
            return {name: float(self._observations[agent][index]) for name, (agent, index) in self._seen.items()}
        try:
            given = getattr(self._holder(), self._statement.state)
            given = given() if callable(given) else given
            if isinstance(given, Mapping):
                table = cast("Mapping[str, Any]", given)
                return {name: float(table[name]) for name in self._names}
            numbers = np.asarray(given, dtype=np.float64).reshape(-1)
        except (Exception, SystemExit) as error:
            raise fault(error, self._copy.source, f"the reference's {self._statement.state}") from error
        if len(numbers) != len(self._names):
            what = f"{self._statement.state} holds {len(numbers)} numbers, and there are {len(self._names)} variables"
            raise InputError(what, self._where, "list the variables in its order")
        return dict(zip(self._names, numbers.tolist(), strict=True))

    def _holder(self) -> Any:
        """Returns the holder of the attribute: the innermost environment that has it."""
        env = self._copy.env
        inner = getattr(env, "env", env)
        for each in (getattr(inner, "unwrapped", inner), inner, env):
            if getattr(each, self._statement.state, None) is not None:
                return each
        what = f"the reference has no attribute {self._statement.state!r}"
        raise InputError(what, self._where, "state names the attribute that holds the variables in order")


def _locate_variables(statement: Statement) -> dict[str, tuple[int, int]]:
    """Finds for each variable the agent and the feature that is the variable itself."""
    places: dict[str, tuple[int, int]] = {}
    for agent, features in enumerate(statement.system.features.values()):
        for index, feature in enumerate(features.values()):
            match feature.form, feature.measure:
                case Affine(((name, factor),), constant), Measure.VALUE if factor == 1 and not constant:
                    places.setdefault(name, (agent, index))
                case _:
                    pass
    hidden = [each.name for each in statement.system.variables if each.name not in places]
    if hidden:
        what = f"nothing shows {', '.join(hidden)} of the reference"
        raise InputError(
            what, statement.system.reference, 'write state = "..." for an attribute that holds the variables in order'
        )
    return places
