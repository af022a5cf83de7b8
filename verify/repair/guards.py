"""Guards: small trees that keep an agent engaged with one landmark wherever a leaf, or a part of its tree, decides.

Does: finds the cheapest guard of a node, with tests on the agent's own offset to the landmark, by dynamic programming
  over the rectangles of a grid.
Assumes: the agent observes its offset to the landmark on both axes; a radius above the margin.
Does not: decide which nodes need one (search.py), or prove the team (zones/engine.py does, afterwards).

A rectangle of offsets is safe for an action iff its points on which the action does not close all lie at the landmark.
Intervals are the exact ones of the deployed arithmetic, taken closed, so that safe here means safe there.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple, TypeAlias

import numpy as np

from codegen.boxes import box_of, leaves_below
from codegen.errors import InputError
from codegen.ir import NO_FEATURE, ActionSpec, AgentPolicy, Float64, Floats, Int32, Tree
from codegen.numbers import round_down
from codegen.paths import in_preorder
from verify.checker.thresholds import sides
from verify.claims.decisions import DecisionClaim
from verify.claims.formula import Linear
from verify.claims.region import Interval, Region
from verify.question import DecisionQuestion

PRICE = 1e-3  # of a further leaf, in shares of states whose action changes
UNLIMITED = -1  # levels
SMALLEST = float(np.finfo(np.float32).tiny)  # of the normal numbers; smaller thresholds are refused


class GuardCost(NamedTuple):
    """The cost of a guard: changed weight with the price of its leaves, then the progress that is lost."""

    price: float
    lost: float

    def __add__(self, other: "GuardCost") -> "GuardCost":  # type: ignore[override]
        return GuardCost(self.price + other.price, self.lost + other.lost)


@dataclass(frozen=True)
class Guard:
    """The tree that stands in the place of a node, and of all below it."""

    agent: str
    node: int  # of the tree before: a leaf, unless the depth asked for one of the splits above
    landmark: str
    tree: Tree
    changed: float  # share of the weighted states in which the action changes
    levels: int  # splits on its longest path


class Post(NamedTuple):
    """The purpose of a guard: a node, and the landmark with which its agent is to stay engaged."""

    policy: AgentPolicy
    node: int
    landmark: str


@dataclass(frozen=True)
class Seen:
    """States to weigh by, as one agent observes them."""

    rows: Floats  # [n, n_features]
    weight: Float64  # [n], of sum 1
    leaf: Int32  # [n] of the tree before


def offset_features(policy: AgentPolicy, landmark: str) -> tuple[int, int]:
    """The features that are the landmark's offset from the agent on x and y. InputError when it has none."""
    columns: list[int] = []
    for axis in "xy":
        wanted = {(1, f"{landmark}.{axis}"), (-1, f"{policy.agent}.{axis}")}
        for place, feature in enumerate(policy.features):
            meaning = feature.meaning
            if meaning is not None and not meaning.function and set(meaning.terms) == wanted:
                columns.append(place)
                break
        else:
            what = f"{policy.agent} does not observe its offset to {landmark} on {axis}"
            raise InputError(what, "", "guards test that offset: repair a team that observes it")
    return columns[0], columns[1]


def guard(question: DecisionQuestion, post: Post, seen: Seen, max_levels: int | None = None) -> Guard | None:
    """The cheapest guard of a node for a landmark, at most `max_levels` deep; None when there is none."""
    return _Grid(question, post, seen).cheapest(max_levels)


class _Action(NamedTuple):
    """An action: its effect, and the push along one axis alone by which it may close."""

    number: int
    effect: tuple[float, float]
    pushed: tuple[float, float]

    @classmethod
    def of(cls, number: int, action: ActionSpec) -> "_Action":
        effect = action.effect or (0.0, 0.0)
        return cls(number, effect, effect if 0 in effect else (0.0, 0.0))


