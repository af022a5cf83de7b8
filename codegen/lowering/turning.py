"""The lowered list of turned sets: what is asked of a state before it surely lies in one of them.

Does: makes of sets with frames, for each step, numbers by which a few products of matrices vouch for states; bounds
  what rounding hides, so that no state outside is vouched for; says how many comparisons that takes.
Assumes: sets of finite float64, each with a frame, of which a proof holds.
Does not: know what is proved, or write text (codegen/targets/monitor.py).

A state x is in a set where it is in its box, and x = c + A z + B r for some |z_j| <= 1 and |r_i| <= R_i: the frame.
With t = x - c, its z is about A**-1 t, and its r about B' t', where t' = t - A z is what is left, since B is nearly
orthogonal. Both are put within bounds, z within 1 - h. If then no more is left than a slack s, in each variable, x is
vouched for. For z and r are numbers within their bounds, whatever rounding made of them; and what is left, with all
that rounding took from the two sums, is at most some g, and so A y for some y with |y_j| <= h. Then x = c + A (z + y) +
B r. So rounding never counts in favour of a state. Sums of floats are off by at most 2 u (n + 4) times the sum of
absolute products, in any order, with and without fused operations (u = 2**-53). Where no z had to be put within 1 - h,
that is enough: A**-1 t is off by at most h. It is enough too where each is within 1 - h + e_j, if the r that make up
for e, B**-1 A e, are within R, but for what is left within s / 2. So nearly all states of a set take one product of a
matrix. Where the states of such z are in the box, give or take one in a million, it is not compared before them.
A variable that a frame sets apart is compared with bounds alone: where no other one has a part in what it may be, in A
and in B, the set is a box along it. So a set may be a point there, as along a constant. Refused: sets that are flat
otherwise, so that h is above LARGEST_EDGE.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import islice, permutations
from typing import NamedTuple

import numpy as np

from codegen.errors import InputError
from codegen.ir import Bool, Float64
from codegen.lowering.parts import UNIT
from codegen.lowering.searching import Boxes, Frame, Lookup, doubles_of, search_of

MAX_SETS = 5_000  # of all steps together
NEXT_TO_NONE = 2.0**-900  # a width that comes of a point, which has some so that it is no division by zero
UNDER = 2.0**-960  # more than underflow takes from a sum
INSCRIBED = 1.0 - 2.0**-20  # of what z may be: what more is cut off is asked of boxes
ROOM = 8.0  # slack, for what one sum is off by
LARGEST_EDGE = 2.0**-20  # of z: what is refused at the border of a set
NEARLY = 2.0**-40  # how far from orthogonal the columns of B may be where a z may be beyond 1
ORDERS = 720  # of the variables, that are tried: all of six
KEPT = 1.0 - 2.0**-30  # of the bounds of r, so that roundings here are within
LARGEST = 2.0**500  # of any number here, so that nothing overflows


class Turned(NamedTuple):
    """Sets: boxes [n, d] and frames, `centre`, `rest` and `slack` [n, d], `matrix`, `inverse` and `turned` [n, d, d],
    `most` [n]: 1 - h; `well` [n, d]: within what each z is enough; `inscribed` [n]: whether such z are in the box too.
    """

    low: Float64
    high: Float64
    centre: Float64
    inverse: Float64
    matrix: Float64
    turned: Float64
    rest: Float64
    slack: Float64
    most: Float64
    well: Float64
    inscribed: Bool

    def holds(self, states: Float64) -> Bool:
        """Which states [batch, variables] are vouched for, with the roundings of generated code."""
        inside = np.zeros(len(states), dtype=np.bool_)
        for at in range(len(self.low)):
            near = np.flatnonzero(((states >= self.low[at]) & (states <= self.high[at])).all(axis=1))
            off = states[near] - self.centre[at]
            along, most = _multiply(self.inverse[at], off), self.most[at]
            well = np.asarray((np.abs(along) <= self.well[at]).all(axis=1))
            put = np.clip(along, -most, most)
            left = off - _multiply(self.matrix[at], put)
            across = np.clip(_multiply(self.turned[at].T, left), -self.rest[at], self.rest[at])
            left = left - _multiply(self.turned[at], across)
            inside[near] |= well | np.asarray((np.abs(left) <= self.slack[at]).all(axis=1))
        return inside


class _Measured(NamedTuple):
    """Of frames the inverses of A, the slack of each variable, h of each set, and whether it is small enough."""

    inverse: Float64
    slack: Float64
    edge: Float64
    sure: Bool


def turn_sets(boxes: Boxes, centre: Float64, matrix: Float64, rest: Float64, turned: Float64, where: str) -> Turned:
    """Sets of a proof, each with its frame. `where` is named in errors. InputError for sets that are flat, unless along
    variables that their frames set apart.
    """
    whole = _fill_boxes(boxes, centre, matrix)
    found = _measure(boxes, centre, matrix, rest, turned)
    flat = ~(whole | found.sure)
    if flat.any():
        boxes, matrix, rest = _set_apart(flat, boxes, centre, matrix, rest, turned)
        found = _measure(boxes, centre, matrix, rest, turned)
    inverse, slack, edge, sure = found
    if not (whole | sure).all():
        what = "a set of the proof is so flat that rounding hides whether a state is in it"
        advice = (
            "start what moves in a range, not at a point, and let no variable be a sum of others; then verify again"
        )
        raise InputError(what, where, advice)
    most = np.where(whole, 1.0, 1.0 - edge)
    well, inscribed = _inscribe(boxes, centre, matrix, _widen(matrix, rest, turned, slack, most), edge)
    slack = np.where(whole[:, None], LARGEST, slack)
    inverse = np.where(sure[:, None, None], inverse, np.eye(matrix.shape[1]))  # of a start that is flat: its box counts
    return Turned(*boxes, centre, inverse, matrix, turned, rest, slack, most, well, inscribed & sure)


def _measure(boxes: Boxes, centre: Float64, matrix: Float64, rest: Float64, turned: Float64) -> _Measured:
    """What rounding hides of frames."""
    low, high = boxes
    size = low.shape[1]
    with np.errstate(all="ignore"):
        inverse = _invert(matrix)
        share = 2.0 * (size + 4) * UNIT
        off = np.abs(np.matmul(inverse, matrix) - np.eye(size)) + share * np.matmul(np.abs(inverse), np.abs(matrix))
        part = off.sum(axis=2).max(axis=1)  # of A**-1 that the inverse leaves out
        reach = np.maximum(high - centre, centre - low) + np.abs(matrix).sum(axis=2)
        reach += 2.0 * np.matmul(np.abs(turned), rest[:, :, None])[:, :, 0]
        lost = 4.0 * share * reach + UNDER  # in both sums of what is left
        slack = ROOM * lost
        edge = np.matmul(np.abs(inverse), (slack + lost)[:, :, None])[:, :, 0].max(axis=1)
        far = np.matmul(np.abs(inverse), np.maximum(high - centre, centre - low)[:, :, None])[:, :, 0].max(axis=1)
        edge = 2.0 * (edge + 2.0 * part + share * far) / (1.0 - part)
        sure = (part < 0.25) & (edge <= LARGEST_EDGE) & (np.abs(inverse).max(axis=(1, 2)) < LARGEST)
    return _Measured(inverse, slack, edge, sure)


def _set_apart(
    flat: Bool, boxes: Boxes, centre: Float64, matrix: Float64, rest: Float64, turned: Float64
) -> tuple[Boxes, Float64, Float64]:
    """The same sets, or parts of those that are flat, with bounds in boxes in place of what frames say of variables
    that they set apart. Such a variable is c + a z + r, and beside that a sum of NEXT_TO_NONE at most: no other one has
    this r, and none this z, or z is 0 here.
    """
    size: int = matrix.shape[1]
    whole, along = np.abs(matrix), list(range(size))
    alone = np.eye(size, dtype=np.bool_)
    others = np.where(alone, 0.0, whole)
    unmixed = (others.sum(axis=1) == 0.0) & (others.sum(axis=2) == 0.0)
    unit = np.abs(turned) == 1.0  # [n, variable, r]
    lone = unit & ((turned != 0.0).sum(axis=2, keepdims=True) == 1) & ((turned != 0.0).sum(axis=1, keepdims=True) == 1)
    own: Float64 = np.asarray(np.where(lone, rest[:, None, :], 0.0).sum(axis=2), dtype=np.float64)
    thin = whole.sum(axis=2) <= NEXT_TO_NONE
    sides: Float64 = np.asarray(whole[:, along, along], dtype=np.float64)
    half = np.where(unmixed, own + sides, own - NEXT_TO_NONE) * KEPT
    apart: Bool = np.asarray(flat[:, None] & lone.any(axis=2) & (unmixed | thin) & (half >= 0.0), dtype=np.bool_)
    low = np.minimum(centre, np.nextafter(centre - half, np.inf))  # the centre is always in
    high = np.maximum(centre, np.nextafter(centre + half, -np.inf))
    narrowed = Boxes(np.where(apart, np.maximum(boxes.low, low), boxes.low),
                     np.where(apart, np.minimum(boxes.high, high), boxes.high))  # fmt: skip
    mixed = np.where(apart[:, :, None] | apart[:, None, :], 0.0, matrix)
    side = np.maximum(narrowed.high - centre, centre - narrowed.low)  # of a frame that holds all of the box there
    mixed[:, along, along] += np.where(apart, 2.0 * np.abs(side) + 1.0, 0.0)
    taken: Bool = np.asarray((lone & apart[:, :, None]).any(axis=1), dtype=np.bool_)
    return narrowed, mixed, np.where(taken, 0.0, rest)


def _inscribe(boxes: Boxes, centre: Float64, matrix: Float64, well: Float64, edge: Float64) -> tuple[Float64, Bool]:
    """Within what z may be so that their states are in the boxes too, and where this takes next to nothing from them;
    elsewhere the same as before. A state of such z is off the centre by less than three times the box, whose edge is
    that of states within: twice as much is enough.
    """
    with np.errstate(all="ignore"):
        sides = np.minimum(boxes.high - centre, centre - boxes.low) * KEPT
        reach = np.matmul(np.abs(matrix), (well + 2.0 * edge[:, None])[:, :, None])[:, :, 0]
        part = (sides / reach).min(axis=1)[:, None]
        inner = np.where(part < 1.0, well * part * KEPT - 4.0 * edge[:, None], well)
        inscribed = np.asarray((inner > well * INSCRIBED).all(axis=1))
    return np.where(inscribed[:, None], inner, well), inscribed


def _widen(matrix: Float64, rest: Float64, turned: Float64, slack: Float64, most: Float64) -> Float64:
    """Within what each z may be, [n, d], so that r within their bounds make up for what is beyond 1, but for a half of
    the slack. No z is beyond 2: so far bounds of what its product hides.
    """
    size = matrix.shape[1]
    needs, skew = measure_needs(matrix, turned)
    with np.errstate(all="ignore"):
        lost = (slack / np.abs(turned).sum(axis=2)).min(axis=1, keepdims=True) / 2.0
        room = np.where(skew[:, None] < NEARLY, KEPT * (rest + lost), 0.0)
        beyond = np.zeros_like(rest)
        for order in islice(permutations(range(size)), ORDERS):
            tried, left = np.zeros_like(rest), room.copy()
            for column in order:
                tried[:, column] = np.clip((left / needs[:, :, column]).min(axis=1), 0.0, 1.0) * KEPT
                left -= needs[:, :, column] * tried[:, column, None]
            better = tried.sum(axis=1) > beyond.sum(axis=1)
            beyond[better] = tried[better]
    return np.maximum(most[:, None], np.nextafter(most[:, None] + beyond, 0.0))


def measure_needs(matrix: Float64, turned: Float64) -> tuple[Float64, Float64]:
    """How much of each r a z takes at most that is beyond by 1, [n, d, d] by r and z, roundings included; and how far B
    is from orthogonal, [n]: of no use from NEARLY on.
    """
    size, across = matrix.shape[1], turned.transpose(0, 2, 1)
    share = 2.0 * (size + 4) * UNIT
    with np.errstate(all="ignore"):
        off = np.abs(np.matmul(across, turned) - np.eye(size)) + share * np.matmul(np.abs(across), np.abs(turned))
        skew = off.sum(axis=2).max(axis=1)  # B**-1 is not quite B'
        needs = np.abs(np.matmul(across, matrix)) + share * np.matmul(np.abs(across), np.abs(matrix)) + UNDER
        needs += 2.0 * skew[:, None, None] * needs.max(axis=1, keepdims=True)
    return needs, skew


def _fill_boxes(boxes: Boxes, centre: Float64, matrix: Float64) -> Bool:
    """Which frames hold their whole boxes, as those of starts do: they are upright, and reach as far."""

    def is_filled(at: int) -> bool:
        sides = np.diagonal(matrix[at])
        if (matrix[at] != np.diag(sides)).any():
            return False
        ends = zip(boxes.low[at].tolist(), centre[at].tolist(), boxes.high[at].tolist(), sides.tolist(), strict=True)
        return all(max(Fraction(c) - Fraction(low), Fraction(high) - Fraction(c)) <= abs(Fraction(side))
                   for low, c, high, side in ends)  # fmt: skip

    return np.array([is_filled(at) for at in range(len(centre))], dtype=np.bool_)


def _invert(matrix: Float64) -> Float64:
    """About the inverse of each; where there is none, numbers that are no inverse."""
    inverse = np.zeros_like(matrix)
    for at, each in enumerate(matrix):
        try:
            inverse[at] = np.linalg.inv(each)
        except np.linalg.LinAlgError:
            continue
    return inverse


def _multiply(matrix: Float64, vectors: Float64) -> Float64:
    """M v of each vector [batch, d], added from left to right."""
    total = np.zeros((len(vectors), len(matrix)))
    for column in range(matrix.shape[1]):
        total = total + matrix[:, column] * vectors[:, column, None]
    return total


def ensure_few_sets(count: int, where: str) -> None:
    """InputError for more turned boxes of all steps than a monitor has room for. `where` is named in errors."""
    if count > MAX_SETS:
        what = f"the proof has {count:,} turned boxes, and a monitor has room for {MAX_SETS:,}"
        raise InputError(what, where, "verify the claim for fewer steps, or from a smaller start")


def look_up_turned(steps: Sequence[Turned], where: str) -> Lookup:
    """The search of lists of sets, one for each step. `where` is named in errors. InputError for too many sets."""
    ensure_few_sets(sum(len(sets.low) for sets in steps), where)
    boxes = [[Boxes(sets.low, sets.high)] for sets in steps]
    found = search_of(boxes, [range(steps[0].low.shape[1])], framed=True)
    frames = [_lower_frame(sets, at) for sets in steps for at in range(len(sets.low))]
    frames.append(_hold_nothing(found.width))  # as the last box: of empty cells, where no box is compared first
    return replace(found, frames=tuple(frames), inscribed=all(bool(sets.inscribed.all()) for sets in steps))


def _lower_frame(sets: Turned, at: int) -> Frame:
    """The frame of one of some sets, as code has it."""
    rows = (sets.inverse, sets.matrix, sets.turned)
    inverse, matrix, turned = (tuple(doubles_of(row) for row in each[at]) for each in rows)
    centre, rest, slack, well = (doubles_of(each[at]) for each in (sets.centre, sets.rest, sets.slack, sets.well))
    (most,) = doubles_of(sets.most[at : at + 1])
    return Frame(centre, inverse, matrix, turned, rest, slack, most, well)


def _hold_nothing(width: int) -> Frame:
    """The frame that holds no state: no number is within -1, neither z nor what is left."""
    none, never = doubles_of(np.zeros(width)), doubles_of(np.full(width, -1.0))
    return Frame(none, (none,) * width, (none,) * width, (none,) * width, none, never, none[0], never)
