"""Sums of several inputs, as a program adds them: an affine form for each, and a place beside the inputs.

Does: turns steps on one input into a term; joins terms where the order of additions allows it exactly; gives each
  sum a place, so that a test of it turns as a test of an input does.
Assumes: one arithmetic for all of them, that of the numbers that the program compares.
Does not: reorder roundings: a sum of two sums, a sum that is scaled, or a feature twice have no place.

What is returned may end with minima and maxima by numbers: they are the bounds of an output.

Addition commutes exactly, and so does a sign with products and sums, but for the sign of a zero: a negated sum keeps
its value and not that. Such a sum may be tested, and is no output.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, TypeAlias, cast

import numpy as np

from codegen.errors import InputError
from codegen.floats import FLOAT32
from codegen.importers.reading import SUMS
from codegen.importers.symbolic.feature import Feature, Step
from codegen.ir import CONSTANT, Floats
from codegen.sums import DOUBLE_SUMS, FLOAT32_STEPS, FLOAT64_SUMS

Terms = tuple[tuple[float, int], ...]
Bounds = tuple[float | None, float | None]
Columns: TypeAlias = "Sequence[Floats] | Mapping[int, Floats]"  # of inputs, by their places
# forms of steps: (name, number or both, whether a zero keeps its sign at a bound of 0)
CUTTING = ("min", "max", "clip")
IN_ORDER = "write w0 * x[0] + w1 * x[1] + ... + c, each feature once, without parentheses, and scale no sum"
CUT_BEFORE = "; a number that is cut first: y = low if x < low else high if x > high else x"
NO_SUM = "what is returned is no sum of weighted features"


@dataclass(frozen=True)
class Cut:
    """The bounds that a returned sum is cut to, and the steps of the program that cut it."""

    bounds: Bounds
    steps: tuple[Step, ...] = field(compare=False, repr=False)

    def value(self, given: Any) -> Any:
        """A number of the program after the steps."""
        for step in self.steps:
            given = step.apply(given)
        return given


class Affine(NamedTuple):
    """Terms (weight, place of the input), in the order of the additions."""

    terms: Terms
    signed: bool = True  # whether its zeros have the signs of the program's
    cut: Cut | None = None  # of what is returned

    @property
    def alone(self) -> bool:
        """True if it is a number."""
        return all(place == CONSTANT for _, place in self.terms)

    def negate(self) -> "Affine":
        """With all signs turned."""
        return Affine(tuple((-weight, place) for weight, place in self.terms), self.signed and len(self.terms) == 1)

    def plus(self, other: "Affine") -> "Affine | None":
        """The sum, exactly; None where both are sums of several, or have something in common."""
        if {place for _, place in self.terms} & {place for _, place in other.terms}:
            return None
        first, last = (other, self) if len(other.terms) > 1 else (self, other)
        if len(last.terms) > 1:
            return None
        return Affine(first.terms + last.terms, self.signed and other.signed)


@dataclass
class Sums:
    """The sums of a program, by their places."""

    numbers: str  # that it computes with; "": it has not said yet
    weights: str = ""  # what features and weights are; "": the same
    places: dict[str, int] = field(default_factory=dict[str, int])
    known: list[Affine] = field(default_factory=list[Affine])
    line: int = 0  # of the source, where the first one is

    @property
    def arithmetic(self) -> str:
        """Its name in a profile."""
        if self.numbers == FLOAT32:
            return FLOAT32_STEPS
        return DOUBLE_SUMS if self.weights == FLOAT32 else FLOAT64_SUMS

    def numbers_of(self, feature: Feature, numbers: str) -> str:
        """Returns the type of an input's numbers, which is `numbers`, or that of a sum."""
        return self.numbers if feature.place >= SUMS else numbers

    def constant(self, number: Any) -> float | None:
        """A number of the program; None where its arithmetic would be another one."""
        kind: Any = np.dtype(self.numbers).type
        if isinstance(number, np.generic) and type(cast("Any", number)) is not kind:
            return None
        try:
            with np.errstate(over="ignore"):
                value = float(kind(number))
        except (OverflowError, TypeError, ValueError):
            return None
        return value if math.isfinite(value) else None

    def of(self, feature: Feature) -> Affine | None:
        """The form of a feature; None where its steps are no terms."""
        if feature.place >= SUMS:
            form: Affine | None = self.known[feature.place - SUMS]
        else:
            form = Affine(((1.0, feature.place),))
        for step in feature.steps:
            if form is not None and step.key != self.numbers:  # else a conversion to what it is already
                form = self._apply_step(form, step.form)
        return form

    def represent(self, value: Any, make_error: Callable[[str, str], InputError]) -> Affine:
        """The form of what a program returns: of a number as it is, or of a feature, which may end with minima and
        maxima by numbers. InputError where there is none, as for 0.1 among float32.
        """
        if not isinstance(value, Feature):
            number = self.constant(value)
            if number is None or number != value:
                what = f"{value!r} is returned among numbers that are {self.numbers}, and is none"
                raise make_error(what, "round it in the source")
            return Affine(((number, CONSTANT),))
        steps = value.steps
        first = len(steps)
        while first and (_cuts(steps[first - 1]) or steps[first - 1].key == self.numbers):
            first -= 1
        form, cutting = self.of(Feature(value.place, steps[:first])), steps[first:]
        if form is None:
            raise make_error(NO_SUM, IN_ORDER)
        if not any(map(_cuts, cutting)):
            return form
        bounds = self._bounds([step for step in cutting if _cuts(step)], make_error)
        return form._replace(cut=Cut(bounds, cutting))

    def _bounds(self, cutting: Sequence[Step], make_error: Callable[[str, str], InputError]) -> Bounds:
        """Returns the bounds that minima and maxima, one after the other, leave of all numbers."""
        low, high = -math.inf, math.inf
        for step in cutting:
            assert step.form is not None
            name, given, keeps = step.form
            ends = [self.constant(each) for each in (given if name == "clip" else (given,))]
            values = [end for end in ends if end is not None]
            if len(values) < len(ends):
                raise make_error(f"what is returned is cut by numbers that are not {self.numbers}", IN_ORDER)
            if 0 in values and not keeps:
                raise make_error("what is returned is cut at 0, and the sign of the zero there is not known", IN_ORDER)
            for most, value in zip((False, True) if name == "clip" else (name == "min",), values, strict=True):
                cut = min if most else max
                low, high = cut(low, value), cut(high, value)
        return None if low == -math.inf else low, None if high == math.inf else high

    def _apply_step(self, affine: Affine, form: tuple[Any, ...] | None) -> Affine | None:
        """A form after `form`: an operation, and its number; "c-": the number minus the form."""
        value = None if form is None or form[0] in CUTTING else self.constant(form[1])
        if form is None or value is None:
            return None
        if form[0] in ("*", "/"):
            return self._scale_form(affine, value if form[0] == "*" else _reciprocal(value))
        added = Affine(((-value if form[0] == "-" else value, CONSTANT),))
        return (affine.negate() if form[0] == "c-" else affine).plus(added)

    def _scale_form(self, affine: Affine, factor: float | None) -> Affine | None:
        """A product: of one input, or of a sum and a sign."""
        if factor in (1.0, -1.0):
            return affine if factor == 1 else affine.negate()
        if factor is None or len(affine.terms) != 1 or affine.alone:
            return None
        weight, place = affine.terms[0]
        vanishes = abs(factor) < float(np.finfo(self.numbers).tiny)  # zero, or subnormal
        return None if vanishes or abs(weight) != 1 else Affine(((factor * weight, place),))

    def add_features(self, left: Feature, right: Feature, *, minus: bool) -> Feature | None:
        """The sum or difference of two features as a feature; None where it has no form."""
        one, other = self.of(left), self.of(right)
        if one is None or other is None:
            return None
        form = one.plus(other.negate() if minus else other)
        return None if form is None else Feature(self.place(form))

    def place(self, affine: Affine) -> int:
        """The place of a sum."""
        key = repr(affine)
        if key not in self.places:
            self.places[key] = SUMS + len(self.known)
            self.known.append(affine)
        return self.places[key]

    def column(self, place: int, columns: Columns) -> Floats:
        """The values of a sum for many observations, as doubles."""
        return sum_terms(self.known[place - SUMS].terms, columns, self.numbers)


def _cuts(step: Step) -> bool:
    return step.form is not None and step.form[0] in CUTTING


def sum_terms(terms: Terms, columns: Columns, numbers: str) -> Floats:
    """The value of each sum, term after term, as doubles."""
    kind, count = np.dtype(numbers).type, len(columns[0]) if columns else 0
    total: Any = None
    with np.errstate(all="ignore"):
        for weight, place in terms:
            each = np.full(count, weight, kind) if place == CONSTANT else columns[place].astype(kind)
            if place != CONSTANT and weight != 1:
                each = -each if weight == -1 else each * kind(weight)
            total = each if total is None else total + each
    return np.asarray(total, dtype=np.float64)


def _reciprocal(value: float) -> float | None:
    """1 / value where dividing by it is multiplying with that: of powers of two."""
    mantissa, exponent = math.frexp(value)
    return math.ldexp(2 * mantissa, 1 - exponent) if abs(mantissa) == 0.5 and abs(exponent) < 100 else None


class Given:
    """The forms that a path gives, one for each output. Equal only if every bit is."""

    def __init__(self, vector: Sequence[Affine]) -> None:
        self.vector = tuple(vector)
        self._key = repr(self.vector)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Given) and self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)
