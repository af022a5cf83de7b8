"""The functions of Python, math and numpy that are understood.

Does: computes them for constants by Python itself; makes steps of those of one feature that keep or turn its order.
Assumes: names that the file did not give another meaning.
Does not: know functions whose rounding nobody promises, such as exp or sin, of a feature.
"""

import ast
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any, cast

import numpy as np

from codegen.importers.python.arithmetic import binary, compared
from codegen.importers.python.attributes import conversion
from codegen.importers.python.machine import MAX_ITEMS, TEST_ADVICE, Machine, step_of
from codegen.importers.python.values import (
    AUTO,
    Array,
    Bound,
    Class,
    Condition,
    Extreme,
    Factory,
    Instance,
    Length,
    Member,
    Module,
    Part,
    Symbol,
    Unread,
)
from codegen.importers.symbolic.feature import FOLDING, RISING, Feature, Step, Test

Given = list[Any]
Named = dict[str, Any]
Call = Callable[[Machine, ast.AST, Given, Named], Any]
UNKNOWN = "write what it computes with comparisons and numbers"


def _saturated(function: Callable[[float], Any], value: Any) -> Any:
    """A whole number of a finite number; what is infinite, or NaN, stays so, where Python gives up."""
    return function(value) if math.isfinite(value) else value


STEPS: Mapping[str, tuple[Callable[[Any], Any], str]] = {  # of a feature; "int" and so on: of finite numbers only
    "abs": (abs, FOLDING), "math.fabs": (math.fabs, FOLDING), "numpy.abs": (np.abs, FOLDING),
    "numpy.absolute": (np.abs, FOLDING), "numpy.fabs": (np.fabs, FOLDING), "float": (float, RISING),
    "numpy.float64": (np.float64, RISING), "numpy.float32": (np.float32, RISING), "numpy.double": (np.float64, RISING),
    "numpy.floor": (np.floor, RISING), "numpy.ceil": (np.ceil, RISING), "numpy.trunc": (np.trunc, RISING),
    "numpy.rint": (np.rint, RISING), "math.radians": (math.radians, RISING), "math.degrees": (math.degrees, RISING),
    "numpy.deg2rad": (np.deg2rad, RISING), "numpy.radians": (np.radians, RISING),
    "numpy.rad2deg": (np.rad2deg, RISING), "numpy.degrees": (np.degrees, RISING),
    **{name: (partial(_saturated, function), RISING) for name, function in
       (("int", int), ("math.floor", math.floor), ("math.ceil", math.ceil), ("math.trunc", math.trunc), ("round", round))},
}  # fmt: skip
FINITE = ("int", "math.floor", "math.ceil", "math.trunc", "round")
SAME = (
    "asarray",
    "array",
    "asfarray",
    "ascontiguousarray",
    "squeeze",
    "ravel",
    "atleast_1d",
    "copy",
    "reshape",
    "nan_to_num",
)


