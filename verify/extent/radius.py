"""How far an observation may be off before an agent acts otherwise, and how far what it gives changes where it is off.

Does: searches a tree for the nearest leaf of another action, in L-infinity distance over all finite numbers, which are
  rounded to float32 if the tree compares that; takes each output's ends over the box of each leaf that observations
  within the errors reach.
Assumes: a checked tree, in whose sums a feature stands once; finite observations.
Does not: prove what it finds to anybody else: the box around an observation, and `robust`, are claims like any other.

A tree is searched best first: a node costs the largest gap between the observation and a test that would have to fall
out otherwise to reach it. So of a large tree only the nodes within the radius are visited.

Products with a weight, sums, clipping and rounding are monotone in every feature, in each arithmetic. So what is
computed takes its ends over a box of floats in two corners, rounding included. Where only single features are tested
these corners reach the leaf, and the ends are exact. A test of a sum cuts no box: there the ends are bounds, and
beside them stands what the reference gives in the corners.
"""

import heapq
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import count

import numpy as np

from codegen import ir
from codegen.errors import InputError
from codegen.ir import NO_FEATURE, ROOT, AgentPolicy, Float64, Floats, Sum, Tree
from codegen.numbers import at_most, neighbour
from codegen.sums import CONSTANT, clip_values
from verify.checker.thresholds import find_double_end

Cut = tuple[Fraction | float, bool]  # a line is cut below a number, or above it when True
WHOLE: tuple[Cut, Cut] = (-math.inf, True), (math.inf, False)
Gap = tuple[Fraction, bool]  # a distance, and whether nothing at just that distance counts


@dataclass(frozen=True)
class Radius:
    """Around one observation: what the agent does, and how near the nearest other action is."""

    leaf: int
    action: int
    distance: Fraction | None = None  # the greatest lower bound; None: no observation leads to another action
    beyond: bool = False  # only observations further away act otherwise
    other: int = NO_FEATURE  # the leaf that is nearest

    @property
    def largest(self) -> float:
        """The largest float64 number such that every observation within it, ends included, acts the same."""
        if self.distance is None:
            return math.inf
        near = float(self.distance)
        too_far = Fraction(near) > self.distance or (Fraction(near) == self.distance and not self.beyond)
        return math.nextafter(near, -math.inf) if too_far else near


def radius(tree: Tree, observation: Sequence[float]) -> Radius:
    """The radius around a finite observation [n_features] of float64 numbers, each read as the agent's number next to
    it.
    """
    at = [Fraction(value) for value in observation]
    leaf: int | None = None
    turn = count()
    waiting: list[tuple[Gap, int, int, Mapping[int, tuple[Cut, Cut]]]] = [((Fraction(0), False), 0, ROOT, {})]
    while waiting:
        gap, _, node, lines = heapq.heappop(waiting)
        feature = int(tree.feature[node])
        if feature != NO_FEATURE:
            for child, line, more in _sides(tree, node, at[feature], lines.get(feature, WHOLE)):
                heapq.heappush(waiting, (max(gap, more), next(turn), child, {**lines, feature: line}))
        elif leaf is None:  # nothing is nearer than where the observation itself leads
            leaf = node
        elif tree.action[node] != tree.action[leaf]:
            return Radius(leaf, int(tree.action[leaf]), *gap, node)
    assert leaf is not None, "a tree has a leaf for every observation"
    return Radius(leaf, int(tree.action[leaf]))


def _sides(tree: Tree, node: int, value: Fraction, line: tuple[Cut, Cut]) -> list[tuple[int, tuple[Cut, Cut], Gap]]:
    """(child, what its feature may be, gap from the value) of the sides that some number reaches."""
    end = find_double_end(float(tree.threshold[node]), tree.numbers)
    number = end.value()
    cut = (number, not end.strict)
    low, high = line
    is_left = value < number or (value == number and not end.strict)
    none, gap = (Fraction(0), False), abs(value - number)
    left = (int(tree.left[node]), (low, min(high, cut)), none if is_left else (gap, end.strict))
    right = (int(tree.right[node]), (max(low, cut), high), (gap, not end.strict) if is_left else none)
    return [side for side in (left, right) if side[1][0] < side[1][1]]


@dataclass(frozen=True)
class Ends:
    """The range of one output around an observation: bounds, and what the reference gives at two observations."""

    value: float  # at the observation itself
    least: float  # no observation within the errors gives less
    most: float
    lowest: tuple[float, ...]  # an observation within the errors, float64; gives the least that was seen
    highest: tuple[float, ...]
    seen: tuple[float, float]  # what the reference gives there

    @property
    def exact(self) -> bool:
        """True if both bounds are met."""
        return self.seen == (self.least, self.most)

    @property
    def change(self) -> float:
        """No observation within the errors changes the output by more: float64, rounded up; infinite beyond all."""
        return _distance(self.value, (self.least, self.most), up=True)

    @property
    def change_seen(self) -> float:
        """By how much the output changes at one of the two observations, rounded down."""
        return _distance(self.value, self.seen, up=False)


