"""Boxes moved one step: a box around all next states of a box, for each piece and joint action.

Does: adds up what a piece and all agents' actions do, exactly; bounds it over boxes, rounded outward; tells which sets
  may hold states of which no dynamics are stated.
Assumes: a system that is well formed.
Does not: know claims.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import groupby
from math import inf
from typing import NamedTuple

import numpy as np

from codegen.ir import AgentPolicy, Bool, Float64, Int64, PolicyProfile
from verify.checker.covers.boxes import BoxList, Cut, half_line, linear, together
from verify.checker.covers.rounding import Factor, ceiling, floor, sum_down
from verify.checker.covers.trees import LeafWays, PairNumbers, TreeCuts, WayDown, choices_of, meet_all, split_by_trees
from verify.checker.reading import RejectedError
from verify.checker.systems.cases import has_cases, hull_of
from verify.systems.claims import SystemClaim
from verify.systems.system import Box, HalfSpace, System, box_of, find_gap

ZERO = Fraction(0), Fraction(0)
Reads = tuple[tuple[tuple[int, Fraction], ...], ...]  # of each next bound: columns of bounds, and factors above 0


class _Term(NamedTuple):
    """A term of several next bounds, `to`. Of each motion, in one row: the column that is read for each of these, the
    factors, and whether there is such a term, None where there always is.
    """

    to: Int64
    read: Int64
    factors: Factor
    stated: Bool | None


class _BoxMotions:
    """Motions of boxes. Of a variable that is multiplied by a negative number, the bounds of its negative are
    multiplied by a positive one.
    """

    def __init__(self, motions: Sequence[Reads]) -> None:
        self._single = len(motions) == 1
        ranks = max((len(terms) for motion in motions for terms in motion), default=0)
        self._terms = [self._term(motions, rank) for rank in range(ranks)]

    @staticmethod
    def _term(motions: Sequence[Reads], rank: int) -> _Term:
        to = [at for at in range(len(motions[0])) if any(len(motion[at]) > rank for motion in motions)]
        terms = [motion[at][rank : rank + 1] for motion in motions for at in to]
        reads = [term[0] if term else (0, Fraction(1)) for term in terms]
        stated = np.array([bool(term) for term in terms])
        factors = Factor(*(factor for _, factor in reads))
        return _Term(np.array(to), np.array([at for at, _ in reads]), factors, None if stated.all() else stated)

    def move_bounds(self, bounds: Float64, shift: Float64, motion: Int64) -> Float64:
        """The bounds of boxes after a step, [n, 2 variables]. `shift`: what is added to each, at least; `motion`: the
        number of each box's motion, [n].
        """
        image = shift
        for to, read, factors, stated in self._terms:
            if self._single:
                product = factors.times_down(bounds.take(read, axis=1))
            else:
                at = motion[:, None] * len(to) + np.arange(len(to))
                product = factors.times_down(np.take_along_axis(bounds, read.take(at), axis=1), at)
                product = product if stated is None else np.where(stated.take(at), product, 0.0)
            if len(to) == image.shape[1]:
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
        self._pieces = BoxPieces(system, profile.agents)
        self.several = any(tree.several for tree in self._trees)

    def move_boxes(self, boxes: BoxList) -> BoxList:
        """Boxes around all next states. RejectedError for too many, or for bounds that are no numbers."""
        return self._pieces.move_boxes(*self._pieces.cut_boxes(split_by_trees(self._trees, boxes)))

    def forget(self) -> None:
        """Has the next boxes moved as if none had been before."""
        for tree in self._trees:
            tree.forget()


class _Row(NamedTuple):
    """Pieces in a row: conditions, where it is a single one that has some, and the boxes of all."""

    when: Sequence[Cut]
    where: LeafWays


class BoxPieces:
    """All pieces: boxes of theirs that boxes meet, and how they move with the joint actions that were met."""

    def __init__(self, system: System, policies: Sequence[AgentPolicy]) -> None:
        self._names = [one.name for one in system.variables]
        self._columns = {name: column for column, name in enumerate(self._names)}
        self._system, self._policies = system, policies
        self._rows: list[_Row] = []
        for _, numbers in groupby(range(len(system.pieces)), lambda n: n if system.pieces[n].when else None):
            ways: list[WayDown] = []
            when: Sequence[HalfSpace] = ()
            for number in numbers:
                when, where = system.pieces[number].when, box_of(system.pieces[number].where)
                lines = [half_line(linear(half), self._columns) for half in where]
                begun = WayDown.begin(2 * len(self._names), number)
                way = begun.on([line for line in lines if line is not None], number)
                ways += [] if way is None else [way]
            if ways:  # else no state lies in the box of any
                self._rows.append(_Row([Cut(linear(half), self._columns) for half in when], LeafWays(ways)))
        self._numbers = PairNumbers(len(system.pieces))
        self._kinds: dict[Reads, int] = {}  # numbers of the motions
        self._kind = np.zeros(0, dtype=np.int64)  # of each pair of a piece and a joint action that was met
        self._shift = np.zeros((0, 2 * len(self._names)))  # what each adds, at least
        self._motions = _BoxMotions([])

    def cut_boxes(self, boxes: BoxList) -> tuple[BoxList, Int64]:
        """Boxes around the states that lie in the box of a piece, bounds included, and meet its conditions, with the
        number of the piece; a box for each piece that it meets.
        """
        least, cut, pieces = boxes.bounds.min(axis=0, initial=inf), [boxes.take(slice(0, 0))], [np.zeros(0, np.int64)]
        for when, where in self._rows:
            if where.may_meet(least):
                some, way = where.cut_boxes(meet_all(when, boxes))
                cut.append(some)
                pieces.append(where.node.take(way))
        boxes, piece = together(cut), np.concatenate(pieces)
        if (piece[1:] < piece[:-1]).any():  # ways that are looked up come box by box
            order = np.argsort(piece, kind="stable")
            boxes, piece = boxes.take(order), piece.take(order)
        return boxes, piece

    def move_boxes(self, boxes: BoxList, piece: Int64) -> BoxList:
        """Boxes around all next states, by the joint actions that are chosen. `piece`: that moves each, [n]."""
        pairs = self._numbers.find(piece, boxes.joint, self._add)
        kind, shift = self._kind.take(pairs), self._shift.take(pairs, axis=0)
        return boxes._replace(bounds=self._motions.move_bounds(boxes.bounds, shift, kind))

    def _add(self, pairs: Sequence[tuple[int, int]]) -> None:
        """Notes how pieces move boxes in which joint actions are chosen."""
        kinds, shifts, size = self._kind.tolist(), self._shift.tolist(), len(self._columns)
        for number, joint in pairs:
            piece, choices = self._system.pieces[number], choices_of(joint, self._policies)
            forms = [piece.total(name, choices) for name in self._names]
            # What each next bound reads: from below, and then of the negatives.
            lower = [
                tuple((self._columns[name] + size * (factor < 0), abs(factor)) for name, factor in form.terms)
                for form in forms
            ]
            upper = [tuple(((at + size) % (2 * size), factor) for at, factor in terms) for terms in lower]
            kinds.append(self._kinds.setdefault((*lower, *upper), len(self._kinds)))
            errors = [piece.error.get(name, ZERO) for name in self._names]
            least = [floor(form.constant + low) for form, (low, _) in zip(forms, errors, strict=True)]
            most = [ceiling(form.constant + high) for form, (_, high) in zip(forms, errors, strict=True)]
            shifts.append([*least, *(-each for each in most)])
        self._kind, self._shift = np.array(kinds, dtype=np.int64), np.array(shifts)
        self._motions = _BoxMotions(list(self._kinds))


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
