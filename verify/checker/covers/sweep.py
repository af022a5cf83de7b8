"""The sweep of a cover: step by step, boxes that hold every state, each of which has to meet the claim.

Does: cuts the start into the parts that a proof names, cuts and moves their boxes, joins them in the cells of the
  proof, and asks the claim of every list.
Assumes: images.py, trees.py and cuts.py bound what they are asked.
Does not: read documents. A list is computed anew from the one before, so a proof holds no boxes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from codegen.ir import PolicyProfile
from verify.checker.covers.boxes import BoxList, Watch, alike_joined, in_cells, together
from verify.checker.covers.cuts import RegionCut, linear
from verify.checker.covers.images import PieceImage
from verify.checker.covers.parts import Parts
from verify.checker.covers.rounding import ensure_arithmetic
from verify.checker.covers.stated import StatedStates
from verify.checker.covers.trees import TreeCuts, split_by_trees
from verify.checker.reading import RejectedError
from verify.systems.claims import SystemClaim
from verify.systems.system import System

MAX_SWEPT = 200_000_000  # boxes over all steps


@dataclass(frozen=True)
class Cells:
    """The cuts of the start, and the cells in which boxes are joined. `cuts`: for each box in turn, 0 where it is swept
    as it is, else 1 more than the column of the variable at whose middle it is cut, the lower half first. `widths`: of
    cells, by column; none: boxes are not joined.
    """

    cuts: Sequence[int]
    widths: Mapping[int, float]


class _ClaimCuts:
    """A claim, with its regions as cuts, and how many boxes were asked about."""

    def __init__(self, claim: SystemClaim, columns: Mapping[str, int]) -> None:
        self.claim, self.swept = claim, 0
        self._regions = [RegionCut(list(map(linear, region)), columns) for region in claim.regions]

    def ask(self, boxes: BoxList, step: int) -> BoxList:
        """The boxes that are followed further. RejectedError where one may hold a state that breaks the claim."""
        says, claim = self.claim.says, self.claim
        if says.avoided:
            self._ensure_none([region.within(boxes) for region in self._regions], step)
            return boxes
        outside = boxes
        if says.once or not says.first or step >= claim.by:
            for region in self._regions:
                outside = region.outside(outside)
        if says.once:
            self._ensure_none([outside] if step == claim.steps else [], step)
            return outside
        self._ensure_none([outside] if not says.first or step >= claim.by else [], step)
        return boxes

    def _ensure_none(self, lists: Sequence[BoxList], step: int) -> None:
        count = sum(each.size for each in lists)
        if count:
            raise RejectedError(f"at step {step} {count:,} boxes may hold states that break the claim")


class CoverSweep:
    """The sweep for some claims, whose lists are the same as far as they go: one that is fulfilled once, of which boxes
    are dropped on the way, is swept alone. `watch` is told of every list, by its step.
    """

    def __init__(
        self, profile: PolicyProfile, system: System, claims: Sequence[SystemClaim], watch: Watch | None = None
    ) -> None:
        if len(claims) > 1 and any(claim.says.once for claim in claims):
            raise ValueError("a claim that is fulfilled once is swept alone")
        columns = {one.name: column for column, one in enumerate(system.variables)}
        self._asked = [_ClaimCuts(claim, columns) for claim in claims]
        self._trees = [TreeCuts(system, policy, columns) for policy in profile.agents]
        self._pieces = [PieceImage(system, piece, profile.agents, self._trees) for piece in system.pieces]
        self._several = any(tree.several for tree in self._trees)
        self._parts, self._stated = Parts(system), StatedStates(system, max(claims, key=lambda claim: claim.steps))
        self._watch = watch

    def run(self, cells: Cells) -> list[int]:
        """For each claim, how many boxes were asked about. RejectedError where one may break it, or leave what is
        stated.
        """
        ensure_arithmetic()
        with np.errstate(all="ignore"):  # what overflows is not finite, and is refused
            for boxes in self._parts.parts(cells.cuts):
                self._follow(boxes, cells.widths)
        return [one.swept for one in self._asked]

    def _follow(self, boxes: BoxList, widths: Mapping[int, float]) -> None:
        step, asked = 0, self._asked
        while True:
            boxes = in_cells(boxes, widths) if widths else boxes
            boxes.ensure_finite()
            if self._watch is not None:
                self._watch(step, boxes)
            size = boxes.size
            for one in asked:
                one.swept += size
                if one.swept > MAX_SWEPT:
                    raise RejectedError(f"the cover has more than {MAX_SWEPT:,} boxes")
                boxes = one.ask(boxes, step)
            asked = [one for one in asked if one.claim.steps > step]
            if not asked or not boxes.size:
                return
            if self._stated.limited and self._stated.beyond(boxes.low, boxes.high).any():
                raise RejectedError(f"at step {step} a box may hold states of which nothing is stated")
            boxes = split_by_trees(self._trees, boxes)
            boxes = together([piece.move_boxes(piece.within(boxes)) for piece in self._pieces])
            boxes = alike_joined(boxes) if self._several else boxes
            step += 1
