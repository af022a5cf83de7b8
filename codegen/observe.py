"""What an agent observes in a world state, by the meanings of its features.

Does: the two roundings of the reference environment: one subtraction in float64, then float32. Longer sums are added in
  float64, one term after the other. An agent that compares float64 observes the sum itself.
Assumes: coordinates in the order of `WorldSpec.coordinates()`.
Does not: know games or dynamics.
"""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from codegen.floats import FLOAT32
from codegen.ir import FeatureSpec, Float64, Floats, Meaning, WorldSpec


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

    def __call__(self, planes: Float64) -> Floats:
        """Observations [n_features, batch] in the agent's numbers, from `planes` [n_coordinates, batch] float64.

        Features and coordinates are rows: a row is contiguous, which is what makes this fast.
        """
        seen = np.empty((len(self.terms), planes.shape[1]), dtype=self.numbers)
        rows = list(planes)
        total = np.empty(planes.shape[1])
        for out, terms, meaning in zip(seen, self.terms, self.meanings, strict=True):
            match terms:
                case []:
                    out[...] = 0
                    continue
                case [(1, a), (-1, b)]:
                    np.subtract(rows[a], rows[b], out=total)
                case _:
                    np.multiply(terms[0][0], rows[terms[0][1]], out=total)
                    for weight, row in terms[1:]:
                        total += weight * rows[row]
            match meaning.function:
                case "positive":
                    np.greater(total, 0, out=out, casting="unsafe")
                case "zero":
                    np.equal(total, 0, out=out, casting="unsafe")
                case _:
                    out[...] = _sign(total) if meaning.function else total
        return seen


def _sign(total: Float64) -> npt.NDArray[np.int8]:
    """-1, 0 or 1; two comparisons take half the time of numpy's sign. NaN gives 0, which no position is."""
    return np.subtract((total > 0).view(np.int8), (total < 0).view(np.int8))


def observe(features: Sequence[FeatureSpec], coordinates: Float64, spec: WorldSpec, numbers: str) -> Floats:
    """Observations of a batch of world states, [batch, n_features], in the `numbers` that the agent compares.

    `coordinates`: [batch, n_coordinates] float64. ValueError for a feature without a meaning.
    """
    return Observer(features, spec, numbers)(coordinates.T).T
