"""What a world file writes about numbers, as trees: sums, products, quotients, powers and functions.

Does: the data of expressions; which names stand in one; puts expressions in place of names; the affine form of one
  that is affine; its value in floats.
Assumes: constants of a file are numbers already.
Does not: read text (parsing.py) or enclose what is not affine (enclosures.py).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from operator import itemgetter
from typing import TypeAlias

from verify.systems.affine import Affine, Interval

ONE, ZERO = Fraction(1), Fraction(0)
ROUNDED = 1e-12  # what rounding may take from a number that is 0


@dataclass(frozen=True)
class Number:
    """A constant, exact."""

    value: Fraction


@dataclass(frozen=True)
class Pi:
    """The number pi, which no fraction is."""


@dataclass(frozen=True)
class Name:
    """A variable, or an input that an agent's action sets."""

    name: str


@dataclass(frozen=True)
class Sum:
    """One expression and another."""

    left: Expression
    right: Expression


@dataclass(frozen=True)
class Product:
    """One expression times another."""

    left: Expression
    right: Expression


@dataclass(frozen=True)
class Quotient:
    """One expression over another, which is never 0 where the statement is made."""

    left: Expression
    right: Expression


@dataclass(frozen=True)
class Power:
    """An expression to a whole power of at least 2."""

    base: Expression
    exponent: int


@dataclass(frozen=True)
class Call:
    """A function of an expression: `sin`, `cos`, `tan`, `exp`, `sqrt` or `clip`, with the bounds of a clip."""

    function: str
    argument: Expression
    bounds: Interval | None = None


Expression: TypeAlias = Number | Pi | Name | Sum | Product | Quotient | Power | Call


def parts(expression: Expression) -> tuple[Expression, ...]:
    """Returns the parts of an expression."""
    match expression:
        case Sum(left, right) | Product(left, right) | Quotient(left, right):
            return left, right
        case Power(base, _):
            return (base,)
        case Call(_, argument, _):
            return (argument,)
        case _:
            return ()


def names(expression: Expression) -> frozenset[str]:
    """The names in it."""
    if isinstance(expression, Name):
        return frozenset((expression.name,))
    return frozenset[str]().union(*map(names, parts(expression)))


def extent(expression: Expression) -> tuple[int, int]:
    """Returns how many parts an expression has, parts of parts included, and how deep they lie."""
    below = [extent(part) for part in parts(expression)]
    return 1 + sum(count for count, _ in below), 1 + max((depth for _, depth in below), default=0)


def degree(expression: Expression) -> int:
    """At most how often names are multiplied in it, with those within functions."""
    match expression:
        case Number() | Pi():
            return 0
        case Name():
            return 1
        case Product(left, right) | Quotient(left, right):
            return degree(left) + degree(right)
        case Power(base, exponent):
            return exponent * degree(base)
        case _:
            return max(map(degree, parts(expression)))


def terms(expression: Expression) -> Iterator[Expression]:
    """Yields the terms of an expression, signs carried along."""
    match expression:
        case Sum(left, right):
            yield from terms(left)
            yield from terms(right)
        case Product(Number() as factor, Sum(left, right)):
            yield from terms(Product(factor, left))
            yield from terms(Product(factor, right))
        case _:
            yield expression


def total(expressions: list[Expression]) -> Expression:
    """Their sum; 0 of none."""
    added: Expression | None = None
    for each in expressions:
        added = each if added is None else Sum(added, each)
    return added or Number(ZERO)


def substitute(expression: Expression, values: Mapping[str, Expression]) -> Expression:
    """The expression with others in place of names."""
    match expression:
        case Name(name):
            return values.get(name, expression)
        case Number() | Pi():
            return expression
        case Sum(left, right):
            return Sum(substitute(left, values), substitute(right, values))
        case Product(left, right):
            return Product(substitute(left, values), substitute(right, values))
        case Quotient(left, right):
            return Quotient(substitute(left, values), substitute(right, values))
        case Power(base, exponent):
            return Power(substitute(base, values), exponent)
        case Call(function, argument, bounds):
            return Call(function, substitute(argument, values), bounds)


@lru_cache(maxsize=1 << 12)  # rules by cases repeat the same few
def affine(expression: Expression) -> Affine | None:
    """The affine form that it is; None for one that is none by its own writing."""
    return _affine(expression)


def _affine(expression: Expression) -> Affine | None:
    match expression:
        case Number(value):
            return Affine.of({}, value)
        case Name(name):
            return Affine.of({name: ONE})
        case Sum(left, right):
            one, other = _affine(left), _affine(right)
            return None if one is None or other is None else one.plus(other)
        case Product(left, right):
            return _product(_affine(left), _affine(right))
        case Quotient(left, right):
            below = _affine(right)
            inverse = None if below is None or below.terms or not below.constant else Affine.of({}, 1 / below.constant)
            return _product(_affine(left), inverse)
        case Power(base, exponent):
            under = _affine(base)
            return None if under is None or under.terms else Affine.of({}, under.constant**exponent)
        case Call() | Pi():
            return None


def _product(one: Affine | None, other: Affine | None) -> Affine | None:
    if one is None or other is None or (one.terms and other.terms):
        return None
    return Affine().plus(one, other.constant) if not other.terms else Affine().plus(other, one.constant)


def of_affine(form: Affine) -> Expression:
    """An affine form as an expression."""
    made: list[Expression] = [Product(Number(factor), Name(name)) for name, factor in form.terms]
    return total([*made, Number(form.constant)] if form.constant or not made else made)


def function(expression: Expression) -> Callable[[Mapping[str, float]], float]:
    """Its value in a state, in float64, operation by operation as it is written.

    The function raises ZeroDivisionError, OverflowError and ValueError as Python has them.
    """
    match expression:
        case Number(constant):
            number = float(constant)
            return lambda state: number
        case Pi():
            return lambda state: math.pi
        case Name(name):
            return itemgetter(name)
        case Power(base, exponent):
            under = function(base)
            return lambda state: under(state) ** exponent
        case Call(called, argument, bounds):
            inner = function(argument)
            if bounds is not None:
                low, high = map(float, bounds)
                return lambda state: min(max(inner(state), low), high)
            called_by = IN_FLOATS[called]
            return lambda state: called_by(inner(state))
        case Sum(left, right):
            one, other = function(left), function(right)
            return lambda state: one(state) + other(state)
        case Product(left, right):
            one, other = function(left), function(right)
            return lambda state: one(state) * other(state)
        case Quotient(left, right):
            one, other = function(left), function(right)
            return lambda state: one(state) / other(state)


def _root(number: float) -> float:
    """The square root, 0 of what rounding has put below 0."""
    return math.sqrt(0.0 if -ROUNDED < number < 0 else number)


IN_FLOATS: Mapping[str, Callable[[float], float]] = {
    "sin": math.sin,
    "cos": math.cos,
    "tan": math.tan,
    "exp": math.exp,
    "sqrt": _root,
}


def value(expression: Expression, state: Mapping[str, float]) -> float:
    """Its value in a state, as `function` computes it."""
    return function(expression)(state)
