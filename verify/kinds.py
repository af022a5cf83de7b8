"""The kinds of claims, the word for all steps, and the two arithmetics that a question may be about.

Does: names them, and how the tests of trees read a world state by an arithmetic.
Assumes: a class for each kind of claim.
Does not: hold any claim, say what every claim has (question.py), or compute.
"""

from enum import Enum
from fractions import Fraction
from typing import NamedTuple

ALWAYS = "always"  # in place of a number of steps: for ever


class Kind(Enum):
    """The subject of a claim; the values are the words of reports."""

    DECISIONS = "decisions"  # in world states
    LEAVES = "leaves"  # of trees: whether a world state reaches them
    EPISODES = "episodes"  # from rest
    SYSTEMS = "systems"  # decisions in a stated system, and its episodes


MACHINE, REAL = "machine", "real"  # thresholds as the deployed arithmetic meets them, or as they are written
SEMANTICS = (MACHINE, REAL)


class Semantics(NamedTuple):
    """The reading of world states by trees: the arithmetic, and by how much each measured feature may be off."""

    arithmetic: str = MACHINE
    eps: Fraction = Fraction(0)
