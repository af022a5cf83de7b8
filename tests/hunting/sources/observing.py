"""Observations at which a source is asked: around every number of it, in pairs, at what its tree tests, and by chance.

Does: draws rows of the types that features have, from numbers and from thresholds.
Assumes: what a tree tests is given as weighted features and a number.
Does not: know languages or profiles.
"""

from collections.abc import Iterable, Sequence

import numpy as np

WHOLE = {
    "int8": (-(2**7), 2**7 - 1),
    "int16": (-(2**15), 2**15 - 1),
    "int32": (-(2**31), 2**31 - 1),
    "int64": (-(2**63), 2**63 - 1),
    "uint8": (0, 2**8 - 1),
    "uint16": (0, 2**16 - 1),
    "uint32": (0, 2**32 - 1),
    "uint64": (0, 2**64 - 1),
    "bool": (0, 1),
}
SPECIAL = (0.0, -0.0, 1.0, -1.0, np.inf, -np.inf, 1e-300, 1e300, 3e38, 2.0**53, 5e-324)
SIDES = 500  # values at most from numbers
EACH = 100  # rows at most for one feature alone
TOGETHER = 250
TESTED = 3  # rows for each side of a threshold
Box = dict[int, tuple[float, float]]  # what a feature is above, and at most
Test = tuple[tuple[tuple[float, int], ...], float, Box]  # weights and features, the threshold, where it is tested


def spread(numbers: Iterable[float], rng: np.random.Generator) -> np.ndarray:
    """Every number and its negative, more and less by one, and its neighbours in float64 and float32."""
    values = np.unique(np.array([*numbers, 0.0, 1.0], np.float64))
    values = values[np.isfinite(values)]
    if len(values) > 2:
        one, other = rng.choice(values, (2, 24))
        with np.errstate(all="ignore"):
            values = np.concatenate([values, one + other, one - other, one * other, one / other])
    values = values[np.isfinite(values)]
    with np.errstate(all="ignore"):
        near = values.astype(np.float32)
        beside = [near, np.nextafter(near, np.float32(np.inf)), np.nextafter(near, np.float32(-np.inf))]
    values = np.concatenate(
        [values, values - 1, values + 1, np.nextafter(values, np.inf), np.nextafter(values, -np.inf), *beside]
    )
    values = np.concatenate([values, -values])
    if len(values) > SIDES:
        values = rng.choice(values, SIDES, replace=False)
    return np.concatenate([values, SPECIAL, rng.normal(size=20) * 10.0 ** rng.integers(-2, 4, 20)])


def fit(values: np.ndarray, kind: str) -> np.ndarray:
    """Values that a type holds, as float64."""
    if kind in WHOLE:
        low, high = WHOLE[kind]
        return np.clip(np.round(np.nan_to_num(values, posinf=high, neginf=low)), low, high)
    with np.errstate(all="ignore"):
        return values.astype(np.float32).astype(np.float64) if kind == "float" else values


def draw(
    types: Sequence[str], numbers: Iterable[float], tests: Sequence[Test], seed: int, limit: int = 2_500
) -> np.ndarray:
    """[rows, features] float64: each feature alone, all together, and at what the tree tests."""
    rng = np.random.default_rng([seed, 51])
    values = spread(numbers, rng)
    count = len(types)
    rows = [rng.choice(values, (TOGETHER, count))]
    usual = rng.choice(np.concatenate([[0.0, 0.5, 1.0], rng.choice(values, 8)]), (EACH, count))
    for place in range(count):
        alone = usual.copy()
        alone[:, place] = rng.choice(values, EACH, replace=len(values) < EACH)
        rows.append(alone)
    rows += [_around(test, values, count, rng) for test in tests]
    drawn = np.concatenate(rows)
    if len(drawn) > limit:
        drawn = drawn[np.sort(rng.choice(len(drawn), limit, replace=False))]
    return np.stack([fit(drawn[:, place], kind) for place, kind in enumerate(types)], axis=1)


def _around(test: Test, values: np.ndarray, count: int, rng: np.random.Generator) -> np.ndarray:
    """Rows that reach a test, where weighted features come to the threshold, or to a little less or more."""
    terms, threshold, box = test
    rows = rng.choice(values, (5 * TESTED, count))
    for feature, (low, high) in box.items():
        inside = values[(values > low) & (values <= high)]
        ends = [each for each in (high, float(np.nextafter(low, np.inf))) if np.isfinite(each)]
        rows[:, feature] = rng.choice([*inside, *ends] or [0.0], len(rows))
    weight, place = terms[-1]
    if len(terms) > 1:  # of a sum the other terms may be anything that does not drown the threshold
        rows = np.where(np.abs(rows) < 1e6, rows, 0.5)
    rest = sum((rows[:, other] * of for of, other in terms[:-1]), np.zeros(len(rows)))
    with np.errstate(all="ignore"):
        at = (threshold - rest) / weight
        single = at.astype(np.float32)
        sides = [
            at,
            np.nextafter(at, np.inf),
            np.nextafter(at, -np.inf),
            np.nextafter(single, np.float32(np.inf)),
            np.nextafter(single, np.float32(-np.inf)),
        ]
    rows[:, place] = np.choose(np.arange(len(rows)) % 5, sides)
    return rows


def whole_rows(rows: np.ndarray, types: Sequence[str], numbers: Iterable[int], seed: int) -> np.ndarray:
    """[rows, features] uint64, two's complement: whole numbers of the rows; beyond 2^53 some that are no double."""
    rng = np.random.default_rng([seed, 53])
    out = np.zeros(rows.shape, np.uint64)
    big = [int(each) for each in numbers if abs(int(each)) > 1 << 53]
    for place, kind in enumerate(types):
        if kind not in WHOLE:
            continue
        low, high = WHOLE[kind]
        exact = [min(max(int(each), low), high) for each in rows[:, place].tolist()]
        if kind in ("int64", "uint64"):
            for row in range(0, len(exact), 3):
                base = big[int(rng.integers(len(big)))] if big and rng.random() < 0.7 else exact[row]
                exact[row] = min(max(base + int(rng.integers(-2, 3)), low), high)
        out[:, place] = np.array([each & 0xFFFFFFFFFFFFFFFF for each in exact], np.uint64)
    return out
