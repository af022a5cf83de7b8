"""The functions of Python, math and numpy that are read, by their names.

Does: steps of a feature, and Python's own result for a constant; the least and the largest; functions that make, take
  apart and count lists, or make arrays.
Assumes: functions that keep or turn the order of floats, or fold it at 0.
Does not: take functions whose rounding nobody promises, such as exp or sin, of a feature.
"""

# pyright: basic
# the values of a program may be anything
import ast
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from codegen.importers.python.arithmetic import (
    CONDITIONS,
    apply_finite,
    binary,
    convert_feature,
    is_constant,
    is_number,
)
from codegen.importers.python.machine import MAX_ITEMS, TEST_ADVICE, Machine, step_of
from codegen.importers.python.values import (
    AUTO,
    Array,
    Bound,
    Class,
    Condition,
    Extreme,
    Factory,
    Module,
    Part,
    Refused,
    Stream,
    Symbol,
    words_of,
)
from codegen.importers.symbolic.feature import FOLDING, RISING, Feature, Step

Given = list[Any]
Named = dict[str, Any]
Call = Callable[[Machine, ast.AST, Given, Named], Any]
UNKNOWN = "write what it computes with comparisons and numbers"
TYPES = {"float": "float64", "float64": "float64", "double": "float64", "float32": "float32", "single": "float32"}
WHOLE: Mapping[str, Callable[..., Any]] = {  # of finite numbers only
    "int": int, "math.floor": math.floor, "math.ceil": math.ceil, "math.trunc": math.trunc, "round": round,
}  # fmt: skip
STEPS: Mapping[str, tuple[Callable[[Any], Any], str]] = {  # of a feature
    "abs": (abs, FOLDING), "math.fabs": (math.fabs, FOLDING), "numpy.abs": (np.abs, FOLDING),
    "numpy.absolute": (np.abs, FOLDING), "numpy.fabs": (np.fabs, FOLDING), "float": (float, RISING),
    "numpy.float64": (np.float64, RISING), "numpy.float32": (np.float32, RISING), "numpy.double": (np.float64, RISING),
    "numpy.floor": (np.floor, RISING), "numpy.ceil": (np.ceil, RISING), "numpy.rint": (np.rint, RISING),
    "math.radians": (math.radians, RISING), "math.degrees": (math.degrees, RISING),
    "numpy.deg2rad": (np.deg2rad, RISING), "numpy.radians": (np.radians, RISING),
    "numpy.rad2deg": (np.rad2deg, RISING), "numpy.degrees": (np.degrees, RISING),
    **{name: (partial(apply_finite, function), RISING) for name, function in WHOLE.items()},
}  # fmt: skip