def _distance(value: float, ends: tuple[float, float], *, up: bool) -> float:
    if not all(map(math.isfinite, (value, *ends))):
        return math.inf
    exact = max(abs(Fraction(end) - Fraction(value)) for end in ends)
    near = float(exact)
    if Fraction(near) == exact or (Fraction(near) > exact) == up:
        return near
    return math.nextafter(near, math.inf if up else -math.inf)


def ends_of(policy: AgentPolicy, observation: Sequence[float], errors: Sequence[Fraction]) -> tuple[Ends, ...]:
    """The ends of each output where each feature is off by at most its error. `observation`: float64 [n_features]."""
    first, last = (
        np.array(
            [_double(Fraction(value) + side * error, -side) for value, error in zip(observation, errors, strict=True)]
        )
        for side in (-1, 1)
    )
    at, boxes = np.array(observation, np.float64), list(_leaves(policy.tree, first, last))
    return tuple(_ends(policy, place, at, boxes, (first, last)) for place in range(len(policy.outputs)))


Box = tuple[int, Floats, Floats]  # a leaf, and the numbers of observations that may reach it, ends included


def _ends(policy: AgentPolicy, place: int, at: Float64, boxes: Sequence[Box], within: tuple[Float64, Float64]) -> Ends:
    """The ends of one output over the boxes of leaves; what is not finite on a side is no bound there."""
    tree, output = policy.tree, policy.outputs[place]
    bounds: tuple[list[float], list[float]] = ([], [])
    corners = ([at], [at])
    for leaf, low, high in boxes:
        each = tree.vectors[int(tree.action[leaf])][place]
        for side, corner in enumerate(_corners(each, low, high)):
            given = clip_values(each.value(corner[None], tree.arithmetic), output.low, output.high)
            bounds[side].append(float(given.astype(tree.gives)[0]))
            corners[side].append(np.clip(corner.astype(np.float64), *within))
    least = min(bounds[0]) if all(map(math.isfinite, bounds[0])) else -math.inf
    most = max(bounds[1]) if all(map(math.isfinite, bounds[1])) else math.inf
    below, above = (ir.outputs(policy, np.stack(side))[:, place].astype(np.float64) for side in corners)
    lowest, highest = int(np.argmin(below)), int(np.argmax(above))
    return Ends(
        value=float(below[0]),
        least=least,
        most=most,
        lowest=tuple(corners[0][lowest].tolist()),
        highest=tuple(corners[1][highest].tolist()),
        seen=(float(below[lowest]), float(above[highest])),
    )


def _double(exact: Fraction, towards: int) -> float:
    """The first double at or behind a number, in that direction."""
    near = float(exact)
    behind = (Fraction(near) - exact) * towards
    return near if behind >= 0 else math.nextafter(near, towards * math.inf)


def _corners(each: Sum, low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """The observations of a box at which a sum is least and most, as each of its operations rises or falls in what it
    reads. InputError for a feature in which some rise and others fall.
    """
    directions = {*_directions(each)}
    if len(directions) > len(each.places):
        what = "a feature stands in a sum twice, with and against its sign"
        raise InputError(what, "", "multiply the sum out in the source")
    least, most = low.copy(), high.copy()
    for place, rises in directions:
        if not rises:
            least[place], most[place] = high[place], low[place]
    return least, most


def _directions(each: Sum, *, rises: bool = True) -> Iterator[tuple[int, bool]]:
    """Yields each feature with whether what reads it rises in it."""
    for weight, place in each.terms:
        if isinstance(place, Sum):
            yield from _directions(place, rises=rises == (weight > 0))
        elif place != CONSTANT:
            yield place, rises == (weight > 0)


def _leaves(tree: ir.Tree, first: Float64, last: Float64) -> Iterator[Box]:
    """The leaves that observations between two reach, each with its box; tests of sums leave boxes as they are."""
    with np.errstate(over="ignore", under="ignore"):
        stack: list[Box] = [(ROOT, first.astype(tree.numbers), last.astype(tree.numbers))]
    while stack:
        node, low, high = stack.pop()
        tested, threshold = int(tree.feature[node]), tree.threshold[node]
        if tested == NO_FEATURE:
            yield node, low, high
        elif tested >= len(low):
            each = tree.sums[tested - len(low)]
            ends = [each.value(corner[None], tree.arithmetic)[0] for corner in _corners(each, low, high)]
            known = bool(np.isfinite(ends).all())
            stack += [(int(tree.right[node]), low, high)] if not (known and ends[1] <= threshold) else []
            stack += [(int(tree.left[node]), low, high)] if not (known and ends[0] > threshold) else []
        else:
            limit = at_most(float(threshold), tree.numbers)
            if high[tested] > limit:
                more = low.copy()
                more[tested] = max(low[tested], neighbour(limit, np.inf, tree.numbers))
                stack.append((int(tree.right[node]), more, high))
            if low[tested] <= limit:
                less = high.copy()
                less[tested] = min(high[tested], limit)
                stack.append((int(tree.left[node]), low, less))
