"""Rules of a world file over many states at once: each number the one that a single state gives.

Does: the value of an expression in all rows of a table; which rules hold in which rows, and where they lead.
Assumes: a checked file; finite numbers.
Does not: prove, or move by flows.

Sums, products, quotients and roots of float64 are the same in numpy. Other functions and powers are not, so Python's
are asked number by number, and once for an argument that an expression has several times.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from codegen.ir import Bool, Float64
from maviper.worlds.stated.systems import MovingRule
from verify.systems.expressions import Call, Expression, Name, Number, Pi, Power, Product, Quotient, Sum
from verify.systems.observing import SINGLE

if TYPE_CHECKING:
    from verify.systems.statement import Rule

Columns: TypeAlias = Mapping[str, Float64]  # of a table of states, by variable


class RuleColumns:
    """A rule, over the rows of a table."""

    def __init__(self, rule: Rule) -> None:
        self._rule, self._one = rule, MovingRule(rule)
        self.error = self._one.error

    def holding(self, state: Columns) -> Bool:
        """The rows whose states lie in its box and meet its conditions, [rows]."""
        rows = np.ones(len(next(iter(state.values()))), dtype=np.bool_)
        for name, (low, high) in self._rule.where.items():
            rows &= (state[name] >= float(low)) & (state[name] <= float(high))
        if self._rule.when:  # exact numbers decide
            for row in np.flatnonzero(rows).tolist():
                rows[row] = self._one.holds({name: float(column[row]) for name, column in state.items()})
        return rows

    def move_states(self, state: Columns, actions: Mapping[str, Sequence[str]]) -> dict[str, Float64]:
        """The next states for joint actions, [rows] by agent, without errors, each as by `MovingRule.move_state`."""
        known: dict[Expression, Float64] = {}
        after = {name: _column(each, state, known) for name, each in self._rule.move.items()}
        for agent, taken in actions.items():
            for (of, action), effects in self._rule.effect.items():
                rows = np.flatnonzero(np.array(taken) == action) if of == agent else np.zeros(0, dtype=np.int64)
                for name, each in effects.items() if len(rows) else ():
                    some = {other: column.take(rows) for other, column in state.items()}
                    after[name][rows] += _column(each, some, {})
        return after


def _column(expression: Expression, state: Columns, known: dict[Expression, Float64]) -> Float64:
    """The values of an expression, [rows], a new array. `known`: of calls and powers that were met."""
    rows = len(next(iter(state.values())))
    match expression:
        case Number(constant):
            return np.full(rows, float(constant))
        case Pi():
            return np.full(rows, math.pi)
        case Name(name):
            return state[name].copy()
        case Sum(left, right):
            return _column(left, state, known) + _column(right, state, known)
        case Product(left, right):
            return _column(left, state, known) * _column(right, state, known)
        case Quotient(left, right):
            below = _column(right, state, known)
            if not below.all():
                raise ZeroDivisionError("float division by zero")
            return _column(left, state, known) / below
        case Power() | Call():
            if expression not in known:
                known[expression] = _evaluate_each(expression, state, known)
            return known[expression].copy()


def _evaluate_each(expression: Power | Call, state: Columns, known: dict[Expression, Float64]) -> Float64:
    """The values of a power or of a function, number by number, as Python has them."""
    match expression:
        case Power(base, exponent):
            return np.array([number**exponent for number in _column(base, state, known).tolist()])
        case Call(function, argument, bounds):
            inner = _column(argument, state, known)
            if bounds is None:
                return np.array([SINGLE.functions[function](number) for number in inner.tolist()])
            low, high = map(float, bounds)
            return np.array([min(max(number, low), high) for number in inner.tolist()])
