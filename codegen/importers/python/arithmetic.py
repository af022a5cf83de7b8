"""Arithmetic and comparisons of Python, of constants and of features.

Does: computes with constants as Python does, within limits; makes steps of arithmetic on one feature, and tests of
  comparisons.
Assumes: float arithmetic of this machine is IEEE 754, as that of NumPy is.
Does not: evaluate nodes: `m` is the machine that does (machine.py), which knows features, counts and decides.

Steps compute with Python's own floats, or NumPy's scalars where the observation is an array, so a threshold that is
found through them is that of Python, to the last bit.
"""

# pyright: basic
# the values of a program may be anything
import ast
import enum
import math
import operator
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np

from codegen.importers.python.values import (
    CONDITIONS,
    MAX_ITEMS,
    TEST_ADVICE,
    Array,
    Condition,
    Extreme,
    Part,
    Refused,
    words_of,
)
from codegen.importers.symbolic.affine import CUT_BEFORE, CUTTING, IN_ORDER
from codegen.importers.symbolic.feature import FALLING, FOLDING, RISING, SIGNS, TURNED, Feature, Step, Test, at_most

MAX_BITS = 1 << 12
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
        return _join_conditions(m, kind, left, right)
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
    return _of_constants(m, kind, left, right)


def _join_conditions(m: Any, kind: type[ast.operator], left: Any, right: Any) -> Any:
    """Arithmetic where a condition counts as 0 or 1; `&`, `|` and `^` of two conditions are one, too."""
    if all(isinstance(each, (*CONDITIONS, bool)) for each in (left, right)):
        if kind in (ast.BitAnd, ast.BitOr):
            return Condition(kind is ast.BitAnd, (left, right))
        if kind is ast.BitXor:
            return compare_values(m, "!=", left, right)
        m.ensure_plain()
    return binary(m, kind, *(int(m.truth(each)) if isinstance(each, CONDITIONS) else each for each in (left, right)))


def _join_features(m: Any, kind: type[ast.operator], left: Feature, right: Feature) -> Any:
    """Arithmetic on two features: whole numbers, a square, or a sum."""
    if m.counts(left) and m.counts(right):
        return binary(m, kind, left, m.whole(right))
    if kind is ast.Mult and left.key == right.key:
        return convert_feature(m, left).then(Step("square", lambda value: value * value, FOLDING))
    if kind not in (ast.Add, ast.Sub):
        word = {ast.Mult: "product", ast.Div: "quotient"}.get(kind, "combination")
        raise Refused(f"the {word} of two features is computed", SEVERAL.format(word))
    joined = m.sums.add_features(left, right, minus=kind is ast.Sub)
    if joined is None:
        cut = any(step.form and step.form[0] in CUTTING for each in (left, right) for step in each.steps)
        raise Refused("two sums are joined whose roundings have no order", IN_ORDER + CUT_BEFORE if cut else IN_ORDER)
    m.sums.line = m.sums.line or m.line
    return joined


def _of_constants(m: Any, kind: type[ast.operator], left: Any, right: Any) -> Any:
    """Arithmetic on constants, by Python itself; with limits on what it may make."""
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


def _of_feature(m: Any, kind: type[ast.operator], left: Any, right: Any) -> Any:
    """Arithmetic on a feature and a number."""
    turned = isinstance(right, Feature)
    feature, number = (right, left) if turned else (left, right)
    if not is_number(number):
        raise Refused("a feature is combined with something that is no number", TEST_ADVICE)
    feature = convert_feature(m, feature)
    whole = m.counts(feature) and isinstance(number, int)
    if whole and kind is ast.Mult and number == 0:
        return 0
    sample = feature.value(1.0)
    near = _near(sample if isinstance(sample, np.floating) else 1.0, number)
    # else it keeps no order of floats, or makes a NaN
    if near is None or not math.isfinite(near) or (near == 0 and kind not in (ast.Add, ast.Sub)):
        raise Refused("a feature is combined with 0, an infinite or a too large number", "write the result itself")
    allowed = (ast.Add, ast.Sub, ast.Mult, *(() if turned else (ast.Div,)), *((ast.FloorDiv,) if whole else ()))
    if kind not in allowed:
        said = "a number is divided by a feature" if turned else f"{kind.__name__.lower()} of a feature is asked"
        raise Refused(said, OTHERWISE.get(kind, TEST_ADVICE))
    sense = FALLING if (kind is ast.Sub and turned) or (kind not in (ast.Add, ast.Sub) and number < 0) else RISING
    operate, sign = OPERATIONS[kind], FORMS.get(kind)
    apply = partial(operate, number) if turned else lambda value: operate(value, number)
    form = ("c-" if kind is ast.Sub and turned else sign, number) if sign else None
    return feature.then(Step(f"{kind.__name__}{turned:d}{type(number).__name__}{number!r}", apply, sense, form=form))


def step_of(kind: str) -> tuple[Step, ...]:
    """The conversion that an array of NumPy has done, if it is one."""
    return (Step(kind, np.dtype(kind).type),) if kind else ()


def convert_feature(m: Any, feature: Feature) -> Feature:
    """The feature as the scalar that Python computes with."""
    return feature if feature.steps else feature.then(*step_of(m.kind))


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
        return _two_compared(m, sign, left, right)
    what = f"{words_of(left)} and {words_of(right)} are compared, which have no order"
    raise Refused(what, "compare one feature with a number")


def _two_compared(m: Any, sign: str, left: Feature, right: Feature) -> Any:
    """A test of a difference, whose sign is that of the comparison, unless both are the same infinity."""
    if left.key == right.key:
        m.forget_nan()  # it is asked for
        return sign in ("==", "<=", ">=")
    if m.counts(left) and m.counts(right):
        return compare_values(m, sign, left, m.whole(right))
    left, right = _unfold(m, left), _unfold(m, right)
    difference = m.sums.add_features(left, right, minus=True)
    if difference is None and left.place == right.place:
        advice = "solve it for the feature, and compare that with one number"
        raise Refused("two numbers that are computed of one feature are compared", advice)
    if difference is None:
        raise Refused("two features are compared", SEVERAL.format("difference"))
    m.finite = True
    m.sums.line = m.sums.line or m.line
    return _with_number(m, difference, sign, 0.0)


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
        number = near
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
