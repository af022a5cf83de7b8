"""Roundings of C: sums of several features, and products that a compiler may join with the sum behind them.

Does: joins features to sums in the type that C adds them in; steps that know their exact result, and the same feature
  as a compiler computes it that rounds a product and a sum once (contraction).
Assumes: each type is evaluated as itself (FLT_EVAL_METHOD 0); a compiler without fast-math.
Does not: reorder anything (symbolic/affine.py), or decide whether a joined pair matters (arithmetic.py).
"""

import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import numpy as np

from codegen.errors import InputError
from codegen.floats import FLOAT32, FLOAT64
from codegen.importers.c.kinds import DOUBLE, FLOAT, GIVEN, Kind, Number, Symbol, round_number
from codegen.importers.reading import SUMS
from codegen.importers.symbolic.affine import IN_ORDER, Affine, Given, Sums
from codegen.importers.symbolic.feature import FALLING, RISING, Feature, Step
from codegen.ir import CONSTANT
from codegen.sums import DOUBLE_SUMS

TEST_ADVICE = "compare one feature, or a sum of features, with a number"
ROUNDINGS = "a product and a sum may be rounded once or twice, as the compiler likes"
CONTRACTED = "compare the feature itself with a number, or say #pragma STDC FP_CONTRACT OFF"
FLOATING: Mapping[str, Callable[[Any, Any], Any]] = {
    "+": operator.add, "-": operator.sub, "*": operator.mul, "/": lambda a, b: a / b,
}  # fmt: skip
NEGATE = Step("negated", operator.neg, FALLING, form=("*", -1))


@dataclass(frozen=True)
class Rounding(Step):
    """A step that rounds an exact result, so that a compiler may join it with another one."""

    exact: Callable[[Fraction], Fraction] = field(default=lambda exact: exact, compare=False)
    kind: Kind = DOUBLE
    sums: bool = False  # whether it adds; else it multiplies


def make_step(sign: str, c: Any, kind: Kind, *, first: bool) -> Step:
    """Arithmetic of a feature, which stands `first` or last, and a number of its type."""
    make = kind.float_type
    compute, exact = FLOATING[sign], Fraction(float(c))

    def apply(v: Any) -> Any:
        return make(compute(make(v), c) if first else compute(c, make(v)))

    falls = (sign == "-" and not first) or (sign in "*/" and c < 0)
    key, sense = f"{sign}{c!r}{first}{kind}", FALLING if falls else RISING
    form = (sign if first or sign != "-" else "c-", c)
    if sign == "/":  # which no compiler joins with another step
        return Step(key, apply, sense, form=form)

    def precisely(v: Fraction) -> Fraction:
        return compute(v, exact) if first else compute(exact, v)

    return Rounding(key, apply, sense, precisely, kind, sign in "+-", form=form)


def contract_feature(feature: Feature) -> Feature | None:
    """The feature with each product kept exact until the sum that follows it; None: there is no such pair."""
    steps, product, pairs = list[Step](feature.steps), -1, 0
    for at, step in enumerate(feature.steps):
        before = feature.steps[product] if product >= 0 else None
        if isinstance(step, Rounding) and step.sums and isinstance(before, Rounding) and before.kind == step.kind:
            steps[product] = _exact(before)
            steps[at], pairs = _once(step), pairs + 1
        if not isinstance(step, Rounding) and step is not NEGATE:
            product = -1
        elif isinstance(step, Rounding):
            product = -1 if step.sums else at
    return Feature(feature.place, tuple(steps)) if pairs else None


def _exact(product: Rounding) -> Step:
    """A product without its rounding."""

    def apply(v: Any) -> Any:
        return product.exact(Fraction(float(v))) if np.isfinite(v) else product.apply(v)

    return Step(f"exactly {product.key}", apply, product.sense)


def _once(total: Rounding) -> Step:
    """A sum of an exact number."""

    def apply(v: Any) -> Any:
        return round_number(total.exact(v), total.kind) if isinstance(v, Fraction) else total.apply(v)

    return Step(f"once {total.key}", apply, total.sense)


# --- sums


def _as_given(symbol: Symbol) -> Symbol:
    """A number without the step that makes a float of it, where nothing else is computed of it."""
    plain = [each.key for each in symbol.feature.steps] == [GIVEN]
    return Symbol(Feature(symbol.feature.place), symbol.kind) if plain else symbol


