"""Tests of one number of the observation, where among all floats their answer turns; sums of several numbers.

Does: floats in their order, counted from 0 outwards; a feature as a chain of steps on one input; the truth of a test
  at a number; the places where it changes, found by bisection through the steps' own arithmetic. Turns steps on one
  input into a term; joins terms where the order of additions allows it exactly; gives each sum a place beside the
  inputs, so that a test of it turns as a test of an input does.
Assumes: each step never falls, never rises, falls below 0 and rises from there on, or takes few whole numbers; it takes
  every float, also infinite ones, and gives NaN for NaN only. One arithmetic for all sums, that of the numbers that the
  program compares.
Does not: follow a program, or know a language: steps and comparisons compute with the scalars that a front end chose.
  It reorders no roundings: a sum that is added to another one, or scaled, stays a sum by itself in it.

Additions of, products with and quotients by finite numbers that are not 0, minima, maxima, conversions and roundings
are such steps, in any precision. They may be constant on stretches and overflow: what is found is exact nevertheless.
What is returned may end with minima and maxima by numbers: they are the bounds of an output.

Addition commutes exactly, and so does a sign with a product; a sum keeps the sign before it.
"""

import math
import operator
import struct
from bisect import bisect_right
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import partial
from typing import Any, NamedTuple, TypeAlias, cast

import numpy as np

from codegen.errors import InputError
from codegen.floats import FLOAT32, FLOAT64
from codegen.importers.reading import SUMS
from codegen.ir import CONSTANT, Floats
from codegen.numbers import nearest_double
from codegen.sums import DOUBLE_SUMS, FLOAT32_STEPS, FLOAT64_SUMS, Sum, Weight, divisor_of

SIGNS: Mapping[str, Callable[[Any, Any], Any]] = {
    "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge, "==": operator.eq, "!=": operator.ne,
}  # fmt: skip
TURNED = {"<": ">", "<=": ">=", ">": "<", ">=": "<=", "==": "==", "!=": "!="}
RISING, FALLING, FOLDING = "rising", "falling", "folding"  # folding: falls below 0, rises from 0 on
JUMPING = "jumping"  # of few whole numbers: anything for each of them
Number: TypeAlias = int | float
LAST: dict[str, int] = {FLOAT32: 0x7F800000, FLOAT64: 0x7FF0000000000000}  # the places of infinity
BITS = {FLOAT32: ("<i", "<f", 1 << 31), FLOAT64: ("<q", "<d", 1 << 63)}  # forms of struct, and the bit of the sign


# --- floats in their order: 0.0 and -0.0 share the place 0, infinities are the ends


def at_most(number: Number) -> float:
    """The largest double that is not above a number."""
    near = nearest_double(number) if isinstance(number, int) else float(number)
    return near if near <= number else math.nextafter(near, -math.inf)


def below(number: Number) -> float:
    """The largest double that is below a number."""
    near = at_most(number)
    return math.nextafter(near, -math.inf) if near == number else near


def place(value: float, numbers: str) -> int:
    """The place of the largest of the `numbers` that is not above a double; infinities are the ends."""
    whole, real, sign = BITS[numbers]
    try:
        bits: int = struct.unpack(whole, struct.pack(real, value))[0]  # of the nearest one
    except OverflowError:
        return LAST[numbers] - 1 if value > 0 else -LAST[numbers]
    at = bits if bits >= 0 else -(bits + sign)
    return at - (number(at, numbers) > value)


def number(at: int, numbers: str) -> float:
    """The number at a place."""
    whole, real, _ = BITS[numbers]
    value: float = struct.unpack(real, struct.pack(whole, abs(at)))[0]
    return -value if at < 0 else value


# --- features and their tests


@dataclass(frozen=True)
class Step:
    """A computation on one number. `key` says all that it does: equal keys, equal steps."""

    key: str
    apply: Callable[[Any], Any]
    sense: str = RISING
    form: tuple[Any, ...] | None = field(default=None, kw_only=True)  # of arithmetic with a number, see Sums
    jumps: tuple[int, ...] = field(default=(), kw_only=True)  # of JUMPING: whole numbers between which it never falls


