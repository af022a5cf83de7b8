"""What a claim is about: who acts, and what they act in.

Does: what every subject has; a team in a game, and one in a stated system.
Assumes: checked profiles; names and units of a system were checked.
Does not: decide.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from codegen.ir import PolicyProfile
    from verify.claims.uncertified.views import Viewed
    from verify.systems.system import System


class Subject(Protocol):
    """Trees, and what their observations and actions mean."""

    @property
    def profile(self) -> PolicyProfile:
        """Whose trees are asked about."""
        ...

    @property
    def origin(self) -> PolicyProfile:
        """The profile that was given: the one whose view is asked about, or else the one asked about."""
        ...

    @property
    def viewed(self) -> Viewed | None:
        """The view that is asked about; None where it is not about observations alone."""
        ...

    def of(self, profile: PolicyProfile) -> Subject:
        """The same about other trees."""
        ...


@dataclass(frozen=True, eq=False)
class Game:
    """Agents in the world that their profile states."""

    profile: PolicyProfile
    viewed: Viewed | None = None  # where the profile is the view of another one, over whose observations is asked

    @property
    def origin(self) -> PolicyProfile:
        """The profile that was given: the one whose view is asked about, or else the one asked about."""
        return self.profile if self.viewed is None else self.viewed.origin

    def of(self, profile: PolicyProfile) -> Game:
        """Other agents in their world."""
        return Game(profile, self.viewed)


@dataclass(frozen=True, eq=False)
class ClosedLoop:
    """Agents in a system that somebody states, which they observe and move."""

    profile: PolicyProfile
    system: System
    viewed: None = None  # claims are about the state

    @property
    def origin(self) -> PolicyProfile:
        """The profile that was given."""
        return self.profile

    def of(self, profile: PolicyProfile) -> ClosedLoop:
        """Other agents in the system."""
        return ClosedLoop(profile, self.system)
