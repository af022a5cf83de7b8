"""Profiles with their views: what engines and reports carry about of a claim over observations.

Does: a profile with its view; words for a view; which features agents may share; carries a region to an agent's copy.
Assumes: observed.py, which says what a view is.
Does not: belong to what proofs rest on.
"""

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from math import ceil, floor
from typing import Final, NamedTuple

from codegen.errors import InputError
from codegen.floats import WHOLE
from codegen.ir import UNSCALED, PolicyProfile
from verify.claims.observed import View, copy_of, ensure_several, of_several, over, variable
from verify.claims.region import Interval, Region
from verify.claims.region_files import everywhere

SEEN, RANGES = "seen", "ranges"  # regions of a view: what episodes showed, and what the features' ranges are
UNLIKE: Final = ""  # in place of float32 and float64: both
ALL: Final = "all"  # in place of names of features: those that several agents have


class Viewed(NamedTuple):
    """A profile, and how its observations are put together."""

    origin: PolicyProfile
    view: View

    @property
    def profile(self) -> PolicyProfile:
        """The view, as a profile."""
        return over(self.origin, self.view)


def describe_view(view: View) -> str:
    """A view in words."""
    shared = f", {', '.join(view.shared)} shared" if view.shared else ""
    if view.mirrored is not None:
        features = ", ".join(view.mirrored.features) or "all features"
        return f"over observations{shared} (two copies of {view.copied}, one with the opposite of {features})"
    if view.raised is not None:
        return f"over observations{shared} (two copies of {view.copied} that differ in {view.raised.feature} only)"
    return f"over observations{shared}"


def find_numbers(view: PolicyProfile) -> dict[str, str]:
    """Returns the numbers that the agents that observe each variable of a view compare: float32 or float64, or a type
    of whole numbers; UNLIKE where they differ.
    """
    variables, numbers = {each.name for each in view.world.variables}, dict[str, str]()
    for policy in view.agents:
        for feature in policy.features:
            for _, name in feature.meaning.terms if feature.meaning is not None else ():
                compared = policy.whole or policy.numbers
                if name in variables and numbers.setdefault(name, compared) != compared:
                    numbers[name] = UNLIKE
    return numbers


def unread(profile: PolicyProfile) -> bool:
    """Returns True if no feature of a profile has a meaning, so that only its observations can be spoken of."""
    return all(feature.meaning is None for policy in profile.agents for feature in policy.features)


def select_features(profile: PolicyProfile, names: Sequence[str]) -> tuple[str, ...]:
    """Features that agents share, in the order given; of ALL those that several agents have. UnknownNameError for a
    feature that no agent has, InputError for one that only one has.
    """
    if tuple(names) == (ALL,):
        return tuple(of_several(profile))
    ensure_several(profile, names)
    return tuple(dict.fromkeys(names))


def build_seen_region(viewed: Viewed) -> Region | None:
    """Builds the region that episodes showed of each variable, within its range; of a shared one, what any agent was
    shown. None where nobody looked.
    """
    seen: dict[str, tuple[Fraction, Fraction]] = {}
    for policy in viewed.origin.agents:
        for feature, ends in zip(policy.features, policy.seen, strict=False):
            name = variable(viewed.origin, viewed.view, policy.agent, feature.name)
            low, high = Fraction(ends[0]), Fraction(ends[-1])
            before = seen.get(name, (low, high))
            seen[name] = min(low, before[0]), max(high, before[1])
    if not seen:
        return None
    whole = everywhere(viewed.profile).box
    box: dict[str, Interval] = {}
    for name, (least, most) in whole.items():
        low, high = seen.get(name, (least, most))
        low, high = max(low, least), min(high, most)
        box[name] = (low, high) if low <= high else (least, most)
    return Region(box, (), name=SEEN)


def carry_region(region: Region, viewed: Viewed) -> Region:
    """A region of the view without a copy, of which the copy keeps every bound too."""
    raised = viewed.view.raised
    if raised is None:
        return region
    name = variable(viewed.origin, viewed.view, raised.agent, raised.feature)
    other = f"{copy_of(raised.agent)}.{raised.feature}"

    def rename_coordinate(coordinate: str) -> str:
        return other if coordinate == name else coordinate

    more = [
        (rename_coordinate(a), rename_coordinate(b), bounds) for a, b, bounds in region.differences if name in (a, b)
    ]
    box = {**region.box, other: region.box[name]}
    return replace(region, box=box, differences=(*region.differences, *more))


def confine_region(region: Region, view: PolicyProfile) -> Region:
    """The whole numbers of a region, where variables of a view are such, within their ranges. InputError where there
    are none.
    """
    numbers = find_numbers(view)
    whole = {name: WHOLE[numbers[name]] for name in numbers if numbers[name] in WHOLE}
    ranges, box = everywhere(view).box, dict(region.box)
    scaled = {
        name
        for policy in view.agents
        for feature in policy.features
        if feature.scale != UNSCALED and feature.meaning is not None
        for _, name in feature.meaning.terms
    }
    for name in sorted(scaled):
        if box[name] != ranges[name] or any(name in (a, b) for a, b, _ in region.differences):
            what = f"the region bounds {name}, which has a scale"
            raise InputError(what, region.name, 'leave it out there, and assume it: assume = "...", in its unit')
    for name in whole:
        (low, high), (least, most) = box[name], ranges[name]
        box[name] = Fraction(ceil(max(low, least))), Fraction(floor(min(high, most)))
        if box[name][0] > box[name][1]:
            what = f"the region has no whole number {name} of the range [{least}, {most}]"
            raise InputError(what, region.name, "widen its bounds")
    differences = (
        (a, b, (Fraction(ceil(low)), Fraction(floor(high)))) if {a, b} <= {*whole} else (a, b, (low, high))
        for a, b, (low, high) in region.differences
    )
    return replace(region, box=box, differences=tuple(differences), whole=whole)
