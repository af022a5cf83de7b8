"""The kinds of claims, and the word for all steps.

Does: names them.
Assumes: a class for each kind of claim.
Does not: hold any claim, or say what every claim has (question.py).
"""

from enum import Enum

ALWAYS = "always"  # in place of a number of steps: for ever


class Kind(Enum):
    """The subject of a claim; the values are the words of reports."""

    DECISIONS = "decisions"  # in world states
    LEAVES = "leaves"  # of trees: whether a world state reaches them
    EPISODES = "episodes"  # from rest
    SYSTEMS = "systems"  # decisions in a stated system, and its episodes
