"""Observations that tell a right implementation of a tree from a wrong one, by the hundred thousand in bounded memory.

Does: boundary observations for every split that can be reached, special float values, and random ones; where sums are
  tested, observations at ties of every one and beside them, numbers of every size and sign; keeps what every target is
  asked in a scratch folder, and hands it out whole, in part, or as lists of numbers.
Assumes: finite thresholds; random draws come from a seed; `Kept` is used as a context manager, which removes the
  folder.
Does not: run any implementation (selfcheck.py).
"""

import tempfile
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from codegen import ir
from codegen.boxes import is_inside, read_bounds, read_distances, split_corners
from codegen.deciding import read_by
from codegen.floats import FLOAT32, FLOAT64, NUMBERS, deciding_double
from codegen.ir import Float64, Floats, GrownTree, Tree
from codegen.numbers import at_most, neighbour
from codegen.world import RegionSpec

BLOCK = 512  # observations that are lists of Python's numbers at the same time
PART = 1 << 22  # numbers of an array in memory at the same time; twice as many would be fresh memory each time


def in_type(rows: Floats, policy: ir.AgentPolicy) -> Floats:
    """Observations as the agent has them: where it observes whole numbers, those below and those above each row.

    So a threshold and both its neighbours become the threshold, one less and one more; what is beyond the type becomes
    its end, and NaN 0.
    """
    if not policy.whole:
        return rows
    low, high = np.iinfo(policy.whole).min, np.iinfo(policy.whole).max
    known = np.nan_to_num(rows, posinf=high, neginf=low)
    return np.concatenate([np.floor(known), np.ceil(known)]).clip(low, high)


def iterate_rows(rows: Any) -> Iterator[list[float]]:
    """The rows of an array one after the other, as `tolist` gives them, which needs eight times an array's memory."""
    for low in range(0, len(rows), BLOCK):
        yield from rows[low : low + BLOCK].tolist()


