"""Certificates of claims about stated systems, as text, and their claims as plain data.

Does: the JSON text that checker/systems/certificates.py reads.
Assumes: nothing.
Does not: check what it writes.
"""

from typing import Any

from codegen.floats import rational_literal
from codegen.json_layout import layout
from verify.certificates.proofs import proof_lines
from verify.checker.envelope import body_hash
from verify.checker.systems.certificates import FORM, SystemCertificate
from verify.claims.formula import Linear
from verify.claims.uncertified.documents import formula_document
from verify.systems.claims import SystemClaim
from verify.systems.system import HalfSpace


def to_json(certificate: SystemCertificate) -> str:
    """The text of a certificate; equal certificates give equal bytes."""
    parts = [
        {
            "followed": list(part.followed),
            "shows": list(part.shows),
            "hulls": [{"step": hull.step, "region": list(map(_half_document, hull.region))} for hull in part.hulls],
            "proof": proof_lines(part.proof),
        }
        for part in certificate.parts
    ]
    body = {
        "certificate": FORM,
        "profile": certificate.profile,
        "system": certificate.system,
        "claim": claim_document(certificate.claim),
        "inhabitant": {name: rational_literal(value) for name, value in certificate.inhabitant.items()},
        "parts": parts,
    }
    return layout(body | {"content_hash": body_hash(body)}) + "\n"


def claim_document(claim: SystemClaim) -> dict[str, Any]:
    """A claim as plain data."""
    return {
        "name": claim.name,
        "kind": claim.pattern.value,
        "regions": [[_half_document(half) for half in region] for region in claim.regions],
        "steps": claim.steps,
        "by": claim.by,
        "formula": formula_document(claim.formula),
        "label": claim.label,
        "region": claim.region,
    }


def _half_document(half: HalfSpace) -> dict[str, Any]:
    terms = tuple((factor, name) for name, factor in half.form.terms)
    return formula_document(Linear(terms, -half.form.constant, half.strict))
