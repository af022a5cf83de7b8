"""An exact model with numbers of few digits: coordinates settled one after another, as simply as the question allows.

Does: tries dyadic numbers of few bits, which keep sums and differences float64 numbers, then fractions of few digits.
Assumes: a question about the region that the model answers.
Does not: judge states (states/real.py), or say that no float64 state answers where it found none.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction

from verify.claims.region import Interval, Region
from verify.solver.encode import Query, fix_variables
from verify.solver.solve import ask
from verify.states.real import value_of

BITS = (0, 1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 44, 52)  # behind the binary point
DENOMINATORS = (10, 100, 1_000)
MAX_ASKED = 100  # questions an order


def pin_model(
    question: Query, region: Region, model: Mapping[str, Fraction], budget: int
) -> tuple[dict[str, Fraction], int]:
    """A model of the question, of float64 numbers where such a one was found, and the resource units spent.

    `budget`: solver resource units per query.
    """
    spent, tries, names = 0, list[dict[str, Fraction]](), list(region.box)
    for order in (names, names[::-1]):
        pinned, units = _in_order(order, question, region, model, budget)
        spent += units
        if all(isinstance(value_of(pinned[name]), float) for name in names):
            return pinned, spent
        tries.append(pinned)
    return tries[0], spent


def _in_order(
    order: Sequence[str], question: Query, region: Region, model: Mapping[str, Fraction], budget: int
) -> tuple[dict[str, Fraction], int]:
    """Pins a model as `pin_model` does, coordinates in this order."""
    pinned, values, spent, queries = dict(model), dict[str, Fraction](), 0, 0
    for name in order:
        for value in _simpler(pinned[name], region.box[name]):
            if queries == MAX_ASKED:
                break
            queries += 1
            answer = ask(fix_variables(question, values | {name: value}), budget)
            spent += answer.resources
            if answer.model is not None:
                pinned = answer.model
                break
        values[name] = pinned[name]
    return pinned, spent


def _simpler(value: Fraction, bounds: Interval) -> Iterator[Fraction]:
    """Numbers near a value, the simplest first, until the value itself is one."""
    low, high = bounds
    near = [value.limit_denominator(most) for most in DENOMINATORS]
    beside = (Fraction(side(value * 2**bits), 2**bits) for bits in BITS for side in (round, math.floor, math.ceil))
    for simple in dict.fromkeys([*beside, *near]):
        if simple == value:
            return
        if low <= simple <= high:
            yield simple
