"""Boxes by the joint action that the agents choose in them.

Does: sends boxes down the trees of all agents, level by level; a box that meets both sides of a split goes both ways,
  cut at the split.
Assumes: the exact sides of splits, as systems/trees.py has them.
Does not: move boxes.

A joint action is one number: the actions of the agents are its digits, the first agent's the highest.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import inf
from typing import NamedTuple

import numpy as np

from codegen.ir import NO_FEATURE, AgentPolicy, Bool, Int64, splits
from verify.checker.covers.boxes import BoxList, together
from verify.checker.covers.cuts import Cut, end_of, opposite
from verify.checker.reading import RejectedError
from verify.checker.systems.trees import goes_left
from verify.claims.formula import TRUE, Formula, Linear, Or
from verify.systems.system import System

MANY = -1  # the column of a test of several variables


class _AtNodes(NamedTuple):
    """BoxList and the node that each is at."""

    boxes: BoxList
    node: Int64


class TreeCuts:
    """One agent's tree. Of a test of one variable `below` is the child of the low side, `above` that of the high one;
    `last` is the largest float on the low side, `first` the least one on the high side; `up`, `down` bound the end.

    A test for equality goes left on both sides of a number: it is two nodes, the second of them behind the whole tree.
    """

    def __init__(self, system: System, policy: AgentPolicy, columns: Mapping[str, int]) -> None:
        tree, features = policy.tree, system.features[policy.agent]
        sides = {
            node: goes_left(
                features[policy.features[int(tree.feature[node])].name], float(tree.threshold[node]), policy.numbers
            )
            for node in splits(tree)
        }
        twice = [node for node, side in sides.items() if isinstance(side, Or) and side.parts]
        count, own = len(tree.feature) + len(twice), len(tree.feature)
        self._action = np.append(tree.action, np.zeros(len(twice))).astype(np.int64)
        self._leaf: Bool = np.append(np.array(tree.feature) == NO_FEATURE, np.zeros(len(twice), dtype=np.bool_))
        self._column = np.full(count, MANY, dtype=np.int64)
        self._below = np.append(tree.left, [tree.left[node] for node in twice]).astype(np.int64)
        self._above = np.append(tree.right, [tree.right[node] for node in twice]).astype(np.int64)
        self._last, self._first, self._up, self._down = (np.zeros(count) for _ in range(4))
        self._cuts: dict[int, tuple[Cut, Cut]] = {}
        self.actions = len(policy.actions)
        for node, side in sides.items():
            if isinstance(side, Linear):
                self._test(node, side, columns)
            elif node not in twice:
                self._one_way(node, side == TRUE)
        for behind, node in enumerate(twice, own):
            self._above[node] = behind
            self._test_both(node, behind, sides[node], columns)

    def _one_way(self, node: int, left: bool) -> None:
        self._column[node] = 0
        self._last[node], self._first[node] = (inf, inf) if left else (-inf, -inf)
        self._up[node], self._down[node] = inf, -inf

    def _test_both(self, node: int, behind: int, left: Formula, columns: Mapping[str, int]) -> None:
        """A test that goes left where one of two inequalities holds."""
        for at, part in zip((node, behind), left.parts if isinstance(left, Or) else (), strict=True):
            if not isinstance(part, Linear):
                raise RejectedError("a test of a number that does not change")
            self._test(at, part, columns)

    def _test(self, node: int, left: Linear, columns: Mapping[str, int]) -> None:
        if len(left.terms) != 1:
            self._cuts[node] = Cut(left, columns), Cut(opposite(left), columns)
            return
        ((weight, name),) = left.terms
        end, strict = left.bound / weight, left.strict
        if weight < 0:  # the left side is the high one
            strict = not strict
            self._below[node], self._above[node] = self._above[node], self._below[node]
        low, high = end_of(end, strict), end_of(-end, not strict)
        self._column[node] = columns[name]
        self._last[node], self._up[node] = low.last, low.up
        self._first[node], self._down[node] = -high.last, -high.up

    def chosen(self, boxes: BoxList) -> BoxList:
        """The boxes, cut at the splits, each with this agent's action as one more digit of its joint action."""
        found, pending = [boxes.taken(slice(0, 0))], _AtNodes(boxes, np.zeros(boxes.size, dtype=np.int64))
        while len(pending.node):
            done = self._leaf[pending.node]
            leaves = pending.boxes.taken(done)
            found.append(leaves._replace(joint=leaves.joint * self.actions + self._action[pending.node[done]]))
            pending = self._next(_AtNodes(pending.boxes.taken(~done), pending.node[~done]))
        return together(found)

    def _next(self, here: _AtNodes) -> _AtNodes:
        """One level further down."""
        column = self._column[here.node]
        sides = [self._by_many(here, int(node)) for node in np.unique(here.node[column == MANY])]
        single = column != MANY
        sides.append(self._by_one(_AtNodes(here.boxes.taken(single), here.node[single]), column[single]))
        return _AtNodes(together([each.boxes for each in sides]), np.concatenate([each.node for each in sides]))

    def _by_many(self, here: _AtNodes, node: int) -> _AtNodes:
        boxes = here.boxes.taken(here.node == node)
        left, right = (cut.within(boxes) for cut in self._cuts[node])
        to = np.repeat([self._below[node], self._above[node]], [left.size, right.size])
        return _AtNodes(together([left, right]), to)

    def _by_one(self, here: _AtNodes, column: Int64) -> _AtNodes:
        rows, node = np.arange(len(here.node)), here.node
        low, high = here.boxes.low[rows, column], here.boxes.high[rows, column]
        in_below, in_above = ~(low > self._last[node]), ~(high < self._first[node])
        below, above = here.boxes.taken(in_below), here.boxes.taken(in_above)
        below.high[np.arange(below.size), column[in_below]] = np.minimum(high, self._up[node])[in_below]
        above.low[np.arange(above.size), column[in_above]] = np.maximum(low, self._down[node])[in_above]
        to = np.concatenate([self._below[node[in_below]], self._above[node[in_above]]])
        return _AtNodes(together([below, above]), to)


def decided(trees: Sequence[TreeCuts], boxes: BoxList) -> BoxList:
    """The boxes by the joint action that is chosen in them."""
    boxes = boxes._replace(joint=np.zeros(boxes.size, dtype=np.int64))
    for tree in trees:
        boxes = tree.chosen(boxes)
    return boxes


def digits(joint: int, trees: Sequence[TreeCuts]) -> tuple[int, ...]:
    """The action of each agent in a joint action."""
    found: list[int] = []
    for tree in reversed(trees):
        joint, action = divmod(joint, tree.actions)
        found.append(action)
    return tuple(reversed(found))
