"""Affine forms in the search for covers: the sweep of the checker, asked which parts of the start it leaves open.

Does: makes that sweep a question of verify/boxes/covering.py.
Assumes: a claim about episodes.
Does not: look for cuts. Whatever it answers, the checker is asked again by the certificate alone.
"""

from __future__ import annotations

import numpy as np

from codegen.ir import Float64, PolicyProfile
from verify.boxes.covering import Sweeping
from verify.boxes.sweep import Swept
from verify.checker.covers.boxes import BoxList
from verify.checker.covers.form_sweep import FormSweep
from verify.checker.reading import RejectedError
from verify.systems.claims import SystemClaim
from verify.systems.system import System


def formwise(profile: PolicyProfile, system: System, claim: SystemClaim) -> Sweeping | None:
    """The sweep by forms; None for a system whose numbers the arithmetic of forms does not hold."""
    try:
        sweep = FormSweep(profile, system, claim)
    except RejectedError:
        return None

    def swept(low: Float64, high: Float64, most: int) -> Swept:
        count = len(low)
        parts = BoxList(low, high, np.arange(count), np.zeros(count, dtype=np.int64))
        try:
            return Swept(*sweep.left(parts, most)[:2])
        except RejectedError:  # a number beyond the arithmetic, or a list that is too long
            return Swept(np.ones(count, dtype=np.bool_), most)

    return swept
