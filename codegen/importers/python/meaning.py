"""What if/else Python returns: its syntax tree followed for many observations at once, as Python would run it.

Does: follows statements and expressions with the observations that reach them; compares as Python compares.
Assumes: a function that source.py has read, so that nothing else can occur.
Does not: share a line with that reader, or evaluate anything by Python's own means.
"""

import ast
import operator
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from codegen.ir import Bool, Floats

COMPARE: Mapping[type[ast.cmpop], Any] = {
    ast.Lt: operator.lt, ast.LtE: operator.le, ast.Gt: operator.gt,
    ast.GtE: operator.ge, ast.Eq: operator.eq, ast.NotEq: operator.ne,
}  # fmt: skip


@dataclass(frozen=True)
class _Column:
    """A feature, as a value of the program."""

    place: int


class _Observation:
    """The whole observation, as a value of the program."""


def decided(
    function: ast.FunctionDef, constants: Mapping[str, Any], names: Sequence[str], rows: Floats, arrays: str = ""
) -> list[Any]:
    """What the function returns for each observation; None where it returns nothing. `names`: of features; `arrays`:
    the type of NumPy's arrays that it is given, "" where it is given Python's floats.
    """
    doubles = rows.astype(arrays or np.float64)
    parameters = [each.arg for each in (*function.args.posonlyargs, *function.args.args)]
    bound: dict[str, Any] = dict(constants)
    if len(parameters) == 1:
        bound[parameters[0]] = _Observation()
    else:
        bound |= {name: _Column(place) for place, name in enumerate(parameters)}
    found: list[Any] = [None] * len(rows)
    open_: list[tuple[Any, np.ndarray, dict[str, Any]]] = [(_linked(function.body, None), np.arange(len(rows)), bound)]
    while open_:
        rest, reached, bound = open_.pop()
        while rest is not None and len(reached):
            node, rest = rest
            here = _Here(doubles, reached, bound, names, _numpy if arrays else _compared)
            if isinstance(node, ast.Return):
                for places, value in here.values(node.value):
                    for place in places.tolist():
                        found[place] = value
                break
            if isinstance(node, ast.If):
                holds = here.holds(node.test)
                open_.append((_linked(node.orelse, rest), reached[~holds], bound))
                rest, reached = _linked(node.body, rest), reached[holds]
            elif isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None:
                target = node.targets[0] if isinstance(node, ast.Assign) else node.target
                *others, (reached, bound) = here.bindings(target, node.value)
                open_ += [(rest, places, other) for places, other in others]
    return found


def _linked(nodes: Sequence[ast.stmt], rest: Any) -> Any:
    for node in reversed(nodes):
        rest = (node, rest)
    return rest


class _Here:
    """The observations that have come to a statement, and what names stand for there."""

    def __init__(
        self, doubles: np.ndarray, reached: np.ndarray, bound: dict[str, Any], names: Sequence[str], compared: Any
    ) -> None:
        self.doubles, self.reached, self.bound, self.names, self.compared = doubles, reached, bound, names, compared

    def at(self, reached: np.ndarray) -> "_Here":
        """The same statement for some of the observations."""
        return _Here(self.doubles, reached, self.bound, self.names, self.compared)

    def bindings(self, target: ast.AST, node: ast.expr) -> list[tuple[np.ndarray, dict[str, Any]]]:
        """What names stand for after an assignment, for each group of observations."""
        if isinstance(target, ast.Name):
            return [(places, self.bound | {target.id: value}) for places, value in self.values(node)]
        each = {item.id: _Column(place) for place, item in enumerate(target.elts)}  # type: ignore[attr-defined]
        return [(self.reached, self.bound | each)]

    def values(self, node: Any) -> list[tuple[np.ndarray, Any]]:
        """What an expression is, with the observations for which it is that."""
        if isinstance(node, ast.IfExp):
            holds = self.holds(node.test)
            sides = ((self.reached[holds], node.body), (self.reached[~holds], node.orelse))
            return [part for places, side in sides for part in self.at(places).values(side)]
        return [(self.reached, self.value(node))]

    def value(self, node: Any) -> Any:
        """What an expression is: a feature, a number, a text, a list."""
        if isinstance(node, ast.Constant):
            return node.value
        if isinstance(node, ast.UnaryOp):
            return -self.value(node.operand) if isinstance(node.op, ast.USub) else +self.value(node.operand)
        if isinstance(node, ast.List | ast.Tuple):
            return tuple(self.value(each) for each in node.elts)
        if isinstance(node, ast.Subscript):
            key: object = node.slice.value  # type: ignore[attr-defined]
            return _Column(self.names.index(key) if isinstance(key, str) else cast(int, key))
        if isinstance(node, ast.Attribute):
            return f"{self.value(node.value)}.{node.attr}"
        return self.bound.get(node.id, node.id)

    def numbers(self, value: Any) -> Any:
        """A feature's values, or the number itself."""
        if isinstance(value, _Observation):
            return self.doubles[self.reached, 0]
        return self.doubles[self.reached, value.place] if isinstance(value, _Column) else value

    def holds(self, node: ast.expr) -> Bool:
        """For which of the observations a condition holds."""
        if isinstance(node, ast.BoolOp):
            join = np.logical_and if isinstance(node.op, ast.And) else np.logical_or
            return join.reduce([self.holds(each) for each in node.values])
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            return ~self.holds(node.operand)
        if isinstance(node, ast.Compare):
            sides = [self.numbers(self.value(each)) for each in (node.left, *node.comparators)]
            pairs = zip(node.ops, sides, sides[1:], strict=False)
            return np.logical_and.reduce([self.compared(COMPARE[type(each)], *pair) for each, *pair in pairs])
        truth = self.numbers(self.value(node))
        return np.broadcast_to(np.asarray(truth, dtype=bool), self.reached.shape)


def _numpy(compare: Any, left: Any, right: Any) -> Bool:
    """A comparison of an array with a number of Python, by NumPy's own rules."""
    with np.errstate(under="ignore"):  # where the number becomes one of the array's
        return np.asarray(compare(left, right), dtype=bool)


def _compared(compare: Any, left: Any, right: Any) -> Bool:
    """A comparison as Python makes it: an integer that is no double is compared exactly."""
    if any(isinstance(each, int) and abs(each) > 2**53 for each in (left, right)):
        left, right = np.asarray(left, dtype=object), np.asarray(right, dtype=object)
    with np.errstate(invalid="ignore"):  # of NaN among objects
        return np.asarray(compare(left, right), dtype=bool)