def arithmetic_step(key: str, sign: str, number: Any, compute: Callable[[Any, Any], Any], *, turned: bool) -> Step:
    """A sum with a number, a difference, product or quotient. `turned`: the number stands first."""
    falls = (sign == "-" and turned) or (sign in "*/" and number < 0)

    def apply(value: Any) -> Any:
        return compute(number, value) if turned else compute(value, number)

    return Step(key, apply, FALLING if falls else RISING, form=("c-" if sign == "-" and turned else sign, number))


@dataclass(frozen=True)
class Feature:
    """An input, by its place, and what is computed of it, first step first. Without steps it is the input itself."""

    place: int
    steps: tuple[Step, ...] = ()

    def then(self, *steps: Step) -> "Feature":
        """The feature with further steps."""
        return Feature(self.place, self.steps + steps)

    def value(self, given: float) -> Any:
        """Computes the feature from a number of the observation."""
        value: Any = given
        for step in self.steps:
            value = step.apply(value)
        return value

    @property
    def key(self) -> str:
        """Equal for equal features."""
        return f"{self.place};{';'.join(step.key for step in self.steps)}"


@dataclass(frozen=True)
class Test:
    """A comparison of a feature with a number; of one without steps, exactly, as whole numbers or doubles."""

    __test__ = False  # no test of pytest

    feature: Feature
    sign: str
    number: Any  # not NaN

    def at(self, given: float) -> bool:
        """Returns True if it holds for a number of the observation."""
        return bool(SIGNS[self.sign](self.feature.value(given), self.number))

    @property
    def key(self) -> str:
        """Equal for equal tests."""
        return f"{self.feature.key} {self.sign} {type(self.number).__name__} {self.number!r}"


class Turn(NamedTuple):
    """The last place where a test answers as below it, and a double that separates it from the next place."""

    place: int
    threshold: float


class Turns(NamedTuple):
    """The answers of a test: `first` at the lowest number, then another one after each turn, and one for NaN."""

    first: bool
    turns: tuple[Turn, ...]  # ascending
    nan: bool


def turns_of(test: Test, numbers: str) -> Turns:
    """All turns of a test among the `numbers`."""
    last = LAST[numbers]
    candidates = _exact(test, numbers) if not test.feature.steps else _search_turns(test, numbers)
    if len(candidates) == 1 and -last <= candidates[0].place < last:
        return Turns(test.sign in ("<", "<="), tuple(candidates), nan=False)  # an input and an order: most are this
    first = answer = test.at(number(-last, numbers))
    turns: list[Turn] = []
    for each in sorted(set(candidates)):
        if -last <= each.place < last and test.at(number(each.place + 1, numbers)) != answer:
            answer = not answer
            turns.append(each)
    return Turns(first, tuple(turns), test.at(float("nan")))


def _exact(test: Test, numbers: str) -> list[Turn]:
    """Where a comparison of an input itself may turn."""
    given: Number = test.number
    ends = {"<": (below,), ">=": (below,), "<=": (at_most,), ">": (at_most,)}.get(test.sign, (below, at_most))
    return [Turn(place(end(given), numbers), end(given)) for end in ends]


def _search_turns(test: Test, numbers: str) -> list[Turn]:
    """Where a comparison of steps may turn: where they pass the number, and where they turn themselves."""
    feature, given = test.feature, test.number
    places: list[int] = []
    for low, high, _ in pieces(feature, numbers):
        places.append(high)
        for sign in (operator.lt, operator.le):
            places.append(_last(low, high, lambda at, sign=sign: sign(feature.value(number(at, numbers)), given)))
    return [Turn(each, number(each, numbers)) for each in places]


