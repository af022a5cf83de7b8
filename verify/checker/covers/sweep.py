"""The sweep of a cover: step by step, sets that hold every state, each of which has to meet the claim.

Does: follows parts of the start as boxes or as affine forms, asks the claim of every list, and tells which parts it
  leaves open; says whether a certificate that is a cover fits a profile and a system, and shows its claim.
Assumes: images.py, trees.py, boxes.py and forms.py bound what they are asked; a certificate that anyone made.
Does not: read documents (../systems/proofs.py), or choose cuts and cells. A list is computed anew from the one before,
  so a proof holds none.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import ClassVar, Generic, NamedTuple, Protocol, TypeVar

import numpy as np

from codegen.ir import Bool, Float64, PolicyProfile
from verify.checker.certificate import numbers
from verify.checker.covers.boxes import (
    MAX_BOXES,
    BoxList,
    Parts,
    RegionCut,
    StartBox,
    Watch,
    alike_joined,
    in_cells,
    linear,
    widths_of,
)
from verify.checker.covers.forms import FormList, FormPieces, FormRegion, FormTree, cut_of, of_boxes, with_fewer_columns
from verify.checker.covers.images import BoxMotion, StatedStates
from verify.checker.covers.rounding import ensure_arithmetic
from verify.checker.reading import RejectedError
from verify.checker.systems.branch_proofs import ensure_asked
from verify.checker.systems.proofs import Cover, SystemCertificate
from verify.systems.claims import SystemClaim
from verify.systems.system import Polytope, System, ensure_in_steps

MAX_COLUMNS = 64  # of a form
MAX_VARIABLES = 128  # of forms, so that all sums are short
S = TypeVar("S", BoxList, FormList)


class Swept(NamedTuple):
    """The parts left open, [parts], how many sets were asked about, why the first part was left open, and whether what
    was allowed stopped the sweep.
    """

    open: Bool
    sets: int
    why: str
    stopped: bool


class Region(Protocol[S]):
    """A polytope that cuts sets of one kind."""

    def within(self, sets: S, /) -> S:
        """Sets around the states that may lie in it."""
        ...

    def outside(self, sets: S, /) -> S:
        """Sets around the states that may lie outside of it."""
        ...


class CoverSweep(ABC, Generic[S]):
    """The sweep for one claim by sets of one kind. RejectedError for a system that these do not hold."""

    nouns: ClassVar[tuple[str, str]]  # of one, of several
    most: ClassVar[int]  # over all steps

    def __init__(self, profile: PolicyProfile, system: System, claim: SystemClaim) -> None:
        self.columns = {one.name: column for column, one in enumerate(system.variables)}
        self.parts, self._claim, self._stated = Parts(system), claim, StatedStates(system, claim)
        self._regions = [self._region(region) for region in claim.regions]
        self._open, self._swept, self._why, self._stopped = np.zeros(0, dtype=np.bool_), 0, "", False

    @abstractmethod
    def _region(self, region: Polytope) -> Region[S]:
        """A region of the claim, as it cuts sets."""

    @abstractmethod
    def _begin(self, boxes: BoxList) -> S:
        """Boxes of starts as sets."""

    @abstractmethod
    def _join(self, sets: S, widths: Mapping[int, float], step: int) -> S:
        """Sets that hold all states of a step, joined in cells; those that are not finite are left open."""

    @abstractmethod
    def _bounds(self, sets: S) -> tuple[Float64, Float64]:
        """Bounds of each variable, [n, variables]."""

    @abstractmethod
    def _move(self, sets: S) -> S:
        """Sets that hold all next states."""

    def run(self, cuts: Sequence[int], widths: Mapping[int, float] | None = None) -> int:
        """Sweeps the start, cut as a proof says; returns the number of sets asked about. RejectedError where one may
        break the claim, or leave what is stated.

        `cuts`: for each box in turn, 0 where it is swept as it is, else 1 more than the column of the variable at whose
        middle it is cut, the lower half first. `widths`: of the cells in which boxes are joined, by column.
        """
        swept = 0
        for starts in self.parts.cut(cuts):
            left = self.find_open_parts(starts, self.most - swept, widths)
            swept += left.sets
            if left.open.any():
                raise RejectedError(left.why)
        return swept

    def find_open_parts(
        self, starts: Sequence[StartBox], most: int, widths: Mapping[int, float] | None = None
    ) -> Swept:
        """Follows parts of the start, with at most so many sets in all. Where one cannot be followed, all are open."""
        self._open, self._swept, self._why, self._stopped = np.zeros(len(starts), dtype=np.bool_), 0, "", False
        try:
            ensure_arithmetic()
            with np.errstate(all="ignore"):  # what overflows is not finite, and is left open
                self._follow(self._begin(self.parts.box_starts(starts)), most, widths or {})
        except RejectedError as error:  # a number beyond the arithmetic, or a list that is too long
            self._open[:], self._why = True, self._why or str(error)
            self._swept = max(self._swept, len(starts))
        return Swept(self._open, self._swept, self._why, self._stopped)

    def _follow(self, sets: S, most: int, widths: Mapping[int, float]) -> None:
        for step in range(self._claim.steps + 1):
            if self._swept + sets.size > most:
                self._leave(sets, f"more than {most:,} {self.nouns[1]}")
                self._swept, self._stopped = self._swept + sets.size, True
                return
            sets = self._join(sets, widths, step)
            self._swept += sets.size
            sets = self._ask_claim(sets, step)
            if step == self._claim.steps:
                return
            if self._stated.limited:
                beyond = self._stated.beyond(*self._bounds(sets))
                self._leave(
                    sets.take(beyond), f"at step {step} a {self.nouns[0]} may hold states of which nothing is stated"
                )
            if self._open.any():
                sets = sets.take(~self._open[sets.part])
            if not sets.size:
                return
            sets = self._move(sets)

    def _ask_claim(self, sets: S, step: int) -> S:
        """The sets that are followed further, once the parts of those that may break the claim are left open."""
        says, claim = self._claim.says, self._claim
        outside, counts = sets, not says.first or says.once or step >= claim.by
        broken = [region.within(sets) for region in self._regions] if says.avoided else []
        for region in self._regions if counts and not says.avoided else ():
            outside = region.outside(outside)
        if counts and not says.avoided and (not says.once or step == claim.steps):
            broken = [outside]
        count = sum(each.size for each in broken)
        for each in broken:
            self._leave(each, f"at step {step} {count:,} {self.nouns[1]} may hold states that break the claim")
        return outside if says.once else sets

    def _leave(self, sets: S, why: str) -> None:
        """Leaves the parts of some sets open."""
        if sets.size:
            self._why = self._why or why
            self._open[sets.part] = True


class BoxSweep(CoverSweep[BoxList]):
    """The sweep by boxes. `watch` is told of every list, by its step; `largest`: of a list."""

    nouns, most = ("box", "boxes"), 200_000_000

    def __init__(
        self,
        profile: PolicyProfile,
        system: System,
        claim: SystemClaim,
        watch: Watch | None = None,
        largest: int = MAX_BOXES,
    ) -> None:
        super().__init__(profile, system, claim)
        self.motion, self._watch, self._largest = BoxMotion(profile, system), watch, largest

    def _region(self, region: Polytope) -> RegionCut:
        return RegionCut(region, self.columns)

    def _begin(self, boxes: BoxList) -> BoxList:
        return boxes

    def _join(self, sets: BoxList, widths: Mapping[int, float], step: int) -> BoxList:
        sets = in_cells(sets, widths, self._largest) if widths else sets
        wild = ~sets.finite
        if wild.any():
            self._leave(sets.take(wild), "a box has bounds that are not finite")
            sets = sets.take(~wild)
        if self._watch is not None:
            self._watch(step, sets)
        return sets

    def _bounds(self, sets: BoxList) -> tuple[Float64, Float64]:
        return sets.low, sets.high

    def _move(self, sets: BoxList) -> BoxList:
        sets = self.motion.move_boxes(sets)
        if sets.size > self._largest:
            raise RejectedError(f"a list has more than {self._largest:,} boxes")
        return alike_joined(sets) if self.motion.several else sets


class FormSweep(CoverSweep[FormList]):
    """The sweep by affine forms, which are not joined in cells."""

    nouns, most = ("form", "forms"), 20_000_000

    def __init__(self, profile: PolicyProfile, system: System, claim: SystemClaim) -> None:
        super().__init__(profile, system, claim)
        if len(system.variables) > MAX_VARIABLES:
            raise RejectedError(f"more than {MAX_VARIABLES} variables for forms")
        self._starts = [cut_of(linear(each), self.columns) for each in system.start if len(each.form.terms) > 1]
        self._trees = [FormTree(system, policy, self.columns) for policy in profile.agents]
        self._pieces = FormPieces(system, profile.agents)

    def _region(self, region: Polytope) -> FormRegion:
        return FormRegion(region, self.columns)

    def _begin(self, boxes: BoxList) -> FormList:
        forms = of_boxes(boxes)
        for start in self._starts:
            forms = start.within(forms)
        return forms

    def _join(self, sets: FormList, widths: Mapping[int, float], step: int) -> FormList:
        if widths:
            raise RejectedError("forms are not joined in cells")
        self._leave(sets.take(~sets.finite), "a form has bounds that are not finite")
        return sets.take(sets.finite)

    def _bounds(self, sets: FormList) -> tuple[Float64, Float64]:
        return sets.bounds()

    def _move(self, sets: FormList) -> FormList:
        sets = sets._replace(joint=np.zeros(sets.size, dtype=np.int64))
        for tree in self._trees:
            sets = tree.split_at_tests(sets)
        return with_fewer_columns(self._pieces.move_forms(sets), MAX_COLUMNS)


def check_certificate(
    certificate: SystemCertificate, proof: Cover, profile: PolicyProfile, system: System, watch: Watch | None = None
) -> int:
    """Checks a certificate with this proof; the number of its sets over all steps. `watch` is told of every list of
    boxes, by its step.

    InputError when it is about another profile or system, or names what they do not have; RejectedError when its sets
    do not show the claim.
    """
    ensure_in_steps(system, "this form of certificate")
    ensure_asked(certificate, set(proof.cells), profile, system)
    claim = certificate.claim
    if claim.about_decisions:
        raise RejectedError("boxes show claims about episodes only")
    columns = {each.name: column for column, each in enumerate(system.variables)}
    widths = {columns[name]: width for name, width in widths_of(proof.cells).items()}
    sweep = BoxSweep(profile, system, claim, watch) if proof.sets == "boxes" else FormSweep(profile, system, claim)
    return sweep.run(list(numbers(proof.cuts)), widths)