class _Grid:
    """The offsets to one landmark that reach a node, cut where closing or being near begins and ends."""

    def __init__(self, question: DecisionQuestion, post: Post, seen: Seen) -> None:
        policy, node, landmark = post
        self._policy, self._node, self._landmark, self._claim = policy, node, landmark, question.claim
        self._features, self._semantics = offset_features(policy, landmark), question.semantics
        box = box_of(policy.tree, node)
        reach = [_reach(question.region, policy.agent, landmark, axis) for axis in "xy"]
        self._lines: list[list[float]] = []
        self._ends: list[list[Fraction]] = []
        for feature, (low, high) in zip(self._features, reach, strict=True):
            below, above = box.low.get(feature), box.high.get(feature)
            lines = [line for line in _lines(question.claim) if _between(below, line, above)]
            first = low if below is None else max(low, self._end(feature, below))
            last = high if above is None else min(high, self._end(feature, above))
            self._lines.append(lines)
            self._ends.append([first, *(self._end(feature, line) for line in lines), last])
        self._known: dict[tuple[_Cells, int], tuple[GuardCost, _Node] | None] = {}
        self._sides: dict[tuple[int, tuple[int, ...], float], tuple[bool, bool] | None] = {}
        self._alone: dict[_Cells, list[tuple[GuardCost, _Node]]] = {}  # leaves of a rectangle, however deep it lies
        below = leaves_below(policy.tree, node)
        here = np.isin(seen.leaf, below)
        self._weights, self._sums = self._sum_cells(seen.rows[here], seen.weight[here])
        acted = policy.tree.action[seen.leaf]
        self._kept = {  # action -> the weight in each cell of states that it is taken in
            int(action): self._sum_cells(seen.rows[here & (acted == action)], seen.weight[here & (acted == action)])[0]
            for action in np.unique(policy.tree.action[below])
        }
        actions = [_Action.of(number, action) for number, action in enumerate(policy.actions)]
        self._actions = sorted(actions, key=lambda action: action.number not in self._kept)  # those taken there first

    def cheapest(self, max_levels: int | None) -> Guard | None:
        """See `guard`."""
        levels = UNLIMITED if max_levels is None else max(0, max_levels)
        best = self._best((0, len(self._lines[0]) + 1, 0, len(self._lines[1]) + 1), levels)
        if best is None:
            return None
        tree = in_preorder(best[1], lambda node: node, self._policy.numbers)
        leaves = int((tree.feature == NO_FEATURE).sum())
        changed = best[0].price - PRICE * (leaves - 1)
        return Guard(self._policy.agent, self._node, self._landmark, tree, max(0.0, changed), _levels(best[1]))

    def _best(self, cells: "_Cells", levels: int) -> "tuple[GuardCost, _Node] | None":
        """Cost and tree for the cells from x0 up to x1 and y0 up to y1."""
        if (cells, levels) not in self._known:
            if cells not in self._alone:
                self._alone[cells] = list(self._leaves(cells))
            options = [*self._alone[cells], *self._splits(cells, levels)]
            self._known[cells, levels] = min(options, key=lambda item: item[0]) if options else None
        return self._known[cells, levels]

    def _leaves(self, cells: "_Cells") -> "Iterator[tuple[GuardCost, _Node]]":
        safe = [action for action in self._actions if self._safe(action.pushed, cells)]
        if not safe:
            return
        x0, x1, y0, y1 = cells
        weight, *sums = (float(table[x0:x1, y0:y1].sum()) for table in (self._weights, *self._sums))
        for action in safe:
            ahead = sum(part * total for part, total in zip(action.effect, sums, strict=True))
            kept = float(self._kept[action.number][x0:x1, y0:y1].sum()) if action.number in self._kept else 0.0
            yield GuardCost(weight - kept, -ahead), action.number

    def _splits(self, cells: "_Cells", levels: int) -> "Iterator[tuple[GuardCost, _Node]]":
        if not levels:
            return
        x0, x1, y0, y1 = cells
        further = levels - 1 if levels > 0 else levels
        cuts = [(0, cut, (x0, cut, y0, y1), (cut, x1, y0, y1)) for cut in range(x0 + 1, x1)]
        cuts += [(1, cut, (x0, x1, y0, cut), (x0, x1, cut, y1)) for cut in range(y0 + 1, y1)]
        for axis, cut, below, above in cuts:
            left = self._best(below, further)
            right = self._best(above, further) if left is not None else None
            if left is not None and right is not None:
                test = self._features[axis], self._lines[axis][cut - 1]
                yield left[0] + right[0] + GuardCost(PRICE, 0.0), (*test, left[1], right[1])

    def _safe(self, pushed: tuple[float, float], cells: "_Cells") -> bool:
        """Returns True if an action that pushes so keeps the agent engaged in all of a rectangle."""
        on_x, on_y = self._side(0, cells[:2], pushed[0]), self._side(1, cells[2:], pushed[1])
        if on_x is None or on_y is None:
            return True  # no state of the region is there
        return on_x[0] or on_y[0] or (on_x[1] and on_y[1])

    def _side(self, axis: int, span: tuple[int, ...], push: float) -> tuple[bool, bool] | None:
        """Of one side of a rectangle: whether the push closes in all of it, and whether all where it does not is
        near. None where no state of the region is there.
        """
        if (axis, span, push) not in self._sides:
            low, high = (self._ends[axis][end] for end in span)
            self._sides[axis, span, push] = None if low > high else self._decide_engaged(low, high, Fraction(push))
        return self._sides[axis, span, push]

    def _decide_engaged(self, low: Fraction, high: Fraction, push: Fraction) -> tuple[bool, bool]:
        margin, radius = self._claim.margin, self._claim.radius
        if push:
            least, most = sorted((push * low, push * high))
            if least > margin:
                return True, True
            low, high = sorted((least / push, min(most, margin) / push))
        return False, -radius <= low and high <= radius

    def _end(self, feature: int, threshold: float) -> Fraction:
        """Where the left side of a test ends, as an exact offset."""
        left = sides(self._policy.features[feature], threshold, self._policy.numbers, self._semantics)[0]
        assert isinstance(left, Linear), left
        return left.bound

    def _sum_cells(self, rows: Floats, weight: Float64) -> tuple[Float64, tuple[Float64, Float64]]:
        """Weight of the states in each cell, and their weighted sums of both offsets."""
        shape = (len(self._lines[0]) + 1, len(self._lines[1]) + 1)
        offsets = [rows[:, feature] for feature in self._features]
        cells = tuple(
            np.searchsorted(np.array(lines, dtype=np.float32), offset, side="left")
            for lines, offset in zip(self._lines, offsets, strict=True)
        )
        tables = [np.zeros(shape) for _ in range(3)]
        for table, values in zip(tables, (weight, weight * offsets[0], weight * offsets[1]), strict=True):
            np.add.at(table, cells, values)
        return tables[0], (tables[1], tables[2])


