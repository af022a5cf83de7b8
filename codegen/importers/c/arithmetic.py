"""The number arithmetic of C, of numbers and of features: conversions, operators, comparisons, sums, its library.

Does: promotes and converts as C does; computes numbers; makes a step of what is computed of a feature, and a sum of
  several in the type that C adds them in; fabs, fmin, fmax, floor and their like, memcpy; skips what prints.
Assumes: each type is evaluated as itself (FLT_EVAL_METHOD 0); a compiler without fast-math; the standard library.
Does not: wrap signed numbers, convert a float that does not fit, since C leaves both undefined, or reorder anything.
  What libraries round differently (sin, exp, pow) is not computed.

A compiler may round a product and a sum once instead of twice (contraction): refused, unless the product is exact.
"""

import math
import operator
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from functools import partial
from typing import Any

import numpy as np

from codegen.errors import InputError
from codegen.floats import FLOAT32, FLOAT64
from codegen.importers.c import kinds
from codegen.importers.c.kinds import (
    DOUBLE,
    FLOAT,
    GIVEN,
    INT,
    LLONG,
    LONG,
    Condition,
    Kind,
    Number,
    Outside,
    Reference,
    Symbol,
    Value,
)
from codegen.importers.reading import SUMS
from codegen.importers.symbolic import feature as features
from codegen.importers.symbolic.feature import (
    FALLING,
    FOLDING,
    IN_ORDER,
    RISING,
    SIGNS,
    Affine,
    Feature,
    Given,
    Step,
    Sums,
)
from codegen.importers.symbolic.paths import IN_SUM, Growth, ask_whole
from codegen.ir import CONSTANT
from codegen.sums import DOUBLE_SUMS, Sum, Weight

Operators = Mapping[str, Callable[[Any, Any], Any]]
COMPUTE: Operators = {"+": operator.add, "-": operator.sub, "*": operator.mul}
FLOATING: Operators = {**COMPUTE, "/": lambda a, b: a / b}
BITS: Operators = {"&": lambda a, b: a & b, "|": lambda a, b: a | b, "^": lambda a, b: a ^ b}
NEGATE = Step("negated", operator.neg, FALLING, form=("*", -1))
TEST_ADVICE = "compare one feature, or a sum of features, with a number"
ROUNDINGS = "a product and a sum may be rounded once or twice, as the compiler likes"
CONTRACTED = "say #pragma STDC FP_CONTRACT OFF, and build with -ffp-contract=off, since gcc ignores the pragma"
OF_ENUM = "an enum {} what may be a negative number, which compilers read differently"
RANGE_ADVICE = "give the parameter a type that it fits, such as int16_t, or test its range first"
FLOAT_ADVICE = "return where it is too large or too small: if (!(x > -1000 && x < 1000)) return 0;"
SET_ADVICE = "write a number of the type"
MAX_VALUES = 256  # of a whole number that is asked for its value
MAX_TABLE, MAX_JUMPS = 1 << 16, 1 << 10  # of a whole number whose bits are used: its values, and what they give


