"""Whether a certificate about episodes of any length is accepted: an invariant as cells or as regions.

Does: whether it fits a profile and a system, and its sets are an invariant that shows the claim.
Assumes: a profile and a system that were read and checked; a document that anyone made.
Does not: prove, read (../systems/proofs.py) or write (verify/certificates).

The numbers of a part are, for each followed variable, the least cell (zigzag: 2n, or -2n - 1 below 0) and how many it
spans; then the cells in order, each as its distance from the one before. A cell's number has one digit for each
variable, the first the highest. Cuts are those of covers (README.md).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from functools import partial

import numpy as np

from codegen.ir import Int64, PolicyProfile
from verify.checker.certificate import numbers
from verify.checker.covers.boxes import BoxList, Watch
from verify.checker.covers.invariants import MAX_SPAN, MAX_STEPS, InvariantSweep, RegionSweep, ensure_shown
from verify.checker.covers.rounding import floor
from verify.checker.reading import RejectedError
from verify.checker.systems.certificates import close_branches, ensure_asked
from verify.checker.systems.proofs import Invariant, InvariantPart, SystemCertificate
from verify.systems.claims import SystemClaim
from verify.systems.system import System, ensure_in_steps

MAX_WIDTH = Fraction(2) ** 200  # of a cell, and 1 over the least


def check_certificate(
    certificate: SystemCertificate, proof: Invariant, profile: PolicyProfile, system: System, watch: Watch | None = None
) -> int:
    """Checks a certificate with this proof; the number of its cells. `watch` is told of all boxes that its cells speak
    of, by part.

    InputError when it is about another profile or system, or names what they do not have; RejectedError when its sets
    do not show the claim.
    """
    named = {name for part in proof.parts for name in (*part.followed, *part.joined)}
    ensure_asked(certificate, named, profile, system, ever=True)
    ensure_in_steps(system, "an invariant")
    count, shown = 0, list[frozenset[int]]()
    for number, part in enumerate(proof.parts):
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
    """Checks a part; returns how many sets were asked about, and the half spaces that it shows. RejectedError."""
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
        closed = sum(close_branches(profile, *by_regions.one_step(number), walk) for number, walk in enumerate(walks))
        return by_regions.check(arriving, cuts) + closed, by_regions.motion.shows
    sweep = InvariantSweep(profile, system, claim, {name: floor(width) for name, width in part.widths.items()})
    cells = read_cells(numbers(part.cells), len(part.widths))
    sweep.check(sweep.motion.arriving(start, joined), cells, part.steps, seen)
    return len(cells), sweep.motion.shows


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
