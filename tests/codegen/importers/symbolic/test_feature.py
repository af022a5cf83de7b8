"""Where tests turn: found through steps' own arithmetic, they answer like the steps at every float beside them."""

import math
import operator
from functools import partial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from codegen.importers.symbolic.feature import (
    FALLING,
    FOLDING,
    LAST,
    SIGNS,
    Feature,
    Step,
    Test,
    number,
    place,
    turns_of,
)

ONE = np.float32
STEPS = {
    "nothing": (),
    "times a tenth": (Step("*", partial(operator.mul, 0.1)),),
    "times -3, plus 1": (Step("*", partial(operator.mul, -3.0), FALLING), Step("+", partial(operator.add, 1.0))),
    "abs": (Step("abs", abs, FOLDING),),
    "abs of a shifted number": (Step("-", lambda x: x - 0.3), Step("abs", abs, FOLDING)),
    "from 1, abs of abs minus 2": (
        Step("abs", abs, FOLDING),
        Step("-", lambda x: 2.0 - x, FALLING),
        Step("abs2", abs, FOLDING),
    ),
    "square": (Step("square", lambda x: x * x, FOLDING),),
    "clipped": (Step("max", lambda x: max(x, -0.5)), Step("min", lambda x: min(x, 0.5))),
    "whole": (Step("int", lambda x: int(x) if math.isfinite(x) else x),),
    "so large that most is infinite": (Step("*", partial(operator.mul, 1e308)),),
    "so small that most is 0": (Step("*", partial(operator.mul, 1e-310)),),
    "float32 steps": (Step("f", ONE), Step("*", lambda x: x * ONE(0.1)), Step("+", lambda x: x + ONE(1e-3))),
}
NUMBERS = (0.0, 0.1, -0.1, 0.5, 1.0, -2.0, 1e-320, 3)


@pytest.mark.parametrize("numbers", ["float32", "float64"])
@pytest.mark.parametrize("name", STEPS)
def test_answers_between_turns_are_those_of_the_steps(name, numbers):
    rng = np.random.default_rng(0)
    last = LAST[numbers]
    with np.errstate(all="ignore"):
        for sign in SIGNS:
            for bound in NUMBERS:
                test = Test(Feature(0, STEPS[name]), sign, bound)
                found = turns_of(test, numbers)
                at = [turn.place for turn in found.turns]
                assert at == sorted(set(at))
                asked = {-last, -1, 0, 1, last, *rng.integers(-last, last, 30).tolist()}
                asked |= {each + beside for each in at for beside in (-1, 0, 1, 2)}
                asked |= {place(each, numbers) for each in (0.3, -0.7, 1.0, 2.0, -2.3)}
                for each in asked:
                    value = number(max(-last, min(last, each)), numbers)
                    passed = sum(turn < place(value, numbers) for turn in at)
                    assert (found.first ^ (passed % 2 == 1)) == test.at(value), (sign, bound, value)
                    separated = sum(turn.threshold < value for turn in found.turns)
                    assert separated == passed
                assert found.nan == test.at(math.nan)


def test_a_fault_in_the_sense_of_a_step_is_seen_by_this_test(monkeypatch):
    monkeypatch.setitem(STEPS, "abs", (Step("abs", abs),))
    with pytest.raises(AssertionError):
        test_answers_between_turns_are_those_of_the_steps("abs", "float64")


@given(st.floats(allow_nan=False), st.sampled_from(["float32", "float64"]))
def test_places_count_floats_in_their_order(value, numbers):
    at = place(value, numbers)
    assert number(at, numbers) <= value
    if abs(at) < LAST[numbers]:
        assert number(at + 1, numbers) > value
    assert place(number(at, numbers), numbers) == at


@given(st.integers(-(10**40), 10**40), st.sampled_from(sorted(SIGNS)), st.floats(allow_nan=False))
def test_an_input_is_compared_exactly_with_any_whole_number(bound, sign, other):
    test = Test(Feature(0), sign, bound)
    turns = turns_of(test, "float64")
    for value in (float(bound), math.nextafter(float(bound), -math.inf), math.nextafter(float(bound), math.inf), other):
        passed = sum(turn.threshold < value for turn in turns.turns)
        assert (turns.first ^ (passed % 2 == 1)) == SIGNS[sign](value, bound)
