"""Taylor coefficients in time of the solutions of a flow, with derivatives by the start; what a step asks of them.

Does: the checker's reading of derivatives: each expression as a list of operations, each operation as a recursion;
  programs of a step: derivatives, polynomials, their slopes, the remainder. Each is made when it is first asked for.
Assumes: a flow that is well formed.
Does not: know boxes, or bound what a series leaves out (steps.py).

If x' = f(x) and x(t) = x_0 + x_1 t + x_2 t**2 + ..., then x_(k+1) = f_k / (k + 1), where f_k is the coefficient of
f(x(t)). Coefficients of products are convolutions; those of sin, cos, exp, quotients and roots follow from the
differential equations of these functions. A tape is computed with intervals (intervals.py), so a coefficient holds
those of all starts in a box.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from functools import cached_property
from typing import NamedTuple

from verify.checker.flows.intervals import Operation, Program, Tape
from verify.checker.reading import RejectedError
from verify.systems.expressions import Call, Expression, Name, Number, Pi, Power, Product, Quotient, Sum
from verify.systems.system import Flow


class Coefficient(NamedTuple):
    """A coefficient, and its derivatives by the starts of variables, by their columns: places on a tape. What is left
    out is exactly 0.
    """

    value: int
    slopes: Mapping[int, int]


Known = Coefficient | None  # None: exactly 0
ONE = Fraction(1)


class Series(NamedTuple):
    """The coefficients from 0 on of each variable, and the tape that they are on."""

    tape: Tape
    coefficients: list[list[Known]]


class FlowReading:
    """The derivatives of a flow as one list of operations."""

    def __init__(self, flow: Flow, names: Sequence[str]) -> None:
        self.names = tuple(names)
        self._operations: list[Operation] = []
        self._places: dict[Operation, int] = {}
        self._rates = [self._place(flow.rates[name]) for name in names]

    def series(self, order: int, sloped: bool, tape: Tape | None = None, mark: str = "") -> Series:
        """The coefficients 0 to `order` of each variable, by its start, which is given by a mark and its name, and by
        inputs. `sloped`: with derivatives.
        """
        tape = Tape() if tape is None else tape
        writing = _Writing(tape)
        values: list[list[Known]] = [[] for _ in self._operations]
        coefficients: list[list[Known]] = []
        for column, name in enumerate(self.names):
            slopes = {column: tape.write("exact", number=ONE)} if sloped else {}
            coefficients.append([Coefficient(tape.write("given", name=mark + name), slopes)])
        for k in range(order):
            for place, operation in enumerate(self._operations):
                if operation.does == "name" and operation.name in self.names:
                    values[place].append(coefficients[self.names.index(operation.name)][k])
                elif operation.does in ("name", "number", "pi"):
                    values[place].append(writing.constant(operation) if k == 0 else None)
                else:
                    read = [values[each] for each in operation.reads]
                    values[place].append(_NEXT[operation.does](writing, read, values[place], operation.number, k))
            for column, place in enumerate(self._rates):
                coefficients[column].append(writing.scale(values[place][k], Fraction(1, k + 1)))
        return Series(tape, coefficients)

    # --- expressions as operations

    def _place(self, expression: Expression) -> int:
        match expression:
            case Number(value):
                return self._add("number", number=value)
            case Pi():
                return self._add("pi")
            case Name(name):
                return self._add("name", name=name)
            case Sum(left, right):
                return self._add("sum", self._place(left), self._place(right))
            case Product(Number(value), other) | Product(other, Number(value)) if not value:
                return self._add("number")
            case Product(Number(value), other) | Product(other, Number(value)):
                return self._add("multiple", self._place(other), number=value)
            case Product(left, right):
                return self._add("product", self._place(left), self._place(right))
            case Quotient(left, Number(value)) if value:
                return self._add("multiple", self._place(left), number=1 / value)
            case Quotient(left, right):
                return self._add("quotient", self._place(left), self._place(right))
            case Power(base, exponent):
                return self._power(self._place(base), exponent)
            case Call(function, argument, None):
                inner = self._place(argument)
                if function in ("exp", "sqrt"):
                    return self._add(function, inner)
                if function not in ("sin", "cos", "tan"):
                    raise RejectedError(f"the checker of flows does not know {function}")
                # sin and cos: each reads the other's coefficients of before
                sine = self._places.get(Operation("sin", (inner,)))
                if sine is None:
                    sine = self._places[Operation("sin", (inner,))] = len(self._operations)
                    self._operations += [Operation("sin", (inner, sine + 1)), Operation("cos", (inner, sine))]
                return self._add("quotient", sine, sine + 1) if function == "tan" else sine + (function == "cos")
            case _:
                raise RejectedError("a derivative holds what the checker of flows does not know")

    def _power(self, base: int, exponent: int) -> int:
        if exponent == 1:
            return base
        even = self._add("square", self._power(base, exponent // 2))
        return even if exponent % 2 == 0 else self._add("product", even, base)

    def _add(self, does: str, *reads: int, name: str = "", number: Fraction = Fraction(0)) -> int:
        operation = Operation(does, reads, name, number)
        if operation not in self._places:
            self._places[operation] = len(self._operations)
            self._operations.append(operation)
        return self._places[operation]


# --- coefficients on a tape


class _Writing:
    """Sums, products and functions of coefficients, written on a tape."""

    def __init__(self, tape: Tape) -> None:
        self.tape = tape

    def constant(self, operation: Operation) -> Coefficient:
        """Returns the coefficient of an operation that does not depend on time."""
        does = {"name": "given", "number": "exact"}.get(operation.does, operation.does)
        return Coefficient(self.tape.write(does, name=operation.name, number=operation.number), {})

    def plus(self, one: Known, other: Known) -> Known:
        """A sum."""
        if one is None or other is None:
            return one or other
        return Coefficient(self.tape.plus(one.value, other.value), self._add_slopes(one.slopes, other.slopes))

    def scale(self, one: Known, factor: Fraction) -> Known:
        """A multiple by an exact number."""
        if one is None or not factor:
            return None
        slopes = {column: self.tape.scale(slope, factor) for column, slope in one.slopes.items()}
        return Coefficient(self.tape.scale(one.value, factor), slopes)

    def times(self, one: Known, other: Known) -> Known:
        """A product."""
        if one is None or other is None:
            return None
        slopes = self._add_slopes(self.multiply_slopes(one.value, other), self.multiply_slopes(other.value, one))
        return Coefficient(self.tape.times(one.value, other.value), slopes)

    def convolve(self, one: Own, other: Own, places: range, k: int) -> Known:
        """The sum of products of coefficients j and k - j, over some j."""
        total: Known = None
        for j in places:
            total = self.plus(total, self.times(one[j], other[k - j]))
        return total

    def inverse(self, below: Known) -> Known:
        """1 over a coefficient."""
        if below is None:
            raise RejectedError("a derivative divides by 0")
        reciprocal = self.tape.write("inverse", below.value)
        slope = self.tape.scale(self.tape.write("square", reciprocal), -ONE)
        return Coefficient(reciprocal, self.multiply_slopes(slope, below))

    def multiply_slopes(self, value: int, inner: Coefficient) -> dict[int, int]:
        """The derivatives of a coefficient times a value."""
        return {column: self.tape.times(value, slope) for column, slope in inner.slopes.items()}

    def _add_slopes(self, one: Mapping[int, int], other: Mapping[int, int]) -> dict[int, int]:
        both = {column: self.tape.plus(one[column], other[column]) for column in one.keys() & other.keys()}
        return {**one, **other, **both}


# --- the coefficient k of each kind, from those of what it reads and its own of before

Read = list[list[Known]]
Own = list[Known]


def _sum(write: _Writing, read: Read, own: Own, number: Fraction, k: int) -> Known:
    return write.plus(read[0][k], read[1][k])


def _multiple(write: _Writing, read: Read, own: Own, number: Fraction, k: int) -> Known:
    return write.scale(read[0][k], number)


def _product(write: _Writing, read: Read, own: Own, number: Fraction, k: int) -> Known:
    return write.convolve(read[0], read[1], range(k + 1), k)


def _square(write: _Writing, read: Read, own: Own, number: Fraction, k: int) -> Known:
    """Twice the products of unlike coefficients, and the square of the middle one."""
    doubled = write.scale(write.convolve(read[0], read[0], range((k + 1) // 2), k), Fraction(2))
    middle = read[0][k // 2]
    if k % 2 or middle is None:
        return doubled
    slopes = {
        column: write.tape.scale(each, Fraction(2))
        for column, each in write.multiply_slopes(middle.value, middle).items()
    }
    return write.plus(doubled, Coefficient(write.tape.write("square", middle.value), slopes))


def _quotient(write: _Writing, read: Read, own: Own, number: Fraction, k: int) -> Known:
    """q v = u, so q_k v_0 = u_k - (v_1 q_(k-1) + ... + v_k q_0)."""
    left = write.plus(read[0][k], write.scale(write.convolve(read[1], own, range(1, k + 1), k), -ONE))
    return write.times(left, write.inverse(read[1][0]))


def _wave(write: _Writing, read: Read, k: int, of_sine: bool) -> Known:
    """sin or cos: each grows by the other, cos by its negative."""
    sign = ONE if of_sine else -ONE
    inner, other = read
    if k:
        return write.scale(_from_rates(write, inner, other, k), sign)
    first = _first(inner)
    sine, cosine = write.tape.write("sin", first.value), write.tape.write("cos", first.value)
    value, slope = (sine, cosine) if of_sine else (cosine, sine)
    return Coefficient(value, write.multiply_slopes(write.tape.scale(slope, sign), first))


def _exp(write: _Writing, read: Read, own: Own, number: Fraction, k: int) -> Known:
    if k:
        return _from_rates(write, read[0], own, k)
    first = _first(read[0])
    value = write.tape.write("exp", first.value)
    return Coefficient(value, write.multiply_slopes(value, first))


def _sqrt(write: _Writing, read: Read, own: Own, number: Fraction, k: int) -> Known:
    """r r = u, so 2 r_0 r_k = u_k - (r_1 r_(k-1) + ... + r_(k-1) r_1)."""
    if k:
        left = write.plus(read[0][k], write.scale(write.convolve(own, own, range(1, k), k), -ONE))
        return write.times(left, write.inverse(write.scale(own[0], Fraction(2))))
    first = _first(read[0])
    value = write.tape.write("sqrt", first.value)
    slope = write.tape.write("inverse", write.tape.scale(value, Fraction(2)))
    return Coefficient(value, write.multiply_slopes(slope, first))


def _from_rates(write: _Writing, inner: Own, other: Own, k: int) -> Known:
    """(u_1 w_(k-1) + 2 u_2 w_(k-2) + ... + k u_k w_0) / k: what u' w adds up to."""
    total: Known = None
    for j in range(1, k + 1):
        total = write.plus(total, write.times(write.scale(inner[j], Fraction(j, k)), other[k - j]))
    return total


