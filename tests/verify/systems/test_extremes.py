"""abs, max and min in rules: their values, the enclosures that the checker shows again, and what is refused."""

from fractions import Fraction as F

import numpy as np
import pytest

from codegen.errors import InputError
from verify.checker.systems.enclosures import ensure_enclosed
from verify.language.units import PURE, unit_of
from verify.systems.expressions import Number
from verify.systems.files import statement_of
from verify.systems.observing import function
from verify.systems.parsing import Names, expression_of

NAMES = Names({"x": PURE, "y": PURE, "v": unit_of("m", "")})
CASES = {
    "abs(x)": lambda x, y: abs(x),
    "|x - y|": lambda x, y: abs(x - y),
    "max(x, y)": max,
    "min(x, y)": min,
    "abs(x) - 2*abs(y)": lambda x, y: abs(x) - 2 * abs(y),
    "max(x, 0.5) + min(y, 0.25)": lambda x, y: max(x, F(1, 2)) + min(y, F(1, 4)),
}


@pytest.mark.parametrize("text", CASES)
def test_values_are_those_of_python(text):
    read = expression_of(text, NAMES, "here").value
    for x, y in [*np.random.default_rng(0).uniform(-2, 2, (200, 2)).tolist(), [0.0, 0.0], [0.5, 0.5], [-1.0, 1.0]]:
        assert abs(function(read)({"x": x, "y": y}) - CASES[text](x, y)) < 1e-12


@pytest.mark.parametrize("text", CASES)
def test_pieces_hold_the_values_and_the_checker_shows_it(text):
    source = f"""
name = "bent"
steps = 2
[variables]
x = {{ range = [-2, 2] }}
y = {{ range = [-2, 2] }}
[agents.a.features]
x = "x"
[agents.a.actions]
go = {{}}
[start]
box = {{ x = [0, 1], y = 0 }}
[dynamics.next]
x = "({text})/4"
y = "y"
[dynamics.cuts]
x = 2
y = 2
"""
    statement = statement_of(source, "bent.toml")
    assert ensure_enclosed(statement) > 0
    for x, y in np.random.default_rng(1).uniform(-2, 2, (100, 2)).tolist():
        state = {"x": F(x), "y": F(y)}
        (piece, *_) = (each for each in statement.system.pieces if each.holds(state))
        exact, (low, high) = F(CASES[text](F(x), F(y))) / 4, piece.error.get("x", (F(0), F(0)))
        assert low <= exact - piece.step(state, {"a": "go"}, {})["x"] <= high


def test_constants_are_numbers_and_units_have_to_fit():
    assert expression_of("max(1/3, 0.25)", Names({}), "here").value is not None
    assert function(expression_of("min(abs(-2), 3)", Names({}), "here").value)({}) == 2
    assert isinstance(expression_of("2", Names({}), "here").value, Number)
    for text, words in (("max(x, v)", "units do not fit"), ("abs(x, y)", "abs has other"), ("min(x)", "min has other")):
        with pytest.raises(InputError, match=words):
            expression_of(text, NAMES, "here")


@pytest.mark.parametrize(
    ("one", "other"),
    [("N", "kg*m/s^2"), ("J", "N*m"), ("W", "J/s"), ("Pa", "N/m^2"), ("Hz", "1/s"), ("N^2/Pa", "N*m^2"), ("kW", "kW")],
)
def test_derived_units_are_what_they_stand_for(one, other):
    assert unit_of(one, "") == unit_of(other, "")
    assert unit_of("kW", "") != unit_of("W", "")
