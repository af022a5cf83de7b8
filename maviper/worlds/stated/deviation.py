"""How far a statement is from the environment that it is about, measured.

Does: makes and steps the environment, reads and sets its state, by an attribute or by what agents observe; plays it at
  random from states all over the ranges; compares each step with the statement's, many states at once.
Assumes: whoever calls it means to run the environment's code; the environment shows its state; finite numbers.
Does not: prove: between the states that were met it may be off by more.

Sums, products, quotients and roots of float64 are the same in numpy as in Python. Other functions and powers are not,
so Python's are asked number by number, and once for an argument that an expression has several times.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from functools import cache, lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias, cast

import numpy as np

from codegen.errors import InputError
from codegen.ir import Bool, Float32, Float64, Int64
from codegen.wording import format_count
from maviper.worlds.outside.making import import_maker, make_environment
from maviper.worlds.outside.playing import steps_alone
from maviper.worlds.outside.processes import Copy
from maviper.worlds.outside.sources import GYMNASIUM, fault, is_named_by_user, output_aside, parse_source
from maviper.worlds.stated.systems import Floats, Moving, MovingRule
from verify.spending import tell
from verify.systems.observing import ARRAYS, SINGLE, Computing
from verify.systems.statement import Statement
from verify.systems.system import Affine, Measure, ensure_in_steps

if TYPE_CHECKING:
    from verify.systems.statement import Rule


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
        if len(self.actions) != len(self._copy.names):
            what = f"{format_count(len(self.actions), 'agent')}, and {len(self._copy.names)} in the reference"
            raise InputError(what, self._where, "name the agents in the environment's order")
        for (agent, actions), own in zip(self.actions.items(), self._copy.names, strict=True):
            n = int(getattr(self._copy.env.action_space(own), "n", 0))
            if n != len(actions):
                what = f"{agent} has {format_count(len(actions), 'action')}, and {n} in the reference"
                raise InputError(what, self._where, "list all of them, in the environment's order")
        self._seen = {} if statement.state else _locate_variables(statement)
        self._observations: Sequence[Float32] = ()
        self.playing = False
        self.placeable = False  # whether the state can be set
        if statement.state:
            self.reset(0)
            at = self.state()
            self.placeable = not callable(getattr(self._holder(), statement.state)) and self.place(at)

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
        advice = 'write state = "..." for an attribute that holds the variables in order'
        raise InputError(what, statement.system.reference, advice)
    return places


Columns: TypeAlias = Mapping[str, Float64]  # of a table of states, by variable


def _each(function: Callable[[float], float]) -> Callable[[Float64], Float64]:
    """A function of numbers as one of columns; an argument that an expression has several times is asked once."""

    @lru_cache(maxsize=64)
    def of(numbers: bytes) -> Float64:
        return np.array([function(number) for number in np.frombuffer(numbers).tolist()])

    return lambda column: of(column.tobytes())


@cache
def _power(exponent: int) -> Callable[[Float64], Float64]:
    return _each(lambda number: number**exponent)


def _divide(one: Float64, other: Float64) -> Float64:
    if not other.all():
        raise ZeroDivisionError("float division by zero")
    return one / other


COLUMNS = Computing(
    ARRAYS.constant,
    ARRAYS.clip,
    {name: _each(function) for name, function in SINGLE.functions.items()},
    _power,
    _divide,
)


class RuleColumns(MovingRule):
    """A rule, over the rows of a table."""

    def __init__(self, rule: Rule) -> None:
        super().__init__(rule, COLUMNS)

    def holding(self, state: Columns) -> Bool:
        """The rows whose states lie in its box and meet its conditions, [rows]."""
        rows = np.ones(len(next(iter(state.values()))), dtype=np.bool_)
        for name, low, high in self.where:
            rows &= (state[name] >= low) & (state[name] <= high)
        if self.when:  # exact numbers decide
            for row in np.flatnonzero(rows).tolist():
                rows[row] = self.holds({name: float(column[row]) for name, column in state.items()})
        return rows

    def move_states(self, state: Columns, actions: Mapping[str, Sequence[str]]) -> dict[str, Float64]:
        """The next states for joint actions, [rows] by agent, without errors, each as by `MovingRule.move_state`."""
        count = len(next(iter(state.values())))
        after = {name: np.array(np.broadcast_to(move(state), count)) for name, move in self.move.items()}
        for agent, taken in actions.items():
            for action in dict.fromkeys(taken):
                rows = np.flatnonzero(np.array(taken) == action)
                some = {name: column.take(rows) for name, column in state.items()}
                for name, added in self.effect.get((agent, action), {}).items():
                    after[name][rows] += added(some)
        return after


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
        rules = [RuleColumns(rule) for rule in statement.rules]
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
