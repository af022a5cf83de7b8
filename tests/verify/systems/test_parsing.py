"""Expressions of world files: what is read is the whole text, as it is written."""

from fractions import Fraction

import pytest

from codegen.errors import InputError
from tests.support.systems import CART
from verify.decimals import exact
from verify.language.parser import Source, tokens
from verify.language.units import PURE, unit_of
from verify.systems.expressions import affine
from verify.systems.files import statement_of
from verify.systems.parsing import Names, expression_of, half_spaces

NAMES = Names({"x": PURE, "v": PURE, "cart.x": PURE})
ENDS_OF_LINES = "\n\r\v\f\x1c\x1d\x1e\x85\u2028\u2029"  # of str.splitlines
CONTROLS = "".join(map(chr, (*range(32), *range(127, 160)))) + "\u2028\u2029\ufeff\u200b\u00a0\u202e\u3000"


def test_the_ends_of_lines_are_among_the_controls():
    assert set(ENDS_OF_LINES) <= set(CONTROLS)
    assert all(len(f"a{each}b".splitlines()) == 2 for each in ENDS_OF_LINES)


def accepted(read, text):
    try:
        read(text, NAMES, "here")
    except InputError:
        return False
    return True


@pytest.mark.parametrize("text", ["( x +{}  v )", "{}x + v", "x + v{}", "x + 2{}*v", "x + 2{}[s]*v", "si{}n(x)"])
def test_no_control_character_stands_in_an_expression(text):
    for read, end in ((expression_of, ""), (half_spaces, " <= 1")):
        assert [sign for sign in CONTROLS if accepted(read, text.format(sign) + end)] == []


@pytest.mark.parametrize("sign", CONTROLS, ids=lambda sign: f"{ord(sign):04x}")
def test_no_control_character_stands_in_a_file_a_unit_or_a_number(sign):
    escaped = f"\\u{ord(sign):04x}"
    for old, new in (
        ('x = "x + dt*v"', f'x = "( x +{escaped}  dt*v )"'),
        ('place = "x"', f'place = "sign({escaped}x)"'),
        ('a = "push"', f'a = "{escaped}0.5 m/s^2"'),
        ('a = "push"', f'a = "0.5{escaped}m/s^2"'),
        ("range = [-10, 10]", f'range = [-10, "1{escaped}0 m"]'),
        ("range = [-10, 10]", f'range = [-10, "10{escaped}"]'),
        ('unit = "m"', f'unit = "m{escaped}"'),
    ):
        assert CART.count(old) == 1
        with pytest.raises(InputError):
            statement_of(CART.replace(old, new), "f")
    for read in (unit_of, exact):
        with pytest.raises(InputError):
            read(f"1{sign}", "here")


@pytest.mark.parametrize("sign", CONTROLS, ids=lambda sign: f"{ord(sign):04x}")
def test_a_formula_has_spaces_tabs_and_ends_of_lines_only(sign):
    for text in (f"x >={sign} 1", f"{sign}x >= 1", f"x >= 1{sign}", f"'a{sign}b' >= 1"):
        if sign in "\t\n" and "'" not in text:
            assert len(tokens(Source(text, str), 100)) == 4
        else:
            with pytest.raises(InputError):
                tokens(Source(text, str), 100)


@pytest.mark.parametrize("text", ["x # + v", "x + v # of the cart", "x + \\ v", "x + 'v'", 'x + "v"', "#"])
def test_nothing_of_an_expression_is_left_out(text):
    with pytest.raises(InputError, match="cannot read"):
        expression_of(text, NAMES, "here")


@pytest.mark.parametrize(
    ("text", "number"),
    [
        ("0.1", Fraction(1, 10)),
        ("0.1000000000000000055511151231257827", Fraction("0.1000000000000000055511151231257827")),
        ("999999999", Fraction(999999999)),
        ("1_000.5", Fraction(2001, 2)),
        ("( 1.5e-3 )", Fraction(3, 2000)),
        ("7", Fraction(7)),
    ],
)
def test_numbers_are_as_they_are_written(text, number):
    found = affine(expression_of(f"({text})*x", NAMES, "here").value)
    assert found is not None and found.terms == (("x", number),)


@pytest.mark.parametrize("text", ["0x10", "1j", "True", "0b1", "1e400", "..."])
def test_what_is_a_number_for_python_only_is_refused(text):
    with pytest.raises(InputError):
        expression_of(f"x + {text}", NAMES, "here")


# --- a word that is a unit and a name


NAMED_ALIKE = """
steps = 10
[constants]
gain = "2 x"
[variables]
x = { unit = "x", range = [-10, 10] }
[agents.cart]
reward = "1*x"
[agents.cart.features]
place = "x"
[agents.cart.actions]
stay = { a = "1 x/s" }
[start]
box = { x = [-1, 1] }
[dynamics.let]
half = "0.5*gain"
[dynamics.error]
x = "0.25[x]"
[dynamics.next]
x = "0.5*x + 1[s]*cart.a"
"""


def test_brackets_and_products_say_what_a_word_is():
    system = statement_of(NAMED_ALIKE, "f").system
    [piece] = system.pieces
    assert dict(piece.move["x"].terms) == {"x": Fraction(1, 2)}
    assert piece.error["x"] == (Fraction(-1, 4), Fraction(1, 4)) and system.variables[0].range[1] == 10


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("0.5*x + 1[s]*cart.a", "0.5 x"),
        ("0.25[x]", "0.25 x"),
        ("0.5*gain", "0.5 gain"),
        ('"1 x/s"', '"1 x/gain"'),
        ("1*x", "1 x"),
        ("x = [-1, 1]", 'x = [-1, "1 x"]'),
    ],
)
def test_a_quantity_whose_unit_is_a_name_may_be_meant_as_a_product(old, new):
    assert NAMED_ALIKE.count(old) == 1
    with pytest.raises(InputError) as raised:
        statement_of(NAMED_ALIKE.replace(old, new), "f")
    assert "is a unit, and the file has what is named so too" in raised.value.what
    assert "for the unit" in raised.value.next_step and "for a product" in raised.value.next_step
