"""Arithmetic and comparisons of Python, of constants and of features.

Does: computes with constants as Python does, within limits; makes steps of arithmetic on one feature, and tests of
  comparisons.
Assumes: float arithmetic of this machine is IEEE 754, as that of NumPy is.
Does not: evaluate nodes.

Steps compute with Python's own floats, or NumPy's scalars where the observation is an array, so a threshold that is
found through them is that of Python, to the last bit.
"""

# pyright: basic
# the values of a program may be anything
import ast
import math
import operator
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from codegen.importers.python.machine import MAX_ITEMS, TEST_ADVICE, Machine, step_of
from codegen.importers.python.values import Array, Condition, Extreme, Instance, Length, Member, Part, Symbol, Unread
from codegen.importers.symbolic.affine import CUT_BEFORE, IN_ORDER
from codegen.importers.symbolic.feature import FALLING, FOLDING, RISING, SIGNS, TURNED, Feature, Step, Test
from codegen.importers.symbolic.line import at_most

MAX_BITS = 1 << 12
OPERATIONS: Mapping[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv, ast.Mod: operator.mod, ast.Pow: operator.pow, ast.LShift: operator.lshift,
    ast.RShift: operator.rshift, ast.BitAnd: operator.and_, ast.BitOr: operator.or_, ast.BitXor: operator.xor,
}  # fmt: skip
CUTS = ("clip", "min", "max")  # steps that cut a number
NAMES: Mapping[type[ast.operator], str] = {ast.Mult: "product", ast.Div: "quotient"}
FORMS: Mapping[type[ast.operator], str] = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}
COMPARISONS: Mapping[type[ast.cmpop], str] = {
    ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!=",
}  # fmt: skip
POWERS = range(2, 17)
SEVERAL = "test each feature alone, or give the {} as a feature of its own"


# --- arithmetic


def binary(m: Machine, kind: type[ast.operator], left: Any, right: Any) -> Any:
    """What `left operator right` is."""
    if (isinstance(left, Part) and _is_number(right)) or (isinstance(right, Part) and _is_number(left)):
        return _of_part(m, kind, left, right)
    if kind in (ast.BitAnd, ast.BitOr) and any(isinstance(each, Test | Condition) for each in (left, right)):
        return Condition(lambda: (all if kind is ast.BitAnd else any)([m.truth(left), m.truth(right)]))
    left, right = m.plain(left), m.plain(right)
    if kind is ast.MatMult:
        return m.unread("a product of arrays is computed, which NumPy adds in an order of its own", IN_ORDER)
    for each in (left, right):
        if isinstance(each, Symbol):
            return m.unread(f"the name {each.name!r} is not defined in the file", "write the number itself")
        if isinstance(each, Unread):
            return each
    if isinstance(left, Array) or isinstance(right, Array):
        return _elementwise(m, lambda a, b: binary(m, kind, a, b), left, right)
    if isinstance(left, Extreme) or isinstance(right, Extreme):
        return _of_extreme(m, kind, left, right)
    if isinstance(left, Feature) and isinstance(right, Feature):
        if m.counts(left) and m.counts(right):
            return binary(m, kind, left, m.whole(right))
        if kind is ast.Mult and left.key == right.key:
            return convert_feature(m, left).then(Step("square", lambda value: value * value, FOLDING))
        if kind in (ast.Add, ast.Sub):
            joined = m.sums.add_features(left, right, minus=kind is ast.Sub)
            if joined is None:
                cut = any(step.form and step.form[0] in CUTS for each in (left, right) for step in each.steps)
                advice = IN_ORDER + CUT_BEFORE if cut else IN_ORDER
                return m.unread("two sums are joined whose roundings have no order", advice)
            m.sums.line = m.sums.line or m.line
            return joined
        word = NAMES.get(kind, "combination")
        return m.unread(f"the {word} of two features is computed", SEVERAL.format(word))
    if isinstance(left, Feature) or isinstance(right, Feature):
        return of_feature(m, kind, left, right)
    return _of_constants(m, kind, left, right)


def _is_number(value: Any) -> bool:
    value = value.value if isinstance(value, Member) and value.kind.mixed else value
    return isinstance(value, int | float | np.number)


