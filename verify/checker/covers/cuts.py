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
from verify.checker.covers.rounding import Factor, ceiling, floor, sum_down, sum_up
from verify.claims.formula import Linear
from verify.systems.system import HalfSpace


class FloatEnd(NamedTuple):
    """Where a half line of numbers up to an end stops: `last` is the largest float in it, `up` no less than the end."""

    last: float
    up: float


def end_of(bound: Fraction, strict: bool) -> FloatEnd:
    """The half line of the numbers that are at most a bound, or below it."""
    last, up = floor(bound), ceiling(bound)
    return FloatEnd(nextafter(last, -inf) if strict and last == up else last, up)


def opposite(inequality: Linear) -> Linear:
    """What holds where an inequality does not."""
    terms = tuple((-weight, name) for weight, name in inequality.terms)
    return Linear(terms, -inequality.bound, not inequality.strict)


def linear(half: HalfSpace) -> Linear:
    """A half space as an inequality."""
    terms = tuple((factor, name) for name, factor in half.form.terms)
    return Linear(terms, -half.form.constant, half.strict)


class Cut:
    """An inequality as a cut of boxes."""

    def __init__(self, inequality: Linear, columns: Mapping[str, int]) -> None:
        self._end = end_of(inequality.bound, inequality.strict)
        terms = [(columns[name], weight) for weight, name in inequality.terms if weight]
        self._always = inequality.bound > 0 or (inequality.bound == 0 and not inequality.strict)
        self._terms = [(column, Factor(weight)) for column, weight in terms]
        self._alone: FloatEnd | None = None
        if len(terms) == 1:
            ((_, weight),) = terms
            self._alone = end_of(inequality.bound / abs(weight), inequality.strict)

    def within(self, boxes: BoxList) -> BoxList:
        """For each box with a state that may meet the inequality, a box around all such states."""
        if not self._terms:
            return boxes if self._always else boxes.taken(np.zeros(boxes.size, dtype=np.bool_))
        if not boxes.size:
            return boxes
        return self._by_one(boxes, self._alone) if self._alone is not None else self._by_all(boxes)

    def _by_one(self, boxes: BoxList, end: FloatEnd) -> BoxList:
        ((column, factor),) = self._terms
        if factor.positive:
            kept = boxes.taken(~(boxes.low[:, column] > end.last))
            kept.high[:, column] = np.minimum(kept.high[:, column], end.up)
        else:
            kept = boxes.taken(~(boxes.high[:, column] < -end.last))
            kept.low[:, column] = np.maximum(kept.low[:, column], -end.up)
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

    def within(self, boxes: BoxList) -> BoxList:
        """Boxes around the states that may lie in it."""
        for inside, _ in self._sides:
            boxes = inside.within(boxes)
        return boxes

    def outside(self, boxes: BoxList) -> BoxList:
        """Boxes around the states that may lie outside of it."""
        found = [boxes.taken(np.zeros(boxes.size, dtype=np.bool_))]
        for inside, outside in self._sides:
            found.append(outside.within(boxes))
            boxes = inside.within(boxes)
        return together(found)
