"""What C's own headers give to a decision: constants, functions of numbers, copies of memory.

Does: fabs, fmin, fmax, floor and their like, of numbers and of features; memcpy and memset; skips what prints.
Assumes: IEEE 754; that functions of the standard library are not replaced.
Does not: compute what libraries round differently (sin, exp, pow), draw numbers, or read files.
"""

# pyright: basic
# pycparser's nodes have no declared attributes
import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from codegen.importers.c.arithmetic import TEST_ADVICE
from codegen.importers.c.kinds import (
    DOUBLE,
    FLOAT,
    INT,
    LLONG,
    LONG,
    SCHAR,
    SHORT,
    UCHAR,
    UINT,
    ULLONG,
    USHORT,
    Kind,
    Type,
    size_of,
)
from codegen.importers.c.values import Array, Condition, Number, Outside, Reference, Struct, Symbol, Value
from codegen.importers.symbolic.feature import Step

PRINTING = ["printf", "fprintf", "puts", "fputs", "putchar", "putc", "fputc", "fflush", "perror"]
SINGLE, HUGE = float(np.finfo(np.float32).max), float(np.finfo(np.float64).max)
CONSTANTS: Mapping[str, Number] = {
    "true": Number(1, INT, "true"), "false": Number(0, INT, "false"), "NULL": Number(0, INT),
    "M_PI": Number(np.float64(math.pi), DOUBLE), "M_PI_2": Number(np.float64(math.pi / 2), DOUBLE),
    "M_PI_4": Number(np.float64(math.pi / 4), DOUBLE), "M_E": Number(np.float64(math.e), DOUBLE),
    "INFINITY": Number(np.float32(math.inf), FLOAT), "HUGE_VAL": Number(np.float64(math.inf), DOUBLE),
    "FLT_MAX": Number(np.float32(SINGLE), FLOAT), "DBL_MAX": Number(np.float64(HUGE), DOUBLE),
    "FLT_MIN": Number(np.float32(2.0**-126), FLOAT), "DBL_MIN": Number(np.float64(2.0**-1022), DOUBLE),
    "FLT_EPSILON": Number(np.float32(2.0**-23), FLOAT), "DBL_EPSILON": Number(np.float64(2.0**-52), DOUBLE),
    **{f"{name}_MAX": Number(kind.high, kind if kind.rank >= INT.rank else INT) for name, kind in {
        "SCHAR": SCHAR, "UCHAR": UCHAR, "SHRT": SHORT, "USHRT": USHORT, "INT": INT, "UINT": UINT, "LLONG": LLONG,
        "INT8": SCHAR, "UINT8": UCHAR, "INT16": SHORT, "UINT16": USHORT, "INT32": INT, "UINT32": UINT,
        "INT64": LLONG, "ULLONG": ULLONG, "UINT64": ULLONG}.items()},
    **{f"{name}_MIN": Number(kind.low, kind if kind.rank >= INT.rank else INT) for name, kind in {
        "SCHAR": SCHAR, "SHRT": SHORT, "INT": INT, "INT8": SCHAR, "INT16": SHORT, "INT32": INT, "INT64": LLONG,
        "LLONG": LLONG}.items()},
    "EXIT_SUCCESS": Number(0, INT), "EXIT_FAILURE": Number(1, INT),
}  # fmt: skip
Handler = Callable[[Any, list[Any]], Value]


def _absolute(kind: Kind) -> Handler:
    return lambda machine, given: machine.arithmetic.absolute(machine.value(given[0]), kind)


def _extreme(most: bool, kind: Kind) -> Handler:
    return lambda machine, given: machine.arithmetic.extreme(most, [machine.value(each) for each in given[:2]], kind)


def _make_step(name: str, kind: Kind, compute: Callable[[Any], Any], *, rising: bool = True) -> Handler:
    """A function that never falls; one that is not `rising` takes numbers only."""

    def handler(machine: Any, given: list[Any]) -> Value:
        value = machine.arithmetic.plain(machine.arithmetic.convert_value(machine.value(given[0]), kind))
        make = kind.float_type
        if isinstance(value, Number):
            with np.errstate(all="ignore"):
                return Number(make(compute(make(value.value))), kind)
        if not rising:
            raise machine.make_error(f"the function {name} of a feature is not read", TEST_ADVICE)
        return Symbol(value.feature.then(Step(name, lambda v: make(compute(make(v))))), kind)

    return handler


def _round_away(v: Any) -> Any:
    """The nearest whole number, of two the one farther from 0."""
    whole = np.trunc(v)
    return whole + np.sign(v) if abs(v - whole) >= 0.5 else whole  # the difference is exact


