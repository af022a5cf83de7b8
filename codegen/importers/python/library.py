"""What an expression of Python may be, and what Python computes: operators, comparisons, functions of math and numpy.

Does: names the kinds of values that the reader adds to Python's own; gives each number of the observation that is read
  (`x[0]`, `x["speed"]`, `x.speed`, a parameter) a place, and says which features there are; computes with constants as
  Python does, within limits; makes steps of arithmetic on one feature, and tests of comparisons; the least and the
  largest; functions that make, take apart and count lists, or make arrays.
Assumes: float arithmetic of this machine is IEEE 754, as that of NumPy is; functions that keep or turn the order of
  floats, or fold it at 0.
Does not: evaluate nodes: `m` is the machine that does (machine.py), which knows features, counts and decides. Functions
  whose rounding nobody promises, such as exp or sin, are not taken of a feature.

Steps compute with Python's own floats, or NumPy's scalars where the observation is an array, so a threshold that is
found through them is that of Python, to the last bit.
"""

# pyright: basic
# the values of a program may be anything
import ast
import enum
import math
import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial, reduce
from inspect import Signature
from typing import Any

import numpy as np

from codegen.errors import InputError, escape_text
from codegen.importers.reading import MAX_FEATURES
from codegen.importers.symbolic.feature import (
    CUT_BEFORE,
    CUTTING,
    FOLDING,
    IN_ORDER,
    RISING,
    SIGNS,
    TURNED,
    Feature,
    Step,
    Test,
    arithmetic_step,
    at_most,
    is_whole,
)
from codegen.importers.symbolic.paths import Described
from codegen.importers.symbolic.statements import Scope

MAX_ITEMS = 1 << 16  # of a list, a text or a dictionary
TEST_ADVICE = "compare one feature with a number; give a sum or a difference as a feature of its own"
STATED = "write what it computes with comparisons and numbers; importing.md lists what is read"
ONE = "give each feature one name or place: of one list or object, or as a parameter of its own"
WORDS = {
    "Part": "the observation", "Extreme": "the least or the largest of several features",
    "NoneType": "None", "str": "a text", "dict": "a dictionary", "Instance": "an object", "Stream": "an iterator",
    "EnumType": "an Enum", "Array": "an array",
    "Feature": "a feature", "Test": "a condition", "Condition": "a condition",
}  # fmt: skip


class Refused(InputError):
    """Something cannot be read. Whoever evaluates the node says where it is."""

    def __init__(self, what: str, advice: str, where: str = "") -> None:
        super().__init__(what, where, advice)


@dataclass(frozen=True)
class Part:
    """The observation, or what stands at a path of keys in it; `steps`: the conversions of each of its numbers."""

    path: tuple[int | str, ...]
    steps: tuple[Step, ...] = ()
    array: bool = False  # whether it was made an array of NumPy


@dataclass(frozen=True)
class Condition:
    """A truth value that is decided where it is needed: whether all (or any) of its parts hold, or whether not."""

    every: bool
    parts: tuple[Any, ...]
    wanted: bool = True


CONDITIONS = (Test, Condition)


@dataclass(frozen=True)
class Extreme:
    """The least or the largest of several features and numbers."""

    least: bool
    parts: tuple[Any, ...]


class Array(list[Any]):
    """A row of an array of NumPy: it is looked up in, gone through and returned, and nothing else."""


class Stream(list[Any]):
    """The items of an iterator. It is used where it is made: by a loop, or as the argument of what takes it apart."""


@dataclass(eq=False)
class Function:
    """A function or lambda of the file."""

    name: str
    node: ast.FunctionDef | ast.Lambda
    scope: Scope  # where it stands
    signature: Signature
    kind: str = ""  # "", "staticmethod", "classmethod" or "property"
    local: frozenset[str] = frozenset()  # names that it assigns


@dataclass(eq=False)
class Class:
    """A class of the file that is no Enum."""

    name: str
    members: dict[str, Any]
    fields: tuple[str, ...] = ()  # of a dataclass or named tuple, in their order


@dataclass(eq=False)
class Instance:
    """An object of a class of the file."""

    kind: Class
    attributes: dict[str, Any] = field(default_factory=dict[str, Any])


