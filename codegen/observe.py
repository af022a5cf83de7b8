"""What an agent observes in a world state, by the meanings of its features.

Does: the two roundings of the reference environment: one subtraction in float64, then float32. Longer sums are added in
  float64, one term after the other. An agent that compares float64 observes the sum itself.
Assumes: coordinates in the order of `WorldSpec.coordinates()`.
Does not: know games or dynamics.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from codegen.floats import FLOAT32
from codegen.ir import FeatureSpec, Float64, Floats, Meaning, WorldSpec

FEW = 2_048  # states of which several differences are taken at once; of more, one after the other is quicker
AT_ONCE = 32_768  # numbers of such differences: they stay in a cache


class Observer:
    """The meanings of some features, looked up once."""

    def __init__(self, features: Sequence[FeatureSpec], spec: WorldSpec, numbers: str = FLOAT32) -> None:
        self.numbers = numbers  # that the agent compares
        index = {name: place for place, name in enumerate(spec.coordinates())}
        self.terms: list[list[tuple[float, int]]] = []  # per feature: (weight, row of the coordinate)
        self.meanings: list[Meaning] = []
        for feature in features:
            if feature.meaning is None:
                raise ValueError(f"feature {feature.name} has no meaning, so it cannot be observed from coordinates")
            self.terms.append([(weight, index[name]) for weight, name in feature.meaning.terms])
            self.meanings.append(feature.meaning)
        # features that are one coordinate less another, by what is made of them: (features, rows, rows)
        self.differences: dict[str, tuple[list[int], list[int], list[int]]] = {}
        for place, (terms, meaning) in enumerate(zip(self.terms, self.meanings, strict=True)):
            match terms:
                case [(1, a), (-1, b)]:
                    columns = self.differences.setdefault(meaning.function, ([], [], []))
                    for column, value in zip(columns, (place, a, b), strict=True):
                        column.append(value)
                case _:
                    pass
        done = {place for places, _, _ in self.differences.values() for place in places}
        self.others = [place for place in range(len(self.terms)) if place not in done]

    def __call__(self, planes: Float64) -> Floats:
        """Observations [n_features, batch] in the agent's numbers, from `planes` [n_coordinates, batch] float64.

        Features and coordinates are rows: a row is contiguous, which is what makes this fast.
        """
        seen = np.empty((len(self.terms), planes.shape[1]), dtype=self.numbers)
        few = planes.shape[1] <= FEW
        at_once = AT_ONCE // max(1, planes.shape[1])
        for function, columns in self.differences.items() if few else ():
            for low in range(0, len(columns[0]), at_once):
                places, a, b = (column[low : low + at_once] for column in columns)
                seen[places] = _apply_function(function, planes[a] - planes[b])
        total = np.empty(planes.shape[1])
        for place in self.others if few else range(len(self.terms)):
            match self.terms[place]:
                case []:
                    seen[place] = 0
                    continue
                case [(1, a), (-1, b)]:
                    np.subtract(planes[a], planes[b], out=total)
                case _:
                    (weight, first), *terms = self.terms[place]
                    np.multiply(weight, planes[first], out=total)
                    for weight, row in terms:
                        total += weight * planes[row]
            seen[place] = _apply_function(self.meanings[place].function, total)
        return seen


def _apply_function(function: str, total: Float64) -> npt.NDArray[Any]:
    """Applies a function of a meaning to sums; "": returns the sums themselves."""
    match function:
        case "positive":
            return total > 0
        case "zero":
            return total == 0
        case "sign":  # two comparisons take half the time of numpy's sign; NaN gives 0, which no position is
            return np.subtract((total > 0).view(np.int8), (total < 0).view(np.int8))
        case _:
            return total


def observe(features: tuple[FeatureSpec, ...], coordinates: Float64, spec: WorldSpec, numbers: str) -> Floats:
    """Observations of a batch of world states, [batch, n_features], in the `numbers` that the agent compares.

    `coordinates`: [batch, n_coordinates] float64. ValueError for a feature without a meaning.
    """
    return _observer(_Same(features), _Same(spec), numbers)(coordinates.T).T


@dataclass(frozen=True, eq=False)
class _Same:
    """Equal where it holds the same object: comparing all features takes as long as looking them up."""

    value: Any

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Same) and self.value is other.value

    def __hash__(self) -> int:
        return id(self.value)


@lru_cache(maxsize=64)
def _observer(features: _Same, spec: _Same, numbers: str) -> Observer:
    """The observer of features that are often asked for state by state; they stay alive as long as it does."""
    return Observer(features.value, spec.value, numbers)
