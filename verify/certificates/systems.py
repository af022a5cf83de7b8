"""Certificates of claims about stated systems, as text, and their claims as plain data.

Does: the JSON texts that the checker reads as certificates: proofs that are walked, covers of boxes, sets of a flow.
Assumes: nothing.
Does not: check what it writes.
"""

from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any

from codegen.floats import rational_literal
from codegen.form.layout import layout
from verify.certificates.proofs import proof_lines
from verify.checker.covers.certificates import FORM as COVER_FORM
from verify.checker.covers.certificates import FORMS, AnyCertificate, CoverCertificate
from verify.checker.covers.forever import FORM as FOREVER_FORM
from verify.checker.covers.forever import WHOLE, InvariantCertificate, InvariantRegion
from verify.checker.envelope import body_hash
from verify.checker.flows.certificates import FORM as FLOW_FORM
from verify.checker.flows.certificates import FlowCertificate
from verify.checker.systems.certificates import FORM, SystemCertificate
from verify.claims.formula import Linear
from verify.claims.uncertified.documents import formula_document
from verify.systems.claims import SystemClaim, SystemPremise
from verify.systems.system import HalfSpace, Polytope


def to_json(certificate: AnyCertificate | FlowCertificate) -> str:
    """The text of a certificate; equal certificates give equal bytes."""
    form, proof = _PROOFS[type(certificate)](certificate)
    body = {
        "certificate": form,
        "profile": certificate.profile,
        "system": certificate.system,
        "claim": claim_document(certificate.claim),
        "inhabitant": _numbers_document(certificate.inhabitant),
        **proof,
    }
    return layout(body | {"content_hash": body_hash(body)}) + "\n"


def _walk_document(certificate: SystemCertificate) -> tuple[str, dict[str, Any]]:
    parts = [
        {
            "followed": list(part.followed),
            "shows": list(part.shows),
            "hulls": [{"step": hull.step, "region": _region_document(hull.region)} for hull in part.hulls],
            "proof": proof_lines(part.proof),
        }
        for part in certificate.parts
    ]
    return FORM, {"parts": parts}


def _cover_document(certificate: CoverCertificate) -> tuple[str, dict[str, Any]]:
    widths = _numbers_document(certificate.widths)
    sets = {"sets": FORMS} if certificate.forms else {}
    return COVER_FORM, {"cells": widths, "cuts": proof_lines(certificate.cuts), **sets}


def _lasting(certificate: InvariantCertificate) -> tuple[str, dict[str, Any]]:
    parts = [
        {
            "widths": _numbers_document(part.widths),
            "steps": part.steps,
            "cells": proof_lines(part.cells),
            **({"regions": list(map(_cut_region, part.regions))} if part.regions else {}),
            **({"cuts": proof_lines(part.cuts)} if part.cuts != WHOLE else {}),
            **({"joined": _numbers_document(part.joined)} if part.joined else {}),
        }
        for part in certificate.parts
    ]
    return FOREVER_FORM, {"parts": parts}


def _cut_region(one: InvariantRegion) -> dict[str, Any]:
    walk = {} if one.walk is None else {"walk": proof_lines(one.walk)}
    return {"region": _region_document(one.region), "cuts": proof_lines(one.cuts), **walk}


def _numbers_document(numbers: Mapping[str, Fraction]) -> dict[str, str]:
    return {name: rational_literal(number) for name, number in numbers.items()}


def _flowing(certificate: FlowCertificate) -> tuple[str, dict[str, Any]]:
    widths = _numbers_document(certificate.widths)
    made = {"order": certificate.order, "steps": certificate.steps, "cells": widths}
    made |= {"joined_every": certificate.every} if certificate.every != 1 else {}
    made |= {"levels": certificate.levels} if certificate.levels else {}
    samples = {"at_samples": certificate.claim.at_samples}
    return FLOW_FORM, {**samples, **made, "cuts": proof_lines(certificate.cuts)}


_PROOFS: dict[type, Callable[[Any], tuple[str, dict[str, Any]]]] = {
    SystemCertificate: _walk_document, CoverCertificate: _cover_document,
    InvariantCertificate: _lasting, FlowCertificate: _flowing,
}  # fmt: skip


def claim_document(claim: SystemClaim) -> dict[str, Any]:
    """A claim as plain data."""
    return {
        "name": claim.name,
        "kind": claim.pattern.value,
        "regions": list(map(_region_document, claim.regions)),
        "steps": claim.steps,
        "by": claim.by,
        "formula": formula_document(claim.formula),
        "label": claim.label,
        "region": claim.region,
        **({"assuming": list(map(_region_document, claim.assuming))} if claim.assuming else {}),
        **({"assumed": claim.assumed} if claim.assumed else {}),
        **({"premises": list(map(_premise_document, claim.premises))} if claim.premises else {}),
    }


def _premise_document(premise: SystemPremise) -> dict[str, Any]:
    return {"formula": formula_document(premise.formula), "state": _numbers_document(premise.state)}


def _region_document(region: Polytope) -> list[dict[str, Any]]:
    return list(map(_half_document, region))


def _half_document(half: HalfSpace) -> dict[str, Any]:
    terms = tuple((factor, name) for name, factor in half.form.terms)
    return formula_document(Linear(terms, -half.form.constant, half.strict))
