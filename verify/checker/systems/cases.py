"""The checker's own reading of modes and cases: every episode stays in modes, and some piece holds every state.

Does: shows that a mode is always one of its values; that the pieces of a system leave out no state within the bounds of
  their boxes.
Assumes: systems/system.py; belongs to what must be right for a certificate to mean something.
Does not: mind that pieces overlap: each of them is followed.

What the pieces test is a few sums of variables. Their ends cut each sum into points and open intervals, within which no
test changes. A state lies in one such cell of each sum, so no state is left out if some piece holds each combination
of cells.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import pairwise

import numpy as np

from verify.checker.reading import RejectedError, TooMuchError
from verify.systems.system import (
    FREE,
    Affine,
    Box,
    HalfSpace,
    Piece,
    Polytope,
    System,
    Variable,
    bounds_of,
    box_of,
)

MAX_CELLS, MAX_SUMS = 200_000, 32
Sum = tuple[tuple[str, Fraction], ...]  # of variables, its first factor 1


def has_cases(system: System) -> bool:
    """Returns True if a system has modes, or pieces that hold less than a box."""
    return any(one.modes for one in system.variables) or any(piece.when for piece in system.pieces)


def hull_of(system: System) -> Box:
    """Bounds of each variable that all boxes of pieces bound. What lies within them is stated where `ensure_cases` has
    shown it.
    """
    wheres = [piece.where for piece in system.pieces]
    named = [name for name in wheres[0] if all(name in where for where in wheres)] if wheres else []
    return {name: (min(where[name][0] for where in wheres), max(where[name][1] for where in wheres)) for name in named}


def ensure_cases(system: System) -> None:
    """RejectedError where an episode is not shown to stay in modes, or a state not to lie in some piece."""
    if not has_cases(system) or not system.pieces:
        return
    modes = {one.name: one for one in system.variables if one.modes}
    for one in modes.values():
        ensure_starts(one, system.start)
        for number, piece in enumerate(system.pieces, 1):
            _ensure_stays(one, piece, modes, f"piece {number}")
    ensure_complete(system, modes)


# --- modes


def ensure_starts(mode: Variable, start: Polytope) -> None:
    """RejectedError unless the start is one value of a mode."""
    low, high = bounds_of(start, {mode.name: FREE})[mode.name]
    if low != high or not is_mode_value(low, mode):
        raise RejectedError(f"episodes do not start in one mode of {mode.name}")


def is_mode_value(number: Fraction, mode: Variable) -> bool:
    """Returns True if a number is one of a mode's values."""
    return number.denominator == 1 and 0 <= number < len(mode.modes)


def _ensure_stays(mode: Variable, piece: Piece, modes: Mapping[str, Variable], where: str) -> None:
    """RejectedError unless a piece sets a mode to a value, whatever agents do."""
    if piece.error.get(mode.name, (0, 0)) != (0, 0):
        raise RejectedError(f"{where}: the mode {mode.name} has an error")
    totals = [piece.move.get(mode.name, Affine())]
    for agent in {agent for agent, _ in piece.effect}:
        added = [forms.get(mode.name, Affine()) for (who, _), forms in piece.effect.items() if who == agent]
        totals = [total.plus(each) for total in totals for each in {*added, Affine()}]
        if len(totals) > MAX_CELLS:
            raise TooMuchError(f"{where}: too many ways to set the mode {mode.name}")
    for total in totals:
        copied = [modes.get(name) for name, factor in total.terms if factor == 1]
        copies = len(total.terms) == 1 and not total.constant and copied[:1] not in ([], [None])
        fits = copies and copied[0] is not None and len(copied[0].modes) <= len(mode.modes)
        if total.terms == ((mode.name, 1),) and total.constant.denominator == 1:  # a counter
            ends = piece.where.get(mode.name, mode.range)
            fits = fits or all(is_mode_value(end + total.constant, mode) for end in ends)
        if not fits and (total.terms or not is_mode_value(total.constant, mode)):
            raise RejectedError(f"{where}: {mode.name} may become what is none of its modes")


# --- pieces


def ensure_complete(system: System, modes: Mapping[str, Variable]) -> None:
    """RejectedError where some combination of cells lies in no piece."""
    hull = hull_of(system)
    held = [tests_of(piece) for piece in system.pieces]
    sums = list(dict.fromkeys(total for tests in held for half in tests for total in [_sum(half)]))
    for total in sums:
        if any(name not in hull for name, _ in total):
            raise RejectedError("the boxes of pieces do not bound all that the pieces test")
    cells = [_cells(total, held, hull, modes) for total in sums]
    count = 1
    for each in cells:
        count *= len(each)
    if count > MAX_CELLS or len(sums) > MAX_SUMS:
        raise TooMuchError(f"the pieces test too much to be seen to leave out nothing: {count:,} cells")
    places = {total: place for place, total in enumerate(sums)}
    held_cells = np.zeros([len(each) for each in cells], dtype=np.bool_)  # one axis for each sum
    for tests in held:
        met = np.ones_like(held_cells)
        for half in tests:
            place, lead = places[_sum(half)], half.form.terms[0][1]
            values = [lead * total + half.form.constant for total in cells[place]]
            holds = np.array([value < 0 if half.strict else value <= 0 for value in values], dtype=np.bool_)
            met &= holds.reshape([-1 if axis == place else 1 for axis in range(len(cells))])
        held_cells |= met
    if not held_cells.all():
        chosen: list[int] = np.argwhere(~held_cells)[0].tolist()
        near = [float(each[at]) for each, at in zip(cells, chosen, strict=True)]
        words = [" + ".join(name if factor == 1 else f"{factor}*{name}" for name, factor in total) for total in sums]
        told = ", ".join(f"{each} near {value:g}" for each, value in zip(words, near, strict=True))
        raise RejectedError(f"no piece is seen to hold {told}")


def tests_of(piece: Piece) -> list[HalfSpace]:
    """All that a state of a piece meets, as half spaces."""
    return [*piece.when, *box_of(piece.where)]


def _sum(half: HalfSpace) -> Sum:
    if not half.form.terms:
        raise RejectedError("a piece has a condition that speaks of no variable")
    lead = half.form.terms[0][1]
    return tuple((name, factor / lead) for name, factor in half.form.terms)


def _cells(total: Sum, held: Sequence[Sequence[HalfSpace]], hull: Box, modes: Mapping[str, Variable]) -> list[Fraction]:
    """A number of each cell of a sum, within the bounds that it has."""
    if len(total) == 1 and total[0][0] in modes:
        return [Fraction(n) for n in range(len(modes[total[0][0]].modes))]
    ends = [sorted(factor * end for end in hull[name]) for name, factor in total]
    low, high = sum((least for least, _ in ends), Fraction(0)), sum((most for _, most in ends), Fraction(0))
    own = [half for tests in held for half in tests if _sum(half) == total]
    tested = {-half.form.constant / half.form.terms[0][1] for half in own}
    inner = sorted({low, high, *(end for end in tested if low < end < high)})
    return [*inner, *((a + b) / 2 for a, b in pairwise(inner))]
