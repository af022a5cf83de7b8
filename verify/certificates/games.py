"""Certificates of claims about games, as text.

Does: writes regions, formulas and claims as plain data; says which claims a certificate may name.
Assumes: nothing.
Does not: check what it writes.
"""

from typing import Any, get_args

from verify.certificates.proofs import plain, state_claim, to_json
from verify.checker.decisions import NAMED, NOISY, UNREAD
from verify.claims.decisions import PLAIN, DecisionClaim
from verify.claims.episodes import EpisodeClaim
from verify.claims.formula import TRUE, Formula
from verify.claims.observed import View
from verify.claims.region import Region
from verify.claims.relations import RELATIONS
from verify.claims.wording import formula_document, region_document, view_document
from verify.kinds import ALWAYS

__all__ = ["may_name", "to_json"]


def may_name(claim: DecisionClaim) -> bool:
    """Returns True if a certificate may name a claim: name and parameters say all that is claimed."""
    return claim.assume == TRUE and claim.of in (*PLAIN, *RELATIONS)


@plain.register
def _(claim: DecisionClaim) -> dict[str, Any]:
    read = claim.parameters
    values = {"name": claim.name, "team": claim.team, "margin": claim.margin, "radius": claim.radius, **UNREAD, **read}
    stated = {name: values[name] for name in dict.fromkeys((*NAMED, *NOISY, *read)) if name in values}
    return {name: list(value) if isinstance(value, tuple) else str(value) for name, value in stated.items()}


@plain.register
def _(region: Region) -> dict[str, Any]:
    return {"name": region.name or region.said, **region_document(region)}


for kind in get_args(Formula):
    plain.register(kind, formula_document)
plain.register(View, view_document)


@state_claim.register
def _(claim: EpisodeClaim, proof: object) -> dict[str, Any]:
    named = {claim.whom: list(claim.named)} if claim.whom else {}
    steps = ALWAYS if claim.ever else claim.steps
    return {"property": claim.name, "team": claim.team, "steps": steps, "radius": str(claim.radius), **named}
