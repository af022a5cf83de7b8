"""What a claim about a team has: a name, words, parameters, and what deciding it may use up.

Does: the base class of such claims, and the ranges of parameters.
Assumes: teams are those of the profile that is asked about.
Does not: decide anything.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import ClassVar

from codegen.errors import InputError, UnknownNameError
from codegen.ir import PolicyProfile
from verify.exact import MAX_NUMBER
from verify.kinds import MACHINE, Kind

Parameter = Fraction | int | str | tuple[str, ...]
Rounded = tuple[tuple[str, str], ...]  # numbers as they are written, and the floats that they are read as


@dataclass(frozen=True)
class TeamClaim:
    """A claim about a team."""

    kind: ClassVar[Kind]
    per_state: ClassVar[bool] = False  # whether a single world state fulfils or breaks it
    limits: ClassVar[tuple[str, ...]]  # the budgets, as `Budgets` names them, that deciding it may use up
    arithmetics: ClassVar[tuple[str, ...]] = (MACHINE,)  # by which it may be asked

    team: str
    label: str = field(default="", compare=False, kw_only=True)
    rounded: Rounded = field(default=(), compare=False, kw_only=True)

    @property
    def name(self) -> str:
        """The name of the property."""
        raise NotImplementedError

    @property
    def parameters(self) -> Mapping[str, Parameter]:
        """The parameters that the claim reads beside its team."""
        raise NotImplementedError

    @property
    def shown(self) -> str:
        """The label, or else the name."""
        return self.label or self.name


def ensure_team(profile: PolicyProfile, team: str) -> None:
    """UnknownNameError for a team of which the profile has no agent."""
    if not profile.team(team):
        raise UnknownNameError("team", team, teams(profile))


def teams(profile: PolicyProfile) -> list[str]:
    """The teams of a profile, in the order of its agents."""
    return list(dict.fromkeys(policy.team for policy in profile.agents))


def check_range(parameter: str, value: Fraction | int, most: int = MAX_NUMBER, least: int = 0) -> None:
    """InputError for a value out of its range."""
    if not least <= value <= most:
        raise InputError(f"{parameter} must be between {least} and {most}", parameter)
