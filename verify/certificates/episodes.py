"""Certificates of claims about episodes, as text.

Does: the JSON texts that checker/episodes/certificates.py and checker/episodes/forever.py read.
Assumes: nothing.
Does not: check what it writes.
"""

from typing import Any

from codegen.floats import rational_literal
from codegen.form import layout
from verify.certificates.proofs import proof_lines
from verify.checker.envelope import body_hash
from verify.checker.episodes.certificates import EpisodeCertificate
from verify.checker.episodes.forever import FORM, LastingCertificate
from verify.claims.region import goal_text
from verify.claims.wording import region_document
from verify.kinds import ALWAYS


def to_json(certificate: EpisodeCertificate | LastingCertificate) -> str:
    """The text of a certificate; equal certificates give equal bytes."""
    claim = certificate.claim
    proofs = _edges(certificate) if certificate.form == FORM else _parts(certificate)
    body: dict[str, Any] = {
        "certificate": certificate.form,
        "profile": certificate.profile,
        "property": claim.name,
        "team": claim.team,
        "steps": ALWAYS if claim.ever else claim.steps,
        "radius": str(claim.radius),
        **({claim.whom: list(claim.named)} if claim.whom else {}),
        "semantics": certificate.semantics,
        "region": {"name": certificate.region.name or certificate.region_said, **region_document(certificate.region)},
        "inhabitant": {name: rational_literal(value) for name, value in certificate.inhabitant.items()},
        **proofs,
    }
    return layout(body | {"content_hash": body_hash(body)}) + "\n"


def _parts(certificate: EpisodeCertificate | LastingCertificate) -> dict[str, Any]:
    parts = [
        {
            "agent": part.agent,
            "landmark": part.landmark,
            "goal": goal_text(part.goal),
            "followed": list(part.followed),
            "proof": proof_lines(part.proof),
        }
        for part in certificate.parts
    ]
    return {"parts": parts}


def _edges(certificate: EpisodeCertificate | LastingCertificate) -> dict[str, Any]:
    proofs: dict[str, dict[str, dict[str, list[str]]]] = {}
    for (name, upper, goal), proof in certificate.proofs.items():
        edges = proofs.setdefault(name, {})
        edges.setdefault("upper" if upper else "lower", {})[goal_text(goal)] = proof_lines(proof)
    edges = {name: [rational_literal(edge) for edge in both] for name, both in certificate.edges.items()}
    return {"edges": edges, "proofs": proofs}
