"""The functions of Python, math and numpy that are read, by their names.

Does: tables of names; functions that make, take apart and count lists, or make arrays.
Assumes: numbers.py has the functions of numbers.
Does not: compute with features itself.
"""

# pyright: basic
# the values of a program may be anything
import ast
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from codegen.importers.python import numbers
from codegen.importers.python.arithmetic import CONDITIONS, binary, is_constant, is_number
from codegen.importers.python.machine import MAX_ITEMS, Machine, words_of
from codegen.importers.python.numbers import STEPS, Call, Given, Named, conversion
from codegen.importers.python.values import AUTO, Array, Bound, Condition, Factory, Length, Module, Part, Stream, Symbol
from codegen.importers.symbolic.feature import Feature, Step

# --- lists


def make_list_call(make: Callable[..., Any]) -> Call:
    """list, tuple, enumerate, zip and so on, as Python makes them."""

    def handle_call(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
        items = [each if isinstance(each, int) else m.items(each) for each in given]
        try:
            sequence = make(*items, **named)
        except (TypeError, ValueError):
            raise m.make_error(node, "a list is made of what it cannot be made of", "write the list itself") from None
        if isinstance(sequence, set) and not is_constant(sequence):
            raise m.make_error(node, "a set is made of what is no constant", "write a list")
        return m.keep_value(sequence) if isinstance(sequence, list | dict | set | tuple) else Stream(list(sequence))

    return handle_call


def _make_set(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    """`set` and `frozenset`, also of a set, whose order is no matter here."""
    return m.keep_value({*given[0]}) if given and isinstance(given[0], set) else make_list_call(set)(m, node, given, {})


def _length(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    """`len`: of an observation, what the file says of it."""
    if isinstance(given[0], Part):
        return m.inputs.length(given[0].path) or Length(given[0])
    if isinstance(given[0], Stream):
        raise m.make_error(node, "an iterator is counted", "count a list")
    return len(given[0]) if isinstance(given[0], set) else len(m.items(given[0]))


def _sum(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    """`sum` of whole numbers and conditions, one after the other. Of floats, newer versions of Python add otherwise."""
    total = given[1] if len(given) > 1 else 0
    for each in m.items(given[0]):
        total = binary(m, ast.Add, total, each)
        if not isinstance(total, int) and not (isinstance(total, Feature) and m.counts(total)):
            raise m.make_error(node, "sum() adds floats, which versions of Python do differently", "write a + b + c")
    return total


def _next(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    """`next` of a generator expression."""
    if not isinstance(given[0], Stream):
        raise m.make_error(node, "next() is not given a generator expression", "write next(a for a in ...)")
    for each in given[0].items:
        return each
    if len(given) < 2:
        raise m.make_error(node, "next() finds nothing", "give a default")
    return given[1]


def _sort_items(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    """`sorted`, of constants."""
    items, reverse = list(m.items(given[0])), named.pop("reverse", False)
    if named or not is_constant(items) or not isinstance(reverse, bool):
        what = "something is sorted by what is no constant"
        raise m.make_error(node, what, "write the order itself, and test what decides it")
    return m.keep_value(sorted(items, reverse=reverse))


def _range(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    """`range`, of constants."""
    whole = [m.whole(each) for each in given]
    if not all(isinstance(each, int) for each in whole) or len(range(*whole)) > MAX_ITEMS:
        raise m.make_error(node, "a range is no range of constants, or too long", "write range(n)")
    return range(*whole)


def _bool(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    return Condition(True, (given[0],), plain=True) if isinstance(given[0], CONDITIONS) else m.truth(given[0])


def _every(function: Callable[[Iterable[Any]], bool]) -> Call:
    def handle_call(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
        return function(m.truth(each) for each in m.items(*given))

    return handle_call


# --- arrays


def _make_array(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    """np.array and np.asarray: of the observation, or of a list of numbers."""
    value, kind = given[0], named.get("dtype", given[1] if len(given) > 1 else None)
    if named.keys() - {"dtype"} or not isinstance(value, Part | list | tuple):
        what = f"an array is made of {words_of(value)}"
        raise m.make_error(node, what, "give the observation, or a list of numbers")
    steps = () if kind is None else conversion(m, kind)
    if isinstance(value, Part):
        if kind is None and not value.array:
            steps = (Step(m.kind or "float64", np.dtype(m.kind or "float64").type),)
        return replace(value, steps=value.steps + steps, array=True)
    if any(isinstance(each, list | tuple) for each in value):
        raise m.make_error(node, "an array of several dimensions is made", "write lists of lists")
    parts = [m.decide(each) for each in value]
    if all(map(is_number, parts)):
        return m.keep_value(Array(_convert_constants(m, parts, steps)))
    if steps or not all(isinstance(each, Feature | int | float | np.number) for each in parts):
        what = "an array of features is made of a type, or with what is no number"
        raise m.make_error(node, what, "give the list itself")
    return m.keep_value(Array(np.float64(each) if isinstance(each, float) else each for each in parts))


def _convert_constants(m: Machine, parts: Given, steps: tuple[Step, ...]) -> list[Any]:
    """Constants as the scalars of an array."""
    if steps and steps[0].key != "float64":
        what = "constants are made numbers of float32, which floats and arrays meet differently"
        raise m.make_error(None, what, "write the numbers themselves")
    return [*np.array(parts, dtype=np.float64 if steps else None)]


def _find_best(largest: bool) -> Call:
    """np.argmax and np.argmin of constants."""

    def handle_call(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
        items = [*m.items(given[0])]
        if not items or not all(map(is_number, items)):
            what = "the largest of several features is asked"
            raise m.make_error(node, what, "compare each feature with a number")
        return items.index((max if largest else min)(items))

    return handle_call


def _refuse_product(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    """left @ right, which NumPy adds in an order of its own"""
    return binary(m, ast.MatMult, *given[:2])


def _field(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    """`dataclasses.field`."""
    if len(named) != 1 or not named.keys() <= {"default", "default_factory"}:
        raise m.make_error(node, "a field is not understood", "give its default, or its default_factory")
    return named["default"] if "default" in named else Factory(named["default_factory"])


# --- the tables


def _bounds(names: Mapping[str, Call | Any], module: str) -> dict[str, Any]:
    return {name: Bound(f"{module}{name}", call) if callable(call) else call for name, call in names.items()}


def _steps(module: str) -> dict[str, Call]:
    """The functions of one number that a module has."""
    return {name.rpartition(".")[2]: numbers.make_step(name) for name in STEPS if name.rpartition(".")[0] == module}


BUILTINS: dict[str, Any] = _bounds(
    {
        **_steps(""),
        "min": numbers.extreme(True, True),
        "max": numbers.extreme(False, True),
        "bool": _bool,
        "len": _length,
        "sum": _sum,
        "any": _every(any),
        "all": _every(all),
        "range": _range,
        "sorted": _sort_items,
        "list": make_list_call(lambda each=(): list(each)),
        "tuple": make_list_call(lambda each=(): tuple(each)),
        "set": _make_set,
        "frozenset": _make_set,
        "dict": make_list_call(lambda **named: named),
        "next": _next,
        "enumerate": make_list_call(enumerate),
        "zip": make_list_call(zip),
        "reversed": make_list_call(lambda each: iter(list(each)[::-1])),
        "print": lambda m, node, given, named: None,
    },
    "",
)
_MATH = ("sqrt", "exp", "log", "log2", "log10", "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "hypot", "pow")
_NUMPY = ("sqrt", "exp", "log", "sin", "cos", "tan", "arctan", "arctan2", "hypot")


def _module(name: str, names: Mapping[str, Call | Any]) -> Module:
    return Module(name, _bounds(names, f"{name}."))


_KNOWN = (
    _module(
        "math",
        {
            **{name: numbers.make_constant_call(getattr(math, name)) for name in _MATH},
            **_steps("math"),
            **{name: getattr(math, name) for name in ("pi", "e", "tau", "inf", "nan")},
            "isnan": numbers.isnan(False),
            "isfinite": numbers.isnan(True),
        },
    ),
    _module(
        "numpy",
        {
            **{name: numbers.make_constant_call(getattr(np, name)) for name in _NUMPY},
            **_steps("numpy"),
            **{name: getattr(np, name) for name in ("pi", "e", "inf", "nan")},
            "ndarray": Symbol("numpy.ndarray"),
            **dict.fromkeys(("array", "asarray"), _make_array),
            "minimum": numbers.extreme(True, False),
            "maximum": numbers.extreme(False, False),
            "clip": numbers.clip,
            "linspace": numbers.make_spacing,
            "sign": numbers.sign,
            "digitize": numbers.make_binning(None),
            "isnan": numbers.isnan(False),
            "isfinite": numbers.isnan(True),
            "argmax": _find_best(True),
            "argmin": _find_best(False),
            **dict.fromkeys(("dot", "matmul", "inner", "vdot"), _refuse_product),
        },
    ),
    _module(
        "bisect",
        {
            **dict.fromkeys(("bisect", "bisect_right"), numbers.make_binning(True)),
            "bisect_left": numbers.make_binning(False),
        },
    ),
    Module("enum", {"auto": Bound("auto", lambda m, node, given, named: AUTO)}),
    Module("dataclasses", {"field": Bound("field", _field)}),
    Module("typing", {"TYPE_CHECKING": False}),
)
MODULES: Mapping[str, Module] = {each.name: each for each in _KNOWN}