@dataclass(frozen=True)
class Bound:
    """A function of Python's, or a method of an object: `call` takes machine, arguments, named ones."""

    name: str
    call: Callable[..., Any]


FACTORY = "default_factory"  # the name of a default of a field that is made anew for each object


@dataclass(frozen=True)
class Module:
    """A module that is known: math, numpy and so on."""

    name: str
    members: Mapping[str, Any]


def words_of(value: Any) -> str:
    """Returns the kind of a value, in words."""
    return WORDS.get(type(value).__name__, f"a {type(value).__name__.lower()}")


# --- the observation


@dataclass
class Inputs:
    """The inputs that a function reads: one parameter that holds all numbers, or a parameter for each."""

    parameters: tuple[str, ...]
    width: int = 0  # how many numbers a sole parameter holds; 0: nobody says
    names: tuple[str, ...] = ()  # of all of them
    places: dict[tuple[int | str, ...], int] = field(default_factory=dict[tuple[int | str, ...], int])
    inner: type | None = None  # int or str: what the numbers of a sole parameter are looked up by
    n_read: int = 0  # numbers up to the last one that is looked at
    first: int = 0  # inputs before them: what is remembered

    def number(self, part: Part) -> int:
        """The place of a part that is used as a number."""
        if len(part.path) == 1 and self.inner:
            raise Refused(f"{text_of_path(part.path)} is used as a number and as a list of numbers", ONE)
        return self.first + self.places.setdefault(part.path, len(self.places))

    def count_names(self, names: Sequence[str]) -> None:
        """Takes the number of names for that of features, and the names for theirs if there is one for each."""
        if self.width and self.width != len(names):
            raise Refused(f"{len(names)} names for {self.width} features", "give each feature a name: a, b = x")
        self.width = len(names)
        features = tuple(f"x{place}" if name == "_" else name for place, name in enumerate(names))
        if all(names) and len(set(features)) == len(features):
            self.names = self.names or features

    def enter(self, part: Part, key: int | str) -> Part:
        """The number that stands at a key."""
        path = (*part.path, key)
        if len(path) > 2 or len(self.parameters) > 1:
            raise Refused(f"{text_of_path(path)} is looked up within one of several things that are given", ONE)
        if part.path in self.places:
            raise Refused(f"{text_of_path(part.path)} is used as a number and as a list of numbers", ONE)
        self.inner = self.inner or type(key)
        if self.inner is not type(key):
            raise Refused(f"{text_of_path(part.path)} is read by numbers and by names", "use one of both everywhere")
        if isinstance(key, int):
            if key < 0 and not self.width:
                what = (
                    f"{text_of_path(path)} counts from the end, and the file does not say how many features there are"
                )
                raise Refused(what, "count from the front, or name all features: --features a,b,c")
            key = key + self.width if key < 0 else key
            if not 0 <= key < (self.width or MAX_FEATURES):
                raise Refused(f"{text_of_path(path)} is beyond the observation", f"it has {self.width} numbers")
            self.n_read = max(self.n_read, key + 1)
        return Part((*part.path, key), part.steps)

    def describe_inputs(self, plain: Described) -> Described:
        """The description with the features and their order."""
        several, last = len(self.parameters) > 1, [path[-1] for path in self.places]
        if several or self.parameters in self.places:
            places = [self.parameters.index(str(each)) for each in last]
            return replace(plain, places=places, features=self.parameters, n_features=len(self.parameters))
        if self.inner is not str:
            places = [int(each) for each in last]
            return replace(plain, places=places, features=self.names, n_features=self.width, n_read=self.n_read)
        features = list(dict.fromkeys([*self.names, *map(str, last)]))
        return replace(plain, places=[features.index(str(each)) for each in last], features=features, keyed=True)

    def shape_parameters(self, described: Described) -> dict[str, Any]:
        """Returns what each parameter is given: the place of a feature, "row" for all, places by name."""
        shapes: dict[str, Any] = {name: place for place, name in enumerate(self.parameters)}
        if len(shapes) == 1 and self.parameters not in self.places:
            keys = [path[1] for path in self.places]
            by_name = dict(zip(keys, described.places, strict=True))
            shapes = {self.parameters[0]: by_name if self.inner is str else "row"}
        return shapes


