"""What C's own headers give to a decision: constants, functions of numbers, a copy of memory.

Does: fabs, fmin, fmax, floor and their like, of numbers and of features; memcpy; skips what prints.
Assumes: IEEE 754; that functions of the standard library are not replaced.
Does not: compute what libraries round differently (sin, exp, pow), draw numbers, or read files.
"""

# pyright: basic
# pycparser's nodes have no declared attributes
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from codegen.importers.c import kinds
from codegen.importers.c.arithmetic import TEST_ADVICE
from codegen.importers.c.kinds import DOUBLE, FLOAT, INT, LLONG, LONG, Kind, Number, Outside, Reference, Symbol, Value
from codegen.importers.symbolic.feature import FOLDING, RISING, Step

PRINTING = ["printf", "fprintf", "puts", "fputs", "putchar", "putc", "fputc", "fflush", "perror"]
WHOLE: Mapping[str, Kind] = {
    "SCHAR": kinds.SCHAR, "SHRT": kinds.SHORT, "INT": INT, "LLONG": LLONG,
    "UCHAR": kinds.UCHAR, "USHRT": kinds.USHORT, "UINT": kinds.UINT, "ULLONG": kinds.ULLONG,
    **{f"{sign}INT{bits}": kinds.STANDARD[f"{sign.lower()}int{bits}_t"] for sign in ("", "U")
       for bits in (8, 16, 32, 64)},
}  # fmt: skip
DOUBLES = {
    "M_PI": math.pi, "M_PI_2": math.pi / 2, "M_PI_4": math.pi / 4, "M_E": math.e, "HUGE_VAL": math.inf,
    "DBL_MAX": float(np.finfo(np.float64).max), "DBL_MIN": 2.0**-1022, "DBL_EPSILON": 2.0**-52,
}  # fmt: skip
FLOATS = {
    "INFINITY": math.inf, "FLT_MAX": float(np.finfo(np.float32).max), "FLT_MIN": 2.0**-126, "FLT_EPSILON": 2.0**-23,
}  # fmt: skip
ENDS = {f"{name}_{end}": (kind, value) for name, kind in WHOLE.items()
        for end, value in (("MAX", kind.high), ("MIN", kind.low)) if kind.signed or end == "MAX"}  # fmt: skip
CONSTANTS: Mapping[str, Number] = {
    "true": Number(1, INT, "true"), "false": Number(0, INT, "false"),
    **dict.fromkeys(("NULL", "EXIT_SUCCESS"), Number(0, INT)), "EXIT_FAILURE": Number(1, INT),
    **{name: Number(np.float64(value), DOUBLE) for name, value in DOUBLES.items()},
    **{name: Number(np.float32(value), FLOAT) for name, value in FLOATS.items()},
    **{name: Number(value, kind if kind.rank >= INT.rank else INT) for name, (kind, value) in ENDS.items()},
}  # fmt: skip


def _round_away(v: Any) -> Any:
    """The nearest whole number, of two the one farther from 0."""
    whole = np.trunc(v)
    return whole + np.sign(v) if abs(v - whole) >= 0.5 else whole  # the difference is exact


ROUNDING = {"floor": np.floor, "ceil": np.ceil, "trunc": np.trunc, "round": _round_away}
EXTREME = {"fmin": min, "fmax": max}
FUNCTIONS: Mapping[str, tuple[str, Kind]] = {  # what each computes, in which type
    "abs": ("fabs", INT), "lround": ("round", DOUBLE), "lroundf": ("round", FLOAT),
    **{f"{name}{end}": (name, kind) for end, kind in (("", DOUBLE), ("f", FLOAT))
       for name in ("fabs", *EXTREME, *ROUNDING)},
}  # fmt: skip
RESULTS = {**{name: kind for name, (_, kind) in FUNCTIONS.items()}, "lround": LONG, "lroundf": LONG, "isnan": INT}
LIBRARY = {*FUNCTIONS, *PRINTING, "assert", "isnan", "memcpy"}


def call_library(machine: Any, name: str, given: list[Any]) -> Value:
    """What a function of LIBRARY gives for the nodes of its arguments."""
    if name in PRINTING:
        machine.notes["what is printed is skipped"] = None
        return None
    if name == "assert":
        if not machine.truth(given[0]):
            raise Outside("observations for which its assertions hold")
        return None
    values = [machine.value(each) for each in given]
    if name == "isnan":
        number = machine.arithmetic.plain(values[0])
        if not number.kind.floating:
            raise machine.make_error("isnan takes a float or a double", "leave it out: a whole number is never NaN")
        machine.paths.nan &= isinstance(number, Number)
        return Number(0, INT)
    if name == "memcpy":
        return _copy_memory(machine, *values)
    (called, kind), arithmetic = FUNCTIONS[name], machine.arithmetic
    numbers = [arithmetic.plain(arithmetic.convert_value(each, kind)) for each in values]
    if called in EXTREME:
        return _extreme(machine, called, kind, *numbers)
    (value,), make = numbers, kind.float_type
    compute, sense = (abs, FOLDING) if called == "fabs" else (lambda v: make(ROUNDING[called](make(v))), RISING)
    if isinstance(value, Number):
        result = compute(value.value)
        number = Number(result if kind.floating else arithmetic.wrap_number(result, kind), kind)
        return arithmetic.convert_value(number, RESULTS[name])
    symbol = Symbol(value.feature.then(Step(f"{called} {kind}", compute, sense)), kind)
    symbol = symbol if kind.floating else arithmetic.ensure_fits(symbol, arithmetic.ends(symbol.feature))
    return arithmetic.convert_value(symbol, RESULTS[name])


def _extreme(machine: Any, called: str, kind: Kind, one: Number | Symbol, other: Number | Symbol) -> Value:
    """fmin and fmax, of which one is a number."""
    choose = EXTREME[called]
    if isinstance(one, Symbol) and isinstance(other, Symbol):
        raise machine.make_error("the larger or smaller of two features is not read", TEST_ADVICE)
    one, other = (one, other) if isinstance(one, Symbol) else (other, one)
    assert isinstance(other, Number)
    c = other.value
    if isinstance(one, Number):
        return Number(choose(one.value, c), kind)
    machine.paths.nan = False  # they leave a NaN out
    step = Step(f"{called}{c!r}", lambda v: v if v != v else choose(v, c), form=(called[1:], c, False))
    return Symbol(one.feature.then(step), kind)


def _copy_memory(machine: Any, target: Value, source: Value, size: Value) -> Value:
    """memcpy of whole items."""
    if not (
        isinstance(target, Reference)
        and isinstance(source, Reference)
        and isinstance(size, Number)
        and target.target.type == source.target.type
    ):
        raise machine.make_error("a copy of memory is not read", "copy item by item")
    count, rest = divmod(size.value, kinds.size_of(target.target.type)[0])
    if rest:
        raise machine.make_error("a copy is not of whole items of one type", "copy item by item")
    for at in range(count):
        from_, to = source.target.item(at), target.target.item(at)
        if from_ is None or to is None:
            raise machine.make_error("a copy goes beyond an array", "stay within the declared length")
        machine.store(to, machine.load(from_))
    return target
