"""What a step of a flow asks of its series, as programs: derivatives, polynomials, their slopes, the remainder.

Does: writes what steps.py says, from the coefficients of series.py. Each program is made when it is first asked for.
Assumes: a flow that was read.
Does not: know boxes.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from functools import cached_property
from typing import NamedTuple

from verify.checker.flows.series import FlowReading, Known
from verify.checker.flows.tapes import Program, Tape


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
                wanted += self._write_polynomial(tape, centre_of(number))
            wanted += [*self._write_slopes(tape), *self._write_remainder(tape), *self._write_bends(tape)]
            self._steps[frames] = Program(tape, wanted)
        return self._steps[frames]

    def _write_polynomial(self, tape: Tape, mark: str) -> list[int | None]:
        series = self._reading.series(self._order - 1, False, tape, mark).coefficients
        return [self._sum_powers(tape, [_value_of(one) for one in each]) for each in series]

    def _write_slopes(self, tape: Tape) -> list[int | None]:
        series = self._reading.series(self._order - 1, True, tape, AROUND).coefficients
        of = [[_slope_of(one, column) for one in each] for each in series for column in range(len(series))]
        return [self._sum_powers(tape, terms) for terms in of]

    def _write_remainder(self, tape: Tape) -> list[int | None]:
        """h**K x_K + sum of k < K of h**(k+1) / (k+1) Dx_k W, where W are the errors by their names."""
        series, errors = self._write_on_the_way(tape, self._order)
        return [self._bound_last(tape, each, errors) for each in series]

    def _write_bends(self, tape: Tape) -> list[int | None]:
        """2 x_2 + Dx_1 W."""
        series, errors = self._write_on_the_way(tape, 2)
        twice = [_scale_place(tape, _value_of(each[2]), Fraction(2)) for each in series]
        moved = [self._multiply_errors(tape, each[1], errors) for each in series]
        return [_add_places(tape, both) for both in zip(twice, moved, strict=True)]

    def _write_on_the_way(self, tape: Tape, order: int) -> tuple[list[list[Known]], dict[int, int]]:
        """Coefficients of what is on the way, and errors by their columns."""
        series = self._reading.series(order, bool(self._off), tape, ON_THE_WAY).coefficients
        return series, {self._reading.names.index(n): tape.write("given", name=error_name(n)) for n in self._off}

    def _bound_last(self, tape: Tape, coefficients: Sequence[Known], errors: dict[int, int]) -> int | None:
        last = _scale_place(tape, _value_of(coefficients[self._order]), self._seconds**self._order)
        for k in range(self._order):
            factor = self._seconds ** (k + 1) / (k + 1)
            moved = self._multiply_errors(tape, coefficients[k], errors)
            last = _add_places(tape, [last, _scale_place(tape, moved, factor)])
        return last

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
