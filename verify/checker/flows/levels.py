"""A sweep of a claim about a flow by levels: cells become narrower where wider ones did not show the claim.

Does: joins sets in cells at every few samples; marks the boxes from which all that follows was shown; at the next
  level, whose cells are half as wide, follows only what lies in no such box.
Assumes: sweep.py follows sets, and says of which it does not show the claim.
Does not: read documents, or choose cells.

A level has boxes at each sample where sets are joined. What leaves them lies in boxes of this level at the next such
sample, or in marked boxes of levels before. A box is marked if all that was followed of it up to that sample met the
claim, and so are all boxes of its level that hold what left it. So every episode that is in a marked box at its sample
meets the claim from then on. Numbers of cells are hashed to find boxes; whether they hold a part is asked of bounds.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from codegen.ir import Bool, Float64, Int64
from verify.checker.covers.boxes import BoxList, cut, least_of_runs
from verify.checker.flows.sets import SetList, build_sets
from verify.checker.flows.sweep import MAX_SETS, FlowSweep, Plan
from verify.checker.reading import RejectedError


class _Span(NamedTuple):
    """A level between two samples. Its boxes: `hashes` of their cells, sorted, `bounds`, which are `marked`; of what
    came into them, from which box of the span before (`sources`) into which (`targets`).
    """

    hashes: Int64
    bounds: Float64
    marked: Bool
    sources: Int64
    targets: Int64

    def hold(self, parts: BoxList, hashes: Int64) -> Bool:
        """Returns True for each part that lies in a marked box."""
        place = np.minimum(np.searchsorted(self.hashes, hashes), len(self.hashes) - 1)
        inside = (parts.bounds >= self.bounds[place]).all(axis=1)
        return np.asarray((self.hashes[place] == hashes) & self.marked[place] & inside)


class LevelSweep:
    """The levels of a `plan`, whose `levels` says how many it needs; `why`: what was not shown at last."""

    def __init__(self, sweep: FlowSweep, plan: Plan) -> None:
        self._sweep, self.plan, self._told = sweep, plan, sweep.sampled
        self.why = ""
        self._seen: list[tuple[int, SetList]] = []
        self._levels: list[tuple[Mapping[int, float], dict[int, _Span]]] = []

    @property
    def levels(self) -> int:
        """The number of levels followed."""
        return len(self._levels)

    def run(self) -> int:
        """Follows all levels; returns the number of sets asked about. RejectedError where the claim is not shown."""
        shown = [self.descend() for _ in range(self.plan.levels)]
        if not shown[-1]:
            raise RejectedError(self.why)
        return self._sweep.swept

    def descend(self) -> bool:
        """Follows one more level; whether all starts are shown. RejectedError for too many sets; then it was none."""
        widths = {column: width * 0.5**self.levels for column, width in self.plan.widths.items()}
        parts, last, spans = self._sweep.starts, self._sweep.last, dict[int, _Span]()
        seen: list[list[tuple[int, SetList]]] = []
        for first in range(0, max(last, 1), self.plan.every):
            parts, hashes = _hash_cells(self._drop_shown(parts, first), widths)
            if not parts.size:
                break
            order = np.argsort(hashes, kind="stable")
            hashes, parts = hashes[order], parts.take(order)
            begins = np.flatnonzero(np.diff(hashes, prepend=hashes[0] - 1))
            boxes, bounds = np.arange(len(begins)), least_of_runs(parts.bounds, begins)
            marked, targets = boxes >= 0, np.repeat(boxes, np.diff(begins, append=len(hashes)))
            spans[first] = _Span(hashes[begins], bounds, marked, parts.part, targets)
            joined = BoxList(bounds, boxes, np.zeros_like(boxes))
            parts, left = self._follow(joined, first, min(first + self.plan.every, last))
            marked[list(left)] = False
            self.why = next(iter(left.values()), self.why)
            seen.append(self._seen)
        _unmark(list(spans.values()))
        self._levels.append((widths, spans))
        self._tell(list(spans.values()), seen)
        return all(span.marked.all() for span in list(spans.values())[:1])

    def _drop_shown(self, parts: BoxList, first: int) -> BoxList:
        """Returns the parts that lie in no marked box of the levels before, cut by their cells."""
        for widths, spans in self._levels:
            if first in spans and parts.size:
                parts, hashes = _hash_cells(parts, widths)
                parts = parts.take(~spans[first].hold(parts, hashes))
        return parts

    def _follow(self, boxes: BoxList, first: int, end: int) -> tuple[BoxList, dict[int, str]]:
        """Returns what is left of boxes at a later sample, and for boxes not shown up to it, why."""
        self._seen = []
        self._sweep.sampled = None if self._told is None else lambda at, sets: self._seen.append((at, sets))
        try:
            after = self._sweep.follow_sets(build_sets(boxes, int(self.plan.every > 1)), self.plan, first, end)
        finally:
            self._sweep.sampled = self._told
        return BoxList.of(after.box.low, after.box.high, after.part, np.zeros_like(after.part)), self._sweep.open

    def _tell(self, spans: list[_Span], seen: list[list[tuple[int, SetList]]]) -> None:
        """Tells of the sets that come from marked boxes."""
        if self._told is not None:
            for span, lists in zip(spans, seen, strict=True):
                for at, sets in lists:
                    self._told(at, sets.take(span.marked[sets.part]))


def _unmark(spans: list[_Span]) -> None:
    """Unmarks boxes that something leaves for an unmarked one."""
    for before, after in zip(reversed(spans[:-1]), reversed(spans[1:]), strict=True):
        before.marked[after.sources[~after.marked[after.targets]]] = False


def _hash_cells(parts: BoxList, widths: Mapping[int, float]) -> tuple[BoxList, Int64]:
    """Boxes cut at the bounds of cells, and hashes of the cells that they lie in."""
    parts, cells = cut(parts, widths)
    if parts.size > MAX_SETS:
        raise RejectedError(f"a list has more than {MAX_SETS:,} sets")
    factors = np.random.default_rng(0).integers(1, 2**62, size=cells.shape[1]) | 1
    return parts, cells @ factors
