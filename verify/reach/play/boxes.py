"""The piece that holds each state of a batch.

Does: finds the first piece whose box a float64 state lies in, bounds included.
Assumes: bounds as their nearest float64; the answers are proposals, like all random play.
Does not: replay.

The bounds of all boxes cut the range of each variable into cells, and all states of a cell lie in the same boxes. So
boxes are compared once with each cell that a state lies in, and not with every state.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from codegen.ir import Float64, Int64
from verify.systems.system import System


class Boxes:
    """The boxes of a system's pieces, and the cells that were asked for."""

    def __init__(self, system: System) -> None:
        boxes = [
            {name: (float(low), float(high)) for name, (low, high) in piece.where.items()} for piece in system.pieces
        ]
        self._count = len(boxes)
        self._ends: dict[str, Float64] = {}  # of each variable that a box bounds
        for name in dict.fromkeys(name for box in boxes for name in box):
            self._ends[name] = np.unique(np.array([box[name] for box in boxes if name in box]))
        free = [(0, 2 * len(ends)) for ends in self._ends.values()]
        spans = np.array(
            [
                [
                    self._cells(name, np.array(box[name])).tolist() if name in box else span
                    for name, span in zip(self._ends, free, strict=True)
                ]
                for box in boxes
            ],
            dtype=np.int64,
        ).reshape(self._count, len(self._ends), 2)
        self._low, self._high = spans[:, :, 0], spans[:, :, 1]  # [pieces, variables]
        self._known: dict[bytes, int] = {}

    def holding(self, state: Mapping[str, Float64], count: int) -> Int64:
        """The number of the first piece that holds each of `count` states, [count]; -1 where none does."""
        cells = np.zeros((count, len(self._ends)), dtype=np.int64)
        which = np.zeros(count, dtype=np.int64)  # cells are numbered column by column: sorting whole rows takes longer
        for column, (name, ends) in enumerate(self._ends.items()):
            cells[:, column] = self._cells(name, state[name])
            which = np.unique(which * (2 * len(ends) + 1) + cells[:, column], return_inverse=True)[1].reshape(count)
        _, examples = np.unique(which, return_index=True)
        return np.array([self._first(cells[place]) for place in examples], dtype=np.int64)[which]

    def _cells(self, name: str, values: Float64) -> Int64:
        """Twice the number of ends below a value, and one more on an end."""
        ends = self._ends[name]
        return np.searchsorted(ends, values, "left") + np.searchsorted(ends, values, "right")

    def _first(self, cell: Int64) -> int:
        key = cell.tobytes()
        if key not in self._known:
            holds = ((self._low <= cell) & (cell <= self._high)).all(axis=1)
            self._known[key] = int(holds.argmax()) if holds.any() else -1
        return self._known[key]