class Kept(Mapping[str, Floats]):
    """Arrays by name, each read from its file when it is asked for."""

    def __init__(self) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="maviper-")
        self._files: dict[str, tuple[Path, str, int]] = {}  # by name: where its rows lie, their type, and their width

    def keep(self, name: str, rows: Floats) -> None:
        """Writes rows behind those that a name has already."""
        if name not in self._files:
            place = Path(self._folder.name) / str(len(self._files))
            self._files[name] = place, rows.dtype.name, rows.shape[1]
        with self._files[name][0].open("ab") as file:
            np.ascontiguousarray(rows).tofile(file)

    def _read(self, name: str, low: int = 0, count: int = -1) -> Floats:
        """So many rows from one on; -1: all that follow."""
        place, numbers, width = self._files[name]
        offset = low * width * np.dtype(numbers).itemsize
        return np.fromfile(place, numbers, count * width if count > 0 else -1, offset=offset).reshape(-1, width)

    def parts(self, name: str) -> Iterator[tuple[int, Floats]]:
        """An array in parts of bounded memory, each with the place of its first row."""
        low, count = 0, max(1, PART // max(1, self._files[name][2]))
        while len(rows := self._read(name, low, count)):
            yield low, rows
            low += len(rows)

    def together(self, names: Sequence[str], count: int) -> Iterator[list[Floats]]:
        """The first `count` rows of some arrays, a block of each at a time."""
        for low in range(0, count, 64 * BLOCK):
            yield [self._read(name, low, min(64 * BLOCK, count - low)) for name in names]

    def __getitem__(self, name: str) -> Floats:
        return self._read(name)

    def __iter__(self) -> Iterator[str]:
        return iter(self._files)

    def __len__(self) -> int:
        return len(self._files)

    def __enter__(self) -> "Kept":
        return self

    def __exit__(self, *_: object) -> None:
        self._folder.cleanup()


HUGE = 1e30  # drawing beyond it overflows; paths that demand more get their own bounds
DRAWN_AT_ONCE = 4_096  # of random observations, which bounds the memory of doubles
FILLINGS = 16  # random completions of each boundary value
# where there are many features, completions are fewer: numbers in all rows of special values or ends, and of doubles
NUMBERS_AT_MOST, DOUBLES_AT_MOST = 1 << 17, 1 << 20


def _special(numbers: str) -> Floats:
    limits = np.finfo(numbers)
    extremes = (limits.max, limits.tiny, limits.smallest_subnormal, np.inf, 0.0)
    return np.array([np.nan, *extremes, *(-extreme for extreme in extremes)], dtype=numbers)


_LIMITS = np.finfo(np.float32)
SPECIAL = {numbers: _special(numbers) for numbers in NUMBERS}

# halves of float32's smallest and of its distance to infinity, beside what doubles have of their own
_HALVES = (2.0**-150, float(_LIMITS.max) + 2.0**103)
DOUBLES = np.array([np.nan, *(s * x for s in (1, -1) for x in (0.0, 5e-324, 1e-40, *_HALVES, 1e300, 1.7e308, np.inf))])
WILD = 500
TYPED = 200  # observations in numbers of each other type
ROUNDS = 20  # of moving states into a region
AROUND = 64  # states at each border of a region
POOL = 4_000  # random observations, of which those that reach a split are moved to its ties
AT_TIE = 16  # observations moved to each tie
STEPS = 2  # neighbours of a tie, on each side
WIDE = 4_000
REST = 2.0**-27  # of a number, which rounding to float32 takes away


def _uniform(rng: np.random.Generator, low: Any, high: Any, shape: tuple[int, ...]) -> Float64:
    """Uniform draws, number for number those of `rng.uniform`, which takes thrice as long where bounds are arrays, and
    takes 0 and -0 for bounds the wrong way round.
    """
    least, most = (np.asarray(end, np.float64) + 0.0 for end in (low, high))
    rows = rng.random(shape)
    rows *= most - least
    rows += least
    return rows


def neighbours(threshold: float, numbers: str) -> Floats:
    """The numbers of that type around a threshold, float32 or float64: at or below it, its two neighbours. [3]"""
    at = at_most(threshold, numbers)
    return np.array([neighbour(at, -np.inf, numbers), at, neighbour(at, np.inf, numbers)], dtype=numbers)


def paths(tree: Tree | GrownTree, n_features: int) -> Iterator[tuple[int, Floats, Floats]]:
    """Every split that some observation reaches, with the open-closed box (low, high] of those observations."""
    infinity, thresholds = np.dtype(tree.numbers).type(np.inf), at_most(tree.threshold, tree.numbers)
    stack = [(ir.ROOT, np.full(n_features, -infinity), np.full(n_features, infinity))]
    while stack:
        node, low, high = stack.pop()
        feature = int(tree.feature[node])
        if feature == ir.NO_FEATURE:
            continue
        yield node, low, high
        corners = split_corners(low, high, feature, thresholds[node])
        sides = zip((tree.left[node], tree.right[node]), corners, strict=True)
        stack += [(int(child), least, most) for child, (least, most) in sides if least[feature] < most[feature]]


def boundary(tree: Tree | GrownTree, features: tuple[ir.FeatureSpec, ...], rng: np.random.Generator) -> Floats:
    """Observations that reach each split with its feature at the threshold and at both its neighbours.

    [n, n_features]; every boundary value comes with FILLINGS random values of the other features. Where the path
    has a test of the same feature right beside the threshold, a neighbour may leave the path; it is asked all the same.
    """
    numbers = tree.numbers
    rows: list[Floats] = [np.zeros((0, len(features)), dtype=numbers)]
    floor = np.array([feature.low for feature in features], dtype=numbers)
    ceiling = np.array([feature.high for feature in features], dtype=numbers)
    for node, low, high in paths(tree, len(features)):
        start = np.maximum(neighbour(low, np.inf, numbers), np.minimum(floor, high))
        stop = np.maximum(np.minimum(high, np.maximum(ceiling, start)), start)
        values = neighbours(float(tree.threshold[node]), numbers)
        shape = (len(values), FILLINGS, len(features))
        drawn = _uniform(rng, start.clip(-HUGE, HUGE), stop.clip(-HUGE, HUGE), shape)
        filled = drawn.astype(numbers).clip(start, stop)
        filled[:, :, int(tree.feature[node])] = values[:, None]
        rows.append(filled.reshape(-1, len(features)))
    return np.concatenate(rows)


def telling(policy: ir.AgentPolicy, rng: np.random.Generator) -> Iterator[Floats]:
    """Observations that a wrong tree decides otherwise, in parts [n, n_features]: boundaries of the tests of single
    features; where sums are tested or given ties of all tests, and numbers of every size.
    """
    if policy.tree.arithmetic:
        yield ties(policy, rng)
        yield wide(len(policy.features), rng, policy.numbers)
    else:
        yield boundary(policy.tree, policy.features, rng)


def telling_doubles(policy: ir.AgentPolicy, rng: np.random.Generator) -> Float64:
    """Double observations that must act as the agent's numbers say: at what `telling` finds, a little away from it."""
    if not policy.tree.arithmetic:
        return doubles(policy.tree, policy.features, rng)
    rows = ties(policy, rng).astype(np.float64)
    if policy.numbers == FLOAT32:
        rows *= 1 + rng.uniform(-REST, REST, rows.shape)  # what is infinite stays so
    return rows


def special(features: tuple[ir.FeatureSpec, ...], rng: np.random.Generator, numbers: str = FLOAT32) -> Floats:
    """Each feature at each special value among random ones, and all features at it at once. [n, n_features]"""
    n, values = len(features), SPECIAL[numbers]
    fillings = _fillings(FILLINGS, n * len(values) * n)
    rows = np.repeat(random(features, fillings, rng, numbers), n * len(values), axis=0)
    rows = rows.reshape(fillings, n, len(values), n)
    for feature in range(n):
        rows[:, feature, :, feature] = values
    return np.concatenate([rows.reshape(-1, n), np.repeat(values[:, None], n, axis=1)])


def _fillings(most: int, numbers: int, at_most: int = NUMBERS_AT_MOST) -> int:
    """Returns the number of random completions, at least one; `numbers`: in all rows with one completion each."""
    return max(1, min(most, at_most // max(1, numbers)))


def ends(features: tuple[ir.FeatureSpec, ...], rng: np.random.Generator, numbers: str = FLOAT32) -> Floats:
    """Observations within the ranges, but for one feature at an end of its range or at a neighbour. [n, n_features]"""
    rows = [np.zeros((0, len(features)), dtype=numbers)]
    fillings = _fillings(FILLINGS // 4, 6 * len(features) ** 2)
    for place, feature in enumerate(features):
        low, high = at_most(feature.low, numbers), -at_most(-feature.high, numbers)
        for value in (*neighbours(low, numbers), *neighbours(high, numbers)):
            filled = random(features, fillings, rng, numbers)
            filled[:, place] = value
            rows.append(filled)
    return np.concatenate(rows)


def random(
    features: tuple[ir.FeatureSpec, ...], count: int, rng: np.random.Generator, numbers: str = FLOAT32
) -> Floats:
    """Uniform in the features' ranges, half in the inner third, where most thresholds lie. [count, n_features]"""
    nothing = np.zeros((0, len(features)), numbers)
    return np.concatenate([nothing, *random_parts(features, count, rng, numbers)])


def random_parts(
    features: tuple[ir.FeatureSpec, ...], count: int, rng: np.random.Generator, numbers: str = FLOAT32
) -> Iterator[Floats]:
    """The rows of `random` in parts, which bounds their memory."""
    low, high = np.array([[feature.low for feature in features], [feature.high for feature in features]])
    middle = (low + high) / 2
    for start in range(0, count, DRAWN_AT_ONCE):
        rows = _uniform(rng, low, high, (min(DRAWN_AT_ONCE, count - start), len(features)))
        inner = slice(0, max(0, count // 2 - start))  # of the first half of all rows
        rows[inner] = middle + (rows[inner] - middle) / 3
        yield rows.astype(numbers)


def doubles(tree: Tree, features: tuple[ir.FeatureSpec, ...], rng: np.random.Generator) -> Float64:
    """Double observations at and beside the doubles that decide: they must act as the tree's numbers say."""
    rows: list[Float64] = [np.zeros((0, len(features)))]
    splits = list(ir.splits(tree))
    fillings = _fillings(FILLINGS, 3 * len(splits) * len(features), DOUBLES_AT_MOST)
    for node in splits:
        turning = float(tree.threshold[node])
        if tree.numbers == FLOAT32:
            turning = deciding_double(turning)
        for value in neighbours(turning, FLOAT64):
            filled = random(features, fillings, rng).astype(np.float64)
            filled[:, int(tree.feature[node])] = value
            rows.append(filled)
    return np.concatenate(rows)


def cast_rows(rows: Float64) -> list[Any]:
    """Some of these observations in numbers of other types, an array for each: what must be turned into doubles first.

    Long doubles and fractions are a little above their double, so that comparing them as they are decides otherwise.
    """
    few = rows[np.random.default_rng(0).permutation(len(rows))[:TYPED]]
    with np.errstate(over="ignore"):  # beyond the largest number of a type is infinity
        arrays: list[Any] = [few.astype(kind) for kind in (np.float16, np.float32)]
        arrays.append(np.nextafter(few.astype(np.longdouble), np.longdouble(np.inf)))
    finite = few[np.isfinite(few).all(axis=1)]  # no fraction is infinite, as what lies beside the largest double
    above = [[_above(x) for x in row] for row in finite.tolist()]
    return [*arrays, np.array(above)]


def _above(x: float) -> Fraction:
    """A little more than a double: by a part of 2^70."""
    over, under = x.as_integer_ratio()
    return Fraction((over << 70) + abs(over), under << 70)


def worlds(profile: ir.PolicyProfile, rng: np.random.Generator) -> Float64:
    """World states in which features tie, are zero, or are anything, [n, n_coordinates] float64.

    Each feature of each split is put at its threshold, or at a neighbour of it, by moving its first coordinate; the
    others are random on a coarse grid, or anywhere.
    """
    names = profile.world.coordinates()
    index = {name: place for place, name in enumerate(names)}
    rows: list[Float64] = [np.zeros((1, len(names)))]
    for policy in profile.agents:
        for node in ir.splits(policy.tree):
            _, first_read = read_by(policy.tree, int(policy.tree.feature[node]), len(policy.features))[0]
            meaning = policy.features[first_read].meaning
            filled = rng.uniform(-2, 2, (FILLINGS, len(names)))
            filled[::2] = np.round(filled[::2] * 4) / 4
            if meaning and meaning.terms:
                (weight, first), *rest = meaning.terms
                near = neighbours(float(policy.tree.threshold[node]), policy.numbers).clip(-HUGE, HUGE)
                at = near[rng.integers(3, size=FILLINGS)].astype(np.float64)
                others = sum((w * filled[:, index[name]] for w, name in rest), np.zeros(FILLINGS))
                filled[:, index[first]] = (at - others) / weight
            rows.append(filled)
    return np.concatenate(rows)


def wild(n_coordinates: int, rng: np.random.Generator) -> Float64:
    """World states that no game meets: huge, tiny, infinite and NaN among ordinary ones, [n, n_coordinates] float64."""
    rows = rng.uniform(-2, 2, (WILD, n_coordinates))
    special = rng.random(rows.shape) < rng.uniform(0, 0.5, (WILD, 1))
    return np.where(special, rng.choice(DOUBLES, rows.shape), rows)


def bordering(region: RegionSpec, world: ir.WorldSpec, rng: np.random.Generator) -> Float64:
    """World states in a region, at and beside each of its borders, and anywhere, [n, n_coordinates] float64."""
    names = world.coordinates()
    index = {name: place for place, name in enumerate(names)}
    drawn = rng.uniform(-2, 2, (100 * AROUND, len(names)))
    for first, second, low, high in read_bounds(region):
        if not second:
            drawn[:, index[first]] = _uniform(rng, low, high, (len(drawn),))
    for _ in range(ROUNDS):  # towards the region, where differences narrow it
        for first, second, low, high in read_bounds(region):
            other = drawn[:, index[second]] if second else 0.0
            drawn[:, index[first]] = other + np.clip(drawn[:, index[first]] - other, low, high)
    if region.goals:
        for axis in "xy":
            drawn[:, index[f"goal.{axis}"]] = drawn[:, index[f"{region.goals[0]}.{axis}"]]
    within = is_inside(region, drawn, names)
    # first what is inside, so that each border is the only one that a state near it may cross
    inside = np.concatenate([drawn[within], drawn[~within]])[:AROUND]
    rows = [inside, rng.uniform(-2, 2, (AROUND, len(names)))]
    moved = [(first, second, end) for first, second, *ends in read_bounds(region) for end in ends]
    moved += [(f"{a}.x", f"{b}.x", side * least) for a, b, least in read_distances(region) for side in (1, -1)]
    for first, second, end in moved:
        at = inside.copy()
        beside = np.array([np.nextafter(end, -np.inf), end, np.nextafter(end, np.inf)])
        at[:, index[first]] = beside[rng.integers(3, size=AROUND)] + (at[:, index[second]] if second else 0.0)
        rows.append(at)
    return np.concatenate(rows)


# --- where sums are tested or given


def ties(policy: ir.AgentPolicy, rng: np.random.Generator) -> Floats:
    """For each split, observations that reach it, with what it tests at the threshold and at neighbours."""
    pool = random(policy.features, POOL, rng, policy.numbers)
    # equal numbers, zeros of both signs and whole numbers, whose sums are exact
    pool[::4] = np.round(pool[::4])
    pool[1::8] = np.where(rng.random(pool[1::8].shape) < 0.5, np.abs(pool[1::8]), -np.abs(pool[1::8]))
    batches = [np.zeros((0, len(policy.features)), policy.numbers)]
    tree, at = policy.tree, ir.apply(policy.tree, pool)
    coming = {int(leaf): np.flatnonzero(at == leaf) for leaf in ir.leaves(tree)}  # rows of the pool, by node
    for node in reversed(list(ir.splits(tree))):  # preorder: children come after their parents
        coming[node] = np.concatenate([coming[int(tree.left[node])], coming[int(tree.right[node])]])
    for node in ir.splits(tree):
        rows = coming[node]
        drawn = pool[rng.choice(rows, AT_TIE)] if len(rows) else pool[rng.integers(len(pool), size=AT_TIE)]
        batches += _move_rows(policy, node, drawn, rng)
    return np.concatenate(batches)


def _move_rows(policy: ir.AgentPolicy, node: int, rows: Floats, rng: np.random.Generator) -> Iterator[Floats]:
    """Rows with one of the tested features moved so that the test is at its threshold, and beside."""
    tree, n, threshold = policy.tree, len(policy.features), float(policy.tree.threshold[node])
    tested = int(tree.feature[node])
    moved = [(weight, place) for weight, place in read_by(tree, tested, n) if weight]
    if not moved:
        return
    weight, place = moved[int(rng.integers(len(moved)))]
    others = np.full(len(rows), float(tree.sums[tested - n].expand().get(ir.CONSTANT, 0)) if tested >= n else 0.0)
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        for other, where in moved:
            if where != place:
                others += other * rows[:, where].astype(np.float64)
        at = ((threshold - others) / weight).astype(policy.numbers)
    for side in (-np.inf, np.inf):
        value = at
        for _ in range(STEPS + 1):
            beside = rows.copy()
            beside[:, place] = value
            yield beside
            value = neighbour(value, side, policy.numbers)


def wide(n_features: int, rng: np.random.Generator, numbers: str) -> Floats:
    """Numbers of every size and sign, zeros of both signs and repeated ones among them."""
    limits = np.finfo(numbers)
    powers = rng.uniform(limits.minexp - 5, limits.maxexp, (WIDE, n_features))
    near = rng.uniform(-4, 4, (WIDE, 1)) + rng.uniform(-300, 300, (WIDE, 1)) * (rng.random((WIDE, 1)) < 0.2)
    powers = np.where(rng.random((WIDE, 1)) < 0.5, powers, near)  # of like size, so that digits are lost in between
    with np.errstate(over="ignore", under="ignore"):
        rows = (np.exp2(powers) * rng.choice([-1.0, 1.0], powers.shape)).astype(numbers)
    rows = np.where(rng.random(rows.shape) < 0.05, rng.choice([0.0, -0.0], rows.shape), rows).astype(numbers)
    repeated = rng.random((WIDE, n_features)) < 0.1
    return np.where(repeated, rows[:, :1], rows)
