"""What a claim is about: who acts, and what they act in.

Does: what every subject has; a team in a game, and one in a stated system.
Assumes: checked profiles; names and units of a system were checked.
Does not: decide.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Self

from codegen.deciding import VERIFIER, ensure_plain
from codegen.errors import InputError
from codegen.ir import UNSCALED

if TYPE_CHECKING:
    from codegen.ir import PolicyProfile
    from verify.claims.views import Viewed
    from verify.systems.system import System


@dataclass(frozen=True, eq=False)
class Subject:
    """Trees, and what their observations and actions mean."""

    profile: PolicyProfile  # whose trees are asked about
    # the view that is asked about, whose profile this is; None where it is not about observations alone
    viewed: Viewed | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        # elsewhere, an action that changes memory would count as another one than the action that it takes
        scaled = [each.name for policy in self.profile.agents for each in policy.features if each.scale != UNSCALED]
        if scaled and self.viewed is None:
            what = f"{VERIFIER} does not take scales in worlds yet"
            raise InputError(what, ", ".join(scaled), "take the scale out of the profile, and state whole numbers")
        ensure_plain(self.profile, VERIFIER, memory=isinstance(self, ClosedLoop) and self.viewed is None)

    @property
    def origin(self) -> PolicyProfile:
        """The profile that was given: the one whose view is asked about, or else the one asked about."""
        return self.profile if self.viewed is None else self.viewed.origin

    def of(self, profile: PolicyProfile) -> Self:
        """The same about other trees."""
        return replace(self, profile=profile)


@dataclass(frozen=True, eq=False)
class Game(Subject):
    """Agents in the world that their profile states."""


@dataclass(frozen=True, eq=False)
class ClosedLoop(Subject):
    """Agents in a system that somebody states, which they observe and move."""

    system: System
