"""Affine forms in the search for covers: the sweep of the checker, asked which parts of the start it leaves open.

Does: makes that sweep a question of verify/boxes/covering.py.
Assumes: a claim about episodes.
Does not: look for cuts. Whatever it answers, the checker is asked again by the certificate alone.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from codegen.ir import Float64, PolicyProfile
from verify.boxes.covering import FormsSwept, SweepForms
from verify.checker.covers.boxes import BoxList
from verify.checker.covers.forms.sweep import FormSweep
from verify.checker.reading import RejectedError
from verify.systems.claims import SystemClaim
from verify.systems.system import System


def sweep_by_forms(profile: PolicyProfile, system: System, claim: SystemClaim) -> SweepForms | None:
    """The sweep by forms; None for a system whose numbers the arithmetic of forms does not hold."""
    try:
        return partial(_sweep_parts, FormSweep(profile, system, [claim]))
    except RejectedError:
        return None


def _sweep_parts(sweep: FormSweep, low: Float64, high: Float64, most: int) -> FormsSwept:
    count = len(low)
    parts = BoxList.of(low, high, np.arange(count), np.zeros(count, dtype=np.int64))
    try:
        left = sweep.find_open_parts(parts, most)
    except RejectedError:  # a number beyond the arithmetic, or a list that is too long
        return FormsSwept(np.ones(count, dtype=np.bool_), count, stopped=False)
    return FormsSwept(left.open[0], left.forms, left.forms > most)
