"""Units: what texts mean the same, and what is no unit."""

import pytest

from codegen.errors import InputError
from verify.language.arithmetic import PURE, format_unit, times, unit_of


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
