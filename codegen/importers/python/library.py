"""The functions of Python, math and numpy that are read, by their names.

Does: steps of a feature, and Python's own result for a constant; the least and the largest; functions that make, take
  apart and count lists, or make arrays.
Assumes: functions that keep or turn the order of floats, or fold it at 0.
Does not: take functions whose rounding nobody promises, such as exp or sin, of a feature.

Each is called with the machine (machine.py), what is given by place, and what is given by name.
"""

# pyright: basic
# the values of a program may be anything
import ast
import enum
import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial, reduce
from typing import Any

import numpy as np

from codegen.importers.python.arithmetic import binary, convert_feature, is_constant, is_number, step_of
from codegen.importers.python.values import (
    CONDITIONS,
    MAX_ITEMS,
    STATED,
    TEST_ADVICE,
    Array,
    Bound,
    Condition,
    Extreme,
    Factory,
    Module,
    Part,
    Refused,
    Stream,
    words_of,
)
from codegen.importers.symbolic.feature import FOLDING, RISING, Feature, Step

Given = list[Any]
Named = dict[str, Any]
Call = Callable[[Any, Given, Named], Any]
TYPES = {"float": "float64", "numpy.float64": "float64", "numpy.float32": "float32"}  # of arrays
WHOLE: Mapping[str, Callable[..., Any]] = {  # of finite numbers only
    "int": int, "math.floor": math.floor, "math.ceil": math.ceil, "round": round,
}  # fmt: skip
STEPS: Mapping[str, tuple[Callable[[Any], Any], str]] = {  # of a feature; "": of constants only
    "abs": (abs, FOLDING), "math.fabs": (math.fabs, FOLDING), "numpy.abs": (np.abs, FOLDING),
    "float": (float, RISING), "numpy.float64": (np.float64, RISING), "numpy.float32": (np.float32, RISING),
    "math.radians": (math.radians, RISING), "math.degrees": (math.degrees, RISING),
    "numpy.deg2rad": (np.deg2rad, RISING), "numpy.rad2deg": (np.rad2deg, RISING),
    # what is infinite, or NaN, stays so, where Python gives up
    **{name: (lambda value, of=of: of(value) if math.isfinite(value) else value, RISING) for name, of in WHOLE.items()},
    **{f"math.{name}": (getattr(math, name), "") for name in ("sqrt", "exp", "log", "sin", "cos", "tan", "atan")},
}  # fmt: skip
STREAMS = ("any", "all", "sum", "min", "max", "list", "tuple", "enumerate", "zip")  # which take iterators apart


def _call_step(name: str, m: Any, given: Given, named: Named) -> Any:
    """A function of one number: of a constant, computed by Python itself."""
    apply, sense = STEPS[name]
    counts = name in ("int", "float")  # which make the same number of a condition among floats and arrays
    given = [m.truth(each) if counts and isinstance(each, CONDITIONS) else m.decide(each) for each in given]
    if given and isinstance(given[0], Feature):
        if len(given) > 1 or named or not sense:
            raise Refused(f"{name} of a feature, or with further arguments, is not understood", STATED)
        m.finite |= name in WHOLE
        return convert_feature(m, given[0]).then(Step(name, apply, sense))
    if name == "numpy.float32":
        raise Refused("a constant is made a number of float32", "write the number itself")
    if named or not all(is_number(each) or (isinstance(each, str) and len(each) < 400) for each in given):
        raise Refused(f"a function is given {', '.join(map(words_of, given))}", STATED)
    return WHOLE.get(name, apply)(*given)


# --- the least and the largest


def _call_extreme(function: Any, m: Any, given: Given, named: Named) -> Any:
    """min, max and their like in numpy."""
    items = [*m.items(given[0])] if len(given) == 1 else given
    if named or not items or (function not in (min, max) and len(given) != 2):
        raise Refused("the least or largest of nothing, or of what is not understood", STATED)
    return reduce(partial(_join_pair, m, function), [m.decide(each) for each in items])


def _join_pair(m: Any, function: Any, one: Any, other: Any) -> Any:
    """The least or largest of two: a number, a step of a feature, or one that is found by comparisons."""
    for each in (one, other):
        if not (is_number(each) or isinstance(each, Feature | Extreme)):
            raise Refused(f"{function.__name__} is given {words_of(each)}", TEST_ADVICE)
    if is_number(one) and is_number(other):
        return function(one, other)
    first = isinstance(one, Feature)
    feature, number = (one, other) if first else (other, one)
    if not isinstance(feature, Feature) or not is_number(number):
        return Extreme(function in (min, np.minimum), (one, other))
    kind = "max" if function in (max, np.maximum) else "min"
    keeps = first and function in (max, min)  # of equal ones Python's give the first; NumPy's depend on the processor
    apply = (lambda value: function(value, number)) if first else partial(function, number)
    key = f"{function.__name__}{first:d}{type(number).__name__}{number!r}"
    return convert_feature(m, feature).then(Step(key, apply, form=(kind, number, keeps)))


def _clip(m: Any, given: Given, named: Named) -> Any:
    """np.clip, of one number."""
    if len(given) == 1 and named.keys() == {"a_min", "a_max"}:
        given, named = [*given, named["a_min"], named["a_max"]], {}
    value, *ends = map(m.decide, given)
    if named or len(ends) != 2 or not all(map(is_number, ends)) or not isinstance(value, Feature | int | float):
        raise Refused("a whole array is clipped, or by what is no number", "write np.clip(x[0], low, high)")
    if not isinstance(value, Feature):
        return np.clip(value, *ends)
    key = f"clip{','.join(f'{type(end).__name__}{end!r}' for end in ends)}"
    step = Step(key, lambda given: np.clip(given, *ends), form=("clip", tuple(ends), True))
    return convert_feature(m, value).then(step)


