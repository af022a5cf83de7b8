"""The grammar of texts, and units."""

import json
from fractions import Fraction
from pathlib import Path

import pytest

from codegen.errors import InputError
from tests.verify.language.vocabularies import READERS, STATED
from verify.claims.formula import holds
from verify.claims.written import formula_of
from verify.language.units import PURE, format_unit, times, unit_of

EXAMPLES = [
    json.loads(line) for line in Path(__file__).with_name("examples.jsonl").read_text(encoding="utf-8").splitlines()
]


def test_texts_mean_what_the_two_readers_before_said():
    """Drawn from 17,000 texts of both grammars from seeds, on which these two and the one reader agreed."""
    kinds = [kind for kind, _, _ in EXAMPLES]
    assert set(kinds) == set(READERS) and min(map(kinds.count, READERS)) >= 80
    for kind, text, meant in EXAMPLES:
        assert READERS[kind](text) == meant, text


def test_conditions_and_expressions_nest_as_deep_as_before():
    plain = READERS["expression"]("x")
    assert READERS["expression"]("(" * 200 + "x" + ")" * 200) == plain
    for text in ("-(" * 149 + "x" + ")" * 149, "x+(" * 149 + "x" + ")" * 149, "sin(" * 149 + "1" + ")" * 149):
        assert READERS["expression"](text)
    for text in ("(" * 201 + "x" + ")" * 201, "-(" * 400 + "x" + ")" * 400, "-" * 151 + "x", "+".join("x" * 151)):
        with pytest.raises(InputError, match="nested deeper"):
            READERS["expression"](text)


# --- units in formulas about stated variables


@pytest.mark.parametrize(
    ("text", "x", "v", "true"),
    [
        ("x + 1[s]*v <= 2", 1, 1, True),
        ("x + 1[s]*v <= 2[m]", 1, 2, False),
        ("|x - 5*dt*v| < 1[m] implies v > 0", 1, 1, True),
        ("max(x, dt*v, 0) == 3 and k*v >= 3", 3, 1, True),
        ("x + v <= 2", 1, 1, True),  # no unit is stated, so these are numbers
        ("2**3*x == 8", 1, 0, True),
    ],
)
def test_formulas_have_units(text, x, v, true):
    state = {"x": Fraction(x), "v": Fraction(v)}
    assert holds(formula_of(text, STATED, str), state, {}) is true


@pytest.mark.parametrize(
    ("kind", "text", "column", "what", "step"),
    [
        ("stated", "x + v <= 2[m]", 3, "units do not fit: m and m/s", "as in 0.1[s]*v"),
        ("stated", "x <= 2[s]", 3, "units do not fit: m and s", "as in 0.1[s]*v"),
        ("stated", "max(x, v) <= 2*dt*v", 1, "units do not fit: m and m/s", "as in 0.1[s]*v"),
        ("stated", "x <= 2[m//s]", 6, "cannot read the unit", "write it as in"),
        ("game", "a.x <= 2[m]", 8, "nothing here has a unit that is known", "only a world file"),
        ("game", "a.x <= ", 7, "too early", "a number, a name"),
        ("game", "a.x 3", 5, "cannot go on with '3'", "an operator may stand here"),
        ("game", "(a.x", 5, "expected ')'", ") may stand here"),
        ("game", "a.x in [left]", 1, "only actions are listed", "write acts(AGENT) in [a, b]"),
        ("game", "acts(a, b) == left", 1, "acts has one agent", "write acts(AGENT) == ACTION"),
        ("game", "distance(a) < 1", 1, "distance needs 2 names", "an entity and then an entity"),
        ("expression", "x + y", 5, "unknown name 'y'", "known:"),
        ("expression", "x + ", 4, "too early", "a number, a name"),
        ("expression", "x <= 3", 1, "not an expression", "write sums"),
        ("expression", "2[m][s]*x", 5, "cannot go on with '['", "an operator may stand here"),
        ("expression", "x // 2", 4, "cannot begin with '/'", "a number, a name"),
        ("condition", "x <= v", 6, "units do not fit", "as in 0.1[s]*v"),
        ("condition", "x", 1, "not a comparison", "compare two sums"),
        ("condition", "x != 2", 3, "not a comparison that a region can have", "a list of regions"),
    ],
)
def test_faults_are_marked_in_the_text(kind, text, column, what, step):
    with pytest.raises(InputError) as raised:
        READERS[kind](text)
    _, line, mark = raised.value.where.split("\n")
    assert what in raised.value.what and line == f"  {text}" and mark == "  " + " " * (column - 1) + "^"
    assert step in raised.value.next_step


def test_long_and_odd_texts_are_cut_and_escaped_where_they_are_shown():
    with pytest.raises(InputError) as raised:
        READERS["game"]("true and\n" + "a.x < 1 or " * 20 + "é" + " or a.x < 1" * 20)
    _, line, mark = raised.value.where.split("\n")
    assert "\\xe9" in line and line[mark.index("^")] == "\\" and len(line) < 140 and line.startswith("  ...")


@pytest.mark.parametrize(
    ("text", "same"),
    [
        ("m/s^2", "m/s/s"),
        ("kg*m/s**2", "m*kg/s^2"),
        ("1/s", "m/s/m"),
        ("rad", "none"),
        ("", "1"),
        ("rad/s", "1/s"),
        ("m*s^-1", "m/s"),
        ("m^0.5*m^0.5", "m"),
        ("m^(1/2)/s", "m^0.5/s"),
        ("N^0.5", "kg^0.5*m^0.5/s"),
        ("m**-0.50", "m^( -1 / 2 )"),
    ],
)
def test_units_that_are_the_same(text, same):
    assert unit_of(text, "") == unit_of(same, "")


@pytest.mark.parametrize("text", ["m s", "m//s", "/s", "2*m", "m^", "m^1.5.2", "m^(1/0)", "m^x", "m^99", "m+s", "*m"])
def test_what_is_no_unit(text):
    with pytest.raises(InputError):
        unit_of(text, "here")


def test_units_multiply_and_are_written():
    speed, time = unit_of("m/s", ""), unit_of("s", "")
    assert format_unit(times(speed, time)) == "m" and format_unit(times(speed, time, -1)) == "m/s^2"
    assert format_unit(PURE) == "1" and format_unit(unit_of("1/s", "")) == "1/s"
    for text, told in (
        ("kg*m/s^2/A", "kg*m/A/s^2"),
        ("m^0.5/s", "m^0.5/s"),
        ("s^-0.25", "1/s^0.25"),
        ("m^(1/3)", "m^(1/3)"),
    ):
        assert format_unit(unit_of(text, "")) == told and unit_of(told, "") == unit_of(text, "")
