"""The sweep of a cover by affine forms: which parts of the start do not meet the claim, as far as forms tell.

Does: follows parts of the start as forms, step by step, and asks the claim of every list.
Assumes: arrays.py and moves.py bound what they are asked.
Does not: read documents, or cut the start.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from codegen.ir import Bool, PolicyProfile
from verify.checker.covers.boxes import BoxList
from verify.checker.covers.cuts import linear
from verify.checker.covers.forms.arrays import FormList, of_boxes, with_fewer_columns
from verify.checker.covers.forms.cuts import FormRegion, FormTree, half
from verify.checker.covers.forms.moves import FormPieces
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
    """The parts left open for each claim, [claims, parts], how many forms were asked about, and why the first part was
    left open.
    """

    open: Bool
    forms: int
    why: str


class FormSweep:
    """The sweep for some claims: for one, or for several none of which a single state fulfils."""

    def __init__(self, profile: PolicyProfile, system: System, claims: Sequence[SystemClaim]) -> None:
        if len(claims) != 1 and any(claim.says.once for claim in claims):
            raise RejectedError("a claim that one state fulfils is followed alone")
        if len(system.variables) > MAX_VARIABLES:
            raise RejectedError(f"more than {MAX_VARIABLES} variables for forms")
        columns = {one.name: column for column, one in enumerate(system.variables)}
        self._claims, self._parts = claims, Parts(system)
        self._stated = [StatedStates(system, claim) for claim in claims]
        self._starts = [half(linear(each), columns) for each in system.start if len(each.form.terms) > 1]
        self._trees = [FormTree(system, policy, columns) for policy in profile.agents]
        self._pieces = FormPieces(system, profile.agents)
        self._regions = [[FormRegion(list(map(linear, each)), columns) for each in claim.regions] for claim in claims]
        self._open, self._why = np.zeros((0, 0), dtype=np.bool_), ""

    def run(self, cuts: Sequence[int]) -> int:
        """Sweeps a start, cut as proofs say; returns the number of forms asked about. RejectedError where one may break
        the claim, or leave what is stated.
        """
        swept = 0
        for parts in self._parts.parts(cuts):
            left = self.find_open_parts(parts._replace(part=np.arange(parts.size)), MAX_SWEPT - swept)
            swept += left.forms
            if left.open.any():
                raise RejectedError(left.why)
        return swept

    def find_open_parts(self, parts: BoxList, most: int) -> Left:
        """Follows boxes of starts, whose `part` are their places, with at most so many forms in all."""
        ensure_arithmetic()
        self._open, self._why = np.zeros((len(self._claims), parts.size), dtype=np.bool_), ""
        with np.errstate(all="ignore"):  # what overflows is not finite, and is left open
            forms = of_boxes(parts)
            for start in self._starts:
                forms = start.within(forms)
            spent = self._follow(forms, most)
        return Left(self._open, spent, self._why)

    def _follow(self, forms: FormList, most: int) -> int:
        spent, everyone = 0, range(len(self._claims))
        for step in range(max(claim.steps for claim in self._claims) + 1):
            asked = [number for number in everyone if self._claims[number].steps >= step]
            going = [number for number in asked if self._claims[number].steps > step]
            self._leave(asked, forms.take(~forms.finite), "a form has bounds that are not finite")
            forms = forms.take(forms.finite)
            spent += forms.size
            for number in asked:
                forms = self._ask_claim(forms, number, step)
            low, high = forms.bounds()
            for number in going:
                beyond = self._stated[number].beyond(low, high)
                self._leave([number], forms.take(beyond), f"at step {step}, nothing may be stated")
            shut = self._open[going][:, forms.part].all(axis=0)  # all, where no claim goes on
            forms = forms.take(np.asarray(~shut, dtype=np.bool_))
            if not forms.size:
                break
            if spent > most:
                self._leave(going, forms, f"more than {most:,} forms")
                break
            forms = self._move_forms(forms)
        return spent

    def _move_forms(self, forms: FormList) -> FormList:
        forms = forms._replace(joint=np.zeros(forms.size, dtype=np.int64))
        for tree in self._trees:
            forms = tree.split_at_tests(forms)
        return with_fewer_columns(self._pieces.move_forms(forms), MAX_COLUMNS)

    def _ask_claim(self, forms: FormList, number: int, step: int) -> FormList:
        """The forms that are followed further, once the parts of those that may break a claim are left open for it."""
        claim = self._claims[number]
        says, regions = claim.says, self._regions[number]
        why = f"at step {step} forms may hold states that break the claim"
        if says.avoided:
            for region in regions:
                self._leave([number], region.within(forms), why)
            return forms
        outside, counts = forms, not says.first or says.once or step >= claim.by
        for region in regions if counts else ():
            outside = region.outside(outside)
        if counts and (not says.once or step == claim.steps):
            self._leave([number], outside, why)
        return outside if says.once else forms

    def _leave(self, numbers: Sequence[int], forms: FormList, why: str) -> None:
        """Leaves the parts of some forms open for some claims."""
        if forms.size:
            self._why = self._why or why
            for number in numbers:
                self._open[number, forms.part] = True
