"""One interval Taylor step of many sets at once: what holds all states after it, and all states on the way.

Does: shows that solutions exist and stay in a box (Picard); bounds the Taylor polynomial by its mean value form, and
  what it leaves out over that box; moves boxes and parallelepipeds.
Assumes: series.py's coefficients; rounding to nearest.
Does not: know trees or claims.

A set is given twice. Its states lie in a box; and they lie in frames, c + A z + e with every z_j in [-1, 1] and every
|e_i| at most r_i. A frame keeps how the variables hang together, so that boxes around turned sets do not grow at
every step.

For x in a box X, T_h the Taylor polynomial of order K, and B a box that no solution from X leaves within h seconds,

    x(h) is in T_h(c) + DT_h(X and c) (x - c) + h**K x_K(B) + sum of k < K of h**(k+1) / (k+1) Dx_k(B) W,

where W holds the errors of the derivative, which may be anything measurable: along x' = f + w the k-th derivative g_k
of a solution changes by g_(k+1) + Dg_k w, and each w is under k + 1 integrals. B is such a box if X + [0, h] (f(B) +
W) lies in it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from codegen.ir import Bool, Float64
from verify.checker.covers.rounding import Factor
from verify.checker.flows.series import Coefficient, FlowReading, Known
from verify.checker.flows.spans import (
    Spans,
    common,
    exact,
    finite,
    hull,
    minus,
    plus,
    raised,
    scaled,
    times,
    total,
    within,
)

ROUNDS = 12  # in which a box is made wider until it holds the image of itself
WIDER = 0.1  # of its width, by which it is made wider
EPSILON = 2.0**-52
EXACT = (Fraction(0), Fraction(0))


class Frame(NamedTuple):
    """The states c + A z + e: `centre` [n, d], `matrix` [n, d, d], `rest` [n, d], none of it below 0."""

    centre: Float64
    matrix: Float64
    rest: Float64

    def at(self, which: Bool | np.ndarray) -> Frame:
        """Some of them."""
        return Frame(self.centre[which], self.matrix[which], self.rest[which])

    @property
    def box(self) -> Spans:
        """Boxes around them."""
        reach = raised(np.abs(self.matrix).sum(axis=2) + self.rest)
        return Spans(np.nextafter(self.centre - reach, -np.inf), np.nextafter(self.centre + reach, np.inf))


def framed(box: Spans) -> Frame:
    """Boxes as frames."""
    middle, size = box.middle, box.low.shape[1]
    matrix = box.around(middle)[:, :, None] * np.eye(size)
    return Frame(middle, matrix, np.zeros_like(middle))


class Moved(NamedTuple):
    """What a step makes of sets: boxes and frames after it, a box of all states on the way, where all was shown, and
    where frames have nothing in common, so that there was no state.
    """

    box: Spans
    frames: tuple[Frame, ...]
    tube: Spans
    shown: Bool
    empty: Bool


@dataclass(frozen=True)
class Stepping:
    """How to step: the order K of the series, and the seconds h of a step."""

    order: int
    seconds: Fraction


class FlowStep:
    """Steps of one flow. `errors`: of the derivative of each variable."""

    def __init__(self, reading: FlowReading, errors: Sequence[tuple[Fraction, Fraction]], how: Stepping) -> None:
        self._reading, self._how, self._errors = reading, how, errors
        self._off = any(each != EXACT for each in errors)
        self._powers = [Factor(how.seconds**k) for k in range(how.order + 1)]

    def moved(self, box: Spans, frames: tuple[Frame, ...], held: Mapping[str, Spans]) -> Moved:
        """The sets a step later; `held`: the inputs of each, [n]."""
        stay, shown = self._stay(box, held)
        left_out = self._left_out(stay, held)
        centres = [frame.centre for frame in frames]
        around = box
        for centre in centres:
            around = hull(around, Spans(centre, centre))
        slopes = self._slopes(around, held)
        found: list[Frame] = []
        after: Spans | None = None
        for frame, polynomial in zip(frames, self._polynomials(centres, held), strict=True):
            moved = _framed(frame, box, plus(polynomial, left_out), slopes)
            found.append(moved)
            after = moved.box if after is None else common(after, moved.box)
        assert after is not None
        shown &= np.asarray(finite(after).all(axis=1)) & np.asarray(finite(stay).all(axis=1))
        return Moved(after, tuple(found), stay, shown, np.asarray((after.low > after.high).any(axis=1)))

    # --- all states on the way

    def _stay(self, box: Spans, held: Mapping[str, Spans]) -> tuple[Spans, Bool]:
        """Boxes that no solution leaves, and where that was shown: a box holds its own image under Picard's map, and so
        the image holds the solutions too.
        """
        guess = _wider(self._along(box, box, held), WIDER)
        found, shown = guess, np.zeros(len(box.low), dtype=np.bool_)
        for _ in range(ROUNDS):
            image = self._along(box, guess, held)
            held_in = within(image, guess) & finite(guess)
            inside = np.asarray(held_in.all(axis=1)) & ~shown
            found = Spans(*(np.where(inside[:, None], new, old) for new, old in zip(image, found, strict=True)))
            shown |= inside
            if shown.all():
                break
            grown = _wider(hull(image, guess), WIDER)  # but not where it holds the image: the others would run after it
            guess = Spans(*(np.where(held_in, old, new) for old, new in zip(guess, grown, strict=True)))
        return found, shown

    def _along(self, box: Spans, stay: Spans, held: Mapping[str, Spans]) -> Spans:
        """X + [0, h] (f(B) + W)."""
        rates = _columns([each[1] for each in self._reading.series(stay, held, 1, sloped=False)], len(box.low))
        moved = scaled(plus(rates, self._errors_of(len(box.low))), self._powers[1])
        return plus(box, Spans(np.minimum(moved.low, 0.0), np.maximum(moved.high, 0.0)))

    def _errors_of(self, count: int) -> Spans:
        ends = [(exact(low, count).low, exact(high, count).high) for low, high in self._errors]
        return Spans(np.stack([low for low, _ in ends], axis=1), np.stack([high for _, high in ends], axis=1))

    # --- the series

    def _polynomials(self, points: Sequence[Float64], held: Mapping[str, Spans]) -> list[Spans]:
        """T_h of points, [n, d] of each list."""
        count, times_held = len(points[0]), {name: _repeated(span, len(points)) for name, span in held.items()}
        start = np.concatenate(points)
        found = self._reading.series(Spans(start, start), times_held, self._how.order - 1, sloped=False)
        landed = _columns([self._summed(each) for each in found], len(start))
        return [landed.at(slice(place, place + count)) for place in range(0, len(start), count)]

    def _summed(self, coefficients: Sequence[Known]) -> Known:
        value: Spans | None = None
        for k in reversed(range(self._how.order)):
            each = coefficients[k]
            if each is not None:
                term = each.value if not k else scaled(each.value, self._powers[k])
                value = term if value is None else plus(value, term)
        return None if value is None else Coefficient(value, None)

    def _slopes(self, start: Spans, held: Mapping[str, Spans]) -> Spans:
        """DT_h over boxes, [n, d, d]."""
        count, size = start.low.shape
        found = self._reading.series(start, held, self._how.order - 1, sloped=True)
        rows: list[Spans] = []
        for coefficients in found:
            row = Spans(np.zeros((count, size)), np.zeros((count, size)))
            for k in reversed(range(self._how.order)):
                each = coefficients[k]
                if each is not None and each.slope is not None:
                    row = plus(row, each.slope if not k else scaled(each.slope, self._powers[k]))
            rows.append(row)
        return Spans(np.stack([row.low for row in rows], axis=1), np.stack([row.high for row in rows], axis=1))

    def _left_out(self, stay: Spans, held: Mapping[str, Spans]) -> Spans:
        """What the polynomial leaves out, and what errors of the derivative add."""
        order, count = self._how.order, len(stay.low)
        found = self._reading.series(stay, held, order, sloped=self._off)
        last = scaled(_columns([each[order] for each in found], count), self._powers[order])
        if not self._off:
            return last
        errors = self._errors_of(count)
        for k in range(order):
            factor = Factor(self._how.seconds ** (k + 1) / (k + 1))
            columns: list[Spans] = []
            for coefficients in found:
                each = coefficients[k]
                none = Spans(np.zeros(count), np.zeros(count))
                columns.append(none if each is None or each.slope is None else total(times(each.slope, errors)))
            last = plus(last, scaled(_stacked(columns), factor))
        return last


def _framed(frame: Frame, box: Spans, landed: Spans, slopes: Spans) -> Frame:
    """A frame after a step. `landed`: where its centre lands, with all that is left out; `slopes`: [n, d, d]."""
    centre = landed.middle
    about = slopes.middle
    off = slopes.around(about)
    reach = common(minus(frame.box, Spans(frame.centre, frame.centre)), minus(box, Spans(frame.centre, frame.centre)))
    size = box.low.shape[1]
    matrix = np.matmul(about, frame.matrix)
    lost = (size + 2) * EPSILON * np.matmul(np.abs(about), np.abs(frame.matrix)).sum(axis=2)
    rest = landed.around(centre) + raised(lost)
    rest = rest + raised(_applied(np.abs(about), frame.rest)) + raised(_applied(off, np.maximum(reach.largest, 0.0)))
    return Frame(centre, matrix, raised(rest))


def _repeated(span: Spans, times_over: int) -> Spans:
    return Spans(np.tile(span.low, times_over), np.tile(span.high, times_over))


def _applied(matrix: Float64, vector: Float64) -> Float64:
    return np.asarray(np.matmul(matrix, vector[:, :, None])[:, :, 0])


def _wider(box: Spans, share: float) -> Spans:
    by = share * (box.high - box.low) + 2.0**-40 * box.largest + 2.0**-200
    return Spans(box.low - by, box.high + by)


def _columns(coefficients: Sequence[Known], count: int) -> Spans:
    nothing = Spans(np.zeros(count), np.zeros(count))
    return _stacked([nothing if each is None else each.value for each in coefficients])


def _stacked(columns: Sequence[Spans]) -> Spans:
    return Spans(np.stack([each.low for each in columns], axis=1), np.stack([each.high for each in columns], axis=1))