def _to_long(name: str, kind: Kind) -> Handler:
    """The nearest whole number, as a long."""
    rounds = _make_step(name, kind, _round_away)
    return lambda machine, given: machine.arithmetic.convert_value(rounds(machine, given), LONG)


def _make_test(test: Callable[[Any, Value], Value]) -> Handler:
    """A question about NaN and infinities."""

    def handler(machine: Any, given: list[Any]) -> Value:
        value = machine.arithmetic.plain(machine.value(given[0]))
        if isinstance(value, Symbol) and machine.paths is not None:
            machine.paths.nan = False
        return test(machine.arithmetic, value)

    return handler


def _is_infinite(arithmetic: Any, value: Value) -> Value:
    return arithmetic.binary("==", arithmetic.absolute(value, DOUBLE), CONSTANTS["HUGE_VAL"])


def _is_finite(arithmetic: Any, value: Value) -> Value:
    infinite = _is_infinite(arithmetic, value)
    return Condition(lambda: not arithmetic.truth(infinite))


def _copy_memory(machine: Any, given: list[Any]) -> Value:
    """memcpy of whole items."""
    target, source, size = (machine.value(each) for each in given)
    if not isinstance(target, Reference) or not isinstance(source, Reference) or not isinstance(size, Number):
        raise machine.make_error("a copy of memory is not read", "copy item by item")
    if not isinstance(target.target, Array) or not isinstance(source.target, Array):
        if isinstance(target.target, Struct):
            machine.store(target.target, source.target)
            return target
        raise machine.make_error("a copy of memory is not read", "copy item by item")
    of = target.target.type.of
    bytes_, each = int(size.value), size_of(of)[0]
    if of != source.target.type.of or bytes_ % each:
        raise machine.make_error("a copy is not of whole items of one type", "copy item by item")
    for at in range(bytes_ // each):
        from_, to = source.target.item(source.at + at), target.target.item(target.at + at)
        if from_ is None or to is None:
            raise machine.make_error("a copy goes beyond an array", "stay within the declared length")
        machine.store(to, machine.load(from_))
    return target


def _clear_memory(machine: Any, given: list[Any]) -> Value:
    """memset to 0 of a whole object."""
    target, value, size = (machine.value(each) for each in given)
    whole = target.target if isinstance(target, Reference) else None
    if whole is None or not isinstance(value, Number) or value.value != 0 or not isinstance(size, Number):
        raise machine.make_error("memset is not read", "set each part")
    if size_of(whole.type)[0] != size.value or getattr(whole, "origin", None) is not None:
        raise machine.make_error("memset does not set a whole variable", "set each part")
    machine.zero_object(whole)
    return target


def _skip_print(machine: Any, given: list[Any]) -> Value:
    machine.note("what is printed is skipped")
    return None


def _assertion(machine: Any, given: list[Any]) -> Value:
    if not machine.truth(given[0]):
        raise Outside("observations for which its assertions hold")
    return None


FUNCTIONS: Mapping[str, Handler] = {
    "fabs": _absolute(DOUBLE), "fabsf": _absolute(FLOAT), "abs": _absolute(INT), "labs": _absolute(LONG),
    "llabs": _absolute(LLONG), "fmin": _extreme(False, DOUBLE), "fminf": _extreme(False, FLOAT),
    "fmax": _extreme(True, DOUBLE), "fmaxf": _extreme(True, FLOAT),
    **{f"{name}{end}": _make_step(f"{name}{end}", kind, compute) for end, kind in (("", DOUBLE), ("f", FLOAT))
       for name, compute in (("floor", np.floor), ("ceil", np.ceil), ("trunc", np.trunc), ("rint", np.rint),
                             ("nearbyint", np.rint), ("round", _round_away))},
    "lround": _to_long("round", DOUBLE), "lroundf": _to_long("roundf", FLOAT),
    "sqrt": _make_step("sqrt", DOUBLE, np.sqrt, rising=False),
    "sqrtf": _make_step("sqrtf", FLOAT, np.sqrt, rising=False),
    "isnan": _make_test(lambda arithmetic, value: Number(0, INT)), "isinf": _make_test(_is_infinite),
    "isfinite": _make_test(_is_finite), "memcpy": _copy_memory, "memset": _clear_memory, "assert": _assertion,
    **dict.fromkeys(PRINTING, _skip_print),
}  # fmt: skip
RESULTS: Mapping[str, Type] = {
    **{name: FLOAT if name.endswith("f") else DOUBLE for name in FUNCTIONS if name[0] in "fcrnst"},
    **dict.fromkeys(("labs", "lround", "lroundf"), LONG), "llabs": LLONG,
    **dict.fromkeys(("abs", "isnan", "isinf", "isfinite"), INT),
}  # fmt: skip
