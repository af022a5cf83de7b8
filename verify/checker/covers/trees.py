"""Boxes by the joint action that the agents choose in them.

Does: looks up for all boxes at once which leaves each meets by tests of single variables, and cuts it at them; at a
  test of several variables a box goes both ways, cut at each.
Assumes: the exact sides of splits, as systems/reading.py has them; half lines as boxes.py has them.
Does not: move boxes.

All bounds are bounds from below, of variables and of their negatives (`BoxList.bounds`). A way down asks that some are
at most `last`, the largest float of a half line; what is met is cut at `first`, a float beyond the end of the half line
that looks the other way. A box meets an end if none of its bounds exceeds `last`. So the ends that a single bound
leaves are a row of bits, found by its place among all `last`, and the ends that a box meets are what its rows share.

A joint action is one number: the actions of the agents are its digits, the first agent's the highest.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from math import inf
from typing import NamedTuple, Protocol, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from codegen.ir import NO_FEATURE, ROOT, AgentPolicy, Bool, Float64, Int64, splits
from verify.checker.covers.boxes import (
    FEW,
    BoundLine,
    BoxList,
    Cut,
    alike,
    half_line,
    least_of_runs,
    opposite,
    round_bounds,
    together,
    unit_of,
)
from verify.checker.reading import RejectedError
from verify.checker.systems.reading import alternatives, goes_left
from verify.claims.formula import TRUE, Formula, Linear
from verify.systems.system import System

AT_ONCE = 1 << 24  # pairs of a box and an end
COMPARED = 32  # ways to which all boxes are compared, since that is as fast for so few
GROWN = 1.25  # times as many boxes in leaves as were left when they were last joined: they are joined again
Bits = NDArray[np.uint64]


class WayDown(NamedTuple):
    """A way down: bounds that may not be exceeded and those at which is cut, by column; the node at its end."""

    last: list[float]
    first: list[float]
    node: int

    @classmethod
    def begin(cls, columns: int, node: int) -> WayDown:
        """The way to a node at which all begins."""
        return cls([inf] * columns, [-inf] * columns, node)

    def on(self, lines: Sequence[BoundLine], node: int) -> WayDown | None:
        """The way on to a node, where some half lines hold; None where no state meets all."""
        last, first = list(self.last), list(self.first)
        for near, far, end, _ in lines:
            last[near], first[far] = min(last[near], end.last), max(first[far], -end.up)
            if first[near] > last[near] or first[far] > last[far]:
                return None
        return WayDown(last, first, node)


class _Column(NamedTuple):
    """One column of bounds: all `last` of ways in it, in order; by how many of these a bound exceeds, the ways left."""

    ends: Float64
    left: Bits  # [ends + 1, words]


class LeafWays:
    """Some ways down from one node."""

    def __init__(self, ways: Sequence[WayDown]) -> None:
        self._last, self._first = np.array([way.last for way in ways]), np.array([way.first for way in ways])
        self.node = np.array([way.node for way in ways])
        self.forget()

    def forget(self) -> None:
        """Has the next boxes split as if none had been before."""
        self._least = 0  # boxes in leaves since they were last joined

    def may_meet(self, least: Float64) -> bool:
        """Returns False if no box meets a way, of those whose bounds are at least so large."""
        return bool((~(least > self._last)).all(axis=1).any())

    def cut_boxes(self, boxes: BoxList) -> tuple[BoxList, Int64]:
        """The boxes cut at the ends of the ways that they meet, and the number of the way of each. RejectedError for a
        bound that is no number.
        """
        by_column = np.ascontiguousarray(boxes.bounds.T)
        least, most = by_column.min(axis=1, initial=inf), by_column.max(axis=1, initial=-inf)
        if np.isnan(least).any():
            raise RejectedError("a box has bounds that are not finite")
        box, way = self._pairs(by_column, least, most)
        bounds = np.maximum(boxes.bounds.take(box, axis=0), self._first.take(way, axis=0))
        return BoxList(bounds, boxes.part.take(box), boxes.joint.take(box)), way

    def split_at_leaves(self, boxes: BoxList) -> tuple[BoxList, Int64]:
        """The boxes cut at the ends of the ways that they meet, those that others all but hold joined with these, and
        the node at each end. RejectedError as of `cut_boxes`.
        """
        (bounds, part, joint), way = self.cut_boxes(boxes)
        self._least = min(self._least, len(way))
        if len(way) >= max(FEW, GROWN * self._least):
            unit = unit_of(boxes.bounds.min(axis=0), boxes.bounds.max(axis=0))
            at_end = bounds == self._first.take(way, axis=0)
            kept, bounds = _join_nested(bounds, at_end, [way, part, joint], unit)
            way, part, joint, self._least = way.take(kept), part.take(kept), joint.take(kept), len(kept)
        return BoxList(bounds, part, joint), self.node.take(way)

    @cached_property
    def _columns(self) -> list[_Column]:
        return [_column(last) for last in self._last.T]

    def _pairs(self, by_column: Float64, least: Float64, most: Float64) -> tuple[Int64, Int64]:
        """Returns the numbers of boxes and ways that meet, pair by pair. `least`, `most`: bounds of each column."""
        count = by_column.shape[1]
        reached: Bool = np.asarray((least <= self._last).all(axis=1), dtype=np.bool_)  # no box meets another way
        ways = np.flatnonzero(reached)
        last = self._last.take(ways, axis=0)
        columns = np.flatnonzero((last < most).any(axis=0)).tolist()  # in all others each box meets each of the ways
        if len(ways) <= COMPARED:
            met = np.ones((len(ways), count), dtype=np.bool_)
            for column in columns:
                met &= by_column[column] <= last[:, column, None]
            at, box = np.divmod(np.flatnonzero(met), max(count, 1))
            return box, ways.take(at)
        # A pair's number is that of the box times the number of ways, and the way's.
        at_once, row, pairs = max(AT_ONCE // len(self.node), 1), _pack_flags(reached[None]), list[Int64]()
        for at in range(0, max(count, 1), at_once):
            some = by_column[:, at : at + at_once]
            common: Bits = np.repeat(row, some.shape[1], axis=0)
            for column in columns:
                ends, left = self._columns[column]
                own: Float64 = some[column]
                common &= left.take(np.searchsorted(ends, own), axis=0)
            flags = np.unpackbits(common.view(np.uint8), axis=1, count=len(self.node), bitorder="little")
            pairs.append(np.flatnonzero(flags.view(np.bool_)) + at * len(self.node))
        return np.divmod(np.concatenate(pairs), len(self.node))


def _column(last: Float64) -> _Column:
    ends = np.unique(last)
    return _Column(ends, _pack_flags(np.searchsorted(ends, last) >= np.arange(len(ends) + 1)[:, None]))


def _pack_flags(flags: Bool) -> Bits:
    """Rows of flags as words."""
    padded = np.zeros((len(flags), -(-flags.shape[1] // 64) * 64), dtype=np.bool_)
    padded[:, : flags.shape[1]] = flags
    return np.packbits(padded, axis=1, bitorder="little").view(np.uint64)


def _join_nested(bounds: Float64, at_end: Bool, kinds: Sequence[Int64], unit: Float64) -> tuple[Int64, Float64]:
    """The numbers of some boxes, and bounds in which these hold all states of a list of boxes in leaves, where those of
    one kind became one of which one all but holds the others. `at_end`: which bounds are those of the leaf; `unit`: by
    how much of a column this may lose.

    Rounding outward makes slivers at the ends of leaves. Two boxes that reach the end of their leaf, and are alike but
    for the bound on the other side, lie in each other. So that bound is left out of the hash by which they are found.
    Whatever is joined, what is around it holds its states; that one box all but does is asked to lose nothing else.
    """
    size = bounds.shape[1] // 2
    rows = round_bounds(bounds, unit) * ~np.concatenate([at_end[:, size:], at_end[:, :size]], axis=1)
    order, begins = alike(rows, kinds)
    if len(begins) == len(order):
        return np.arange(len(order)), bounds
    bounds, counts = bounds.take(order, axis=0), np.diff(begins, append=len(order))
    around = np.repeat(least_of_runs(bounds, begins), counts, axis=0)
    holds = np.logical_or.reduceat((bounds - around <= unit).all(axis=1), begins)
    alone = np.repeat(~holds, counts)
    first = np.zeros(len(order), dtype=np.bool_)
    first[begins] = True
    kept = np.flatnonzero(alone | first)
    joined = np.where(alone.take(kept)[:, None], bounds.take(kept, axis=0), around.take(kept, axis=0))
    return order.take(kept), joined


MAX_WAYS = 4_096  # down from one node that are looked up together


T = TypeVar("T", BoundLine, Cut)
Sides: TypeAlias = list[tuple[list[T], int]]  # of a split: what holds there, and the node to which it leads


def _sides(tests: Sequence[tuple[T, T]], left: int, right: int) -> Sides[T]:
    """The sides of a split that goes left where one of some tests holds: each test beyond those before it, and what
    lies beyond all. `tests`: each with its opposite.
    """
    sides: Sides[T] = []
    beyond: list[T] = []
    for test, otherwise in tests:
        sides.append(([*beyond, test], left))
        beyond = [*beyond, otherwise]
    return [*sides, (beyond, right)]


class TreeCuts:
    """One agent's tree."""

    def __init__(self, system: System, policy: AgentPolicy, columns: Mapping[str, int]) -> None:
        tree, features = policy.tree, system.features[policy.agent]
        self._action, self._leaf = np.array(tree.action, dtype=np.int64), np.array(tree.feature) == NO_FEATURE
        self._columns, self._actions = columns, len(policy.actions)
        self._lines: dict[int, Sides[BoundLine]] = {}  # of splits that test single variables
        self._cuts: dict[int, Sides[Cut]] = {}  # of all others
        self._cells: dict[int, LeafWays] = {}
        for node in splits(tree):
            feature = features[policy.features[int(tree.feature[node])].name]
            left = goes_left(feature, float(tree.threshold[node]), policy.numbers)
            self._split(node, left, int(tree.left[node]), int(tree.right[node]))

    def _split(self, node: int, goes_left: Formula, left: int, right: int) -> None:
        if goes_left == TRUE:
            self._lines[node] = [([], left)]
            return
        parts = [each for each in alternatives(goes_left) if isinstance(each, Linear)]
        if len(parts) < len(alternatives(goes_left)):
            raise RejectedError("a test of a number that does not change")
        lines = [line for line in (half_line(each, self._columns) for each in parts) if line is not None]
        if len(lines) == len(parts):
            self._lines[node] = _sides([(line, line.opposite) for line in lines], left, right)
        else:
            cuts = [(Cut(each, self._columns), Cut(opposite(each), self._columns)) for each in parts]
            self._cuts[node] = _sides(cuts, left, right)

    @property
    def several(self) -> bool:
        """True if the tree tests several variables at once, by which boxes are cut into pieces that nothing joins."""
        return bool(self._cuts)

    def forget(self) -> None:
        """Has the next boxes cut as if none had been before."""
        for ways in self._cells.values():
            ways.forget()

    def split_at_tests(self, boxes: BoxList) -> BoxList:
        """The boxes, cut at the splits, each with this agent's action as one more digit of its joint action."""
        at_leaves, pending = [boxes.take(slice(0, 0))], [(ROOT, boxes)]
        while pending:
            node, boxes = pending.pop()
            if not boxes.size:
                continue
            if node in self._lines:
                boxes, at = self._leaves(node).split_at_leaves(boxes)
                done = self._leaf.take(at)
                if done.all():
                    at_leaves.append(self._add_action(boxes, at))
                    continue
                at_leaves.append(self._add_action(boxes.take(done), at[done]))
                pending += [(split, boxes.take(at == split)) for split in np.unique(at[~done]).tolist()]
            elif node in self._cuts:
                pending += [(to, meet_all(cuts, boxes)) for cuts, to in self._cuts[node]]
            else:
                at_leaves.append(self._add_action(boxes, np.full(boxes.size, node)))
        return together(at_leaves)

    def _add_action(self, boxes: BoxList, leaf: Int64) -> BoxList:
        return boxes._replace(joint=boxes.joint * self._actions + self._action.take(leaf))

    def _leaves(self, root: int) -> LeafWays:
        """The ways down from a node by tests of single variables."""
        if root not in self._cells:
            ways, pending = list[WayDown](), deque([WayDown.begin(2 * len(self._columns), root)])
            while pending:
                way = pending.popleft()
                if way.node not in self._lines or len(pending) >= MAX_WAYS:  # to any test once there are many
                    ways.append(way)
                else:
                    further = [way.on(lines, to) for lines, to in self._lines[way.node]]
                    pending += [each for each in further if each is not None]
            self._cells[root] = LeafWays(ways)
        return self._cells[root]


