"""What rules make of expressions: the rule of each way to choose, and expressions as functions of arrays.

Does: says which choices a rule holds, how each is called, and puts their values in place of the names that stand for
  them; expressions in float64, many states at a time.
Assumes: choices as they were read (parsing.py); nothing of what arrays give is believed: each operation rounds, and
  what is not defined is NaN or infinite.
Does not: read texts, or bound anything.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import product
from math import prod
from typing import NamedTuple

import numpy as np

from codegen.errors import InputError
from codegen.ir import Float64
from codegen.numbers import nearest_double
from verify.systems.language.expressions import (
    Call,
    Expression,
    Name,
    Number,
    Pi,
    Power,
    Product,
    Quotient,
    Sum,
    names,
    substitute,
)
from verify.systems.language.parsing import Choice, Option
from verify.toml_places import Place

MAX_WAYS = 256  # to choose in one rule


class ChosenMotion(NamedTuple):
    """The next value of each variable for some choices, and what these are in the words of the file."""

    next: Mapping[str, Expression]
    words: Mapping[str, str]


def call(called: dict[str, str], choices: Mapping[str, Choice], name: str) -> None:
    """Calls the choices that were read last by the name that they stand under; a second one gets a number too."""
    fresh = [each for each in choices if each not in called]
    for number, each in enumerate(fresh, 1):
        called[each] = name if number == 1 and name not in called.values() else f"{name} {number}"


def ways(
    stated: Mapping[str, Expression], choices: Mapping[str, Choice], called: Mapping[str, str], where: Place
) -> Iterator[ChosenMotion]:
    """The next values for each way to choose. InputError for too many."""
    used = _find_used(stated.values(), choices)
    count = prod(len(choices[name]) for name in used)
    if count > MAX_WAYS:
        raise InputError(f"{count:,} ways to choose, of at most {MAX_WAYS}", where, "choose between fewer values")
    for options in product(*(choices[name] for name in used)):
        taken = dict(zip(used, options, strict=True))
        words = {called[name]: option.written for name, option in taken.items()}
        yield ChosenMotion({name: _replace_choices(each, taken) for name, each in stated.items()}, words)


def _find_used(stated: Iterable[Expression], choices: Mapping[str, Choice]) -> list[str]:
    """The choices that expressions hold, those within others included, in the order in which they were read."""
    used: set[str] = set()
    pending = [name for each in stated for name in names(each) if name in choices]
    while pending:
        name = pending.pop()
        if name not in used:
            used.add(name)
            pending += [other for option in choices[name] for other in names(option.value) if other in choices]
    return [name for name in choices if name in used]


def _replace_choices(expression: Expression, taken: Mapping[str, Option]) -> Expression:
    """The expression with what is taken in place of choices."""
    while names(expression) & taken.keys():
        expression = substitute(expression, {name: option.value for name, option in taken.items()})
    return expression


Evaluated = Callable[[Mapping[str, Float64]], Float64]


def vectorise(expression: Expression) -> Evaluated:
    """An expression as a function of arrays by name."""
    match expression:
        case Number(value):
            number = np.asarray(nearest_double(value))
            return lambda known: number
        case Pi():
            return lambda known: np.asarray(np.pi)
        case Name(name):
            return lambda known: known[name]
        case Sum(left, right):
            one, other = vectorise(left), vectorise(right)
            return lambda known: one(known) + other(known)
        case Product(left, right):
            one, other = vectorise(left), vectorise(right)
            return lambda known: one(known) * other(known)
        case Quotient(left, right):
            one, other = vectorise(left), vectorise(right)
            return lambda known: one(known) / other(known)
        case Power(base, exponent):
            under = vectorise(base)
            return lambda known: under(known) ** exponent
        case Call(function, argument, bounds):
            inner = vectorise(argument)
            if bounds is not None:
                low, high = map(nearest_double, bounds)
                return lambda known: np.clip(inner(known), low, high)
            named = getattr(np, function)
            return lambda known: named(inner(known))
