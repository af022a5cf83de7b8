"""Profiles with their views: what engines and reports carry about of a claim over observations.

Does: a profile with its view; which features agents may share; carries a region to the copy of an agent.
Assumes: observed.py, which says what a view is.
Does not: belong to what proofs rest on.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final, NamedTuple

from codegen.ir import PolicyProfile
from verify.claims.observed import View, copy_of, ensure_several, of_several, over, variable
from verify.claims.region import Region

ALL: Final = "all"  # in place of names of features: those that several agents have


class Viewed(NamedTuple):
    """A profile, and how its observations are put together."""

    origin: PolicyProfile
    view: View

    @property
    def profile(self) -> PolicyProfile:
        """The view, as a profile."""
        return over(self.origin, self.view)


def unread(profile: PolicyProfile) -> bool:
    """Whether no feature of a profile has a meaning, so that only its observations can be spoken of."""
    return all(feature.meaning is None for policy in profile.agents for feature in policy.features)


def shared_features(profile: PolicyProfile, names: Sequence[str]) -> tuple[str, ...]:
    """Features that agents share, in the order given; of ALL those that several agents have. UnknownNameError for a
    feature that no agent has, InputError for one that only one has.
    """
    if tuple(names) == (ALL,):
        return tuple(of_several(profile))
    ensure_several(profile, names)
    return tuple(dict.fromkeys(names))


def carried(region: Region, viewed: Viewed) -> Region:
    """A region of the view without a copy, of which the copy keeps every bound too."""
    raised = viewed.view.raised
    if raised is None:
        return region
    name = variable(viewed.origin, viewed.view, raised.agent, raised.feature)
    other = f"{copy_of(raised.agent)}.{raised.feature}"

    def moved(coordinate: str) -> str:
        return other if coordinate == name else coordinate

    more = [(moved(a), moved(b), bounds) for a, b, bounds in region.differences if name in (a, b)]
    return replace(region, box={**region.box, other: region.box[name]}, differences=(*region.differences, *more))
