"""Steps before a scikit-learn tree, folded into its thresholds: scalers, selectors and binarizers.

Does: finds, for each test of the tree, the largest float32 number that passes it through the steps' own arithmetic.
Assumes: a fitted Pipeline of scikit-learn; float32 observations.
Does not: take a step that it does not know, or whose columns depend on one another.

Each known step maps one column by subtractions, additions, products with and quotients by positive numbers, clipping or
a comparison. Each of these never falls where its input rises, and neither does rounding, in float32 or float64. So a
test holds for all numbers up to one, and no others; bisection over all float32 numbers in their order finds that one.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from codegen.errors import InputError, shown
from codegen.ir import NO_CHILD, NO_FEATURE, Bool, Float32, GrownTree

LARGEST = np.float32(np.finfo(np.float32).max)
POSITIVE = {  # steps of scikit-learn, and what their columns are multiplied with or divided by
    "sklearn.preprocessing._data.StandardScaler": "scale_",
    "sklearn.preprocessing._data.RobustScaler": "scale_",
    "sklearn.preprocessing._data.MinMaxScaler": "scale_",
    "sklearn.preprocessing._data.MaxAbsScaler": "scale_",
    "sklearn.preprocessing._data.Binarizer": "",
}
SELECTORS = "sklearn.feature_selection."


def columns(steps: Sequence[tuple[str, Any]], width: int) -> list[int]:
    """Which column of the observation each column after the steps is made of. InputError with its name for a step that
    is not known to keep columns apart and in order.
    """
    found: list[int] = list(range(width))
    for name, step in steps:
        kind = f"{type(step).__module__}.{type(step).__qualname__}"
        if kind.startswith(SELECTORS) and "transform" not in vars(step) and hasattr(step, "get_support"):
            kept: list[int] = step.get_support(indices=True).tolist()
            found = [found[place] for place in kept]
        elif kind not in POSITIVE or "transform" in vars(step) or not _rising(step, POSITIVE[kind]):
            what = f"the step {shown(name)!r} before the tree is not understood: {type(step).__name__}"
            raise InputError(what, "", "use scalers, selectors and binarizers, or give the tree alone")
    return found


def _rising(step: Any, attribute: str) -> bool:
    factor = getattr(step, attribute, None) if attribute else None
    return factor is None or bool((np.isfinite(factor) & (np.asarray(factor) > 0)).all())


def folded(tree: GrownTree, transform: Callable[[Float32], Float32], source: Sequence[int], width: int) -> GrownTree:
    """The tree over the observations before the steps. `source`: as from `columns`."""
    split = np.flatnonzero(tree.feature != NO_FEATURE)
    if not len(split):
        return tree
    features = np.array(source, dtype=np.int64)[tree.feature[split]]

    def passes(numbers: Float32) -> Bool:
        rows = np.zeros((len(split), width), dtype=np.float32)
        rows[np.arange(len(split)), features] = numbers
        after = transform(rows)
        return after[np.arange(len(split)), tree.feature[split]] <= tree.threshold[split]

    low, high = (np.full(len(split), end, dtype=np.int64) for end in (-_order(LARGEST), _order(LARGEST)))
    never, always = ~passes(_number(low)), passes(_number(high))
    while (low < high).any():  # the largest number that passes is in [low, high]
        middle = (low + high + 1) // 2
        good = passes(_number(middle))
        low, high = np.where(good, middle, low), np.where(good, high, middle - 1)
    threshold = np.zeros(len(tree.feature))
    feature = tree.feature.copy()
    threshold[split], feature[split] = _number(low), features
    skip = dict(zip(split[never].tolist(), tree.right[split[never]].tolist(), strict=True))
    skip |= dict(zip(split[always].tolist(), tree.left[split[always]].tolist(), strict=True))
    return _without(GrownTree(feature, threshold, tree.left, tree.right, tree.action), skip)


def _order(number: Any) -> int:
    """The place of a positive float32 in the order of all: 0 for 0."""
    return int(np.float32(number).view(np.int32))


def _number(order: Any) -> Float32:
    """The float32 numbers at places of their order."""
    bits = np.abs(np.asarray(order, dtype=np.int32)).view(np.float32)
    return np.where(np.asarray(order) < 0, -bits, bits)


def _without(tree: GrownTree, skip: dict[int, int]) -> GrownTree:
    """The tree without splits that all observations pass on one side; `skip`: node -> that side."""

    def led(node: int) -> int:
        while node in skip:
            node = skip[node]
        return node

    order, open_ = list[int](), [led(0)]
    while open_:
        node = open_.pop()
        order.append(node)
        if tree.feature[node] != NO_FEATURE:
            open_ += [led(int(tree.right[node])), led(int(tree.left[node]))]
    place = {node: index for index, node in enumerate(order)} | {NO_CHILD: NO_CHILD}
    left, right = ([place[led(int(side[node]))] for node in order] for side in (tree.left, tree.right))
    return GrownTree(tree.feature[order], tree.threshold[order], np.array(left), np.array(right), tree.action[order])
