"""Boxes cut by inequalities: a box that holds all states of a box in which an inequality holds.

Does: half spaces with exact numbers as cuts of boxes; the boxes within and outside of a polytope.
Assumes: finite bounds. A box is dropped only where a bound shows that no state of it is meant.
Does not: know trees, claims or moves.

A bound is a float64, so an inequality whose end lies between two floats, or is not reached, is met by a box exactly if
the box reaches the last float that meets it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from math import inf, nextafter
from typing import NamedTuple

import numpy as np

from codegen.ir import Bool, Float64
from verify.checker.covers.boxes import BoxList, together
from verify.checker.covers.rounding import Factor, around, sum_down, sum_up
from verify.claims.formula import Linear
from verify.systems.system import HalfSpace


class FloatEnd(NamedTuple):
    """Where a half line of numbers up to an end stops: `last` is the largest float in it, `up` no less than the end."""

    last: float
    up: float


def end_of(bound: Fraction, strict: bool) -> FloatEnd:
    """The half line of the numbers that are at most a bound, or below it."""
    last, up = around(bound)
    return FloatEnd(nextafter(last, -inf) if strict and last == up else last, up)


class BoundLine(NamedTuple):
    """An inequality of one variable: the column of `BoxList.bounds` that it bounds from above, the column of the other
    side, and its end there. `down`: no more than the end.
    """

    near: int
    far: int
    end: FloatEnd
    down: float

    @property
    def opposite(self) -> BoundLine:
        """The bound that holds where this one does not."""
        (last, up), down = self.end, self.down
        beyond = nextafter(-up, -inf) if last == up else -up  # a float that belongs to the one side only
        return BoundLine(self.far, self.near, FloatEnd(beyond, -down), -up)


def half_line(inequality: Linear, columns: Mapping[str, int]) -> BoundLine | None:
    """An inequality of one variable as bounds have it; None for one of none, or of several. `columns`: of all."""
    terms = [(weight, columns[name]) for weight, name in inequality.terms if weight]
    if len(terms) != 1:
        return None
    ((weight, low),) = terms
    high = low + len(columns)
    near, far = (low, high) if weight.numerator > 0 else (high, low)
    size = weight if weight.numerator > 0 else -weight
    bound = inequality.bound if size == 1 else inequality.bound / size
    down, up = around(bound)
    last = nextafter(down, -inf) if inequality.strict and down == up else down
    return BoundLine(near, far, FloatEnd(last, up), down)


def opposite(inequality: Linear) -> Linear:
    """Returns the negation of an inequality."""
    terms = tuple((-weight, name) for weight, name in inequality.terms)
    return Linear(terms, -inequality.bound, not inequality.strict)


def linear(half: HalfSpace) -> Linear:
    """A half space as an inequality."""
    terms = tuple((factor, name) for name, factor in half.form.terms)
    return Linear(terms, -half.form.constant, half.strict)


class Cut:
    """An inequality as a cut of boxes. `line`: the same as a half line, where it is about one variable."""

    def __init__(self, inequality: Linear, columns: Mapping[str, int]) -> None:
        self.line = half_line(inequality, columns)
        self._always = inequality.bound > 0 or (inequality.bound == 0 and not inequality.strict)
        self._terms: list[tuple[int, Factor]] = []
        if self.line is None:
            self._end = end_of(inequality.bound, inequality.strict)
            self._terms = [(columns[name], Factor(weight)) for weight, name in inequality.terms if weight]

    def within(self, boxes: BoxList) -> BoxList:
        """For each box with a state that may meet the inequality, a box around all such states."""
        if not boxes.size:
            return boxes
        if self.line is not None:
            return self._by_one(boxes, self.line)
        if not self._terms:
            return boxes if self._always else boxes.take(slice(0, 0))
        return self._by_all(boxes)

    @staticmethod
    def _by_one(boxes: BoxList, line: BoundLine) -> BoxList:
        met, first = ~(boxes.bounds[:, line.near] > line.end.last), -line.end.up
        if not met.any():
            return boxes.take(slice(0, 0))
        if met.all() and (boxes.bounds[:, line.far] >= first).all():
            return boxes
        kept = boxes.take(met)
        kept.bounds[:, line.far] = np.maximum(kept.bounds[:, line.far], first)
        return kept

    def _by_all(self, boxes: BoxList) -> BoxList:
        low, high = boxes.low, boxes.high
        least = [factor.times_down((low if factor.positive else high)[:, i]) for i, factor in self._terms]
        met = ~(_total_down(least) > self._end.last)
        kept, least = boxes.take(met), [each[met] for each in least]
        for place, (column, factor) in enumerate(self._terms):
            left = sum_up(-_total_down(least[:place] + least[place + 1 :]), self._end.up)
            at = column + kept.variables * factor.positive  # of the bound on the other side
            first = -factor.into_up(left) if factor.positive else factor.into_down(left)
            kept.bounds[:, at] = np.maximum(kept.bounds[:, at], first)
        empty = np.asarray((kept.low > kept.high).any(axis=1), dtype=np.bool_)
        return kept.take(~empty)


def _total_down(values: Sequence[Float64]) -> Float64:
    total = values[0]
    for each in values[1:]:
        total = sum_down(total, each)
    return total


class LineCuts:
    """Inequalities of one variable each, as one cut. `variables`: how many there are."""

    def __init__(self, lines: Sequence[BoundLine], variables: int) -> None:
        self._last, self._first = np.full(2 * variables, inf), np.full(2 * variables, -inf)
        for near, far, end, _ in lines:
            self._last[near] = min(self._last[near], end.last)
            self._first[far] = max(self._first[far], -end.up)
        self._none = bool((self._first > self._last).any())  # no state meets all

    def may_meet(self, least: Float64) -> bool:
        """Returns False if no box meets all of them, of those whose bounds are at least so large."""
        return not (least > self._last).any()

    def within(self, boxes: BoxList) -> BoxList:
        """For each box with a state that may meet all of them, a box around all such states."""
        if self._none:
            return boxes.take(slice(0, 0))
        beyond: Bool = np.asarray((boxes.bounds > self._last).any(axis=1), dtype=np.bool_)
        boxes = boxes.take(~beyond) if beyond.any() else boxes
        return boxes._replace(bounds=np.maximum(boxes.bounds, self._first))


class RegionCut:
    """A polytope, by the cuts of its half spaces and of their opposites."""

    def __init__(self, inequalities: Sequence[Linear], columns: Mapping[str, int]) -> None:
        self._sides = [(Cut(each, columns), Cut(opposite(each), columns)) for each in inequalities]
        lines = [outside.line for _, outside in self._sides]
        self._single = None not in lines
        self._inside = LineCuts([inside.line for inside, _ in self._sides if inside.line], len(columns))
        self._columns = np.array([each.near for each in lines if each], dtype=np.int64)
        self._last = np.array([each.end.last for each in lines if each])

    def within(self, boxes: BoxList) -> BoxList:
        """Boxes around the states that may lie in it."""
        boxes = self._inside.within(boxes)
        for inside, _ in () if self._single else self._sides:
            boxes = boxes if inside.line else inside.within(boxes)
        return boxes

    def outside(self, boxes: BoxList) -> BoxList:
        """Boxes around the states that may lie outside of it."""
        none = boxes.take(slice(0, 0))
        if self._single and (boxes.bounds.take(self._columns, axis=1) > self._last).all():
            return none
        outer_parts = [none]
        for inside, outside in self._sides:
            outer_parts.append(outside.within(boxes))
            boxes = inside.within(boxes)
        return together(outer_parts)
