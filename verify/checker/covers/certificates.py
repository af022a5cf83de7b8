"""Certificates that are covers: the document, and whether it is accepted.

Does: reads the document; whether it fits a profile and a system, and its boxes meet the claim.
Assumes: a profile and a system that were read and checked; a document that anyone made.
Does not: prove, or write (verify/certificates).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, Literal

import msgspec

from codegen.errors import InputError
from codegen.floats import rational_literal
from codegen.ir import PolicyProfile
from verify.checker.covers import forever
from verify.checker.covers.boxes import Watch
from verify.checker.covers.forever import InvariantCertificate
from verify.checker.covers.forms.sweep import FormSweep
from verify.checker.covers.rounding import floor
from verify.checker.covers.sweep import Cells, CoverSweep
from verify.checker.envelope import REMAKE, ensure_readable, ensure_whole, numbers, read_proof
from verify.checker.reading import RejectedError
from verify.checker.systems import certificates as walked
from verify.checker.systems.certificates import SystemCertificate, SystemClaimJson, ensure_asked, read_claim
from verify.exact import read_number
from verify.systems.claims import SystemClaim
from verify.systems.system import System, ensure_in_steps

FORM = "maviper-system-certificate-2"
BOXES, FORMS = "boxes", "forms"  # the sets of a cover
MAX_WIDTH = Fraction(2) ** 200  # of a cell, and 1 over the least


@dataclass(frozen=True)
class CoverCertificate:
    """A claim about a profile in a stated system, with what its cover is made from: how the start is cut, as bytes; the
    widths of cells by variable; or that its sets are affine forms, which are not joined.
    """

    profile: str  # content hash
    system: str  # content hash
    claim: SystemClaim
    inhabitant: Mapping[str, Fraction]  # a start, which shows that there is one
    widths: Mapping[str, Fraction]
    cuts: bytes
    forms: bool = False

    @property
    def counted(self) -> str:
        """What is counted when it is checked."""
        return FORMS if self.forms else BOXES

    @property
    def unit(self) -> str:
        """One of what is counted."""
        return "form" if self.forms else "box"

    @property
    def size(self) -> int:
        """Bytes of the cuts."""
        return len(self.cuts)

    @property
    def made_of(self) -> dict[str, Any]:
        """What a report says of it beside its size."""
        cells = {name: rational_literal(width) for name, width in self.widths.items()}
        return {} if self.forms else {"cells": cells}

    def reading(self, reader: Callable[[bytes], bytes]) -> CoverCertificate:
        """The same with its cuts given to a reader."""
        return replace(self, cuts=reader(self.cuts))

    def check(self, profile: PolicyProfile, system: System, watch: Watch | None = None) -> int:
        """As the function."""
        return check_certificate(self, profile, system, watch)


def check_certificate(
    certificate: CoverCertificate, profile: PolicyProfile, system: System, watch: Watch | None = None
) -> int:
    """Checks a certificate; the number of its sets over all steps. `watch` is told of every list of boxes, by its step.

    InputError when it is about another profile or system, or names what they do not have; RejectedError when its sets
    do not show the claim.
    """
    ensure_in_steps(system, "this form of certificate")
    ensure_asked(certificate, set(certificate.widths), profile, system)
    claim = certificate.claim
    if claim.about_decisions:
        raise RejectedError("boxes show claims about episodes only")
    columns = {each.name: column for column, each in enumerate(system.variables)}
    if not all(1 / MAX_WIDTH < width < MAX_WIDTH for width in certificate.widths.values()):
        raise RejectedError("a cell has a width out of range")
    widths = {columns[name]: floor(width) for name, width in certificate.widths.items()}
    cuts = list(numbers(certificate.cuts))
    if not certificate.forms:
        return CoverSweep(profile, system, [claim], watch).run(Cells(cuts, widths))[0]
    if widths:
        raise RejectedError("forms are not joined in cells")
    return FormSweep(profile, system, [claim]).run(cuts)


AnyCertificate = SystemCertificate | CoverCertificate | InvariantCertificate


# --- the text


class CoverCertificateJson(msgspec.Struct, forbid_unknown_fields=True, omit_defaults=True):
    """The members of the file; numbers are exact texts."""

    certificate: str
    profile: str
    system: str
    claim: SystemClaimJson
    inhabitant: dict[str, str]
    cells: dict[str, str]
    cuts: list[str]
    content_hash: str
    sets: Literal["boxes", "forms"] = "boxes"


class _FormJson(msgspec.Struct):
    """The form of a document, whatever else is in it."""

    certificate: str = ""


def from_json(text: str | bytes, where: str = "certificate") -> AnyCertificate:
    """The certificate in a text, of any form. InputError when it is damaged, of another version, or edited."""
    with ensure_readable(where):
        form = msgspec.json.decode(text, type=_FormJson).certificate
        if form != FORM:
            return forever.from_json(text, where) if form == forever.FORM else walked.from_json(text, where)
        raw = msgspec.json.decode(text, type=CoverCertificateJson)
        ensure_whole(raw, FORM, where)
        inhabitant = {name: read_number(value) for name, value in raw.inhabitant.items()}
        widths = {name: read_number(value) for name, value in raw.cells.items()}
        claim = read_claim(raw.claim)
        if claim.about_decisions:
            raise InputError("a cover of a claim about decisions", where, REMAKE)
        cuts = read_proof(raw.cuts, "$.cuts")
        return CoverCertificate(raw.profile, raw.system, claim, inhabitant, widths, cuts, raw.sets == FORMS)
