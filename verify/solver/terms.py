"""The terms that queries to Z3 are made of: exact numbers, unknowns, and tests of sums as half lines.

Does: makes terms where the thread that asks keeps them, each in a context of its own; keeps the tests of sums for its
  next query; gives the exact end of the differences, or coordinates, that a threshold lets go left.
Assumes: the solver translates a query into a fresh context, so that what a thread asked before leaves no trace;
  thresholds are numbers of the type that their agent compares, float32 or float64.
Does not: know trees, regions or claims; share the arithmetic of thresholds with codegen or with any other engine, so
  that consensus means something.

Machine rounding: a difference d of two float64 positions is observed as fl32(fl64(d)), or as fl64(d) by an agent that
compares float64. Rounding is monotone, so "fl32(fl64(d)) <= t" is a half line of d. Its end is where the second
rounding ties, then where the first one does; a tie belongs to it iff the lower neighbour has an even significand.
Replacing the threshold by that end makes the question over the reals the machine's own question.
"""

import ctypes
import math
import struct
import threading
from collections.abc import Sequence
from fractions import Fraction
from functools import lru_cache
from typing import NamedTuple, TypeAlias

import z3

MAX_KNOWN = 1 << 15  # thresholds, and tests, that are kept for the next query: the other goals', the control's


class HalfLine(NamedTuple):
    """All d with d <= end, or d < end when `strict`."""

    end: Fraction
    strict: bool


class _Format(NamedTuple):
    code: str  # struct codes of the float and of the integer with the same bits
    bits: str
    overflow: Fraction  # what the next value after the largest finite one would be


_SINGLE = _Format("<f", "<i", Fraction(2) ** 128)
_DOUBLE = _Format("<d", "<q", Fraction(2) ** 1024)


def _rank(value: float, form: _Format) -> int:
    """Position of a float in the order of its format: 0 for 0.0, neighbours differ by one."""
    (bits,) = struct.unpack(form.bits, struct.pack(form.code, value))
    return bits if bits >= 0 else -(bits & (2 ** (8 * struct.calcsize(form.code) - 1) - 1))


def _value(rank: int, form: _Format) -> float | Fraction:
    """The float at a position, exactly; one past the largest finite float stands for the value that would follow."""
    (value,) = struct.unpack(form.code, struct.pack(form.bits, abs(rank)))
    exact = form.overflow if value == math.inf else value
    return exact if rank >= 0 else -exact


def _round_at_most(rank: int, form: _Format) -> HalfLine:
    """All real numbers that round to a float not above the one at `rank`, ties to even."""
    (low, of_low), (high, of_high) = (_value(place, form).as_integer_ratio() for place in (rank, rank + 1))
    return HalfLine(Fraction(low * of_high + high * of_low, 2 * of_low * of_high), strict=rank % 2 != 0)


@lru_cache(maxsize=MAX_KNOWN)
def half_line(threshold: float, single: bool) -> HalfLine:
    """The differences d with fl32(fl64(d)) <= `threshold` (a float32); unless `single`, with fl64(d) <= `threshold`."""
    if not single:
        return _round_at_most(_rank(threshold, _DOUBLE), _DOUBLE)
    last = _round_at_most(_rank(threshold, _SINGLE), _SINGLE)
    # midpoints of neighbouring float32 values are float64 values
    rank = _rank(float(last.end), _DOUBLE) - (1 if last.strict else 0)
    return _round_at_most(rank, _DOUBLE)


def last_double(threshold: float, single: bool) -> HalfLine:
    """The float64 values z with fl32(z) <= `threshold`: for a feature that is one coordinate, rounded once. Unless
    `single`, it is not rounded.
    """
    if not single:
        return HalfLine(Fraction(threshold), strict=False)
    return _round_at_most(_rank(threshold, _SINGLE), _SINGLE)


Terms = tuple[tuple[float, str], ...]  # a sum: (weight, position) of each part
Real: TypeAlias = z3.ArithRef
Test: TypeAlias = z3.BoolRef
_PAIR = z3.Ast * 2


class _Home(threading.local):
    """Where a thread's terms live: Z3 breaks when two threads write into one context, such as its own global one.

    Terms are made by Z3's own functions: what z3's operators look up of every argument takes most of the time in which
    a tree is written.
    """

    def __init__(self) -> None:
        self.context = z3.Context()
        z3.Z3_enable_concurrent_dec_ref(self.context.ref())  # Python frees terms in whichever thread collects them
        self.compared = lru_cache(maxsize=MAX_KNOWN)(_compare_terms)
        self.totalled = lru_cache(maxsize=MAX_KNOWN)(_sum_terms)