def text_of_path(path: Sequence[int | str]) -> str:
    """A path as Python."""
    return escape_text(str(path[0])) + "".join(f"[{escape_text(repr(key))}]" for key in path[1:])


# --- operators

MAX_BITS = 1 << 12
LARGEST = float(np.finfo(np.float64).max)
OPERATIONS: Mapping[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv, ast.Mod: operator.mod, ast.Pow: operator.pow, ast.LShift: operator.lshift,
    ast.RShift: operator.rshift, ast.BitAnd: operator.and_, ast.BitOr: operator.or_, ast.BitXor: operator.xor,
}  # fmt: skip
FORMS: Mapping[type[ast.operator], str] = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}
COMPARISONS: Mapping[type[ast.cmpop], str] = {
    ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!=",
}  # fmt: skip
OTHERWISE = {
    ast.Pow: "write x * x, which does not fail where it is too large, or compare the feature itself",
    ast.FloorDiv: "write math.floor(x / c)",
    ast.Mod: "give the remainder as a feature of its own",
    ast.Div: "compare the feature itself: 1 / x > c says 0 < x < 1 / c",
}
SEVERAL = "test each feature alone, or give the {} as a feature of its own"
NUMBERS = (int, float, np.number)
FIXED = (type(None), *NUMBERS, str, range, enum.Enum)


def is_number(value: Any) -> bool:
    """Returns True if it is a constant number."""
    return isinstance(value, NUMBERS)


def is_constant(value: Any) -> bool:
    """Returns True if a value depends on no feature, and Python itself may compare it."""
    if isinstance(value, tuple | list | frozenset):
        return not isinstance(value, Array) and all(map(is_constant, value))
    if isinstance(value, dict):
        return all(map(is_constant, (*value, *value.values())))
    return isinstance(value, FIXED)


# --- arithmetic


def binary(m: Any, kind: type[ast.operator], left: Any, right: Any) -> Any:
    """Computes `left operator right`."""
    if isinstance(left, CONDITIONS) or isinstance(right, CONDITIONS):
        # a condition counts as 0 or 1; `&`, `|` and `^` of two are one, too
        if all(isinstance(each, (*CONDITIONS, bool)) for each in (left, right)):
            if kind in (ast.BitAnd, ast.BitOr):
                return Condition(kind is ast.BitAnd, (left, right))
            if kind is ast.BitXor:
                return compare_values(m, "!=", left, right)
            m.ensure_plain()
        counted = [int(m.truth(each)) if isinstance(each, CONDITIONS) else each for each in (left, right)]
        return binary(m, kind, *counted)
    left, right = m.plain(left), m.plain(right)
    if kind is ast.MatMult:
        raise Refused("a product of arrays is computed, which NumPy adds in an order of its own", IN_ORDER)
    for each in (left, right):
        if isinstance(each, Array) or not isinstance(each, (Feature, *NUMBERS, str, list, tuple)):
            raise Refused(f"arithmetic is done on {words_of(each)}", "do it on each number")
    if isinstance(left, Feature) and isinstance(right, Feature):
        return _join_features(m, kind, left, right)
    if isinstance(left, Feature) or isinstance(right, Feature):
        return _of_feature(m, kind, left, right)
    # constants are computed by Python itself; with limits on what it may make
    if kind in (ast.Pow, ast.LShift) and all(isinstance(each, int) for each in (left, right)):
        bits = right if kind is ast.LShift else right * max(int(left).bit_length(), 1)
        if abs(bits) > MAX_BITS:
            raise Refused("a number is too large", f"keep whole numbers below {MAX_BITS} bits")
    if kind is not ast.Add and (isinstance(left, str) or isinstance(right, str)):
        raise Refused("a text is formatted or repeated", "write the text itself")
    items = [each for each in (left, right) if isinstance(each, list | tuple)]
    times = [each for each in (left, right) if isinstance(each, int)]
    if kind is ast.Mult and items and times and len(items[0]) * max(times[0], 0) > MAX_ITEMS:
        raise Refused("a list is too long", f"keep it below {MAX_ITEMS} parts")
    constant = OPERATIONS[kind](left, right)
    if isinstance(constant, complex) or (isinstance(constant, int) and constant.bit_length() > MAX_BITS):
        raise Refused("a number is too large, or complex", "write the result itself")
    return m.keep_value(constant) if isinstance(constant, list | tuple | str) else constant


