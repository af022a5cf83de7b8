"""The world states that a profile is meant for, where it is not meant for all.

Does: bounds as exact text, the doubles that check them without letting a state outside pass, the check itself.
Assumes: coordinates are named as in the world's spec.
Does not: prove anything about a region (the verifier does).
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
import numpy.typing as npt


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


@dataclass(frozen=True)
class RegionSpec:
    """A region as a file states it: numbers are exact text, decimals or fractions; differences are named `a - b`."""

    goals: tuple[str, ...]  # landmarks that may be the goal; empty: the world has no goal
    box: Mapping[str, tuple[str, str]]
    difference: Mapping[str, tuple[str, str]] = field(default_factory=lambda: MappingProxyType({}))
    apart: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))

    def bounds(self) -> Iterator[Bound]:
        """The box's bounds, then the differences'."""
        for name, (low, high) in self.box.items():
            yield Bound(name, "", _up(Fraction(low)), -_up(-Fraction(high)))
        for pair, (low, high) in self.difference.items():
            first, second = pair.split(" - ")
            yield Bound(first, second, _above(Fraction(low)), -_above(-Fraction(high)))

    def distances(self) -> Iterator[Apart]:
        """The pairs that are kept apart."""
        for pair, least in self.apart.items():
            first, second = pair.split(" - ")
            yield Apart(first, second, _above(Fraction(least)))

    def holds(self, coordinates: npt.NDArray[np.float64], names: tuple[str, ...]) -> npt.NDArray[np.bool_]:
        """Which world states [batch, n_coordinates] the check lets pass. `names`: of the coordinates."""
        at = dict(zip(names, coordinates.T, strict=True))
        within = np.ones(len(coordinates), dtype=bool)
        for first, second, low, high in self.bounds():
            value = at[first] - at[second] if second else at[first]
            within &= (value >= low) & (value <= high)
        for first, second, least in self.distances():
            gaps = [np.abs(at[f"{first}.{axis}"] - at[f"{second}.{axis}"]) for axis in "xy"]
            within &= (gaps[0] >= least) | (gaps[1] >= least)
        if self.goals:
            same = [(at["goal.x"] == at[f"{goal}.x"]) & (at["goal.y"] == at[f"{goal}.y"]) for goal in self.goals]
            within &= np.logical_or.reduce(same)
        return within


def _up(value: Fraction) -> float:
    """The smallest double not below a number."""
    near = float(value)
    return near if Fraction(near) >= value else math.nextafter(near, math.inf)


def _above(value: Fraction) -> float:
    """A double that no difference below `value` rounds to."""
    return math.nextafter(_up(value), math.inf)
