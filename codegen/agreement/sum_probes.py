"""Observations that tell a right implementation of sums from a wrong one.

Does: observations at ties of every sum that is tested and beside them, along the paths that reach it; numbers of every
  size and sign; doubles that are rounded before they are added.
Assumes: a checked tree with sums; random draws come from a seed.
Does not: run any implementation (selfcheck.py).
"""

from collections.abc import Iterator

import numpy as np

from codegen import ir
from codegen.agreement import probes
from codegen.floats import FLOAT32
from codegen.ir import Float64, Floats
from codegen.numbers import neighbour

POOL = 4_000  # random observations, of which those that reach a split are moved to its ties
EACH = 16  # observations moved to each tie
STEPS = 2  # neighbours of a tie, on each side
WIDE = 4_000
REST = 2.0**-27  # of a number, which rounding to float32 takes away


def parts(policy: ir.AgentPolicy, rng: np.random.Generator) -> Iterator[Floats]:
    """Ties and neighbours, then numbers of every size. [n, n_features] each"""
    yield ties(policy, rng)
    yield wide(len(policy.features), rng, policy.numbers)


def ties(policy: ir.AgentPolicy, rng: np.random.Generator) -> Floats:
    """For each split, observations that reach it, with what it tests at the threshold and at neighbours."""
    pool = probes.random(policy.features, POOL, rng, policy.numbers)
    # equal numbers, zeros of both signs and whole numbers, whose sums are exact
    pool[::4] = np.round(pool[::4])
    pool[1::8] = np.where(rng.random(pool[1::8].shape) < 0.5, np.abs(pool[1::8]), -np.abs(pool[1::8]))
    batches = [np.zeros((0, len(policy.features)), policy.numbers)]
    for node, rows in _reaching(policy.tree, pool):
        drawn = pool[rng.choice(rows, EACH)] if len(rows) else pool[rng.integers(len(pool), size=EACH)]
        batches += _move_rows(policy, node, drawn, rng)
    return np.concatenate(batches)


def _reaching(tree: ir.Tree, pool: Floats) -> Iterator[tuple[int, np.ndarray]]:
    """Every split, with the rows of the pool that come to it."""
    at = ir.apply(tree, pool)
    below = {int(leaf): np.flatnonzero(at == leaf) for leaf in ir.leaves(tree)}
    for node in reversed(list(ir.splits(tree))):  # preorder: children come after their parents
        below[node] = np.concatenate([below[int(tree.left[node])], below[int(tree.right[node])]])
    for node in ir.splits(tree):
        yield node, below[node]


def _move_rows(policy: ir.AgentPolicy, node: int, rows: Floats, rng: np.random.Generator) -> Iterator[Floats]:
    """Rows with one of the tested features moved so that the test is at its threshold, and beside."""
    tree, n, threshold = policy.tree, len(policy.features), float(policy.tree.threshold[node])
    tested = int(tree.feature[node])
    terms = tree.sums[tested - n].terms if tested >= n else ((1.0, tested),)
    moved = [term for term in terms if term[1] != ir.CONSTANT]
    weight, place = moved[int(rng.integers(len(moved)))]
    others = np.zeros(len(rows))
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        for other, where in terms:
            if where != place:
                others += other * (1.0 if where == ir.CONSTANT else rows[:, where].astype(np.float64))
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


def doubles(policy: ir.AgentPolicy, rng: np.random.Generator) -> Float64:
    """Ties as doubles, each number a little away from it: they must count as the agent's numbers."""
    rows = ties(policy, rng).astype(np.float64)
    if policy.numbers == FLOAT32:
        rows *= 1 + rng.uniform(-REST, REST, rows.shape)  # what is infinite stays so
    return rows
