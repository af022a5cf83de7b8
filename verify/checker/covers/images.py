"""Boxes moved one step: a box around all next states of a box, for each piece and joint action.

Does: adds up what a piece and all agents' actions do, exactly; bounds it over boxes, rounded outward.
Assumes: a system that is well formed.
Does not: know which action is chosen, or which piece is to move a state.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from codegen.ir import AgentPolicy, Float64
from verify.checker.covers.boxes import BoxList, together
from verify.checker.covers.cuts import Cut, linear
from verify.checker.covers.rounding import Factor, ceiling, floor, sum_down, sum_up
from verify.checker.covers.trees import TreeCuts, digits
from verify.systems.system import Affine, Piece, System

Terms = tuple[tuple[tuple[str, Fraction], ...], ...]  # of each variable's next value


class _Shift(NamedTuple):
    """What is added to the next values: bounds of constants and errors."""

    low: Float64
    high: Float64


class _BoxMotion:
    """How joint actions move boxes that differ in what they add alone."""

    def __init__(self, terms: Terms, columns: Mapping[str, int]) -> None:
        self._forms = [[(columns[name], Factor(factor)) for name, factor in each] for each in terms]

    def moved(self, boxes: BoxList, shift: _Shift) -> BoxList:
        """The boxes after a step. `shift`: for each box, [n, variables]."""
        low, high = np.empty_like(boxes.low), np.empty_like(boxes.high)
        for column, form in enumerate(self._forms):
            least, most = shift.low[:, column], shift.high[:, column]
            for read, factor in form:
                ends = (boxes.low, boxes.high) if factor.positive else (boxes.high, boxes.low)
                least = sum_down(least, factor.times_down(ends[0][:, read]))
                most = sum_up(most, factor.times_up(ends[1][:, read]))
            low[:, column], high[:, column] = least, most
        return BoxList(low, high, boxes.part, boxes.joint)


class PieceImage:
    """One piece: the bounds of its box, and the motions of the joint actions that were met."""

    def __init__(
        self, system: System, piece: Piece, policies: Sequence[AgentPolicy], trees: Sequence[TreeCuts]
    ) -> None:
        self._names = [one.name for one in system.variables]
        self._columns = {name: column for column, name in enumerate(self._names)}
        self._piece, self._policies, self._trees = piece, policies, trees
        bounds = [(self._columns[name], *ends) for name, ends in piece.where.items()]
        self._where = [(at, floor(low), ceiling(low), floor(high), ceiling(high)) for at, low, high in bounds]
        self._when = [Cut(linear(half), self._columns) for half in piece.when]
        self._motions: dict[Terms, int] = {}
        self._known: dict[int, tuple[int, _Shift]] = {}

    def within(self, boxes: BoxList) -> BoxList:
        """Boxes around the states that lie in the box of the piece, bounds included, and meet its conditions."""
        for cut in self._when:
            boxes = cut.within(boxes)
        for column, _, least, most, _ in self._where:
            met = ~(boxes.high[:, column] < least) & ~(boxes.low[:, column] > most)
            if not met.all():
                boxes = boxes.taken(met)
        if not self._where:
            return boxes
        boxes = boxes._replace(low=boxes.low.copy(), high=boxes.high.copy())
        for column, low, _, _, high in self._where:
            boxes.low[:, column] = np.maximum(boxes.low[:, column], low)
            boxes.high[:, column] = np.minimum(boxes.high[:, column], high)
        return boxes

    def moved(self, boxes: BoxList) -> BoxList:
        """Boxes around all next states, by the joint actions that are chosen."""
        joints, of = np.unique(boxes.joint, return_inverse=True)
        known = [self._of_joint(int(joint)) for joint in joints]
        kinds = np.array([kind for kind, _ in known], dtype=np.int64)[of.reshape(boxes.size)]
        low = np.array([shift.low for _, shift in known])[of.reshape(boxes.size)]
        high = np.array([shift.high for _, shift in known])[of.reshape(boxes.size)]
        found: list[BoxList] = []
        for terms, kind in self._motions.items():
            rows = np.flatnonzero(kinds == kind)
            if len(rows):
                motion = _BoxMotion(terms, self._columns)
                found.append(motion.moved(boxes.taken(rows), _Shift(low[rows], high[rows])))
        return together(found) if found else boxes

    def _of_joint(self, joint: int) -> tuple[int, _Shift]:
        if joint not in self._known:
            forms = [self._total(name, joint) for name in self._names]
            errors = [self._piece.error.get(name, (Fraction(0), Fraction(0))) for name in self._names]
            low = [floor(form.constant + error[0]) for form, error in zip(forms, errors, strict=True)]
            high = [ceiling(form.constant + error[1]) for form, error in zip(forms, errors, strict=True)]
            shift = _Shift(np.array(low), np.array(high))
            kind = self._motions.setdefault(tuple(form.terms for form in forms), len(self._motions))
            self._known[joint] = kind, shift
        return self._known[joint]

    def _total(self, name: str, joint: int) -> Affine:
        """The next value of a variable as one exact form, without the error."""
        form = self._piece.move.get(name, Affine())
        for policy, action in zip(self._policies, digits(joint, self._trees), strict=True):
            choice = policy.agent, policy.actions[action].name
            form = form.plus(self._piece.effect.get(choice, {}).get(name, Affine()))
        return form