def _of_constants(m: Machine, kind: type[ast.operator], left: Any, right: Any) -> Any:
    """Arithmetic on constants, by Python itself; with limits on what it may make."""
    if kind in (ast.Pow, ast.LShift) and all(isinstance(each, int) for each in (left, right)):
        bits = right if kind is ast.LShift else right * max(int(left).bit_length(), 1)
        if abs(bits) > MAX_BITS:
            return m.unread("a number is too large", f"keep whole numbers below {MAX_BITS} bits")
    items = [each for each in (left, right) if isinstance(each, str | list | tuple)]
    if any(isinstance(one, Part | Feature) for each in items for one in each):
        return m.unread("arithmetic is done on a part of the observation", "do it on each number")
    times = [each for each in (left, right) if isinstance(each, int)]
    if kind is ast.Mult and items and times and len(items[0]) * max(times[0], 0) > MAX_ITEMS:
        return m.unread("a list or text is too long", f"keep it below {MAX_ITEMS} parts")
    if kind is ast.Mod and isinstance(left, str):
        return m.unread("a text is formatted", "write the text itself")
    try:
        constant = OPERATIONS[kind](left, right)
    except ZeroDivisionError:
        return m.unread("a number is divided by 0", "mend it")
    except (TypeError, ValueError, OverflowError, KeyError):
        return m.unread("an operation on constants is not understood", "write the result itself")
    if isinstance(constant, complex) or (isinstance(constant, int) and constant.bit_length() > MAX_BITS):
        return m.unread("a number is too large, or complex", "write the result itself")
    return m.keep_value(constant) if isinstance(constant, list | tuple | str | set | dict) else constant


