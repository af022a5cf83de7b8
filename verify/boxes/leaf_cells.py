"""The leaves of a tree whose tests are of single variables, as cells: which of them a box meets is looked up.

Does: for all boxes at once, the leaves that each meets, and its part in each.
Assumes: boxes with finite bounds; nothing is rounded outward, since the checker reads and computes all again.
Does not: know tests of several variables.

The ends of all tests of a variable are sorted. Where the bounds of a box lie among them says, as one row of bits each,
which leaves reach so far. A box meets the leaves that all of its rows have in common.
"""

from __future__ import annotations

from math import inf
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from codegen.ir import Bool, Float64, Int64
from verify.boxes.rows import Rows, join_rows

MAX_LEAVES = 4_096
AT_ONCE = 1 << 24  # pairs of a box and a leaf
Bits = NDArray[np.uint64]


class SingleTests(NamedTuple):
    """A tree, by node: whether it is a leaf, its action, the column and the end of its test, and the children below and
    above that end.
    """

    leaf: Bool
    action: Int64
    column: Int64
    end: Float64
    low: Int64
    high: Int64


class _Ends(NamedTuple):
    """The ends of tests of a variable, in order; the leaves that reach up to the place of a low bound, and down to that
    of a high one, as bits [places, words].
    """

    column: int
    ends: Float64
    up_to: Bits
    down_to: Bits


class LeafCells:
    """Leaves as cells: above `_low`, up to `_high`, [leaves, variables]."""

    def __init__(self, tests: SingleTests, variables: int) -> None:
        lows, highs, actions = list[Float64](), list[Float64](), list[int]()
        pending = [(0, np.full(variables, -inf), np.full(variables, inf))]
        while pending:
            node, low, high = pending.pop()
            if tests.leaf[node]:
                if (low < high).all():
                    lows.append(low)
                    highs.append(high)
                    actions.append(int(tests.action[node]))
                continue
            column, end, below, above = int(tests.column[node]), tests.end[node], high.copy(), low.copy()
            below[column], above[column] = min(high[column], end), max(low[column], end)
            pending += [(int(tests.low[node]), low, below), (int(tests.high[node]), above, high)]
        self._low, self._high = np.array(lows), np.array(highs)
        self._action = np.array(actions, dtype=np.int64)
        self._ends = [self._index_ends(column) for column in range(variables)]
        self._ends = [each for each in self._ends if len(each.ends)]

    def _index_ends(self, column: int) -> _Ends:
        low, high = self._low[:, column], self._high[:, column]
        ends = np.unique(np.concatenate([low, high]))
        ends = ends[np.isfinite(ends)]
        places = np.arange(len(ends) + 1)[:, None]
        first = np.where(low == -inf, -1, np.searchsorted(ends, low))
        return _Ends(column, ends, _bits(np.searchsorted(ends, high) >= places), _bits(first < places))

    def split_at_leaves(self, rows: Rows, actions: int) -> Rows:
        """The boxes cut at the leaves that they meet, with the action as one more digit of the joint one."""
        most = max(AT_ONCE // len(self._action), 1)
        if rows.size > most:
            parts = (rows.at(slice(begin, begin + most)) for begin in range(0, rows.size, most))
            return join_rows([self.split_at_leaves(part, actions) for part in parts])
        if not self._ends:
            return rows._replace(joint=rows.joint * actions + self._action[0])
        common: Bits | None = None
        for column, ends, up_to, down_to in self._ends:
            high = np.searchsorted(ends, rows.high[:, column])
            low = np.searchsorted(ends, rows.low[:, column], "right")
            first = np.minimum(low, high)  # a point on an end lies in the leaf below it
            both = up_to.take(first, axis=0) & down_to.take(high, axis=0)
            common = both if common is None else common & both
        assert common is not None
        flags = np.unpackbits(common.view(np.uint8), axis=1, count=len(self._action), bitorder="little")
        box, leaf = np.divmod(np.flatnonzero(flags), len(self._action))
        met = rows.at(box)
        low = np.maximum(met.low, self._low.take(leaf, axis=0))
        high = np.minimum(met.high, self._high.take(leaf, axis=0))
        return met._replace(low=low, high=high, joint=met.joint * actions + self._action.take(leaf))


def _bits(flags: Bool) -> Bits:
    """Rows of flags as words."""
    padded = np.zeros((len(flags), -(-flags.shape[1] // 64) * 64), dtype=np.bool_)
    padded[:, : flags.shape[1]] = flags
    return np.packbits(padded, axis=1, bitorder="little").view(np.uint64)
