"""The functions of Python, math and numpy that are understood, by their names.

Does: tables of names; functions that choose, ask for types, or make arrays.
Assumes: numbers.py and sequences.py have the functions of numbers and of lists.
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

from codegen.importers.python import numbers, sequences
from codegen.importers.python.arithmetic import binary, compare_values
from codegen.importers.python.attributes import attribute_of, conversion
from codegen.importers.python.machine import Machine, step_of
from codegen.importers.python.numbers import STEPS
from codegen.importers.python.sequences import Call, Given, Named, items_of
from codegen.importers.python.values import (
    AUTO,
    Array,
    Bound,
    Class,
    Condition,
    Factory,
    Function,
    Instance,
    Member,
    Module,
    Part,
    Symbol,
    Unread,
)
from codegen.importers.symbolic.feature import Feature, Test

SAME = ("asarray", "array", "asfarray", "ascontiguousarray", "squeeze", "ravel", "atleast_1d", "copy", "reshape",
        "nan_to_num")  # fmt: skip


# --- choices


def _where(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    if len(given) != 3:
        return m.unread("np.where without values is not understood", "write a if test else b")
    if isinstance(given[0], Array):
        sides = [each if isinstance(each, Array | list) else [each] * len(given[0]) for each in given[1:]]
        return m.keep_value(Array(a if m.truth(test) else b for test, a, b in zip(given[0], *sides, strict=False)))
    return given[1] if m.truth(given[0]) else given[2]


def _isinstance(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    value, kinds = given[0], given[1] if isinstance(given[1], tuple) else (given[1],)
    names = [each if isinstance(each, Class) else getattr(each, "name", str(each)).rpartition(".")[2] for each in kinds]
    if isinstance(value, Instance | Member):
        return any(each in value.kind.lineage for each in names)
    unread = next((each for each in kinds if isinstance(each, Unread)), None)
    if unread is not None or (isinstance(value, Part) and any(isinstance(each, Class) for each in names)):
        return unread or m.unread("the class of the observation is asked", "leave the question out")
    if isinstance(value, Part) and _is_container(m, value):
        keyed = m.inputs.inner.get(value.path) is str
        holds = any(each in (("dict", "Mapping") if keyed else ("list", "ndarray", "Sequence")) for each in names)
        m.notes[f"line {m.line}: the observation is taken for a {'dictionary' if keyed else 'list or array'}"] = None
        return holds
    value = m.require_value(m.plain(value))
    if isinstance(value, Feature):
        sample = np.dtype(m.arrays).type(1) if m.arrays and not value.steps else value.value(1.0)
        plain = any(isinstance(sample, each) for each in (int, float) if each.__name__ in names)
        return plain or any(each in ("Number", "Real") for each in names)
    plain = {"int": int, "float": float, "str": str, "bool": bool, "list": list, "tuple": tuple, "dict": dict}
    return any(isinstance(value, plain[each]) for each in names if isinstance(each, str) and each in plain)


def _is_container(m: Machine, part: Part) -> bool:
    """Whether a part of the observation is a list of numbers, and no number: a sole parameter, unless used as one."""
    alone = len(part.path) == 1 == len(m.inputs.parameters)
    return part.path in m.inputs.inner or (alone and part.path not in m.inputs.places)


def _bool(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    return m.truth(given[0]) if given else False


def _every(function: Callable[[Iterable[Any]], bool]) -> Call:
    def handle_call(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
        items = items_of(m, given[0]) if len(given) == 1 and not isinstance(given[0], Test | Condition) else given
        return items if isinstance(items, Unread) else function(m.truth(each) for each in items)

    return handle_call


def _array(name: str) -> Call:
    def handle_call(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
        value, typed = given[0], len(given) > 1 and name in ("asarray", "array")
        kind = named.get("dtype", given[1] if typed else None)
        if name == "nan_to_num" and m.paths is not None:
            m.paths.nan = False
        if isinstance(value, Part):
            steps = conversion(m, kind) if kind is not None else () if value.array else step_of(m.arrays or "float64")
            return steps if isinstance(steps, Unread) else replace(value, steps=value.steps + steps, array=True)
        if not isinstance(value, list | tuple):
            return m.plain(value)
        parts = (
            handle_call(m, node, [each], named) if isinstance(each, list | tuple) else _element(m, each, kind)
            for each in value
        )
        return m.keep_value(Array(parts))

    return handle_call


def _element(m: Machine, value: Any, kind: Any) -> Any:
    """A number of a constant array, in its type."""
    steps = conversion(m, kind) if kind is not None else ()
    if isinstance(value, float) or (isinstance(value, int) and steps and not isinstance(steps, Unread)):
        return (steps[0].apply if steps and not isinstance(steps, Unread) else np.float64)(value)
    return value


def _best(largest: bool) -> Call:
    """np.argmax and np.argmin of constants."""

    def handle_call(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
        items = items_of(m, given[0])
        numbers = items if isinstance(items, Unread) else [m.plain(each) for each in items]
        if isinstance(numbers, Unread) or any(isinstance(each, Feature | Unread) for each in numbers):
            return m.unread("the largest of several features is asked", "compare each feature with a number")
        return numbers.index((max if largest else min)(numbers))

    return handle_call


def _attribute(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    if not isinstance(given[1], str):
        return m.unread("getattr", "write x.name")
    return attribute_of(m, given[0], given[1], node)


def _field(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    """`dataclasses.field`."""
    return named["default"] if "default" in named else Factory(named.get("default_factory"))


def _bounds(names: Mapping[str, Call | Any], module: str) -> dict[str, Any]:
    return {name: Bound(f"{module}{name}", call) if callable(call) else call for name, call in names.items()}


def _named_tuple(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    """collections.namedtuple."""
    name, fields = (*given, named.get("field_names"))[:2]
    words = fields.replace(",", " ").split() if isinstance(fields, str) else fields
    if named.keys() - {"field_names"} or not isinstance(words, list | tuple) or not isinstance(name, str):
        return m.unread("a named tuple is not understood", "write a class of typing.NamedTuple")
    return Class(name, (), {}, fields=tuple(words))


def _reduce(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    """functools.reduce."""
    items = [*given[2:], *m.require_value(items_of(m, given[1]))]
    total = items[0] if items else m.unread("reduce() finds nothing", "give it a first value")
    for each in items[1:]:
        total = m.call(given[0], [total, each], {}, node)
    return total


def _partial(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    """functools.partial."""
    function, *first = given
    if isinstance(function, Function):
        m.makers.add(function)  # it is a part of another one
    return Bound("partial", lambda m, node, more, others: m.call(function, [*first, *more], {**named, **others}, node))


def _steps(module: str) -> dict[str, Call]:
    """The functions of one number that a module has."""
    return {name.rpartition(".")[2]: numbers.make_step(name) for name in STEPS if name.rpartition(".")[0] == module}


BUILTINS: dict[str, Any] = _bounds(
    {
        **_steps(""),
        "min": numbers.extreme(True, True),
        "max": numbers.extreme(False, True),
        "bool": _bool,
        "isinstance": _isinstance,
        "len": sequences.length,
        "sum": sequences.sum_of,
        "any": _every(any),
        "all": _every(all),
        "range": sequences.range_of,
        "sorted": sequences.sort_items,
        "list": sequences.make_list_call(lambda each=(): list(each)),
        "tuple": sequences.make_list_call(lambda each=(): tuple(each)),
        "set": sequences.make_list_call(lambda each=(): set(each), unordered=True),
        "frozenset": sequences.make_list_call(lambda each=(): frozenset(each), unordered=True),
        "dict": sequences.make_list_call(lambda each=(), **named: dict(each, **named)),
        "next": sequences.next_of,
        "enumerate": sequences.make_list_call(enumerate),
        "zip": sequences.make_list_call(zip),
        "map": sequences.map_of,
        "filter": sequences.filter_items,
        "reversed": sequences.make_list_call(lambda each: iter(list(each)[::-1])),
        "iter": sequences.make_list_call(iter),
        "str": numbers.make_constant_call(str),
        "divmod": numbers.make_constant_call(divmod),
        "print": lambda m, node, given, named: None,
        "getattr": _attribute,
    },
    "",
)
_MATH = ("sqrt", "exp", "log", "log2", "log10", "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "hypot", "sinh",
         "cosh", "tanh", "copysign", "pow", "gcd", "isclose", "fmod", "dist", "isinf")  # fmt: skip
_NUMPY = ("sqrt", "exp", "log", "sin", "cos", "tan", "arctan", "arctan2", "tanh", "mean", "prod", "hypot")
_TYPES = ("ndarray", "floating", "integer", "number", "random")
_SIGNS = {"lt": "<", "le": "<=", "gt": ">", "ge": ">=", "eq": "==", "ne": "!="}


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
            **{name: Symbol(f"numpy.{name}") for name in _TYPES},
            **{name: _array(name) for name in SAME},
            **dict.fromkeys(("int64", "int32", "int_", "intp"), numbers.make_step("int")),
            **dict.fromkeys(("minimum", "fmin"), numbers.extreme(True, False)),
            **dict.fromkeys(("maximum", "fmax"), numbers.extreme(False, False)),
            **dict.fromkeys(("min", "amin"), numbers.extreme(True, True)),
            **dict.fromkeys(("max", "amax"), numbers.extreme(False, True)),
            **dict.fromkeys(("any", "logical_or"), _every(any)),
            **dict.fromkeys(("all", "logical_and"), _every(all)),
            "round": numbers.make_step("numpy.rint"),
            "clip": numbers.clip,
            **{each.__name__: numbers.make_spacing(each) for each in (np.linspace, np.arange)},
            "sign": numbers.sign,
            "where": _where,
            "digitize": numbers.make_binning(None),
            "searchsorted": numbers.make_binning(False),
            "isnan": numbers.isnan(False),
            "isfinite": numbers.isnan(True),
            "argmax": _best(True),
            "argmin": _best(False),
            "bool_": _bool,
            "sum": sequences.sum_of,
            # left @ right, which NumPy adds in an order of its own
            **dict.fromkeys(
                ("dot", "matmul", "inner", "vdot"), lambda m, node, given, named: binary(m, ast.MatMult, *given[:2])
            ),
            "logical_not": lambda m, node, given, named: not m.truth(given[0]),
        },
    ),
    _module(
        "bisect",
        {
            **dict.fromkeys(("bisect", "bisect_right"), numbers.make_binning(True)),
            "bisect_left": numbers.make_binning(False),
        },
    ),
    _module("collections", {"namedtuple": _named_tuple}),
    _module("functools", {"partial": _partial, "reduce": _reduce}),
    _module(
        "operator",
        {
            name: lambda m, node, given, named, sign=sign: compare_values(m, sign, given[0], given[1])
            for name, sign in _SIGNS.items()
        },
    ),
    _module("enum", {"auto": lambda m, node, given, named: AUTO}),
    _module("dataclasses", {"field": _field}),
    _module("typing", {"TYPE_CHECKING": False}),
)
MODULES: Mapping[str, Module] = {each.name: each for each in _KNOWN}
