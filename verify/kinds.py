"""What every claim has, whatever it is about: a kind, words, and what deciding it may use up.

Does: names the kinds and those properties.
Assumes: a class for each kind of claim.
Does not: hold any claim.
"""

from enum import Enum
from typing import ClassVar, Protocol

ALWAYS = "always"  # in place of a number of steps: for ever


class Kind(Enum):
    """What a claim is about; the values are the words of reports."""

    DECISIONS = "decisions"  # in world states
    LEAVES = "leaves"  # of trees: whether a world state reaches them
    EPISODES = "episodes"  # from rest
    SYSTEMS = "systems"  # decisions in a stated system, and its episodes


class AnyClaim(Protocol):
    """A claim of any kind."""

    kind: ClassVar[Kind]
    per_state: ClassVar[bool]  # whether a single world state fulfils or breaks it
    limits: ClassVar[tuple[str, ...]]  # the budgets, as `Budgets` names them, that deciding it may use up
    arithmetics: ClassVar[tuple[str, ...]]  # by which it may be asked

    @property
    def team(self) -> str:
        """Whose decisions it is about; "": those of all agents."""
        ...

    @property
    def name(self) -> str:
        """The name of the property."""
        ...

    @property
    def label(self) -> str:
        """What a user calls it; "" where nobody said."""
        ...

    @property
    def shown(self) -> str:
        """The label, or else the name."""
        ...
