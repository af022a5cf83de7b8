"""How states are checked against a region: the doubles of its bounds, and which states pass.

Does: the doubles that check a region without letting a state outside pass; the check itself.
Assumes: a checked region, and coordinates as in the world's spec.
Does not: belong to what proofs rest on.
"""

import math
from collections.abc import Iterator
from fractions import Fraction
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from codegen.region import RegionSpec, round_up


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
    """Which world states [batch, n_coordinates] the check lets pass. `names`: of the coordinates."""
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
