"""Real arithmetic: what features measure exactly in a world state, and the leaves to which trees lead by that.

Does: exact measurements of rational states; float64 numbers that compare as exact measurements do, for batches.
Assumes: for batches, features that are sums of at most two signed float64 coordinates, or functions of these.
Does not: share the reading of tests with solver/encode.py or checker/thresholds.py, whose answers the referee judges
  by this one.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import TypeAlias

import numpy as np

from codegen.floats import rational_literal
from codegen.ir import NO_FEATURE, ROOT, FeatureSpec, Float64, Int32, Meaning, Tree, WorldSpec

Value: TypeAlias = float | Fraction  # a float64 number, or a rational that is none


def value_of(exact: Fraction) -> Value:
    """The number as a float64 number where it is one."""
    near = float(exact)
    return near if Fraction(near) == exact else exact


def write_value(value: Value) -> float | str:
    """A number as files state it: a float64 number as such, another rational as the text of its fraction."""
    plain = value_of(Fraction(value))
    return plain if isinstance(plain, float) else rational_literal(plain)


def write_values(values: Mapping[str, Value]) -> dict[str, float | str]:
    """Several numbers as files state them."""
    return {name: write_value(value) for name, value in values.items()}


def measure_feature(meaning: Meaning, at: Mapping[str, Fraction], error: Fraction = Fraction(0)) -> Fraction:
    """Measures a feature in a state, exactly. `at`: every coordinate; `error`: added to the sum."""
    total = sum((Fraction(weight) * at[name] for weight, name in meaning.terms), error)
    kinds = {"sign": (total > 0) - (total < 0), "positive": total > 0, "zero": total == 0}
    return Fraction(kinds[meaning.function]) if meaning.function else total


def leaf_of(tree: Tree, measurements: Sequence[Fraction]) -> int:
    """The leaf to which exact measurements [n_features] lead."""
    node = ROOT
    while tree.feature[node] != NO_FEATURE:
        left = measurements[int(tree.feature[node])] <= Fraction(float(tree.threshold[node]))
        node = int(tree.left[node] if left else tree.right[node])
    return node


def comparable(features: Sequence[FeatureSpec], coordinates: Float64, world: WorldSpec) -> Float64:
    """Numbers that are at most a float64 number iff the exact measurements are, [batch, n_features].

    `coordinates`: [batch, n_coordinates] float64, finite.
    """
    at = dict(zip(world.coordinates(), coordinates.T, strict=True))
    numbers = np.empty((len(coordinates), len(features)))
    for place, feature in enumerate(features):
        meaning = feature.meaning
        assert meaning is not None, feature
        parts = [weight * at[name] for weight, name in meaning.terms]
        parts = _distil_sum(parts) if len(parts) > 2 else parts
        total = sum(parts, np.zeros(len(coordinates)))
        if meaning.function:  # a sum of two rounds to 0 only from 0, and keeps its sign
            kinds = {"sign": np.sign(total), "positive": total > 0, "zero": total == 0}
            numbers[:, place] = kinds[meaning.function]
        elif len(parts) == 2:
            # above its rounded value the exact sum exceeds every float64 number that does not exceed the next one
            numbers[:, place] = np.where(_find_rounding_error(*parts) > 0, np.nextafter(total, np.inf), total)
        else:
            numbers[:, place] = total
    return numbers


def _distil_sum(parts: Sequence[Float64]) -> list[Float64]:
    """Two addends: the rounded sum of all, and something smaller with the sign of what that rounding has lost.

    Each pass adds all parts up to the last one and leaves in every other place what that addition has lost, until
    nothing changes. Source: Rump, Ogita, Oishi (2008), Accurate floating-point summation I, section 2 (distillation).
    """
    addends = list(parts)
    while True:
        before = list(addends)
        for place in range(1, len(addends)):
            low, high = addends[place - 1], addends[place]
            addends[place - 1], addends[place] = _find_rounding_error(low, high), low + high
        if all(np.array_equal(old, new) for old, new in zip(before, addends, strict=True)):
            break
    rest = np.zeros_like(addends[-1])
    for part in addends[:-1]:  # ascending: the last one that is not 0 is larger than all before it together
        rest = np.where(part != 0, part, rest)
    return [addends[-1], rest]


def _find_rounding_error(a: Float64, b: Float64) -> Float64:
    """Computes what rounding takes from a + b, exactly. Source: Knuth, TAOCP 2, 4.2.2, theorem B."""
    total = a + b
    later = total - a
    return (a - (total - later)) + (b - later)


def leaves_of(tree: Tree, numbers: Float64) -> Int32:
    """The leaf to which each row of `comparable` numbers leads, [batch]."""
    node = np.full(len(numbers), ROOT, dtype=np.int32)
    row = np.flatnonzero(tree.feature[node] != NO_FEATURE)
    while row.size:
        here = node[row]
        left = numbers[row, tree.feature[here]] <= tree.threshold[here].astype(np.float64)
        node[row] = np.where(left, tree.left[here], tree.right[here])
        row = row[tree.feature[node[row]] != NO_FEATURE]
    return node
