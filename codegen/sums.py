"""Sums of weighted features, which trees test and leaves give, in one of three arithmetics.

Does: the data of a sum; its value for a batch of observations, which is the reference; bounds of outputs.
Assumes: checked sums (check.py); IEEE 754, rounding to nearest.
Does not: know trees, or make text.

A sum is added from left to right and begins with its first term, never with 0, so that -0.0 keeps its sign. A term may
weigh a sum in place of a feature, as in `0.4 + 2.5 * (1 - z)`: the inner sum is computed first, by itself. A weight
that is a fraction, 1 / c for a number c, divides by c: the product with 1 / c, rounded once, is the quotient. The
arithmetics, each the same on every machine that keeps IEEE 754:

- *double sums*: observations and weights are float32, so that each product is exact in float64; sums are float64. A
  fused multiply-add changes nothing. Inner sums weigh 1 or -1, and nothing is divided.
- *float32 steps*: observations and weights are float32; each product and each sum is rounded to float32, as NumPy does
  with arrays of float32.
- *float64*: observations, weights, products and sums are float64, as Python's numbers are.

A test compares a sum with its threshold, both in the numbers of sums; NaN compares false and goes right. An output is
clipped, then rounded once: NaN stays NaN, -0.0 is within a bound of 0.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Final, cast

import numpy as np

from codegen.floats import FLOAT32, FLOAT64

DOUBLE_SUMS: Final = "double sums"
FLOAT32_STEPS: Final = "float32 steps"
FLOAT64_SUMS: Final = "float64"
ARITHMETICS: Final = (DOUBLE_SUMS, FLOAT32_STEPS, FLOAT64_SUMS)
OBSERVED: Final = {DOUBLE_SUMS: FLOAT32, FLOAT32_STEPS: FLOAT32, FLOAT64_SUMS: FLOAT64}  # and what weights are
MAX_INNER: Final = 16  # sums in one another
CONSTANT: Final = -1  # the place of a term that is no feature's: its weight is the term


Weight = float | Fraction  # a fraction divides: it is 1 / c for one of the numbers of the arithmetic


def divisor_of(weight: Weight) -> float | None:
    """What a term is divided by; None: its weight is a factor."""
    return float(1 / weight) if isinstance(weight, Fraction) else None


def choose_numbers(arithmetic: str) -> str:
    """The numbers that sums are in, and constants and thresholds of sums."""
    return FLOAT32 if arithmetic == FLOAT32_STEPS else FLOAT64


@dataclass(frozen=True)
class Sum:
    """Terms (weight, what is weighed), in the order in which they are added: the place of a feature, or a sum."""

    terms: tuple[tuple[Weight, "int | Sum"], ...]

    def value(self, x: Any, arithmetic: str) -> Any:
        """[batch] in the numbers of the arithmetic. `x`: [batch, n_features] observations."""
        number = np.dtype(choose_numbers(arithmetic)).type

        def weighed(weight: Weight, place: "int | Sum") -> Any:
            if place == CONSTANT:
                return np.full(len(x), weight, number)
            seen = place.value(x, arithmetic) if isinstance(place, Sum) else x[:, place].astype(number)
            divisor = divisor_of(weight)
            return seen * number(weight) if divisor is None else seen / number(divisor)

        with np.errstate(over="ignore", under="ignore", invalid="ignore"):
            terms = [weighed(*term) for term in self.terms]
            total = terms[0]
            for term in terms[1:]:
                total = total + term
        return total

    def parts(self) -> Iterator["Sum"]:
        """The sum, and every sum in it."""
        yield self
        for _, place in self.terms:
            if isinstance(place, Sum):
                yield from place.parts()

    @property
    def depth(self) -> int:
        """How many sums lie in one another, this one counted."""
        return 1 + max((place.depth for _, place in self.terms if isinstance(place, Sum)), default=0)

    @property
    def divides(self) -> bool:
        """True if a term of it, or of a sum in it, is divided."""
        return any(isinstance(weight, Fraction) for part in self.parts() for weight, _ in part.terms)

    def expand(self) -> dict[int, Fraction]:
        """The exact sum multiplied out: what each feature is weighed with and, at CONSTANT, what is added to all."""
        exact: dict[int, Fraction] = {}
        for weight, place in self.terms:
            for inner, factor in place.expand().items() if isinstance(place, Sum) else [(place, Fraction(1))]:
                exact[inner] = exact.get(inner, Fraction(0)) + Fraction(weight) * factor
        return exact

    @property
    def places(self) -> list[int]:
        """The features that it reads, in their order, each once; none where it is constant."""
        named = [place for part in self.parts() for _, place in part.terms]
        return list(dict.fromkeys(place for place in named if not isinstance(place, Sum) and place != CONSTANT))


def among(x: Any, sums: Sequence[Sum], arithmetic: str) -> Any:
    """Observations with the values of sums as further columns, [batch, n_features + n_sums]; as they are without."""
    if not sums:
        return x
    return np.column_stack([x.astype(choose_numbers(arithmetic)), *(each.value(x, arithmetic) for each in sums)])


def clip_values(values: Any, low: float | None, high: float | None) -> Any:
    """Values within bounds, element by element; None: no bound."""
    number: Any = values.dtype.type
    if high is not None:
        values = cast(Any, np.where(values > number(high), number(high), values))
    return values if low is None else cast(Any, np.where(values < number(low), number(low), values))
