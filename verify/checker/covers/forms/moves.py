"""Affine forms moved one step, by the piece that their states lie in and the joint action that is chosen.

Does: finds the pieces that a form meets. Where there are several, one piece moves all of it, with an error that has
  room for what the others do, unless that error is large: then the form is cut at the bounds of their boxes.
Assumes: a system that is well formed; forms of which no state lies outside all pieces.
Does not: know trees or claims.

Were a form always cut, a curved rule that is enclosed by many pieces would leave ever more slivers at their borders.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from codegen.ir import AgentPolicy, Bool, Float64, Int64
from verify.checker.covers.cuts import linear
from verify.checker.covers.forms.arrays import LOST, FormList, Moves, narrow_forms, sides, sums, together, weight
from verify.checker.covers.forms.cuts import half as cut_of
from verify.checker.covers.rounding import ceiling, floor
from verify.checker.reading import RejectedError
from verify.systems.system import Affine, System

ZERO = (Fraction(0), Fraction(0))
JOINED = 2.0  # times the error of a piece alone: so large may one be that has room for others
MAX_COMPARED = 1 << 25  # bounds of pieces that are compared with bounds of forms at once


class _Known(NamedTuple):
    """The effect of a piece and a joint action: factors [d, d], and bounds of constants and errors, [d] each."""

    matrix: Float64
    low: Float64
    high: Float64


class _Pairs(NamedTuple):
    """A form and a piece that it meets, by their places; `first`: the piece that is to move it."""

    form: Int64
    piece: Int64
    first: Int64


class FormPieces:
    """All pieces. `actions`: how many each agent has."""

    def __init__(self, system: System, policies: Sequence[AgentPolicy]) -> None:
        self._names = [one.name for one in system.variables]
        self._columns = {name: column for column, name in enumerate(self._names)}
        self._pieces, self._policies = system.pieces, policies
        self._ends = np.array([[self._end(piece.where.get(name)) for name in self._names] for piece in system.pieces])
        self._cut = [self._columns[name] for name in self._names if any(name in each.where for each in system.pieces)]
        self._when = [[cut_of(linear(half), self._columns) for half in piece.when] for piece in system.pieces]
        self._kept = np.array([self._columns[name] for name in self._names if self._errs(name)], dtype=np.int64)
        self._places: dict[tuple[int, int], int] = {}
        self._known: list[_Known] = []
        self._table = _Known(*(np.zeros(0),) * 3)

    def _end(self, bounds: tuple[Fraction, Fraction] | None) -> tuple[float, float]:
        return (-np.inf, np.inf) if bounds is None else (floor(bounds[0]), ceiling(bounds[1]))

    def _errs(self, name: str) -> bool:
        """Returns True if a piece has an error for a variable, or does otherwise than another piece."""
        forms = {piece.move.get(name, Affine()) for piece in self._pieces}
        return len(forms) > 1 or any(piece.error.get(name, ZERO) != ZERO for piece in self._pieces)

    def move_forms(self, forms: FormList) -> FormList:
        """Forms around all next states."""
        low, high = forms.bounds()
        pairs = self._find_pairs(forms, low, high)
        moves = self._of(forms.joint[pairs.form], pairs.first)
        one = np.bincount(pairs.form, minlength=forms.size)[pairs.form] == 1
        alone = Moves(moves.matrix[one], *_with_error(moves.low[one], moves.high[one]), self._kept)
        images = [alone.of(forms.take(pairs.form[one]))]
        if not one.all():
            images += self._across(forms, _Pairs(*(each[~one] for each in pairs)), low, high)
        return together(images)

    def _across(self, forms: FormList, pairs: _Pairs, low: Float64, high: Float64) -> list[FormList]:
        """After a step, the forms that meet several pieces, each with a row for every such piece in `pairs`."""
        least, most = self._room(forms.joint[pairs.form], pairs, low, high)
        rows, begins, back = np.unique(pairs.form, return_index=True, return_inverse=True)
        first = self._of(forms.joint[rows], pairs.first[begins])
        least, most = np.minimum.reduceat(least, begins), np.maximum.reduceat(most, begins)
        shift, error = _with_error(least, most)
        own = first.high - first.low
        fits = 2.0 * error <= JOINED * own + LOST * np.abs(shift)
        small = np.asarray(fits.all(axis=1), dtype=np.bool_)
        joined = Moves(first.matrix[small], shift[small], error[small], self._kept).of(forms.take(rows[small]))
        cut = ~small[back.reshape(-1)]
        return [joined, self._cut_and_moved(forms.take(pairs.form[cut]), pairs.piece[cut])]

    def _cut_and_moved(self, forms: FormList, piece: Int64) -> FormList:
        """After a step, forms cut by the box of a piece each."""
        for column in self._cut:
            for side, sign in ((1, 1.0), (0, -1.0)):
                weights = np.zeros(len(self._names))
                weights[column] = sign
                of, end = sums(forms, weights), sign * self._ends[piece, column, side]
                whole, crossing = sides(of, end, end)
                if not whole.all():
                    kept = [forms.take(whole), narrow_forms(forms.take(crossing), of.take(crossing), end[crossing])]
                    forms, piece = together(kept), np.concatenate([piece[whole], piece[crossing]])
        for number, cuts in enumerate(self._when):
            if cuts and (piece == number).any():
                met, others = forms.take(piece == number), piece != number
                for cut in cuts:
                    met = cut.within(met)
                forms = together([forms.take(others), met])
                piece = np.concatenate([piece[others], np.full(met.size, number)])
        moves = self._of(forms.joint, piece)
        return Moves(moves.matrix, *_with_error(moves.low, moves.high), self._kept).of(forms)

    def _find_pairs(self, forms: FormList, low: Float64, high: Float64) -> _Pairs:
        """All forms with the pieces that they meet, form by form; first the piece that holds its middle."""
        count = len(self._ends)
        at_once = max(MAX_COMPARED // (count * max(len(self._cut), 1)), 1)
        pairs: list[_Pairs] = []
        for begin in range(0, forms.size, at_once):
            some = slice(begin, begin + at_once)
            met = self._meets(low[some], high[some])
            for number, cuts in enumerate(self._when):
                for cut in cuts if met[:, number].any() else ():
                    met[:, number] &= cut.may_meet(forms.take(np.arange(forms.size)[some]))
            if not met.any(axis=1).all():
                raise RejectedError("a form meets no piece")
            middle = met & self._meets(forms.middle[some], forms.middle[some])
            first = np.asarray(np.where(middle.any(axis=1), middle.argmax(axis=1), met.argmax(axis=1)), dtype=np.int64)
            form, piece = np.nonzero(met)
            pairs.append(_Pairs(form + begin, piece, first[form]))
        if not pairs:
            none = np.zeros(0, dtype=np.int64)
            return _Pairs(none, none, none)
        return pairs[0] if len(pairs) == 1 else _Pairs(*map(np.concatenate, zip(*pairs, strict=True)))

    def _meets(self, low: Float64, high: Float64) -> Bool:
        met = np.ones((len(low), len(self._ends)), dtype=np.bool_)
        for column in self._cut:
            met &= ~(high[:, column, None] < self._ends[:, column, 0])
            met &= ~(low[:, column, None] > self._ends[:, column, 1])
        return met

    def _room(self, joint: Int64, pairs: _Pairs, low: Float64, high: Float64) -> tuple[Float64, Float64]:
        """Bounds of what is to be added to the factors of the first piece, that each other piece may do its own."""
        first, other = self._of(joint, pairs.first), self._of(joint, pairs.piece)
        least = np.maximum(low[pairs.form], self._ends[pairs.piece, :, 0])
        most = np.maximum(np.minimum(high[pairs.form], self._ends[pairs.piece, :, 1]), least)
        middle, half = 0.5 * least + 0.5 * most, 0.5 * (most - least)
        off = other.matrix - first.matrix
        value = np.einsum("nij,nj->ni", off, middle)
        reach = np.einsum("nij,nj->ni", np.abs(off), half)
        size = np.abs(other.matrix) + np.abs(first.matrix)
        reach += np.einsum("nij,nj->ni", size, np.abs(middle) + half) * (len(self._names) + 8) * LOST
        reach += (np.abs(value) + np.abs(other.low) + np.abs(other.high)) * 8 * LOST
        return other.low + value - reach, other.high + value + reach

    def _of(self, joint: Int64, piece: Int64) -> _Known:
        """Returns the effects of pieces and joint actions, one row for each."""
        keys, back = np.unique(np.stack([piece, joint]), axis=1, return_inverse=True)
        places = np.array([self._place(*map(int, key)) for key in keys.T], dtype=np.int64)
        if len(self._table.low) < len(self._known):
            self._table = _Known(*(np.array(each) for each in zip(*self._known, strict=True)))
        of = places[back.reshape(-1)]
        size = len(self._names)
        return (
            _Known(*(each[of] for each in self._table))
            if len(of)
            else _Known(np.zeros((0, size, size)), np.zeros((0, size)), np.zeros((0, size)))
        )

    def _place(self, piece: int, joint: int) -> int:
        if (piece, joint) not in self._places:
            size = len(self._names)
            matrix, low, high = np.zeros((size, size)), np.zeros(size), np.zeros(size)
            for row, name in enumerate(self._names):
                form, error = self._total(piece, name, joint), self._pieces[piece].error.get(name, ZERO)
                for read, factor in form.terms:
                    matrix[row, self._columns[read]] = weight(factor)
                low[row], high[row] = floor(form.constant + error[0]), ceiling(form.constant + error[1])
            self._places[piece, joint] = len(self._known)
            self._known.append(_Known(matrix, low, high))
        return self._places[piece, joint]

    def _total(self, piece: int, name: str, joint: int) -> Affine:
        """The next value of a variable as one exact form, without the error."""
        stated = self._pieces[piece]
        form = stated.move.get(name, Affine())
        for policy in reversed(self._policies):
            joint, action = divmod(joint, len(policy.actions))
            choice = policy.agent, policy.actions[action].name
            form = form.plus(stated.effect.get(choice, {}).get(name, Affine()))
        return form


def _with_error(low: Float64, high: Float64) -> tuple[Float64, Float64]:
    """Numbers and errors that hold all between two bounds."""
    middle = 0.5 * low + 0.5 * high
    return middle, np.maximum(high - middle, middle - low) * (1 + 4 * LOST)
