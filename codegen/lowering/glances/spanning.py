"""A box that the boxes of a list hold together, around states that were visited, though none of them holds it alone.

Does: takes boxes away from a box until nothing is left of it; grows one around states as far as nothing is.
Assumes: closed boxes [n, variables] of finite float64, no state but those of float64; visited states.
Does not: divide a list into cells (coring.py).

What a box leaves of another one begins at the next float64, so that closed boxes that meet leave nothing between them.
"""

from __future__ import annotations

import numpy as np

from codegen.ir import Bool, Float64
from codegen.lowering.searching import Boxes, draw_points

MAX_LEFT = 500  # boxes: what has come to be so many pieces counts as not held
DRAWN = 60  # points, by which most that is not held is found soon
SHRUNK = (1.0, 0.95, 0.9, 0.8)  # of the sides of the box around all visited states
GROWN = (0.1, 0.05)  # of a side, at either end, one after the other, where it cannot reach the end of the list


def span_states(boxes: Boxes, states: Float64) -> Boxes | None:
    """One box within a list, about as wide as the visited states [n, variables] are, and wider where the list is."""
    low, high = boxes.low.min(axis=0), boxes.high.max(axis=0)
    first, last = states.min(axis=0), states.max(axis=0)
    middle, half = first / 2.0 + last / 2.0, last / 2.0 - first / 2.0
    for share in SHRUNK:
        with np.errstate(over="ignore"):
            core = Boxes(np.maximum(middle - share * half, low)[None], np.minimum(middle + share * half, high)[None])
        if is_held(boxes, core):
            return _grow_ends(boxes, core, Boxes(low, high))
    return None


def _grow_ends(boxes: Boxes, core: Boxes, around: Boxes) -> Boxes:
    """A box of a list as wide as it may be of a few widths, end by end."""
    low, high = core.low[0], core.high[0]
    for at in range(len(low)):
        side = float(high[at]) - float(low[at])
        for more in (np.inf, *(share * side for share in GROWN)):
            first, last = max(float(low[at]) - more, around.low[at]), min(float(high[at]) + more, around.high[at])
            for ends, bounds in ((low, (first, low[at])), (high, (high[at], last))):
                added = Boxes(core.low.copy(), core.high.copy())
                added.low[0, at], added.high[0, at] = bounds
                if is_held(boxes, added):
                    ends[at] = first if ends is low else last
    return core


def is_held(boxes: Boxes, whole: Boxes) -> bool:
    """Whether each float64 state of one box, [1, variables], is in a box of a list; no, where that takes too long."""
    near = boxes.take(_find_meeting(boxes, whole.low[0], whole.high[0]))
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        shared = np.minimum(near.high, whole.high) - np.maximum(near.low, whole.low)
        shares = np.nan_to_num(shared / (whole.high - whole.low), nan=1.0).prod(axis=1)
    if not near.holds(np.concatenate([*whole, draw_points(whole)[:DRAWN]])).all():
        return False
    left = whole
    for at in np.argsort(-shares, kind="stable").tolist():
        left = _take_away(left, near.low[at], near.high[at])
        if not 0 < len(left.low) <= MAX_LEFT:
            break
    return not len(left.low)


def _take_away(left: Boxes, low: Float64, high: Float64) -> Boxes:
    """What boxes have beyond one box, as boxes that do not meet."""
    meets = _find_meeting(left, low, high)
    pieces, rest = [left.take(~meets)], left.take(meets)
    for at in range(len(low)):
        below, above = rest.take(rest.low[:, at] < low[at]), rest.take(rest.high[:, at] > high[at])
        with np.errstate(over="ignore"):  # of a box that has all there is along a variable nothing is left beyond
            below.high[:, at], above.low[:, at] = np.nextafter(low[at], -np.inf), np.nextafter(high[at], np.inf)
        pieces += [below, above]
        rest = Boxes(rest.low.copy(), rest.high.copy())
        rest.low[:, at], rest.high[:, at] = np.maximum(rest.low[:, at], low[at]), np.minimum(rest.high[:, at], high[at])
    return Boxes(np.concatenate([each.low for each in pieces]), np.concatenate([each.high for each in pieces]))


def _find_meeting(boxes: Boxes, low: Float64, high: Float64) -> Bool:
    return np.asarray((boxes.low <= high).all(axis=1) & (boxes.high >= low).all(axis=1))