# --- lists and arrays


def _call_list(make: Callable[..., Any], m: Any, given: Given, named: Named) -> Any:
    """list, tuple, enumerate, zip and so on, as Python makes them."""
    items = [each if isinstance(each, int) else m.items(each) for each in given]
    sequence = make(*items, **named)
    return m.keep_value(sequence) if isinstance(sequence, list | dict | tuple) else Stream(sequence)


def _sum(m: Any, given: Given, named: Named) -> Any:
    """`sum` of whole numbers and conditions, one after the other. Of floats, newer versions of Python add otherwise."""
    total: Any = 0
    for each in m.items(*given):
        total = binary(m, ast.Add, total, each)
        if not isinstance(total, int) and not (isinstance(total, Feature) and m.counts(total)):
            raise Refused("sum() adds floats, which versions of Python do differently", "write a + b + c")
    return total


def _range(m: Any, given: Given, named: Named) -> Any:
    """`range`, of constants."""
    whole = [m.whole(each) for each in given]
    if not all(isinstance(each, int) for each in whole) or len(range(*whole)) > MAX_ITEMS:
        raise Refused("a range is no range of constants, or too long", "write range(n)")
    return range(*whole)


def _make_array(m: Any, given: Given, named: Named) -> Any:
    """np.array and np.asarray: of the observation, or of a list of numbers."""
    value, kind = given[0], named.get("dtype")
    if len(given) > 1 or named.keys() - {"dtype"} or not isinstance(value, Part | list | tuple):
        raise Refused(f"an array is made of {words_of(value)}", "give the observation, or a list of numbers")
    if isinstance(value, Part):
        given_kind = "" if value.array else m.kind or "float64"
        name = given_kind if kind is None else TYPES.get(getattr(kind, "name", ""))
        if name is None:
            what = "numbers are converted to a type that is neither float32 nor float64"
            raise Refused(what, "convert to float32 or float64; int(x[0]) of each number")
        return replace(value, steps=value.steps + step_of(name), array=True)
    parts = [m.decide(each) for each in value]
    if kind is not None or not all(isinstance(each, Feature) or is_number(each) for each in parts):
        raise Refused("an array is made of a type, or of what is no number", "give the list itself")
    if is_constant(parts):
        return m.keep_value(Array(np.array(parts)))
    return m.keep_value(Array(np.float64(each) if isinstance(each, float) else each for each in parts))


def _field(m: Any, given: Given, named: Named) -> Any:
    """`dataclasses.field`."""
    if named.keys() != {"default_factory"}:
        raise Refused("a field is not understood", "give its default, or its default_factory")
    return Factory(named["default_factory"])


def _log(m: Any, given: Given, named: Named) -> Any:
    """`print` and functions of logging: None."""


def _refuse_call(m: Any, given: Given, named: Named) -> Any:
    """Refuses a call of what stands in class statements only."""
    raise Refused("this is called", STATED)


# --- the tables


CALLS: Mapping[str, Call] = {
    **{name: partial(_call_step, name) for name in STEPS},
    **dict.fromkeys(("staticmethod", "classmethod", "property", "object", "str"), _refuse_call),
    **dict.fromkeys(("numpy.ndarray", "enum.unique", "dataclasses.dataclass"), _refuse_call),
    **dict.fromkeys(("typing.NamedTuple", "typing.TypedDict", "typing.Protocol"), _refuse_call),
    **dict.fromkeys(("print", "logging.debug", "logging.info", "logging.warning", "logging.error"), _log),
    **dict.fromkeys(("numpy.dot", "numpy.matmul"), lambda m, given, named: binary(m, ast.MatMult, *given[:2])),
    **dict.fromkeys(("numpy.array", "numpy.asarray"), _make_array),
    **{name: partial(_call_extreme, function) for name, function in (("min", min), ("max", max))},
    **{f"numpy.{of}": partial(_call_extreme, getattr(np, of)) for of in ("minimum", "maximum")},
    **{name: partial(_call_list, make) for name, make in (("enumerate", enumerate), ("zip", zip))},
    "list": partial(_call_list, lambda each=(): list(each)),
    "tuple": partial(_call_list, lambda each=(): tuple(each)),
    "dict": partial(_call_list, lambda **named: named),
    "reversed": partial(_call_list, lambda each: iter(list(each)[::-1])),
    "numpy.clip": _clip,
    "bool": lambda m, given, named: Condition(True, (given[0],)),
    "len": lambda m, given, named: len(m.items(*given) if isinstance(given[0], Part | enum.EnumType) else given[0]),
    "sum": _sum,
    "any": lambda m, given, named: any(m.truth(each) for each in m.items(*given)),
    "all": lambda m, given, named: all(m.truth(each) for each in m.items(*given)),
    "range": _range,
    "enum.auto": lambda m, given, named: enum.auto(),
    "dataclasses.field": _field,
    "logging.getLogger": lambda m, given, named: Module("logging", _members("logging")),
}
KNOWN: Mapping[str, Any] = {
    **{f"{module}.{name}": getattr(math, name) for module in ("math", "numpy") for name in ("pi", "e", "inf", "nan")},
    **{name: Bound(name, call) for name, call in CALLS.items()},
    "enum.Enum": enum.Enum,
    "enum.IntEnum": enum.IntEnum,
    "typing.TYPE_CHECKING": False,
}


def _members(module: str) -> dict[str, Any]:
    parts = {name: name.rpartition(".") for name in KNOWN}
    return {parts[name][2]: value for name, value in KNOWN.items() if parts[name][0] == module}


BUILTINS = _members("")
NAMES = ("math", "numpy", "enum", "dataclasses", "typing", "logging")
MODULES: Mapping[str, Module] = {each: Module(each, _members(each)) for each in NAMES}
