"""A world that a file states, `system:FILE`, in floats: its rules, its flows, its ranges and its starts.

Does: reads the file; moves the state by the rules as they are written, in float64, or for one period with actions held,
  by the classical Runge-Kutta method; draws starts by a seed.
Assumes: a checked file (verify/systems).
Does not: play (environment.py), or prove. Proofs are about exact numbers, and enclose every state of a period
  (verify/checker/flows); here each operation of a rule rounds.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from codegen.errors import InputError
from codegen.ir import Float64
from maviper.files import kinds, runs
from maviper.worlds.outside.sources import SYSTEM, is_named_by_user
from verify.systems.files import MAX_BYTES, statement_of
from verify.systems.observing import SINGLE, Computing, function
from verify.systems.system import Flow, FlowCase, Interval, bounds_of

if TYPE_CHECKING:
    from verify.systems.statement import Rule, Statement


PARTS = 8  # of a period in play
TOLERANCE = 1e-12  # of the referee, absolute and relative


Floats = dict[str, float]


class FlowRule:
    """The motion of one period, as one rule of a world in play. `error`: what the errors of derivatives add up to in a
    period, if they stay as they are.
    """

    def __init__(self, flow: Flow, case: FlowCase | None = None) -> None:
        self.case = () if case is None else (case.where, case.when)
        self._piece = None if case is None else case.piece
        self.period = float(flow.period)
        self.jitter = float(flow.jitter[0]), float(flow.jitter[1])
        self.error = {
            name: (self.period * float(low), self.period * float(high)) for name, (low, high) in flow.error.items()
        }
        self._jumps = {name: function(value) for name, value in flow.jumps.items()}
        self._rates = {name: function(rate) for name, rate in flow.rates.items()}
        self._held = {choice: {name: float(value) for name, value in of.items()} for choice, of in flow.held.items()}

    def holds(self, state: Mapping[str, float]) -> bool:
        """Returns True if the rule applies to a state that is this at a sample; without cases it always does."""
        return self._piece is None or self._piece.holds({name: Fraction(number) for name, number in state.items()})

    def hold_inputs(self, actions: Mapping[str, str]) -> Floats:
        """The inputs' values for a joint action by names."""
        return {name: value for choice in actions.items() for name, value in self._held[choice].items()}

    def derivative(self, state: Mapping[str, float], held: Mapping[str, float]) -> Floats:
        """The derivative of each variable."""
        known = {**state, **held}
        return {name: rate(known) for name, rate in self._rates.items()}

    def apply_jumps(self, state: Mapping[str, float], held: Mapping[str, float]) -> Floats:
        """The state at a sample after what jumps there."""
        known = {**state, **held}
        return {**state, **{name: value(known) for name, value in self._jumps.items()}}

    def move_state(self, state: Mapping[str, float], actions: Mapping[str, str], longer: float = 0.0) -> Floats:
        """The state after a period that is so many seconds longer than stated, without errors."""
        held, h = self.hold_inputs(actions), (self.period + longer) / PARTS
        now = self.apply_jumps(state, held)
        for _ in range(PARTS):
            first = self.derivative(now, held)
            second = self.derivative(_along(now, first, h / 2), held)
            third = self.derivative(_along(now, second, h / 2), held)
            last = self.derivative(_along(now, third, h), held)
            now = {x: now[x] + h / 6 * (first[x] + 2 * second[x] + 2 * third[x] + last[x]) for x in now}
        return now

    def integrate_states(self, state: Mapping[str, float], actions: Mapping[str, str], times: Float64) -> Float64:
        """The states at some times of a period, in order, [times, variables], by scipy's DOP853."""
        from scipy.integrate import solve_ivp  # half a second, which proofs and checks need not wait

        held, names = self.hold_inputs(actions), list(state)

        def rate(_: float, numbers: Float64) -> Float64:
            rates = self.derivative(dict(zip(names, numbers.tolist(), strict=True)), held)
            return np.array([rates[name] for name in names])

        begun, span = np.array(list(self.apply_jumps(state, held).values())), (0.0, float(times[-1]))
        solution = solve_ivp(rate, span, begun, "DOP853", t_eval=times, rtol=TOLERANCE, atol=TOLERANCE)
        if not solution.success:
            raise ArithmeticError(f"it grows beyond all bounds within {span[1]:g} s")
        return np.asarray(solution.y.T)


def flow_rules(flow: Flow) -> list[FlowRule]:
    """The rules of a flow in play: one for each of its cases."""
    if not flow.cases:
        return [FlowRule(flow)]
    return [FlowRule(own, case) for own, case in zip(flow.each, flow.cases, strict=True)]


def _along(state: Mapping[str, float], rate: Mapping[str, float], time: float) -> Floats:
    return {name: value + time * rate[name] for name, value in state.items()}


DRAWS, TRIES = 1_000, 100  # of starts at once, until one lies in the start region


