"""What is claimed of whole episodes: the data of such a claim.

Does: name, team, steps, radius, and of whom the claim speaks.
Assumes: nothing; also read by the checker of certificates about episodes.
Does not: decide, play or check.
"""

from dataclasses import dataclass, field
from fractions import Fraction

RADIUS = Fraction(2, 5)
DEFAULT_ZONES = 5_000_000  # visited for a claim; about a million a second
KEEPS_APART = "keeps_apart"


@dataclass(frozen=True)
class EpisodeClaim:
    """A claim about whole episodes from rest; `landmarks`: one for each agent, or none where any matching will do;
    `others`: from whom the team keeps apart, none: from one another.
    """

    name: str
    team: str
    steps: int
    radius: Fraction = RADIUS
    landmarks: tuple[str, ...] = ()
    others: tuple[str, ...] = ()
    zones: int = field(default=DEFAULT_ZONES, compare=False)  # that deciding it may visit
    label: str = field(default="", compare=False)

    @property
    def shown(self) -> str:
        """The label, or else the name."""
        return self.label or self.name
