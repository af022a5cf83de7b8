"""Certificates of claims about episodes of any length: an invariant as cells or as regions.

Does: reads the document; whether it fits a profile and a system, and its sets are an invariant that shows the claim.
Assumes: a profile and a system that were read and checked; a document that anyone made.
Does not: prove, or write (verify/certificates).

The numbers of a part are, for each followed variable, the least cell (zigzag: 2n, or -2n - 1 below 0) and how many it
spans; then the cells in order, each as its distance from the one before. A cell's number has one digit for each
variable, the first the highest. Cuts are those of covers (README.md).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from types import MappingProxyType
from typing import Any, ClassVar, NamedTuple

import msgspec
import numpy as np

from codegen.errors import InputError
from codegen.ir import Int64, PolicyProfile
from verify.checker.covers.boxes import BoxList, Watch
from verify.checker.covers.invariants import MAX_SPAN, MAX_STEPS, InvariantSweep, RegionSweep, ensure_shown
from verify.checker.covers.rounding import floor
from verify.checker.envelope import REMAKE, ensure_readable, ensure_whole, numbers, read_proof
from verify.checker.reading import RejectedError
from verify.checker.systems.certificates import BITS, SystemClaimJson, ensure_asked, read_claim, read_region
from verify.checker.systems.walk import FollowedPart, Proof, SystemQuestions
from verify.exact import read_number
from verify.systems.claims import SystemClaim
from verify.systems.system import Polytope, System, ensure_in_steps

FORM = "maviper-system-certificate-4"
MAX_WIDTH = Fraction(2) ** 200  # of a cell, and 1 over the least


WHOLE = bytes(1)  # cuts of a set that is not cut


class InvariantRegion(NamedTuple):
    """A region of an invariant, and how it is cut. `walk`: the proof of one step from it; None: boxes show it."""

    region: Polytope
    cuts: bytes
    walk: bytes | None = None


class InvariantPart(NamedTuple):
    """An invariant of some variables. Cells: their `widths` by variable, within how many `steps` each comes back, and
    the cells. Or regions: how many `steps` in a row lead to another state in them. `cuts` of the start, and the widths
    of the cells in which boxes are joined, lead to the first step of which the claim speaks.
    """

    widths: Mapping[str, Fraction]
    steps: int
    cells: bytes = b""
    regions: tuple[InvariantRegion, ...] = ()
    cuts: bytes = WHOLE
    joined: Mapping[str, Fraction] = MappingProxyType({})

    @property
    def followed(self) -> list[str]:
        """The variables."""
        halves = [half for each in self.regions for half in each.region]
        return list(self.widths) or list(dict.fromkeys(name for half in halves for name, _ in half.form.terms))


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
        """Bytes of the cells, cuts and walks."""
        of_regions = [each.cuts + (each.walk or b"") for part in self.parts for each in part.regions]
        return sum(map(len, (*(part.cells for part in self.parts), *of_regions)))

    @property
    def made_of(self) -> dict[str, Any]:
        """What a report says of it beside its size."""
        return {"parts": [part.followed for part in self.parts], "steps": [part.steps for part in self.parts]}

    def reading(self, reader: Callable[[bytes], bytes]) -> InvariantCertificate:
        """The same with its cells and cuts given to a reader."""
        parts = [
            part._replace(
                cells=reader(part.cells) if part.cells else part.cells,
                regions=tuple(
                    each._replace(cuts=reader(each.cuts), walk=None if each.walk is None else reader(each.walk))
                    for each in part.regions
                ),
            )
            for part in self.parts
        ]
        return replace(self, parts=tuple(parts))

    def check(self, profile: PolicyProfile, system: System, watch: Watch | None = None) -> int:
        """As the function."""
        return check_certificate(self, profile, system, watch)


def check_certificate(
    certificate: InvariantCertificate, profile: PolicyProfile, system: System, watch: Watch | None = None
) -> int:
    """Checks a certificate; the number of its cells. `watch` is told of all boxes that its cells speak of, by part.

    InputError when it is about another profile or system, or names what they do not have; RejectedError when its sets
    do not show the claim.
    """
    named = {name for part in certificate.parts for name in (*part.followed, *part.joined)}
    ensure_asked(certificate, named, profile, system, ever=True)
    ensure_in_steps(system, "an invariant")
    count, shown = 0, list[frozenset[int]]()
    for number, part in enumerate(certificate.parts):
        seen = None if watch is None else partial(watch, number)
        sets, shows = _check_part(part, certificate.claim, profile, system, seen)
        count, shown = count + sets, [*shown, shows]
    ensure_shown(certificate.claim, shown)
    return count


def _check_part(
    part: InvariantPart,
    claim: SystemClaim,
    profile: PolicyProfile,
    system: System,
    seen: Callable[[BoxList], None] | None,
) -> tuple[int, frozenset[int]]:
    """How many sets of a part were asked about, and which half spaces of the claim it shows. RejectedError."""
    modes = {one.name for one in system.variables if one.modes}
    if not all(1 / MAX_WIDTH < width < MAX_WIDTH for width in (*part.widths.values(), *part.joined.values())):
        raise RejectedError("a cell has a width out of range")
    if any(part.widths[name] != 1 for name in modes & set(part.widths)) or not 1 <= part.steps <= MAX_STEPS:
        raise RejectedError("cells of modes are 1 wide, and a part takes 1 to 8 steps")
    if bool(part.widths) == bool(part.regions) or bool(part.widths) != bool(part.cells):
        raise RejectedError("a part has either cells with their widths, or regions")
    joined = {name: floor(width) for name, width in part.joined.items()}
    start = list(numbers(part.cuts))
    if part.regions:
        regions = [each.region for each in part.regions]
        walks = [each.walk for each in part.regions if each.walk is not None]
        if walks and (len(walks) < len(regions) or part.steps != 1):
            raise RejectedError("one step is walked from all regions, or from none")
        by_regions = RegionSweep(profile, system, claim, regions, 0 if walks else part.steps)
        cuts = [list(numbers(each.cuts)) for each in part.regions]
        arriving = by_regions.motion.arriving(start, joined)
        closed = sum(_check_walk(profile, *by_regions.one_step(number), walk) for number, walk in enumerate(walks))
        return by_regions.check(arriving, cuts) + closed, by_regions.motion.shows
    sweep = InvariantSweep(profile, system, claim, {name: floor(width) for name, width in part.widths.items()})
    cells = read_cells(numbers(part.cells), len(part.widths))
    sweep.check(sweep.motion.arriving(start, joined), cells, part.steps, seen)
    return len(cells), sweep.motion.shows


def _check_walk(profile: PolicyProfile, begun: System, claim: SystemClaim, part: FollowedPart, walk: bytes) -> int:
    """How many branches a proof of one step closes. RejectedError where it does not hold."""
    proof = Proof(numbers(walk, BITS))
    SystemQuestions(profile, begun, claim, part, proof).run()
    proof.ensure_read()
    return proof.closed


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
    digits: list[Int64] = []
    for low, span in zip(reversed(lows), reversed(spans), strict=True):
        digits.append(keys % span + low)
        keys = keys // span
    return np.stack(digits[::-1], axis=1)


# --- the text


class InvariantRegionJson(msgspec.Struct, forbid_unknown_fields=True, omit_defaults=True):
    """A region of a part, in text."""

    region: list[dict[str, Any]]
    cuts: list[str]
    walk: list[str] | None = None


class InvariantPartJson(msgspec.Struct, forbid_unknown_fields=True, omit_defaults=True):
    """A part, in text. Without `cuts` the start is not cut."""

    widths: dict[str, str]
    steps: int
    cells: list[str]
    regions: list[InvariantRegionJson] = []
    cuts: list[str] = []
    joined: dict[str, str] = {}


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
    with ensure_readable(where):
        raw = msgspec.json.decode(text, type=InvariantCertificateJson)
        ensure_whole(raw, FORM, where)
        claim = read_claim(raw.claim)
        if not claim.says.ever:
            raise InputError("an invariant of a claim about some steps", where, REMAKE)
        return InvariantCertificate(
            raw.profile, raw.system, claim, _read_numbers(raw.inhabitant), tuple(map(_read_part, raw.parts))
        )


def _read_numbers(texts: Mapping[str, str]) -> dict[str, Fraction]:
    return {name: read_number(text) for name, text in texts.items()}


def _read_part(raw: InvariantPartJson) -> InvariantPart:
    regions = list(map(_read_region, raw.regions))
    cuts = read_proof(raw.cuts, "$.parts") or WHOLE
    cells, joined = read_proof(raw.cells, "$.parts"), _read_numbers(raw.joined)
    return InvariantPart(_read_numbers(raw.widths), raw.steps, cells, tuple(regions), cuts, joined)


def _read_region(raw: InvariantRegionJson) -> InvariantRegion:
    walk = None if raw.walk is None else read_proof(raw.walk, "$.parts")
    return InvariantRegion(read_region(raw.region), read_proof(raw.cuts, "$.parts"), walk)
