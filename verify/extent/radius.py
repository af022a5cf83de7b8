"""How far an observation may be off before an agent acts otherwise: the exact L-infinity distance to another action.

Does: searches a tree for the nearest leaf of another action, over all finite numbers, which are rounded to float32 if
  the tree compares that.
Assumes: a checked tree; finite observations.
Does not: prove what it finds to anybody else (the box around an observation is a claim like any other).

A tree is searched best first: a node costs the largest gap between the observation and a test that would have to fall
out otherwise to reach it. So of a large tree only the nodes within the radius are visited.
"""

import heapq
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import count

from codegen.ir import NO_FEATURE, ROOT, Tree
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
