"""Boxes by the joint action that the agents choose in them.

Does: looks up which leaves a box meets by tests of single variables, and cuts it at them; at a test of several
  variables it goes both ways, cut at each.
Assumes: the exact sides of splits, as systems/trees.py has them; leaves.py.
Does not: move boxes.

A joint action is one number: the actions of the agents are its digits, the first agent's the highest.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from typing import Protocol, TypeAlias, TypeVar

import numpy as np

from codegen.ir import NO_FEATURE, ROOT, AgentPolicy, Int64, splits
from verify.checker.covers.boxes import BoxList, together
from verify.checker.covers.cuts import BoundLine, Cut, half_line, opposite
from verify.checker.covers.leaves import LeafWays, WayDown
from verify.checker.reading import RejectedError
from verify.checker.systems.trees import goes_left
from verify.claims.formula import TRUE, Formula, Linear, Or
from verify.systems.system import System

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
        parts = [each for each in _parts(goes_left) if isinstance(each, Linear)]
        if len(parts) < len(_parts(goes_left)):
            raise RejectedError("a test of a number that does not change")
        lines = [line for line in (half_line(each, self._columns) for each in parts) if line is not None]
        if len(lines) == len(parts):
            self._lines[node] = _sides([(line, line.opposite) for line in lines], left, right)
        else:
            cuts = [(Cut(each, self._columns), Cut(opposite(each), self._columns)) for each in parts]
            self._cuts[node] = _sides(cuts, left, right)

    @property
    def actions(self) -> int:
        """The number of the agent's actions."""
        return self._actions

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
        at_leaves, pending = list[BoxList](), [(ROOT, boxes)]
        while pending:
            node, boxes = pending.pop()
            if node in self._lines:
                boxes, at = self._leaves(node).split_at_leaves(boxes)
                done = self._leaf.take(at)
                if done.all():
                    at_leaves.append(self._add_action(boxes, at))
                    continue
                at_leaves.append(self._add_action(boxes.take(done), at[done]))
                pending += [(split, boxes.take(at == split)) for split in np.unique(at[~done]).tolist()]
            elif node in self._cuts:
                pending += [(to, _within(cuts, boxes)) for cuts, to in self._cuts[node]]
            else:
                at_leaves.append(self._add_action(boxes, np.full(boxes.size, node)))
        return together(at_leaves)

    def _add_action(self, boxes: BoxList, leaf: Int64) -> BoxList:
        return boxes._replace(joint=boxes.joint * self._actions + self._action.take(leaf))

    def _leaves(self, root: int) -> LeafWays:
        """The ways down from a node by tests of single variables."""
        if root not in self._cells:
            self._cells[root] = LeafWays(self._ways(root))
        return self._cells[root]

    def _ways(self, root: int) -> list[WayDown]:
        """These ways, to leaves and other tests; to any test once there are many."""
        ways, pending = list[WayDown](), deque([WayDown.begin(2 * len(self._columns), root)])
        while pending:
            way = pending.popleft()
            if way.node not in self._lines or len(pending) >= MAX_WAYS:
                ways.append(way)
            else:
                further = [way.on(lines, to) for lines, to in self._lines[way.node]]
                pending += [each for each in further if each is not None]
        return ways


def _parts(goes_left: Formula) -> Sequence[Formula]:
    return goes_left.parts if isinstance(goes_left, Or) else (goes_left,)


def _within(cuts: Sequence[Cut], boxes: BoxList) -> BoxList:
    for cut in cuts:
        boxes = cut.within(boxes)
    return boxes


class Chooses(Protocol):
    """Something that sends boxes down the tree of an agent."""

    @property
    def actions(self) -> int:
        """The number of the agent's actions."""
        ...

    def split_at_tests(self, boxes: BoxList) -> BoxList:
        """The boxes, each with this agent's action as one more digit of its joint action."""
        ...


def split_by_trees(trees: Sequence[Chooses], boxes: BoxList) -> BoxList:
    """The boxes by the joint action that is chosen in them."""
    boxes = boxes._replace(joint=np.zeros(boxes.size, dtype=np.int64))
    for tree in trees:
        boxes = tree.split_at_tests(boxes)
    return boxes


def digits(joint: int, trees: Sequence[Chooses]) -> tuple[int, ...]:
    """The action of each agent in a joint action."""
    actions: list[int] = []
    for tree in reversed(trees):
        joint, action = divmod(joint, tree.actions)
        actions.append(action)
    return tuple(reversed(actions))
