"""A team in a stated system as arrays of float64: trees that send boxes to actions, and motions of boxes.

Does: one step of many boxes at once.
Assumes: a checked profile and system; nothing is rounded outward, since the checker reads and computes all again.
Does not: know claims. It shares no reading with the checker.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import inf, nextafter
from typing import NamedTuple

import numpy as np

from codegen.floats import FLOAT32
from codegen.ir import NO_FEATURE, AgentPolicy, Float64, Int64, PolicyProfile
from codegen.numbers import nearest_double, neighbour
from verify.boxes.leaf_cells import MAX_LEAVES, LeafCells, SingleTests
from verify.boxes.rows import Half, Rows, join_rows
from verify.systems.system import Affine, HalfSpace, Measure, Piece, Polytope, System

SEVERAL = -1  # the column of a test of several variables


class _NodeRows(NamedTuple):
    """Boxes, and the node of a tree at which each is."""

    rows: Rows
    node: Int64


class ModelTree:
    """One agent's tree: `_low` and `_high` are the children below and above the end of a test of one variable."""

    def __init__(self, system: System, policy: AgentPolicy, columns: Mapping[str, int]) -> None:
        tree = policy.tree
        self.actions = len(policy.actions)
        self.variables: set[str] = set()  # that are tested
        self._action, self._leaf = np.array(tree.action, dtype=np.int64), np.array(tree.feature) == NO_FEATURE
        self._low, self._high = np.array(tree.left, dtype=np.int64), np.array(tree.right, dtype=np.int64)
        self._column, self._end = np.zeros(len(tree.feature), dtype=np.int64), np.zeros(len(tree.feature))
        self._halves: dict[int, Half] = {}
        for node in np.flatnonzero(~self._leaf).tolist():
            feature = system.features[policy.agent][policy.features[int(tree.feature[node])].name]
            if feature.measure is Measure.EQUALS:
                self._equal(node, feature.form, float(tree.threshold[node]), columns)
                continue
            end = _end(float(tree.threshold[node]), policy.numbers)
            if feature.measure in (Measure.SIGN, Measure.POSITIVE):
                least = -1 if feature.measure is Measure.SIGN else 0
                threshold = float(tree.threshold[node])
                beside_0 = nextafter(0.0, -1.0 if threshold < 0 else 1.0)
                end = inf if threshold >= 1 else -inf if threshold < least else beside_0
            elif feature.measure is Measure.CLIP and feature.bounds is not None:
                least, most = map(nearest_double, feature.bounds)
                end = inf if end >= most else -inf if end < least else end
            self._test(node, feature.form, end, columns)
        tests = SingleTests(self._leaf, self._action, self._column, self._end, self._low, self._high)
        single = not self._halves and int(self._leaf.sum()) <= MAX_LEAVES
        self._cells = LeafCells(tests, len(columns)) if single else None

    def _equal(self, node: int, form: Affine, threshold: float, columns: Mapping[str, int]) -> None:
        """A test whether a form is 0: below 0, then above 0 by a node behind all others."""
        if not 0 <= threshold < 1 or not form.terms:
            self._end[node] = inf if threshold >= 1 or (threshold >= 0 and form.constant) else -inf
            return
        behind = len(self._leaf)
        self._leaf = np.append(self._leaf, False)
        self._action, self._column = np.append(self._action, 0), np.append(self._column, 0)
        self._end = np.append(self._end, 0.0)
        self._low, self._high = np.append(self._low, self._high[node]), np.append(self._high, self._low[node])
        self._high[node] = behind
        constant = nearest_double(form.constant)
        for at, end in ((node, nextafter(-constant, -inf)), (behind, -constant)):
            self._test(at, form, end + constant, columns)
            if self._column[at] != SEVERAL and form.terms[0][1] == 1:
                self._end[at] = end  # whatever the sum rounds to

    def _test(self, node: int, form: Affine, end: float, columns: Mapping[str, int]) -> None:
        if not form.terms or abs(end) == inf:
            left = end == inf or (end != -inf and nearest_double(form.constant) <= end)
            self._end[node] = inf if left else -inf
            return
        self.variables |= {name for name, _ in form.terms}
        end -= nearest_double(form.constant)
        weights = {columns[name]: nearest_double(factor) for name, factor in form.terms}
        weights = {column: weight for column, weight in weights.items() if weight}  # some are too small for a float
        if not weights:
            self._end[node] = inf if end >= 0 else -inf
            return
        if len(weights) > 1:
            self._column[node], self._halves[node] = SEVERAL, Half(weights, end)
            return
        ((self._column[node], weight),) = weights.items()
        self._end[node] = end / weight
        if weight < 0:
            self._low[node], self._high[node] = self._high[node], self._low[node]

    def split_at_tests(self, rows: Rows) -> Rows:
        """The boxes cut at the tests, with the action as one more digit of the joint one."""
        if self._cells is not None:
            return self._cells.split_at_leaves(rows, self.actions)
        parts, here = [rows.at(np.zeros(0, dtype=np.int64))], _NodeRows(rows, np.zeros(rows.size, dtype=np.int64))
        while len(here.node):
            leaf = self._leaf[here.node]
            done = here.rows.at(leaf)
            parts.append(done._replace(joint=done.joint * self.actions + self._action[here.node[leaf]]))
            here = self._below(_NodeRows(here.rows.at(~leaf), here.node[~leaf]))
        return join_rows(parts)

    def _below(self, here: _NodeRows) -> _NodeRows:
        column = self._column[here.node]
        one = column != SEVERAL
        rows, node, column, place = here.rows.at(one), here.node[one], column[one], np.arange(int(one.sum()))
        end = self._end[node]
        low, high = rows.low[place, column], rows.high[place, column]
        down = (low <= end) & ~((low == end) & (high > end))
        up = high > end
        left, right = rows.at(down), rows.at(up)
        left.high[np.arange(left.size), column[down]] = np.minimum(high, end)[down]
        right.low[np.arange(right.size), column[up]] = np.maximum(low, end)[up]
        sides, nodes = [left, right], [self._low[node[down]], self._high[node[up]]]
        for each in np.unique(here.node[~one]).tolist():
            boxes = here.rows.at(here.node == each)
            for half, to in (
                (self._halves[each], self._low[each]),
                (self._halves[each].opposite(), self._high[each]),
            ):
                sides.append(half.of(boxes))
                nodes.append(np.full(sides[-1].size, to))
        return _NodeRows(join_rows(sides), np.concatenate(nodes))


