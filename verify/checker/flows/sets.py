"""Lists of sets that a flow moves: boxes with frames, cut by trees and regions, joined in cells.

Does: the data of a list; narrows sets to boxes within them; joins them.
Assumes: covers/boxes.py, and frames as steps.py has them.
Does not: know flows, trees or claims.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from codegen.ir import Bool, Float64, Int64
from verify.checker.covers.boxes import BoxList, in_cells
from verify.checker.flows.spans import Spans, round_up
from verify.checker.flows.steps import Frame, build_frames, orthogonalise_rest


class SetList(NamedTuple):
    """Sets: `box` [n, variables]; `frames` that hold them too; `part` [n], of the start that each comes from; `joint`
    [n], the number of the joint action that is held.
    """

    box: Spans
    frames: tuple[Frame, ...]
    part: Int64
    joint: Int64

    @property
    def size(self) -> int:
        """The number of sets."""
        return len(self.part)

    def take(self, which: Bool | Int64) -> SetList:
        """Some of them."""
        frames = tuple(frame.at(which) for frame in self.frames)
        return SetList(self.box.at(which), frames, self.part[which], self.joint[which])

    @property
    def numbered(self) -> BoxList:
        """The boxes, each with the number of its set for a part."""
        return BoxList.of(self.box.low, self.box.high, np.arange(self.size), self.joint)

    def narrow_to(self, boxes: BoxList) -> SetList:
        """The sets in which boxes lie that were cut from `numbered`, narrowed to these."""
        sources = self.take(boxes.part)
        box = Spans(boxes.low, boxes.high)
        cut = np.asarray(((box.low > sources.box.low) | (box.high < sources.box.high)).any(axis=1))
        frames = tuple(_cut(frame, box, cut) for frame in sources.frames)
        return SetList(box, frames, sources.part, boxes.joint)

    def join_by_cell(self, widths: Mapping[int, float]) -> SetList:
        """Boxes around the sets, one for each cell and part of the start that has some."""
        boxes = in_cells(BoxList.of(self.box.low, self.box.high, self.part, self.joint), widths)
        return build_sets(boxes, 0)


def build_sets(boxes: BoxList, kept: int) -> SetList:
    """Boxes as sets, with `kept` frames."""
    box = Spans(boxes.low, boxes.high)
    return SetList(box, tuple(build_frames(box) for _ in range(kept)), boxes.part, boxes.joint)


def beside(lists: Sequence[SetList]) -> SetList:
    """The sets of some lists in one."""
    if len(lists) == 1:
        return lists[0]
    box = Spans(*(np.concatenate(ends) for ends in zip(*(each.box for each in lists), strict=True)))
    frames = tuple(
        Frame(*map(np.concatenate, zip(*of, strict=True))) for of in zip(*(e.frames for e in lists), strict=True)
    )
    part, joint = (np.concatenate([each[at] for each in lists]) for at in (2, 3))
    return SetList(box, frames, part, joint)


def _cut(frame: Frame, box: Spans, cut: Bool) -> Frame:
    """The frames without those z whose states lie outside the boxes; `cut`: where boxes are less than before.

    Of row i, A_ij z_j = x_i - c_i - (all other terms) - (B r)_i, whose bounds give bounds of z_j.
    """
    if not cut.any():
        return frame
    centre, matrix = frame.centre.copy(), frame.matrix.copy()
    of, size = np.flatnonzero(cut), centre.shape[1]
    c, a, rest = centre[of], matrix[of], frame.loose[of]
    low, high = -np.ones((len(of), size)), np.ones((len(of), size))
    for row in range(size):
        down, up = _beside(box.low[of, row] - c[:, row], -1.0), _beside(box.high[of, row] - c[:, row], 1.0)
        for column in range(size):
            factor = a[:, row, column]
            others = round_up(np.abs(np.delete(a[:, row], column, axis=1)).sum(axis=1) + rest[:, row])
            least, most = _beside(down - others, -1.0), _beside(up + others, 1.0)
            with np.errstate(all="ignore"):
                ends = least / factor, most / factor
            known = np.abs(factor) > 1e-200
            low[:, column] = np.where(
                known, np.maximum(low[:, column], _beside(np.minimum(*ends), -1.0)), low[:, column]
            )
            high[:, column] = np.where(
                known, np.minimum(high[:, column], _beside(np.maximum(*ends), 1.0)), high[:, column]
            )
    high = np.maximum(low, high)  # what is empty may be any one point
    return _rescale_frame(frame, of, low, high)


def _beside(values: Float64, way: float) -> Float64:
    """A little further: more than a sum or a quotient of two floats is off by."""
    return values + way * (2.0**-50 * np.abs(values) + 2.0**-1000)


def _rescale_frame(frame: Frame, of: Int64, low: Float64, high: Float64) -> Frame:
    """Frames with z in [low, high], as frames with z in [-1, 1]."""
    middle = 0.5 * low + 0.5 * high
    radius = np.maximum(high - middle, middle - low) * (1.0 + 2.0**-50)
    centre, matrix, rest, turned = (each.copy() for each in frame)
    moved = np.matmul(matrix[of], middle[:, :, None])[:, :, 0]
    size = centre.shape[1]
    off = (
        np.matmul(np.abs(matrix[of]), (np.abs(middle) + radius)[:, :, None])[:, :, 0]
        + np.abs(centre[of])
        + np.abs(moved)
    )
    centre[of] += moved
    matrix[of] *= radius[:, None, :]
    turned[of], rest[of] = orthogonalise_rest(turned[of], rest[of], round_up((size + 4) * 2.0**-52 * off))
    return Frame(centre, matrix, rest, turned)
