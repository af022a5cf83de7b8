"""Turned boxes without a variable that nothing reads: what of their states the other variables tell.

Does: which variables of a flow no later state depends on; sets with frames as sets of the other variables.
Assumes: sets as codegen/lowering/turning.py has them, of finite float64.
Does not: know proofs, or ask whether a state is in a set.

What a sample sets anew, before anything reads it, may be any number: then a proof holds of a state if it holds of one
with the same other variables. Without such a u, a set { c + A z + B r } with n variables is one in n - 1, whose A and B
have a column too many. This makes a part of it that has a frame again: { c + A' z + Q y }, |z_j| <= 1, |y_i| <= Y_i.

- Of A the least column goes: its z is 0. So does one of B with which u moves, where r within a share of their bounds,
  MOST or more, keep u within its box for all z: all r do, or all others. Elsewhere those r count that do not move u,
  and z within a share.
- Q is orthogonal and spans what columns of B do, one after the other. Y is such that the r of each y, S Q y, are within
  their bounds R: W Y <= R for W = |S Q|, where S inverts what is left of B. Of some such Y the largest is taken.
- A set goes whose centre, which is in all of its parts, has a u out of its box.
- Where A is flat, some Q D is added to it, of which y have to make up for: |D| 1 <= Y / 2.

All bounds are taken for less than they are by KEPT, and W and |D| for more, by what rounding hides.
"""

from collections.abc import Iterator, Sequence
from itertools import chain, islice, permutations, product
from typing import NamedTuple

import numpy as np

from codegen.errors import InputError
from codegen.ir import Float64
from codegen.lowering.searching import Boxes
from codegen.lowering.turning import KEPT, ORDERS, Turned, turn_sets
from verify.checker.covers.invariants import names_of
from verify.systems.claims import SystemClaim
from verify.systems.language.expressions import names
from verify.systems.system import System

SHARE = 2.0**-40  # of z or y: more than rounding hides of matrices here
MOST = 0.5
CONDITION = 2.0**10  # of A that is multiplied by a share: what rounding does to z is within 2**-37 of it
TINY = 2.0**-1000
LEAST = 2.0**-10  # of how much u moves with a column of B that goes
WIDE = 0.25  # of A in units of Y: what is narrower is flat
GREEDY = 1.0 - 2.0**-10  # of what W leaves: so that something is left for the others


class Frames(NamedTuple):
    """Sets: boxes and frames, [n, d] and [n, d, d]."""

    boxes: Boxes
    centre: Float64
    matrix: Float64
    rest: Float64
    turned: Float64


def list_unread(system: System, claim: SystemClaim) -> list[str]:
    """The variables that each sample sets anew, and that neither a sample, an agent nor the claim reads."""
    if system.flow is None:
        return []
    flow = system.flow
    read = set(chain(flow.kept, flow.kept.values(), *flow.seen, *(each.values() for each in flow.seen)))
    read = read.union(*({name for name, _ in one.form.terms} for of in system.features.values() for one in of.values()))
    read = read.union(*map(names_of, chain.from_iterable((*claim.regions, *claim.assuming))))
    read = read.union(*(set(case.where).union(*map(names_of, case.when)) for case in flow.cases))
    read = read.union(*(names(jump) for each in flow.each for jump in each.jumps.values()))
    return [
        one.name for one in system.variables if one.name not in read and all(one.name in e.jumps for e in flow.each)
    ]


def turn_without(sets: Frames, unread: Sequence[int], where: str) -> Turned:
    """Sets without some of their variables. `where` is named in errors. InputError as `turn_sets`."""
    for at in sorted(unread, reverse=True):
        sets = _drop(sets, at, where)
    made = turn_sets(*sets, where)
    return made._replace(skew=np.array(list(map(_skew, sets.matrix, sets.rest, sets.turned)))) if unread else made


def _drop(sets: Frames, at: int, where: str) -> Frames:
    """Sets without a variable; those are left out whose centre is none of their states."""
    inside = (sets.boxes.low[:, at] <= sets.centre[:, at]) & (sets.centre[:, at] <= sets.boxes.high[:, at])
    if not inside.any():
        what = "what a sample sets anew is elsewhere in the sets of the proof than in the middle of their frames"
        raise InputError(what, where, "verify the claim from a smaller start")
    sets = Frames(sets.boxes.take(inside), *(of[inside] for of in sets[1:]))
    kept = [each for each in range(sets.centre.shape[1]) if each != at]
    boxes = Boxes(sets.boxes.low[:, kept], sets.boxes.high[:, kept])
    frames = [_drop_from_frame(sets, row, at, kept) for row in range(len(sets.centre))]
    matrix, rest, turned = (np.array(of) for of in zip(*frames, strict=True))
    return Frames(boxes, sets.centre[:, kept], matrix, rest, turned)