def number(value: Fraction) -> Real:
    """An exact rational constant."""
    return z3.RealVal(f"{value.numerator}/{value.denominator}", _home.context)


def unknown(name: str) -> Real:
    """A real number that is not known; equal names are equal numbers."""
    return z3.Real(name, _home.context)


def constant(value: bool) -> Test:
    """True or false."""
    return z3.BoolVal(value, _home.context)


def conjunction(*parts: Test) -> Test:
    """All of these, of which there may be none."""
    return Test(z3.Z3_mk_and(*_listed(parts)), _home.context)


def disjunction(*parts: Test) -> Test:
    """Some of these, of which there may be none."""
    return Test(z3.Z3_mk_or(*_listed(parts)), _home.context)


def _listed(parts: Sequence[z3.ExprRef]) -> tuple["z3.ContextHandle", int, "ctypes.Array[z3.Ast]"]:
    """Parts as Z3 takes them."""
    return _home.context.ref(), len(parts), (z3.Ast * len(parts))(*[part.as_ast() for part in parts])


def negation(test: Test) -> Test:
    """That a test does not hold."""
    return Test(z3.Z3_mk_not(test.ctx.ref(), test.as_ast()), test.ctx)


def less_than(one: Real, bound: Real) -> Test:
    """That a number is less than a bound. The bound stands first, here and below: the models that Z3 finds, and so
    counterexamples, hang on the order.
    """
    return Test(z3.Z3_mk_gt(one.ctx.ref(), bound.as_ast(), one.as_ast()), one.ctx)


def at_most(one: Real, bound: Real) -> Test:
    """That a number is not greater than a bound."""
    return Test(z3.Z3_mk_ge(one.ctx.ref(), bound.as_ast(), one.as_ast()), one.ctx)


def at_least(one: Real, bound: Real) -> Test:
    """That a number is not less than a bound."""
    return Test(z3.Z3_mk_le(one.ctx.ref(), bound.as_ast(), one.as_ast()), one.ctx)


def compare_terms(terms: Terms, line: HalfLine) -> tuple[Test, Test]:
    """(the sum of unknowns, each with its weight, lies on the half line, it does not)."""
    return _home.compared(terms, line)


def _compare_terms(terms: Terms, line: HalfLine) -> tuple[Test, Test]:
    return on_line(sum_terms(terms), line)


def on_line(measured: Real, line: HalfLine) -> tuple[Test, Test]:
    """(a number lies on the half line, it does not)."""
    within = (less_than if line.strict else at_most)(measured, number(line.end))
    return within, negation(within)


def sum_terms(terms: Terms) -> Real:
    """The sum of unknowns, each with its weight."""
    return _home.totalled(terms)


def _sum_terms(terms: Terms) -> Real:
    return add_terms([_times(weight, unknown(name)) for weight, name in terms])


def add_terms(parts: Sequence[Real]) -> Real:
    """The sum of terms, of which there may be none."""
    return Real(z3.Z3_mk_add(*_listed(parts)), _home.context) if parts else number(Fraction(0))


def _times(weight: float, coordinate: Real) -> Real:
    if abs(weight) == 1:
        return coordinate if weight > 0 else -coordinate
    return number(Fraction(weight)) * coordinate


def either(test: Test, left: Test, right: Test) -> Test:
    """The one test where a test holds, else the other."""
    return Test(z3.Z3_mk_ite(test.ctx.ref(), test.as_ast(), left.as_ast(), right.as_ast()), test.ctx)


def branch(below: Test, left: Test, above: Test, right: Test) -> Test:
    """Both of the first two, or both of the others. The two conjunctions are Z3's alone, and no terms of Python."""
    context = _home.context.ref()
    both: list[z3.Ast] = []
    for one, other in ((below, left), (above, right)):
        both.append(z3.Z3_mk_and(context, 2, _PAIR(one.as_ast(), other.as_ast())))
        z3.Z3_inc_ref(context, both[-1])
    made = Test(z3.Z3_mk_or(context, 2, _PAIR(*both)), _home.context)
    for each in both:
        z3.Z3_dec_ref(context, each)
    return made


def either_number(test: Test, left: Real, right: Real) -> Real:
    """The one number where a test holds, else the other."""
    return Real(z3.Z3_mk_ite(test.ctx.ref(), test.as_ast(), left.as_ast(), right.as_ast()), test.ctx)


def equal(one: Real, other: Real) -> Test:
    """That two numbers are the same."""
    return conjunction(one <= other, one >= other)


_home = _Home()
