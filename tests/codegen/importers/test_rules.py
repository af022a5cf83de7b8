"""Tests as splits: for every number and every float32 beside it, x <= t says what the comparison says."""

import operator
import sys
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from codegen.errors import InputError
from codegen.floats import neighbour
from codegen.importers import rules

SIGNS = {"<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge, "==": operator.eq, "!=": operator.ne}
NUMBERS = st.one_of(
    st.integers(-(10**40), 10**40),
    st.floats(allow_nan=False, allow_infinity=False),
    st.floats(width=32, allow_nan=False, allow_infinity=False),
)


def holds(condition, x):
    """Whether a condition holds for the value x of its only feature."""
    if isinstance(condition, rules.AtMost):
        return x <= condition.threshold
    if isinstance(condition, rules.Not):
        return not holds(condition.part, x)
    if isinstance(condition, rules.Joined):
        return (all if condition.every else any)(holds(part, x) for part in condition.parts)
    return condition


@given(NUMBERS, st.sampled_from(sorted(SIGNS)), st.floats(width=32, allow_nan=False))
def test_every_comparison_becomes_one_with_a_double(number, sign, other):
    with np.errstate(over="ignore"):
        near = np.float64(min(max(number, -1e300), 1e300)).astype(np.float32)
    found = rules.compared(0, sign, number)
    for x in (near, neighbour(near, -np.inf), neighbour(near, np.inf), np.float32(other)):
        assert holds(found, float(x)) == SIGNS[sign](float(x), number)


@given(NUMBERS)
@example(-sys.float_info.max)  # no double lies below it
@example(sys.float_info.max)
def test_the_doubles_around_a_number(number):
    at, under = rules.at_most(number), rules.below(number)
    assert Fraction(at) <= Fraction(number) and (under == -np.inf or Fraction(under) < Fraction(number))
    for each, strict in ((at, False), (under, True)):
        with np.errstate(over="ignore"):
            above = float(np.nextafter(each, np.inf))  # Python's own compares exactly with an int
        assert np.isinf(above) or (above >= number if strict else above > number)


def test_a_tree_and_its_values():
    test = rules.If(rules.compared(1, ">", 2), (rules.Return("go", "", 1),), (rules.Return("stay", "", 2),), 1)
    found = rules.program((test,), "here")
    assert found.tree.feature.tolist() == [1, -1, -1] and found.tree.threshold[0] == 2.0
    assert found.values == ("stay", "go") and not found.nan


def test_decided_tests_are_left_out():
    inner = rules.If(rules.compared(0, "<", 5), (rules.Return(1, "", 1),), (), 1)
    outer = rules.If(rules.compared(0, "<", 2), (inner,), (rules.Return(2, "", 1),), 1)
    assert len(rules.program((outer,), "here").tree.feature) == 3


def test_too_many_steps_are_refused(monkeypatch):
    monkeypatch.setattr(rules, "MAX_STEPS", 5)
    steps = (*(rules.Set("a", 1) for _ in range(5)), rules.Return(None, "a", 1))
    with pytest.raises(InputError, match="too many paths"):
        rules.program(steps, "here")