class Summing:
    """The sums of one function. `numbers`: of the observation; `contracts`: whether a compiler may join roundings."""

    def __init__(self, make_error: Callable[[str, str], InputError], numbers: str, *, contracts: bool) -> None:
        self._make_error, self._numbers, self._contracts = make_error, numbers, contracts
        self.sums = Sums("")
        self.finite = False  # whether two features are compared

    def add_symbols(self, sign: str, one: Symbol, other: Symbol, kind: Kind) -> Symbol:
        """A sum or difference. InputError where its roundings have no order, or compilers differ."""
        found = self._add_features(sign, one, other, kind)
        self._ensure_one_rounding(self._form_of(found))
        return Symbol(found, kind)

    def compare_symbols(self, one: Symbol, other: Symbol) -> Symbol:
        """A difference, whose sign is that of the comparison, unless both are the same infinity."""
        if one.feature.key == other.feature.key:
            raise self._make_error("a feature is compared with itself", TEST_ADVICE)
        if not one.kind.floating:
            return self.add_whole("-", one, other)
        self.finite, kind = True, one.kind
        if self._numbers == FLOAT64:  # floats that are given as they are lie among the doubles
            one, other = map(_as_given, (one, other))
            kind = kind if one.feature.steps or other.feature.steps else DOUBLE
        return Symbol(self._add_features("-", one, other, kind), kind)

    def add_whole(self, sign: str, one: Symbol, other: Symbol) -> Symbol:
        """A sum or difference of whole numbers, which floats have exactly."""
        single = self._numbers == FLOAT32
        plain = [Symbol(Feature(each.feature.place, each.feature.steps[1:]), each.kind) for each in (one, other)]
        total = self._add_features(sign, plain[0], plain[1], FLOAT if single else DOUBLE)
        most = 2**16 if single else 2**32  # of an input: `Kind.fits_float32`
        sizes = [abs(weight) * (1 if place == CONSTANT else most) for weight, place in self._form_of(total).terms]
        if sum(sizes) > (2**24 if single else 2**53):
            raise self._make_error("a sum of whole numbers may be no float", TEST_ADVICE)
        return Symbol(total, one.kind)

    def _form_of(self, total: Feature) -> Affine:
        return self.sums.known[total.place - SUMS]

    def build_given(self, values: Sequence[Number | Symbol]) -> Given | None:
        """Builds a form for each number returned where these depend on features; None: these are labels."""
        symbols = [each for each in values if isinstance(each, Symbol)]
        if not symbols or not all(each.kind.floating for each in symbols):
            return None
        for each in symbols:
            self._compute_in(each.kind)
        return Given([self._form(each) for each in values])

    def inputs(self, feature: Feature) -> set[int]:
        """The inputs that a feature is computed of."""
        if feature.place < SUMS:
            return {feature.place}
        return {place for _, place in self._form_of(feature).terms if place != CONSTANT}

    def _form(self, value: Number | Symbol) -> Affine:
        given = value.feature if isinstance(value, Symbol) else value.value
        form = self.sums.represent(given, self._make_error)
        self._ensure_weights(form)
        self._ensure_one_rounding(form)
        return form

    def _add_features(self, sign: str, one: Symbol, other: Symbol, kind: Kind) -> Feature:
        self._compute_in(kind)
        total = self.sums.add_features(one.feature, other.feature, minus=sign == "-")
        if total is None:
            raise self._make_error("two sums are joined whose roundings have no order", IN_ORDER)
        self._ensure_weights(self._form_of(total))
        return total

    def _compute_in(self, kind: Kind) -> None:
        """Sums are of this type from now on. InputError where others are of another one."""
        numbers = FLOAT32 if kind == FLOAT else FLOAT64
        if self.sums.numbers not in ("", numbers):
            raise self._make_error("sums of float and of double stand side by side", "use one type for all of them")
        if (self._numbers, numbers) == (FLOAT64, FLOAT32):
            what = "sums of float stand in a function that is given doubles, or whole numbers of more than 16 bits"
            raise self._make_error(what, "use double for all of them, or declare whole numbers int16_t or smaller")
        self.sums.numbers, self.sums.weights = numbers, self._numbers

    def _ensure_weights(self, form: Affine) -> None:
        """InputError for products of a float and a double that is none, which no profile has."""
        for weight, place in form.terms if self.sums.arithmetic == DOUBLE_SUMS else ():
            if place != CONSTANT and float(np.float32(weight)) != weight:
                what = f"a float is multiplied with {weight!r}, which is no float"
                raise self._make_error(what, "write it as a float, such as 0.1f, or let the observation be double")

    def _ensure_one_rounding(self, form: Affine) -> None:
        """InputError for products that a compiler may join with the sum behind them; those of floats in double are
        exact, so that nothing is to be joined.
        """
        if not self._contracts or len(form.terms) < 2 or self.sums.arithmetic == DOUBLE_SUMS:
            return
        if any(abs(weight) != 1 and place != CONSTANT for weight, place in form.terms):
            raise self._make_error(ROUNDINGS, CONTRACTED)
