"""Certificates of claims about single decisions, as text.

Does: the JSON text that checker/decisions/certificates.py reads.
Assumes: nothing.
Does not: check what it writes.
"""

from typing import Any

from codegen.floats import rational_literal
from codegen.form import layout
from verify.certificates.proofs import proof_lines
from verify.checker.decisions.certificates import NAMED, NOISY, UNREAD, Certificate, Premise
from verify.checker.envelope import body_hash
from verify.claims.decisions import PLAIN, DecisionClaim
from verify.claims.formula import TRUE
from verify.claims.region import goal_text
from verify.claims.relations import RELATIONS
from verify.claims.wording import formula_document, region_document, view_document


def to_json(certificate: Certificate) -> str:
    """The text of a certificate; equal certificates give equal bytes."""
    body = {
        "certificate": certificate.form,
        "profile": certificate.profile,
        **({"against": certificate.against} if certificate.against else {}),
        "property": None if certificate.claim is None else _property_document(certificate.claim),
        "semantics": certificate.semantics,
        **({"eps": str(certificate.eps)} if certificate.eps else {}),
        **({} if certificate.view is None else {"view": view_document(certificate.view)}),
        "region": {"name": certificate.region.name or certificate.region_said, **region_document(certificate.region)},
        "formula": formula_document(certificate.formula),
        "inhabitant": {name: rational_literal(value) for name, value in certificate.inhabitant.items()},
        **({"premises": list(map(_premise_document, certificate.premises))} if certificate.says_left_sides else {}),
        "proofs": {goal_text(goal): proof_lines(proof) for goal, proof in certificate.proofs.items()},
    }
    return layout(body | {"content_hash": body_hash(body)}) + "\n"


def _premise_document(premise: Premise) -> dict[str, Any]:
    state = {name: rational_literal(value) for name, value in premise.state.items()}
    return {"formula": formula_document(premise.formula), "goal": goal_text(premise.goal), "state": state}


def may_name(claim: DecisionClaim) -> bool:
    """Returns True if a certificate may name a claim: name and parameters say all that is claimed."""
    return claim.assume == TRUE and claim.of in (*PLAIN, *RELATIONS)


def _property_document(claim: DecisionClaim) -> dict[str, Any]:
    read = claim.parameters
    values = {"name": claim.name, "team": claim.team, "margin": claim.margin, "radius": claim.radius, **UNREAD, **read}
    stated = {name: values[name] for name in dict.fromkeys((*NAMED, *NOISY, *read)) if name in values}
    return {name: list(value) if isinstance(value, tuple) else str(value) for name, value in stated.items()}
