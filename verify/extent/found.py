"""Where a claim about single decisions holds: violating zones, their exact share, the largest proved region found.

Does: joins violations.py and largest.py to one answer, with a reason for each part that cannot be had.
Assumes: a claim that has its verdict already (verdicts/decisions.py).
Does not: decide; write reports (reports/where.py).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from codegen.intervals import Share
from verify.claims.formula import TRUE
from verify.claims.region import Region
from verify.claims.wording.starts import everywhere
from verify.extent.largest import candidates, largest
from verify.extent.violations import ExactShare, Failing, exact_part, exact_share, violations
from verify.question import DecisionQuestion
from verify.result import Verdict
from verify.states.shares import SAMPLE_SEED, SAMPLES, explain_unstated, find_unbounded
from verify.states.state import batch, contains, sample
from verify.zones.engine import BeyondZonesError

BEYOND = (
    "an inequality of the claim bounds neither a coordinate nor a difference of two, so only a solver can decide it"
)
OVERLAPPING = "zones of different leaves overlap, in too many parts to count each state once"
OF_LEAVES = "the claim is about leaves and not about world states"


@dataclass(frozen=True)
class ProvedPart:
    """A part of the region in which the claim is proved: how much of it, and of the start region, it is."""

    region: Region
    exact: Fraction | None  # share of the region; None where it takes too many faces
    share: Share  # the same, sampled
    start: Share | None  # None where the start region has a coordinate without a range


@dataclass(frozen=True)
class Where:
    """The zones and regions that are known; each part that is missing has its reason."""

    reason: str = ""  # why there are no zones at all
    everywhere: bool = False
    failing: tuple[Failing, ...] = ()  # goal by goal
    share: ExactShare | None = None
    share_reason: str = ""
    part: ProvedPart | None = None
    part_reason: str = ""

    @property
    def complete(self) -> bool:
        """True if the zones are all that there are."""
        return all(one.complete for one in self.failing)

    @property
    def count(self) -> int:
        """The number of zones."""
        return sum(len(one.zones) for one in self.failing)


def where(question: DecisionQuestion, verdict: Verdict, name: str = "") -> Where:
    """Where a claim with that verdict holds and fails. `name`: of the region that is found."""
    claim = question.claim
    if not claim.per_state:
        return Where(OF_LEAVES)
    if verdict is Verdict.PROVED:
        return Where(everywhere=True)
    if verdict is Verdict.VACUOUS:
        return Where("the claim is about no world state of the region")
    try:
        failing = tuple(violations(question))
    except BeyondZonesError:
        return Where(BEYOND)
    extent = Where(failing=failing)
    if reason := explain_unstated(question):
        return replace(extent, share_reason=reason, part_reason=reason)
    if not extent.complete:
        reason = f"not all violating zones are known: {_ending(question, failing)}"
        return _beside(question, replace(extent, share_reason=reason, part_reason=reason), name)
    share = exact_share(question, failing)
    extent = replace(extent, share=share) if isinstance(share, ExactShare) else replace(extent, share_reason=share)
    if isinstance(share, ExactShare) and not share.exact:
        extent = replace(extent, share_reason=OVERLAPPING)
    if not extent.count:
        return replace(extent, part_reason="no zone violates the claim over real positions")
    part = largest(question, failing, SAMPLE_SEED)
    if isinstance(part, str):
        return replace(extent, part_reason=part)
    return replace(extent, part=_part(question, replace(part, name=name)))


def _beside(question: DecisionQuestion, where: Where, name: str) -> Where:
    """Adds what is found despite too many zones: a region inside a smaller one of which all zones are known."""
    if any(one.nodes > one.limit for one in where.failing):
        return where  # each smaller region might take as many nodes
    for candidate in candidates(question, SAMPLE_SEED):
        inner = question.within(candidate)
        failing = violations(inner)
        if all(one.complete for one in failing):
            # without zones it holds in all of the candidate
            part = largest(inner, failing, SAMPLE_SEED) if any(one.zones for one in failing) else candidate
            if isinstance(part, str):
                return replace(where, part_reason=f"{where.part_reason}; in a smaller region: {part}")
            return replace(where, part=_part(question, replace(part, name=name)), part_reason="")
    return where


def _ending(question: DecisionQuestion, failing: Sequence[Failing]) -> str:
    """Why a search for zones ended before it had all."""
    spent = next((one.limit for one in failing if not one.complete and one.nodes > one.limit), 0)
    if spent:
        return f"the search ended after {spent:,} nodes; {question.budgets.hint('goes on')}"
    return f"there are more than {question.budgets.max_cells:,}; a larger --max-cells lists more"


def _part(question: DecisionQuestion, part: Region) -> ProvedPart:
    start = everywhere(question.profile)
    share = _within(question, part, question.region)
    return ProvedPart(
        part, exact_part(question, part), share, None if find_unbounded(start) else _within(question, part, start)
    )


def _within(question: DecisionQuestion, part: Region, whole: Region) -> Share:
    """The sampled share of a part in the states of a whole that meet the assumption."""
    profile, claim = question.profile, question.claim
    coordinates, goals = sample(whole, profile.world, SAMPLES, SAMPLE_SEED)
    if claim.assume != TRUE:
        kept = batch(coordinates, profile.world).holds(claim.assume, {})
        coordinates, goals = coordinates[kept], goals[kept]
    inside = contains(part, coordinates, profile.world)
    if part.goals:
        inside &= [profile.world.landmarks[int(goal)].name in part.goals for goal in goals]
    return Share(int(inside.sum()), len(inside))
