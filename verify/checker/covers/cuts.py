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

from codegen.ir import Float64
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
        """What holds where it does not."""
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
    near, far = (low, high) if weight > 0 else (high, low)
    bound = inequality.bound if abs(weight) == 1 else inequality.bound / abs(weight)
    down, up = around(bound)
    last = nextafter(down, -inf) if inequality.strict and down == up else down
    return BoundLine(near, far, FloatEnd(last, up), down)


def opposite(inequality: Linear) -> Linear:
    """What holds where an inequality does not."""
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
            return boxes if self._always else boxes.taken(slice(0, 0))
        return self._by_all(boxes)

    @staticmethod
    def _by_one(boxes: BoxList, line: BoundLine) -> BoxList:
        size = boxes.low.shape[1]
        column, rises = line.near % size, line.near < size
        ends = (boxes.low, boxes.high) if rises else (-boxes.high, -boxes.low)
        least, most = (each[:, column] for each in ends)
        met = ~(least > line.end.last)
        if not met.any():
            return boxes.taken(slice(0, 0))
        if met.all() and (most <= line.end.up).all():
            return boxes
        kept, most = boxes.taken(met), np.minimum(most[met], line.end.up)
        if rises:
            kept.high[:, column] = most
        else:
            kept.low[:, column] = -most
        return kept

    def _by_all(self, boxes: BoxList) -> BoxList:
        least = [factor.times_down((boxes.low if factor.positive else boxes.high)[:, i]) for i, factor in self._terms]
        met = ~(_total_down(least) > self._end.last)
        kept, least = boxes.taken(met), [each[met] for each in least]
        for place, (column, factor) in enumerate(self._terms):
            left = sum_up(-_total_down(least[:place] + least[place + 1 :]), self._end.up)
            if factor.positive:
                kept.high[:, column] = np.minimum(kept.high[:, column], factor.into_up(left))
            else:
                kept.low[:, column] = np.maximum(kept.low[:, column], factor.into_down(left))
        empty = np.asarray((kept.low > kept.high).any(axis=1), dtype=np.bool_)
        return kept.taken(~empty)


def _total_down(values: Sequence[Float64]) -> Float64:
    total = values[0]
    for each in values[1:]:
        total = sum_down(total, each)
    return total


class RegionCut:
    """A polytope, by the cuts of its half spaces and of their opposites."""

    def __init__(self, inequalities: Sequence[Linear], columns: Mapping[str, int]) -> None:
        self._sides = [(Cut(each, columns), Cut(opposite(each), columns)) for each in inequalities]
        lines = [outside.line for _, outside in self._sides]
        self._single = None not in lines
        self._columns = np.array([each.near for each in lines if each], dtype=np.int64)
        self._last = np.array([each.end.last for each in lines if each])

    def within(self, boxes: BoxList) -> BoxList:
        """Boxes around the states that may lie in it."""
        for inside, _ in self._sides:
            boxes = inside.within(boxes)
        return boxes

    def outside(self, boxes: BoxList) -> BoxList:
        """Boxes around the states that may lie outside of it."""
        found = [boxes.taken(slice(0, 0))]
        if self._single and (boxes.bounds.take(self._columns, axis=1) > self._last).all():
            return found[0]
        for inside, outside in self._sides:
            found.append(outside.within(boxes))
            boxes = inside.within(boxes)
        return together(found)