class Arithmetic:
    """Computes on one path. `contracts`: whether a product and a sum may be joined."""

    numbers = FLOAT64  # that are observed
    paths: Growth | None = None
    memories = 0  # inputs below are remembered

    def __init__(self, make_error: Callable[[str, str], InputError], *, contracts: bool) -> None:
        self.make_error, self.contracts = make_error, contracts
        self.used = set[int]()  # inputs that a test has looked at
        self.sums, self.finite = Sums(""), False  # finite: whether two features are compared
        self._tables = dict[str, Step]()

    # --- truth

    def truth(self, value: Value) -> bool:
        """Returns True if a value is not 0."""
        if value is not None and not isinstance(value, Condition | Number | Symbol):
            return True  # of a pointer
        given = self.plain(value)
        return bool(given.value != 0) if isinstance(given, Number) else self._holds(given.feature, "!=", 0)

    def _holds(self, feature: Feature, sign: str, number: Any) -> bool:
        paths, place = self._ensure_paths(), feature.place
        self.used |= {*(self.sums.known[place - SUMS].places if place >= SUMS else [place])}
        # a double, since NumPy would make a float of Python's number
        test = features.Test(feature, sign, number if isinstance(number, int) else np.float64(number))
        return paths.holds(test)

    def _ensure_paths(self) -> Growth:
        if self.paths is None:
            raise self.make_error("a feature is read outside a function", TEST_ADVICE)
        return self.paths

    def plain(self, value: Value) -> Number | Symbol:
        """A value as a number or a feature; a condition is asked."""
        if isinstance(value, (Number, Symbol)):  # most are this; faster than a union
            return value
        if isinstance(value, Condition):
            return Number(int(value.holds()), INT)
        if value is None:
            raise self.make_error("a value is used that nothing has set", "set it on every path")
        raise self.make_error("a pointer or a text is used as a number", TEST_ADVICE)

    def resolve_number(self, value: Value) -> Number | Symbol:
        """A value as a number, also a feature that is one of few whole numbers: it is asked which."""
        given = self.plain(value)
        if isinstance(given, Number) or given.kind.floating:
            return given
        least, most = self.ends(given.feature)
        if most - least >= MAX_VALUES:
            return given
        feature = given.feature
        return Number(ask_whole(least, most, lambda number: self._holds(feature, "<=", number)), given.kind)

    def _resolve_memory(self, given: Symbol) -> Number | Symbol:
        """A number in place of what is computed of a memory, which is asked; any other one as it is."""
        place, kind = given.feature.place, given.kind
        if place >= self.memories or not kind.floating:
            return self.resolve_number(given) if place < self.memories else given
        least, most = self._ensure_paths().whole_ends(place)
        if most - least > MAX_VALUES:
            raise self.make_error(*IN_SUM)
        held = ask_whole(least, most, lambda number: self._holds(Feature(place), "<=", number))
        return Number(kind.float_type(given.feature.value(float(held))), kind)

    # --- conversions

    def convert_value(self, value: Value, kind: Kind) -> Number | Symbol | Condition:
        """A value as one of a type."""
        if kind == kinds.BOOL and isinstance(value, Condition | Symbol):
            return value if isinstance(value, Condition) else Condition(lambda: self.truth(value))
        if isinstance(value, Condition) and kind.rank <= INT.rank and kind != kinds.UINT:
            return value
        given = self.plain(value)
        if isinstance(given, Number):
            return Number(self._number(given, kind), kind, given.name)
        return given if given.kind == kind else Symbol(self._feature(given, kind), kind)

    def _number(self, given: Number, kind: Kind) -> Any:
        value = given.value
        if kind == kinds.BOOL:
            return int(value != 0)
        if not given.kind.floating:
            return kinds.round_number(value, kind) if kind.floating else self._cut_bits(value, kind)
        if kind.floating:
            number = kind.float_type(value)
            if np.isfinite(value) and not np.isfinite(number):
                raise self.make_error(f"the number {value} is beyond {kind}", "write a smaller one")
            return number
        if not np.isfinite(value) or not kind.holds(math.trunc(float(value))):
            raise self.make_error(f"the number {value} is no {kind}", RANGE_ADVICE)
        return math.trunc(float(value))

    def wrap_number(self, value: int, kind: Kind) -> int:
        """Converts a whole number to a type. InputError where it overflows, which C leaves undefined."""
        if kind.signed and not kind.holds(value):
            raise self.make_error(f"the number {value} is no {kind}", SET_ADVICE)
        return self._cut_bits(value, kind)

    def _cut_bits(self, value: int, kind: Kind) -> int:
        """A whole number converted to a type: its last bits. InputError where compilers differ."""
        if kind.holds(value):
            return value
        if kind in (kinds.LONG, kinds.ULONG, kinds.ENUM, kinds.CHAR):
            raise self.make_error(f"the number {value} is no {kind}", SET_ADVICE)
        return kind.low + (value - kind.low) % (kind.high - kind.low + 1)

    def _feature(self, given: Symbol, kind: Kind) -> Feature:
        feature = given.feature
        if kind.floating and given.kind.floating:
            return feature.then(_to(kind)) if kind.rank < given.kind.rank else feature
        if given.kind.floating:
            feature = feature.then(Step("truncated", kinds.truncate_float))
        least, most = self.ends(feature)
        if kind.floating:
            return feature if kind == DOUBLE and max(-least, most) <= 2**53 else feature.then(_to(kind))
        if kind.low <= least and most <= kind.high:
            return feature
        if not given.kind.floating and most - least < MAX_TABLE:
            return self._tabulate(given, f"as {kind}", lambda v: self._cut_bits(v, kind)).feature
        told = "converted to" if given.kind.floating else "made"
        what = f"a number from {least} to {most} is {told} {kind}, which holds {kind.low} to {kind.high}"
        raise self.make_error(what, FLOAT_ADVICE if given.kind.floating else RANGE_ADVICE)

    def ends(self, feature: Feature) -> tuple[Any, Any]:
        """The least and the most that a feature is on this path."""
        paths = self._ensure_paths()
        if any(step.key.startswith("truncated") for step in feature.steps):
            paths.nan = False
        return paths.least(feature), -paths.least(feature.then(NEGATE))

    # --- operators

    def unary(self, sign: str, value: Value) -> Value:
        """`+`, `-`, `~` and `!` of a value."""
        if sign == "!":
            known = value if isinstance(value, Number) else None
            return Number(int(known.value == 0), INT) if known else Condition(lambda: not self.truth(value))
        enums = self.plain(value).kind == kinds.ENUM
        given = self._promote_number(self.plain(value))
        kind = given.kind
        if sign == "+":
            return self.plain(value) if enums else given
        if kind.floating and sign == "~":
            raise self.make_error("bits of a float are used", TEST_ADVICE)
        if kind.floating:
            return Number(-given.value, kind) if isinstance(given, Number) else _then(given, NEGATE)
        whole = self._whole("-", Number(0 if sign == "-" else -1 if kind.signed else kind.high, kind), given, kind)
        return self._make_of(enums, whole)

    def _promote_number(self, given: Number | Symbol) -> Number | Symbol:
        if given.kind != kinds.ENUM and given.kind.rank >= INT.rank:
            return given
        return Number(given.value, INT, given.name) if isinstance(given, Number) else Symbol(given.feature, INT)

    def common(self, one: Kind, other: Kind) -> Kind:
        """The type in which two numbers meet."""
        if one.rank == other.rank and one.signed != other.signed:
            return kinds.UNSIGNED.get(one, one) if one.signed else one
        high, low = (one, other) if one.rank >= other.rank else (other, one)
        by_width = (high, low) in ((kinds.LONG, kinds.UINT), (kinds.LLONG, kinds.ULONG))  # as wide as long is
        return kinds.ULONG if by_width else high

    def binary(self, sign: str, left: Value, right: Value) -> Value:
        """An operator of two numbers."""
        one, other = self.plain(left), self.plain(right)
        if isinstance(one, Symbol) and isinstance(other, Symbol):  # a memory is asked for its value
            one, other = self._resolve_memory(one), self._resolve_memory(other)
        enums = kinds.ENUM in (one.kind, other.kind)
        one, other = self._promote_number(one), self._promote_number(other)
        if sign in ("<<", ">>"):
            other = self.resolve_number(other)
            if not isinstance(other, Number) or one.kind.floating or not 0 <= other.value < one.kind.bits:
                raise self.make_error("a shift is not read", "shift by a number within the type")
            least = one.value if isinstance(one, Number) else self.ends(one.feature)[0] if sign == ">>" else 0
            if least < 0:
                raise self.make_error("a negative number may be shifted", RANGE_ADVICE)
            return self._whole("*" if sign == "<<" else "/", one, Number(2**other.value, one.kind), one.kind)
        kind = self.common(one.kind, other.kind)
        one, other = (self.plain(self.convert_value(each, kind)) for each in (one, other))
        self._ensure_natural("meets" if enums else "", one, other)
        if sign in SIGNS:
            if isinstance(one, Number) and isinstance(other, Number):
                return Number(int(SIGNS[sign](one.value, other.value)), INT)
            if isinstance(one, Symbol) and isinstance(other, Symbol):
                one, other = self._compare_symbols(one, other), Number(0, INT)
            if isinstance(one, Number):
                one, other, sign = other, one, features.TURNED[sign]
            assert isinstance(one, Symbol) and isinstance(other, Number)
            feature, number = one.feature, other.value
            if number != number:
                return Number(int(sign == "!="), INT)
            return Condition(lambda: self._holds(feature, sign, number))
        if kind.floating:
            return self._floating(sign, one, other, kind)
        return self._make_of(enums, self._whole(sign, one, other, kind))

    def _make_of(self, enums: bool, whole: Value) -> Value:
        """A whole number, which an enum made, or did not. One that did is unsigned where compilers like it."""
        self._ensure_natural("makes" if enums else "", whole)
        if not enums or not isinstance(whole, Number | Symbol) or whole.kind != INT:
            return whole
        return replace(whole, kind=kinds.ENUM)

    def _ensure_natural(self, does: str, *values: Value) -> None:
        for each in values if does else ():
            if isinstance(each, Symbol):
                least = 0 if each.kind.floating else self.ends(each.feature)[0]
            else:
                least = each.value if isinstance(each, Number) else 0
            if least >= 0:
                continue
            raise self.make_error(OF_ENUM.format(does), "convert it to int")

    def _floating(self, sign: str, one: Number | Symbol, other: Number | Symbol, kind: Kind) -> Value:
        make = kind.float_type
        if sign not in FLOATING:
            raise self.make_error(f"the operator {sign} takes no floats", TEST_ADVICE)
        if isinstance(one, Number) and isinstance(other, Number):
            if sign == "/" and other.value == 0:
                raise self.make_error("a number is divided by 0", "write the value")
            with np.errstate(all="ignore"):
                return Number(make(FLOATING[sign](make(one.value), make(other.value))), kind)
        if isinstance(one, Symbol) and isinstance(other, Symbol):
            same = one.feature.key == other.feature.key
            if sign in "+-" and not same:
                total = self._add_features(sign, one.feature, other.feature, kind)
                self._ensure_one_rounding(self.sums.known[total.place - SUMS])
                return Symbol(total, kind)
            if sign != "*" or not same:
                what = "a product of features" if sign in "*/" else "a sum of several features"
                raise self.make_error(f"{what} is not read", TEST_ADVICE)
            return _then(one, Step(f"squared{kind}", lambda v: make(make(v) * make(v)), FOLDING))
        given, number = (one, other) if isinstance(one, Symbol) else (other, one)
        assert isinstance(given, Symbol) and isinstance(number, Number)
        c, first = make(number.value), given is one
        if not np.isfinite(c) or (sign in "*/" and c == 0) or (sign == "/" and not first):
            what = f"a feature {sign} {c}" if first else "a number is divided by a feature"
            raise self.make_error(f"{what} is not read", TEST_ADVICE)
        if sign in "+-":
            self._ensure_exact_product(given.feature, kind, c)
        compute, key = FLOATING[sign], f"{sign}{c!r}{first}{kind}"

        def joined(one: Any, other: Any) -> Any:
            return make(compute(make(one), make(other)))

        return _then(given, features.arithmetic_step(key, sign, c, joined, turned=not first))

    def _ensure_exact_product(self, feature: Feature, kind: Kind, added: Any) -> None:
        """InputError where the last step is a product that a compiler may join with the sum behind it."""
        steps = [step for step in feature.steps if step is not NEGATE]
        last = steps[-1] if steps else NEGATE
        if not self.contracts or not last.key.startswith(("*", "squared")) or not last.key.endswith(str(kind)):
            return
        by = last.form[1] if last.form else math.nan
        of_floats = (self.numbers, kind, len(steps)) == (FLOAT32, DOUBLE, 1) and feature.place < SUMS
        # a power of two: what it loses at either end is too small, or too large, to matter beside what is added
        power = abs(math.frexp(by)[0]) == 0.5 and all(1e-20 < abs(each) < 1e20 for each in (by, added))
        if not power and not (of_floats and np.float32(by) == by):
            raise self.make_error(ROUNDINGS, CONTRACTED)

    def _whole(self, sign: str, one: Number | Symbol, other: Number | Symbol, kind: Kind) -> Value:
        if isinstance(one, Number) and isinstance(other, Number):
            return Number(self._compute_number(sign, one.value, other.value, kind), kind)
        if isinstance(one, Symbol) and isinstance(other, Symbol):
            total = None  # their sum; where that is none, one of few is asked which it is
            if sign in "+-":
                with suppress(InputError):
                    total = self._add_whole(sign, one, other)
            few = self.resolve_number(other) if total is None else other
            if isinstance(few, Number):
                return self._whole(sign, one, few, kind)
            if sign not in "+-":
                raise self.make_error(f"the operator {sign} of two features is not read", TEST_ADVICE)
            (low, high), (less, more) = self.ends(one.feature), self.ends(other.feature)
            ends = (low + less, high + more) if sign == "+" else (low - more, high - less)
            return self.ensure_fits(Symbol(total or self._add_whole(sign, one, other), kind), ends)
        given, number = (one, other) if isinstance(one, Symbol) else (other, one)
        assert isinstance(given, Symbol) and isinstance(number, Number)
        c, first = int(number.value), given is one
        if sign == "*" and not c:
            return Number(0, kind)
        if sign in COMPUTE:
            step = features.arithmetic_step(f"{sign}{c}{first}", sign, c, COMPUTE[sign], turned=not first)
        elif sign == "/" and first and c:
            step = Step(f"//{c}", lambda v: kinds.quotient(v, c), RISING if c > 0 else FALLING)
        else:
            compute_pair = partial(self._compute_number, sign, kind=kind)
            return self._tabulate(
                given, f"{sign}{c}{first}{kind}", lambda v: compute_pair(*((v, c) if first else (c, v)))
            )
        symbol = _then(Symbol(given.feature, kind), step)
        return self.ensure_fits(symbol, self.ends(symbol.feature))

    def ensure_fits(self, symbol: Symbol, ends: tuple[Any, Any]) -> Symbol:
        """The symbol. The path ends where its number overflows, which C leaves undefined; InputError where it wraps."""
        feature, kind, (least, most) = symbol.feature, symbol.kind, ends
        if kind.low <= least and most <= kind.high:
            return symbol
        if not kind.signed:
            raise self.make_error(f"a number from {least} to {most} wraps around in {kind}", RANGE_ADVICE)
        if not (self._holds(feature, ">=", kind.low) and self._holds(feature, "<=", kind.high)):
            raise Outside("numbers that do not overflow")
        return symbol

    def _tabulate(self, given: Symbol, key: str, compute: Callable[[int], int]) -> Symbol:
        """Computes a function of a whole number by a table of its values on this path."""
        low, high = self.ends(given.feature)
        if high - low >= MAX_TABLE:
            what = "bits or remainders of a whole number of more than 16 bits are not read"
            raise self.make_error(what, "declare it with at most 16 bits, such as uint16_t, or test its range first")
        within, told = Step(f"{low} to {high}", lambda v: min(max(v, low), high)), f"{key} of {low} to {high}"
        if told not in self._tables:
            known = {v: compute(v) for v in range(low, high + 1)}
            jumps = tuple(v for v in range(low + 1, high + 1) if known[v] < known[v - 1])
            if len(jumps) > MAX_JUMPS:
                what = f"bits or remainders that fall more than {MAX_JUMPS:,} times are not read"
                raise self.make_error(what, "declare it with 8 bits, such as uint8_t, or test its range first")
            sense = features.JUMPING if jumps else RISING
            self._tables[told] = Step(told, lambda v: known.get(v, v), sense, jumps=jumps)  # v itself: a NaN
        return _then(given, within, self._tables[told])

    def _compute_number(self, sign: str, a: int, b: int, kind: Kind) -> int:
        """A number of two whole numbers."""
        if sign in BITS:
            return BITS[sign](a, b)
        if sign in ("/", "%"):
            if b == 0:
                raise self.make_error("a number is divided by 0", "write the value")
            whole = kinds.quotient(a, b)
            return self.wrap_number(whole if sign == "/" else a - whole * b, kind)
        return self.wrap_number(COMPUTE[sign](a, b), kind)

    # --- sums

    def _compare_symbols(self, one: Symbol, other: Symbol) -> Symbol:
        """A difference, whose sign is that of the comparison, unless both are the same infinity."""
        if one.feature.key == other.feature.key:
            raise self.make_error("a feature is compared with itself", TEST_ADVICE)
        if not one.kind.floating:
            return Symbol(self._add_whole("-", one, other), one.kind)
        self.finite, kind, both = True, one.kind, [one.feature, other.feature]
        if self.numbers == FLOAT64:  # floats that are given as they are lie among the doubles
            both = [Feature(each.place) if [step.key for step in each.steps] == [GIVEN] else each for each in both]
            kind = kind if any(each.steps for each in both) else DOUBLE
        return Symbol(self._add_features("<", both[0], both[1], kind), kind)

    def _add_whole(self, sign: str, one: Symbol, other: Symbol) -> Feature:
        """A sum or difference of whole numbers, which floats have exactly."""
        single = self.numbers == FLOAT32
        given = [each.feature for each in (one, other)]  # the first step of an input makes it whole; sums have no such
        plain = [each if each.place >= SUMS else Feature(each.place, each.steps[1:]) for each in given]
        total = self._add_features(sign, plain[0], plain[1], FLOAT if single else DOUBLE)
        most = 2**16 if single else 2**32  # of an input: `Kind.fits_float32`
        if _largest(self.sums.known[total.place - SUMS].terms, most) > (2**24 if single else 2**53):
            raise self.make_error("a sum of whole numbers may be no float", TEST_ADVICE)
        return total

    def _add_features(self, sign: str, one: Feature, other: Feature, kind: Kind) -> Feature:
        self._compute_in(kind)
        total = self.sums.add_features(one, other, sign)
        if total is None:
            raise self.make_error("what is added or compared is no sum", IN_ORDER)
        self._ensure_weights(self.sums.known[total.place - SUMS])
        return total

    def build_given(self, values: Sequence[Value]) -> Given | None:
        """Builds a form for each number returned where these depend on features; None: these are labels."""
        numbers = [self.resolve_number(each) for each in values]
        symbols = [each for each in numbers if isinstance(each, Symbol)]
        if not symbols or not all(each.kind.floating for each in symbols):
            return None
        for each in symbols:
            self._compute_in(each.kind)
        forms = list[Affine]()
        for each in numbers:
            given = each.feature if isinstance(each, Symbol) else each.value
            forms.append(self.sums.represent(given, self.make_error))
            self._ensure_weights(forms[-1])
        self.used |= {place for each in forms for place in each.places}
        return Given(forms)

    def _compute_in(self, kind: Kind) -> None:
        """Sums are of this type from now on. InputError where others are of another one."""
        numbers = FLOAT32 if kind == FLOAT else FLOAT64
        if self.sums.numbers not in ("", numbers):
            raise self.make_error("sums of float and of double stand side by side", "use one type for all of them")
        if (self.numbers, numbers) == (FLOAT64, FLOAT32):
            what = "sums of float stand in a function that is given doubles, or whole numbers of more than 16 bits"
            raise self.make_error(what, "use double for all of them, or declare whole numbers int16_t or smaller")
        self.sums.numbers, self.sums.weights = numbers, self.numbers

    def _ensure_weights(self, form: Affine) -> None:
        """InputError for products of a float and a double that is none, which no profile has."""
        for part in Sum(form.terms).parts() if self.sums.arithmetic == DOUBLE_SUMS else ():
            for weight, place in part.terms:
                if isinstance(weight, Fraction) or (isinstance(place, Sum) and abs(weight) != 1):
                    what = f"a {'sum of floats' if isinstance(place, Sum) else 'float'} is scaled in double"
                    raise self.make_error(what, "compute in float throughout, or let the observation be double")
                if place != CONSTANT and float(np.float32(weight)) != weight:
                    what = f"a float is multiplied with {weight!r}, which is no float"
                    raise self.make_error(what, "write it as a float, such as 0.1f, or let the observation be double")

    def _ensure_one_rounding(self, form: Affine) -> None:
        """InputError for products that a compiler may join with the sum behind them; those of floats in double are
        exact, so that nothing is to be joined.
        """
        if not self.contracts or self.sums.arithmetic == DOUBLE_SUMS:
            return
        parts = [part for part in Sum(form.terms).parts() if len(part.terms) > 1]
        if any(_is_product(*term) for part in parts for term in part.terms):
            raise self.make_error(ROUNDINGS, CONTRACTED)


