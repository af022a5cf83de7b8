"""What fitted models of ONNX and of scikit-learn have in common: steps before a tree, and regressors.

Does: finds, for each test of a tree, the float32 number at which it turns, through the steps' own arithmetic; makes
  labels of few numbers that leaves give, and outputs of many.
Assumes: each test looks at one number of the observation, and what it sees never falls (or never rises) where that
  number rises.
Does not: know any step (columns.py, scikit.py), or import ONNX.

Subtractions, additions, products with and quotients by numbers that are not 0, clipping and comparisons have that
property, and so has rounding, in float32 or float64. So a test holds for all numbers up to one, or from one on, and for
no others; bisection over all float32 numbers in their order finds that one.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from codegen.importers.reading import MAX_VALUES, Origin
from codegen.importers.symbolic.paths import with_sums, without
from codegen.ir import CONSTANT, NO_FEATURE, Bool, Float32, Floats, GrownTree
from codegen.sums import DOUBLE_SUMS

LARGEST, INFINITE = np.float32(np.finfo(np.float32).max), np.float32(np.inf)


class Asked(NamedTuple):
    """The questions of the n splits of a tree, in the order of their nodes."""

    source: npt.NDArray[Any]  # [n] the number of the observation that each one looks at
    rising: Bool  # [n] whether what it sees never falls where that number rises; else it never rises
    passes: Callable[[Float32], Bool]  # numbers [n], one for each split -> which splits send them to the left


class Folded(NamedTuple):
    """A tree over the observations before the steps."""

    tree: GrownTree
    nan: bool  # whether a NaN, which goes right, goes where the steps and their tree send it


def fold_steps(tree: GrownTree, tests: Asked, largest: np.float32 = INFINITE) -> Folded:
    """The tree over the observations before the steps, for numbers from -`largest` to `largest`."""
    split = np.flatnonzero(tree.feature != NO_FEATURE)
    if not len(split):
        return Folded(tree, True)
    turn = np.where(tests.rising, 1, -1)

    def passes(order: Any) -> Bool:
        return tests.passes(_number(turn * order))

    ends = _order(largest)
    low, high = (np.full(len(split), end, dtype=np.int64) for end in (-ends, ends))
    never, always = ~passes(low), passes(high)
    while (low < high).any():  # the last number that passes is in [low, high]
        middle = (low + high + 1) // 2
        good = passes(middle)
        low, high = np.where(good, middle, low), np.where(good, high, middle - 1)
    threshold, feature = np.zeros(len(tree.feature)), tree.feature.copy()
    # what passes from a number on fails up to the one before it
    threshold[split], feature[split] = _number(np.where(tests.rising, low, -low - 1)), tests.source
    left, right = tree.left.copy(), tree.right.copy()
    turned = split[~tests.rising]
    left[turned], right[turned] = tree.right[turned], tree.left[turned]
    skip = dict(zip(split[never].tolist(), tree.right[split[never]].tolist(), strict=True))
    skip |= dict(zip(split[always].tolist(), tree.left[split[always]].tolist(), strict=True))
    to_the_left = np.where(never | always, always, ~tests.rising)  # where a NaN goes here, as the steps' tree names it
    nan = (tests.passes(np.full(len(split), np.nan, dtype=np.float32)) == to_the_left).all()
    return Folded(without(GrownTree(feature, threshold, left, right, tree.action), skip), bool(nan))


def _order(number: Any) -> int:
    """The place of a positive float32 in the order of all: 0 for 0."""
    return int(np.float32(number).view(np.int32))


def _number(order: Any) -> Float32:
    """The float32 numbers at places of their order; what lies before -infinity is -infinity."""
    bits: Float32 = np.minimum(np.abs(order), _order(INFINITE)).astype(np.int32).view(np.float32)
    return np.where(np.asarray(order) < 0, -bits, bits)


def giving(origin: Origin, values: Any, said: Callable[[Floats], Any]) -> Origin:
    """The origin of a regressor: few numbers are its labels, many, or several at once, are what its leaves give.

    `values`: [n_leaves, n_outputs], in which the actions of the tree count; `said`: what the regressor itself gives,
    [n, n_outputs].
    """
    known, place = np.unique(values, return_inverse=True)
    if values.shape[1] == 1 and len(known) <= MAX_VALUES:
        leaf, action = origin.grown.feature == NO_FEATURE, place.ravel()[origin.grown.action]
        grown = replace(origin.grown, action=np.where(leaf, action, origin.grown.action))

        def act(rows: Floats) -> Any:
            return np.searchsorted(known, np.asarray(said(rows))[:, 0])

        return replace(origin, grown=grown, labels=tuple(known.tolist()), act=act)
    vectors = [[((float(value), CONSTANT),) for value in row] for row in values.astype(np.float64).tolist()]
    return with_sums(replace(origin, act=said, labels=()), (), vectors, DOUBLE_SUMS)
