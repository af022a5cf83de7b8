"""An imported tree replayed against its origin: a count of observations on which both decide the same, or an error.

Does: asks both at every threshold that can be reached and at both its neighbours, at special values, at random.
Assumes: the tree is sound; `act` decides as the origin does.
Does not: know what the origin is.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from codegen.agreement import probes, sum_probes
from codegen.agreement.entries import differing, reference
from codegen.errors import DisagreementError, InputError
from codegen.importers.reading import Answers
from codegen.importers.sourced import choose_rows
from codegen.ir import NO_FEATURE, AgentPolicy, FeatureSpec, Floats, Tree
from codegen.numbers import neighbour
from codegen.sums import among

RANDOM = 4_000
ROWS = 100_000  # at thresholds, beyond which each comes with fewer random values of the other features
MAX_NUMBERS = 1 << 28  # in all observations together: a GiB
WORK = 1 << 24  # rows times numbers of a source
MAX_SPECIAL = 64  # features that are put at special values, one by one


Asks = Callable[[Floats], Floats]


def observations(policy: AgentPolicy, *, nan: bool, finite: bool, asks: Asks | None = None) -> Floats:
    """What both are asked about, [n, n_features]. `asks`: what an origin makes of the tree's own rows. InputError where
    that is more than fits into memory.
    """
    asks = asks or (lambda rows: rows)
    if policy.tree.arithmetic:
        return _keep_rows(policy, asks(np.concatenate(list(_of_sums(policy)))), nan=nan, finite=finite)
    rng, width = np.random.default_rng(0), len(policy.features)
    tested = policy.tree.feature != NO_FEATURE
    n_splits = int(tested.sum())
    fillings = min(max(ROWS // (3 * max(n_splits, 1)), 1), probes.FILLINGS)
    if (3 * fillings * n_splits + 2 * RANDOM) * width > MAX_NUMBERS:
        what = f"{n_splits} splits over {width} features are more than can be replayed"
        raise InputError(what, policy.agent, "give the features that are tested only")
    # around the thresholds, since the range that an imported feature states is no help
    span = 2.0 * min(float(np.abs(policy.tree.threshold).max()) + 1.0, probes.HUGE)
    features = tuple(FeatureSpec(each.name, "none", -span, span, None) for each in policy.features)
    used = np.unique(policy.tree.feature[tested])[:MAX_SPECIAL]
    numbers, values = policy.numbers, probes.SPECIAL[policy.numbers]
    special = probes.random(features, len(used) * len(values), rng, numbers)
    for place, feature in enumerate(used):
        special[place * len(values) : (place + 1) * len(values), feature] = values
    rows = np.concatenate(
        [
            _boundary(policy.tree, width, fillings, span, rng),
            special,
            np.repeat(values[:, None], width, axis=1),
            probes.random(features, RANDOM, rng, numbers),
            _mix_thresholds(policy.tree, probes.random(features, RANDOM, rng, numbers), rng),
        ]
    )
    return _keep_rows(policy, asks(rows), nan=nan, finite=finite)


def source_observations(policy: AgentPolicy, numbers: Sequence[int | float], *, nan: bool, finite: bool) -> Floats:
    """What a source is asked beside that, [n, n_features]: its own numbers and the thresholds, feature by feature and
    in pairs.
    """
    tree, width = policy.tree, len(policy.features)
    most = min(ROWS // 2, MAX_NUMBERS // 8 // width, WORK // (1 + len(numbers)))
    thresholds = [tree.threshold[tree.feature == place].tolist() for place in range(width)]
    columns = choose_rows(numbers, [policy.numbers] * width, thresholds, most)
    return _keep_rows(policy, np.stack(columns, axis=1), nan=nan, finite=finite)


def _keep_rows(policy: AgentPolicy, rows: Floats, *, nan: bool, finite: bool) -> Floats:
    """The observations that may be compared."""
    if policy.tree.arithmetic:
        rows = rows[np.isfinite(rows).all(axis=1)] if finite else rows
        # of finite numbers that are too large a sum may be NaN, too
        sums = (*policy.tree.sums, *(each for vector in policy.tree.vectors for each in vector))
        tested = among(rows, sums, policy.tree.arithmetic)
        return rows if nan else rows[~np.isnan(tested).any(axis=1)]
    left_out = np.zeros(rows.shape, dtype=np.bool_)
    left_out |= False if nan else np.isnan(rows)
    left_out |= np.isinf(rows) if finite else False
    return rows[~left_out.any(axis=1)]


def _of_sums(policy: AgentPolicy) -> Iterator[Floats]:
    """At ties of sums and beside them, numbers of every size, special ones, and random ones."""
    rng, used = np.random.default_rng(0), policy.tree.threshold[policy.tree.feature != NO_FEATURE]
    span = 2.0 * min(float(np.abs(used).max(initial=0.0)) + 1.0, probes.HUGE)
    features = tuple(FeatureSpec(each.name, "none", -span, span, None) for each in policy.features)
    yield from sum_probes.parts(replace(policy, features=features), rng)
    if len(features) <= MAX_SPECIAL:
        yield probes.special(features, rng, policy.numbers)
    yield probes.random(features, RANDOM, rng, policy.numbers)


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
    for feature in np.unique(tree.feature[tree.feature != NO_FEATURE]):
        at = tree.threshold[tree.feature == feature]
        beside = np.stack([neighbour(at, -np.inf, tree.numbers), at, neighbour(at, np.inf, tree.numbers)])
        rows[:, feature] = rng.choice(beside.ravel(), len(rows))
    return rows


def replay_origin(policy: AgentPolicy, act: Callable[[Floats], Any], rows: Floats) -> int:
    """How many observations were compared. DisagreementError for the first one on which tree and origin differ."""
    theirs, every = np.asarray(act(rows)), np.ones(len(rows), bool)
    return compare_answers(policy, rows, Answers(theirs, every, every, lambda place: f"{theirs[place]}"))


def compare_answers(policy: AgentPolicy, rows: Floats, answers: Answers) -> int:
    """How many observations were compared: those that the source takes. DisagreementError for the first one on which
    tree and source differ; InputError where none was compared.
    """
    ours = reference(policy, rows)
    wrong = (differing(policy, ours, answers.told) | ~answers.known) & answers.asked
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
