"""Shares of a sample with 95 % intervals.

Does: the Wilson interval, shared by measures of play and by shares of a region.
Assumes: independent samples.
Does not: sample.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

MAX_DIGITS = 18  # that a float has
Z95 = 1.959963984540054  # two-sided 95 % quantile of the normal distribution


@dataclass(frozen=True)
class Share:
    """`hits` of `count` sampled states, with the Wilson interval of the share."""

    hits: int
    count: int

    @property
    def value(self) -> float:
        """The share itself; 0 for an empty sample."""
        return self.hits / self.count if self.count else 0.0

    @property
    def interval(self) -> tuple[float, float]:
        """The 95 % interval (Wilson 1927)."""
        if not self.count:
            return 0.0, 1.0
        p, n, z2 = self.value, self.count, Z95**2
        middle = (p + z2 / (2 * n)) / (1 + z2 / n)
        half = Z95 * math.sqrt(p * (1 - p) / n + z2 / (4 * n * n)) / (1 + z2 / n)
        return max(0.0, middle - half) if self.hits else 0.0, min(1.0, middle + half) if self.hits < self.count else 1.0

    def document(self) -> dict[str, float | int]:
        """The share as plain data."""
        low, high = self.interval
        return {
            "share": self.value,
            "low": round(low, 9),
            "high": round(high, 9),
            "hits": self.hits,
            "samples": self.count,
        }

    def __str__(self) -> str:
        return format_share(self.document())


def percent(value: float, whole: float = 1) -> str:
    """A part of `whole` in words: with three digits, and with as many more as keep what is less than all from 100 %."""
    found = 100 * value / whole
    rounded = (f"{found:.{digits}g}" for digits in range(3, MAX_DIGITS))
    return f"{next((text for text in rounded if text != '100' or value >= whole), found)} %"


def format_share(share: Mapping[str, float], of: str = "", what: str = "state") -> str:
    """A share's document in words, with its interval. `of`: what follows a share that was measured."""
    if not share["samples"]:
        return f"not measured (no sampled {what} lies in the region)"
    words = f"{percent(share['share'])} [{100 * share['low']:.3g}, {100 * share['high']:.3g}]"
    return f"{words} {of}" if of else words
