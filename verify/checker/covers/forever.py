"""Certificates of claims about episodes of any length: an invariant as cells.

Does: reads the document; whether it fits a profile and a system, and its cells are an invariant that shows the claim.
Assumes: a profile and a system that were read and checked; a document that anyone made.
Does not: prove, or write (verify/certificates).

The numbers of a part are, for each followed variable, the least cell (zigzag: 2n, or -2n - 1 below 0) and how many it
spans; then the cells in order, each as its distance from the one before. A cell's number has one digit for each
variable, the first the highest.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from typing import Any, ClassVar, NamedTuple

import msgspec
import numpy as np

from codegen.errors import InputError
from codegen.ir import Int64, PolicyProfile
from verify.checker.covers.boxes import Watch
from verify.checker.covers.invariants import MAX_SPAN, MAX_STEPS, InvariantSweep, ensure_shown
from verify.checker.covers.rounding import floor
from verify.checker.envelope import REMAKE, ensure_whole, numbers, read_proof, undamaged
from verify.checker.reading import RejectedError
from verify.checker.systems.certificates import SystemClaimJson, ensure_asked, read_claim
from verify.claims.formula_json import read_number
from verify.systems.claims import SystemClaim
from verify.systems.system import System, ensure_in_steps

FORM = "maviper-system-certificate-4"
MAX_WIDTH = Fraction(2) ** 200  # of a cell, and 1 over the least


class InvariantPart(NamedTuple):
    """Cells of some variables: their `widths` by variable, within how many `steps` each comes back, and the cells."""

    widths: Mapping[str, Fraction]
    steps: int
    cells: bytes


@dataclass(frozen=True)
class InvariantCertificate:
    """A claim about a profile in a stated system, with an invariant. All its parts hold at once."""

    profile: str  # content hash
    system: str  # content hash
    claim: SystemClaim
    inhabitant: Mapping[str, Fraction]  # a start, which shows that there is one
    parts: tuple[InvariantPart, ...]

    counted: ClassVar[str] = "cells"
    unit: ClassVar[str] = "cell"

    @property
    def size(self) -> int:
        """Bytes of the cells."""
        return sum(len(part.cells) for part in self.parts)

    @property
    def made_of(self) -> dict[str, Any]:
        """What a report says of it beside its size."""
        return {"parts": [list(part.widths) for part in self.parts], "steps": [part.steps for part in self.parts]}

    def reading(self, reader: Callable[[bytes], bytes]) -> InvariantCertificate:
        """The same with its cells given to a reader."""
        return replace(self, parts=tuple(part._replace(cells=reader(part.cells)) for part in self.parts))

    def accepted(self, profile: PolicyProfile, system: System, watch: Watch | None = None) -> int:
        """As the function."""
        return accepted(self, profile, system, watch)


def accepted(
    certificate: InvariantCertificate, profile: PolicyProfile, system: System, watch: Watch | None = None
) -> int:
    """Checks a certificate; the number of its cells. `watch` is told of all boxes that it speaks of, by part.

    InputError when it is about another profile or system, or names what they do not have; RejectedError when its cells
    do not show the claim.
    """
    ensure_asked(certificate, {name for part in certificate.parts for name in part.widths}, profile, system, ever=True)
    ensure_in_steps(system, "an invariant")
    count, shown = 0, list[frozenset[int]]()
    modes = {one.name for one in system.variables if one.modes}
    for number, part in enumerate(certificate.parts):
        if not part.widths or not all(1 / MAX_WIDTH < width < MAX_WIDTH for width in part.widths.values()):
            raise RejectedError("a cell has a width out of range")
        if any(part.widths[name] != 1 for name in modes & set(part.widths)) or not 1 <= part.steps <= MAX_STEPS:
            raise RejectedError("cells of modes are 1 wide, and a part takes 1 to 8 steps")
        widths = {name: floor(width) for name, width in part.widths.items()}
        sweep = InvariantSweep(profile, system, certificate.claim, widths)
        cells = read_cells(numbers(part.cells), len(widths))
        sweep.check(cells, part.steps, None if watch is None else partial(watch, number))
        count, shown = count + len(cells), [*shown, sweep.shows]
    ensure_shown(certificate.claim, shown)
    return count


def read_cells(given: Iterator[int], variables: int) -> Int64:
    """The cells that numbers stand for, [n, variables]. RejectedError where there are none, or too large ones."""
    lows, spans, span = list[int](), list[int](), 1
    for _ in range(variables):
        low, size = next(given, 0), next(given, 0)
        lows.append(low // 2 if low % 2 == 0 else -(low // 2) - 1)
        spans.append(size)
        span *= size
    steps = list(given)
    if not 0 < span <= MAX_SPAN or not steps or max([*steps, *map(abs, lows)]) >= MAX_SPAN:
        raise RejectedError("the cells of an invariant are out of range")
    keys = np.cumsum(np.array(steps, dtype=np.int64))
    if not ((keys >= 0) & (keys < span)).all():
        raise RejectedError("the cells of an invariant are out of range")
    return _digits(keys, lows, spans)


def _digits(keys: Int64, lows: Sequence[int], spans: Sequence[int]) -> Int64:
    found: list[Int64] = []
    for low, span in zip(reversed(lows), reversed(spans), strict=True):
        found.append(keys % span + low)
        keys = keys // span
    return np.stack(found[::-1], axis=1)


# --- the text


class InvariantPartJson(msgspec.Struct, forbid_unknown_fields=True):
    """A part, in text."""

    widths: dict[str, str]
    steps: int
    cells: list[str]


class InvariantCertificateJson(msgspec.Struct, forbid_unknown_fields=True):
    """The members of the file; numbers are exact texts."""

    certificate: str
    profile: str
    system: str
    claim: SystemClaimJson
    inhabitant: dict[str, str]
    parts: list[InvariantPartJson]
    content_hash: str


def from_json(text: str | bytes, where: str = "certificate") -> InvariantCertificate:
    """The certificate in a text. InputError when it is damaged, of another version, or edited."""
    with undamaged(where):
        raw = msgspec.json.decode(text, type=InvariantCertificateJson)
        ensure_whole(raw, FORM, where)
        claim = read_claim(raw.claim)
        if not claim.says.ever:
            raise InputError("an invariant of a claim about some steps", where, REMAKE)
        parts = tuple(
            InvariantPart(
                {name: read_number(width) for name, width in part.widths.items()},
                part.steps,
                read_proof(part.cells, "$.parts"),
            )
            for part in raw.parts
        )
        inhabitant = {name: read_number(value) for name, value in raw.inhabitant.items()}
        return InvariantCertificate(raw.profile, raw.system, claim, inhabitant, parts)
