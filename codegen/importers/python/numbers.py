"""Functions of one number: steps of a feature, Python's own result for a constant.

Does: abs, float, int, floor, minima and maxima, clip, sign, borders between numbers.
Assumes: functions that keep or turn the order of floats, or fold it at 0.
Does not: take functions whose rounding nobody promises, such as exp or sin, of a feature.
"""

# pyright: basic
# the values of a program may be anything
import ast
import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np

from codegen.importers.python.arithmetic import (
    CONDITIONS,
    apply_finite,
    compare_values,
    convert_feature,
    is_constant,
    is_number,
)
from codegen.importers.python.machine import MAX_ITEMS, TEST_ADVICE, Machine, step_of, words_of
from codegen.importers.python.values import Array, Condition, Extreme, Part
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
                raise m.make_error(node, "a constant is made a number of float32", "write the number itself")
            return constant(m, node, plain, given, named)
        m.finite |= name in WHOLE
        if len(given) == 1 and not named:
            return convert_feature(m, given[0]).then(Step(name, apply, sense))
        if name != "round" or named or not isinstance(given[1], int):
            raise m.make_error(node, f"{name} with further arguments is not understood", UNKNOWN)
        m.ask_arrays("a feature is rounded to digits")
        if isinstance(convert_feature(m, given[0]).value(1.0), np.generic):
            what = "a number of NumPy is rounded to digits, by a way of its own"
            raise m.make_error(node, what, "compare it with the middle between two of these numbers")
        return given[0].then(Step(f"round{given[1]}", partial(_round, given[1])))

    return handle_call


def _round(digits: int, value: Any) -> Any:
    return apply_finite(lambda each: round(each, digits), value)


def conversion(m: Machine, kind: Any) -> tuple[Step, ...]:
    """The steps of a conversion to a type of NumPy, given as the type, or by its name."""
    name = (kind if isinstance(kind, str) else getattr(kind, "name", "")).rpartition(".")[2]
    if name not in TYPES:
        what = "numbers are converted to a type that is neither float32 nor float64"
        raise m.make_error(None, what, "convert to float32 or float64; int(x[0]) of each number")
    return step_of(TYPES[name])


def constant(m: Machine, node: ast.AST, function: Callable[..., Any], given: Given, named: Named) -> Any:
    """A function of constants, computed by Python itself."""
    if not is_constant(given) or not is_constant(named) or any(isinstance(each, list | tuple | dict) for each in given):
        raise m.make_error(node, f"a function is given {', '.join(map(words_of, given))}", UNKNOWN)
    if any(isinstance(each, str) and len(each) > 400 for each in given):
        raise m.make_error(node, "a text is too long", "make it shorter")
    try:
        return function(*given, **named)
    except (TypeError, ValueError, ArithmeticError):
        raise m.make_error(node, "a function fails with the constants that it is given", "mend it") from None


def make_constant_call(function: Callable[..., Any]) -> Call:
    """A function of constants only."""

    def handle_call(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
        given = [m.decide(each) for each in given]
        if any(isinstance(each, Feature | Extreme) for each in given):
            name = getattr(function, "__name__", "a function")
            raise m.make_error(node, f"{name} of a feature is not understood", "compare the feature itself")
        return constant(m, node, function, given, named)

    return handle_call


# --- the least and the largest


def extreme(least: bool, builtin: bool) -> Call:
    """min, max and their like in numpy."""
    function: Any = (min if least else max) if builtin else np.minimum if least else np.maximum

    def handle_call(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
        items = [*m.items(given[0])] if len(given) == 1 else given
        if not items and "default" in named:
            return named["default"]
        if named.keys() - {"key", "default"} or not items or (not builtin and (named or len(given) != 2)):
            raise m.make_error(node, "the least or largest of nothing, or of what is not understood", UNKNOWN)
        if "key" in named:
            keys = [m.call(named["key"], [each], {}, node) for each in items]
            if not is_constant(keys):
                what = f"{function.__name__} asks for a key that is no constant"
                raise m.make_error(node, what, "compare the features one by one")
            return items[keys.index(function(keys))]
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
        raise m.make_error(None, what, TEST_ADVICE)
    try:
        number = function(*constants) if len(constants) > 1 else constants[0]
    except TypeError:
        raise m.make_error(None, "constants that have no order are compared", "compare numbers") from None
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
        raise m.make_error(node, "a whole array is clipped", "clip each number by itself")
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


# --- rows of numbers, signs and borders


def make_spacing(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    """np.linspace of constants."""
    numbers = [*given, *named.values()]
    long = any(abs(each) > MAX_ITEMS for each in numbers) if all(map(is_number, numbers)) else True
    if long or named.keys() - {"num"}:
        what = "a row of numbers is not understood, or too long"
        raise m.make_error(node, what, "write its numbers: [0.0, 0.5, 1.0]")
    return m.keep_value(Array(constant(m, node, np.linspace, given, named)))


def sign(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    """np.sign: decided."""
    value = m.decide(given[0])
    if isinstance(value, Feature):
        if m.paths is not None:
            m.paths.nan = False  # numpy gives NaN
        kind = type(np.sign(convert_feature(m, value).value(1.0)))
        if m.truth(compare_values(m, ">", value, 0)):
            return kind(1)
        return kind(-1 if m.truth(compare_values(m, "<", value, 0)) else 0)
    return constant(m, node, np.sign, [value], named)


def make_binning(right: bool | None) -> Call:
    """np.digitize (None), bisect_right (True) and bisect_left (False): how many borders are not above a number."""

    def handle_call(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
        if len(given) != 2 or named.keys() - ({"right"} if right is None else set()):
            raise m.make_error(node, "borders are given in a way that is not understood", "give a number and a list")
        value, borders = (given[0], given[1]) if right is None else (given[1], given[0])
        side = named.get("right", False) is not True if right is None else right
        numbers = [m.decide(each) for each in m.items(borders)]
        if not all(map(is_number, numbers)) or numbers != sorted(numbers):
            raise m.make_error(node, "borders are not in ascending order", "sort them")
        for place, border in enumerate(numbers):
            if m.truth(compare_values(m, "<" if side else "<=", value, border)):
                return place
        return len(numbers)

    return handle_call


def isnan(known: bool) -> Call:
    """math.isnan and its like: what they say of numbers; of a NaN the tree does not ask."""

    def handle_call(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
        value = m.decide(given[0])
        if isinstance(value, Feature):
            if m.paths is not None:
                m.paths.nan = False
            if not known:
                return False
            ends = compare_values(m, "<", value, math.inf), compare_values(m, ">", value, -math.inf)
            return Condition(True, ends)
        return constant(m, node, math.isfinite if known else math.isnan, [value], {})

    return handle_call
