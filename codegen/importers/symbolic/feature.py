"""Tests of one number of the observation: where, among all floats, their answer turns.

Does: floats in their order, counted from 0 outwards; a feature as a chain of steps on one input; the truth of a test
  at a number; the places where it changes, found by bisection through the steps' own arithmetic.
Assumes: each step never falls, never rises, falls below 0 and rises from there on, or takes few whole numbers; it takes
  every float, also infinite ones, and gives NaN for NaN only.
Does not: follow a program, or know a language: steps and comparisons compute with the scalars that a front end chose.

Additions of, products with and quotients by finite numbers that are not 0, minima, maxima, conversions and roundings
are such steps, in any precision. They may be constant on stretches and overflow: what is found is exact nevertheless.
"""

import math
import operator
import struct
from bisect import bisect_right
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple, TypeAlias

from codegen.floats import FLOAT32, FLOAT64
from codegen.numbers import nearest_double

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
    form: tuple[Any, ...] | None = field(default=None, kw_only=True)  # of arithmetic with a number, see affine.py
    jumps: tuple[int, ...] = field(default=(), kw_only=True)  # of JUMPING: whole numbers between which it never falls


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