def _stepped(name: str) -> Call:
    """A function of one number."""
    apply, sense = STEPS[name]
    plain: Callable[..., Any] = {"int": int, "round": round, "math.floor": math.floor, "math.ceil": math.ceil,
                                 "math.trunc": math.trunc}.get(name, apply)  # fmt: skip

    def called(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
        if (
            (len(given) == 1
            and isinstance(given[0], Part)
            and name.startswith("numpy."))
            or (name == "float"
            and len(given) == 1
            and isinstance(given[0], Part))
        ):
            return replace(
                given[0],
                steps=(*given[0].steps, *step_of(m.arrays if not given[0].steps else ""), Step(name, apply, sense)),
            )
        given = [m.needed(m.plain(each)) for each in given]
        if given and isinstance(given[0], Extreme) and sense == RISING:
            return Extreme(given[0].least, tuple(called(m, node, [each, *given[1:]], named) for each in given[0].parts))
        if not given or not isinstance(given[0], Feature):
            return _constant(m, node, plain, given, named)
        m.finite |= name in FINITE
        if len(given) > 1 or named:
            if name != "round" or named or not isinstance(given[1], int):
                return m.unread(f"{name} with further arguments is not understood", UNKNOWN)
            apply_ = partial(_saturated, lambda value, digits=given[1]: round(value, digits))
            return _of(m, given[0]).then(Step(f"round{given[1]}", apply_))
        return _of(m, given[0]).then(Step(name, apply, sense))

    return called


def _of(m: Machine, feature: Feature) -> Feature:
    return feature if feature.steps else feature.then(*step_of(m.arrays))


def _constant(m: Machine, node: ast.AST, function: Callable[..., Any], given: Given, named: Named) -> Any:
    """A function of constants, computed by Python itself."""
    given = [each.value if isinstance(each, Member) and each.kind.whole else each for each in given]
    plain = (bool, int, float, str, np.number, type(None))
    if not all(
        isinstance(each, plain) or (isinstance(each, list | tuple) and all(isinstance(one, plain) for one in each))
        for each in [*given, *named.values()]
    ):
        return m.unread("a function is given what it is not understood for", UNKNOWN)
    if any(isinstance(each, str) and len(each) > 400 for each in given):
        return m.unread("a text is too long", "make it shorter")
    try:
        found = function(*given, **named)
    except (TypeError, ValueError, ArithmeticError, LookupError):
        return m.unread("a function fails with the constants that it is given", "mend it")
    return m.kept(Array(found.tolist())) if isinstance(found, np.ndarray) else found


def _fixed(function: Callable[..., Any]) -> Call:
    """A function of constants only."""

    def called(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
        given = [m.plain(each) for each in given]
        unread = next((each for each in given if isinstance(each, Unread)), None)
        if unread is not None:
            return unread
        if any(isinstance(each, Feature | Extreme) for each in given):
            name = getattr(function, "__name__", "a function")
            return m.unread(f"{name} of a feature is not understood", "compare the feature itself with a number")
        return _constant(m, node, function, given, named)

    return called


# --- the least and the largest


def _extreme(least: bool, builtin: bool) -> Call:
    function: Any = (min if least else max) if builtin else np.minimum if least else np.maximum

    def called(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
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
            parts = _joined(m, function, parts)
        if len(parts) == 1:
            return parts[0]
        return Extreme(
            least,
            tuple(
                one
                for each in parts
                for one in (each.parts if isinstance(each, Extreme) and each.least == least else [each])
            ),
        )

    return called


def _joined(m: Machine, function: Any, parts: Given) -> Given:
    """The parts with all constants joined, and those joined with a sole feature."""
    features = [each for each in parts if isinstance(each, Feature | Extreme)]
    constants = [m.needed(each) for each in parts if not isinstance(each, Feature | Extreme)]
    try:
        number = function(*constants) if len(constants) > 1 else constants[0]
    except TypeError:
        raise m.refused(None, "constants that have no order are compared", "compare numbers") from None
    if len(features) != 1 or not isinstance(features[0], Feature):
        return [*features, number]
    if not isinstance(number, int | float | np.number):
        raise m.refused(None, "a feature is compared with what is no number", TEST_ADVICE)
    first = isinstance(parts[0], Feature)
    apply = partial(_either, function, number, first)
    return [_of(m, features[0]).then(Step(f"{function.__name__}{first:d}{type(number).__name__}{number!r}", apply))]


def _either(function: Any, number: Any, first: bool, value: Any) -> Any:
    return function(value, number) if first else function(number, value)


def _clip(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    names = ["a", "a_min", "a_max"]
    values = dict(zip(names, given, strict=False)) | {
        {"min": "a_min", "max": "a_max"}.get(k, k): v for k, v in named.items()
    }
    value, low, high = (values.get(name) for name in names)
    if isinstance(value, Array | list):
        return m.kept(Array(_clip(m, node, [each, low, high], {}) for each in value))
    value = m.plain(value)
    for bound, function in ((low, np.maximum), (high, np.minimum)):
        if bound is not None:
            value = _extreme(function is np.minimum, False)(m, node, [value, bound], {})
    return value


# --- choices


def _sign(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    value = m.needed(m.plain(given[0]))
    if isinstance(value, Feature | Extreme):
        if m.paths is not None:
            m.paths.nan = False  # numpy gives NaN
        return 1 if m.truth(compared(m, ">", value, 0)) else -1 if m.truth(compared(m, "<", value, 0)) else 0
    return _constant(m, node, np.sign, [value], named)


def _where(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    if len(given) != 3:
        return m.unread("np.where without values is not understood", "write a if test else b")
    if isinstance(given[0], Array):
        sides = [each if isinstance(each, Array | list) else [each] * len(given[0]) for each in given[1:]]
        return m.kept(Array(a if m.truth(test) else b for test, a, b in zip(given[0], *sides, strict=False)))
    return given[1] if m.truth(given[0]) else given[2]


def _binned(right: bool | None) -> Call:
    """np.digitize (None), bisect_right (True) and bisect_left (False): how many borders are not above a number."""

    def called(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
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
            if m.truth(compared(m, "<" if side else "<=", value, border)):
                return place
        return len(numbers)

    return called


def _isinstance(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    value, kinds = given[0], given[1] if isinstance(given[1], tuple) else (given[1],)
    names = [each if isinstance(each, Class) else getattr(each, "name", str(each)).rpartition(".")[2] for each in kinds]
    if isinstance(value, Instance | Member):
        return any(
            isinstance(each, Class) and (each is value.kind or value.kind in _below(each, value.kind)) for each in names
        )
    if isinstance(value, Part):
        keyed = m.inputs.inner.get(value.path) is str
        return any(
            each in (("dict", "Mapping") if keyed else ("list", "tuple", "ndarray", "Sequence")) for each in names
        )
    value = m.needed(m.plain(value))
    if isinstance(value, Feature):
        return any(each in ("float", "int", "Number", "Real", "floating", "number") for each in names)
    plain = {"int": int, "float": float, "str": str, "bool": bool, "list": list, "tuple": tuple, "dict": dict}
    return any(isinstance(value, plain[each]) for each in names if each in plain)


def _below(base: Class, kind: Class) -> list[Class]:
    return [kind] if base in kind.bases or any(_below(base, each) for each in kind.bases) else []


def _bool(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    return m.truth(given[0]) if given else False


def _every(function: Callable[[Iterable[Any]], bool]) -> Call:
    def called(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
        items = items_of(m, given[0]) if len(given) == 1 and not isinstance(given[0], Test | Condition) else given
        return items if isinstance(items, Unread) else function(m.truth(each) for each in items)

    return called


def _isnan(known: bool) -> Call:
    """math.isnan and its like: what they say of numbers; of a NaN the tree does not ask."""

    def called(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
        value = m.needed(m.plain(given[0]))
        if isinstance(value, Feature):
            if m.paths is not None:
                m.paths.nan = False
            if known:
                return Condition(
                    lambda: m.truth(compared(m, "<", value, math.inf)) and m.truth(compared(m, ">", value, -math.inf))
                )
            return False
        return _constant(m, node, math.isfinite if known else math.isnan, [value], {})

    return called


# --- lists


def items_of(m: Machine, value: Any) -> Any:
    """The parts of a list, a text, a dictionary, an Enum or an observation of known length."""
    value = m.needed(value)
    if isinstance(value, Part):
        n = m.inputs.length(value.path)
        if not n:
            return m.unread("the file does not say how many features there are", "name all: --features a,b,c")
        return [m.inputs.enter(value, k, m.line) for k in range(n - value.offset)]
    if isinstance(value, Class) and value.enum:
        return [each for each in value.members.values() if isinstance(each, Member)]
    if isinstance(value, set | frozenset) and len(cast("set[Any]", value)) > 1:
        return m.unread("a loop goes over a set, whose order nobody knows", "write a list")
    if isinstance(value, dict | set | frozenset):
        return list(cast("set[Any]", value))
    if isinstance(value, list | tuple | str | range) or hasattr(value, "__next__"):
        return value
    raise m.refused(None, "a loop goes over something that is no list", "loop over literals")


def _listed(make: Callable[[Iterable[Any]], Any]) -> Call:
    """list, tuple, enumerate, zip and so on, of lists."""

    def called(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
        items = [items_of(m, each) if not isinstance(each, int) else each for each in given]
        unread = next((each for each in items if isinstance(each, Unread)), None)
        try:
            found = unread or make(*items, **named)
        except (TypeError, ValueError):
            raise m.refused(node, "a list is made of what it cannot be made of", "write the list itself") from None
        m.count(len(found) if isinstance(found, list | tuple | dict | set) else 1)
        return m.kept(found) if isinstance(found, list | dict | set) else found

    return called


def _mapped(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    if isinstance(given[1], Part) and not m.inputs.length(given[1].path):
        return mapped(m, given[1], lambda each: m.call(given[0], [each], {}, node))
    items = [items_of(m, each) for each in given[1:]]
    unread = next((each for each in items if isinstance(each, Unread)), None)
    return unread or m.kept([m.call(given[0], list(each), {}, node) for each in zip(*items, strict=False)])


def mapped(m: Machine, part: Part, function: Callable[[Any], Any]) -> Any:
    """The observation with each of its numbers, however many there are, replaced by what one step makes of it."""
    found = function(Feature(-1, part.steps))
    if isinstance(found, Feature) and found.place == -1:
        return replace(part, steps=found.steps, array=False)
    return m.unread("the file does not say how many features there are", "name all: --features a,b,c")


def _filtered(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    items = items_of(m, given[1])
    return (
        items
        if isinstance(items, Unread)
        else m.kept([each for each in items if m.truth(m.call(given[0], [each], {}, node))])
    )


def _length(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    if isinstance(given[0], Part):
        return m.inputs.length(given[0].path) - given[0].offset if m.inputs.length(given[0].path) else Length(given[0])
    items = items_of(m, given[0])
    return items if isinstance(items, Unread) else len(items)


def _sum(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    items, total = items_of(m, given[0]), given[1] if len(given) > 1 else 0
    for each in [items] if isinstance(items, Unread) else items:
        total = binary(m, ast.Add, total, each)
    return total


def _next(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    items = iter(items_of(m, given[0]))
    found = (
        next(items, *given[1:]) if len(given) > 1 else next(items, m.unread("next() finds nothing", "give a default"))
    )
    return found


def _sorted(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    items = items_of(m, given[0])
    if isinstance(items, Unread):
        return items
    items = list(items)
    keys = [m.whole(m.call(named["key"], [each], {}, node) if "key" in named else each) for each in items]
    order = sorted(range(len(items)), key=keys.__getitem__, reverse=bool(named.get("reverse")))
    return m.kept([items[place] for place in order])


def _range(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    numbers = [m.whole(each) for each in given]
    if not all(isinstance(each, int) for each in numbers) or len(range(*numbers)) > MAX_ITEMS:
        return m.unread("a range is no range of constants, or too long", "write range(n)")
    return range(*numbers)


def _array(name: str) -> Call:
    def called(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
        value, kind = (
            given[0],
            named.get("dtype", given[1] if len(given) > 1 and name in ("asarray", "array") else None),
        )
        if name == "nan_to_num" and m.paths is not None:
            m.paths.nan = False
        if isinstance(value, Part):
            steps = conversion(m, kind) if kind is not None else () if value.array else step_of(m.arrays or "float64")
            return steps if isinstance(steps, Unread) else replace(value, steps=value.steps + steps, array=True)
        if not isinstance(value, list | tuple):
            return m.plain(value)
        return m.kept(
            Array(
                called(m, node, [each], named) if isinstance(each, list | tuple) else _element(m, each, kind)
                for each in value
            )
        )

    return called


def _element(m: Machine, value: Any, kind: Any) -> Any:
    """A number of a constant array, in its type."""
    steps = conversion(m, kind) if kind is not None else ()
    if isinstance(value, float) or (isinstance(value, int) and steps and not isinstance(steps, Unread)):
        return (steps[0].apply if steps and not isinstance(steps, Unread) else np.float64)(value)
    return value


def _best(largest: bool) -> Call:
    """np.argmax and np.argmin of constants."""

    def called(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
        items = items_of(m, given[0])
        numbers = items if isinstance(items, Unread) else [m.plain(each) for each in items]
        if isinstance(numbers, Unread) or any(isinstance(each, Feature | Unread) for each in numbers):
            return m.unread("the largest of several features is asked", "compare each feature with a number")
        return numbers.index((max if largest else min)(numbers))

    return called


def _attribute(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    return m.attribute(given[0], given[1], node) if isinstance(given[1], str) else m.unread("getattr", "write x.name")


def _field(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    """`dataclasses.field`."""
    return named["default"] if "default" in named else Factory(named.get("default_factory"))


def _bounds(names: Mapping[str, Call | Any], module: str) -> dict[str, Any]:
    return {name: Bound(f"{module}{name}", call) if callable(call) else call for name, call in names.items()}


def _quiet(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    return None


_STEPS = {module: {name.rpartition(".")[2]: _stepped(name) for name in STEPS if name.rpartition(".")[0] == module}
          for module in ("", "math", "numpy")}  # fmt: skip
_CONSTANT = {name: _fixed(getattr(math, name)) for name in
             """sqrt exp log log2 log10 sin cos tan asin acos atan atan2 hypot sinh cosh tanh copysign pow gcd isclose
             fmod dist""".split()}  # fmt: skip # noqa: SIM905
BUILTINS: dict[str, Any] = _bounds({
    **_STEPS[""], "min": _extreme(True, True), "max": _extreme(False, True), "bool": _bool, "isinstance": _isinstance,
    "len": _length, "sum": _sum, "any": _every(any), "all": _every(all), "range": _range, "sorted": _sorted,
    "list": _listed(lambda each=(): list(each)), "tuple": _listed(lambda each=(): tuple(each)),
    "set": _listed(lambda each=(): set(each)), "frozenset": _listed(lambda each=(): frozenset(each)),
    "dict": _listed(lambda each=(), **named: dict(each, **named)), "next": _next,
    "enumerate": _listed(lambda each, start=0: list(enumerate(each, start))), "iter": _listed(lambda each: list(each)),
    "zip": _listed(lambda *each, strict=False: list(zip(*each, strict=False))), "map": _mapped, "filter": _filtered,
    "reversed": _listed(lambda each: list(each)[::-1]), "str": _fixed(str), "divmod": _fixed(divmod),
    "print": _quiet, "getattr": _attribute,
}, "")  # fmt: skip
MODULES: dict[str, Module] = {
    "math": Module("math", _bounds({
        **_CONSTANT, **_STEPS["math"], "pi": math.pi, "e": math.e, "tau": math.tau, "inf": math.inf, "nan": math.nan,
        "isnan": _isnan(False), "isinf": _fixed(math.isinf), "isfinite": _isnan(True),
    }, "math.")),
    "numpy": Module("numpy", _bounds({
        **{name: _fixed(getattr(np, name)) for name in "sqrt exp log sin cos tan arctan2 arctan tanh mean prod hypot".split()},  # noqa: SIM905
        **_STEPS["numpy"], **{name: _array(name) for name in SAME}, "pi": np.pi, "inf": np.inf, "nan": np.nan, "e": np.e,
        "minimum": _extreme(True, False), "maximum": _extreme(False, False), "clip": _clip, "sign": _sign,
        "where": _where, "digitize": _binned(None), "searchsorted": _binned(False), "any": _every(any),
        "all": _every(all), "isnan": _isnan(False), "isfinite": _isnan(True), "argmax": _best(True),
        "argmin": _best(False), "min": _extreme(True, True), "max": _extreme(False, True), "round": _stepped("numpy.rint"),
        "logical_and": _every(all), "logical_or": _every(any), "int64": _stepped("int"), "int32": _stepped("int"),
        "bool_": _bool, "sum": _sum,
        **{name: Symbol(f"numpy.{name}") for name in ("ndarray", "floating", "integer", "number", "random")},
        "logical_not": lambda m, node, given, named: not m.truth(given[0]),
    }, "numpy.")),
    "enum": Module("enum", {"auto": Bound("auto", lambda m, node, given, named: AUTO)}),
    "dataclasses": Module("dataclasses", {"field": Bound("field", _field)}),
    "typing": Module("typing", {"TYPE_CHECKING": False}),
    "bisect": Module("bisect", _bounds({
        "bisect": _binned(True), "bisect_right": _binned(True), "bisect_left": _binned(False),
    }, "bisect.")),
}  # fmt: skip
