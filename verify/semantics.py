"""Which arithmetic a question is about.

Does: names the two, and how the tests of trees read a world state by them.
Assumes: nothing.
Does not: compute in either.
"""

from fractions import Fraction
from typing import NamedTuple

MACHINE, REAL = "machine", "real"  # thresholds as the deployed arithmetic meets them, or as they are written
SEMANTICS = (MACHINE, REAL)


class Semantics(NamedTuple):
    """The reading of world states by trees: the arithmetic, and by how much each measured feature may be off."""

    arithmetic: str = MACHINE
    eps: Fraction = Fraction(0)