_Node: TypeAlias = "int | tuple[int, float, _Node, _Node]"  # an action, or (feature, threshold, left, right)
_Cells: TypeAlias = tuple[int, int, int, int]


def _levels(node: _Node) -> int:
    return 0 if isinstance(node, int) else 1 + max(_levels(node[2]), _levels(node[3]))


def _lines(claim: DecisionClaim) -> list[float]:
    """Thresholds, ascending: far side of being near, where closing ends on either side, near side."""
    near = float(np.nextafter(round_down(np.float64(claim.radius)), np.float32(0)))
    above = float(np.nextafter(np.float32(claim.margin), np.float32(np.inf))) if claim.margin else 0.0
    above = max(above, SMALLEST) if above else above
    below = -max(float(np.nextafter(np.float32(above), np.float32(np.inf))), SMALLEST)
    return sorted({-near, below, above, near} if near > -below else {below, above})


def _between(below: float | None, line: float, above: float | None) -> bool:
    return (below is None or below < line) and (above is None or line < above)


def _reach(region: Region, agent: str, landmark: str, axis: str) -> Interval:
    """Between which ends the landmark's offset lies in the region."""
    own, mark = f"{agent}.{axis}", f"{landmark}.{axis}"
    low, high = region.box[mark][0] - region.box[own][1], region.box[mark][1] - region.box[own][0]
    for a, b, (least, most) in region.differences:
        if (a, b) == (mark, own):
            low, high = max(low, least), min(high, most)
        if (a, b) == (own, mark):
            low, high = max(low, -most), min(high, -least)
    return low, high
