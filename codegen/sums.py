"""Sums of weighted features, which trees test and leaves give, in one of three arithmetics.

Does: the data of a sum; its value for a batch of observations, which is the reference; bounds of outputs.
Assumes: checked sums (check.py); IEEE 754, rounding to nearest.
Does not: know trees, or make text.

A sum is added from left to right and begins with its first term, never with 0, so that -0.0 keeps its sign. The
arithmetics, each the same on every machine that keeps IEEE 754:

- *double sums*: observations and weights are float32, so that each product is exact in float64; sums are float64. A
  fused multiply-add changes nothing.
- *float32 steps*: observations and weights are float32; each product and each sum is rounded to float32, as NumPy does
  with arrays of float32.
- *float64*: observations, weights, products and sums are float64, as Python's numbers are.

A test compares a sum with its threshold, both in the numbers of sums; NaN compares false and goes right. An output is
clipped, then rounded once: NaN stays NaN, -0.0 is within a bound of 0.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, cast

import numpy as np

from codegen.floats import FLOAT32, FLOAT64

DOUBLE_SUMS: Final = "double sums"
FLOAT32_STEPS: Final = "float32 steps"
FLOAT64_SUMS: Final = "float64"
ARITHMETICS: Final = (DOUBLE_SUMS, FLOAT32_STEPS, FLOAT64_SUMS)
OBSERVED: Final = {DOUBLE_SUMS: FLOAT32, FLOAT32_STEPS: FLOAT32, FLOAT64_SUMS: FLOAT64}  # and what weights are
CONSTANT: Final = -1  # the place of a term that is no feature's: its weight is the term


def choose_numbers(arithmetic: str) -> str:
    """The numbers that sums are in, and constants and thresholds of sums."""
    return FLOAT32 if arithmetic == FLOAT32_STEPS else FLOAT64


@dataclass(frozen=True)
class Sum:
    """Terms (weight, place of the feature), in the order in which they are added."""

    terms: tuple[tuple[float, int], ...]

    def value(self, x: Any, arithmetic: str) -> Any:
        """[batch] in the numbers of the arithmetic. `x`: [batch, n_features] observations."""
        number = np.dtype(choose_numbers(arithmetic)).type
        with np.errstate(over="ignore", under="ignore", invalid="ignore"):
            terms = [
                np.full(len(x), weight, number) if place == CONSTANT else x[:, place].astype(number) * number(weight)
                for weight, place in self.terms
            ]
            total = terms[0]
            for term in terms[1:]:
                total = total + term
        return total


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
