"""Values of world files: numbers and their units exactly, and a refusal with its place for all else."""

from fractions import Fraction as F

import pytest

from codegen.errors import InputError, UnknownNameError
from tests.support.systems import CART
from verify.language.arithmetic import unit_of
from verify.systems import values
from verify.systems.files import statement_of
from verify.toml_places import parse

DOCUMENT, PLACE = parse('a = 1\n[table]\nx = "2"\n', "f", "no TOML", "")
NAMES = statement_of(CART, "f").names
METRE = unit_of("m", PLACE)


@pytest.mark.parametrize(
    ("given", "number", "unit"),
    [
        (3, F(3), None),
        ("9.8 m/s^2", F(49, 5), "m/s^2"),
        ("1/3", F(1, 3), None),
        ("-1e-3 m", F(-1, 1000), "m"),
        (".5 kg", F(1, 2), "kg"),
        ("2/4  m", F(1, 2), "m"),
        ("0.1", F(1, 10), None),
    ],
)
def test_a_quantity_is_an_exact_number_and_a_unit(given, number, unit):
    assert values.quantity(given, PLACE) == (number, None if unit is None else unit_of(unit, PLACE))


@pytest.mark.parametrize("given", ["", "m", "1 2", "1//3", "one", "1/0", "inf", "nan", True, None, [1], "1\n m", "--1"])
def test_what_is_no_quantity_is_refused(given):
    with pytest.raises(InputError) as raised:
        values.quantity(given, PLACE / "a")
    assert "f, line 1" in str(raised.value.where)


@pytest.mark.parametrize(
    ("given", "low", "high"),
    [([0, 1], 0, 1), ("2 m", 2, 2), (["-1/2 m", "1/2"], F(-1, 2), F(1, 2)), ([1, 1], 1, 1), (["2*3", "7 m"], 6, 7)],
)
def test_bounds_are_two_numbers_or_one_for_both_in_the_unit(given, low, high):
    assert values.interval(given, METRE, NAMES, PLACE) == (low, high)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ([1, 0], "is above the upper one"),
        ([0, 1, 2], "a list of 3, where 2"),
        (["x", 3], "not a constant"),
        (["1 s", 3], "the unit is s, and m is needed"),
    ],
)
def test_bounds_that_are_none_are_refused(given, said):
    with pytest.raises(InputError, match=said):
        values.interval(given, METRE, NAMES, PLACE)


def test_a_unit_that_is_a_name_too_may_have_been_meant_as_a_product():
    assert values.as_typed("0.5*x", NAMES, PLACE).unit == METRE
    assert values.as_typed("0.5 m", NAMES, PLACE).unit == METRE
    with pytest.raises(InputError, match="is a unit, and the file has what is named so too"):
        values.as_typed("0.5 x", NAMES, PLACE)


@pytest.mark.parametrize(("name", "dotted"), [("x", False), ("a1_b", False), ("cart.a", True), ("A" * 64, False)])
def test_names(name, dotted):
    assert values.as_name(name, PLACE, dotted) == name


@pytest.mark.parametrize("dotted", [False, True])
@pytest.mark.parametrize(
    "name", ["", "1a", "a.b.c", "_x", "lambda", "cart.if", "sin", "A" * 65, "é", "a b", "a.", ".a"]
)
def test_what_is_no_name(name, dotted):
    with pytest.raises(InputError, match="not a name"):
        values.as_name(name, PLACE, dotted)
    with pytest.raises(InputError, match=r"not a name: 'a\.b'"):
        values.as_name("a.b", PLACE)


def test_a_name_with_a_dot_may_be_written_as_two_tables():
    nested = {"cart": {"x": "m", "v": "m/s"}, "pole.angle": "rad", "y": {"unit": "m"}, "z": {"range": [0, 1]}}
    assert values.flat(nested, PLACE) == {
        "cart.x": "m",
        "cart.v": "m/s",
        "pole.angle": "rad",
        "y": {"unit": "m"},
        "z": {"range": [0, 1]},
    }
    with pytest.raises(InputError, match=r"'cart\.x' stands twice"):
        values.flat({"cart": {"x": 1}, "cart.x": 2}, PLACE)


@pytest.mark.parametrize("given", [0, -1, 26, True, "3", 2.0, None])
def test_a_count_is_a_whole_number_from_one(given):
    assert values.count(25, PLACE, 25) == 25 and values.count(1, PLACE, 25) == 1
    with pytest.raises(InputError, match="not a whole number from 1 to 25"):
        values.count(given, PLACE, 25)


def test_kinds_of_values_are_told_apart():
    assert values.table(DOCUMENT, "table", PLACE) == {"x": "2"} and values.table(DOCUMENT, "none", PLACE) == {}
    assert values.as_list([1, 2], PLACE, 2) == [1, 2] and values.text("a b", PLACE) == "a b"
    values.only(DOCUMENT, ("a", "table", "more"), PLACE)
    for refused in (
        lambda: values.table(DOCUMENT, "a", PLACE),
        lambda: values.as_list({"a": 1}, PLACE),
        lambda: values.as_list([1], PLACE, 2),
        lambda: values.text("a\nb", PLACE),
        lambda: values.text(3, PLACE),
    ):
        with pytest.raises(InputError):
            refused()
    with pytest.raises(UnknownNameError, match="did you mean 'table'"):
        values.only({"a": 1, "tabel": 2}, ("a", "table"), PLACE)
