"""Where something is claimed: regions of world states.

Does: the data of a region.
Assumes: a world whose coordinates are named by the profile's world spec.
Does not: read or write files, or know where a world starts (region_files.py).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction

Interval = tuple[Fraction, Fraction]
Difference = tuple[str, str, Interval]  # (a, b, bounds of a - b)
Pair = tuple[str, str, Fraction]  # (entity, entity, least L-infinity distance)


@dataclass(frozen=True)
class Region:
    """A set of world states: a closed interval for each position, bounds on differences, pairs kept apart.

    For example:

        Region({"agent_0.x": (Fraction(-1), Fraction(1, 2))}, goals=("landmark_0",))
    """

    box: Mapping[str, Interval]  #: coordinate -> bounds: every position, and the velocities that matter
    goals: tuple[str, ...]  #: landmarks that may be the goal; empty when the world has none
    differences: tuple[Difference, ...] = ()
    apart: tuple[Pair, ...] = ()
    name: str = field(default="", compare=False)
    #: coordinates that are whole numbers, with the floats that agents make of them; between two whole numbers they
    #: decide as at the one above, so that what holds everywhere holds of whole numbers
    whole: Mapping[str, str] = field(default_factory=dict[str, str], compare=False)
    said: str = field(default="", compare=False)  #: what a certificate that was read calls it; says nothing

    @property
    def goal_cases(self) -> tuple[str | None, ...]:
        """The goals one by one; None alone where the world has none."""
        return self.goals or (None,)


UNBOUNDED = Region({}, (), name="of the file")  # of claims that have regions themselves


def goal_text(goal: str | None) -> str:
    """A goal as files have it: "" where there is none."""
    return goal or ""


def goal_of(written: str) -> str | None:
    """The goal that `goal_text` wrote."""
    return written or None