def of_feature(m: Machine, kind: type[ast.operator], left: Any, right: Any) -> Any:
    """Arithmetic on a feature and a number."""
    turned = isinstance(right, Feature)
    feature, number = (right, left) if turned else (left, right)
    if not _is_number(number):
        return m.unread("a feature is combined with something that is no number", TEST_ADVICE)
    feature = convert_feature(m, feature)
    if kind is ast.Mult and number == 0 and isinstance(number, int) and m.counts(feature):
        return 0
    if not _usable(number, feature.value(1.0), kind):
        return m.unread("a feature is combined with 0, an infinite or a too large number", "write the result itself")
    sense = RISING if kind in (ast.Add, ast.Sub) or number > 0 else FALLING
    if kind is ast.Sub and turned:
        sense = FALLING
    if kind is ast.Pow and not turned and number in POWERS:
        return feature.then(Step(f"power {number!r}", partial(_power, number), RISING if number % 2 else FOLDING))
    whole = m.counts(feature) and isinstance(number, int)
    if kind is ast.Mod and whole and not turned:
        return m.whole(feature) % number
    if kind is ast.FloorDiv and not turned and not whole and math.frexp(number)[0] == 0.5:
        m.finite = True  # of infinities Python gives NaN
        # of a power of 2, which rounds nothing
        return feature.then(Step(f"floor {number!r}", partial(apply_finite, lambda value: value // number)))
    allowed = (ast.Add, ast.Sub, ast.Mult, *(() if turned else (ast.Div,)))
    if kind not in allowed and not (kind is ast.FloorDiv and whole and not turned):
        return _refuse_operator(m, kind, turned)
    operate = OPERATIONS[kind]
    apply = partial(operate, number) if turned else lambda value: operate(value, number)
    sign = FORMS.get(kind)
    form = ("c-" if kind is ast.Sub and turned else sign, number) if sign else None
    return feature.then(Step(f"{kind.__name__}{turned:d}{type(number).__name__}{number!r}", apply, sense, form=form))


def _power(number: Any, value: Any) -> Any:
    """`value ** number` by Python's or NumPy's own power, whose error is too small to change the order of powers;
    infinite where Python gives up.
    """
    try:
        return value**number
    except OverflowError:
        return math.inf if value > 0 or number % 2 == 0 else -math.inf


def apply_finite(function: Callable[[Any], Any], value: Any) -> Any:
    """A whole number of a finite number; what is infinite, or NaN, stays so, where Python gives up."""
    return function(value) if math.isfinite(value) else value


def _usable(number: Any, sample: Any, kind: type[ast.operator]) -> bool:
    """Whether arithmetic with a number keeps the order of floats and makes no NaN."""
    near = _near(sample if isinstance(sample, np.floating) else 1.0, number)
    return near is not None and math.isfinite(near) and bool(near != 0 or kind in (ast.Add, ast.Sub))


def _refuse_operator(m: Machine, kind: type[ast.operator], turned: bool) -> Unread:
    advice = {
        ast.Pow: f"give a whole number from 2 to {POWERS[-1]} as the power, or compare the feature itself",
        ast.FloorDiv: "write math.floor(x / c)",
        ast.Mod: "give the remainder as a feature of its own",
        ast.Div: "compare the feature itself: 1 / x > c says 0 < x < 1 / c",
    }
    what = "a number is divided by a feature" if turned and kind is ast.Div else f"{kind.__name__.lower()} of a feature"
    return m.unread(f"{what} is not understood", advice.get(kind, TEST_ADVICE))


def convert_feature(m: Machine, feature: Feature) -> Feature:
    """The feature as the scalar that Python computes with."""
    return feature if feature.steps else feature.then(*step_of(m.arrays))


def _of_part(m: Machine, kind: type[ast.operator], left: Any, right: Any) -> Any:
    """Arithmetic on the observation, of which nobody knows yet whether it is a number or an array of them."""
    turned = isinstance(right, Part)
    part: Part = right if turned else left
    sides = (left, Feature(-1, part.steps)) if turned else (Feature(-1, part.steps), right)
    feature = of_feature(m, kind, *(m.plain(each) if isinstance(each, Member) else each for each in sides))
    return replace(part, steps=feature.steps, scaled=True) if isinstance(feature, Feature) else feature


def _elementwise(m: Machine, function: Callable[[Any, Any], Any], left: Any, right: Any) -> Any:
    """An operation on constant arrays, element by element."""
    given = [each if isinstance(each, list) else None for each in (left, right)]
    length = max(len(each) for each in given if each is not None)
    if any(each is not None and len(each) != length for each in given):
        return m.unread("arrays of different lengths are combined", "write the result itself")
    m.count(length)
    pairs = zip(
        *(each if each is not None else [other] * length for each, other in zip(given, (left, right), strict=True)),
        strict=True,
    )
    return m.keep_value(Array(function(a, b) for a, b in pairs))


def _of_extreme(m: Machine, kind: type[ast.operator], left: Any, right: Any) -> Any:
    """Arithmetic on the least or largest of several: on each of them."""
    turned = isinstance(right, Extreme)
    extreme, number = (right, left) if turned else (left, right)
    if not _is_number(number):
        return m.unread("several features are combined", SEVERAL.format("result"))
    parts = tuple(binary(m, kind, *((number, each) if turned else (each, number))) for each in extreme.parts)
    unread = next((each for each in parts if isinstance(each, Unread)), None)
    falls = (turned and kind is ast.Sub) or (kind in (ast.Mult, ast.Div) and number < 0)
    return unread or Extreme(extreme.least != falls, parts)


def unary(m: Machine, kind: type[ast.unaryop], value: Any) -> Any:
    """What `-value`, `+value` or `~value` is."""
    if isinstance(value, Test | Condition) and kind is ast.Invert:
        return m.unread("~ of a condition is not understood", "write not")
    if isinstance(value, Part) and kind is not ast.Invert:
        return value if kind is ast.UAdd else _of_part(m, ast.Mult, value, -1)
    value = m.plain(value)
    if isinstance(value, Feature | Extreme) and kind is not ast.Invert:
        return value if kind is ast.UAdd else binary(m, ast.Mult, value, -1)
    if isinstance(value, Array):
        return m.keep_value(Array(unary(m, kind, each) for each in value))
    if isinstance(value, int) or (isinstance(value, float | np.number) and kind is not ast.Invert):
        return -value if kind is ast.USub else +value if kind is ast.UAdd else ~value  # type: ignore[operator]
    return value if isinstance(value, Unread) else m.unread("a sign stands before what is no number", TEST_ADVICE)


# --- comparisons


def compare_values(m: Machine, sign: str, left: Any, right: Any) -> Any:
    """What `left sign right` is: a test of a feature, a condition, or a constant."""
    m.count()
    if isinstance(left, Length) or isinstance(right, Length):
        return _of_length(m, sign, left, right)
    left, right = (each if isinstance(each, Symbol) else m.plain(each) for each in (left, right))
    for each in (left, right):
        if isinstance(each, Unread):
            return each
    if isinstance(left, Array) or isinstance(right, Array):
        return _elementwise(m, lambda a, b: compare_values(m, sign, a, b), left, right)
    if isinstance(left, tuple | list) and isinstance(right, tuple | list) and sign in ("==", "!="):
        if len(left) != len(right):
            return sign == "!="
        pairs = [compare_values(m, "==", a, b) for a, b in zip(left, right, strict=True)]
        return Condition(lambda: all(m.truth(each) for each in pairs) == (sign == "=="))
    if any(isinstance(each, Instance) for each in (left, right)):
        if left is not right:
            return m.unread("objects are compared", "compare their attributes")
        return sign in ("==", "<=", ">=")
    for one, other, said in ((left, right, sign), (right, left, TURNED[sign])):
        if isinstance(one, Extreme) and _is_number(other):
            return _extreme_compared(m, one, said, other)
        if isinstance(one, Feature) and not isinstance(other, Feature | Extreme):
            return _with_number(m, one, said, other)
    if isinstance(left, Feature) and isinstance(right, Feature) and left.key == right.key:
        if m.paths is not None:
            m.paths.nan = False  # it is asked whether a number is NaN
        return sign in ("==", "<=", ">=")
    if isinstance(left, Feature) and isinstance(right, Feature):
        return _two_compared(m, sign, left, right)
    if isinstance(left, Feature | Extreme) or isinstance(right, Feature | Extreme):
        return m.unread("two features are compared", SEVERAL.format("difference"))
    if isinstance(left, Symbol) or isinstance(right, Symbol):
        if sign not in ("==", "!="):
            m.require_value(left if isinstance(left, Symbol) else right)
        return (left == right) == (sign == "==")
    try:
        return bool(SIGNS[sign](left, right))
    except (TypeError, ValueError):
        return m.unread("constants that have no order are compared", "compare numbers with numbers")


def _two_compared(m: Machine, sign: str, left: Feature, right: Feature) -> Any:
    """A test of a difference, whose sign is that of the comparison, unless both are the same infinity."""
    if m.counts(left) and m.counts(right):
        return compare_values(m, sign, left, m.whole(right))
    difference = m.sums.add_features(left, right, minus=True)
    if difference is None and left.place == right.place:
        advice = "solve it for the feature, and compare that with one number"
        return m.unread("two numbers that are computed of one feature are compared", advice)
    if difference is None:
        return m.unread("two features are compared", SEVERAL.format("difference"))
    m.finite = True
    return _with_number(m, difference, sign, 0.0)


def _with_number(m: Machine, feature: Feature, sign: str, number: Any) -> Any:
    """A test of a feature."""
    if not _is_number(number):
        if number is None:
            return sign == "!="
        if isinstance(number, str | Member | Symbol) and sign in ("==", "!="):
            return m.unread("a feature is compared with a text", "features are numbers: compare with a number")
        return m.unread("a feature is compared with what is no number", TEST_ADVICE)
    if isinstance(number, float | np.floating) and math.isnan(number):
        return sign == "!="
    sample = np.dtype(m.arrays).type(1) if m.arrays and not feature.steps else feature.value(1.0)
    if isinstance(sample, np.floating) and not isinstance(number, np.floating):
        near = _near(sample, number)
        if near is None:
            return m.unread(f"a number is beyond {sample.dtype}", "write a smaller one; NumPy warns of it, too")
        number = near
    elif not feature.steps and isinstance(number, int):
        m.long |= at_most(number) != number
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


def _extreme_compared(m: Machine, extreme: Extreme, sign: str, number: Any) -> Any:
    """A test of the least or largest of several: of any of them, or of all."""
    if sign in ("==", "!="):
        within, beyond = ("<=", "<") if extreme.least else (">=", ">")
        parts = [_extreme_compared(m, extreme, each, number) for each in (within, beyond)]
        return Condition(lambda: (m.truth(parts[0]) and not m.truth(parts[1])) == (sign == "=="))
    one = any if extreme.least == (sign in ("<", "<=")) else all
    tests = [compare_values(m, sign, each, number) for each in extreme.parts]
    if m.paths is not None:
        m.paths.nan = False  # what Python takes for the least beside a NaN depends on their order
    return next((each for each in tests if isinstance(each, Unread)), None) or Condition(
        lambda: one(m.truth(each) for each in tests)
    )


def _of_length(m: Machine, sign: str, left: Any, right: Any) -> Any:
    """How many numbers the observation has: what the file expects of it."""
    length, number = (left, right) if isinstance(left, Length) else (right, left)
    known = m.inputs.length(length.part.path)
    if not isinstance(number, int):
        return m.unread("the length of the observation is compared with what is no number", "write the number")
    if isinstance(right, Length):
        sign = TURNED[sign]
    if not known and sign in ("==", "!="):
        m.inputs.widths[length.part.path] = known = number
        m.notes[f"line {m.line}: the observation is taken to have {number} numbers"] = None
    return bool(SIGNS[sign](known, number)) if known else sign in (">", ">=", "!=")
