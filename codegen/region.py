"""The world states that a profile is meant for, where it is not meant for all.

Does: the data of such a region, whose bounds are exact text.
Assumes: coordinates are named as in the world's spec.
Does not: check states (boxes.py), or prove anything about a region (the verifier does).
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from types import MappingProxyType


@dataclass(frozen=True)
class RegionSpec:
    """A region as a file states it: numbers are exact text, decimals or fractions; differences are named `a - b`."""

    goals: tuple[str, ...]  # landmarks that may be the goal; empty: the world has no goal
    box: Mapping[str, tuple[str, str]]
    difference: Mapping[str, tuple[str, str]] = field(default_factory=lambda: MappingProxyType({}))
    apart: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))


def round_up(value: Fraction) -> float:
    """The smallest double not below a number."""
    near = float(value)
    return near if Fraction(near) >= value else math.nextafter(near, math.inf)
