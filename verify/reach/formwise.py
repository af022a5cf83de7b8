"""Affine forms in the search for covers: the sweep of the checker, asked which parts of the start it leaves open.

Does: makes that sweep a question of verify/boxes/covering.py.
Assumes: a claim about episodes.
Does not: look for cuts. Whatever it answers, the checker is asked again by the certificate alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from functools import partial

import numpy as np

from codegen.ir import Float64, PolicyProfile
from verify.boxes.covering import FormsOf, FormsSwept
from verify.checker.covers.boxes import BoxList
from verify.checker.covers.forms.sweep import FormSweep
from verify.checker.reading import RejectedError
from verify.systems.claims import SystemClaim
from verify.systems.system import System


def formwise(profile: PolicyProfile, system: System, claims: Sequence[SystemClaim]) -> list[FormsOf]:
    """The sweeps by forms: one for all claims but those that one state fulfils, which have one each. None for a system
    whose numbers the arithmetic of forms does not hold.
    """
    shared = tuple(number for number, claim in enumerate(claims) if not claim.says.once)
    alone = [(number,) for number, claim in enumerate(claims) if claim.says.once]
    sweeps: list[FormsOf] = []
    for group in (*([shared] if shared else []), *alone):
        with suppress(RejectedError):
            sweep = FormSweep(profile, system, [claims[number] for number in group])
            sweeps.append(FormsOf(group, partial(_sweep_parts, sweep, len(group))))
    return sweeps


def _sweep_parts(sweep: FormSweep, claims: int, low: Float64, high: Float64, most: int) -> FormsSwept:
    count = len(low)
    parts = BoxList.of(low, high, np.arange(count), np.zeros(count, dtype=np.int64))
    try:
        left = sweep.find_open_parts(parts, most)
    except RejectedError:  # a number beyond the arithmetic, or a list that is too long
        return FormsSwept(np.ones((claims, count), dtype=np.bool_), count, stopped=False)
    return FormsSwept(left.open, left.forms, left.forms > most)
