"""Expressions and conditions of a world's file, read from text with their units.

Does: numbers as they are written, `9.8[m/s^2]`, names, + - * / **, sin, cos, clip; comparisons as half spaces.
Assumes: the names that a text may use are given with their units. Units that do not fit are refused.
Does not: evaluate: Python's own parser cuts the text, and only what is listed here is taken from it.

A number without a unit fits beside any other in a sum, and is a pure number in a product.
"""

import ast
from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import NamedTuple

from codegen.errors import InputError, UnknownNameError
from verify.claims.region import exact
from verify.systems.language.expressions import (
    Call,
    Expression,
    Name,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
    affine,
    degree,
    extent,
)
from verify.systems.language.units import PURE, Unit, times, unit_of, written
from verify.systems.system import Affine, HalfSpace, Polytope

MAX_CHARACTERS, MAX_DEPTH, MAX_PARTS, MAX_EXPONENT, MAX_DEGREE = 2_000, 150, 20_000, 8, 64
LARGEST, MAX_BITS = 10**100, 1 << 15  # of a number that is computed from others, and of its denominator
FUNCTIONS = ("sin", "cos", "clip")
MINUS = Number(Fraction(-1))
HOW = "write sums and products of names and numbers, such as x + 0.1[s]*v"


class Typed(NamedTuple):
    """An expression and its unit; None: a bare number, which fits any."""

    expression: Expression
    unit: Unit | None


@dataclass(frozen=True)
class Names:
    """What a text may name: `known` are variables and inputs, `meant` constants and what `let` names."""

    known: Mapping[str, Unit]
    meant: Mapping[str, Typed] = field(default_factory=dict[str, Typed])


def expression_of(text: str, names: Names, where: str) -> Typed:
    """The expression that a text states. InputError with `where` and the column of the first fault."""
    reader = _Reader(text, names, where)
    return reader.sum(reader.tree())


def fitting(typed: Typed, unit: Unit, where: str) -> Expression:
    """The expression, whose unit must be this one. InputError otherwise."""
    if typed.unit not in (None, unit):
        what = f"the unit is {written(typed.unit or PURE)}, and {written(unit)} is needed"
        raise InputError(f"units do not fit: {what}", where, "give numbers their unit, as in 0.1[s]*v")
    return typed.expression


def affine_of(text: str, names: Names, where: str) -> tuple[Affine, Unit | None]:
    """The affine form that a text states, and its unit. InputError for what is not affine."""
    typed = expression_of(text, names, where)
    return _affine(typed.expression, where), typed.unit


def half_spaces(text: str, names: Names, where: str) -> Polytope:
    """The half spaces of a comparison, `0 <= x - y < 1`. InputError for anything else."""
    reader = _Reader(text, names, where)
    tree = reader.tree()
    if not isinstance(tree, ast.Compare):
        raise InputError("not a comparison", where, "compare two sums by <=, <, >=, > or ==")
    found: list[HalfSpace] = []
    sides = [tree.left, *tree.comparators]
    for left, sign, right in zip(sides, tree.ops, sides[1:], strict=False):
        less = _affine(reader.less(left, right).expression, where)
        found += _compared(less, sign, where)
    return tuple(found)


def _affine(expression: Expression, where: str) -> Affine:
    found = affine(expression)
    if found is None:
        raise InputError("not an affine form", where, "write sums of variables times numbers")
    return found


def _compared(less: Affine, sign: ast.cmpop, where: str) -> list[HalfSpace]:
    """`less` compared with 0."""
    more = Affine().plus(less, Fraction(-1))
    match sign:
        case ast.LtE() | ast.Lt():
            return [HalfSpace(less, isinstance(sign, ast.Lt))]
        case ast.GtE() | ast.Gt():
            return [HalfSpace(more, isinstance(sign, ast.Gt))]
        case ast.Eq():
            return [HalfSpace(less), HalfSpace(more)]
        case _:
            raise InputError("not a comparison that a region can have", where, "use <=, <, >=, > or ==")


