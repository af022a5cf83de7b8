"""Whether a certificate about a stated system is accepted, whatever its proof is.

Does: gives each kind of proof to what checks it.
Assumes: a profile and a system that were read and checked; a certificate that anyone made.
Does not: read or write certificates.
"""

from collections.abc import Callable

from codegen.ir import PolicyProfile
from verify.checker.covers import invariants
from verify.checker.covers import sweep as covers
from verify.checker.covers.boxes import BoxList
from verify.checker.flows import sweep as flows
from verify.checker.flows.steps import SetList
from verify.checker.systems import branch_proofs as walks
from verify.checker.systems.proofs import Cover, FlowSets, Invariant, SystemCertificate, Walks
from verify.systems.system import System

Watch = Callable[[int, BoxList | SetList], None]  # told of what a proof rests on: its step, sample or part, and sets


def accept(certificate: SystemCertificate, profile: PolicyProfile, system: System, watch: Watch | None = None) -> int:
    """Checks a certificate; the number of branches that its proof closes, or of its sets, of which `watch` is told.

    InputError when it is about another profile or system, or names what they do not have; RejectedError when its proof
    does not hold.
    """
    match certificate.proof:
        case Walks() as proof:
            return walks.check_certificate(certificate, proof, profile, system)
        case Cover() as proof:
            return covers.check_certificate(certificate, proof, profile, system, watch)
        case FlowSets() as proof:
            return flows.check_certificate(certificate, proof, profile, system, watch)
        case Invariant() as proof:
            return invariants.check_certificate(certificate, proof, profile, system, watch)
