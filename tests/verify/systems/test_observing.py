"""What agents observe: the exact value, rounded once."""

from dataclasses import replace
from fractions import Fraction as F

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from codegen.floats import NUMBERS
from codegen.numbers import nearest_single
from tests.support.system_cases import policy, team
from verify.checker.systems.reading import goes_left
from verify.claims.formula import holds
from verify.systems.observing import choose_actions, measure_feature
from verify.systems.system import Affine, Feature, Measure, System, Variable

FORM = Affine.of({"x": F(1), "y": F(-2)}, F(1, 2))


NUMBER = st.fractions(-1000, 1000) | st.floats(-(2.0**90), 2.0**90, width=32).map(F)


@given(NUMBER, st.integers(-3, 3), st.integers(25, 120))
def test_nothing_is_nearer(number, off, bits):
    """Numbers beside float32 numbers and their midpoints, against their neighbours by exact distances."""
    exact = number + F(off, 2**bits)
    found = nearest_single(exact)
    distance = abs(F(float(found)) - exact)
    for towards in (-np.inf, np.inf):
        beside = np.nextafter(found, np.float32(towards))
        other = abs(F(float(beside)) - exact)
        even = not int(np.frombuffer(found.tobytes(), np.uint32)[0]) & 1
        assert distance < other or (distance == other and even)


@pytest.mark.parametrize("sign", [-1, 1])
def test_a_number_just_beside_a_tie(sign):
    """The nearest double is the tie itself, and would round to the even neighbour."""
    tie = F(1) + F(1, 2**24)
    assert nearest_single(tie) == 1
    assert nearest_single(tie + F(sign, 2**90)) == (1 if sign < 0 else np.nextafter(np.float32(1), np.float32(2)))


def test_measures():
    state = {"x": F(1), "y": F(1)}
    assert measure_feature(Feature(FORM), state) == F(-1, 2)
    assert measure_feature(Feature(FORM, Measure.SIGN), state) == -1
    assert measure_feature(Feature(FORM, Measure.SIGN), {"x": F(3, 2), "y": F(1)}) == 0
    assert measure_feature(Feature(FORM, Measure.POSITIVE), state) == 0
    assert measure_feature(Feature(FORM, Measure.EQUALS), state) == 0
    assert measure_feature(Feature(FORM, Measure.EQUALS), {"x": F(3, 2), "y": F(1)}) == 1
    assert measure_feature(Feature(FORM, Measure.CLIP, (F(-1, 4), F(1))), state) == F(-1, 4)
    assert nearest_single(measure_feature(Feature(FORM), {"x": F(1, 10), "y": F(0)})) == np.float32(0.6)


@pytest.mark.parametrize("numbers", NUMBERS)
@pytest.mark.parametrize("threshold", [0.1, -0.1, 1.0, 1e-3])
def test_a_test_goes_left_where_the_rounded_number_does(numbers, threshold):
    """The checker's inequality against what the referee observes, at the tie beside a threshold and next to it."""
    here = np.dtype(numbers).type(threshold)
    after = np.nextafter(here, here.dtype.type(np.inf))
    tie = (F(float(here)) + F(float(after))) / 2
    nested = ((0, 0.0), 0, 1)
    found = policy("a", ["f"], ["go", "rest"], nested)
    tree = replace(found.tree, threshold=np.array([here, 0, 0], numbers), numbers=numbers)
    profile = team(replace(found, tree=tree))
    feature = Feature(Affine.of({"x": F(1)}))
    system = System("line", (Variable("x", "1", (F(-2), F(2))),), {"a": {"f": feature}}, ())
    for x in (F(float(here)), tie - F(1, 2**200), tie, tie + F(1, 2**200), F(float(after))):
        left = holds(goes_left(feature, float(here), numbers), {"x": x}, {})
        assert left == (choose_actions(system, profile, {"x": x})["a"] == 0)
