"""The number arithmetic of C, of numbers and of features: conversions, operators, comparisons.

Does: promotes and converts as C does; computes numbers; makes a step of what is computed of a feature.
Assumes: each type is evaluated as itself (FLT_EVAL_METHOD 0); a compiler without fast-math.
Does not: wrap signed numbers, or convert a float that does not fit: C leaves both undefined.

A compiler may round a product and a sum once instead of twice (contraction). Where that moves a threshold, the
test is refused.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from typing import Any

import numpy as np

from codegen.errors import InputError
from codegen.importers.c import kinds
from codegen.importers.c.kinds import DOUBLE, INT, Condition, Kind, Number, Outside, Symbol, Value
from codegen.importers.c.sums import (
    CONTRACTED,
    FLOATING,
    NEGATE,
    ROUNDINGS,
    TEST_ADVICE,
    Rounding,
    Summing,
    contract_feature,
    make_step,
)  # fmt: skip
from codegen.importers.symbolic.affine import Given
from codegen.importers.symbolic.feature import (
    FALLING,
    FOLDING,
    JUMPING,
    RISING,
    SIGNS,
    TURNED,
    Feature,
    Step,
    Test,
    turns_of,
)  # fmt: skip
from codegen.importers.symbolic.paths import Growth
from codegen.ir import CONSTANT

COMPUTE = {sign: FLOATING[sign] for sign in "+-*"}
BITS: Mapping[str, Callable[[int, int], int]] = {
    "&": lambda a, b: a & b, "|": lambda a, b: a | b, "^": lambda a, b: a ^ b,
}  # fmt: skip
OF_ENUM = "an enum {} a negative number, which compilers read differently"
RANGE_ADVICE = "give the parameter a type that it fits, such as int16_t, or test its range first"
FLOAT_ADVICE = "return where it is too large or too small: if (!(x > -1000 && x < 1000)) return 0;"
MAX_VALUES = 256  # of a whole number that is asked for its value
MAX_TABLE, MAX_JUMPS = 1 << 16, 1 << 10  # of a whole number whose bits are used: its values, and what they give


class Arithmetic:
    """Computes on one path. `contracts`: whether a product and a sum may be joined."""

    def __init__(self, make_error: Callable[[str, str], InputError], numbers: str, *, contracts: bool) -> None:
        self.make_error, self.numbers, self.contracts = make_error, numbers, contracts
        self.paths: Growth | None = None
        self.used = set[int]()  # inputs that a test has looked at
        self.summing = Summing(make_error, numbers, contracts=contracts)
        self._tables = dict[str, Step]()
        self.speculating = False  # whether what is evaluated may turn out not to be reached

    # --- truth

    def truth(self, value: Value) -> bool:
        """Returns True if a value is not 0."""
        if value is not None and not isinstance(value, Condition | Number | Symbol):
            return True  # of a pointer
        given = self.plain(value)
        return bool(given.value != 0) if isinstance(given, Number) else self._holds(given.feature, "!=", 0)

    def _holds(self, feature: Feature, sign: str, number: Any) -> bool:
        if self.paths is None:
            raise self.make_error("a feature is read outside a function", TEST_ADVICE)
        self.used |= self.summing.inputs(feature)
        if number != number:
            return sign == "!="
        # a double, since NumPy would make a float of Python's number
        test = Test(feature, sign, number if isinstance(number, int) else np.float64(number))
        numbers = self.summing.sums.numbers_of(feature, self.numbers)
        once = contract_feature(feature) if self.contracts else None
        if once and turns_of(test, numbers) != turns_of(Test(once, sign, test.number), numbers):
            raise self.make_error(f"{ROUNDINGS}, and a decision depends on it", CONTRACTED)
        return self.paths.holds(test)

    def plain(self, value: Value) -> Number | Symbol:
        """A value as a number or a feature; a condition is asked."""
        if isinstance(value, Condition):
            return Number(int(value.holds()), INT)
        if isinstance(value, Number | Symbol):
            return value
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
        while least < most:
            middle = (least + most) // 2
            least, most = (least, middle) if self._holds(given.feature, "<=", middle) else (middle + 1, most)
        return Number(least, given.kind)

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
        if kind.floating:
            if not given.kind.floating:
                return kinds.round_number(value, kind)
            number = kind.float_type(value)
            if np.isfinite(value) and not np.isfinite(number):
                raise self.make_error(f"the number {value} is beyond {kind}", "write a smaller one")
            return number
        if given.kind.floating:
            if not np.isfinite(value) or not kind.holds(math.trunc(float(value))):
                raise self.make_error(f"the number {value} is no {kind}", RANGE_ADVICE)
            return math.trunc(float(value))
        return self._cut_bits(value, kind)

    def wrap_number(self, value: int, kind: Kind) -> int:
        """Converts a whole number to a type. InputError where it overflows, which C leaves undefined."""
        if kind.signed and not kind.holds(value):
            raise self.make_error(f"the number {value} is no {kind}", "write a number of the type")
        return self._cut_bits(value, kind)

    def _cut_bits(self, value: int, kind: Kind) -> int:
        """A whole number converted to a type: its last bits. InputError where compilers differ."""
        if kind.holds(value):
            return value
        if kind in (kinds.LONG, kinds.ULONG, kinds.ENUM) or kind.name == "char":
            raise self.make_error(f"the number {value} is no {kind}", "write a number of the type")
        return kind.low + (value - kind.low) % (kind.high - kind.low + 1)

    def _feature(self, given: Symbol, kind: Kind) -> Feature:
        feature = given.feature
        if kind.floating and given.kind.floating:
            return feature.then(_to(kind)) if kind.rank < given.kind.rank else feature
        if kind.floating:
            least, most = self.ends(feature)
            exact = max(-least, most) <= 2 ** (24 if kind == kinds.FLOAT else 53)
            return feature if exact and kind == DOUBLE else feature.then(_to(kind))
        if given.kind.floating:
            feature = feature.then(Step("truncated", kinds.truncate_float))
        least, most = self.ends(feature)
        if not given.kind.floating and most - least < MAX_TABLE and not (kind.holds(least) and kind.holds(most)):
            return self._tabulate(given, f"as {kind}", lambda v: self._cut_bits(v, kind)).feature
        if least < kind.low or most > kind.high:
            told = "converted to" if given.kind.floating else "made"
            what = f"a number from {least} to {most} is {told} {kind}, which holds {kind.low} to {kind.high}"
            raise self.make_error(what, FLOAT_ADVICE if given.kind.floating else RANGE_ADVICE)
        return feature

    def ends(self, feature: Feature) -> tuple[Any, Any]:
        """The least and the most that a feature is on this path."""
        if self.paths is None:
            raise self.make_error("a feature is read outside a function", TEST_ADVICE)
        if any(step.key.startswith("truncated") for step in feature.steps):
            self.paths.nan = False
        return self.paths.least(feature), -self.paths.least(feature.then(NEGATE))

    # --- operators

    def unary(self, sign: str, value: Value) -> Value:
        """`+`, `-`, `~` and `!` of a value."""
        if sign == "!":
            known = value if isinstance(value, Number) else None
            return Number(int(known.value == 0), INT) if known else Condition(lambda: not self.truth(value))
        given = self._promote_number(self.plain(value))
        if sign == "+":
            return given
        if sign == "-" and given.kind.floating:
            return Number(-given.value, given.kind) if isinstance(given, Number) else self._then(given, NEGATE)
        if sign == "-":
            return self._whole("-", Number(0, given.kind), given, given.kind)
        if given.kind.floating:
            raise self.make_error("bits of a float are used", TEST_ADVICE)
        return self._whole("-", Number(-1 if given.kind.signed else given.kind.high, given.kind), given, given.kind)

    def _promote_number(self, given: Number | Symbol) -> Number | Symbol:
        if given.kind != kinds.ENUM and given.kind.rank >= INT.rank:
            return given
        return Number(given.value, INT, given.name) if isinstance(given, Number) else Symbol(given.feature, INT)

    def common(self, one: Kind, other: Kind) -> Kind:
        """The type in which two numbers meet."""
        if one.rank == other.rank and one.signed != other.signed:
            return kinds.UNSIGNED.get(one, one) if one.signed else one
        high, low = (one, other) if one.rank >= other.rank else (other, one)
        return kinds.ULONG if (high, low) == (kinds.LONG, kinds.UINT) else high

    def binary(self, sign: str, left: Value, right: Value) -> Value:
        """An operator of two numbers."""
        one, other = self.plain(left), self.plain(right)
        enums = [each for each in (one, other) if each.kind == kinds.ENUM]
        one, other = self._promote_number(one), self._promote_number(other)
        if sign in ("<<", ">>"):
            return self._shift_number(sign, one, other)
        kind = self.common(one.kind, other.kind)
        one, other = (self.plain(self.convert_value(each, kind)) for each in (one, other))
        if enums and any(isinstance(each, Number) and each.value < 0 for each in (one, other)):
            raise self.make_error(OF_ENUM.format("meets"), "convert it to int")
        if sign in SIGNS:
            return self._compare_values(sign, one, other)
        if kind.floating:
            return self._floating(sign, one, other, kind)
        whole = self._whole(sign, one, other, kind)
        if enums and isinstance(whole, Number) and whole.value < 0:
            raise self.make_error(OF_ENUM.format("makes"), "convert it to int")
        return whole

    def _compare_values(self, sign: str, one: Number | Symbol, other: Number | Symbol) -> Value:
        if isinstance(one, Number) and isinstance(other, Number):
            return Number(int(SIGNS[sign](one.value, other.value)), INT)
        if isinstance(one, Symbol) and isinstance(other, Symbol):
            one, other = self.summing.compare_symbols(one, other), Number(0, INT)
        if isinstance(one, Number):
            one, other, sign = other, one, TURNED[sign]
        assert isinstance(one, Symbol) and isinstance(other, Number)
        feature, number = one.feature, other.value
        return Condition(lambda: self._holds(feature, sign, number))

    def _then(self, given: Symbol, *steps: Step) -> Symbol:
        return Symbol(given.feature.then(*steps), given.kind)

    def _floating(self, sign: str, one: Number | Symbol, other: Number | Symbol, kind: Kind) -> Value:
        make = kind.float_type
        if isinstance(one, Number) and isinstance(other, Number):
            a, b = make(one.value), make(other.value)
            if sign == "/" and b == 0:
                raise self.make_error("a number is divided by 0", "write the value")
            if sign not in "+-*/":
                raise self.make_error(f"the operator {sign} takes no floats", TEST_ADVICE)
            with np.errstate(all="ignore"):
                return Number(make(FLOATING[sign](a, b)), kind)
        if isinstance(one, Symbol) and isinstance(other, Symbol):
            if sign in "+-" and one.feature.key != other.feature.key:
                return self.summing.add_symbols(sign, one, other, kind)
            return self._square_feature(sign, one, other, kind)
        given, number = (one, other) if isinstance(one, Symbol) else (other, one)
        assert isinstance(given, Symbol) and isinstance(number, Number)
        c, first = make(number.value), given is one
        if not np.isfinite(c) or (sign in "*/" and c == 0) or (sign == "/" and not first) or sign not in "+-*/":
            what = "a number is divided by a feature" if sign == "/" and not first else f"a feature {sign} {c}"
            raise self.make_error(f"{what} is not read", TEST_ADVICE)
        return self._then(given, make_step(sign, c, kind, first=first))

    def build_given(self, values: Sequence[Value]) -> Given | None:
        """Builds a form for each number returned where these depend on features; None: these are labels."""
        given = self.summing.build_given([self.resolve_number(each) for each in values])
        terms = [term for each in given.vector for term in each.terms] if given else []
        self.used |= {place for _, place in terms if place != CONSTANT}
        return given

    def _square_feature(self, sign: str, one: Symbol, other: Symbol, kind: Kind) -> Symbol:
        if sign != "*" or one.feature.key != other.feature.key:
            what = "a product of features" if sign in "*/" else "a sum of several features"
            raise self.make_error(f"{what} is not read", TEST_ADVICE)
        make = kind.float_type
        squared = Rounding(f"squared{kind}", lambda v: make(make(v) * make(v)), FOLDING, lambda v: v * v, kind)
        return self._then(one, squared)

    def _whole(self, sign: str, one: Number | Symbol, other: Number | Symbol, kind: Kind) -> Value:
        if isinstance(one, Number) and isinstance(other, Number):
            return Number(self._compute_number(sign, one.value, other.value, kind), kind)
        if isinstance(one, Symbol) and isinstance(other, Symbol):
            return self._join_whole(sign, one, other, kind)
        given, number = (one, other) if isinstance(one, Symbol) else (other, one)
        assert isinstance(given, Symbol) and isinstance(number, Number)
        c, first = int(number.value), given is one
        if sign in COMPUTE and (sign != "*" or c):
            compute = COMPUTE[sign]
            sense = FALLING if (sign == "*" and c < 0) or (sign == "-" and not first) else RISING
            form = (sign if first or sign != "-" else "c-", c)
            step = Step(f"{sign}{c}{first}", lambda v: compute(v, c) if first else compute(c, v), sense, form=form)
        elif sign == "/" and first and c:
            step = Step(f"//{c}", lambda v: kinds.quotient(v, c), RISING if c > 0 else FALLING)
        elif sign == "*":
            return Number(0, kind)
        else:
            compute_pair = partial(self._compute_number, sign, kind=kind)
            return self._tabulate(
                given, f"{sign}{c}{first}{kind}", lambda v: compute_pair(*((v, c) if first else (c, v)))
            )
        symbol = self._then(Symbol(given.feature, kind), step)
        return self.ensure_fits(symbol, self.ends(symbol.feature))

    def _join_whole(self, sign: str, one: Symbol, other: Symbol, kind: Kind) -> Value:
        """Joins two whole numbers: returns their sum; where that is none, one of few is asked which it is."""
        total = None
        if sign in "+-":
            with suppress(InputError):
                total = self.summing.add_whole(sign, one, other).feature
        few = self.resolve_number(other) if total is None else other
        if isinstance(few, Number):
            return self._whole(sign, one, few, kind)
        if sign not in "+-":
            raise self.make_error(f"the operator {sign} of two features is not read", TEST_ADVICE)
        (low, high), (less, more) = self.ends(one.feature), self.ends(other.feature)
        ends = (low + less, high + more) if sign == "+" else (low - more, high - less)
        return self.ensure_fits(Symbol(total or self.summing.add_whole(sign, one, other).feature, kind), ends)

    def ensure_fits(self, symbol: Symbol, ends: tuple[Any, Any]) -> Symbol:
        """The symbol. The path ends where its number overflows, which C leaves undefined; InputError where it wraps."""
        feature, kind, (least, most) = symbol.feature, symbol.kind, ends
        if kind.low <= least and most <= kind.high:
            return symbol
        if not kind.signed:
            raise self.make_error(f"a number from {least} to {most} wraps around in {kind}", RANGE_ADVICE)
        if self.speculating:
            raise self.make_error("a number may overflow", RANGE_ADVICE)
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
        if told in self._tables:
            return self._then(given, within, self._tables[told])
        known = {v: compute(v) for v in range(low, high + 1)}
        jumps = tuple(v for v in range(low + 1, high + 1) if known[v] < known[v - 1])
        if len(jumps) > MAX_JUMPS:
            what = f"bits or remainders that fall more than {MAX_JUMPS:,} times are not read"
            raise self.make_error(what, "declare it with 8 bits, such as uint8_t, or test its range first")
        sense = JUMPING if jumps else RISING
        self._tables[told] = Step(told, lambda v: known.get(v, v), sense, jumps=jumps)  # v itself: a NaN
        return self._then(given, within, self._tables[told])

    def _compute_number(self, sign: str, a: int, b: int, kind: Kind) -> int:
        """A number of two whole numbers."""
        if sign in ("/", "%"):
            if b == 0:
                raise self.make_error("a number is divided by 0", "write the value")
            whole = kinds.quotient(a, b)
            return self.wrap_number(whole if sign == "/" else a - whole * b, kind)
        if sign in BITS:
            return BITS[sign](a, b)
        if sign not in COMPUTE:
            raise self.make_error(f"the operator {sign} is not read", TEST_ADVICE)
        return self.wrap_number(COMPUTE[sign](a, b), kind)

    def _shift_number(self, sign: str, one: Number | Symbol, other: Number | Symbol) -> Value:
        other = self.resolve_number(other)
        if not isinstance(other, Number) or one.kind.floating or not 0 <= other.value < one.kind.bits:
            raise self.make_error("a shift is not read", "shift by a number within the type")
        factor = 2**other.value
        if isinstance(one, Symbol):
            if sign == ">>" and self.ends(one.feature)[0] < 0:
                raise self.make_error("a negative number may be shifted", RANGE_ADVICE)
            return self._whole("*" if sign == "<<" else "/", one, Number(factor, one.kind), one.kind)
        if one.value < 0:
            raise self.make_error("a negative number is shifted", "write the value")
        return Number(self.wrap_number(one.value * factor if sign == "<<" else one.value // factor, one.kind), one.kind)


def _to(kind: Kind) -> Step:
    """The conversion to a floating type."""
    make = kind.float_type

    def apply(v: Any) -> Any:
        return kinds.round_number(v, kind) if isinstance(v, int) else make(v)

    return Step(f"to {kind}", apply)