def _is_product(weight: Weight, place: int | Sum) -> bool:
    """Returns True if the last operation of a term is a product, which may be joined with what is added to it."""
    if isinstance(place, Sum) and abs(weight) == 1 and len(place.terms) == 1:
        return _is_product(*place.terms[0])
    return abs(weight) != 1 and place != CONSTANT and not isinstance(weight, Fraction)


def _largest(terms: features.Terms, most: int) -> float:
    """Bounds the absolute value of a sum, and of what is computed on the way. `most`: that of an input."""
    sizes = [_largest(place.terms, most) if isinstance(place, Sum) else most for _, place in terms]
    return sum(
        float(abs(weight)) * (1 if place == CONSTANT else size)
        for (weight, place), size in zip(terms, sizes, strict=True)
    )


# --- steps


def _then(given: Symbol, *steps: Step) -> Symbol:
    return Symbol(given.feature.then(*steps), given.kind)


def _to(kind: Kind) -> Step:
    """The conversion to a floating type."""
    return Step(f"to {kind}", lambda v: kinds.round_number(v, kind) if isinstance(v, int) else kind.float_type(v))


# --- what C's own headers give to a decision: constants, functions of numbers, a copy of memory

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
    compute: Callable[[Any], Any] = abs if called == "fabs" else (lambda v: make(ROUNDING[called](make(v))))
    sense = FOLDING if called == "fabs" else RISING
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