def _join_features(m: Any, kind: type[ast.operator], left: Feature, right: Feature) -> Any:
    """Arithmetic on two features: whole numbers, a square, or a sum."""
    if is_whole(left) and is_whole(right):
        return binary(m, kind, left, m.whole(right))
    one, other = m.resolve_memory(left), m.resolve_memory(right)
    if one is not left or other is not right:
        return binary(m, kind, one, other)
    if kind is ast.Mult and left.key == right.key:
        return compute(m, left, Step("square", lambda value: value * value, FOLDING))
    if kind not in (ast.Add, ast.Sub):
        word = {ast.Mult: "product", ast.Div: "quotient"}.get(kind, "combination")
        raise Refused(f"the {word} of two features is computed", SEVERAL.format(word))
    joined = m.sums.add_features(left, right, "-" if kind is ast.Sub else "+")
    if joined is None:
        cut = any(step.form and step.form[0] in CUTTING for each in (left, right) for step in each.steps)
        raise Refused("what is added is no sum", IN_ORDER + CUT_BEFORE if cut else IN_ORDER)
    m.sums.line = m.sums.line or m.line
    return joined


def _of_feature(m: Any, kind: type[ast.operator], left: Any, right: Any) -> Any:
    """Arithmetic on a feature and a number."""
    turned = isinstance(right, Feature)
    feature, number = (right, left) if turned else (left, right)
    if not is_number(number):
        raise Refused("a feature is combined with something that is no number", TEST_ADVICE)
    feature = convert_feature(m, feature)
    if is_whole(feature) and isinstance(number, int) and kind is ast.Mult and number == 0:
        return 0
    sample = feature.value(1.0)
    near = _near(sample if isinstance(sample, np.floating) else 1.0, number)
    # else it keeps no order of floats, or makes a NaN
    if near is None or not math.isfinite(near) or (near == 0 and kind not in (ast.Add, ast.Sub)):
        raise Refused("a feature is combined with 0, an infinite or a too large number", "write the result itself")
    if kind not in (ast.Add, ast.Sub, ast.Mult, *(() if turned else (ast.Div,))):
        said = "a number is divided by a feature" if turned else f"{kind.__name__.lower()} of a feature is asked"
        raise Refused(said, OTHERWISE.get(kind, TEST_ADVICE))
    key = f"{kind.__name__}{turned:d}{type(number).__name__}{number!r}"
    return compute(m, feature, arithmetic_step(key, FORMS[kind], number, OPERATIONS[kind], turned=turned))


def step_of(kind: str) -> tuple[Step, ...]:
    """The conversion that an array of NumPy has done, if it is one."""
    return (Step(kind, np.dtype(kind).type),) if kind else ()


def convert_feature(m: Any, feature: Feature) -> Feature:
    """The feature as the scalar that Python computes with."""
    return feature if feature.steps else feature.then(*step_of(m.kind))


def compute(m: Any, feature: Feature, step: Step) -> Feature:
    """The feature behind a step. InputError where Python fails for large numbers, as it does for int(x) * 9 / 2."""
    after = convert_feature(m, feature).then(step)
    try:
        for end in (LARGEST, -LARGEST):
            after.value(end)
    except OverflowError:
        raise Refused("this fails where the feature is large", "cut it first: min(max(x, -1000), 1000)") from None
    return after


def unary(m: Any, kind: type[ast.unaryop], value: Any) -> Any:
    """Computes `-value`, `+value` or `~value`."""
    if isinstance(value, CONDITIONS) and kind is ast.Invert:
        raise Refused("~ of a condition is not understood", "write not")
    value = m.decide(value)
    if isinstance(value, Feature) and kind is not ast.Invert:
        return value if kind is ast.UAdd else binary(m, ast.Mult, value, -1)
    if isinstance(value, int) or (isinstance(value, float | np.number) and kind is not ast.Invert):
        return -value if kind is ast.USub else +value if kind is ast.UAdd else ~value  # type: ignore[operator]
    raise Refused(f"a sign stands before {words_of(value)}", TEST_ADVICE)