def meet_all(cuts: Sequence[Cut], boxes: BoxList) -> BoxList:
    """Boxes around the states that may meet some inequalities."""
    for cut in cuts:
        boxes = cut.within(boxes)
    return boxes


class Chooses(Protocol):
    """Something that sends boxes down the tree of an agent."""

    def split_at_tests(self, boxes: BoxList) -> BoxList:
        """The boxes, each with this agent's action as one more digit of its joint action."""
        ...


def split_by_trees(trees: Sequence[Chooses], boxes: BoxList) -> BoxList:
    """The boxes by the joint action that is chosen in them."""
    boxes = boxes._replace(joint=np.zeros(boxes.size, dtype=np.int64))
    for tree in trees:
        boxes = tree.split_at_tests(boxes)
    return boxes


def choices_of(joint: int, policies: Sequence[AgentPolicy]) -> list[tuple[str, str]]:
    """The action of each agent in a joint action, by names."""
    chosen: list[tuple[str, str]] = []
    for policy in reversed(policies):
        joint, action = divmod(joint, len(policy.actions))
        chosen.append((policy.agent, policy.actions[action].name))
    return chosen[::-1]


class PairNumbers:
    """Numbers of the pairs of a piece and a joint action that were met, from 0 in the order in which they were."""

    def __init__(self, pieces: int) -> None:
        self._joints = np.zeros(0, dtype=np.int64)  # that were met, in order
        self._numbers = np.zeros((pieces, 0), dtype=np.int64)  # [pieces, joints], -1 for a pair that was not met
        self._count = 0

    def find(self, piece: Int64, joint: Int64, add: Callable[[Sequence[tuple[int, int]]], None]) -> Int64:
        """The numbers of pairs, [n]. `add` is told of those that are new, in their order."""
        at = np.searchsorted(self._joints, joint)
        if not (len(self._joints) and (self._joints.take(at, mode="clip") == joint).all()):
            before, known = self._joints, self._numbers
            self._joints = np.union1d(before, joint)
            self._numbers = np.full((len(known), len(self._joints)), -1)
            self._numbers[:, np.searchsorted(self._joints, before)] = known
            at = np.searchsorted(self._joints, joint)
        numbers = self._numbers[piece, at]
        if (numbers < 0).any():
            new = sorted(set(zip(piece[numbers < 0].tolist(), at[numbers < 0].tolist(), strict=True)))
            self._numbers[tuple(zip(*new, strict=True))] = np.arange(self._count, self._count + len(new))
            self._count += len(new)
            add([(number, int(self._joints[place])) for number, place in new])
            numbers = self._numbers[piece, at]
        return numbers
