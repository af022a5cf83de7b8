"""Boxes moved one step: a box around all next states of a box, for each piece and joint action.

Does: adds up what a piece and all agents' actions do, exactly; bounds it over boxes, rounded outward; tells which sets
  may hold states of which no dynamics are stated.
Assumes: a system that is well formed.
Does not: know claims.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from math import inf
from typing import NamedTuple

import numpy as np

from codegen.ir import AgentPolicy, Bool, Float64, Int64, PolicyProfile
from verify.checker.covers.boxes import BoxList, Cut, LineCuts, half_line, linear, together
from verify.checker.covers.rounding import Factor, around, ceiling, floor, sum_down
from verify.checker.covers.trees import TreeCuts, choices_of, split_by_trees
from verify.checker.reading import RejectedError
from verify.checker.systems.cases import has_cases, hull_of
from verify.systems.claims import SystemClaim
from verify.systems.system import Box, Piece, System, box_of, find_gap

Terms = tuple[tuple[tuple[str, Fraction], ...], ...]  # of each variable's next value


class _Term(NamedTuple):
    """A term of several next values: their columns of bounds, the columns that are read, and factors above 0. None for
    columns: all of them, in order.
    """

    to: Int64 | None
    read: Int64 | None
    factors: Factor


class _BoxMotion:
    """The motion by joint actions of boxes that differ only in what is added to them. Of a variable that is multiplied
    by a negative number, the bounds of its negative are multiplied by a positive one.
    """

    def __init__(self, terms: Terms, columns: Mapping[str, int]) -> None:
        size, self.terms, self._terms = len(columns), terms, list[_Term]()
        for rank in range(max(map(len, terms), default=0)):
            to = [column for column, form in enumerate(terms) if len(form) > rank]
            reads = [(columns[form[rank][0]], form[rank][1]) for form in terms if len(form) > rank]
            read = [at + size * (factor < 0) for at, factor in reads]
            factors = Factor(*2 * [abs(factor) for _, factor in reads])
            columns_of = [*to, *(at + size for at in to)], [*read, *((at + size) % (2 * size) for at in read)]
            to_, read_ = (None if each == list(range(2 * size)) else np.array(each) for each in columns_of)
            self._terms.append(_Term(to_, read_, factors))

    def move_bounds(self, bounds: Float64, shift: Float64) -> Float64:
        """The bounds of boxes after a step. `shift`: what is added to each, at least; both [n, 2 variables]."""
        image = shift
        for to, read, factors in self._terms:
            product = factors.times_down(bounds if read is None else bounds.take(read, axis=1))
            if to is None:
                image = sum_down(image, product)
            else:
                image = image.copy() if image is shift else image
                image[:, to] = sum_down(image.take(to, axis=1), product)
        return image


class BoxMotion:
    """Boxes moved by a team in a system. `several`: some tree tests several variables at once."""

    def __init__(self, profile: PolicyProfile, system: System) -> None:
        columns = {one.name: column for column, one in enumerate(system.variables)}
        self._trees = [TreeCuts(system, policy, columns) for policy in profile.agents]
        self._pieces = [PieceImage(system, piece, profile.agents) for piece in system.pieces]
        self.several = any(tree.several for tree in self._trees)

    def move_boxes(self, boxes: BoxList) -> BoxList:
        """Boxes around all next states. RejectedError for too many, or for bounds that are no numbers."""
        boxes = split_by_trees(self._trees, boxes)
        least = boxes.bounds.min(axis=0, initial=inf)
        met = [piece for piece in self._pieces if piece.may_meet(least)] or self._pieces[:1]
        return together([piece.move_boxes(piece.within(boxes)) for piece in met])

    def forget(self) -> None:
        """Has the next boxes moved as if none had been before."""
        for tree in self._trees:
            tree.forget()


class PieceImage:
    """One piece: the bounds of its box, and the motions of the joint actions that were met."""

    def __init__(self, system: System, piece: Piece, policies: Sequence[AgentPolicy]) -> None:
        self._names = [one.name for one in system.variables]
        self._columns = {name: column for column, name in enumerate(self._names)}
        self._piece, self._policies = piece, policies
        lines = [half_line(linear(half), self._columns) for half in box_of(piece.where)]
        self._where = LineCuts([line for line in lines if line is not None], len(self._names))
        self._when = [Cut(linear(half), self._columns) for half in piece.when]
        self._motions: dict[Terms, int] = {}  # numbers of the motions
        self._moves: list[_BoxMotion] = []
        self._joints = np.zeros(0, dtype=np.int64)  # the joint actions that were met, in order
        self._kinds = np.zeros(0, dtype=np.int64)  # the number of the motion of each
        self._shifts = np.zeros((0, 2 * len(self._names)))  # what each adds, at least

    def may_meet(self, least: Float64) -> bool:
        """Returns False if no box of a list lies in the box of the piece. `least`: bounds of all of them."""
        return self._where.may_meet(least)

    def within(self, boxes: BoxList) -> BoxList:
        """Boxes around the states that lie in the box of the piece, bounds included, and meet its conditions."""
        for cut in self._when:
            boxes = cut.within(boxes)
        return self._where.within(boxes) if self._piece.where else boxes

    def move_boxes(self, boxes: BoxList) -> BoxList:
        """Boxes around all next states, by the joint actions that are chosen."""
        if not boxes.size:
            return boxes
        at = np.searchsorted(self._joints, boxes.joint)
        if not (len(self._joints) and (self._joints.take(at, mode="clip") == boxes.joint).all()):
            self._meet(sorted(set(boxes.joint.tolist()).difference(self._joints.tolist())))
            at = np.searchsorted(self._joints, boxes.joint)
        bounds, shifts = boxes.bounds, self._shifts.take(at, axis=0)
        if len(self._moves) == 1:
            return boxes._replace(bounds=self._moves[0].move_bounds(bounds, shifts))
        kinds, image = self._kinds.take(at), np.empty_like(bounds)
        for kind, motion in enumerate(self._moves):
            rows = np.flatnonzero(kinds == kind)
            image[rows] = motion.move_bounds(bounds.take(rows, axis=0), shifts.take(rows, axis=0))
        return boxes._replace(bounds=image)

    def _meet(self, joints: Sequence[int]) -> None:
        """Notes how some joint actions move boxes."""
        kinds, shifts = self._kinds.tolist(), self._shifts.tolist()
        for joint in joints:
            choices = choices_of(joint, self._policies)
            forms = [self._piece.total(name, choices) for name in self._names]
            terms = tuple(form.terms for form in forms)
            kinds.append(self._kind(terms))
            ends = [self._bound_shift(name, form.constant) for name, form in zip(self._names, forms, strict=True)]
            shifts.append([*(low for low, _ in ends), *(-high for _, high in ends)])
        met = np.concatenate([self._joints, joints])
        order = np.argsort(met)
        self._joints, self._kinds, self._shifts = met[order], np.array(kinds)[order], np.array(shifts)[order]

    def _kind(self, terms: Terms) -> int:
        """The number of a motion."""
        if self._moves and self._moves[-1].terms == terms:  # mostly: and hashes of fractions are slow
            return len(self._moves) - 1
        if terms not in self._motions:
            self._motions[terms] = len(self._moves)
            self._moves.append(_BoxMotion(terms, self._columns))
        return self._motions[terms]

    def _bound_shift(self, name: str, constant: Fraction) -> tuple[float, float]:
        """Bounds of what is added to a variable: a constant, and an error."""
        if name not in self._piece.error:
            return around(constant)
        low, high = self._piece.error[name]
        return floor(constant + low), ceiling(constant + high)


class StatedStates:
    """The states for which a system says how they move, where a claim needs that. RejectedError for gaps in it."""

    def __init__(self, system: System, claim: SystemClaim) -> None:
        self._columns = {one.name: column for column, one in enumerate(system.variables)}
        self._bounds = self._bound_pieces(system) if claim.steps or claim.says.ever else None

    @property
    def limited(self) -> bool:
        """True if there are states of which nothing is stated."""
        return self._bounds is not None

    def _bound_pieces(self, system: System) -> tuple[Float64, Float64] | None:
        """Bounds of a box all of whose states lie in a piece; None where some piece holds all states."""
        wheres = [piece.where for piece in system.pieces]
        if not all(wheres):
            return None
        bounds: dict[str, tuple[Fraction, Fraction]] = {}
        for where in wheres:
            for name, (low, high) in where.items():
                least, most = bounds.get(name, (low, high))
                bounds[name] = min(least, low), max(most, high)
        if has_cases(system):  # cases.py shows that they leave no gap
            bounds = dict(hull_of(system))
        else:
            whole: Box = bounds
            if any(low >= high for low, high in bounds.values()) or find_gap(whole, wheres) is not None:
                raise RejectedError("the pieces leave gaps between them")
        low = np.full(len(self._columns), -np.inf)
        high = np.full(len(self._columns), np.inf)
        for name, (least, most) in bounds.items():
            low[self._columns[name]], high[self._columns[name]] = ceiling(least), floor(most)
        return low, high

    def beyond(self, low: Float64, high: Float64) -> Bool:
        """Returns True for each set, by bounds [n, variables], that may hold states of which nothing is stated, [n]."""
        if self._bounds is None:
            return np.zeros(len(low), dtype=np.bool_)
        least, most = self._bounds
        return np.asarray(~((low >= least) & (high <= most)).all(axis=1), dtype=np.bool_)
