"""Where a claim about single decisions holds: violating zones, their exact share, the largest proved region found.

Does: joins violations.py and largest.py to one answer, with a reason for each part that cannot be had.
Assumes: a claim that has its verdict already (engine.py).
Does not: decide; write reports (where_report.py).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from codegen.ir import PolicyProfile
from verify.formula import TRUE
from verify.largest import largest
from verify.properties import LEAVES, Property
from verify.shares import SAMPLE_SEED, SAMPLES, Share
from verify.spec import MACHINE, Region, Verdict
from verify.violations import DEFAULT_ZONES, ExactShare, Failing, exact_part, exact_share, violations
from verify.world import batch, contains, everywhere, sample
from verify.zones import DEFAULT_NODES, BeyondZonesError

BEYOND = "an inequality of the claim bounds no coordinate and no difference of two, so that only a solver decides it"
NOISY = "violating zones are those of features without errors, and the claim allows errors"
OF_LEAVES = "the claim is about leaves and not about world states"


@dataclass(frozen=True)
class Part:
    """A part of the region in which the claim is proved: how much of it, and of the start region, it is."""

    region: Region
    exact: Fraction | None  # share of the region; None where it takes too many faces
    share: Share  # the same, sampled
    start: Share


@dataclass(frozen=True)
class Where:
    """What is known; each part that is missing has its reason."""

    reason: str = ""  # why there are no zones at all
    everywhere: bool = False
    failing: tuple[Failing, ...] = ()  # goal by goal
    share: ExactShare | None = None
    share_reason: str = ""
    part: Part | None = None
    part_reason: str = ""

    @property
    def complete(self) -> bool:
        """Whether the zones are all that there are."""
        return all(one.complete for one in self.failing)

    @property
    def count(self) -> int:
        """The number of zones."""
        return sum(len(one.zones) for one in self.failing)


def where(
    profile: PolicyProfile,
    claim: Property,
    region: Region,
    verdict: Verdict,
    semantics: str = MACHINE,
    most: int = DEFAULT_ZONES,
    name: str = "",
) -> Where:
    """Where a claim with that verdict holds and fails. `most`: zones; `name`: of the region that is found."""
    if claim.name == LEAVES:
        return Where(OF_LEAVES)
    if verdict is Verdict.PROVED:
        return Where(everywhere=True)
    if verdict is Verdict.VACUOUS:
        return Where("the claim speaks of no world state of the region")
    if claim.eps:
        return Where(NOISY)
    try:
        failing = tuple(violations(profile, claim, region, semantics, most))
    except BeyondZonesError:
        return Where(BEYOND)
    found = Where(failing=failing)
    if not found.complete:
        reason = f"not all violating zones are known: {_ending(failing, most)}"
        return replace(found, share_reason=reason, part_reason=reason)
    share = exact_share(profile, claim, region, failing)
    found = replace(found, share=share) if isinstance(share, ExactShare) else replace(found, share_reason=share)
    if not found.count:
        return replace(found, part_reason="no zone violates the claim over real positions")
    part = largest(profile, claim, region, failing, SAMPLE_SEED, semantics)
    if isinstance(part, str):
        return replace(found, part_reason=part)
    return replace(found, part=_part(profile, claim, region, replace(part, name=name)))


def _ending(failing: Sequence[Failing], most: int) -> str:
    """Why a search for zones ended before it had all."""
    spent = next((one.nodes for one in failing if not one.complete and one.nodes > DEFAULT_NODES), 0)
    return f"the search ended after {spent - 1} nodes" if spent else f"there are more than {most}"


def _part(profile: PolicyProfile, claim: Property, region: Region, part: Region) -> Part:
    shares = []
    for whole in (region, everywhere(profile)):
        coordinates, goals = sample(whole, profile.world, SAMPLES, SAMPLE_SEED)
        if claim.assume != TRUE:
            kept = batch(coordinates, profile.world).holds(claim.assume, {})
            coordinates, goals = coordinates[kept], goals[kept]
        inside = contains(part, coordinates, profile.world)
        if part.goals:
            inside &= [profile.world.landmarks[goal].name in part.goals for goal in goals]
        shares.append(Share(int(inside.sum()), len(inside)))
    return Part(part, exact_part(profile, claim, region, part), *shares)
