"""Whether a certificate of a claim about a flow is accepted.

Does: whether it fits a profile and a system, and the sets that are made from it meet the claim.
Assumes: a profile and a system that were read and checked; a document that anyone made.
Does not: prove, read (../systems/proofs.py) or write (verify/certificates).

A certificate says how the start is cut, the order of the series, the steps of a period, and in which cells sets are
joined: at all samples in cells of one width, or by levels (levels.py). All sets and tubes are made from that again, and
every enclosure is shown again.
"""

from __future__ import annotations

from fractions import Fraction

from codegen.errors import InputError
from codegen.ir import PolicyProfile
from verify.checker.certificate import REMAKE, numbers
from verify.checker.covers.rounding import floor
from verify.checker.flows.levels import LevelSweep
from verify.checker.flows.sweep import FlowSweep, Plan, SetWatch
from verify.checker.reading import RejectedError
from verify.checker.systems.certificates import ensure_asked
from verify.checker.systems.proofs import FlowSets, SystemCertificate
from verify.systems.system import System

MAX_WIDTH = Fraction(2) ** 200  # of a cell, and 1 over the least
MAX_ORDER, MAX_STEPS = 30, 1_000
MAX_LEVELS, MAX_EVERY = 20, 1 << 20


def check_certificate(
    certificate: SystemCertificate,
    proof: FlowSets,
    profile: PolicyProfile,
    system: System,
    watch: SetWatch | None = None,
) -> int:
    """Checks a certificate with this proof; the number of its sets over all steps. `watch` is told of the sets, by
    sample.

    InputError when it is about another profile or system, or names what they do not have; RejectedError when its sets
    do not show the claim.
    """
    if system.flow is None:
        raise InputError("the certificate is about continuous time", f"system {system.name} moves in steps", REMAKE)
    ensure_asked(certificate, set(proof.cells), profile, system)
    if certificate.claim.about_decisions or certificate.claim.at_samples is None:
        raise RejectedError("sets of a flow show claims about continuous time only")
    if not 1 <= proof.order <= MAX_ORDER or not 1 <= proof.steps <= MAX_STEPS:
        raise RejectedError(f"the order is not from 1 to {MAX_ORDER}, or the steps are not from 1 to {MAX_STEPS}")
    if not all(1 / MAX_WIDTH < width < MAX_WIDTH for width in proof.cells.values()):
        raise RejectedError("a cell has a width out of range")
    sweep = FlowSweep(profile, system, certificate.claim)
    sweep.sampled = watch
    widths = {sweep.columns[name]: floor(width) for name, width in proof.cells.items()}
    cuts, every, levels = list(numbers(proof.cuts)), proof.joined_every, proof.levels
    plan = Plan(cuts, proof.order, proof.steps, widths, every, levels)
    if levels == 0 and every == 1:
        return sweep.run(plan)
    if not widths or cuts != [0] or not 1 <= levels <= MAX_LEVELS or not 1 <= every <= MAX_EVERY:
        raise RejectedError(
            f"the levels are not from 1 to {MAX_LEVELS}, or the samples between joins not from 1 to {MAX_EVERY:,}, "
            "or there are no cells, or cuts beside them"
        )
    return LevelSweep(sweep, plan).run()