# --- comparisons


def compare_values(m: Any, sign: str, left: Any, right: Any) -> Any:
    """Compares `left sign right`: a test of a feature, a condition, or a constant."""
    m.count()
    if isinstance(left, Feature | Part) and type(right) in (int, float):  # most are this
        return _with_number(m, m.plain(left), sign, right)
    if isinstance(left, CONDITIONS) or isinstance(right, CONDITIONS):  # which count as 0 or 1
        one, other = (m.truth(each) if isinstance(each, CONDITIONS) else each for each in (left, right))
        return Condition(True, (compare_values(m, sign, one, other),))
    left, right = m.plain(left), m.plain(right)
    if is_constant(left) and is_constant(right):
        answer = SIGNS[sign](left, right)
        return Condition(True, (bool(answer),)) if isinstance(answer, np.generic) else bool(answer)
    if isinstance(left, tuple) and isinstance(right, tuple) and sign in ("==", "!="):
        if len(left) != len(right):
            return sign == "!="
        m.forget_nan()  # which is equal to itself there
        pairs = tuple(compare_values(m, "==", a, b) for a, b in zip(left, right, strict=True))
        return Condition(True, pairs, sign == "==")
    for one, other, said in ((left, right, sign), (right, left, TURNED[sign])):
        if isinstance(one, Extreme) and (is_number(other) or isinstance(other, Feature)):
            if sign in ("==", "!="):
                raise Refused("the least or largest of several is asked what it equals", "compare it by < or >")
            m.forget_nan()  # what Python takes for the least beside a NaN depends on their order
            every = one.least != (said in ("<", "<="))
            return Condition(every, tuple(compare_values(m, said, each, other) for each in one.parts))
        if isinstance(one, Feature) and not isinstance(other, Feature | Extreme):
            return _with_number(m, one, said, other)
    if isinstance(left, Feature) and isinstance(right, Feature):
        if left.key == right.key:
            m.forget_nan()  # it is asked for
            return sign in ("==", "<=", ">=")
        if is_whole(left) and is_whole(right):
            return compare_values(m, sign, left, m.whole(right))
        one, other = m.resolve_memory(left), m.resolve_memory(right)
        if one is not left or other is not right:
            return compare_values(m, sign, one, other)
        # the sign of a difference is that of the comparison, unless both are the same infinity
        left, right = _unfold(m, left), _unfold(m, right)
        difference = m.sums.add_features(left, right, "<")
        if difference is None and left.place == right.place:
            advice = "solve it for the feature, and compare that with one number"
            raise Refused("two numbers that are computed of one feature are compared", advice)
        if difference is None:
            raise Refused("two features are compared", SEVERAL.format("difference"))
        m.finite = True
        m.sums.line = m.sums.line or m.line
        return _with_number(m, difference, sign, 0.0)
    what = f"{words_of(left)} and {words_of(right)} are compared, which have no order"
    raise Refused(what, "compare one feature with a number")


def _unfold(m: Any, feature: Feature) -> Feature:
    """A feature without the `abs` that ends it: with its sign turned where it is negative, which is exact."""
    if not feature.steps or not feature.steps[-1].key.endswith("abs"):
        return feature
    before = Feature(feature.place, feature.steps[:-1])
    return binary(m, ast.Mult, before, -1) if m.truth(compare_values(m, "<", before, 0)) else before


def _with_number(m: Any, feature: Feature, sign: str, number: Any) -> Any:
    """A test of a feature."""
    if type(number) is float and not feature.steps and not m.kind and number == number:  # most are this
        return Test(feature, sign, number)
    if not is_number(number):
        if number is None and sign in ("==", "!="):
            return sign == "!="
        words = "with a text" if isinstance(number, str) else "with what is no number"
        raise Refused(f"a feature is compared {words}", "features are numbers: compare with a number")
    if isinstance(number, np.integer):
        number = np.float64(number)
    if isinstance(number, float | np.floating) and math.isnan(number):
        return sign == "!="
    sample = np.dtype(m.kind).type(1) if m.kind and not feature.steps else feature.value(1.0)
    if isinstance(sample, np.floating) and not isinstance(number, np.floating):
        near = _near(sample, number)
        if near is None:
            raise Refused(f"a number is beyond {sample.dtype}", "write a smaller one; NumPy warns of it, too")
        number = number if feature.steps else near  # steps may give Python's numbers, too, as max(x, 0.5) does
    elif isinstance(number, int) and isinstance(sample, float) and at_most(number) != number:
        m.ask_arrays("a feature is compared with a whole number that no double equals")
    if not feature.steps:
        number = number if isinstance(number, int) and not isinstance(number, bool) else float(number)
    return Test(feature, sign, number)


