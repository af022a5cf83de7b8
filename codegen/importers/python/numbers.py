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
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from codegen.importers.python.arithmetic import apply_finite, compare_values, convert_feature
from codegen.importers.python.machine import MAX_ITEMS, TEST_ADVICE, Machine, step_of
from codegen.importers.python.sequences import Call, Given, Named, items_of
from codegen.importers.python.values import Array, Condition, Extreme, Member, Part, Unread
from codegen.importers.symbolic.feature import FOLDING, RISING, Feature, Step

UNKNOWN = "write what it computes with comparisons and numbers"


WHOLE: Mapping[str, Callable[..., Any]] = {  # of finite numbers only
    "int": int, "math.floor": math.floor, "math.ceil": math.ceil, "math.trunc": math.trunc, "round": round,
}  # fmt: skip
STEPS: Mapping[str, tuple[Callable[[Any], Any], str]] = {  # of a feature
    "abs": (abs, FOLDING), "math.fabs": (math.fabs, FOLDING), "numpy.abs": (np.abs, FOLDING),
    "numpy.absolute": (np.abs, FOLDING), "numpy.fabs": (np.fabs, FOLDING), "float": (float, RISING),
    "numpy.float64": (np.float64, RISING), "numpy.float32": (np.float32, RISING), "numpy.double": (np.float64, RISING),
    "numpy.floor": (np.floor, RISING), "numpy.ceil": (np.ceil, RISING), "numpy.trunc": (np.trunc, RISING),
    "numpy.rint": (np.rint, RISING), "math.radians": (math.radians, RISING), "math.degrees": (math.degrees, RISING),
    "numpy.deg2rad": (np.deg2rad, RISING), "numpy.radians": (np.radians, RISING),
    "numpy.rad2deg": (np.rad2deg, RISING), "numpy.degrees": (np.degrees, RISING),
    **{name: (partial(apply_finite, function), RISING) for name, function in WHOLE.items()},
}  # fmt: skip