def make_step(name: str) -> Call:
    """A function of one number."""
    apply, sense = STEPS[name]
    plain = WHOLE.get(name, apply)

    def handle_call(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
        counts = name in ("int", "float")  # which make the same number of a condition among floats and arrays
        given = [m.truth(each) if counts and isinstance(each, CONDITIONS) else m.decide(each) for each in given]
        if given and isinstance(given[0], Extreme) and sense == RISING:
            parts = tuple(handle_call(m, node, [each, *given[1:]], named) for each in given[0].parts)
            return Extreme(given[0].least, parts)
        if not given or not isinstance(given[0], Feature):
            if name == "numpy.float32":
                raise Refused("a constant is made a number of float32", "write the number itself")
            return constant(plain, given, named)
        m.finite |= name in WHOLE
        if len(given) == 1 and not named:
            return convert_feature(m, given[0]).then(Step(name, apply, sense))
        if name != "round" or named or not isinstance(given[1], int):
            raise Refused(f"{name} with further arguments is not understood", UNKNOWN)
        m.ask_arrays("a feature is rounded to digits")
        if isinstance(convert_feature(m, given[0]).value(1.0), np.generic):
            what = "a number of NumPy is rounded to digits, by a way of its own"
            raise Refused(what, "compare it with the middle between two of these numbers")
        return given[0].then(Step(f"round{given[1]}", partial(_round, given[1])))

    return handle_call


def _round(digits: int, value: Any) -> Any:
    return apply_finite(lambda each: round(each, digits), value)


def conversion(kind: Any) -> tuple[Step, ...]:
    """The steps of a conversion to a type of NumPy, given as the type, or by its name."""
    name = (kind if isinstance(kind, str) else getattr(kind, "name", "")).rpartition(".")[2]
    if name not in TYPES:
        what = "numbers are converted to a type that is neither float32 nor float64"
        raise Refused(what, "convert to float32 or float64; int(x[0]) of each number")
    return step_of(TYPES[name])


def constant(function: Callable[..., Any], given: Given, named: Named) -> Any:
    """A function of constants, computed by Python itself."""
    if not is_constant(given) or not is_constant(named) or any(isinstance(each, list | tuple | dict) for each in given):
        raise Refused(f"a function is given {', '.join(map(words_of, given))}", UNKNOWN)
    if any(isinstance(each, str) and len(each) > 400 for each in given):
        raise Refused("a text is too long", "make it shorter")
    return function(*given, **named)


def make_constant_call(function: Callable[..., Any]) -> Call:
    """A function of constants only."""

    def handle_call(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
        given = [m.decide(each) for each in given]
        if any(isinstance(each, Feature | Extreme) for each in given):
            name = getattr(function, "__name__", "a function")
            raise Refused(f"{name} of a feature is not understood", "compare the feature itself")
        return constant(function, given, named)

    return handle_call


# --- the least and the largest


def extreme(least: bool, builtin: bool) -> Call:
    """min, max and their like in numpy."""
    function: Any = (min if least else max) if builtin else np.minimum if least else np.maximum

    def handle_call(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
        items = [*m.items(given[0])] if len(given) == 1 else given
        if named or not items or (not builtin and len(given) != 2):
            raise Refused("the least or largest of nothing, or of what is not understood", UNKNOWN)
        parts = [m.decide(each) for each in items]
        if not all(isinstance(each, Feature | Extreme) for each in parts):
            parts = _join_constants(m, function, parts, items)
        if len(parts) == 1:
            return parts[0]
        flat = [each.parts if isinstance(each, Extreme) and each.least == least else [each] for each in parts]
        return Extreme(least, tuple(one for each in flat for one in each))

    return handle_call


def _join_constants(m: Machine, function: Any, parts: Given, items: Given) -> Given:
    """The parts with all constants joined, and those joined with a sole feature."""
    features = [each for each in parts if isinstance(each, Feature | Extreme)]
    constants = [each for each in parts if not isinstance(each, Feature | Extreme)]
    if not is_constant(constants) or (features and not all(map(is_number, constants))):
        what = f"{function.__name__} is given {words_of(next(each for each in constants if not is_number(each)))}"
        raise Refused(what, TEST_ADVICE)
    number = function(*constants) if len(constants) > 1 else constants[0]
    if not features:  # of members of an Enum, one of them
        return [next(each for each, part in zip(items, parts, strict=True) if part is number or part == number)]
    if len(features) != 1 or not isinstance(features[0], Feature):
        return [*features, number]
    first = isinstance(parts[0], Feature)
    return [convert_feature(m, features[0]).then(*_make_bound(function, number, first))]


def clip(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    """np.clip, of one number."""
    names = {"min": "a_min", "max": "a_max"}
    values = dict(zip(("a", "a_min", "a_max"), given, strict=False)) | {names.get(k, k): v for k, v in named.items()}
    value, low, high = (m.decide(values.get(name)) for name in ("a", "a_min", "a_max"))
    if (isinstance(values.get("a"), Part) and values["a"].array) or isinstance(value, list | tuple):
        raise Refused("a whole array is clipped", "clip each number by itself")
    if isinstance(value, Feature) and is_number(low) and is_number(high):
        ends = (low, high)
        key = f"clip{','.join(f'{type(end).__name__}{end!r}' for end in ends)}"
        step = Step(key, lambda given: np.clip(given, *ends), form=("clip", ends, True))
        return convert_feature(m, value).then(step)
    for bound, function in ((low, np.maximum), (high, np.minimum)):
        if bound is not None:
            value = extreme(function is np.minimum, False)(m, node, [value, bound], {})
    return value


def _make_bound(function: Any, number: Any, first: bool) -> tuple[Step]:
    """The least or the largest of a feature and a constant. `first`: the feature is named first."""
    name = f"{function.__name__}{first:d}{type(number).__name__}{number!r}"
    kind = "max" if function in (max, np.maximum) else "min"
    keeps = first and function in (max, min)  # of equal ones Python's give the first; NumPy's depend on the processor
    apply = (lambda value: function(value, number)) if first else partial(function, number)
    return (Step(name, apply, form=(kind, number, keeps)),)


def _isnan(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    """math.isnan and its like: what they say of numbers; of a NaN the tree does not ask."""
    value = m.decide(given[0])
    if not isinstance(value, Feature):
        return constant(math.isnan, [value], {})
    m.forget_nan()
    return False


# --- lists


def make_list_call(make: Callable[..., Any]) -> Call:
    """list, tuple, enumerate, zip and so on, as Python makes them."""

    def handle_call(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
        items = [each if isinstance(each, int) else m.items(each) for each in given]
        sequence = make(*items, **named)
        if isinstance(sequence, set) and not is_constant(sequence):
            raise Refused("a set is made of what is no constant", "write a list")
        return m.keep_value(sequence) if isinstance(sequence, list | dict | set | tuple) else Stream(list(sequence))

    return handle_call


def _make_set(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    """`set` and `frozenset`, also of a set, whose order is no matter here."""
    return m.keep_value({*given[0]}) if given and isinstance(given[0], set) else make_list_call(set)(m, node, given, {})


def _length(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    """`len`: of an observation, what the file says of it."""
    return len(m.items(given[0])) if isinstance(given[0], Part | Class) else len(given[0])


def _sum(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    """`sum` of whole numbers and conditions, one after the other. Of floats, newer versions of Python add otherwise."""
    total = given[1] if len(given) > 1 else 0
    for each in m.items(given[0]):
        total = binary(m, ast.Add, total, each)
        if not isinstance(total, int) and not (isinstance(total, Feature) and m.counts(total)):
            raise Refused("sum() adds floats, which versions of Python do differently", "write a + b + c")
    return total


def _range(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    """`range`, of constants."""
    whole = [m.whole(each) for each in given]
    if not all(isinstance(each, int) for each in whole) or len(range(*whole)) > MAX_ITEMS:
        raise Refused("a range is no range of constants, or too long", "write range(n)")
    return range(*whole)


def _bool(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    return Condition(True, (given[0],), plain=True) if isinstance(given[0], CONDITIONS) else m.truth(given[0])


def _every(function: Callable[[Iterable[Any]], bool]) -> Call:
    def handle_call(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
        return function(m.truth(each) for each in m.items(*given))

    return handle_call


# --- arrays


def _make_array(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    """np.array and np.asarray: of the observation, or of a list of"""
    value, kind = given[0], named.get("dtype", given[1] if len(given) > 1 else None)
    if named.keys() - {"dtype"} or not isinstance(value, Part | list | tuple):
        raise Refused(f"an array is made of {words_of(value)}", "give the observation, or a list of numbers")
    steps = () if kind is None else conversion(kind)
    if isinstance(value, Part):
        if kind is None and not value.array:
            steps = (Step(m.kind or "float64", np.dtype(m.kind or "float64").type),)
        return replace(value, steps=value.steps + steps, array=True)
    if any(isinstance(each, list | tuple) for each in value):
        raise Refused("an array of several dimensions is made", "write lists of lists")
    parts = [m.decide(each) for each in value]
    if all(map(is_number, parts)):
        return m.keep_value(Array(_convert_constants(m, parts, steps)))
    if steps or not all(isinstance(each, Feature | int | float | np.number) for each in parts):
        raise Refused("an array of features is made of a type, or with what is no number", "give the list itself")
    return m.keep_value(Array(np.float64(each) if isinstance(each, float) else each for each in parts))


def _convert_constants(m: Machine, parts: Given, steps: tuple[Step, ...]) -> list[Any]:
    """Constants as the scalars of an array."""
    if steps and steps[0].key != "float64":
        what = "constants are made numbers of float32, which floats and arrays meet differently"
        raise Refused(what, "write the numbers themselves")
    return [*np.array(parts, dtype=np.float64 if steps else None)]


def _refuse_product(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    """left @ right, which NumPy adds in an order of its own"""
    return binary(m, ast.MatMult, *given[:2])


def _field(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    """`dataclasses.field`."""
    if len(named) != 1 or not named.keys() <= {"default", "default_factory"}:
        raise Refused("a field is not understood", "give its default, or its default_factory")
    return named["default"] if "default" in named else Factory(named["default_factory"])


# --- the tables


def _bounds(names: Mapping[str, Call | Any], module: str) -> dict[str, Any]:
    return {name: Bound(f"{module}{name}", call) if callable(call) else call for name, call in names.items()}


def _steps(module: str) -> dict[str, Call]:
    """The functions of one number that a module has."""
    return {name.rpartition(".")[2]: make_step(name) for name in STEPS if name.rpartition(".")[0] == module}


BUILTINS: dict[str, Any] = _bounds(
    {
        **_steps(""),
        "min": extreme(True, True),
        "max": extreme(False, True),
        "bool": _bool,
        "len": _length,
        "sum": _sum,
        "any": _every(any),
        "all": _every(all),
        "range": _range,
        "list": make_list_call(lambda each=(): list(each)),
        "tuple": make_list_call(lambda each=(): tuple(each)),
        "set": _make_set,
        "frozenset": _make_set,
        "dict": make_list_call(lambda **named: named),
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
            **{name: make_constant_call(getattr(math, name)) for name in _MATH},
            **_steps("math"),
            **{name: getattr(math, name) for name in ("pi", "e", "tau", "inf", "nan")},
            "isnan": _isnan,
        },
    ),
    _module(
        "numpy",
        {
            **{name: make_constant_call(getattr(np, name)) for name in _NUMPY},
            **_steps("numpy"),
            **{name: getattr(np, name) for name in ("pi", "e", "inf", "nan")},
            "ndarray": Symbol("numpy.ndarray"),
            **dict.fromkeys(("array", "asarray"), _make_array),
            "minimum": extreme(True, False),
            "maximum": extreme(False, False),
            "clip": clip,
            "isnan": _isnan,
            **dict.fromkeys(("dot", "matmul", "inner", "vdot"), _refuse_product),
        },
    ),
    Module("enum", {"auto": Bound("auto", lambda m, node, given, named: AUTO)}),
    Module("dataclasses", {"field": Bound("field", _field)}),
    Module("typing", {"TYPE_CHECKING": False}),
)
MODULES: Mapping[str, Module] = {each.name: each for each in _KNOWN}
