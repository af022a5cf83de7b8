"""The observations at which a source itself is asked what it decides: they come from its numbers, not from the tree.

Does: puts every feature at each number, at its negation, one more and one less, at its float32 and float64 neighbours,
  and at special values of its type; one feature at a time, then two.
Assumes: all numbers that stand in the source, or that its constants are.
Does not: know a language, a reader or a tree. Thresholds are numbers among others, of one feature.

A row is given by column, each an array of the type that the source declares, so that whole numbers beyond 2^24 and 2^53
stay what they are.
"""

import math
from collections.abc import Iterable, Sequence
from itertools import combinations
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from codegen.floats import FLOAT32, FLOAT64

ROWS = 100_000
FILLINGS = 3  # rows for each value of a feature: the others at zero, then at random values
Numbers: TypeAlias = "Iterable[int | float]"
Column: TypeAlias = "npt.NDArray[Any]"  # [n_rows]


def list_values(numbers: Numbers, kind: str) -> tuple[Column, Column]:
    """The values of a feature of the NumPy type `kind` at and around numbers, ascending, and special ones beside them.

    float32, float64, bool, and whole numbers of any width. The first list has zero, and no special value but that.
    """
    if np.dtype(kind).kind == "f":
        return _list_floats(numbers, kind)
    if kind == "bool":
        return np.array([False, True]), np.array([], np.bool_)
    least, most = int(np.iinfo(kind).min), int(np.iinfo(kind).max)
    found = {0, 1, least, most}
    for number in numbers:
        if isinstance(number, int) or math.isfinite(number):
            for whole in (math.floor(number), math.ceil(number)):
                found |= {sign * whole + beside for sign in (1, -1) for beside in (-1, 0, 1)}
    return np.array(sorted(each for each in found if least <= each <= most), kind), np.array([], kind)


def _list_floats(numbers: Numbers, kind: str) -> tuple[Column, Column]:
    near = {0.0, 1.0, -1.0}
    for number in numbers:
        try:
            near |= {sign * float(number) + beside for sign in (1, -1) for beside in (-1, 0, 1)}
        except OverflowError:
            continue  # a whole number that no double is near to
    with np.errstate(all="ignore"):
        at = np.array(sorted(near), np.float64)
        values = [at]
        for neighbours in (FLOAT32,) if kind == FLOAT32 else (FLOAT32, FLOAT64):
            rounded = at.astype(neighbours)
            values += [rounded, *(np.nextafter(rounded, np.array(end, neighbours)) for end in (-np.inf, np.inf))]
        found = np.unique(np.concatenate([each.astype(kind) for each in values]))
        limits = np.finfo(kind)
        special = np.array([-0.0, np.nan, np.inf, limits.max, limits.tiny, limits.smallest_subnormal], kind)
    return found[np.isfinite(found)], np.concatenate([special, -special[2:]])


def choose_rows(
    numbers: Numbers, kinds: Sequence[str], thresholds: Sequence[Numbers] = (), most: int = ROWS, seed: int = 0
) -> list[Column]:
    """The observations, a column for each feature: each value of each feature, then pairs, `most` rows in all.

    `kinds`: the NumPy type of each feature; `thresholds`: numbers more for each feature. Where there are more pairs, or
    more values, than rows, they are drawn with the seed.
    """
    rng, numbers = np.random.default_rng(seed), list(numbers)
    plain, values = list[Column](), list[Column]()
    for place, kind in enumerate(kinds):
        near, special = list_values([*numbers, *(thresholds[place] if thresholds else ())], kind)
        plain.append(near)
        values.append(np.concatenate([near, special]))
    if not kinds:
        return []
    single = np.array([(place, at, 0, -1) for place, each in enumerate(values) for at in range(len(each))])
    if len(single) > most:  # special values first, then as many others as fit
        special = single[:, 1] >= np.array([len(each) for each in plain])[single[:, 0]]
        order = np.argsort(~special + rng.random(len(single)))
        single = single[np.sort(order[:most])]
    single = np.tile(single, (max(1, min(FILLINGS, most // len(single))), 1))
    chosen = np.concatenate([single, _pair_values([len(each) for each in values], most - len(single), rng)])
    zeros = np.arange(len(chosen)) < len(single) // FILLINGS  # the first filling
    columns = list[Column]()
    for place, (near, each) in enumerate(zip(plain, values, strict=True)):
        column = near[np.where(zeros, np.searchsorted(near, 0), rng.integers(len(near), size=len(chosen)))]
        for of, at in ((0, 1), (2, 3)):
            put = (chosen[:, of] == place) & (chosen[:, at] >= 0)
            column[put] = each[chosen[put, at]]
        columns.append(column)
    return columns


def _pair_values(counts: Sequence[int], most: int, rng: np.random.Generator) -> npt.NDArray[np.int64]:
    """Two features and the place of a value of each, [n, 4]; at most `most` of them."""
    pairs = list(combinations(range(len(counts)), 2))
    sizes = [counts[one] * counts[other] for one, other in pairs]
    if most <= 0 or not pairs:
        return np.zeros((0, 4), np.int64)
    if sum(sizes) <= most:
        places = [np.indices((counts[one], counts[other])).reshape(2, -1) for one, other in pairs]
        which = np.repeat(np.array(pairs), sizes, axis=0)
        first, second = np.concatenate(places, axis=1)
    else:
        which = np.array(pairs)[rng.choice(len(pairs), most, p=np.array(sizes) / sum(sizes))]
        first, second = (rng.integers(np.array(counts)[which[:, side]]) for side in (0, 1))
    return np.stack([which[:, 0], first, which[:, 1], second], axis=1)
