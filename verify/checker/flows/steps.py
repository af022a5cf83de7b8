"""Sets that a flow moves, and one interval Taylor step of many at once: what holds all states after and during it.

Does: shows that solutions exist and stay in a box (Picard); bounds the Taylor polynomial by its mean value form, and
  what it leaves out over that box; moves boxes and parallelepipeds; narrows lists of these to boxes within them, and
  joins them in cells.
Assumes: series.py's coefficients; rounding to nearest.
Does not: know trees or claims.

A set is given twice. Its states lie in a box; and they lie in frames, c + A z + B r with every z_j in [-1, 1] and
every |r_i| at most R_i. A frame keeps how the variables hang together, so that boxes around turned sets do not grow
at every step. B r is all that A z left out so far; B is nearly orthogonal and turns with the flow, so that this does
not grow by turning either (Lohner).

For x in a box X, T_h the Taylor polynomial of order K, and B a box that no solution from X leaves within h seconds,

    x(h) is in T_h(c) + DT_h(X and c) (x - c) + h**K x_K(B) + sum of k < K of h**(k+1) / (k+1) Dx_k(B) W,

where W holds the errors of the derivative, which may be anything measurable: along x' = f + w the k-th derivative g_k
of a solution changes by g_(k+1) + Dg_k w, and each w is under k + 1 integrals. B is such a box if X + [0, h] (f(B) +
W) lies in it.

On the way, x(t) is no further from (1 - t / h) x(0) + t / h x(h) than the integrals of f and of w are from the lines
between their ends. The derivative of f along a solution is g = 2 x_2(B) + Dx_1(B) W almost everywhere, so the first is
off by - t (h - t) / 2 g, which is in - [0, h**2 / 8] g; the second by at most t (h - t) / h, or h / 4, times the width
of W.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from fractions import Fraction
from math import isqrt
from typing import NamedTuple

import numpy as np

from codegen.ir import Bool, Float64, Int64
from verify.checker.covers.boxes import BoxList, in_cells
from verify.checker.covers.rounding import Factor, ceiling, floor
from verify.checker.flows.intervals import (
    LEAST,
    Program,
    Spans,
    common,
    finite,
    hull,
    minus,
    plus,
    round_up,
    scale_spans,
    within,
)
from verify.checker.flows.series import AROUND, ON_THE_WAY, FlowReading, Stepping, StepPrograms, centre_of, error_name

ROUNDS = 12  # in which a box is made wider until it holds the image of itself
WIDER = 0.1  # of its width, by which it is made wider
EPSILON = 2.0**-52
EXACT = (Fraction(0), Fraction(0))


class Frame(NamedTuple):
    """The states c + A z + B r: `centre` [n, d], `matrix` [n, d, d], `rest` [n, d], none of it below 0, the bounds of
    r; `turned` [n, d, d].
    """

    centre: Float64
    matrix: Float64
    rest: Float64
    turned: Float64

    def at(self, which: Bool | np.ndarray) -> Frame:
        """Some of them."""
        return Frame(*(each[which] for each in self))

    @property
    def loose(self) -> Float64:
        """Bounds of B r, [n, d]."""
        return round_up(_apply_matrix(np.abs(self.turned), self.rest))

    @property
    def box(self) -> Spans:
        """Boxes around them."""
        reach = round_up(np.abs(self.matrix).sum(axis=2) + self.loose)
        return Spans(np.nextafter(self.centre - reach, -np.inf), np.nextafter(self.centre + reach, np.inf))


def build_frames(box: Spans) -> Frame:
    """Boxes as frames."""
    middle, size = box.middle, box.low.shape[1]
    straight = np.broadcast_to(np.eye(size), (len(middle), size, size))
    return Frame(middle, box.around(middle)[:, :, None] * straight, np.zeros_like(middle), straight)


class Moved(NamedTuple):
    """The results of a step of sets: boxes and frames after it, a box of all states on the way, where all was shown,
    and where frames have nothing in common, so that there was no state.
    """

    box: Spans
    frames: tuple[Frame, ...]
    tube: Spans
    shown: Bool
    empty: Bool


class FlowStep:
    """Steps of one flow. `errors`: of the derivative of each variable."""

    def __init__(self, reading: FlowReading, errors: Sequence[tuple[Fraction, Fraction]], how: Stepping) -> None:
        self._names = reading.names
        self._power, self._quarter = Factor(how.seconds), Factor(how.seconds / 4)
        self._eighth = Factor(-(how.seconds**2) / 8)
        self._bounds = _ends_of(errors)
        off = [name for name, each in zip(reading.names, errors, strict=False) if each != EXACT]
        self._programs = StepPrograms(reading, how, off)

    def with_errors(self, errors: Sequence[tuple[Fraction, Fraction]]) -> FlowStep:
        """The same with other errors, which lie within those of this one."""
        other = copy(self)
        other._bounds = _ends_of(errors)
        return other

    def move_sets(self, box: Spans, frames: tuple[Frame, ...], held: Mapping[str, Spans]) -> Moved:
        """The sets a step later; `held`: the inputs of each, [n]."""
        stay, shown = self._stay(box, held)
        polynomials, slopes, left_out, bends = self._sum_series(box, frames, stay, held)
        moved_frames: list[Frame] = []
        after = common(stay, plus(box, self._moves(stay, held)))  # by the mean of each derivative on the way
        for frame, polynomial in zip(frames, polynomials, strict=True):
            moved = _move_frame(frame, box, plus(polynomial, left_out), slopes)
            moved_frames.append(moved)
            after = common(after, moved.box)
        shown &= np.asarray(finite(after).all(axis=1)) & np.asarray(finite(stay).all(axis=1))
        # Solutions are no further from the line between their ends than -[0, h**2 / 8] f' + [-h / 4, h / 4] |W|.
        bent, errors = scale_spans(bends, self._eighth), self._errors_of(len(bends.low))
        bent = Spans(np.minimum(bent.low, 0.0), np.maximum(bent.high, 0.0))
        bulge = plus(bent, scale_spans(minus(errors, errors), self._quarter))
        tube = common(stay, plus(hull(box, after), bulge))
        tube = Spans(*(np.where(finite(tube), new, old) for old, new in zip(stay, tube, strict=True)))
        return Moved(after, tuple(moved_frames), tube, shown, np.asarray((after.low > after.high).any(axis=1)))

    def jump_sets(self, box: Spans, frames: tuple[Frame, ...], held: Mapping[str, Spans]) -> Moved:
        """The sets after a jump to the values that the reading gives, by their mean value form too."""
        image = self._run(self._programs.rates, box, held)
        slopes = _as_matrices(self._run(self._programs.rate_slopes, _around(box, frames), held))
        after, carried = image, list[Frame]()
        rates = image  # of all centres, in one run
        if frames:
            tiled = {name: Spans(*(np.tile(end, len(frames)) for end in span)) for name, span in held.items()}
            centres = np.concatenate([frame.centre for frame in frames])
            rates = self._run(self._programs.rates, Spans(centres, centres), tiled)
        for number, frame in enumerate(frames):
            landed = rates.at(slice(number * len(frame.centre), (number + 1) * len(frame.centre)))
            carried.append(_move_frame(frame, box, landed, slopes))
            after = common(after, carried[-1].box)
        shown = np.asarray(finite(after).all(axis=1)) & np.asarray(finite(image).all(axis=1))
        return Moved(after, tuple(carried), image, shown, np.asarray((after.low > after.high).any(axis=1)))

    # --- all states on the way

    def _stay(self, box: Spans, held: Mapping[str, Spans]) -> tuple[Spans, Bool]:
        """Boxes that no solution leaves, and where that was shown: a box holds its own image under Picard's map, and so
        the image holds the solutions too.
        """
        first = self._along(box, box, held)
        wider = _wider(first, WIDER)  # but not where nothing moves, so that bounds which are met exactly stay so
        guess = Spans(*(np.where(within(first, box), old, new) for old, new in zip(box, wider, strict=True)))
        stay, shown = guess, np.zeros(len(box.low), dtype=np.bool_)
        for _ in range(ROUNDS):
            image = self._along(box, guess, held)
            held_in = within(image, guess) & finite(guess)
            inside = np.asarray(held_in.all(axis=1)) & ~shown
            stay = Spans(*(np.where(inside[:, None], new, old) for new, old in zip(image, stay, strict=True)))
            shown |= inside
            if shown.all():
                break
            grown = _wider(hull(image, guess), WIDER)  # but not where it holds the image: the others would run after it
            guess = Spans(*(np.where(held_in, old, new) for old, new in zip(guess, grown, strict=True)))
        return stay, shown

    def _along(self, box: Spans, stay: Spans, held: Mapping[str, Spans]) -> Spans:
        """X + [0, h] (f(B) + W)."""
        moved = self._moves(stay, held)
        return plus(box, Spans(np.minimum(moved.low, 0.0), np.maximum(moved.high, 0.0)))

    def _moves(self, stay: Spans, held: Mapping[str, Spans]) -> Spans:
        """h (f(B) + W)."""
        rates = self._run(self._programs.rates, stay, held)
        return scale_spans(plus(rates, self._errors_of(len(stay.low))), self._power)

    def _errors_of(self, count: int) -> Spans:
        return Spans(*(np.broadcast_to(each, (count, len(each))) for each in self._bounds))

    # --- the series

    def _sum_series(
        self, box: Spans, frames: Sequence[Frame], stay: Spans, held: Mapping[str, Spans]
    ) -> tuple[list[Spans], Spans, Spans, Spans]:
        """T_h of the centres, [n, d] of each frame; DT_h over boxes around them, [n, d, d]; what T_h leaves out and
        errors add, [n, d]; f's derivative along solutions, [n, d].
        """
        given, size = dict(held), len(self._names)
        for number, frame in enumerate(frames):
            given |= self._name_columns(centre_of(number), Spans(frame.centre, frame.centre))
        given |= self._name_columns(AROUND, _around(box, frames)) | self._name_columns(ON_THE_WAY, stay)
        errors = self._errors_of(len(stay.low))
        given |= {error_name(name): errors.at((slice(None), column)) for column, name in enumerate(self._names)}
        results = self._programs.step(len(frames)).run(given, len(stay.low))
        rows = Spans(np.ascontiguousarray(results.low.T), np.ascontiguousarray(results.high.T))
        parts = [rows.at((slice(None), slice(place, place + size))) for place in range(0, len(frames) * size, size)]
        matrices = _as_matrices(rows.at((slice(None), slice(len(frames) * size, -2 * size))))
        left_out, bends = (rows.at((slice(None), slice(*ends))) for ends in ((-2 * size, -size), (-size, None)))
        return parts, matrices, left_out, bends

    def _name_columns(self, mark: str, boxes: Spans) -> dict[str, Spans]:
        return {mark + name: boxes.at((slice(None), column)) for column, name in enumerate(self._names)}

    def _run(self, program: Program, start: Spans, held: Mapping[str, Spans]) -> Spans:
        """Runs a program on boxes [n, d], by rows: [n, results]."""
        results = program.run({**self._name_columns("", start), **held}, len(start.low))
        return Spans(np.ascontiguousarray(results.low.T), np.ascontiguousarray(results.high.T))


def _ends_of(errors: Sequence[tuple[Fraction, Fraction]]) -> tuple[Float64, Float64]:
    return np.array([floor(low) for low, _ in errors]), np.array([ceiling(high) for _, high in errors])


def _around(box: Spans, frames: Sequence[Frame]) -> Spans:
    """Boxes around boxes and the centres of frames."""
    for frame in frames:
        box = hull(box, Spans(frame.centre, frame.centre))
    return box


def _as_matrices(rows: Spans) -> Spans:
    size = isqrt(rows.low.shape[1])
    return Spans(rows.low.reshape(-1, size, size), rows.high.reshape(-1, size, size))


def _move_frame(frame: Frame, box: Spans, landed: Spans, slopes: Spans) -> Frame:
    """A frame after a step. `landed`: where its centre lands, with all that is left out; `slopes`: [n, d, d]."""
    centre = landed.middle
    about = slopes.middle
    off = slopes.around(about)
    reach = common(minus(frame.box, Spans(frame.centre, frame.centre)), minus(box, Spans(frame.centre, frame.centre)))
    matrix, lost = _multiply_matrices(about, frame.matrix)
    moved, lost_too = _multiply_matrices(about, frame.turned)
    more = landed.around(centre) + round_up(lost.sum(axis=2)) + round_up(_apply_matrix(lost_too, frame.rest))
    more = round_up(more + round_up(_apply_matrix(off, np.maximum(reach.largest, 0.0))))
    turned, rest = orthogonalise_rest(moved, frame.rest, more)
    return Frame(centre, matrix, rest, turned)


def orthogonalise_rest(matrix: Float64, rest: Float64, more: Float64) -> tuple[Float64, Float64]:
    """M r + m, where |r_i| and |m_i| have the bounds `rest` and `more`, as Q s: Q and the bounds of s.

    Q Q' = I + E, where row sums of |E| are at most some e. If e < 1/4, Q has the inverse Q' (I + E)**-1, and
    |(I + E)**-1 x - x| is at most 2 e times the largest |x_i|. Any Q will do; this one is from a QR decomposition.
    """
    size = matrix.shape[1]
    straight = np.broadcast_to(np.eye(size), matrix.shape)
    sides = matrix * rest[:, None, :]
    order = np.argsort(-np.abs(sides).sum(axis=1), axis=1, kind="stable")
    sides = np.take_along_axis(sides, order[:, None, :], axis=2)
    scale = np.abs(sides).max(axis=(1, 2), keepdims=True)
    usable = np.isfinite(scale) & (scale > LEAST)
    if not usable.any():
        return straight, round_up(_apply_matrix(np.abs(matrix), rest) + more)
    basis = np.linalg.qr(np.where(usable, sides / np.where(usable, scale, 1.0), straight))[0]
    square, lost = _multiply_matrices(basis, basis.transpose(0, 2, 1))
    off = round_up((np.abs(square - straight) + lost + EPSILON).sum(axis=2)).max(axis=1)
    good = np.isfinite(off) & (off < 0.25)
    basis = np.where(good[:, None, None], basis, straight)
    off = np.where(good, off, 0.0)
    across = basis.transpose(0, 2, 1)
    seen, lost = _multiply_matrices(across, matrix)
    largest = round_up(_apply_matrix(np.abs(matrix), rest) + more).max(axis=1)
    far = more + (2.0 * off * largest)[:, None]
    return basis, round_up(_apply_matrix(np.abs(seen) + lost, rest) + _apply_matrix(np.abs(across), far))


def _multiply_matrices(one: Float64, other: Float64) -> tuple[Float64, Float64]:
    """Products of matrices, and bounds of what their elements are off by."""
    lost = (one.shape[1] + 2) * EPSILON * np.matmul(np.abs(one), np.abs(other))
    return np.matmul(one, other), lost + LEAST


def _apply_matrix(matrix: Float64, vector: Float64) -> Float64:
    return np.asarray(np.matmul(matrix, vector[:, :, None])[:, :, 0])


def _wider(box: Spans, share: float) -> Spans:
    by = share * (box.high - box.low) + 2.0**-40 * box.largest + 2.0**-200
    return Spans(box.low - by, box.high + by)


class SetList(NamedTuple):
    """Sets: `box` [n, variables]; `frames` that hold them too; `part` [n], of the start that each comes from; `joint`
    [n], the number of the joint action that is held.
    """

    box: Spans
    frames: tuple[Frame, ...]
    part: Int64
    joint: Int64

    @property
    def size(self) -> int:
        """The number of sets."""
        return len(self.part)

    def take(self, which: Bool | Int64) -> SetList:
        """Some of them."""
        frames = tuple(frame.at(which) for frame in self.frames)
        return SetList(self.box.at(which), frames, self.part[which], self.joint[which])

    @property
    def numbered(self) -> BoxList:
        """The boxes, each with the number of its set for a part."""
        return BoxList.of(self.box.low, self.box.high, np.arange(self.size), self.joint)

    def narrow_to(self, boxes: BoxList) -> SetList:
        """The sets in which boxes lie that were cut from `numbered`, narrowed to these."""
        sources = self.take(boxes.part)
        box = Spans(boxes.low, boxes.high)
        cut = np.asarray(((box.low > sources.box.low) | (box.high < sources.box.high)).any(axis=1))
        frames = tuple(_cut(frame, box, cut) for frame in sources.frames)
        return SetList(box, frames, sources.part, boxes.joint)

    def join_by_cell(self, widths: Mapping[int, float]) -> SetList:
        """Boxes around the sets, one for each cell and part of the start that has some."""
        boxes = in_cells(BoxList.of(self.box.low, self.box.high, self.part, self.joint), widths)
        return build_sets(boxes, 0)


def build_sets(boxes: BoxList, kept: int) -> SetList:
    """Boxes as sets, with `kept` frames."""
    box = Spans(boxes.low, boxes.high)
    return SetList(box, tuple(build_frames(box) for _ in range(kept)), boxes.part, boxes.joint)


def beside(lists: Sequence[SetList]) -> SetList:
    """The sets of some lists in one."""
    if len(lists) == 1:
        return lists[0]
    box = Spans(*(np.concatenate(ends) for ends in zip(*(each.box for each in lists), strict=True)))
    frames = tuple(
        Frame(*map(np.concatenate, zip(*of, strict=True))) for of in zip(*(e.frames for e in lists), strict=True)
    )
    part, joint = (np.concatenate([each[at] for each in lists]) for at in (2, 3))
    return SetList(box, frames, part, joint)


def _cut(frame: Frame, box: Spans, cut: Bool) -> Frame:
    """The frames without those z whose states lie outside the boxes; `cut`: where boxes are less than before.

    Of row i, A_ij z_j = x_i - c_i - (all other terms) - (B r)_i, whose bounds give bounds of z_j.
    """
    if not cut.any():
        return frame
    centre, matrix = frame.centre.copy(), frame.matrix.copy()
    of, size = np.flatnonzero(cut), centre.shape[1]
    c, a, rest = centre[of], matrix[of], frame.loose[of]
    low, high = -np.ones((len(of), size)), np.ones((len(of), size))
    for row in range(size):
        down, up = _beside(box.low[of, row] - c[:, row], -1.0), _beside(box.high[of, row] - c[:, row], 1.0)
        for column in range(size):
            factor = a[:, row, column]
            others = round_up(np.abs(np.delete(a[:, row], column, axis=1)).sum(axis=1) + rest[:, row])
            least, most = _beside(down - others, -1.0), _beside(up + others, 1.0)
            with np.errstate(all="ignore"):
                ends = least / factor, most / factor
            known = np.abs(factor) > 1e-200
            least, most = _beside(np.minimum(*ends), -1.0), _beside(np.maximum(*ends), 1.0)
            low[:, column] = np.where(known, np.maximum(low[:, column], least), low[:, column])
            high[:, column] = np.where(known, np.minimum(high[:, column], most), high[:, column])
    high = np.maximum(low, high)  # what is empty may be any one point
    return _rescale_frame(frame, of, low, high)


def _beside(values: Float64, way: float) -> Float64:
    """A little further: more than a sum or a quotient of two floats is off by."""
    return values + way * (2.0**-50 * np.abs(values) + 2.0**-1000)


def _rescale_frame(frame: Frame, of: Int64, low: Float64, high: Float64) -> Frame:
    """Frames with z in [low, high], as frames with z in [-1, 1]."""
    middle = 0.5 * low + 0.5 * high
    radius = np.maximum(high - middle, middle - low) * (1.0 + 2.0**-50)
    centre, matrix, rest, turned = (each.copy() for each in frame)
    moved, size = _apply_matrix(matrix[of], middle), centre.shape[1]
    off = _apply_matrix(np.abs(matrix[of]), np.abs(middle) + radius) + np.abs(centre[of]) + np.abs(moved)
    centre[of] += moved
    matrix[of] *= radius[:, None, :]
    turned[of], rest[of] = orthogonalise_rest(turned[of], rest[of], round_up((size + 4) * 2.0**-52 * off))
    return Frame(centre, matrix, rest, turned)
