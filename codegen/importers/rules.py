"""A program of tests, assignments and returns as one decision tree, whatever language it was written in.

Does: follows every path through the program; writes `and`, `or`, `not` and `==` as splits; leaves out tests that
  earlier ones decide.
Assumes: tests compare one feature with a number, both as doubles.
Does not: read a language (python/source.py), or choose names.

Every test becomes x <= t with t a double, exactly: x < c says x <= (the double before c); an integer that no double
equals is rounded down first. Only NaN may be decided otherwise: it fails every comparison, and so passes to the right
of a split, but x > c sends it where x <= c holds. `Program.nan` says whether no NaN meets such a test.
"""

import math
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from codegen.errors import InputError
from codegen.importers.symbolic.labels import Value
from codegen.importers.symbolic.line import Number, at_most, below
from codegen.ir import MAX_DEPTH, NO_ACTION, NO_CHILD, NO_FEATURE, GrownTree

UNBOUNDED = (-math.inf, math.inf)
MAX_NODES = 1 << 19
MAX_STEPS = 10_000_000  # of following paths, which a program of many variables multiplies


@dataclass(frozen=True)
class AtMost:
    """Whether a feature is at most a threshold."""

    feature: int
    threshold: float
    nan: bool = True  # whether the program, too, takes NaN for not at most it


@dataclass(frozen=True)
class Joined:
    """Conditions joined by `and` (`every`) or by `or`."""

    every: bool
    parts: "tuple[Condition, ...]"


@dataclass(frozen=True)
class Not:
    """A condition turned around."""

    part: "Condition"


Condition: TypeAlias = AtMost | Joined | Not | bool


@dataclass(frozen=True)
class If:
    """A condition, and what is done where it holds and where it does not."""

    condition: Condition
    then: "tuple[Statement, ...]"
    otherwise: "tuple[Statement, ...]"
    line: int


@dataclass(frozen=True)
class Set:
    """A variable that holds a value from here on."""

    name: str
    value: Value


@dataclass(frozen=True)
class Return:
    """The end: a value, or what the variable `name` holds."""

    value: Value | None
    name: str
    line: int


Statement: TypeAlias = If | Set | Return
Rest: TypeAlias = "tuple[Statement, Rest] | None"  # what is still to be done


@dataclass(frozen=True)
class Program:
    """The tree of a program."""

    tree: GrownTree  # a leaf's action is the place of its value
    values: tuple[Value, ...]  # in the order in which leaves first give them, from left to right
    nan: bool  # whether a NaN is decided as by the program


@dataclass(frozen=True)
class _Path:
    """One path through a program, as far as it was followed."""

    rest: Rest
    variables: dict[str, Value]
    within: dict[int, tuple[float, float]]  # tested features: (low, high]; without a high end also NaN
    depth: int
    parent: int  # the row and the column that lead on to it
    column: int


def compared(feature: int, operator: str, number: Number) -> Condition:
    """The condition `feature operator number`, for <=, <, >, >=, == and !=."""
    if operator == "<=":
        return AtMost(feature, at_most(number))
    if operator == "<":
        return AtMost(feature, below(number))
    if operator in (">", ">="):
        return Not(AtMost(feature, at_most(number) if operator == ">" else below(number), nan=False))
    if operator == "!=":
        return Not(compared(feature, "==", number))
    above = Not(AtMost(feature, below(number)))  # a NaN never comes this far
    return at_most(number) == number and Joined(True, (AtMost(feature, at_most(number)), above))


def program(statements: tuple[Statement, ...], where: str) -> Program:
    """The tree of a function's statements. InputError, with `where` and the line, for a path without a return, for a
    variable that is not set on a path, and for too deep or large a tree.
    """
    growth = _Growth(where)
    growth.open.append(_Path(_before(statements, None), {}, {}, 0, NO_CHILD, 0))
    while growth.open:
        growth.follow(growth.open.pop())
    return Program(GrownTree(*np.array(growth.rows, dtype=np.float64).T), tuple(growth.values), growth.nan)


