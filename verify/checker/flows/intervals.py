"""Intervals as pairs of float64 arrays, rounded outward, and tapes of operations on them.

Does: sums, products, quotients, powers, sin, cos, exp and roots of intervals, element by element; writes operations
  down, each once, and computes those that wait for nothing more in one go, for many boxes at a time.
Assumes: rounding to nearest with subnormals, which covers/rounding.py asks for; sums and products in any order, as
  numpy computes them.
Does not: refuse what is not finite (bounds that are infinite or NaN stay so, and `finite` tells); call a library's sin,
  cos or exp, whose errors nobody states; know flows.

A float that is computed by one operation lies within half a step of the exact result, so the next float on the safe
side bounds it. Products with an interval that is exactly 0 are exactly 0, and sums are exact where no error was made.

sin and cos. k is the whole number next to 2 x / pi, and y = x - k pi / 2 is computed as (x - k P) - k Q. P has 33
bits and |k| < 2**20, so k P is exact; |pi / 2 - P - Q| < 2**-86. Two subtractions and one product round, by at most
2**-53 in all that counts, so y is off by less than 2**-51, and |y| < 0.8. The series end at y**17 / 17! and y**18 /
18!, and leave less than 2**-62. Horner's scheme with 9 steps is off by at most 20 * 2**-53 * cosh(0.8) < 2**-48. In
all less than 2**-46.

exp. k is next to x / ln 2, y = (x - k L) - k M with L of 33 bits, |y| < 0.36; the series ends at y**13 / 13! and leaves
less than 2**-57 of the value. Horner's scheme with 13 steps and the error of y are off by less than 2**-46 of the
value in all, and 2**k is exact.

A program computes what is written on a tape, operation by operation, so that bounds are the floats of a plain
evaluation. Only the order is another: all sums that can be computed, then all products, and so on. Few large arrays
take the place of many small ones, with which numpy takes as long.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from math import factorial
from typing import NamedTuple

import numpy as np

from codegen.ir import Bool, Float64, Int64
from verify.checker.covers.rounding import Factor, around, lower, sum_down, sum_up

Index = int | slice | Bool | Int64 | tuple[int | slice | None, ...]
RELATIVE = 1.0 + 2.0**-44  # more than rounding takes from a sum of at most 500 products that are not negative
LEAST = 2.0**-1000


class Spans(NamedTuple):
    """Intervals: `low` and `high` of one shape."""

    low: Float64
    high: Float64

    @property
    def ends(self) -> Float64:
        """The same as one array, [2, ...]: bounds from below of the numbers, and of their negatives."""
        ends = np.empty((2, *self.low.shape))  # faster than to stack
        ends[0], ends[1] = self.low, -self.high
        return ends

    def at(self, index: Index) -> Spans:
        """Some of them."""
        return Spans(self.low[index], self.high[index])

    @property
    def middle(self) -> Float64:
        """About the middles."""
        return 0.5 * self.low + 0.5 * self.high

    @property
    def largest(self) -> Float64:
        """The largest absolute value in each."""
        return np.maximum(np.abs(self.low), np.abs(self.high))

    def around(self, middle: Float64) -> Float64:
        """At most how far each comes from a number."""
        return round_up(np.maximum(self.high - middle, middle - self.low))


def round_up(values: Float64) -> Float64:
    """At least the sums that were computed as these values, of products that are not negative."""
    return np.maximum(values, 0.0) * RELATIVE + LEAST


def exact(number: Fraction, count: int) -> Spans:
    """An exact number, `count` times."""
    low, high = around(number)
    return Spans(np.full(count, low), np.full(count, high))


def of_ends(ends: Float64) -> Spans:
    """Intervals by their ends."""
    return Spans(ends[0], -ends[1])


def plus(one: Spans, other: Spans) -> Spans:
    """Sums."""
    return of_ends(sum_down(one.ends, other.ends))


def minus(one: Spans, other: Spans) -> Spans:
    """Differences."""
    return Spans(sum_down(one.low, -other.high), sum_up(one.high, -other.low))


def times(one: Spans, other: Spans) -> Spans:
    """Products."""
    return of_ends(multiply_ends(one.ends, other.ends))


def multiply_ends(one: Float64, other: Float64) -> Float64:
    """Products, by ends: those of like ends bound the products as they are, those of unlike ends their negatives."""
    alike, unlike = one * other, one * other[::-1]
    products = np.empty_like(alike)
    np.minimum(np.minimum(alike[0], alike[1]), -np.maximum(unlike[0], unlike[1]), out=products[0])
    np.minimum(-np.maximum(alike[0], alike[1]), np.minimum(unlike[0], unlike[1]), out=products[1])
    nothing = ((one[0] == 0.0) & (one[1] == 0.0)) | ((other[0] == 0.0) & (other[1] == 0.0))
    return np.where(nothing, 0.0, lower(products))


def scale_spans(span: Spans, factor: Factor) -> Spans:
    """Multiples by one exact number other than 0."""
    ends = span.ends if factor.positive else -span.ends[::-1]
    return of_ends(factor.times_down(ends))


def square(span: Spans) -> Spans:
    """Squares, which are not below 0."""
    ends = span.low * span.low, span.high * span.high
    low = np.where((span.low <= 0.0) & (span.high >= 0.0), 0.0, np.nextafter(np.minimum(*ends), -np.inf))
    nothing = (span.low == 0.0) & (span.high == 0.0)
    return Spans(np.maximum(low, 0.0), np.where(nothing, 0.0, np.nextafter(np.maximum(*ends), np.inf)))


def inverse(span: Spans) -> Spans:
    """1 over each; NaN where that may be 0."""
    apart = (span.low > 0.0) | (span.high < 0.0)
    low, high = np.nextafter(1.0 / span.high, -np.inf), np.nextafter(1.0 / span.low, np.inf)
    return Spans(np.where(apart, low, np.nan), np.where(apart, high, np.nan))


def hull(one: Spans, other: Spans) -> Spans:
    """The least intervals around both."""
    return Spans(np.minimum(one.low, other.low), np.maximum(one.high, other.high))


def common(one: Spans, other: Spans) -> Spans:
    """Returns the intersections of the spans."""
    return Spans(np.maximum(one.low, other.low), np.minimum(one.high, other.high))


def within(one: Spans, other: Spans) -> Bool:
    """Returns True for each span of `one` that lies in that of `other`; never where a bound is NaN."""
    return (one.low >= other.low) & (one.high <= other.high)


def finite(span: Spans) -> Bool:
    """Returns True for each span whose bounds are both finite."""
    return np.isfinite(span.low) & np.isfinite(span.high)


P, Q = float.fromhex("0x1.921fb544p+0"), float.fromhex("0x1.0b4611a626331p-34")  # pi / 2
L, M = float.fromhex("0x1.62e42fefp-1"), float.fromhex("0x1.473de6af278edp-34")  # ln 2
QUARTER = float.fromhex("0x1.921fb54442d18p+0")  # the float64 next to pi / 2
SLACK = 2.0**-46
LARGEST = 1e6  # of what sin and cos are taken: k stays below 2**20
LARGEST_EXPONENT = 690.0
NEAR = 2.0**-30  # of a turn, within which an extremum counts as met; more than (x - e) / (2 pi) is off by
TURN = 4.0 * QUARTER
SINES = [(-1.0) ** n / factorial(2 * n + 1) for n in range(9)]
COSINES = [(-1.0) ** n / factorial(2 * n) for n in range(10)]
POWERS = [1.0 / factorial(n) for n in range(14)]


def half_turns(count: int) -> Spans:
    """pi, `count` times: it lies between the float64 next to it and the one after, as 2 QUARTER is below it."""
    below = np.full(count, 2.0 * QUARTER)
    return Spans(below, np.nextafter(below, np.inf))


def waves(span: Spans) -> tuple[Spans, Spans]:
    """Bounds of sin and of cos; NaN beyond LARGEST."""
    ends = np.stack([span.low, span.high])
    known = np.abs(ends) <= LARGEST
    ends = np.where(known, ends, 0.0)
    turns = np.rint(ends / QUARTER)
    y = (ends - turns * P) - turns * Q
    quarter, squared = turns.astype(np.int64) % 4, y * y
    sine, cosine = y * _horner(SINES, squared), _horner(COSINES, squared)
    odd = quarter % 2 == 1
    sine, cosine = np.where(odd, cosine, sine), np.where(odd, sine, cosine)
    sine, cosine = np.where(quarter >= 2, -sine, sine), np.where((quarter == 1) | (quarter == 2), -cosine, cosine)
    known = known[0] & known[1]
    return _bound_wave(span, sine, QUARTER, known), _bound_wave(span, cosine, 0.0, known)


def _bound_wave(span: Spans, ends: Float64, top: float, known: Bool) -> Spans:
    """Bounds of a wave by its values at both ends, off by less than SLACK, and a place `top` where it is 1."""
    low, high = ends.min(axis=0) - SLACK, ends.max(axis=0) + SLACK
    high = np.where(_meets(span, top), 1.0, np.minimum(high, 1.0))
    low = np.where(_meets(span, top + 2.0 * QUARTER), -1.0, np.maximum(low, -1.0))
    return Spans(np.where(known, low, np.nan), np.where(known, high, np.nan))


def _meets(span: Spans, place: float) -> Bool:
    """Where an interval may hold a place, or one whole turns from it."""
    first, last = (span.low - place) / TURN - NEAR, (span.high - place) / TURN + NEAR
    return np.ceil(first) <= np.floor(last)


def _horner(factors: list[float], x: Float64) -> Float64:
    total = np.full_like(x, factors[-1])
    for factor in reversed(factors[:-1]):
        total = total * x + factor
    return total


def exponential(span: Spans) -> Spans:
    """Bounds of exp; NaN beyond LARGEST_EXPONENT."""
    low, high = _exp(span.low) * (1.0 - SLACK), _exp(span.high) * (1.0 + SLACK)
    known = np.maximum(np.abs(span.low), np.abs(span.high)) <= LARGEST_EXPONENT
    return Spans(np.where(known, low, np.nan), np.where(known, high, np.nan))


def _exp(x: Float64) -> Float64:
    x = np.where(np.abs(x) <= LARGEST_EXPONENT, x, 0.0)
    doublings = np.rint(x / L)
    y = (x - doublings * L) - doublings * M
    return np.ldexp(_horner(POWERS, y), doublings.astype(np.int32))


def root(span: Spans) -> Spans:
    """Bounds of the square root, which IEEE 754 rounds to nearest; NaN where a number may be below 0."""
    low, high = np.sqrt(span.low), np.sqrt(span.high)
    return Spans(np.maximum(np.nextafter(low, -np.inf), 0.0), np.nextafter(high, np.inf))


AT_ONCE = 1 << 18  # results that are computed together: about what a processor keeps close


class Operation(NamedTuple):
    """An operation on the results at some places of a tape; `name`: of what is given; `number`: a factor or value."""

    does: str
    reads: tuple[int, ...] = ()
    name: str = ""
    number: Fraction = Fraction(0)


class Tape:
    """Operations. Each function gives the place of a result, the same one where it was asked before."""

    def __init__(self) -> None:
        self.operations: list[Operation] = []
        self._places: dict[Operation, int] = {}

    def write(self, does: str, *reads: int, name: str = "", number: Fraction = Fraction(0)) -> int:
        """Any operation."""
        operation = Operation(does, reads, name, number)
        if operation not in self._places:
            self._places[operation] = len(self.operations)
            self.operations.append(operation)
        return self._places[operation]

    def plus(self, one: int, other: int) -> int:
        """A sum."""
        return self.write("plus", one, other)

    def times(self, one: int, other: int) -> int:
        """A product."""
        return self.write("times", one, other)

    def scale(self, one: int, factor: Fraction) -> int:
        """A multiple by an exact number other than 0."""
        assert factor
        return one if factor == 1 else self.write("scale", one, number=factor)


class _TapeGroup(NamedTuple):
    """Operations of one kind whose results go from `first` to before `last`. `reads`: of each operand, [results]."""

    first: int
    last: int
    does: Callable[..., Float64]
    reads: Sequence[Int64]


class Program:
    """Computes the results at some places of a tape; None: exactly 0."""

    def __init__(self, tape: Tape, wanted: Sequence[int | None]) -> None:
        operations, self._groups = tape.operations, list[_TapeGroup]()
        first_ones: list[tuple[int, Operation]] = []
        slots: dict[int, int] = {}
        for (_, kind), places in sorted(_sort_by_level(operations, wanted).items()):
            of, first = [operations[place] for place in places], len(slots)
            columns = zip(*(each.reads for each in of), strict=True)
            reads = [np.array([slots[place] for place in column]) for column in columns]
            slots |= {place: first + number for number, place in enumerate(places)}  # what is read has its slot before
            if reads:
                self._groups.append(_TapeGroup(first, len(slots), _does(kind, of), reads))
            else:
                first_ones += enumerate(of, first)
        self._given = [(slot, each.name) for slot, each in first_ones if each.does == "given"]
        fixed = [(slot, each) for slot, each in first_ones if each.does != "given"]  # the same for all boxes
        spans = [half_turns(1) if each.does == "pi" else exact(each.number, 1) for _, each in fixed]
        self._fixed = np.array([slot for slot, _ in fixed], dtype=np.int64)
        self._numbers = np.concatenate([np.zeros((2, 0)), *(span.ends for span in spans)], axis=1)[:, :, None]
        self._size, self._count = len(slots), len(wanted)
        self._filled = np.array([row for row, place in enumerate(wanted) if place is not None], dtype=np.int64)
        self._wanted = np.array([slots[place] for place in wanted if place is not None], dtype=np.int64)

    def run(self, given: Mapping[str, Spans], count: int) -> Spans:
        """The results, [wanted, count], for `count` boxes. `given`: by name, [count]."""
        results, each = np.zeros((2, self._count, count)), max(AT_ONCE // max(self._size, 1), 1)
        ends = {name: given[name].ends for _, name in self._given}
        for begin in range(0, count, each):
            some = slice(begin, min(begin + each, count))
            computed = np.empty((2, self._size, some.stop - begin))
            for slot, name in self._given:
                computed[:, slot] = ends[name][:, some]
            computed[:, self._fixed] = self._numbers
            for group in self._groups:
                computed[:, group.first : group.last] = group.does(*(computed.take(at, axis=1) for at in group.reads))
            results[:, self._filled, some] = computed[:, self._wanted]
        return of_ends(results)


def _sort_by_level(operations: Sequence[Operation], wanted: Iterable[int | None]) -> dict[tuple[int, str], list[int]]:
    """The places that are needed, by level and kind: each level reads levels before it."""
    needed = {place for place in wanted if place is not None}
    for place in reversed(range(len(operations))):
        if place in needed:
            needed |= set(operations[place].reads)
    levels: dict[int, int] = {}
    kinds: dict[tuple[int, str], list[int]] = {}
    for place in sorted(needed):
        operation = operations[place]
        levels[place] = 1 + max((levels[each] for each in operation.reads), default=-1)
        kind = "waves" if operation.does in WAVES else operation.does
        kinds.setdefault((levels[place], kind), []).append(place)
    return kinds


def _does(kind: str, operations: Sequence[Operation]) -> Callable[..., Float64]:
    """Returns the function that computes a group of operations."""
    if kind == "scale":  # each by a factor of its own
        factor = Factor(*(each.number for each in operations))
        positive = np.array([each.number > 0 for each in operations])[:, None]

        def scale(ends: Float64) -> Float64:
            turned = ends if positive.all() else np.where(positive, ends, -ends[::-1])
            return factor.times_down(turned.transpose(0, 2, 1)).transpose(0, 2, 1)

        return scale
    if kind == "waves":  # both are computed once for each result that is read
        _, first, of = np.unique([each.reads[0] for each in operations], return_index=True, return_inverse=True)
        is_sine = np.array([each.does == "sin" for each in operations])[:, None]

        def wave(ends: Float64) -> Float64:
            sine, cosine = waves(of_ends(ends[:, first]))
            return np.where(is_sine, sine.ends[:, of], cosine.ends[:, of])

        return wave
    return FUNCTIONS[kind]


def _by_spans(function: Callable[[Spans], Spans]) -> Callable[[Float64], Float64]:
    return lambda ends: function(of_ends(ends)).ends


WAVES = ("sin", "cos")
FUNCTIONS: Mapping[str, Callable[..., Float64]] = {
    "plus": sum_down,
    "times": multiply_ends,
    "square": _by_spans(square),
    "inverse": _by_spans(inverse),
    "exp": _by_spans(exponential),
    "sqrt": _by_spans(root),
}
