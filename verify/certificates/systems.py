"""Certificates of claims about stated systems: made, and their claims as plain data.

Does: puts a claim and a proof together; writes a claim as the checker reads it.
Assumes: nothing.
Does not: check what it writes.
"""

from typing import Any

from codegen.ir import PolicyProfile
from codegen.policy_json import content_hash
from verify.certificates.proofs import plain, state_claim, to_json
from verify.checker.certificate import Certificate
from verify.checker.systems.proofs import PROOFS, FlowSets, SystemCertificate, SystemHeader, SystemProof
from verify.claims.formula import Linear
from verify.claims.wording import formula_document
from verify.systems import documents
from verify.systems.claims import SystemClaim
from verify.systems.system import HalfSpace, State, System

__all__ = ["certify", "claim_document", "to_json"]


def certify(
    profile: PolicyProfile, system: System, claim: SystemClaim, state: State, proof: SystemProof
) -> SystemCertificate:
    """The certificate of a claim with a proof. `state`: one that the claim is about."""
    (form,) = (name for name, kind in PROOFS.items() if kind is type(proof))
    header = SystemHeader(form, content_hash(profile), state, documents.content_hash(system))
    return Certificate(header, claim, proof)


@state_claim.register
def _(claim: SystemClaim, proof: object) -> dict[str, Any]:
    samples = {"at_samples": claim.at_samples} if isinstance(proof, FlowSets) else {}
    return {"claim": claim_document(claim), **samples}


def claim_document(claim: SystemClaim) -> dict[str, Any]:
    """A claim as plain data."""
    premises = [{"formula": formula_document(each.formula), "state": plain(each.state)} for each in claim.premises]
    return {
        "name": claim.name,
        "kind": claim.pattern.value,
        "regions": plain(claim.regions),
        "steps": claim.steps,
        "by": claim.by,
        "formula": formula_document(claim.formula),
        "label": claim.label,
        "region": claim.region,
        **({"assuming": plain(claim.assuming)} if claim.assuming else {}),
        **({"assumed": claim.assumed} if claim.assumed else {}),
        **({"premises": premises} if premises else {}),
    }


@plain.register
def _(half: HalfSpace) -> dict[str, Any]:
    terms = tuple((factor, name) for name, factor in half.form.terms)
    return formula_document(Linear(terms, -half.form.constant, half.strict))
