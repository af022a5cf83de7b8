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

from codegen.ir import AgentPolicy, Float64, Int64
from verify.checker.covers.boxes import BoxList, bounded
from verify.checker.covers.cuts import Cut, linear
from verify.checker.covers.rounding import Factor, around, ceiling, floor, sum_down
from verify.checker.covers.trees import TreeCuts, digits
from verify.systems.system import Affine, Piece, System

Terms = tuple[tuple[tuple[str, Fraction], ...], ...]  # of each variable's next value


class _Term(NamedTuple):
    """A term of several next values: their columns of bounds, the columns that are read, and factors above 0."""

    to: Int64
    read: Int64
    factors: Factor


class _BoxMotion:
    """How joint actions move boxes that differ in what they add alone. Of a variable that is multiplied by a negative
    number, the bounds of its negative are multiplied by a positive one.
    """

    def __init__(self, terms: Terms, columns: Mapping[str, int]) -> None:
        size, self._terms = len(columns), list[_Term]()
        for rank in range(max(map(len, terms), default=0)):
            to = [column for column, form in enumerate(terms) if len(form) > rank]
            reads = [(columns[form[rank][0]], form[rank][1]) for form in terms if len(form) > rank]
            read = [at + size * (factor < 0) for at, factor in reads]
            factors = Factor(*2 * [abs(factor) for _, factor in reads])
            both = np.array([*to, *(at + size for at in to)])
            self._terms.append(_Term(both, np.array([*read, *((at + size) % (2 * size) for at in read)]), factors))

    def moved(self, bounds: Float64, shift: Float64) -> Float64:
        """The bounds of boxes after a step. `shift`: what is added to each, at least; both [n, 2 variables]."""
        found = shift.copy()
        for to, read, factors in self._terms:
            product = factors.times_down(bounds.take(read, axis=1))
            found[:, to] = sum_down(found.take(to, axis=1), product)
        return found


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
        self._motions: dict[Terms, int] = {}  # numbers of the motions
        self._moves: list[_BoxMotion] = []
        self._joints = np.zeros(0, dtype=np.int64)  # the joint actions that were met, in order
        self._kinds = np.zeros(0, dtype=np.int64)  # the number of the motion of each
        self._shifts = np.zeros((0, 2 * len(self._names)))  # what each adds, at least

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
        if not boxes.size:
            return boxes
        at = np.searchsorted(self._joints, boxes.joint)
        if not (len(self._joints) and (self._joints.take(at, mode="clip") == boxes.joint).all()):
            self._meet(np.setdiff1d(boxes.joint, self._joints).tolist())
            at = np.searchsorted(self._joints, boxes.joint)
        bounds, shifts = boxes.bounds, self._shifts.take(at, axis=0)
        if len(self._moves) == 1:
            return bounded(self._moves[0].moved(bounds, shifts), boxes.part, boxes.joint)
        kinds, found = self._kinds.take(at), np.empty_like(bounds)
        for kind, motion in enumerate(self._moves):
            rows = np.flatnonzero(kinds == kind)
            found[rows] = motion.moved(bounds.take(rows, axis=0), shifts.take(rows, axis=0))
        return bounded(found, boxes.part, boxes.joint)

    def _meet(self, joints: Sequence[int]) -> None:
        """Notes how some joint actions move boxes."""
        kinds, shifts = self._kinds.tolist(), self._shifts.tolist()
        for joint in joints:
            forms = [self._total(name, joint) for name in self._names]
            terms = tuple(form.terms for form in forms)
            if terms not in self._motions:
                self._motions[terms] = len(self._moves)
                self._moves.append(_BoxMotion(terms, self._columns))
            kinds.append(self._motions[terms])
            ends = [self._added(name, form.constant) for name, form in zip(self._names, forms, strict=True)]
            shifts.append([*(low for low, _ in ends), *(-high for _, high in ends)])
        met = np.concatenate([self._joints, joints])
        order = np.argsort(met)
        self._joints, self._kinds, self._shifts = met[order], np.array(kinds)[order], np.array(shifts)[order]

    def _added(self, name: str, constant: Fraction) -> tuple[float, float]:
        """Bounds of what is added to a variable: a constant, and an error."""
        if name not in self._piece.error:
            return around(constant)
        low, high = self._piece.error[name]
        return floor(constant + low), ceiling(constant + high)

    def _total(self, name: str, joint: int) -> Affine:
        """The next value of a variable as one exact form, without the error."""
        form = self._piece.move.get(name, Affine())
        for policy, action in zip(self._policies, digits(joint, self._trees), strict=True):
            effect = self._piece.effect.get((policy.agent, policy.actions[action].name), {})
            form = form.plus(effect[name]) if name in effect else form
        return form
