"""How far what an agent gives may change where an observation is off: the largest and the least value of each output.

Does: walks the leaves that observations within the errors reach; takes each output's ends over the box of each leaf.
Assumes: a checked tree of sums, in which a feature stands once; finite observations.
Does not: prove what it finds to anybody else (the claim `robust` is for that).

Products with a weight, sums, clipping and rounding are monotone in every feature, in each arithmetic. So what is
computed takes its ends over a box of floats in two corners, rounding included. Where only single features are tested
these corners reach the leaf, and the ends are exact. A test of a sum cuts no box: there the ends are bounds, and beside
them stands what the reference gives in the corners.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from codegen import ir
from codegen.ir import NO_FEATURE, ROOT, AgentPolicy, Float64, Floats, Sum
from codegen.numbers import at_most, neighbour
from codegen.sums import CONSTANT, clip_values


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
    """The observations of a box at which a sum is least and most."""
    least, most = low.copy(), high.copy()
    for weight, place in each.terms:
        if place != CONSTANT and weight < 0:
            least[place], most[place] = high[place], low[place]
    return least, most


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
