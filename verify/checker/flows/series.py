"""Taylor coefficients in time of the solutions of a flow, over many boxes at once, with their derivatives by the start.

Does: the checker's reading of derivatives: each expression as a list of operations, each operation as a recursion.
Assumes: a flow that is well formed.
Does not: bound what a series leaves out (steps.py).

If x' = f(x) and x(t) = x_0 + x_1 t + x_2 t**2 + ..., then x_(k+1) = f_k / (k + 1), where f_k is the coefficient of
f(x(t)). Coefficients of products are convolutions; those of sin, cos, exp, quotients and roots follow from the
differential equations of these functions. All of it is done with intervals, so a coefficient holds those of all
starts in a box.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from verify.checker.covers.rounding import Factor
from verify.checker.flows.functions import exponential, half_turns, root, waves
from verify.checker.flows.spans import Spans, exact, inverse, plus, scale_spans, square, times
from verify.checker.reading import RejectedError
from verify.systems.language.expressions import Call, Expression, Name, Number, Pi, Power, Product, Quotient, Sum
from verify.systems.system import Flow


class Coefficient(NamedTuple):
    """A coefficient [n], and its derivatives by the start, [n, variables]; None: these are not asked, or are 0."""

    value: Spans
    slope: Spans | None


Known = Coefficient | None  # None: exactly 0


def _plus(one: Known, other: Known) -> Known:
    if one is None or other is None:
        return one or other
    slope = one.slope or other.slope
    if one.slope is not None and other.slope is not None:
        slope = plus(one.slope, other.slope)
    return Coefficient(plus(one.value, other.value), slope)


@lru_cache(maxsize=1 << 12)
def factor_of(number: Fraction) -> Factor:
    """The one object of a factor."""
    return Factor(number)


def _scale_coefficient(one: Known, factor: Fraction) -> Known:
    if one is None or not factor:
        return None
    if factor == 1:
        return one
    by = factor_of(factor)
    return Coefficient(scale_spans(one.value, by), None if one.slope is None else scale_spans(one.slope, by))


def _times(one: Known, other: Known) -> Known:
    if one is None or other is None:
        return None
    slope = _scale_slope(one.value, other.slope)
    more = _scale_slope(other.value, one.slope)
    slope = plus(slope, more) if slope is not None and more is not None else slope or more
    return Coefficient(times(one.value, other.value), slope)


def _scale_slope(value: Spans, slope: Spans | None) -> Spans | None:
    return None if slope is None else times(value.at((slice(None), None)), slope)


def _of(value: Spans, slope: Spans, inner: Coefficient) -> Coefficient:
    """A function of a part, by its value and its derivative."""
    return Coefficient(value, _scale_slope(slope, inner.slope))


# --- operations, each by the places of what it reads


@dataclass(frozen=True)
class _Operation:
    does: str
    reads: tuple[int, ...] = ()
    name: str = ""
    number: Fraction = Fraction(0)


def _constant(operation: _Operation, count: int) -> Spans:
    return half_turns(count) if operation.does == "pi" else exact(operation.number, count)


class FlowReading:
    """The derivatives of a flow as one list of operations."""

    def __init__(self, flow: Flow, names: Sequence[str]) -> None:
        self.names = tuple(names)
        self._operations: list[_Operation] = []
        self._places: dict[_Operation, int] = {}
        self._rates = [self._place(flow.rates[name]) for name in names]

    def series(self, start: Spans, held: Mapping[str, Spans], order: int, sloped: bool) -> list[list[Known]]:
        """The coefficients 0 to `order` of each variable, for starts in boxes [n, variables]; `held`: inputs, [n].
        `sloped`: with derivatives by the start.
        """
        count, size = start.low.shape
        values: list[list[Known]] = [[] for _ in self._operations]
        coefficients: list[list[Known]] = []
        memo: Memo = {}
        for column in range(size):
            one = np.zeros((count, size))
            one[:, column] = 1.0
            coefficients.append([Coefficient(start.at((slice(None), column)), Spans(one, one) if sloped else None)])
        for k in range(order):
            for place, operation in enumerate(self._operations):
                if operation.does == "name" and operation.name in self.names:
                    values[place].append(coefficients[self.names.index(operation.name)][k])
                elif operation.does in ("name", "number", "pi"):
                    known = held[operation.name] if operation.does == "name" else _constant(operation, count)
                    values[place].append(Coefficient(known, None) if k == 0 else None)
                else:
                    read = [values[each] for each in operation.reads]
                    values[place].append(_NEXT[operation.does](read, values[place], operation.number, k, memo))
            for column, place in enumerate(self._rates):
                coefficients[column].append(_scale_coefficient(values[place][k], Fraction(1, k + 1)))
        return coefficients

    # --- expressions as operations

    def _place(self, expression: Expression) -> int:
        match expression:
            case Number(value):
                return self._add(_Operation("number", number=value))
            case Pi():
                return self._add(_Operation("pi"))
            case Name(name):
                return self._add(_Operation("name", name=name))
            case Sum(left, right):
                return self._add(_Operation("sum", (self._place(left), self._place(right))))
            case Product(Number(value), other) | Product(other, Number(value)) if not value:
                return self._add(_Operation("number"))
            case Product(Number(value), other) | Product(other, Number(value)):
                return self._add(_Operation("multiple", (self._place(other),), number=value))
            case Product(left, right):
                return self._add(_Operation("product", (self._place(left), self._place(right))))
            case Quotient(left, Number(value)) if value:
                return self._add(_Operation("multiple", (self._place(left),), number=1 / value))
            case Quotient(left, right):
                return self._add(_Operation("quotient", (self._place(left), self._place(right))))
            case Power(base, exponent):
                return self._power(self._place(base), exponent)
            case Call(function, argument, None):
                return self._call(function, self._place(argument))
            case _:
                raise RejectedError("a derivative holds what the checker of flows does not know")

    def _power(self, base: int, exponent: int) -> int:
        if exponent == 1:
            return base
        half = self._power(base, exponent // 2)
        even = self._add(_Operation("square", (half,)))
        return even if exponent % 2 == 0 else self._add(_Operation("product", (even, base)))

    def _call(self, function: str, inner: int) -> int:
        if function in ("sin", "cos", "tan"):
            places = self._wave(inner)
            if function != "tan":
                return places[function == "cos"]
            return self._add(_Operation("quotient", places))
        if function not in ("exp", "sqrt"):
            raise RejectedError(f"the checker of flows does not know {function}")
        return self._add(_Operation(function, (inner,)))

    def _wave(self, inner: int) -> tuple[int, int]:
        """sin and cos of a part: each reads the other's coefficients of before."""
        sine_at = self._places.get(_Operation("sin", (inner,)))
        if sine_at is None:
            sine_at = len(self._operations)
            self._places[_Operation("sin", (inner,))] = sine_at
            self._operations += [
                _Operation("sin", (inner, sine_at + 1)),
                _Operation("cos", (inner, sine_at)),
            ]
        return sine_at, sine_at + 1

    def _add(self, operation: _Operation) -> int:
        if operation not in self._places:
            self._places[operation] = len(self._operations)
            self._operations.append(operation)
        return self._places[operation]


