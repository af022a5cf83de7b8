"""What a query in VNN-LIB says of given numbers: read by the language's own package, evaluated exactly."""

import operator
from fractions import Fraction

import vnnlib

SIGNS = {
    vnnlib.LessEqual: operator.le,
    vnnlib.LessThan: operator.lt,
    vnnlib.GreaterEqual: operator.ge,
    vnnlib.GreaterThan: operator.gt,
    vnnlib.Equal: operator.eq,
    vnnlib.NotEqual: operator.ne,
}


def number(term, at):
    """The value of a term, exactly; `at`: (variable, indices) -> value."""
    match term:
        case vnnlib.Var():
            return at[term.name, tuple(term.indices)]
        case vnnlib.Negate():
            return -number(term.expr, at)
        case vnnlib.Plus():
            return sum((number(each, at) for each in term.args), Fraction(0))
        case vnnlib.Minus():
            return number(term.head, at) - sum((number(each, at) for each in term.rest), Fraction(0))
        case vnnlib.Multiply():
            first, second = (number(each, at) for each in term.args)
            return first * second
        case _:
            return Fraction(term.lexeme)


def true(fact, at):
    if isinstance(fact, vnnlib.And):
        return all(true(part, at) for part in fact.args)
    if isinstance(fact, vnnlib.Or):
        return any(true(part, at) for part in fact.args)
    return SIGNS[type(fact)](number(fact.lhs, at), number(fact.rhs, at))
