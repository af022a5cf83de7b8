"""Boxes: of observations that reach a node of a tree, and of world states that a region lets pass.

Does: the way up from a node, the leaves below it, its box and a point of a box; tests as corners of boxes; the doubles
  that check a region without letting a state outside pass, and the check itself.
Assumes: checked profiles and regions, and coordinates as in the world's spec.
Does not: belong to what proofs rest on.
"""

import math
from collections.abc import Iterator
from fractions import Fraction
from itertools import pairwise
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from codegen.ir import NO_FEATURE, ROOT, Floats, Tree
from codegen.numbers import neighbour
from codegen.paths import Box
from codegen.world import RegionSpec, round_up

Corners: TypeAlias = tuple[Floats, Floats]  # the ends (low, high] of each feature, [n_features]


def find_point(box: Box, n_features: int, numbers: str) -> Floats:
    """An observation in a box, [n_features], of these numbers."""
    observation = np.zeros(n_features, dtype=numbers)
    for feature in box.low.keys() | box.high.keys():
        high, low = box.high.get(feature), box.low.get(feature, 0.0)
        observation[feature] = neighbour(low, np.inf, numbers) if high is None else high
    return observation


def upwards(tree: Tree, node: int) -> list[int]:
    """A node and all above it, up to the root."""
    path = [node]
    while path[-1] != ROOT:
        path.append(int(np.flatnonzero((tree.left == path[-1]) | (tree.right == path[-1]))[0]))
    return path


def leaves_below(tree: Tree, node: int) -> list[int]:
    """The leaves of the part of a tree that begins at a node, from left to right; of a leaf itself."""
    leaves, waiting = list[int](), [node]
    while waiting:  # no recursion: chains of tests may be thousands long
        first = waiting.pop()
        if tree.feature[first] == NO_FEATURE:
            leaves.append(first)
        else:
            waiting += [int(tree.right[first]), int(tree.left[first])]
    return leaves


def box_of(tree: Tree, node: int) -> Box:
    """The observations that reach a node: none where a low end is not below its high end."""
    low: dict[int, float] = {}
    high: dict[int, float] = {}
    way = upwards(tree, node)
    for below, parent in pairwise(way):
        feature, threshold = int(tree.feature[parent]), float(tree.threshold[parent])
        if tree.left[parent] == below:
            high[feature] = min(high.get(feature, threshold), threshold)
        else:
            low[feature] = max(low.get(feature, threshold), threshold)
    return Box(low, high)


def split_corners(low: Floats, high: Floats, feature: int, threshold: np.floating) -> tuple[Corners, Corners]:
    """Splits corners at a test into left and right, as arrays; a side is empty where its low end is not below."""
    most, least = high.copy(), low.copy()
    most[feature] = min(high[feature], threshold)
    least[feature] = max(low[feature], threshold)
    return (low, most), (least, high)


class Bound(NamedTuple):
    """`low <= first - second <= high` (`second` "": the coordinate itself) as doubles round it.

    A coordinate's bounds are exact where doubles can be; a difference, which rounds once, must be inside by more.
    """

    first: str
    second: str
    low: float
    high: float


class Apart(NamedTuple):
    """Two entities whose offset on some axis is at least `least`, and for that surely so."""

    first: str
    second: str
    least: float


def read_bounds(region: RegionSpec) -> Iterator[Bound]:
    """The box's bounds, then the differences'."""
    for name, (low, high) in region.box.items():
        yield Bound(name, "", round_up(Fraction(low)), -round_up(-Fraction(high)))
    for pair, (low, high) in region.difference.items():
        first, second = pair.split(" - ")
        yield Bound(first, second, _above(Fraction(low)), -_above(-Fraction(high)))


def read_distances(region: RegionSpec) -> Iterator[Apart]:
    """The pairs that are kept apart."""
    for pair, least in region.apart.items():
        first, second = pair.split(" - ")
        yield Apart(first, second, _above(Fraction(least)))


def is_inside(
    region: RegionSpec, coordinates: npt.NDArray[np.float64], names: tuple[str, ...]
) -> npt.NDArray[np.bool_]:
    """Returns which world states [batch, n_coordinates] the check lets pass. `names`: of the coordinates."""
    at = dict(zip(names, coordinates.T, strict=True))
    within = np.ones(len(coordinates), dtype=bool)
    for first, second, low, high in read_bounds(region):
        value = at[first] - at[second] if second else at[first]
        within &= (value >= low) & (value <= high)
    for first, second, least in read_distances(region):
        gaps = [np.abs(at[f"{first}.{axis}"] - at[f"{second}.{axis}"]) for axis in "xy"]
        within &= (gaps[0] >= least) | (gaps[1] >= least)
    if region.goals:
        same = [(at["goal.x"] == at[f"{goal}.x"]) & (at["goal.y"] == at[f"{goal}.y"]) for goal in region.goals]
        within &= np.logical_or.reduce(same)
    return within


def _above(value: Fraction) -> float:
    """A double that no difference below `value` rounds to."""
    return math.nextafter(round_up(value), math.inf)
