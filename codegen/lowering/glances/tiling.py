"""The lowered tiles of lists of turned sets: a bit for each cell of a grid, which says that all of the cell is in them.

Does: lays a grid where states were visited, as fine as makes most of them be in such cells; packs the bits.
Assumes: sets of codegen/lowering/turning.py; visited states, which decide nothing but how soon a word is known.
Does not: refuse a state: whoever is in no such cell is asked of the list itself.

A cell counts where each part of it, SPLIT along each variable, lies in one set: in its box, and in its frame, by z that
are enough alone (`well`). Of the sums of A**-1 (x - c) each has to leave as much at the middle of a part as it can
change within it, EDGE and more of it, and SURE of all that is added up in it: more than float64 rounds here and in
code. The first and the last cell along a variable take what is beyond the others, and no number, and never count.

Tried on the pendulum of generated/arch: 64, 128 and 256 cells along both variables tell 79, 90 and 96 % of states that
are drawn anew. Cells turned as the states lie, and more parts to a cell, tell no more. The parallelepipeds of
tilting.py tell a third, since boxes cut most of these frames.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from codegen.ir import Bool, Float64
from codegen.lowering.glances.coring import ENOUGH, FEW, lay_row, place_numbers
from codegen.lowering.parts import Tiles
from codegen.lowering.searching import EDGE, doubles_of
from codegen.lowering.turning import Turned

SIZES = {1: (64, 256), 2: (64, 128, 256), 3: (16, 32)}  # cells along each variable, by how many there are
SPLIT = 4
BEYOND = 0.05  # of the side of the box around visited states: what more the grid takes in at either end
SURE = 2.0**-24
PAID = 0.03  # of all states, that have to be told more by twice as many cells along each variable


def tile_lists(lists: Sequence[Turned], visited: Sequence[Float64]) -> Tiles | None:
    """Tiles of lists, or None where they tell too few. `visited`: of each list some states, or nothing at all."""
    width = lists[0].low.shape[1]
    if width not in SIZES or len(visited) < len(lists) or min(map(len, visited)) < FEW:
        return None
    best: list[_Tiled] = []
    most = ENOUGH - PAID
    for size in SIZES[width]:
        laid = [_Tiled(sets, size, states) for sets, states in zip(lists, visited, strict=True)]
        told = float(np.mean([tiled.tell(states).mean() for tiled, states in zip(laid, visited, strict=True)]))
        if told >= most + PAID:
            best, most = laid, told
    if not best:
        return None
    rows = tuple(tuple(doubles_of(np.array(row)) for row in tiled.rows) for tiled in best)
    packed = np.concatenate([np.packbits(tiled.cells.ravel(), bitorder="little") for tiled in best])
    return Tiles(best[0].size, rows, tuple(packed.tolist()))


class _Tiled:
    """The tiles of a list: `rows`, by variable the least and most of its cells and their scale; `cells`, [size, ...],
    which of them count.
    """

    def __init__(self, sets: Turned, size: int, states: Float64) -> None:
        low, high = states.min(axis=0), states.max(axis=0)
        low, high = low - BEYOND * (high - low), high + BEYOND * (high - low)
        low, high = np.maximum(low, sets.low.min(axis=0)), np.minimum(high, sets.high.max(axis=0))
        self.size, self.width = size, len(low)
        self.rows = [lay_row(low[at : at + 1], high[at : at + 1], size) for at in range(self.width)]
        self.cells: Bool = np.zeros((size,) * self.width, dtype=np.bool_)
        if all(scale > 0.0 for _, _, scale in self.rows):
            parts = self._find_parts(sets).reshape([each for _ in low for each in (size, SPLIT)])
            inner = (slice(1, -1),) * self.width
            whole = np.asarray(parts.all(axis=tuple(range(1, 2 * self.width, 2))))
            self.cells[inner] = whole[inner]

    def tell(self, states: Float64) -> Bool:
        """Which states are in a cell that counts."""
        places = [place_numbers(states[:, at], row, self.size) for at, row in enumerate(self.rows)]
        return self.cells.ravel()[np.ravel_multi_index(places, self.cells.shape)]

    def _find_parts(self, sets: Turned) -> Bool:
        """Which parts of cells lie in a set, [SPLIT * size, ...]."""
        least, _, scale = np.array(self.rows).T
        part, edge = 1.0 / (SPLIT * scale), SPLIT * EDGE
        held = np.zeros((SPLIT * self.size,) * self.width, dtype=np.bool_)
        with np.errstate(over="ignore"):
            begins = np.clip(np.ceil((sets.low - least) / part + edge), 0.0, len(held)).astype(np.int64)
            ends = np.clip(np.floor((sets.high - least) / part - edge), 0.0, len(held)).astype(np.int64)
        largest = np.abs(np.concatenate([sets.low, sets.high, sets.centre])).max(axis=0)
        room = sets.well - np.matmul(np.abs(sets.inverse), (0.5 + edge) * part + SURE * largest)
        for at in np.flatnonzero((room > 0.0).all(axis=1) & (begins < ends).all(axis=1)).tolist():
            first, last = begins[at].tolist(), ends[at].tolist()
            off: list[Float64] = []
            for k, span in enumerate(map(np.arange, first, last)):
                middles: Float64 = least[k] + (span + 0.5) * part[k] - sets.centre[at, k]
                off.append(middles.reshape([-1 if other == k else 1 for other in range(self.width)]))
            within = np.ones([end - begin for begin, end in zip(first, last, strict=True)], dtype=np.bool_)
            for factors, most in zip(sets.inverse[at].tolist(), room[at].tolist(), strict=True):
                total = np.zeros(within.shape)
                for factor, column in zip(factors, off, strict=True):
                    total = total + factor * column
                within &= np.abs(total) <= most
            held[tuple(map(slice, first, last))] |= within
        return held