def read(path: str | Path) -> Statement:
    """Reads the statement of a world file. InputError with the place of the first fault."""
    name = str(path)
    data = runs.read(Path(path), MAX_BYTES)
    kinds.ensure(data, name, kinds.WORLD.called, kinds.WORLD)
    try:
        return statement_of(data.decode(), Path(path).name)
    except UnicodeDecodeError:
        raise InputError("not a readable file", f"{name}: not UTF-8 text", "is this the right file?") from None


def file_of(world: str | Path) -> Path:
    """The world file that a user named, also as `system:FILE`. InputError for a world that is played, not stated."""
    name = str(world)
    if name.startswith(f"{SYSTEM}:"):
        return Path(name.removeprefix(f"{SYSTEM}:"))
    if not Path(name).exists() and is_named_by_user(name):
        what = "this world is played by its own code, which states no rules that a proof could use"
        advice = (
            "leave --system out: claims about observations hold in every world (`maviper verify PROFILE --new`); "
            "or state the rules in a world file (`maviper guide systems`)"
        )
        raise InputError(what, f"--system {name}", advice)
    return Path(name)


class MovingRule:
    """A rule in floats."""

    def __init__(self, rule: Rule, by: Computing = SINGLE) -> None:
        self.error = {name: _floats(bounds) for name, bounds in rule.error.items()}
        self.where = [(name, *_floats(bounds)) for name, bounds in rule.where.items()]
        self.when = rule.when
        self.case = (rule.where, rule.when)
        self.move = {name: function(move, by) for name, move in rule.move.items()}
        self.effect = {
            choice: {name: function(added, by) for name, added in effects.items()}
            for choice, effects in rule.effect.items()
        }

    def holds(self, state: Mapping[str, float]) -> bool:
        """Returns True if a state lies in its box and meets its conditions."""
        if not all(low <= state[name] <= high for name, low, high in self.where):
            return False
        exact = {name: Fraction(number) for name, number in state.items()} if self.when else {}
        return all(half.holds(exact) for half in self.when)

    def move_state(self, state: Mapping[str, float], actions: Mapping[str, str]) -> Floats:
        """The next state for a joint action by names, without an error."""
        after = {name: move(state) for name, move in self.move.items()}
        for choice in actions.items():
            for name, added in self.effect.get(choice, {}).items():
                after[name] += added(state)
        return after


AnyRule = MovingRule | FlowRule


class Moving:
    """A statement's ranges and rules in floats."""

    def __init__(self, statement: Statement) -> None:
        self.ranges = {each.name: _floats(each.range) for each in statement.system.variables}
        flow = statement.system.flow
        self._rules: list[AnyRule] = [MovingRule(rule) for rule in statement.rules]
        self._rules += [] if flow is None else flow_rules(flow)

    def within(self, state: Mapping[str, float]) -> bool:
        """Returns True if a state lies in the ranges of all variables."""
        return all(low <= state[name] <= high for name, (low, high) in self.ranges.items())

    def rules(self, state: Mapping[str, float]) -> list[AnyRule]:
        """The rules that hold in a state: none outside the ranges, several on a border."""
        return self.find_rules(state) if self.within(state) else []

    def find_rules(self, state: Mapping[str, float]) -> list[AnyRule]:
        """The rules whose boxes hold a state: a rule without a box holds beyond the ranges too."""
        return [rule for rule in self._rules if rule.holds(state)]

    def clip_state(self, state: Mapping[str, float]) -> Floats:
        """The state nearest to one in the ranges."""
        return {name: min(max(number, self.ranges[name][0]), self.ranges[name][1]) for name, number in state.items()}


def draw_rule(rules: Sequence[AnyRule], rng: np.random.Generator) -> AnyRule:
    """One of the rules that hold in a state: the first, or any of those that differ from it in choices alone."""
    ways = [rule for rule in rules if rule.case == rules[0].case]
    return ways[int(rng.integers(len(ways)))] if len(ways) > 1 else ways[0]


def _floats(bounds: Interval) -> tuple[float, float]:
    return float(bounds[0]), float(bounds[1])


def start(statement: Statement, rng: np.random.Generator) -> Floats:
    """A start: uniform among the states that the box of the start region and its further conditions allow.

    InputError where none is found, since the region is too thin.
    """
    bounds = box(statement)
    flow = statement.system.flow
    kept = dict[str, str]() if flow is None else flow.kept
    further = [half for half in statement.system.start if len(half.form.terms) > 1]  # the box, rounded, is met by all
    for _ in range(TRIES):
        drawn = {name: rng.uniform(float(low), float(high), DRAWS) for name, (low, high) in bounds.items()}
        for k in range(DRAWS):
            state = {name: float(numbers[k]) for name, numbers in drawn.items()}
            state |= {name: state[of] for name, of in kept.items()}
            exact = {name: Fraction(number) for name, number in state.items()}
            if all(half.holds(exact) for half in further):
                return state
    what = "no start was found: the start region is too thin beside its box"
    raise InputError(what, statement.system.name, "bound the start more tightly by its box")


def box(statement: Statement) -> dict[str, Interval]:
    """The bounds of each variable that the start region states by itself."""
    return bounds_of(statement.system.start, {each.name: each.range for each in statement.system.variables})
