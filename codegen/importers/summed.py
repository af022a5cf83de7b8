"""Origins whose trees test sums or give numbers.

Does: keeps, of the sums that a reader found, those that the tree names; says what they need of a caller.
Assumes: a grown tree whose features from SUMS on count in the sums, and whose actions count in the vectors.
Does not: read any source.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from codegen.errors import InputError
from codegen.floats import FLOAT32, FLOAT64
from codegen.importers.reading import SUMS, Origin
from codegen.ir import CONSTANT, NO_FEATURE, Floats, Sum
from codegen.sums import DOUBLE_SUMS, FLOAT32_STEPS, FLOAT64_SUMS

Terms = Sequence[tuple[float, int]]
MAX_VALUES = 64  # of a regressor, beyond which they are no actions
ARITHMETIC: Mapping[str, str] = {FLOAT32: FLOAT32_STEPS, FLOAT64: FLOAT64_SUMS}


def with_sums(
    origin: Origin,
    tests: Sequence[Terms],
    vectors: Sequence[Sequence[Terms]],
    places: Sequence[int],
    arithmetic: str = "",
) -> Origin:
    """The origin with the sums that its tree tests, and what its leaves give; itself where there is none of both.

    `places`: of the inputs that terms name, among the features. `arithmetic`: default that of the origin's numbers.
    """
    named = [int(each) - SUMS for each in dict.fromkeys(origin.grown.feature[origin.grown.feature >= SUMS].tolist())]
    if not named and not vectors:
        return origin
    chosen = arithmetic or ARITHMETIC[origin.numbers]
    order = {SUMS + old: SUMS + new for new, old in enumerate(named)}
    feature = [order.get(each, each) for each in origin.grown.feature.tolist()]
    return replace(
        origin,
        grown=replace(origin.grown, feature=np.array(feature)),
        arithmetic=chosen,
        gives=FLOAT32 if chosen == FLOAT32_STEPS else FLOAT64,
        sums=tuple(place_sum(tests[each], places) for each in named),
        vectors=tuple(tuple(place_sum(each, places) for each in vector) for vector in vectors),
    )


def place_sum(terms: Terms, places: Any) -> Sum:
    """The sum over the features at these places. `places`: of each that terms name."""
    return Sum(tuple((weight, CONSTANT if place == CONSTANT else int(places[place])) for weight, place in terms))


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
    vectors = [[[(value, CONSTANT)] for value in row] for row in values.astype(np.float64).tolist()]
    return with_sums(replace(origin, act=said, labels=()), (), vectors, (), DOUBLE_SUMS)


def rounds(origin: Origin) -> bool:
    """Whether its answers depend on how sums are rounded. Of a difference of two features, the sign does not; nor does
    a feature that is given as it is.
    """
    zero = {0.0, math.nextafter(0.0, -math.inf), -float(np.finfo(np.float32).smallest_subnormal)}
    for place, each in enumerate(origin.sums):
        asked = origin.grown.threshold[origin.grown.feature == SUMS + place].tolist()
        if len(each.terms) > 2 or not _plain(each) or not {*asked} <= zero:
            return True
    given = [each for vector in origin.vectors for each in vector if any(place != CONSTANT for _, place in each.terms)]
    return any(len(each.terms) > 1 or not _plain(each) for each in given)


def _plain(each: Sum) -> bool:
    return all(abs(weight) == 1 and place != CONSTANT for weight, place in each.terms)


def ensure_alike(origin: Origin, agent: str) -> None:
    """InputError for numbers that the arithmetic of an origin does not have, such as 0.1 among float32 steps."""
    kind = FLOAT32 if origin.arithmetic == FLOAT32_STEPS else FLOAT64
    weights = FLOAT32 if origin.arithmetic == DOUBLE_SUMS else kind
    for each in (*origin.sums, *(one for vector in origin.vectors for one in vector)):
        for weight, place in each.terms:
            numbers = kind if place == CONSTANT else weights
            if float(np.dtype(numbers).type(weight)) != weight:
                what = f"{weight!r} stands in a sum of {numbers} numbers, and is none"
                raise InputError(what, agent, f"round it in the source to {numbers}")