def _near(sample: Any, number: Any) -> Any:
    """The number as NumPy compares it with a scalar of its own; None beyond the largest."""
    try:
        with np.errstate(over="ignore", under="ignore"):
            near = type(sample)(number)
    except OverflowError:
        return None
    return near if np.isfinite(near) or (isinstance(number, float) and math.isinf(number)) else None


# --- functions of one number


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


def _refuse_whole(m: Any, feature: Feature) -> None:
    """Refuses a function of NumPy of Python's whole number: what it gives has 64 bits, and later sums wrap."""
    if is_whole(feature):
        what = "a whole number, as int() or round() gives it, is given to NumPy"
        raise Refused(what, "use abs, min or max, which keep it whole")


def _call_step(name: str, m: Any, given: Given, named: Named) -> Any:
    """A function of one number: of a constant, computed by Python itself."""
    apply, sense = STEPS[name]
    counts = name in ("int", "float")  # which make the same number of a condition among floats and arrays
    given = [m.truth(each) if counts and isinstance(each, CONDITIONS) else m.decide(each) for each in given]
    if given and isinstance(given[0], Feature):
        if len(given) > 1 or named or not sense:
            raise Refused(f"{name} of a feature, or with further arguments, is not understood", STATED)
        if name in ("numpy.abs", "numpy.deg2rad", "numpy.rad2deg"):
            _refuse_whole(m, given[0])
        m.finite |= name in WHOLE
        return compute(m, given[0], Step(name, apply, sense))
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
    if function not in (min, max):
        _refuse_whole(m, feature)
    kind = "max" if function in (max, np.maximum) else "min"
    keeps = first and function in (max, min)  # of equal ones Python's give the first; NumPy's depend on the processor
    apply = (lambda value: function(value, number)) if first else partial(function, number)
    key = f"{function.__name__}{first:d}{type(number).__name__}{number!r}"
    return compute(m, feature, Step(key, apply, form=(kind, number, keeps)))


def _clip(m: Any, given: Given, named: Named) -> Any:
    """np.clip, of one number."""
    if len(given) == 1 and named.keys() == {"a_min", "a_max"}:
        given, named = [*given, named["a_min"], named["a_max"]], {}
    value, *ends = map(m.decide, given)
    if named or len(ends) != 2 or not all(map(is_number, ends)) or not isinstance(value, Feature | int | float):
        raise Refused("a whole array is clipped, or by what is no number", "write np.clip(x[0], low, high)")
    if not isinstance(value, Feature):
        return np.clip(value, *ends)
    _refuse_whole(m, value)
    key = f"clip{','.join(f'{type(end).__name__}{end!r}' for end in ends)}"
    step = Step(key, lambda given: np.clip(given, *ends), form=("clip", tuple(ends), True))
    return compute(m, value, step)


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
        if not isinstance(total, int) and not (isinstance(total, Feature) and is_whole(total)):
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
    return Bound(FACTORY, lambda m, given, _: m.call(named["default_factory"], given, {}))


def _refuse_call(m: Any, given: Given, named: Named) -> Any:
    """Refuses a call of what stands in class statements only."""
    raise Refused("this is called", STATED)


# --- the tables


CALLS: Mapping[str, Call] = {
    **{name: partial(_call_step, name) for name in STEPS},
    **dict.fromkeys(("object", "str", "enum.unique", "dataclasses.dataclass"), _refuse_call),
    **dict.fromkeys(("typing.NamedTuple", "typing.TypedDict", "typing.Protocol"), _refuse_call),
    **dict.fromkeys(
        ("print", "logging.debug", "logging.info", "logging.warning", "logging.error"), lambda m, given, named: None
    ),
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
