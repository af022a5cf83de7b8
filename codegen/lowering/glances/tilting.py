"""The lowered tilt: a turned set as one product of a small float32 matrix with the state, which nearly all states pass.

Does: makes of a set with a frame a parallelepiped within it, as large on all sides as the rest of the frame allows;
  leaves out what roundings of float32 could add.
Assumes: sets of codegen/lowering/turning.py.
Does not: refuse a state: whoever is beyond is asked of the frame itself.

With x = c + A z + B r a state is in a set for all |z_j| <= 1 + e_j where |B**-1 A| e <= R, row by row: r makes up for
what is beyond 1. All e_j grow together, until a row is full; then those go on that it has no part in. Of A**-1 (x - c)
each row is divided by its 1 + e_j, so that each of the sums has to be within 1: sums of x itself, since A**-1 c is a
constant. In float32 a sum is off by at most 2**-24 (n + 3) times the sum of absolute products. That is at most a +
b M, where M is the largest sum, since then x is within M times the parallelepiped; so M <= (1 + a) / (1 - b), wherever
x is. By so much, and by MARGIN, the parallelepiped is smaller: by a share MARGIN of its size, but by all that roundings
may add, however small a narrow box makes it. MARGIN is beyond all that turning.py leaves out for its own roundings: a
state that passes here passes there.

Four sums at once are one instruction of most processors: the matrix is by columns, each filled up to a multiple of
four. Beside the product in double that turning.py makes, with a jump for each sum, it takes a third.

Tried at TORA, where a step took 2.5 ns: what squares are compared with beside the factors, and masks that are joined in
place of bits, take a tenth less. The largest of four squares takes a seventh more; numbers that are rounded in pairs,
and a matrix by diagonals, gain nothing. Without any glance a step takes 1.5.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from codegen.floats import short_hex
from codegen.ir import Bool, Float32, Float64
from codegen.lowering.parts import LANES, UNIT, Tilt
from codegen.lowering.turning import KEPT, LARGEST_EDGE, NEARLY, UNDER, Turned, measure_needs

SINGLE = 2.0**-24  # unit of float32
MARGIN = 2.0**-13
MAX_LOST = 2.0**-10  # by roundings of float32: beyond, no state passes
LARGEST = 2.0**60  # factor
REFUSED, ZERO = "0x1p+1F", "0x0p+0F"  # a sum that is beyond 1 in every state, and its factors
FEW = 0.1  # of the sets


def tilt_alone(steps: Sequence[Turned]) -> tuple[Tilt, ...]:
    """A tilt that no state passes, and the tilt of each list, where each is one set; nothing at all where too many are
    sets that no state passes.
    """
    if any(len(sets.low) != 1 for sets in steps):
        return ()
    tilts = tuple(tilt for sets in steps for tilt in tilt_sets(sets))
    refused = sum(tilt.first[0] == REFUSED for tilt in tilts)
    none = Tilt((REFUSED,) * len(tilts[0].first), ((ZERO,) * len(tilts[0].first),) * len(tilts[0].along))
    return (none, *tilts) if refused <= FEW * len(tilts) else ()


def tilt_sets(sets: Turned) -> tuple[Tilt, ...]:
    """The tilt of each set; of a set that is flat, or where roundings hide too much, one that no state passes."""
    size = sets.low.shape[1]
    lanes = -(-size // LANES) * LANES
    with np.errstate(all="ignore"):
        within, orthogonal = _widen_evenly(sets)
        rows = sets.inverse / within[:, :, None]
        first = -np.matmul(rows, sets.centre[:, :, None])[:, :, 0]
        reach = np.matmul(np.abs(sets.matrix), within[:, :, None])[:, :, 0]
        share = 2.0 * (size + 3) * SINGLE
        still = share * (np.matmul(np.abs(rows), np.abs(sets.centre)[:, :, None])[:, :, 0] + np.abs(first)).max(axis=1)
        lost = still + share * np.matmul(np.abs(rows), reach[:, :, None])[:, :, 0].max(axis=1)
        sides = np.minimum(sets.high - sets.centre, sets.centre - sets.low)
        part = np.minimum((sides / reach).min(axis=1), 1.0) * (1.0 - MARGIN) - 2.0 * lost
        rows, first = rows / part[:, None, None], first / part[:, None]
        left_out = np.abs(np.matmul(sets.inverse, sets.matrix) - np.eye(size)).sum(axis=2).max(axis=1)
        sure = orthogonal & (lost < MAX_LOST) & (part > 0.0) & (left_out < LARGEST_EDGE)
        sure &= np.asarray((np.abs(rows) < LARGEST).all(axis=(1, 2)) & (np.abs(first) < LARGEST).all(axis=1))
    padded = np.zeros((len(rows), 1 + size, lanes), dtype=np.float32)
    padded[:, 0, :size] = np.where(sure[:, None], first, 2.0)
    padded[:, 1:, :size] = np.where(sure[:, None, None], rows, 0.0).transpose(0, 2, 1)
    return tuple(Tilt(_write_floats(each[0]), tuple(map(_write_floats, each[1:]))) for each in padded)


def _widen_evenly(sets: Turned) -> tuple[Float64, Bool]:
    """Within what each z may be, [n, d], none beyond 2; and whether B is orthogonal enough for that to be so."""
    needs, skew = measure_needs(sets.matrix, sets.turned)
    beyond, size = np.zeros_like(sets.rest), sets.rest.shape[1]
    none = np.abs(np.matmul(sets.turned.transpose(0, 2, 1), sets.matrix)) < needs.max(axis=(1, 2), keepdims=True) * (
        2.0 * (size + 4) * UNIT
    )
    needs = np.where(none, 0.0, needs)
    for at, of in enumerate(needs):
        left, going = KEPT * sets.rest[at], np.ones(size, dtype=np.bool_)
        while going.any():
            used = of[:, going].sum(axis=1)
            grown = np.where(used > 0.0, left / np.maximum(used, UNDER), np.inf)
            most = min(float(grown.min()), float((1.0 - beyond[at, going]).min()))
            beyond[at, going] += most
            left = np.maximum(left - used * most, 0.0)
            full = grown <= most  # rows that leave nothing for whatever has a part in them
            going &= ~(of[full] > 0.0).any(axis=0) & (beyond[at] < 1.0)
    return 1.0 + beyond, skew < NEARLY


def _write_floats(values: Float32) -> tuple[str, ...]:
    return tuple(f"{short_hex(float(value) + 0.0)}F" for value in values)
