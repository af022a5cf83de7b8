"""The piece, or the rule, that moves each state of a batch, where these have conditions or rules have choices.

Does: finds the first case that a float64 state lies in, and one of the pieces that share it.
Assumes: bounds and factors as their nearest float64; the answers are proposals, like all random play.
Does not: replay.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from codegen.ir import Bool, Float64, Int64
from codegen.numbers import nearest_double
from verify.systems.statement import Rule
from verify.systems.system import HalfSpace, Piece, System

Planes = Mapping[str, Float64]  # variable -> [batch]


def has_cases(system: System) -> bool:
    """Returns True if pieces have conditions, or several pieces hold the same states."""
    return any(piece.when or piece.choice for piece in system.pieces)


class Cases:
    """The cases of pieces, or rules: each with the numbers of those that share its box and conditions."""

    def __init__(self, pieces: Sequence[Piece | Rule]) -> None:
        cases: dict[object, list[int]] = {}
        for number, piece in enumerate(pieces):
            cases.setdefault((tuple(sorted(piece.where.items())), piece.when), []).append(number)
        self._cases = [(pieces[numbers[0]], np.array(numbers, dtype=np.int64)) for numbers in cases.values()]

    def holding(self, state: Planes, count: int, which: Float64) -> Int64:
        """The number of a piece that holds each of `count` states, [count]; -1 where none does. `which`: in [0, 1], the
        place of the piece among those of its case.
        """
        holder = np.full(count, -1, dtype=np.int64)
        for piece, numbers in self._cases:
            here = (holder < 0) & _holds(piece, state, count)
            place = np.minimum((which * len(numbers)).astype(np.int64), len(numbers) - 1)
            holder[here] = numbers[place[here]]
        return holder


def _holds(piece: Piece | Rule, state: Planes, count: int) -> Bool:
    inside = np.ones(count, dtype=np.bool_)
    for name, (low, high) in piece.where.items():
        inside &= (state[name] >= nearest_double(low)) & (state[name] <= nearest_double(high))
    for half in piece.when:
        inside &= _meets(half, state, count)
    return inside


def _meets(half: HalfSpace, state: Planes, count: int) -> Bool:
    total = np.full(count, nearest_double(half.form.constant))
    for name, factor in half.form.terms:
        total = total + nearest_double(factor) * state[name]
    return total < 0 if half.strict else total <= 0
