"""Whether a certificate that is a cover is accepted.

Does: whether it fits a profile and a system, and the sets that are made from it meet the claim.
Assumes: a profile and a system that were read and checked; a document that anyone made.
Does not: prove, read (../systems/proofs.py) or write (verify/certificates).
"""

from __future__ import annotations

from fractions import Fraction

from codegen.ir import PolicyProfile
from verify.checker.certificate import numbers
from verify.checker.covers.boxes import Watch
from verify.checker.covers.forms.sweep import FormSweep
from verify.checker.covers.rounding import floor
from verify.checker.covers.sweep import Cells, CoverSweep
from verify.checker.reading import RejectedError
from verify.checker.systems.certificates import ensure_asked
from verify.checker.systems.proofs import Cover, SystemCertificate
from verify.systems.system import System, ensure_in_steps

MAX_WIDTH = Fraction(2) ** 200  # of a cell, and 1 over the least


def check_certificate(
    certificate: SystemCertificate, proof: Cover, profile: PolicyProfile, system: System, watch: Watch | None = None
) -> int:
    """Checks a certificate with this proof; the number of its sets over all steps. `watch` is told of every list of
    boxes, by its step.

    InputError when it is about another profile or system, or names what they do not have; RejectedError when its sets
    do not show the claim.
    """
    ensure_in_steps(system, "this form of certificate")
    ensure_asked(certificate, set(proof.cells), profile, system)
    claim = certificate.claim
    if claim.about_decisions:
        raise RejectedError("boxes show claims about episodes only")
    columns = {each.name: column for column, each in enumerate(system.variables)}
    if not all(1 / MAX_WIDTH < width < MAX_WIDTH for width in proof.cells.values()):
        raise RejectedError("a cell has a width out of range")
    widths = {columns[name]: floor(width) for name, width in proof.cells.items()}
    cuts = list(numbers(proof.cuts))
    if proof.sets == "boxes":
        return CoverSweep(profile, system, [claim], watch).run(Cells(cuts, widths))[0]
    if widths:
        raise RejectedError("forms are not joined in cells")
    return FormSweep(profile, system, [claim]).run(cuts)
