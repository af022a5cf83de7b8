"""What C's own headers give to a decision: constants, functions of numbers,a copy of memory.

Does: fabs, fmin, fmax, floor and their like, of numbers and of features; memcpy; skips what prints.
Assumes: IEEE 754; that functions of the standard library are not replaced.
Does not: compute what libraries round differently (sin, exp, pow), draw numbers, or read files.
"""

# pyright: basic
# pycparser's nodes have no declared attributes
import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from codegen.importers.c import kinds
from codegen.importers.c.arithmetic import TEST_ADVICE
from codegen.importers.c.kinds import DOUBLE, FLOAT, INT, LONG, Kind, Number, Outside, Reference, Symbol, Type, Value
from codegen.importers.symbolic.feature import FOLDING, Step

PRINTING = ["printf", "fprintf", "puts", "fputs", "putchar", "putc", "fputc", "fflush", "perror"]
SINGLE, HUGE = float(np.finfo(np.float32).max), float(np.finfo(np.float64).max)
WHOLE: Mapping[str, Kind] = {
    "SCHAR": kinds.SCHAR, "SHRT": kinds.SHORT, "INT": INT, "LLONG": kinds.LLONG,
    "UCHAR": kinds.UCHAR, "USHRT": kinds.USHORT, "UINT": kinds.UINT, "ULLONG": kinds.ULLONG,
    **{f"INT{bits}": kinds.STANDARD[f"int{bits}_t"] for bits in (8, 16, 32, 64)},
    **{f"UINT{bits}": kinds.STANDARD[f"uint{bits}_t"] for bits in (8, 16, 32, 64)},
}  # fmt: skip
CONSTANTS: Mapping[str, Number] = {
    "true": Number(1, INT, "true"), "false": Number(0, INT, "false"), "NULL": Number(0, INT),
    "M_PI": Number(np.float64(math.pi), DOUBLE), "M_PI_2": Number(np.float64(math.pi / 2), DOUBLE),
    "M_PI_4": Number(np.float64(math.pi / 4), DOUBLE), "M_E": Number(np.float64(math.e), DOUBLE),
    "INFINITY": Number(np.float32(math.inf), FLOAT), "HUGE_VAL": Number(np.float64(math.inf), DOUBLE),
    "FLT_MAX": Number(np.float32(SINGLE), FLOAT), "DBL_MAX": Number(np.float64(HUGE), DOUBLE),
    "FLT_MIN": Number(np.float32(2.0**-126), FLOAT), "DBL_MIN": Number(np.float64(2.0**-1022), DOUBLE),
    "FLT_EPSILON": Number(np.float32(2.0**-23), FLOAT), "DBL_EPSILON": Number(np.float64(2.0**-52), DOUBLE),
    **{f"{name}_MAX": Number(kind.high, kind if kind.rank >= INT.rank else INT) for name, kind in WHOLE.items()},
    **{f"{name}_MIN": Number(kind.low, kind if kind.rank >= INT.rank else INT) for name, kind in WHOLE.items()
       if kind.signed},
    "EXIT_SUCCESS": Number(0, INT), "EXIT_FAILURE": Number(1, INT),
}  # fmt: skip
Handler = Callable[[Any, list[Any]], Value]


def _absolute(kind: Kind) -> Handler:
    """The absolute value, as one of a type."""

    def handler(machine: Any, given: list[Any]) -> Value:
        arithmetic = machine.arithmetic
        value = arithmetic.plain(arithmetic.convert_value(machine.value(given[0]), kind))
        if isinstance(value, Number):
            whole = abs(value.value)
            return Number(whole if kind.floating else arithmetic.wrap_number(whole, kind), kind)
        symbol = Symbol(value.feature.then(Step("absolute", abs, FOLDING)), kind)
        return symbol if kind.floating else arithmetic.ensure_fits(symbol, arithmetic.ends(symbol.feature))

    return handler


def _extreme(most: bool, kind: Kind) -> Handler:
    """fmin and fmax, of which one is a number."""
    choose, name = (max, "max") if most else (min, "min")

    def handler(machine: Any, given: list[Any]) -> Value:
        arithmetic = machine.arithmetic
        one, other = (arithmetic.plain(arithmetic.convert_value(machine.value(each), kind)) for each in given[:2])
        if isinstance(one, Number) and isinstance(other, Number):
            return Number(choose(one.value, other.value), kind)
        if isinstance(one, Symbol) and isinstance(other, Symbol):
            raise machine.make_error("the larger or smaller of two features is not read", TEST_ADVICE)
        symbol, c = (one, other.value) if isinstance(one, Symbol) else (other, one.value)
        machine.paths.nan = False  # they leave a NaN out
        step = Step(f"{name}{c!r}", lambda v: v if v != v else choose(v, c), form=(name, c, False))
        return Symbol(symbol.feature.then(step), kind)

    return handler


def _make_step(name: str, kind: Kind, compute: Callable[[Any], Any]) -> Handler:
    """A function that never falls."""

    def handler(machine: Any, given: list[Any]) -> Value:
        value = machine.arithmetic.plain(machine.arithmetic.convert_value(machine.value(given[0]), kind))
        make = kind.float_type
        if isinstance(value, Number):
            with np.errstate(all="ignore"):
                return Number(make(compute(make(value.value))), kind)
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


def _is_nan(machine: Any, given: list[Any]) -> Value:
    machine.paths.nan &= isinstance(machine.arithmetic.plain(machine.value(given[0])), Number)
    return Number(0, INT)


def _copy_memory(machine: Any, given: list[Any]) -> Value:
    """memcpy of whole items."""
    target, source, size = (machine.value(each) for each in given)
    pointers = isinstance(target, Reference) and isinstance(source, Reference)
    if not pointers or target.target.type != source.target.type or not isinstance(size, Number):
        raise machine.make_error("a copy of memory is not read", "copy item by item")
    count, rest = divmod(int(size.value), kinds.size_of(target.target.type)[0])
    if rest:
        raise machine.make_error("a copy is not of whole items of one type", "copy item by item")
    for at in range(count):
        from_, to = source.target.item(at), target.target.item(at)
        if from_ is None or to is None:
            raise machine.make_error("a copy goes beyond an array", "stay within the declared length")
        machine.store(to, machine.load(from_))
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
    "llabs": _absolute(kinds.LLONG), "fmin": _extreme(False, DOUBLE), "fminf": _extreme(False, FLOAT),
    "fmax": _extreme(True, DOUBLE), "fmaxf": _extreme(True, FLOAT),
    **{f"{name}{end}": _make_step(f"{name}{end}", kind, compute) for end, kind in (("", DOUBLE), ("f", FLOAT))
       for name, compute in (("floor", np.floor), ("ceil", np.ceil), ("trunc", np.trunc), ("round", _round_away))},
    "lround": _to_long("round", DOUBLE), "lroundf": _to_long("roundf", FLOAT),
    "isnan": _is_nan, "memcpy": _copy_memory, "assert": _assertion,
    **dict.fromkeys(PRINTING, _skip_print),
}  # fmt: skip
RESULTS: Mapping[str, Type] = {
    **{name: FLOAT if name.endswith("f") else DOUBLE for name in FUNCTIONS if name[0] in "fcrnst"},
    **dict.fromkeys(("labs", "lround", "lroundf"), LONG), "llabs": kinds.LLONG,
    **dict.fromkeys(("abs", "isnan"), INT),
}  # fmt: skip
