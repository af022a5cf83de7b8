"""Certificates of claims about flows: the document, and whether it is accepted.

Does: reads the document; whether it fits a profile and a system, and the sets that are made from it meet the claim.
Assumes: a profile and a system that were read and checked; a document that anyone made.
Does not: prove, or write (verify/certificates).

A certificate says how the start is cut, the order of the series, the steps of a period, and in which cells sets are
joined: at all samples in cells of one width, or by levels (levels.py). All sets and tubes are made from that again, and
every enclosure is shown again.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, ClassVar

import msgspec

from codegen.errors import InputError
from codegen.floats import rational_literal
from codegen.ir import PolicyProfile
from verify.checker.covers.rounding import floor
from verify.checker.envelope import REMAKE, ensure_readable, ensure_whole, numbers, read_proof
from verify.checker.flows.levels import LevelSweep
from verify.checker.flows.sweep import FlowSweep, Plan, SetWatch
from verify.checker.reading import RejectedError
from verify.checker.systems.certificates import SystemClaimJson, ensure_asked, read_claim
from verify.exact import read_number
from verify.systems.claims import SystemClaim
from verify.systems.system import System

FORM = "maviper-system-certificate-3"
MAX_WIDTH = Fraction(2) ** 200  # of a cell, and 1 over the least
MAX_ORDER, MAX_STEPS = 30, 1_000
MAX_LEVELS, MAX_EVERY = 20, 1 << 20


@dataclass(frozen=True)
class FlowCertificate:
    """A claim about a profile in continuous time, with what its sets are made from."""

    profile: str  # content hash
    system: str  # content hash
    claim: SystemClaim
    inhabitant: Mapping[str, Fraction]  # a start, which shows that there is one
    order: int  # of the series
    steps: int  # of a period
    widths: Mapping[str, Fraction]  # of cells, by variable; none: sets are not joined
    cuts: bytes  # of the start
    every: int = 1  # so many samples sets are joined, by levels
    levels: int = 0  # of cells, each half as wide as those before; 0: cells of one width

    counted: ClassVar[str] = "sets"
    unit: ClassVar[str] = "set"

    @property
    def size(self) -> int:
        """Bytes of the cuts."""
        return len(self.cuts)

    @property
    def made_of(self) -> dict[str, Any]:
        """What a report says of it beside its size."""
        widths = {name: rational_literal(width) for name, width in self.widths.items()}
        levels = {"joined_every": self.every, "levels": self.levels} if self.levels else {}
        return {"order": self.order, "steps_of_a_period": self.steps, "cells": widths, **levels}

    def reading(self, reader: Callable[[bytes], bytes]) -> FlowCertificate:
        """The same with its cuts given to a reader."""
        return replace(self, cuts=reader(self.cuts))

    def check(self, profile: PolicyProfile, system: System, watch: SetWatch | None = None) -> int:
        """As the function."""
        return check_certificate(self, profile, system, watch)


def check_certificate(
    certificate: FlowCertificate, profile: PolicyProfile, system: System, watch: SetWatch | None = None
) -> int:
    """Checks a certificate; the number of its sets over all steps. `watch` is told of the sets, by sample.

    InputError when it is about another profile or system, or names what they do not have; RejectedError when its sets
    do not show the claim.
    """
    if system.flow is None:
        raise InputError("the certificate is about continuous time", f"system {system.name} moves in steps", REMAKE)
    ensure_asked(certificate, set(certificate.widths), profile, system)
    if certificate.claim.about_decisions or certificate.claim.at_samples is None:
        raise RejectedError("sets of a flow show claims about continuous time only")
    if not 1 <= certificate.order <= MAX_ORDER or not 1 <= certificate.steps <= MAX_STEPS:
        raise RejectedError(f"the order is not from 1 to {MAX_ORDER}, or the steps are not from 1 to {MAX_STEPS}")
    if not all(1 / MAX_WIDTH < width < MAX_WIDTH for width in certificate.widths.values()):
        raise RejectedError("a cell has a width out of range")
    sweep = FlowSweep(profile, system, certificate.claim)
    sweep.sampled = watch
    widths = {sweep.columns[name]: floor(width) for name, width in certificate.widths.items()}
    cuts, every, levels = list(numbers(certificate.cuts)), certificate.every, certificate.levels
    plan = Plan(cuts, certificate.order, certificate.steps, widths, every, levels)
    if levels == 0 and every == 1:
        return sweep.run(plan)
    if not widths or cuts != [0] or not 1 <= levels <= MAX_LEVELS or not 1 <= every <= MAX_EVERY:
        raise RejectedError(
            f"the levels are not from 1 to {MAX_LEVELS}, or the samples between joins not from 1 to {MAX_EVERY:,}, "
            "or there are no cells, or cuts beside them"
        )
    return LevelSweep(sweep, plan).run()


# --- the text


class FlowCertificateJson(msgspec.Struct, forbid_unknown_fields=True, omit_defaults=True):
    """The members of the file; numbers are exact texts. Older files do not have those with defaults."""

    certificate: str
    profile: str
    system: str
    claim: SystemClaimJson
    at_samples: bool
    inhabitant: dict[str, str]
    order: int
    steps: int
    cells: dict[str, str]
    cuts: list[str]
    content_hash: str
    joined_every: int = 1
    levels: int = 0


def from_json(text: str | bytes, where: str = "certificate") -> FlowCertificate:
    """The certificate in a text. InputError when it is damaged, of another version, or edited."""
    with ensure_readable(where):
        raw = msgspec.json.decode(text, type=FlowCertificateJson)
        ensure_whole(raw, FORM, where)
        inhabitant = {name: read_number(value) for name, value in raw.inhabitant.items()}
        widths = {name: read_number(value) for name, value in raw.cells.items()}
        claim = replace(read_claim(raw.claim), at_samples=raw.at_samples)
        cuts, every, levels = read_proof(raw.cuts, "$.cuts"), raw.joined_every, raw.levels
        steps = raw.order, raw.steps
        return FlowCertificate(raw.profile, raw.system, claim, inhabitant, *steps, widths, cuts, every, levels)
