"""Certificates of claims about episodes, as text.

Does: the JSON text that checker/episodes/certificates.py reads.
Assumes: nothing.
Does not: check what it writes.
"""

from codegen.floats import rational_literal
from codegen.form.layout import layout
from verify.certificates.proofs import proof_lines
from verify.checker.envelope import body_hash
from verify.checker.episodes.certificates import EpisodeCertificate
from verify.claims.region import goal_text


def to_json(certificate: EpisodeCertificate) -> str:
    """The text of a certificate; equal certificates give equal bytes."""
    claim = certificate.claim
    body = {
        "certificate": certificate.form,
        "profile": certificate.profile,
        "property": claim.name,
        "team": claim.team,
        "steps": claim.steps,
        "radius": str(claim.radius),
        claim.whom: list(claim.named),
        "semantics": certificate.semantics,
        "region": {"name": certificate.region.name or certificate.region_said, **certificate.region.document()},
        "inhabitant": {name: rational_literal(value) for name, value in certificate.inhabitant.items()},
        "parts": [
            {
                "agent": part.agent,
                "landmark": part.landmark,
                "goal": goal_text(part.goal),
                "followed": list(part.followed),
                "proof": proof_lines(part.proof),
            }
            for part in certificate.parts
        ],
    }
    return layout(body | {"content_hash": body_hash(body)}) + "\n"
