"""Two engines on one question: the zone engine first, Z3 as the second opinion.

Does: asks the zone engine, has its proofs checked, holds its verdict against Z3's.
Assumes: a team whose policies are `verifiable`.
Does not: call a disagreement or a refused proof a verdict: both are our bugs, and raise AssertionError.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction

from codegen.ir import PolicyProfile
from codegen.policy_json import content_hash
from verify import zones
from verify.bounds import RejectedError
from verify.certificate import Certificate, accepted
from verify.formula import TRUE
from verify.margins import Margin, largest_margin
from verify.properties import Property, formula
from verify.spec import MACHINE, Region, Verdict

UNITS_A_NODE = 50  # of a budget in solver resource units, so many stand for one search node
ENGINE = "zones"


@dataclass(frozen=True)
class Opinion:
    """What one engine said, and what it spent; SKIPPED where the question is beyond it."""

    engine: str
    verdict: Verdict
    spent: int
    unit: str


@dataclass(frozen=True)
class Zoned:
    """The zone engine's answer, and for a proof its certificate, accepted by the checker."""

    opinion: Opinion
    goal: str = ""
    point: Mapping[str, Fraction] | None = None
    certificate: Certificate | None = None
    branches: int = 0  # that the certificate's proofs close


def by_zones(profile: PolicyProfile, claim: Property, region: Region, budget: int, semantics: str = MACHINE) -> Zoned:
    """The zone engine's opinion. `budget`: solver resource units, see UNITS_A_NODE."""
    skipped = Zoned(Opinion(ENGINE, Verdict.SKIPPED, 0, "search nodes"))
    asked = formula(profile, claim)
    try:
        found = zones.decide(profile, asked, region, semantics, max(1, budget // UNITS_A_NODE), eps=claim.eps)
    except zones.BeyondZonesError:
        return skipped
    opinion = Opinion(ENGINE, found.verdict, found.nodes, "search nodes")
    if found.verdict is not Verdict.PROVED:
        return Zoned(opinion, found.goal, found.point)
    named = claim if claim.statement is None and claim.assume == TRUE else None
    made = Certificate(
        content_hash(profile), named, asked, region, semantics, found.inhabitant, found.proofs, eps=claim.eps
    )
    try:
        return Zoned(opinion, certificate=made, branches=accepted(made, profile))
    except RejectedError as error:
        raise AssertionError(f"the checker refuses the zone engine's proof of {claim.name}: {error}") from error


def largest_eps(profile: PolicyProfile, claim: Property, region: Region, budget: int, semantics: str) -> Margin:
    """Up to which errors of features a claim that holds with its own keeps holding: each with a checked proof."""

    def proved_at(eps: Fraction) -> bool:
        asked = replace(claim, eps=eps)
        return by_zones(profile, asked, region, budget, semantics).opinion.verdict is Verdict.PROVED

    return largest_margin(proved_at, claim.eps)


def agreeing(zoned: Zoned, second: Opinion) -> Verdict:
    """The verdict of the two: AssertionError when both have one and they differ."""
    first = zoned.opinion
    undecided = (Verdict.UNKNOWN, Verdict.SKIPPED)
    if first.verdict in undecided or second.verdict is Verdict.VACUOUS:  # zones do not ask what the assumption leaves
        return second.verdict
    if second.verdict not in (*undecided, first.verdict):
        raise AssertionError(
            f"the engines disagree: {first.engine} {first.verdict.value}, {second.engine} {second.verdict.value}"
        )
    return first.verdict
