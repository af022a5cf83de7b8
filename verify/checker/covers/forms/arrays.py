"""Affine forms as arrays: sets of states that depend on the start, cut by inequalities and moved by matrices.

Does: the data of a list of forms; bounds of sums over them; cuts; images; fewer columns where there are many.
Assumes: float64 that rounds to nearest (rounding.py asks). Whatever order sums are taken in, what rounding loses is
  bounded and put into the radius.
Does not: know systems, trees or claims; refuse what is not finite, which the sweep does.

A form is the set of all  middle + sum of z_j columns_j + r,  each z_j in [-1, 1], each |r_i| at most radius_i. A box
keeps no trace of where its states came from, so rotations and x + dt v widen it. A form keeps it in its columns.

A sum of n products of floats, in any order and with or without fused operations, is off by at most n u / (1 - n u)
times the sum of absolute products, u = 2^-53 (Higham, Accuracy and Stability of Numerical Algorithms, 3.1), besides
what underflows. `LOST` is twice u, so (n + 4) LOST has room for factors that are rounded themselves, and for the
rounding of the bound.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from codegen.ir import Bool, Float64, Int64
from verify.checker.covers.boxes import BoxList
from verify.checker.reading import RejectedError

LOST = 2.0**-52
_MORE = 1.0 + 2.0**-44  # widens a bound that was computed in a few roundings
_UNDER = 2.0**-960  # more than underflow takes from any sum here
LEAST = 2.0**-900  # of a factor other than 0
MAX_NUMBERS = 1 << 26  # in the columns of one list


class FormList(NamedTuple):
    """Forms: `middle` and `radius` [n, variables], `columns` [n, k, variables]; `part` and `joint` as of boxes."""

    middle: Float64
    columns: Float64
    radius: Float64
    part: Int64
    joint: Int64

    @property
    def size(self) -> int:
        """The number of forms."""
        return len(self.part)

    def take(self, which: Bool | Int64) -> FormList:
        """Some of the forms, by a mask or by their numbers."""
        return FormList(
            self.middle[which], self.columns[which], self.radius[which], self.part[which], self.joint[which]
        )

    def reach(self) -> Float64:
        """Returns about how far the columns and the radius reach from the middle, [n, variables]."""
        return np.abs(self.columns).sum(axis=1) + self.radius

    def bounds(self) -> tuple[Float64, Float64]:
        """Bounds of each variable, [n, variables]."""
        reach = self.reach()
        lost = (np.abs(self.middle) + reach) * (self.columns.shape[1] + 4) * LOST + _UNDER
        reach = np.where(reach > 0, reach * _MORE + lost, 0.0)
        return self.middle - reach, self.middle + reach

    @property
    def finite(self) -> Bool:
        """True for each form that has finite numbers only, [n]."""
        whole = np.abs(self.columns).sum(axis=(1, 2)) + np.abs(self.middle).sum(axis=1) + self.radius.sum(axis=1)
        return np.isfinite(whole)


def of_boxes(boxes: BoxList) -> FormList:
    """Forms around boxes, with a column for each variable along which some box is wide."""
    middle = 0.5 * boxes.low + 0.5 * boxes.high
    half = np.maximum(boxes.high - middle, middle - boxes.low)
    half = np.where(half > 0, half * _MORE + np.abs(middle) * 2 * LOST + _UNDER, 0.0)
    wide = np.flatnonzero((half > 0).any(axis=0))
    columns = np.zeros((boxes.size, len(wide), half.shape[1]))
    columns[:, np.arange(len(wide)), wide] = half[:, wide]
    return FormList(middle, columns, np.zeros_like(middle), boxes.part, boxes.joint)


def together(lists: Sequence[FormList]) -> FormList:
    """The forms of some lists in one. RejectedError for too many."""
    if sum(each.columns.size for each in lists) > MAX_NUMBERS:
        raise RejectedError(f"a list of forms has more than {MAX_NUMBERS:,} numbers")
    kept = [each for each in lists if each.size] or lists[:1]
    return kept[0] if len(kept) == 1 else FormList(*map(np.concatenate, zip(*kept, strict=True)))


class Sums(NamedTuple):
    """A sum of multiples of variables over forms: `value` in the middle [n], `slopes` along the columns [n, k], and a
    bound of all else, `rest` [n].
    """

    value: Float64
    slopes: Float64
    rest: Float64

    @property
    def low(self) -> Float64:
        """A number at most the sum, [n]."""
        return self.value - self._reach

    @property
    def high(self) -> Float64:
        """A number at least the sum, [n]."""
        return self.value + self._reach

    @property
    def _reach(self) -> Float64:
        reach = np.abs(self.slopes).sum(axis=1) + self.rest
        lost = (np.abs(self.value) + reach) * (self.slopes.shape[1] + 4) * LOST
        return np.where(reach > 0, reach * _MORE + lost, 0.0)

    def take(self, which: Bool) -> Sums:
        """Those of some of the forms."""
        return Sums(*(column[which] for column in self))

    def negative(self) -> Sums:
        """Of the negated multiples."""
        return Sums(-self.value, -self.slopes, self.rest)


def sums(forms: FormList, weights: Float64) -> Sums:
    """Sums the variables of forms by weights. `weights`: [variables], or for each form, [n, variables]; each the float
    nearest to an exact number, which is 0 or not below LEAST.
    """
    weights = np.broadcast_to(weights, forms.middle.shape)
    value = (forms.middle * weights).sum(axis=1)
    slopes = np.einsum("nkd,nd->nk", forms.columns, weights)
    size = np.abs(weights)
    lost = (size * (np.abs(forms.middle) + forms.reach())).sum(axis=1) * (sum(forms.columns.shape[1:]) + 8) * LOST
    plain = ((size > 0).sum(axis=1) == 1) & (size.max(axis=1) == 1)  # one variable: nothing is rounded
    rest = (size * forms.radius).sum(axis=1)
    return Sums(value, slopes, np.where(plain, rest, (rest + lost) * _MORE + _UNDER))


def narrow_forms(forms: FormList, of: Sums, most: float | Float64) -> FormList:
    """Forms that hold all states in which a sum is at most a number (of each form, [n])."""
    slopes = np.abs(of.slopes)
    reach = slopes.sum(axis=1)
    room = (most - of.value) + (reach + of.rest)
    room += (np.abs(most) + np.abs(of.value) + reach + of.rest) * (slopes.shape[1] + 8) * LOST
    ends = np.divide(room[:, None] - slopes, slopes, out=np.ones_like(slopes), where=slopes > 0)
    ends = np.clip(ends + (np.abs(ends) + 1) * 8 * LOST, -1.0, 1.0)  # of each z_j, with the sign of its slope
    half = np.where(ends < 1, 0.5 * (1 + ends) + 4 * LOST, 1.0)
    shift = np.where(ends < 1, 0.5 * (ends - 1), 0.0) * np.sign(of.slopes)
    middle = forms.middle + np.einsum("nk,nkd->nd", shift, forms.columns)
    wide = np.abs(forms.columns).sum(axis=1)
    lost = (np.abs(forms.middle) + wide) * (slopes.shape[1] + 8) * LOST + _UNDER
    radius = np.where(wide > 0, (forms.radius + lost) * _MORE, forms.radius)
    columns = forms.columns * half[:, :, None]
    return forms._replace(middle=middle, columns=columns, radius=radius)


def sides(of: Sums, last: float | Float64, up: float | Float64) -> tuple[Bool, Bool]:
    """Marks the forms that lie in a half line of a sum wholly, and those that do in part, [n] each. `last`: the largest
    float in it, `up`: no less than its end; of each form, [n], or of all.
    """
    met, whole = ~(of.low > last), of.high <= up
    return met & whole, met & ~whole


class FormCut(NamedTuple):
    """An inequality as a cut of forms: `weights` as of `sums`; `last` and `up` as of `sides`."""

    weights: Float64
    last: float
    up: float

    def within(self, forms: FormList) -> FormList:
        """For each form with a state that may meet the inequality, a form around all such states."""
        of = sums(forms, self.weights)
        whole, crossing = sides(of, self.last, self.up)
        if whole.all():
            return forms
        return together([forms.take(whole), narrow_forms(forms.take(crossing), of.take(crossing), self.up)])

    def may_meet(self, forms: FormList) -> Bool:
        """Returns True for each form with a state that may meet the inequality, [n]."""
        return ~(sums(forms, self.weights).low > self.last)


class Moves(NamedTuple):
    """The motion of each form in a step: `matrix` [n, d, d] of floats nearest to exact numbers, each 0 or not below
    LEAST; `shift` [n, d]; an error of at most `error` [n, d], which becomes a column for the variables `kept`.
    """

    matrix: Float64
    shift: Float64
    error: Float64
    kept: Int64

    def of(self, forms: FormList) -> FormList:
        """The forms after a step."""
        count, k, d = forms.columns.shape
        turned = self.matrix.transpose(0, 2, 1)
        size = np.abs(turned)
        middle = np.einsum("nd,nde->ne", forms.middle, turned) + self.shift
        columns = np.zeros((count, k + len(self.kept), d))
        columns[:, :k] = forms.columns @ turned
        columns[:, k + np.arange(len(self.kept)), self.kept] = self.error[:, self.kept]
        lost = self.error.copy()
        lost[:, self.kept] = 0.0
        reach = np.abs(forms.middle) + np.abs(forms.columns).sum(axis=1)
        reach = np.einsum("nd,nde->ne", reach, size) + np.abs(self.shift)
        radius = np.einsum("nd,nde->ne", forms.radius, size) + lost
        rounded = (radius + reach * (d + k + 8) * LOST) * _MORE + _UNDER
        return FormList(middle, columns, np.where(self._rounds, rounded, radius), forms.part, forms.joint)

    @property
    def _rounds(self) -> Bool:
        """Where more happens than that one variable is copied, or one number taken, [n, d]."""
        size = np.abs(self.matrix)
        terms = (size > 0).sum(axis=2)
        copied = (terms == 1) & (size.max(axis=2) == 1) & (self.shift == 0)
        return ~((copied | (terms == 0)) & (self.error == 0))


def with_fewer_columns(forms: FormList, most: int) -> FormList:
    """The forms, with at most so many columns: those that reach least become one for each variable."""
    count, k, d = forms.columns.shape
    if k <= most or not count:
        return forms
    size = np.abs(forms.columns)
    whole = size.sum(axis=1)
    share = (size / np.where(whole > 0, whole, 1.0)[:, None, :]).max(axis=2)
    order = np.argsort(share, axis=1, kind="stable")
    few = order[:, : k - most // 2]
    kept = np.sort(order[:, k - most // 2 :], axis=1)
    rows = np.arange(forms.size)[:, None]
    boxed = size[rows, few].sum(axis=1)
    boxed = boxed * _MORE + boxed * k * LOST
    columns = np.zeros((count, kept.shape[1] + d, d))
    columns[:, : kept.shape[1]] = forms.columns[rows, kept]
    columns[:, kept.shape[1] + np.arange(d), np.arange(d)] = boxed
    return forms._replace(columns=columns)


def weight(exact: Fraction) -> float:
    """The float nearest to a factor. RejectedError where it is too small or large for this arithmetic."""
    factor = 0.0 if not exact else float(exact) if abs(exact.numerator) < abs(exact.denominator) << 900 else np.inf
    if exact and not LEAST <= abs(factor) <= 1 / LEAST:
        raise RejectedError("a number is too small or too large for the arithmetic of forms")
    return factor