def _drop_from_frame(sets: Frames, row: int, at: int, kept: list[int]) -> tuple[Float64, Float64, Float64]:
    """A', Y and Q of a set without a variable; all 0 where there are none."""
    matrix, turned, rest = sets.matrix[row], sets.turned[row], sets.rest[row]
    columns = sorted(np.argsort(-np.abs(matrix[kept]).sum(axis=0), kind="stable").tolist()[: len(kept)])
    order, along = np.argsort(rest, kind="stable").tolist(), matrix[np.ix_(kept, columns)]
    share, shrunk = _share_box(sets, row, at, columns, [])
    moved = np.flatnonzero(np.abs(turned[at]) > LEAST).tolist()
    shares = {column: share if share >= MOST else _share_box(sets, row, at, columns, [column])[0] for column in moved}
    moving, split = [column for column in moved if shares[column] >= MOST], None
    if moving:
        ways = [turned[np.ix_(kept, [each for each in reversed(order) if each != column])] for column in moving]
        rests = [
            shares[column] * KEPT * rest[[each for each in reversed(order) if each != column]] for column in moving
        ]
        fits = [_fit(way, range(len(kept)), way, of) for way, of in zip(ways, rests, strict=True)]
        split = max((fit for fit in fits if fit), key=lambda fit: _measure_volume(fit[0]), default=None)
        if split is not None:
            return _thicken(along, *split)
    elif _measure_condition(along) <= CONDITION:
        along = along * shrunk
        split = _fit(turned, kept, turned[np.ix_(kept, order[: len(kept)])], KEPT * rest)
    return (0.0 * along, np.zeros(len(kept)), np.eye(len(kept))) if split is None else (along, *split)


def _share_box(sets: Frames, row: int, at: int, columns: list[int], gone: list[int]) -> tuple[float, float]:
    """Of what u may be off its centre: the share of the r that are not gone for which z leave room; and that of z
    without r.
    """
    low, high, centre = float(sets.boxes.low[row, at]), float(sets.boxes.high[row, at]), float(sets.centre[row, at])
    side = min(high - centre, centre - low) - 2.0**-50 * (abs(low) + abs(high) + abs(centre))
    along = float(np.abs(sets.matrix[row, at, columns]).sum())
    across = float(np.delete(np.abs(sets.turned[row, at]) * sets.rest[row], gone).sum())
    if along + across == 0.0:
        return float(low <= centre <= high), 1.0
    room = side - along - 2.0**-46 * (side + along)
    share = min(1.0, max(0.0, room) / across) if across > 0.0 else float(room >= 0.0)
    return share, min(1.0, max(0.0, side) / along * (1.0 - 2.0**-36)) if along > 0.0 else 1.0


def _measure_condition(matrix: Float64) -> float:
    """How much larger than itself what its rounding does to z may be."""
    try:
        return float((np.abs(np.linalg.inv(matrix)) @ np.abs(matrix)).sum(axis=1).max())
    except np.linalg.LinAlgError:
        return np.inf


def _fit(square: Float64, rows: Sequence[int], basis: Float64, rest: Float64) -> tuple[Float64, Float64] | None:
    """Y, and Q, which spans the columns of a basis one after the other. r is the inverse of a square matrix times
    Q y in some rows, and 0 in others. None where rounding hides too much of the inverse.
    """
    try:
        across, inverse = np.linalg.qr(basis)[0], np.linalg.inv(square)
    except np.linalg.LinAlgError:
        return None
    hidden = 2.0**-48 * np.abs(inverse) @ np.abs(square)
    off = float((np.abs(inverse @ square - np.eye(len(square))) + hidden).sum(axis=1).max())
    if max(off, float(np.abs(across.T @ across - np.eye(len(rows))).sum(axis=1).max())) > SHARE / 4.0:
        return None
    needs, sizes = np.abs(inverse[:, rows] @ across), np.abs(inverse[:, rows]) @ np.abs(across)
    needs += 2.0**-48 * sizes + 2.0 * off * sizes.max(axis=0)
    most = max(_list_bounds(needs, rest), key=_measure_volume) * KEPT
    return (most, across) if (needs @ most <= rest).all() else None


def _list_bounds(needs: Float64, rest: Float64) -> Iterator[Float64]:
    """Some Y with W Y <= R."""
    with np.errstate(divide="ignore", invalid="ignore"):
        shape = (rest[:, None] / needs).min(axis=0)
        whole = np.nan_to_num((rest / (needs @ shape)).min()) * shape
    for part, order in product((1.0, 0.5), islice(permutations(range(len(shape))), ORDERS)):
        most = part * whole
        left = rest - needs @ most
        for column in order:
            more = max(float((left / needs[:, column]).min()), 0.0) * GREEDY
            most[column] += more
            left = left - needs[:, column] * more
        yield most


def _measure_volume(most: Float64) -> float:
    """The logarithm, where sides of 0 have some width."""
    return float(np.log(most + TINY).sum())


def _thicken(matrix: Float64, most: Float64, across: Float64) -> tuple[Float64, Float64, Float64]:
    """A, or where it is flat about A + Q D with |D| 1 <= Y / 2; what is left of Y; and Q."""
    if not (most > 0.0).all():
        return matrix, most, across
    left, sides, right = np.linalg.svd((across.T @ matrix) / most[:, None])
    if sides.min() >= WIDE:
        return matrix, most, across
    wide = matrix + across @ (most[:, None] * (left @ right) / (2.0 * np.sqrt(len(most))))
    rounded = np.abs(across.T) @ (2.0**-48 * (np.abs(matrix) + np.abs(wide)))
    taken = (np.abs(across.T @ (wide - matrix)) + rounded).sum(axis=1)
    most = (most - taken - SHARE * taken.max()) * KEPT
    return (wide, most, across) if (most >= 0.0).all() else (0.0 * wide, 0.0 * most, across)


def _skew(matrix: Float64, rest: Float64, turned: Float64) -> Float64:
    """By how much z move for each that is put within its bounds, so that least is needed of the bounds of y."""
    skew = np.zeros_like(matrix)
    if not (rest > 0.0).all():
        return skew
    sides = (turned.T @ matrix) / rest[:, None]
    for column in range(len(rest)):
        others = [each for each in range(len(rest)) if each != column]
        skew[others, column] = np.linalg.lstsq(sides[:, others], sides[:, column], rcond=None)[0]
    return skew
