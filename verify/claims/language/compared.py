"""Numbers beside a feature, read as the agents that observe it compare them.

Does: reads an inequality over one feature as a test of the agents that observe it; spells a float that a decimal means.
Assumes: all agents that observe a feature compare the same type of numbers.
Does not: touch sums of several features.

A claim says x < 0 of the float32 that an agent compares. Read of the float64 number before it is rounded, the claim
would fail at -1e-46, which the agent sees as 0; read as a test, both mean the same numbers.
"""

from collections.abc import Callable, Mapping
from decimal import Decimal
from fractions import Fraction
from itertools import count
from math import inf
from typing import NamedTuple

from codegen.numbers import nearest_double, nearest_number, neighbour
from verify.claims.formula import And, Formula, Linear, Not, Or, conjunction, disjunction


class Compared(NamedTuple):
    """A comparison of a feature: float32 or float64; (is at most, is above) one of these numbers, as formulas."""

    numbers: str
    cut: Callable[[float], tuple[Formula, Formula]]


def read_as_compared(formula: Formula, known: Mapping[str, Compared]) -> Formula:
    """The formula whose inequalities over one feature are tests of it."""
    match formula:
        case And(parts):
            return conjunction(*(read_as_compared(part, known) for part in parts))
        case Or(parts):
            return disjunction(*(read_as_compared(part, known) for part in parts))
        case Not(part):
            return Not(read_as_compared(part, known))
        case Linear(((weight, name),), bound, strict) if name in known:
            numbers, cut = known[name]
            # up to an end, or the opposite of what is below it
            return cut(last_of(bound / weight, numbers, below=strict == (weight > 0)))[0 if weight > 0 else 1]
        case _:
            return formula


def last_of(end: Fraction, numbers: str, below: bool) -> float:
    """The largest of the `numbers` that is at most `end`, or, where `below`, that is below it."""
    near = neighbour(neighbour(nearest_double(end), inf, numbers), inf, numbers)
    while Fraction(float(near)) > end or (below and Fraction(float(near)) == end):
        near = neighbour(near, -inf, numbers)
    return float(near)


def spell_unlike(near: float, exact: Fraction, numbers: str) -> str:
    """A float with as many digits, from 15 on, as tell it from other floats and from an exact number."""
    texts = (f"{Decimal(near):.{digits}g}" for digits in count(15))
    return next(text for text in texts if nearest_number(Fraction(text), numbers) == near and Fraction(text) != exact)
