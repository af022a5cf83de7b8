"""Expressions as functions of arrays.

Does: float64, many states at a time.
Assumes: nothing of what it gives is believed: each operation rounds, and what is not defined is NaN or infinite.
Does not: bound anything.
"""

from collections.abc import Callable, Mapping

import numpy as np

from codegen.ir import Float64
from codegen.numbers import nearest_double
from verify.systems.language.expressions import Call, Expression, Name, Number, Pi, Power, Product, Quotient, Sum

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
