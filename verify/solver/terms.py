"""The terms that queries to Z3 are made of: exact numbers, unknowns, and tests of sums, each thread's in a context of
its own.

Does: makes terms where the thread that asks keeps them; keeps the tests of sums for its next query.
Assumes: the solver translates a query into a fresh context, so that what a thread asked before leaves no trace.
Does not: know trees, regions or claims.
"""

import threading
from collections.abc import Sequence
from fractions import Fraction
from functools import lru_cache
from typing import TypeAlias

import z3

from verify.solver.halflines import HalfLine

MAX_KNOWN = 1 << 15  # tests that are kept for the next query: the other goals', the control's
Terms = tuple[tuple[float, str], ...]  # a sum: (weight, position) of each part
Real: TypeAlias = z3.ArithRef
Test: TypeAlias = z3.BoolRef


class _Home(threading.local):
    """Where a thread's terms live: Z3 breaks when two threads write into one context, such as its own global one."""

    def __init__(self) -> None:
        self.context = z3.Context()
        z3.Z3_enable_concurrent_dec_ref(self.context.ref())  # Python frees terms in whichever thread collects them
        self.compared = lru_cache(maxsize=MAX_KNOWN)(_compare_terms)


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
    return z3.And(*parts, _home.context)


def disjunction(*parts: Test) -> Test:
    """Some of these, of which there may be none."""
    return z3.Or(*parts, _home.context)


def negation(test: Test) -> Test:
    """That a test does not hold."""
    return z3.Not(test)


def compare_terms(terms: Terms, line: HalfLine) -> tuple[Test, Test]:
    """(the sum of unknowns, each with its weight, lies on the half line, it does not)."""
    return _home.compared(terms, line)


def _compare_terms(terms: Terms, line: HalfLine) -> tuple[Test, Test]:
    measured, end = sum_terms(terms), number(line.end)
    below = measured < end if line.strict else measured <= end
    return below, z3.Not(below)


def sum_terms(terms: Terms) -> Real:
    """The sum of unknowns, each with its weight."""
    return add_terms([_times(weight, unknown(name)) for weight, name in terms])


def add_terms(parts: Sequence[Real]) -> Real:
    """The sum of terms, of which there may be none."""
    return z3.Sum(*parts) if parts else number(Fraction(0))


def _times(weight: float, coordinate: Real) -> Real:
    if abs(weight) == 1:
        return coordinate if weight > 0 else -coordinate
    return number(Fraction(weight)) * coordinate


def either(test: Test, left: Test, right: Test) -> Test:
    """Makes the term of z3.If without its coercions: they take most of the time in which a tree is written."""
    context = test.ctx
    return z3.BoolRef(z3.Z3_mk_ite(context.ref(), test.as_ast(), left.as_ast(), right.as_ast()), context)


def either_number(test: Test, left: Real, right: Real) -> Real:
    """The one number where a test holds, else the other."""
    context = test.ctx
    return Real(z3.Z3_mk_ite(context.ref(), test.as_ast(), left.as_ast(), right.as_ast()), context)


def equal(one: Real, other: Real) -> Test:
    """That two numbers are the same."""
    return conjunction(one <= other, one >= other)


_home = _Home()