def make_step(name: str) -> Call:
    """A function of one number."""
    apply, sense = STEPS[name]
    plain = WHOLE.get(name, apply)

    def handle_call(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
        if len(given) == 1 and isinstance(given[0], Part) and (name == "float" or name.startswith("numpy.")):
            before = given[0].steps or step_of(m.arrays)
            return replace(given[0], steps=(*before, Step(name, apply, sense)))
        given = [m.require_value(m.plain(each)) for each in given]
        if given and isinstance(given[0], Extreme) and sense == RISING:
            parts = tuple(handle_call(m, node, [each, *given[1:]], named) for each in given[0].parts)
            return Extreme(given[0].least, parts)
        if not given or not isinstance(given[0], Feature):
            return constant(m, node, plain, given, named)
        m.finite |= name in WHOLE
        if len(given) > 1 or named:
            if name != "round" or named or not isinstance(given[1], int):
                return m.unread(f"{name} with further arguments is not understood", UNKNOWN)
            apply_ = partial(apply_finite, lambda value, digits=given[1]: round(value, digits))
            return convert_feature(m, given[0]).then(Step(f"round{given[1]}", apply_))
        return convert_feature(m, given[0]).then(Step(name, apply, sense))

    return handle_call


def constant(m: Machine, node: ast.AST, function: Callable[..., Any], given: Given, named: Named) -> Any:
    """A function of constants, computed by Python itself."""
    given = [each.value if isinstance(each, Member) and each.kind.mixed else each for each in given]
    plain = (bool, int, float, str, np.number, type(None))
    if not all(
        isinstance(each, plain) or (isinstance(each, list | tuple) and all(isinstance(one, plain) for one in each))
        for each in [*given, *named.values()]
    ):
        return m.unread("a function is given what it is not understood for", UNKNOWN)
    if any(isinstance(each, str) and len(each) > 400 for each in given):
        return m.unread("a text is too long", "make it shorter")
    try:
        returned = function(*given, **named)
    except (TypeError, ValueError, ArithmeticError, LookupError):
        return m.unread("a function fails with the constants that it is given", "mend it")
    return m.keep_value(Array(returned.tolist())) if isinstance(returned, np.ndarray) else returned


def make_constant_call(function: Callable[..., Any]) -> Call:
    """A function of constants only."""

    def handle_call(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
        given = [m.plain(each) for each in given]
        unread = next((each for each in given if isinstance(each, Unread)), None)
        if unread is not None:
            return unread
        if any(isinstance(each, Feature | Extreme) for each in given):
            name = getattr(function, "__name__", "a function")
            return m.unread(f"{name} of a feature is not understood", "compare the feature itself with a number")
        return constant(m, node, function, given, named)

    return handle_call


# --- the least and the largest


def extreme(least: bool, builtin: bool) -> Call:
    """min, max and their like in numpy."""
    function: Any = (min if least else max) if builtin else np.minimum if least else np.maximum

    def handle_call(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
        key, default = named.get("key"), named.get("default")
        items = items_of(m, given[0]) if len(given) == 1 else given
        if isinstance(items, Unread):
            return items
        if key is not None:
            items = list(items)
            keys = [m.whole(m.call(key, [each], {}, node)) for each in items]
            return items[keys.index(function(keys))]
        parts = [m.plain(each) for each in items]
        unread = next((each for each in parts if isinstance(each, Unread)), None)
        if unread is not None or not parts:
            return unread or default
        if not all(isinstance(each, Feature | Extreme) for each in parts):
            parts = _join_constants(m, function, parts)
        if len(parts) == 1:
            return parts[0]
        flat = [each.parts if isinstance(each, Extreme) and each.least == least else [each] for each in parts]
        return Extreme(least, tuple(one for each in flat for one in each))

    return handle_call


def _join_constants(m: Machine, function: Any, parts: Given) -> Given:
    """The parts with all constants joined, and those joined with a sole feature."""
    features = [each for each in parts if isinstance(each, Feature | Extreme)]
    constants = [m.require_value(each) for each in parts if not isinstance(each, Feature | Extreme)]
    try:
        number = function(*constants) if len(constants) > 1 else constants[0]
    except TypeError:
        raise m.make_error(None, "constants that have no order are compared", "compare numbers") from None
    if len(features) != 1 or not isinstance(features[0], Feature):
        return [*features, number]
    if not isinstance(number, int | float | np.number):
        raise m.make_error(None, "a feature is compared with what is no number", TEST_ADVICE)
    first = isinstance(parts[0], Feature)
    return [convert_feature(m, features[0]).then(*_make_bound(function, number, first))]


def clip(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    """np.clip."""
    names = ["a", "a_min", "a_max"]
    values = dict(zip(names, given, strict=False)) | {
        {"min": "a_min", "max": "a_max"}.get(k, k): v for k, v in named.items()
    }
    value, low, high = (values.get(name) for name in names)
    if isinstance(value, Part):
        return _clip_part(m, value, low, high)
    if isinstance(value, Array | list):
        lows, highs = (end if isinstance(end, Array | list) else [end] * len(value) for end in (low, high))
        if len(lows) != len(value) or len(highs) != len(value):
            return m.unread("numbers are clipped to more or fewer bounds than there are", "give a bound for each")
        parts = zip(map(m.plain, value), lows, highs, strict=True)
        return m.keep_value(Array(clip(m, node, list(each), {}) for each in parts))
    value = m.plain(value)
    ends = [m.plain(bound) for bound in (low, high)]
    if isinstance(value, Feature) and all(isinstance(end, int | float | np.number) for end in ends):
        step = f"clip{','.join(f'{type(end).__name__}{end!r}' for end in ends)}"
        return value.then(Step(step, lambda given: np.clip(given, *ends), form=("clip", tuple(ends), True)))
    for bound, function in ((low, np.maximum), (high, np.minimum)):
        if bound is not None:
            value = extreme(function is np.minimum, False)(m, node, [value, bound], {})
    return value


def _clip_part(m: Machine, part: Part, low: Any, high: Any) -> Any:
    """Every number of an observation, clipped, as an array."""
    steps = () if part.array else step_of(m.arrays or "float64")
    for bound, function in ((low, np.maximum), (high, np.minimum)):
        number = m.require_value(m.plain(bound))
        if number is not None and not isinstance(number, int | float | np.number):
            return m.unread("an observation is clipped by what is no number", "clip each number by itself")
        if number is not None:
            steps += _make_bound(function, number, True)
    return replace(part, steps=part.steps + steps, array=True)


def _make_bound(function: Any, number: Any, first: bool) -> tuple[Step]:
    """The least or the largest of a feature and a constant. `first`: the feature is named first."""
    name = f"{function.__name__}{first:d}{type(number).__name__}{number!r}"
    kind = "max" if function in (max, np.maximum) else "min"
    keeps = first and function in (max, min)  # of equal ones Python's give the first; NumPy's depend on the processor
    apply = (lambda value: function(value, number)) if first else partial(function, number)
    return (Step(name, apply, form=(kind, number, keeps)),)


def make_spacing(function: Callable[..., Any]) -> Call:
    """np.linspace and np.arange of constants."""

    def handle_call(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
        given = [m.whole(each) for each in given]
        numbers = [each for each in (*given, *named.values()) if isinstance(each, int | float)]
        low, high = (given[0], given[1]) if len(given) > 1 else (0, given[0] if given else 0)
        long = any(abs(each) > MAX_ITEMS for each in numbers) if function is np.linspace else False
        if function is np.arange and len(numbers) == len(given):
            step = given[2] if len(given) > 2 else 1
            long = not step or abs((high - low) / step) > MAX_ITEMS
        if len(numbers) < len(given) + len(named) or named.keys() - {"num"} or long:
            return m.unread("a row of numbers is not understood, or too long", "write its numbers: [0.0, 0.5, 1.0]")
        return constant(m, node, function, given, named)

    return handle_call


def sign(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    """np.sign: decided."""
    value = m.require_value(m.plain(given[0]))
    if isinstance(value, Feature | Extreme):
        if m.paths is not None:
            m.paths.nan = False  # numpy gives NaN
        if m.truth(compare_values(m, ">", value, 0)):
            return 1
        return -1 if m.truth(compare_values(m, "<", value, 0)) else 0
    return constant(m, node, np.sign, [value], named)


def make_binning(right: bool | None) -> Call:
    """np.digitize (None), bisect_right (True) and bisect_left (False): how many borders are not above a number."""

    def handle_call(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
        value, borders = (given[0], given[1]) if right is None else (given[1], given[0])
        side = named.get("right", given[2] if len(given) > 2 else False) is not True if right is None else right
        side = {"left": False, "right": True}.get(named.get("side", ""), side)
        borders = items_of(m, borders)
        if isinstance(borders, Unread):
            return borders
        numbers = [m.whole(each) for each in borders]
        if numbers != sorted(numbers):
            return m.unread("borders are not in ascending order", "sort them")
        for place, border in enumerate(numbers):
            if m.truth(compare_values(m, "<" if side else "<=", value, border)):
                return place
        return len(numbers)

    return handle_call


def isnan(known: bool) -> Call:
    """math.isnan and its like: what they say of numbers; of a NaN the tree does not ask."""

    def handle_call(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
        value = m.require_value(m.plain(given[0]))
        if isinstance(value, Feature):
            if m.paths is not None:
                m.paths.nan = False
            if not known:
                return False
            ends = [compare_values(m, "<", value, math.inf), compare_values(m, ">", value, -math.inf)]
            return Condition(lambda: all(m.truth(each) for each in ends))
        return constant(m, node, math.isfinite if known else math.isnan, [value], {})

    return handle_call
