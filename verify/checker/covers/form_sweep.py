"""The sweep of a cover by affine forms: which parts of the start do not meet the claim, as far as forms tell.

Does: follows parts of the start as forms, step by step, and asks the claim of every list.
Assumes: forms.py and form_moves.py bound what they are asked.
Does not: read documents, or cut the start.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from codegen.ir import Bool, PolicyProfile
from verify.checker.covers.boxes import BoxList
from verify.checker.covers.cuts import linear
from verify.checker.covers.form_cuts import FormRegion, FormTree, half
from verify.checker.covers.form_moves import FormPieces
from verify.checker.covers.forms import FormList, of_boxes, with_fewer_columns
from verify.checker.covers.parts import Parts
from verify.checker.covers.rounding import ensure_arithmetic
from verify.checker.covers.stated import StatedStates
from verify.checker.reading import RejectedError
from verify.systems.claims import SystemClaim
from verify.systems.system import System

MAX_SWEPT = 20_000_000  # forms over all steps
MAX_COLUMNS = 64  # of a form
MAX_VARIABLES = 128  # so that all sums are short


class Left(NamedTuple):
    """Which parts are left open, [parts], how many forms were asked about, and why the first part was left open."""

    open: Bool
    forms: int
    why: str


class FormSweep:
    """The sweep for one claim."""

    def __init__(self, profile: PolicyProfile, system: System, claim: SystemClaim) -> None:
        if len(system.variables) > MAX_VARIABLES:
            raise RejectedError(f"more than {MAX_VARIABLES} variables for forms")
        columns = {one.name: column for column, one in enumerate(system.variables)}
        self._claim, self._stated, self._parts = claim, StatedStates(system, claim), Parts(system)
        self._starts = [half(linear(each), columns) for each in system.start if len(each.form.terms) > 1]
        self._trees = [FormTree(system, policy, columns) for policy in profile.agents]
        self._pieces = FormPieces(system, profile.agents)
        self._regions = [FormRegion(list(map(linear, region)), columns) for region in claim.regions]
        self._open, self._why = np.zeros(0, dtype=np.bool_), ""

    def run(self, cuts: Sequence[int]) -> int:
        """How many forms were asked about, of a start cut as proofs say. RejectedError where one may break the claim,
        or leave what is stated.
        """
        swept = 0
        for parts in self._parts.parts(cuts):
            found = self.left(parts._replace(part=np.arange(parts.size)), MAX_SWEPT - swept)
            swept += found.forms
            if found.open.any():
                raise RejectedError(found.why)
        return swept

    def left(self, parts: BoxList, most: int) -> Left:
        """Follows boxes of starts, whose `part` are their places, with at most so many forms in all."""
        ensure_arithmetic()
        self._open, self._why = np.zeros(parts.size, dtype=np.bool_), ""
        with np.errstate(all="ignore"):  # what overflows is not finite, and is left open
            forms = of_boxes(parts)
            for start in self._starts:
                forms = start.within(forms)
            spent = self._follow(forms, most)
        return Left(self._open, spent, self._why)

    def _follow(self, forms: FormList, most: int) -> int:
        spent = 0
        for step in range(self._claim.steps + 1):
            forms = self._without(forms, ~forms.finite, "a form has bounds that are not finite")
            spent += forms.size
            forms = self._asked(forms, step)
            if step == self._claim.steps or not forms.size:
                break
            if spent > most:
                self._without(forms, np.ones(forms.size, dtype=np.bool_), f"more than {most:,} forms")
                break
            low, high = forms.bounds()
            forms = self._without(forms, self._stated.beyond(low, high), f"at step {step}, nothing may be stated")
            forms = self._moved(forms)
        return spent

    def _moved(self, forms: FormList) -> FormList:
        forms = forms._replace(joint=np.zeros(forms.size, dtype=np.int64))
        for tree in self._trees:
            forms = tree.chosen(forms)
        return with_fewer_columns(self._pieces.moved(forms), MAX_COLUMNS)

    def _without(self, forms: FormList, bad: Bool, why: str) -> FormList:
        """The forms of parts that are shown so far, once the parts of some are left open."""
        if not bad.any():
            return forms
        self._why = self._why or why
        self._open[forms.part[bad]] = True
        return forms.taken(~self._open[forms.part])

    def _asked(self, forms: FormList, step: int) -> FormList:
        """The forms that are followed further, once the parts of those that may break the claim are left open."""
        says, claim = self._claim.says, self._claim
        why = f"at step {step} forms may hold states that break the claim"
        if says.avoided:
            for region in self._regions:
                self._leave(region.within(forms), why)
            return forms.taken(~self._open[forms.part])
        outside, counts = forms, not says.first or says.once or step >= claim.by
        for region in self._regions if counts else ():
            outside = region.outside(outside)
        if counts and (not says.once or step == claim.steps):
            self._leave(outside, why)
        forms = outside if says.once else forms
        return forms.taken(~self._open[forms.part])

    def _leave(self, forms: FormList, why: str) -> None:
        self._without(forms, np.ones(forms.size, dtype=np.bool_), why)