def pieces(feature: Feature, numbers: str) -> list[tuple[int, int, bool]]:
    """Stretches of places, first to last, on which the steps never fall (True) or never rise, and give one type.

    A minimum or maximum gives its number where it takes that, as `max(x, 0.5)` of a float32 number gives Python's 0.5:
    0.49999999999999994 is another number beside this one, but the same beside the float32 number 0.5.
    """
    stretches = [(-LAST[numbers], LAST[numbers], True)]
    for count, step in enumerate(feature.steps):
        before = Feature(feature.place, feature.steps[:count])
        if step.sense == FALLING:
            stretches = [(low, high, not rising) for low, high, rising in stretches]
        elif step.sense != RISING:
            split = partial(_side_of, step, before, numbers)
            parts = [(*part, rising) for low, high, rising in stretches for part in _alike(low, high, split)]
            if step.sense == FOLDING:
                stretches = [(low, high, rising != split(low)) for low, high, rising in parts]
            else:
                stretches = [(low, high, rising if step.jumps else True) for low, high, rising in parts]
        given = partial(_type_of, Feature(feature.place, feature.steps[: count + 1]), numbers)
        stretches = [
            (*part, rising)
            for low, high, rising in stretches
            for part in ([(low, high)] if given(low) == given(high) else _alike(low, high, given))
        ]
    return stretches


def is_whole(feature: Feature) -> bool:
    """Returns True if a feature gives whole numbers of Python wherever it is finite; max(x, 3) does only up to 3."""
    if not isinstance(feature.value(1.0), int):
        return False
    ends = {end for low, high, _ in pieces(feature, FLOAT64) for end in (low, high)}
    values = [feature.value(number(end, FLOAT64)) for end in ends]
    return all(isinstance(value, int) or not math.isfinite(value) for value in values)


def _type_of(feature: Feature, numbers: str, at: int) -> type[object]:
    """The type of what a feature gives at a place: a step changes it once, from one end of a stretch to the other."""
    value: object = feature.value(number(at, numbers))
    return type(value)


def _side_of(step: Step, before: Feature, numbers: str, at: int) -> Any:
    """Where a folding or jumping step is met at a place: below 0, or between which jumps; without any, by which number
    it is.
    """
    value = before.value(number(at, numbers))
    if step.sense == FOLDING:
        return bool(value < 0)
    return bisect_right(step.jumps, value) if step.jumps else value


def _alike(low: int, high: int, group: Callable[[int], Any]) -> Iterator[tuple[int, int]]:
    """Stretches of places, first to last, of one group each."""
    while low <= high:
        first = group(low)
        end = _last(low, high, lambda at, first=first: group(at) == first)
        yield low, end
        low = end + 1


def _last(low: int, high: int, holds: Callable[[int], Any]) -> int:
    """The last place from `low` on that answers as `low` does, where the answer turns at most once."""
    first = bool(holds(low))
    while low < high:
        middle = (low + high + 1) // 2
        if bool(holds(middle)) == first:
            low = middle
        else:
            high = middle - 1
    return low


# --- sums