class _Reader:
    """The text of one expression."""

    def __init__(self, text: str, names: Names, where: str) -> None:
        self._text, self._names, self._where = text.strip(), names, where
        self._depth = 0

    def tree(self) -> ast.expr:
        """What Python's parser makes of the text."""
        if len(self._text) > MAX_CHARACTERS or not self._text.isascii() or "\n" in self._text:
            what = f"an expression is one line of at most {MAX_CHARACTERS} ASCII characters"
            raise InputError(what, self._where, "split it")
        try:
            return ast.parse(self._text, mode="eval").body
        except SyntaxError as error:
            raise InputError(f"cannot read {self._text[:60]!r}", self._place(error.offset or 1), HOW) from None
        except (ValueError, RecursionError, MemoryError):
            raise InputError("cannot read the expression", self._where, HOW) from None

    def _place(self, column: int) -> str:
        return f"{self._where}, column {column}"

    def _wrong(self, what: str, node: ast.expr, advice: str = HOW) -> InputError:
        return InputError(what, self._place(node.col_offset + 1), advice)

    def _written(self, node: ast.expr) -> str:
        return self._text[node.col_offset : node.end_col_offset]

    def sum(self, node: ast.expr) -> Typed:
        """The expression of a node and all below it."""
        self._depth += 1
        if self._depth > MAX_DEPTH:
            raise self._wrong(f"nested deeper than {MAX_DEPTH} levels", node, "split the expression")
        found = self._node(node)
        self._depth -= 1
        count, depth = extent(found.expression)
        if count > MAX_PARTS or depth > MAX_DEPTH:
            raise self._wrong(f"more than {MAX_PARTS} parts, or {MAX_DEPTH} levels", node, "simplify the expression")
        self._ensure_small(found.expression, node)
        return found

    def _ensure_small(self, expression: Expression, node: ast.expr) -> None:
        """InputError for powers of powers, whose numbers would fill the memory."""
        if degree(expression) > MAX_DEGREE:
            raise self._wrong(f"names are multiplied more than {MAX_DEGREE} times", node, "simplify the expression")
        form = affine(expression)
        for number in () if form is None else (form.constant, *(factor for _, factor in form.terms)):
            if abs(number) > LARGEST or number.denominator.bit_length() > MAX_BITS:
                raise self._wrong("a number that is too large or too fine", node, "simplify the expression")

    def _node(self, node: ast.expr) -> Typed:
        match node:
            case ast.Constant():
                return Typed(Number(self._number(node)), None)
            case ast.Subscript(ast.Constant() as number, unit):
                return Typed(Number(self._number(number)), unit_of(self._written(unit), self._place(node.col_offset)))
            case ast.Name() | ast.Attribute():
                return self._named(node)
            case ast.UnaryOp(ast.USub(), operand):
                return self._minus(self.sum(operand))
            case ast.UnaryOp(ast.UAdd(), operand):
                return self.sum(operand)
            case ast.BinOp(left, sign, right):
                return self._joined(node, self.sum(left), sign, right)
            case ast.Call():
                return self._called(node)
            case _:
                raise self._wrong(f"cannot read {self._written(node)[:60]!r}", node)

    def _number(self, node: ast.Constant) -> Fraction:
        return exact(self._written(node), self._place(node.col_offset + 1))

    def _named(self, node: ast.expr) -> Typed:
        name = self._written(node)
        if name in self._names.meant:
            return self._names.meant[name]
        if name not in self._names.known:
            known = (*self._names.known, *self._names.meant)
            raise UnknownNameError("name", name, known, self._place(node.col_offset + 1))
        return Typed(Name(name), self._names.known[name])

    def _minus(self, typed: Typed) -> Typed:
        if isinstance(typed.expression, Number):
            return Typed(Number(-typed.expression.value), typed.unit)
        return Typed(Product(MINUS, typed.expression), typed.unit)

    def _joined(self, node: ast.BinOp, left: Typed, sign: ast.operator, below: ast.expr) -> Typed:
        if isinstance(sign, ast.Pow):
            return self._power(node, left, below)
        right = self.sum(below)
        match sign:
            case ast.Add() | ast.Sub():
                other = self._minus(right) if isinstance(sign, ast.Sub) else right
                return Typed(Sum(left.expression, other.expression), self._same(left, right, node))
            case ast.Mult():
                return Typed(Product(left.expression, right.expression), _multiplied(left.unit, right.unit, 1))
            case ast.Div():
                if right.expression == Number(Fraction(0)):
                    raise self._wrong("division by zero", node)
                return Typed(Quotient(left.expression, right.expression), _multiplied(left.unit, right.unit, -1))
            case ast.BitXor():
                raise self._wrong("^ is no power", node, "write ** for powers")
            case _:
                raise self._wrong(f"cannot read {self._written(node)[:60]!r}", node)

    def _same(self, left: Typed, right: Typed, node: ast.expr) -> Unit | None:
        """The unit of both; a bare number has that of the other."""
        if None not in (left.unit, right.unit) and left.unit != right.unit:
            what = f"units do not fit: {written(left.unit or PURE)} and {written(right.unit or PURE)}"
            raise self._wrong(what, node, "give numbers their unit, as in 0.1[s]*v")
        return right.unit if left.unit is None else left.unit

    def _power(self, node: ast.BinOp, base: Typed, exponent: ast.expr) -> Typed:
        power = exponent.value if isinstance(exponent, ast.Constant) else None
        if not isinstance(power, int) or isinstance(power, bool) or not 1 <= power <= MAX_EXPONENT:
            raise self._wrong(f"powers are whole, from 1 to {MAX_EXPONENT}", node)
        if power == 1:
            return base
        return Typed(Power(base.expression, power), None if base.unit is None else times(PURE, base.unit, power))

    def _called(self, node: ast.Call) -> Typed:
        function = self._written(node.func)
        if function not in FUNCTIONS:
            raise UnknownNameError("function", function, FUNCTIONS, self._place(node.col_offset + 1))
        given = [self.sum(each) for each in node.args]
        if len(given) != (3 if function == "clip" else 1) or node.keywords:
            how = "clip(SUM, LOW, HIGH)" if function == "clip" else f"{function}(SUM)"
            raise self._wrong(f"{function} has other arguments", node, f"write {how}")
        if function == "clip":
            return self._clipped(node, given)
        if given[0].unit not in (None, PURE):
            what = f"units do not fit: {function} of {written(given[0].unit or PURE)}"
            raise self._wrong(what, node, "give it a pure number, or radians")
        return Typed(Call(function, given[0].expression), PURE)

    def _clipped(self, node: ast.Call, given: list[Typed]) -> Typed:
        ends = [affine(each.expression) for each in given[1:]]
        low, high = (None if end is None or end.terms else end.constant for end in ends)
        if low is None or high is None or low > high:
            raise self._wrong("the bounds of clip are two numbers, the lower one first", node)
        unit = self._same(given[0], given[1], node)
        unit = self._same(Typed(given[0].expression, unit), given[2], node)
        return Typed(Call("clip", given[0].expression, (low, high)), unit)

    def less(self, left: ast.expr, right: ast.expr) -> Typed:
        """One side less the other."""
        one, other = self.sum(left), self.sum(right)
        return Typed(Sum(one.expression, self._minus(other).expression), self._same(one, other, left))


def _multiplied(one: Unit | None, other: Unit | None, power: int) -> Unit | None:
    if one is None and other is None:
        return None
    return times(one or PURE, other or PURE, power)