def _before(statements: tuple[Statement, ...], rest: Rest) -> Rest:
    for statement in reversed(statements):
        rest = (statement, rest)
    return rest


class _Growth:
    """A tree that grows: a row a node, in preorder."""

    def __init__(self, where: str) -> None:
        self.where = where
        self.rows: list[list[float]] = []
        self.values: dict[Value, int] = {}
        self.open: list[_Path] = []
        self.nan = True
        self.steps = 0

    def follow(self, path: _Path) -> None:
        """Goes on to the next split or leaf of a path, and opens what follows a split."""
        rest, variables = path.rest, path.variables
        while rest is not None:
            statement, after = rest
            self.steps += 1
            if self.steps > MAX_STEPS:
                raise InputError("the program has too many paths", self.where, "return in each branch")
            if isinstance(statement, Return):
                self._leaf(statement, variables, path)
                return
            if isinstance(statement, Set):
                variables, rest = variables | {statement.name: statement.value}, after
                continue
            condition = statement.condition
            if isinstance(condition, AtMost):
                known = self._known(condition, path)
                if known is None:
                    self._split(condition, statement, replace(path, rest=after, variables=variables))
                    return
                condition = known
            rest = _before(_simpler(condition, statement), after)
        raise InputError("a path ends without a return", self.where, "return an action on every path")

    def _known(self, test: AtMost, path: _Path) -> bool | None:
        """How earlier tests decide this one; None: they do not."""
        low, high = path.within.get(test.feature, UNBOUNDED)
        self.nan &= test.nan or high < math.inf
        return (
            True if high <= test.threshold and high < math.inf else False if low >= test.threshold > -math.inf else None
        )

    def _leaf(self, end: Return, variables: dict[str, Value], path: _Path) -> None:
        value = variables.get(end.name) if end.value is None else end.value
        if value is None:
            what = f"{end.name!r} is returned, but holds nothing on some path"
            raise InputError(what, f"{self.where}, line {end.line}", "return a number, a text or a list of numbers")
        place = self.values.setdefault(value, len(self.values))
        self._node([NO_FEATURE, 0.0, NO_CHILD, NO_CHILD, place], path, end.line)

    def _split(self, test: AtMost, statement: If, path: _Path) -> None:
        if path.depth == MAX_DEPTH:
            where = f"{self.where}, line {statement.line}"
            raise InputError(f"the tree is deeper than {MAX_DEPTH} splits", where, "simplify it first")
        place = self._node([test.feature, test.threshold, NO_CHILD, NO_CHILD, NO_ACTION], path, statement.line)
        low, high = path.within.get(test.feature, UNBOUNDED)
        for side, column, bounds in (
            (statement.otherwise, 3, (test.threshold, high)),
            (statement.then, 2, (low, test.threshold)),
        ):
            within = path.within | {test.feature: bounds}
            rest = _before(side, path.rest)
            self.open.append(_Path(rest, path.variables, within, path.depth + 1, place, column))

    def _node(self, row: list[float], path: _Path, line: int) -> int:
        if len(self.rows) == MAX_NODES:
            where = f"{self.where}, line {line}"
            raise InputError(f"the tree has more than {MAX_NODES} nodes", where, "simplify its conditions")
        if path.parent != NO_CHILD:
            self.rows[path.parent][path.column] = len(self.rows)
        self.rows.append(row)
        return len(self.rows) - 1


def _simpler(condition: Condition, statement: If) -> tuple[Statement, ...]:
    """What to do instead of a statement whose condition is no test, or is decided."""
    then, otherwise, line = statement.then, statement.otherwise, statement.line
    if isinstance(condition, Not):
        return (If(condition.part, otherwise, then, line),)
    if isinstance(condition, Joined) and condition.parts:
        first, rest = condition.parts[0], Joined(condition.every, condition.parts[1:])
        inner = (If(rest, then, otherwise, line),)
        return (If(first, inner, otherwise, line) if condition.every else If(first, then, inner, line),)
    holds = condition.every if isinstance(condition, Joined) else bool(condition)
    return then if holds else otherwise
