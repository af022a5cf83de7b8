"""Expressions over the variables of a state, in exact numbers: affine forms, sums, products, quotients, functions.

Does: the data; intervals and boxes; which names stand in an expression; puts expressions in place of names; the affine
  form of one that is affine.
Assumes: constants of a file are numbers already.
Does not: read text (parsing.py) or enclose what is not affine (enclosures.py).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import TypeAlias

State = Mapping[str, Fraction]
Interval = tuple[Fraction, Fraction]
Box = Mapping[str, Interval]  # closed; a variable that is not named is free


@dataclass(frozen=True)
class Affine:
    """A sum of multiples of variables and a constant: `terms` by name, in order, none of them 0."""

    terms: tuple[tuple[str, Fraction], ...] = ()
    constant: Fraction = Fraction(0)

    @staticmethod
    def of(terms: Mapping[str, Fraction], constant: Fraction = Fraction(0)) -> Affine:
        """The form with these terms, in the one order in which equal forms are equal data."""
        return Affine(tuple(sorted((name, factor) for name, factor in terms.items() if factor)), constant)

    def at(self, state: State) -> Fraction:
        """Its value in a state."""
        return self.constant + sum((factor * state[name] for name, factor in self.terms), Fraction(0))

    def plus(self, other: Affine, times: Fraction = Fraction(1)) -> Affine:
        """This form and a multiple of another."""
        if not other.terms:
            return Affine(self.terms, self.constant + (other.constant if times == 1 else times * other.constant))
        terms = dict(self.terms)
        for name, factor in other.terms:
            terms[name] = terms.get(name, Fraction(0)) + times * factor
        return Affine.of(terms, self.constant + times * other.constant)


ONE, ZERO = Fraction(1), Fraction(0)


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
    if isinstance(expression, Name):
        return values.get(expression.name, expression)
    return _change_parts(expression, lambda part: substitute(part, values))


def replace_part(expression: Expression, old: Expression, new: Expression) -> Expression:
    """The expression with another one in place of a part, wherever it stands."""
    return new if expression == old else _change_parts(expression, lambda part: replace_part(part, old, new))


def _change_parts(expression: Expression, change: Callable[[Expression], Expression]) -> Expression:
    match expression:
        case Name() | Number() | Pi():
            return expression
        case Sum(left, right):
            return Sum(change(left), change(right))
        case Product(left, right):
            return Product(change(left), change(right))
        case Quotient(left, right):
            return Quotient(change(left), change(right))
        case Power(base, exponent):
            return Power(change(base), exponent)
        case Call(function, argument, bounds):
            return Call(function, change(argument), bounds)


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
