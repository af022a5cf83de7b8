"""An imported tree replayed against its origin: a count of observations on which both decide the same, or an error.

Does: chooses what both are asked: every threshold that can be reached and both its neighbours, special values, random
  ones; where a source itself is asked, its own numbers, too: each of them, its negation, one more and one less, its
  float32 and float64 neighbours, and special values of the type; one feature at a time, then two.
Assumes: the tree is sound; the origin answers as it decides; all numbers that stand in a source, or that its constants
  are.
Does not: know what the origin is.

Rows of a source's numbers are chosen by column, each an array of the type that it declares, so that whole numbers
beyond 2^24 and 2^53 stay what they are.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import combinations
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from codegen.agreement import probes
from codegen.agreement.entries import STEPS, WALKS, ask_sequences, differing
from codegen.deciding import decide
from codegen.errors import DisagreementError, InputError
from codegen.floats import FLOAT32, FLOAT64
from codegen.importers.reading import Answers, Running
from codegen.ir import NO_FEATURE, AgentPolicy, FeatureSpec, Floats, Int64, Tree
from codegen.memory import step_memory
from codegen.numbers import neighbour
from codegen.sums import among

RANDOM = 4_000
ROWS = 100_000  # at thresholds, beyond which each comes with fewer random values of the other features
MAX_NUMBERS = 1 << 28  # in all observations together: a GiB
WORK = 1 << 24  # rows times numbers of a source
MAX_SPECIAL = 64  # features that are put at special values, one by one
LARGEST = float(np.finfo(np.float64).max)
FILLINGS = 3  # rows for each value of a feature at a source's numbers: the others at zero, then at random values
Numbers: TypeAlias = "Iterable[int | float]"
Column: TypeAlias = "npt.NDArray[Any]"  # [n_rows]


# --- observations at the tree's thresholds


def observations(policy: AgentPolicy, *, nan: bool, finite: bool) -> Floats:
    """Returns the rows that both are asked about, [n, n_features]. InputError for more than fits into memory."""
    tree, width, rng = policy.tree, len(policy.features), np.random.default_rng(0)
    at = tree.threshold[tree.feature != NO_FEATURE]
    fillings = min(max(ROWS // (3 * max(len(at), 1)), 1), probes.FILLINGS)
    if (3 * fillings * len(at) + 2 * RANDOM) * width > MAX_NUMBERS:
        what = f"{len(at)} splits over {width} features are more than can be replayed"
        raise InputError(what, policy.agent, "give the features that are tested only")
    # around the thresholds, since the range that an imported feature states is no help
    span = 2.0 * min(float(np.abs(at).max(initial=0.0)) + 1.0, probes.HUGE)
    features = tuple(FeatureSpec(each.name, "none", -span, span, None) for each in policy.features)
    drawn = probes.random(features, RANDOM, rng, policy.numbers)
    if tree.arithmetic:
        rows = list(probes.telling(replace(policy, features=features), rng))
        rows += [probes.special(features, rng, policy.numbers)] if width <= MAX_SPECIAL else []
    else:
        mixed = _mix_thresholds(tree, drawn.copy(), rng)
        rows = [_boundary(tree, width, fillings, span, rng), _put_special(tree, drawn, rng), mixed]
    return _keep_rows(policy, probes.in_type(np.concatenate([*rows, drawn]), policy), nan=nan, finite=finite)


def _keep_rows(policy: AgentPolicy, rows: Floats, *, nan: bool, finite: bool) -> Floats:
    """The observations that may be compared."""
    tested = rows = rows[~np.isinf(rows).any(axis=1)] if finite else rows
    if policy.tree.arithmetic:  # of finite numbers that are too large a sum may be NaN, too
        sums = (*policy.tree.sums, *(each for vector in policy.tree.vectors for each in vector))
        tested = among(rows, sums, policy.tree.arithmetic)
        nan = nan and not finite
    return rows if nan else rows[~np.isnan(tested).any(axis=1)]


def _put_special(tree: Tree, drawn: Floats, rng: np.random.Generator) -> Floats:
    """Tested features at each special value, one by one among random ones, and all features at once."""
    values, used = probes.SPECIAL[tree.numbers], _sort_distinct(tree.feature[tree.feature != NO_FEATURE])[:MAX_SPECIAL]
    rows = drawn[rng.integers(len(drawn), size=len(used) * len(values))]
    rows[np.arange(len(rows)), np.repeat(used, len(values))] = np.tile(values, len(used))
    return np.concatenate([rows, np.repeat(values[:, None], drawn.shape[1], axis=1)])


def _boundary(tree: Tree, width: int, fillings: int, span: float, rng: np.random.Generator) -> Floats:
    """Observations that reach each split with its feature at the threshold and at both its neighbours, as
    `probes.boundary` makes them, but all at once. [n, width]
    """
    boxes = list(probes.paths(tree, width))
    if not boxes:
        return np.zeros((0, width), dtype=tree.numbers)
    nodes, low, high = (np.array(each) for each in zip(*boxes, strict=True))
    at, numbers = tree.threshold[nodes], tree.numbers
    most = np.dtype(numbers).type(span)
    start = np.maximum(neighbour(low, np.inf, numbers), np.minimum(-most, high))
    stop = np.maximum(np.minimum(high, np.maximum(most, start)), start)
    rows = np.repeat(start[:, None], 3 * fillings, axis=1)
    with np.errstate(over="ignore", invalid="ignore"):  # where an interval is wider than the largest number
        rows += (rng.random(rows.shape, dtype=at.dtype.type) * (stop - start)[:, None]).astype(numbers)
    rows = np.where(np.isfinite(rows), rows, start[:, None]).clip(start[:, None], stop[:, None])
    beside = np.stack([neighbour(at, -np.inf, numbers), at, neighbour(at, np.inf, numbers)], axis=1)
    rows[np.arange(len(nodes)), :, tree.feature[nodes]] = np.repeat(beside, fillings, axis=1)
    return rows.reshape(-1, width)


def _mix_thresholds(tree: Tree, rows: Floats, rng: np.random.Generator) -> Floats:
    """The rows, with every tested feature at or beside one of its thresholds, whatever the path."""
    for feature in _sort_distinct(tree.feature[tree.feature != NO_FEATURE]):
        at = tree.threshold[tree.feature == feature]
        beside = np.stack([neighbour(at, -np.inf, tree.numbers), at, neighbour(at, np.inf, tree.numbers)])
        rows[:, feature] = rng.choice(beside.ravel(), len(rows))
    return rows


# --- observations at the numbers of a source


def source_observations(
    policy: AgentPolicy, running: Running, places: Sequence[int], *, nan: bool, finite: bool
) -> Floats:
    """Returns the rows that a source is asked about, [n, n_features]: what else is asked, in its types, and its own
    numbers. `places`: among the features of the policy, of those of the source.
    """
    tree, width, kinds = policy.tree, len(policy.features), [policy.numbers] * len(policy.features)
    for place, kind in zip(places, running.types, strict=False):
        kinds[place] = policy.numbers if kind == FLOAT64 else kind
    if policy.whole:  # a source may take more than what is observed
        kinds = [kind if np.can_cast(kind, policy.whole) else policy.whole for kind in kinds]
    most = min(ROWS if running.types else ROWS // 2, MAX_NUMBERS // 8 // width, WORK // (1 + len(running.numbers)))
    thresholds = [tree.threshold[tree.feature == place].tolist() for place in range(width)]
    chosen = choose_rows(running.numbers, kinds, thresholds, most)
    rows = observations(policy, nan=nan, finite=finite)
    tested = [_as_type(each, kind) for each, kind in zip(rows.T, kinds, strict=True)]
    pairs = zip(tested, chosen, strict=True)
    rows = np.stack([np.concatenate(pair).astype(np.float64) for pair in pairs], axis=1)
    if policy.whole:
        rows = rows.clip([each.low for each in policy.features], [each.high for each in policy.features])
    with np.errstate(over="ignore"):
        given = rows.astype(policy.numbers)  # which not all whole numbers are
    return _keep_rows(policy, given[((given == rows) | np.isnan(rows)).all(axis=1)], nan=nan, finite=finite)


def _sort_distinct(values: Column) -> Column:
    """Different values, ascending. NumPy, not asked for their places, loads its masked arrays, which takes 25 ms."""
    return np.unique(values, return_index=True)[0]


def _as_type(values: Column, kind: str) -> Column:
    """Numbers as a type has them: whole ones rounded up, and cut to its ends."""
    with np.errstate(over="ignore"):
        if np.dtype(kind).kind == "f":
            return values.astype(kind)
        low, high = (0, 1) if kind == "bool" else (np.iinfo(kind).min, np.iinfo(kind).max)
        return np.nan_to_num(np.ceil(values.astype(np.float64))).clip(low, high).astype(kind)


def list_values(numbers: Numbers, kind: str) -> tuple[Column, Column]:
    """The values of a feature of the NumPy type `kind` at and around numbers, ascending, and special ones beside them.

    float32, float64, bool, and whole numbers of any width. The first list has zero, and no special value but that.
    """
    if np.dtype(kind).kind == "f":
        known = np.array([0.0, *(float(each) for each in numbers if abs(each) <= LARGEST)])
        with np.errstate(all="ignore"):
            at = _sort_distinct(np.concatenate([sign * known + beside for sign in (1, -1) for beside in (0.0, -1, 1)]))
            values = [at]
            for neighbours in (FLOAT32,) if kind == FLOAT32 else (FLOAT32, FLOAT64):
                rounded = at.astype(neighbours)
                values += [rounded, *(np.nextafter(rounded, np.array(end, neighbours)) for end in (-np.inf, np.inf))]
            found = _sort_distinct(np.concatenate([each.astype(kind) for each in values]))
            limits = np.finfo(kind)
            special = np.array([-0.0, np.nan, np.inf, limits.max, limits.tiny, limits.smallest_subnormal], kind)
        return found[np.isfinite(found)], np.concatenate([special, -special[2:]])
    if kind == "bool":
        return np.array([False, True]), np.array([], np.bool_)
    least, most = int(np.iinfo(kind).min), int(np.iinfo(kind).max)
    found = {0, 1, least, most}
    for number in numbers:
        if isinstance(number, int) or math.isfinite(number):
            for whole in (math.floor(number), math.ceil(number)):
                found |= {sign * whole + beside for sign in (1, -1) for beside in (-1, 0, 1)}
    return np.array(sorted(each for each in found if least <= each <= most), kind), np.array([], kind)


def choose_rows(
    numbers: Numbers, kinds: Sequence[str], thresholds: Sequence[Numbers] = (), most: int = ROWS, seed: int = 0
) -> list[Column]:
    """The observations, a column for each feature: each value of each feature, then pairs, `most` rows in all.

    `kinds`: the NumPy type of each feature; `thresholds`: numbers more for each feature. Where there are more pairs, or
    more values, than rows, they are drawn with the seed.
    """
    rng, numbers = np.random.default_rng(seed), list(numbers)
    near, special, known = list[Column](), list[Column](), set(numbers)
    shared = {kind: list_values(numbers, kind) for kind in dict.fromkeys(kinds)}
    for place, kind in enumerate(kinds):
        more = [each for each in thresholds[place] if each not in known] if thresholds else []
        near.append(np.concatenate([shared[kind][0], *([list_values(more, kind)[0]] if more else [])]))
        special.append(shared[kind][1])
    if not kinds:
        return []
    values = [np.concatenate(pair) for pair in zip(near, special, strict=True)]
    first = _draw_places([len(each) for each in special], most, rng)  # special values, then as many others as fit
    first[:, 1] += np.array([len(each) for each in near])[first[:, 0]]
    single = np.concatenate([first, _draw_places([len(each) for each in near], most - len(first), rng)])
    single = np.tile(single, (max(1, min(FILLINGS, most // len(single))), 1))
    chosen = np.concatenate([single, _pair_values([len(each) for each in values], most - len(single), rng)])
    zeros = np.arange(len(chosen)) < len(single) // FILLINGS  # the first filling
    columns = list[Column]()
    for place, (some, each) in enumerate(zip(near, values, strict=True)):
        column = np.where(zeros, some.dtype.type(0), some[rng.integers(len(some), size=len(chosen))])
        for of, at in ((0, 1), (2, 3)):
            put = (chosen[:, of] == place) & (chosen[:, at] >= 0)
            column[put] = each[chosen[put, at]]
        columns.append(column)
    return columns


def _draw_places(counts: Sequence[int], most: int, rng: np.random.Generator) -> npt.NDArray[np.int64]:
    """Features, and the place of a value of each, of all values or of `most`. [n, 4], as `_pair_values` has them."""
    ends, total = np.cumsum(counts), sum(counts)
    drawn = rng.choice(total, min(total, most), replace=False)
    of = np.searchsorted(ends, drawn, side="right")
    return np.stack([of, drawn - ends[of] + np.array(counts)[of], 0 * of, 0 * of - 1], axis=1)


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


# --- calls one after the other


def with_sequences(policy: AgentPolicy, rows: Floats, *, walks: bool) -> tuple[Floats, Int64]:
    """The rows with memory in its ranges, and that memory, [n, n_memories]. Before them come walks from the source's
    own start on, where memory is NaN in the rows. `walks`: whether it takes all observations.
    """
    observed, rows = len(policy.features) - len(policy.memory), rows.copy()
    for place, each in enumerate(policy.memory, observed):
        rows[:, place] = np.rint(np.nan_to_num(rows[:, place]).clip(each.low, each.high))
    known = rows[:, observed:].astype(np.int64)
    if not walks:
        return rows, known
    asked = ask_sequences(policy, rows[:, :observed])
    count = WALKS * STEPS
    walked = asked.rows[:count].astype(policy.numbers)
    return np.concatenate([walked, rows]), np.concatenate([asked.known[:count], known])


# --- the comparison


def compare_answers(policy: AgentPolicy, rows: Floats, answers: Answers, known: Int64 | None = None) -> int:
    """Compares tree and source, and counts the observations that the source takes. DisagreementError for the first one
    on which tree and source differ; InputError where none was compared. `known`: memory before each.
    """
    if known is None:
        ours = decide(policy, rows)
    else:  # the action taken and the memory after it, [n, 1 + n_memories]
        ours = np.column_stack(step_memory(policy, known, rows[:, : -len(policy.memory)]))
    wrong = (differing(ours, answers.told) | ~answers.known) & answers.asked
    for place in np.flatnonzero(wrong)[:1].tolist():
        numbers = ", ".join(f"{float(each)!r}" for each in rows[place][:20])
        does, here = ("gives", "gives") if policy.outputs else ("takes action", "takes")
        what = f"the imported tree {does} {ours[place]} where its origin {here} {answers.word(place)}"
        raise DisagreementError(what, f"{policy.agent}: [{numbers}]", "nothing was written; please report it")
    count = int(answers.asked.sum())
    if len(rows) and not count:
        what = "the assertions of the source hold at none of the observations that were asked"
        raise InputError(what, policy.agent, "assert what an observation may be, or nothing")
    return count
