"""What an agent observes in a world state, by the meanings of its features.

Does: the two roundings of the reference environment: one subtraction in float64, then float32.
Assumes: coordinates in the order of `WorldSpec.coordinates()`.
Does not: know games or dynamics.
"""

from collections.abc import Sequence

import numpy as np

from codegen.ir import FeatureSpec, Float32, Float64, WorldSpec


def observe(features: Sequence[FeatureSpec], coordinates: Float64, spec: WorldSpec) -> Float32:
    """Observations of a batch of world states, [batch, n_features] float32.

    `coordinates`: [batch, n_coordinates] float64. ValueError for a feature without a meaning.
    """
    index = {name: place for place, name in enumerate(spec.coordinates())}
    seen = np.empty((len(coordinates), len(features)), dtype=np.float32)
    for place, feature in enumerate(features):
        if feature.meaning is None:
            raise ValueError(f"feature {feature.name} has no meaning, so it cannot be observed from coordinates")
        (weight, name), *rest = feature.meaning.terms
        total = weight * coordinates[:, index[name]]
        for weight, name in rest:
            total = total + weight * coordinates[:, index[name]]
        seen[:, place] = np.sign(total) if feature.meaning.sign else total
    return seen