def _first(read: Own) -> Coefficient:
    """The value that a part begins with."""
    if read[0] is None:
        raise RejectedError("a derivative takes a function of nothing")
    return read[0]


_NEXT: Mapping[str, Callable[[_Writing, Read, Own, Fraction, int], Known]] = {
    "sum": _sum,
    "multiple": _multiple,
    "product": _product,
    "square": _square,
    "quotient": _quotient,
    "sin": lambda write, read, own, number, k: _wave(write, read, k, of_sine=True),
    "cos": lambda write, read, own, number, k: _wave(write, read, k, of_sine=False),
    "exp": _exp,
    "sqrt": _sqrt,
}


class Stepping(NamedTuple):
    """The order K of the series, and the seconds h of a step."""

    order: int
    seconds: Fraction


AROUND, ON_THE_WAY = "around ", "on the way: "  # marks of starts; no text can write a name with them


def centre_of(number: int) -> str:
    """The mark of the centres of a frame."""
    return f"centre {number}: "


def error_name(name: str) -> str:
    """By which name a program is given the error of a derivative. No text can write it."""
    return f"error of {name}"


class StepPrograms:
    """The programs of one flow and step; `off`: variables whose derivatives have errors."""

    def __init__(self, reading: FlowReading, how: Stepping, off: Sequence[str]) -> None:
        self._reading, self._order, self._seconds, self._off = reading, how.order, how.seconds, off
        self._steps: dict[int, Program] = {}

    @cached_property
    def rates(self) -> Program:
        """f, [d]."""
        tape, series = self._reading.series(1, sloped=False)
        return Program(tape, [_value_of(each[1]) for each in series])

    @cached_property
    def rate_slopes(self) -> Program:
        """Df, [d d], by rows."""
        tape, series = self._reading.series(1, sloped=True)
        columns = range(len(series))
        return Program(tape, [_slope_of(each[1], column) for each in series for column in columns])

    def step(self, frames: int) -> Program:
        """T_h of the centres of so many frames, [d] each; DT_h of what lies AROUND, [d d] by rows; what T_h leaves out
        and errors add, by what is ON_THE_WAY, [d]; f's derivative along solutions there, [d]. All of it is one program,
        since its parts can be computed together.
        """
        if frames not in self._steps:
            tape, wanted = Tape(), list[int | None]()
            for number in range(frames):
                series = self._reading.series(self._order - 1, False, tape, centre_of(number)).coefficients
                wanted += [self._sum_powers(tape, [_value_of(one) for one in each]) for each in series]
            series = self._reading.series(self._order - 1, True, tape, AROUND).coefficients
            of = [[_slope_of(one, column) for one in each] for each in series for column in range(len(series))]
            wanted += [self._sum_powers(tape, terms) for terms in of]
            wanted += self._write_remainder(tape)
            series, errors = self._write_on_the_way(tape, 2)  # f' is 2 x_2 + Dx_1 W
            twice = [_scale_place(tape, _value_of(each[2]), Fraction(2)) for each in series]
            moved = [self._multiply_errors(tape, each[1], errors) for each in series]
            wanted += [_add_places(tape, both) for both in zip(twice, moved, strict=True)]
            self._steps[frames] = Program(tape, wanted)
        return self._steps[frames]

    def _write_remainder(self, tape: Tape) -> list[int | None]:
        """h**K x_K + sum of k < K of h**(k+1) / (k+1) Dx_k W, where W are the errors by their names."""
        series, errors = self._write_on_the_way(tape, self._order)
        remainder: list[int | None] = []
        for each in series:
            last = _scale_place(tape, _value_of(each[self._order]), self._seconds**self._order)
            for k in range(self._order):
                moved = self._multiply_errors(tape, each[k], errors)
                last = _add_places(tape, [last, _scale_place(tape, moved, self._seconds ** (k + 1) / (k + 1))])
            remainder.append(last)
        return remainder

    def _write_on_the_way(self, tape: Tape, order: int) -> tuple[list[list[Known]], dict[int, int]]:
        """Coefficients of what is on the way, and errors by their columns."""
        series = self._reading.series(order, bool(self._off), tape, ON_THE_WAY).coefficients
        return series, {self._reading.names.index(n): tape.write("given", name=error_name(n)) for n in self._off}

    def _multiply_errors(self, tape: Tape, one: Known, errors: dict[int, int]) -> int | None:
        """The derivatives of a coefficient times errors."""
        moved = {column: _slope_of(one, column) for column in errors}
        parts = [tape.times(slope, errors[column]) for column, slope in moved.items() if slope is not None]
        return _add_places(tape, parts)

    def _sum_powers(self, tape: Tape, places: Sequence[int | None]) -> int | None:
        """The sum of h**k c_k, the last ones first."""
        terms = [_scale_place(tape, place, self._seconds**k) for k, place in enumerate(places)]
        return _add_places(tape, reversed(terms))


def _value_of(coefficient: Known) -> int | None:
    return None if coefficient is None else coefficient.value


def _slope_of(coefficient: Known, column: int) -> int | None:
    return None if coefficient is None else coefficient.slopes.get(column)


def _scale_place(tape: Tape, place: int | None, factor: Fraction) -> int | None:
    return None if place is None else tape.scale(place, factor)


def _add_places(tape: Tape, places: Iterable[int | None]) -> int | None:
    """A sum from left to right."""
    total: int | None = None
    for place in places:
        if place is not None:
            total = place if total is None else tape.plus(total, place)
    return total