Terms = tuple[tuple[Weight, int | Sum], ...]
Bounds = tuple[float | None, float | None]
Columns: TypeAlias = "Sequence[Floats] | Mapping[int, Floats]"  # of inputs, by their places
# forms of steps: (name, number or both, whether a zero keeps its sign at a bound of 0)
CUTTING = ("min", "max", "clip")
IN_ORDER = "add, subtract, multiply with and divide by numbers only: y = c + w0 * x[0] + w1 * (x[1] - x[2])"
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
    """Terms (weight, place of the input or a sum), in the order of the additions."""

    terms: Terms
    cut: Cut | None = None  # of what is returned

    @property
    def places(self) -> list[int]:
        """The inputs that it reads; none where it is a number."""
        return Sum(self.terms).places

    def within(self, factor: Weight = 1.0) -> "Affine":
        """A single term, which weighs the form."""
        return Affine(((factor, Sum(self.terms)),))

    def scale(self, factor: Weight) -> "Affine":
        """The product with a number, or the quotient, exactly."""
        weight, place = self.terms[0]
        if len(self.terms) == 1 and abs(weight) == 1:
            return Affine(((-factor if weight < 0 else factor, place),))
        return Affine(((-weight, place),)) if len(self.terms) == 1 and factor == -1 else self.within(factor)

    def plus(self, other: "Affine") -> "Affine":
        """The sum, exactly: from left to right, or with an inner sum where the program computes one by itself."""
        first, last = (other, self) if len(self.terms) == 1 < len(other.terms) else (self, other)
        last = last if len(last.terms) == 1 else last.within()
        twice = last.terms[0][1] in [place for _, place in first.terms if not isinstance(place, Sum)]
        first = first.within() if twice else first
        return Affine(first.terms + last.terms)

    def minus(self, other: "Affine") -> "Affine":
        """The difference, exactly but for the sign of a zero, which no comparison tells: with the fewest inner sums."""
        if len(self.terms) > 1:
            return self.plus(other.scale(-1.0))
        return self.plus(Affine(tuple((-weight, place) for weight, place in other.terms)))


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
                advice = "let the number come last: max(min(u, 1.0), 0.0), or 0.0 if u < 0.0 else u"
                raise make_error("what is returned is cut at 0, and the sign of the zero there is not known", advice)
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
            if value == 1:
                return affine
            # none by numbers that are zero or subnormal
            vanishes = not affine.places or abs(value) < float(np.finfo(self.numbers).tiny)
            return None if vanishes else affine.scale(_reciprocal(value) if form[0] == "/" else value)
        added = Affine(((-value if form[0] == "-" else value, CONSTANT),))
        return (affine.scale(-1.0) if form[0] == "c-" else affine).plus(added)

    def add_features(self, left: Feature, right: Feature, sign: str) -> Feature | None:
        """The sum ("+") or difference ("-") of two features as a feature, or one with the sign of the difference ("<");
        None where it has no form.
        """
        one, other = self.of(left), self.of(right)
        if one is None or other is None:
            return None
        if sign == "<":
            return Feature(self.place(one.minus(other)))
        return Feature(self.place(one.plus(other.scale(-1.0) if sign == "-" else other)))

    def place(self, affine: Affine) -> int:
        """The place of a sum."""
        key = repr(affine)
        if key not in self.places:
            self.places[key] = SUMS + len(self.known)
            self.known.append(affine)
        return self.places[key]

    def repeats(self, place: int) -> bool:
        """Returns True if a sum reads an input twice, so that it is NaN where that alone is infinite."""
        named = [each for part in Sum(self.known[place - SUMS].terms).parts() for _, each in part.terms]
        inputs = [each for each in named if not isinstance(each, Sum) and each != CONSTANT]
        return len({*inputs}) < len(inputs)

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
            if place == CONSTANT:
                each: Any = np.full(count, weight, kind)
            else:
                seen = sum_terms(place.terms, columns, numbers) if isinstance(place, Sum) else columns[place]
                each = seen.astype(kind)
                divisor = divisor_of(weight)
                if divisor is None:
                    each = each if weight == 1 else -each if weight == -1 else each * kind(weight)
                else:
                    each = each / kind(divisor)
            total = each if total is None else total + each
    return np.asarray(total, dtype=np.float64)


def _reciprocal(value: float) -> Weight:
    """The weight that divides by a number: a factor where this is a power of two, else a fraction."""
    mantissa, exponent = math.frexp(value)
    power = abs(mantissa) == 0.5 and abs(exponent) < 100
    return math.ldexp(2 * mantissa, 1 - exponent) if power else 1 / Fraction(value)


class Given:
    """The forms that a path gives, one for each output. Equal only if every bit is."""

    def __init__(self, vector: Sequence[Affine]) -> None:
        self.vector = tuple(vector)
        self._key = repr(self.vector)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Given) and self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)