def _end(threshold: float, numbers: str) -> float:
    """About where numbers begin to round to more than a threshold."""
    if numbers != FLOAT32:
        return threshold
    return (threshold + float(neighbour(np.float32(threshold), inf))) / 2


class _Moves(NamedTuple):
    """A joint action's effect in a piece: [d, d] factors, and bounds of what is added, [d], or of each box, [n, d]."""

    matrix: Float64
    low: Float64
    high: Float64


class Model:
    """A team in a system."""

    def __init__(self, profile: PolicyProfile, system: System) -> None:
        self.names = [one.name for one in system.variables]
        self.columns = {name: column for column, name in enumerate(self.names)}
        self.trees = [ModelTree(system, policy, self.columns) for policy in profile.agents]
        self._policies, self._pieces = profile.agents, system.pieces
        self._where = [
            [
                (self.columns[name], nearest_double(low), nearest_double(high))
                for name, (low, high) in piece.where.items()
            ]
            for piece in system.pieces
        ]
        self._when = [list(map(self._strict_half, piece.when)) for piece in system.pieces]
        self._known: dict[tuple[int, int], _Moves] = {}

    def region(self, polytope: Polytope) -> list[Half]:
        """A polytope as inequalities."""
        return [self._half(half) for half in polytope]

    def _half(self, half: HalfSpace) -> Half:
        weights = {self.columns[name]: nearest_double(factor) for name, factor in half.form.terms}
        return Half(weights, -nearest_double(half.form.constant))

    def _strict_half(self, half: HalfSpace) -> Half:
        """A half space, the open ones without the float on their border."""
        weights = {self.columns[name]: nearest_double(factor) for name, factor in half.form.terms}
        end = -nearest_double(half.form.constant)
        return Half(weights, nextafter(end, -inf) if half.strict else end)

    def step_boxes(self, rows: Rows) -> Rows:
        """The boxes after a step."""
        rows = rows._replace(joint=np.zeros(rows.size, dtype=np.int64))
        for tree in self.trees:
            rows = tree.split_at_tests(rows)
        if not rows.size:
            return rows
        least, most = rows.low.min(axis=0), rows.high.max(axis=0)
        parts: list[Rows] = [rows.at(np.zeros(0, dtype=np.int64))]
        for number, where in enumerate(self._where):
            if all(most[column] >= low and least[column] <= high for column, low, high in where):
                inside = _inside(rows, where)
                for half in self._when[number]:
                    inside = half.of(inside)
                parts.append(self._move_boxes(inside, number))
        return join_rows(parts)

    def _move_boxes(self, rows: Rows, number: int) -> Rows:
        if not rows.size:
            return rows
        joints, of = np.unique(rows.joint, return_inverse=True)
        moves = [self._by(number, int(joint)) for joint in joints]
        if all(np.array_equal(each.matrix, moves[0].matrix) for each in moves):  # actions add numbers alone
            low, high = np.array([each.low for each in moves]), np.array([each.high for each in moves])
            return self._shift_boxes(rows, _Moves(moves[0].matrix, low[of], high[of]))
        return join_rows([self._shift_boxes(rows.at(of == place), each) for place, each in enumerate(moves)])

    def _by(self, number: int, joint: int) -> _Moves:
        if (number, joint) not in self._known:
            self._known[number, joint] = self._moves(self._pieces[number], joint)
        return self._known[number, joint]

    @staticmethod
    def _shift_boxes(rows: Rows, moves: _Moves) -> Rows:
        up, down = np.maximum(moves.matrix, 0.0).T, np.minimum(moves.matrix, 0.0).T
        low = rows.low @ up + rows.high @ down + moves.low
        high = rows.high @ up + rows.low @ down + moves.high
        return rows._replace(low=low, high=high)

    def _moves(self, piece: Piece, joint: int) -> _Moves:
        forms = dict(piece.move)
        for policy, tree in zip(reversed(self._policies), reversed(self.trees), strict=True):
            joint, action = divmod(joint, tree.actions)
            for name, added in piece.effect.get((policy.agent, policy.actions[action].name), {}).items():
                forms[name] = forms[name].plus(added)
        size = len(self.names)
        matrix, low, high = np.zeros((size, size)), np.zeros(size), np.zeros(size)
        for name, form in forms.items():
            row = self.columns[name]
            for read, factor in form.terms:
                matrix[row, self.columns[read]] = nearest_double(factor)
            error = piece.error.get(name, (0, 0))
            low[row], high[row] = (nearest_double(form.constant + each) for each in error)
        return _Moves(matrix, low, high)


def _inside(rows: Rows, where: list[tuple[int, float, float]]) -> Rows:
    if not where:
        return rows
    met = np.ones(rows.size, dtype=np.bool_)
    for column, low, high in where:
        met &= (rows.high[:, column] >= low) & (rows.low[:, column] <= high)
    overlap = rows.at(met)
    for column, low, high in where:
        overlap.low[:, column] = np.maximum(overlap.low[:, column], low)
        overlap.high[:, column] = np.minimum(overlap.high[:, column], high)
    return overlap
