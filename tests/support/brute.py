"""Policies looked at cell by cell: an account of what trees decide that shares nothing with the verifier.

Does: random trees with ties, signed zeros and neighbouring floats; decides one observation; the half lines on which one
  feature's tests fall out alike, with their exact ends; every combination of these.
Assumes: numpy rounds float64 to float32 as IEEE 754 says.
Does not: import anything of `verify`.

A half line is found by asking float32 itself: between two neighbours it begins at their middle, and the middle belongs
to whichever float32 the middle is rounded to.
"""

import itertools
import math
from fractions import Fraction

import numpy as np

from tests.support.teams import nested

WIDE = Fraction(10**12)  # ends of what is unbounded: no sum or distance here comes near


def random_tree(rng, n_features, max_depth, pool, n_actions=3, numbers="float32"):
    """A tree whose thresholds are of a pool. `pool`: numbers that the trees of one case share."""

    def grow(depth, ends=0.2):
        if depth == 0 or (ends and rng.random() < ends):
            return int(rng.integers(n_actions))
        return int(rng.integers(n_features)), float(rng.choice(pool)), grow(depth - 1), grow(depth - 1)

    return nested(grow(int(rng.integers(1, max_depth + 1)), 0), numbers)


def random_pool(rng, numbers="float32"):
    """Thresholds with ties, both zeros and neighbours."""
    kind = np.dtype(numbers).type
    base = [kind(each) for each in (0.0, -0.0, 0.5, -1.0, 1.0, *rng.uniform(-2, 2, 3))]
    chosen = [base[place] for place in rng.permutation(len(base))[: int(rng.integers(1, 6))]]
    beside = [np.nextafter(each, kind(way)) for each in chosen if abs(each) > 0.25 for way in (-9, 9)]
    more = [beside[place] for place in rng.permutation(len(beside))[:2]]
    return np.array([*chosen, *more], dtype=kind)


def action_of(tree, values):
    """What a tree decides: `values` [n_features] are float64 numbers or fractions, read as the tree's numbers are."""
    node = 0
    while tree.feature[node] >= 0:
        value, threshold = values[tree.feature[node]], tree.threshold[node]
        if not isinstance(value, Fraction):
            value, threshold = np.dtype(tree.numbers).type(value), np.dtype(tree.numbers).type(threshold)
        else:
            threshold = Fraction(float(threshold))
        node = int(tree.left[node] if value <= threshold else tree.right[node])
    return int(tree.action[node])


def end_of(threshold, numbers):
    """(end, closed) of the numbers, over the reals, that go left at a threshold."""
    if numbers == "float64":
        return Fraction(float(threshold)), True
    low = np.float32(threshold)
    high = np.nextafter(low, np.float32(np.inf))
    middle = (Fraction(float(low)) + Fraction(float(high))) / 2
    assert Fraction(float(middle)) == middle, "the middle of two float32 numbers is a float64 number"
    return middle, bool(np.float32(float(middle)) <= low)


def lines_of(reading, exact=False):
    """The parts of the real line of one variable that its tests tell apart: (low, has low, high, has high), in order.

    `reading`: (tree, its feature that reads the variable). `exact`: without rounding.
    """
    ends = set()
    for tree, feature in reading:
        for threshold in tree.threshold[tree.feature == feature]:
            ends.add((Fraction(float(threshold)), True) if exact else end_of(threshold, tree.numbers))
    cuts = sorted(ends)  # an end that stays out of the left part comes before the one that is in it
    bounds = [(-WIDE, False), *cuts, (WIDE, True)]
    return [(low, not with_low, high, with_high) for (low, with_low), (high, with_high) in itertools.pairwise(bounds)]


def inside(line, low, high):
    """A part within [low, high], or None where nothing of it is."""
    a, has_a, b, has_b = line
    if low > a or (low == a and has_a):
        a, has_a = low, True
    if high < b or (high == b and has_b):
        b, has_b = high, True
    if a > b or (a == b and not (has_a and has_b)):
        return None
    return a, has_a, b, has_b


def float_in(line):
    """A float64 number in a part, or None where it holds none."""
    low, has_low, high, has_high = line
    tried = [float(low), float(high), float((low + high) / 2)]
    tried += [math.nextafter(each, way) for each in tried[:2] for way in (-math.inf, math.inf)]
    for value in tried:
        exact = Fraction(value)
        if (low < exact or (low == exact and has_low)) and (exact < high or (exact == high and has_high)):
            return value
    return None


def gap(line, value):
    """(distance of a part from a number, whether no number of it is as near as that)."""
    low, has_low, high, has_high = line
    if value < low or (value == low and not has_low):
        return low - value, not has_low
    if value > high or (value == high and not has_high):
        return value - high, not has_high
    return Fraction(0), False