# --- the coefficient k of each kind, from those of what it reads and its own of before

Read = list[list[Known]]
Own = list[Known]
Memo = dict[int, tuple[Spans, Spans]]  # sin and cos of a value, by the object that it is


def _sum(read: Read, own: Own, number: Fraction, k: int, memo: Memo) -> Known:
    return _plus(read[0][k], read[1][k])


def _multiple(read: Read, own: Own, number: Fraction, k: int, memo: Memo) -> Known:
    return _scale_coefficient(read[0][k], number)


def _product(read: Read, own: Own, number: Fraction, k: int, memo: Memo) -> Known:
    return _convolve(read[0], read[1], range(k + 1), k)


def _square(read: Read, own: Own, number: Fraction, k: int, memo: Memo) -> Known:
    """Twice the products of unlike coefficients, and the square of the middle one."""
    doubled = _scale_coefficient(_convolve(read[0], read[0], range((k + 1) // 2), k), Fraction(2))
    middle = read[0][k // 2]
    if k % 2 or middle is None:
        return doubled
    slope = (
        None if middle.slope is None else scale_spans(times(middle.value.at((slice(None), None)), middle.slope), TWO)
    )
    return _plus(doubled, Coefficient(square(middle.value), slope))


def _quotient(read: Read, own: Own, number: Fraction, k: int, memo: Memo) -> Known:
    """q v = u, so q_k v_0 = u_k - (v_1 q_(k-1) + ... + v_k q_0)."""
    left = _plus(read[0][k], _scale_coefficient(_convolve(read[1], own, range(1, k + 1), k), Fraction(-1)))
    return _times(left, _inverse(read[1][0]))


def _inverse(below: Known) -> Known:
    if below is None:
        raise RejectedError("a derivative divides by 0")
    reciprocal = inverse(below.value)
    return _of(reciprocal, scale_spans(square(reciprocal), MINUS), below)


def _sin(read: Read, own: Own, number: Fraction, k: int, memo: Memo) -> Known:
    inner, other = read
    if k:
        return _from_rates(inner, other, k)
    sine, cosine = _waves(inner, memo)
    return _of(sine, cosine, _first(inner))


def _cos(read: Read, own: Own, number: Fraction, k: int, memo: Memo) -> Known:
    inner, other = read
    if k:
        return _scale_coefficient(_from_rates(inner, other, k), Fraction(-1))
    sine, cosine = _waves(inner, memo)
    return _of(cosine, scale_spans(sine, MINUS), _first(inner))


def _waves(inner: Own, memo: Memo) -> tuple[Spans, Spans]:
    first = _first(inner)
    if id(first) not in memo:
        memo[id(first)] = waves(first.value)
    return memo[id(first)]


def _exp(read: Read, own: Own, number: Fraction, k: int, memo: Memo) -> Known:
    if k:
        return _from_rates(read[0], own, k)
    first = _first(read[0])
    exp_value = exponential(first.value)
    return _of(exp_value, exp_value, first)


def _sqrt(read: Read, own: Own, number: Fraction, k: int, memo: Memo) -> Known:
    """r r = u, so 2 r_0 r_k = u_k - (r_1 r_(k-1) + ... + r_(k-1) r_1)."""
    if k:
        left = _plus(read[0][k], _scale_coefficient(_convolve(own, own, range(1, k), k), Fraction(-1)))
        return _times(left, _inverse(_scale_coefficient(own[0], Fraction(2))))
    first = _first(read[0])
    root_value = root(first.value)
    return _of(root_value, inverse(scale_spans(root_value, TWO)), first)


def _from_rates(inner: Own, other: Own, k: int) -> Known:
    """(u_1 w_(k-1) + 2 u_2 w_(k-2) + ... + k u_k w_0) / k: what u' w adds up to."""
    total: Known = None
    for j in range(1, k + 1):
        total = _plus(total, _times(_scale_coefficient(inner[j], Fraction(j, k)), other[k - j]))
    return total


def _convolve(one: Own, other: Own, places: range, k: int) -> Known:
    total: Known = None
    for j in places:
        total = _plus(total, _times(one[j], other[k - j]))
    return total


def _first(read: Own) -> Coefficient:
    """The value that a part begins with."""
    if read[0] is None:
        raise RejectedError("a derivative takes a function of nothing")
    return read[0]


MINUS, TWO = Factor(Fraction(-1)), Factor(Fraction(2))
_NEXT = {
    "sum": _sum,
    "multiple": _multiple,
    "product": _product,
    "square": _square,
    "quotient": _quotient,
    "sin": _sin,
    "cos": _cos,
    "exp": _exp,
    "sqrt": _sqrt,
}
