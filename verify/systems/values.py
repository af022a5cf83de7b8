"""Values of a parsed TOML document: tables, texts, counts, names and quantities, or an error that says where.

Does: checks kinds, keys and names; reads numbers with their units.
Assumes: floats were left as the texts that they are.
Does not: know what a world file is about (files.py).
"""

import re
from collections.abc import Collection, Mapping
from fractions import Fraction
from keyword import iskeyword

from codegen.errors import InputError, UnknownNameError, escape_text
from verify.claims.region import Interval
from verify.claims.region_files import is_list, is_table
from verify.decimals import number
from verify.language.units import Typed, Unit, unit_of
from verify.systems.expressions import Expression, Number, affine
from verify.systems.parsing import FUNCTIONS, Names, expression_of, fitting
from verify.toml_places import Place

ADVICE = "`maviper worlds new FILE` writes a file to start from"
NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,63}")
DOTTED = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,63}(\.[A-Za-z][A-Za-z0-9_]{0,63})?")
_QUANTITY = re.compile(r"\s*([-+]?[0-9.][0-9._]*(?:[eE][-+]?[0-9]+)?(?:/[0-9_]+)?)(?:\s+([A-Za-z%1(].*))?\s*")

_WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


def table(document: Mapping[str, object], key: str, where: Place) -> Mapping[str, object]:
    """The table under a key; empty where there is none."""
    return as_table(document.get(key, {}), where / key)


def as_table(value: object, where: Place) -> Mapping[str, object]:
    """A value that must be a table."""
    if not is_table(value):
        raise InputError("not a table", where, ADVICE)
    return value


VALUES = ("unit", "range", "modes")  # keys of a variable's own table


def flat(given: Mapping[str, object], where: Place) -> dict[str, object]:
    """A table whose keys are names of variables: `cart.x` without quotes is TOML's way to nest, and means the same.
    InputError for a name that stands in it both ways.
    """
    flattened: dict[str, object] = {}
    for name, value in given.items():
        nested = is_table(value) and not any(key in value for key in VALUES)
        entries = (
            {name: value} if not nested else {f"{name}.{key}": each for key, each in as_table(value, where).items()}
        )
        for key in entries.keys() & flattened.keys():
            raise InputError(f"'{escape_text(key)}' stands twice in one table", where, "give it once")
        flattened |= entries
    return flattened


def as_list(value: object, where: Place, length: int | None = None) -> list[object]:
    """A value that must be a list, of this length if one is given."""
    if not is_list(value):
        raise InputError("not a list", where, ADVICE)
    if length is not None and len(value) != length:
        raise InputError(f"a list of {len(value)}, where {length} are needed", where, ADVICE)
    return value


def only(given: Mapping[str, object], known: Collection[str], where: Place, kind: str = "key") -> None:
    """UnknownNameError for a key that is none of these."""
    for key in given:
        if key not in known:
            raise UnknownNameError(kind, key, known, where)


def text(value: object, where: Place) -> str:
    """A text of one line."""
    if not isinstance(value, str) or not value.isprintable():
        raise InputError("not a text of one line", where, 'write "..."')
    return value


def count(value: object, where: Place, most: int) -> int:
    """A whole number from 1."""
    if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= most:
        raise InputError(f"not a whole number from 1 to {most}", where, f"write such as {min(25, most)}")
    return value


def as_name(name: str, where: Place, dotted: bool = False) -> str:
    """A name that expressions can hold."""
    plain = (DOTTED if dotted else NAME).fullmatch(name)
    if plain is None or name in FUNCTIONS or any(iskeyword(part) for part in name.split(".")):
        raise InputError(f"not a name: '{escape_text(name)[:60]}'", where, "use letters, digits and _, a letter first")
    return name


def quantity(value: object, where: Place) -> tuple[Fraction, Unit | None]:
    """A number and its unit: 9.8, "1/3" or "9.8 m/s^2"; without a unit None. InputError for what is no number."""
    matched = _QUANTITY.fullmatch(value) if isinstance(value, str) and value.isprintable() else None
    if matched is None or matched[2] is None:
        return number(value, where), None
    return number(matched[1], where), unit_of(matched[2], where)


def as_typed(value: object, names: Names, where: Place) -> Typed[Expression]:
    """A quantity or, of a text that is none, an expression. InputError where a quantity may be meant as a product."""
    infinite = isinstance(value, str) and value.lstrip("+-") in ("inf", "nan")  # of TOML
    stated = _QUANTITY.fullmatch(value) if isinstance(value, str) else None
    if isinstance(value, str) and not infinite and stated is None:
        return expression_of(value, names, where)
    if stated is not None and stated[2] is not None:
        words, written = _WORD.findall(stated[2]), escape_text(stated[2])
        if words and all(word in names.known or word in names.meant for word in words):  # 0.5 x may mean 0.5*x
            what = f"'{written}' is a unit, and the file has what is named so too"
            advice = f"write {stated[1]}[{written}] for the unit, {stated[1]}*{written} for a product"
            raise InputError(what, where, advice)
    exact, unit = quantity(value, where)
    return Typed(Number(exact), unit)


def as_constant(value: object, unit: Unit, names: Names, where: Place) -> Fraction:
    """A number in a unit: a quantity, or an expression of constants."""
    form = affine(fitting(as_typed(value, names, where), unit, where))
    if form is None or form.terms:
        raise InputError("not a constant", where, "name constants only")
    return form.constant


def interval(value: object, unit: Unit, names: Names, where: Place) -> Interval:
    """Bounds `[low, high]`, or one number for both."""
    ends = as_list(value, where, 2) if is_list(value) else [value, value]
    low, high = (as_constant(end, unit, names, where) for end in ends)
    if low > high:
        raise InputError(f"the lower bound {low} is above the upper one {high}", where, "swap them")
    return low, high


def error_of(value: object, unit: Unit, names: Names, where: Place) -> Interval:
    """Reads by how much something may be off: a number e for [-e, e], or an interval."""
    low, high = interval(value, unit, names, where)
    if is_list(value):
        return low, high
    if high < 0:
        raise InputError(f"the error {high} is below 0", where, "write e for [-e, e], or [low, high]")
    return -high, high
