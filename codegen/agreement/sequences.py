"""Code that remembers, replayed: each memory beside each threshold, then walks, against the reference.

Does: chooses memory and observations; asks the machine of each language; compares the action taken and all that is
  remembered after it.
Assumes: the trees themselves are compared elsewhere; where a walk goes on, the machine's own memory is used.
Does not: build or load what it asks.
"""

from collections.abc import Callable
from itertools import islice, product
from typing import NamedTuple

import numpy as np

from codegen import ir
from codegen.agreement import probes
from codegen.ir import Float64, Floats, Int64
from codegen.memory import initial_memory, step_memory

WALKS, STEPS = 500, 200  # 10^5 decisions
PAIRS, MOST_VALUES = 4_096, 64  # memories together; values of one that are asked where no threshold is
ROWS = 50_000


class Questions(NamedTuple):
    """Observations in order: `rows` [n, n_features], where a memory is NaN the machine goes on from its own, which is
    `known` [n, n_memories]. Before the first one it is asked for its memory alone.
    """

    rows: Float64
    known: Int64

    @property
    def shown(self) -> Float64:
        """The rows as messages name them, one for each answer."""
        return np.concatenate([self.rows[:1], self.rows])


def ask_sequences(policy: ir.AgentPolicy, among: Floats | None = None) -> Questions:
    """The questions of an agent that remembers: first walks from a reset on, then pairs. `among`: observations
    [n, n_observed] from which each number is drawn; default those at its thresholds.
    """
    rng, width = np.random.default_rng(0), len(policy.features) - len(policy.memory)
    told = among if among is not None else np.concatenate(list(probes.telling(policy, rng)))[:, :width]
    if not len(told):
        told = probes.special(policy.features, rng, policy.numbers)[:, :width]
    told = probes.in_type(told, policy)
    walked = np.stack([rng.choice(told[:, place], (WALKS, STEPS)) for place in range(width)], axis=2)
    held = rng.random((WALKS, STEPS)) < rng.random((WALKS, 1))  # as inputs that stay, so that counters get far
    for step in range(1, STEPS):
        walked[held[:, step], step] = walked[held[:, step], step - 1]
    memory = np.empty((WALKS, STEPS, len(policy.memory)), np.int64)
    now, ends = initial_memory(policy)[None].repeat(WALKS, axis=0), _values(policy)
    for place, values in enumerate(ends):
        now[1:, place] = rng.choice(values, WALKS - 1)
    for step in range(STEPS):
        memory[:, step] = now
        now = step_memory(policy, now, walked[:, step])[1]
    given = np.full(memory.shape, np.nan)
    given[1:, 0] = memory[1:, 0]
    walks = np.concatenate([walked.reshape(-1, width), given.reshape(-1, len(ends))], axis=1)
    states = np.array(list(islice(product(*ends), PAIRS)), np.int64)
    beside = told[rng.permutation(len(told))[: max(1, ROWS // len(states))]]
    known = np.repeat(states, len(beside), axis=0)
    pairs = np.concatenate([np.tile(beside, (len(states), 1)), known], axis=1)
    return Questions(
        np.concatenate([walks, pairs]).astype(np.float64), np.concatenate([memory.reshape(-1, len(ends)), known])
    )


def _values(policy: ir.AgentPolicy) -> list[Int64]:
    """The values of each memory that are asked: all of a few, else its ends, and those beside thresholds."""
    tree, width = policy.tree, len(policy.features) - len(policy.memory)
    values: list[Int64] = []
    for place, spec in enumerate(policy.memory, width):
        at = np.floor(tree.threshold[tree.feature == place].astype(np.float64))
        chosen = np.concatenate([at, at + 1, [spec.low, spec.high, spec.initial or 0]])
        if spec.high - spec.low < MOST_VALUES:
            chosen = np.arange(spec.low, spec.high + 1)
        values.append(np.unique(chosen[(spec.low <= chosen) & (chosen <= spec.high)]).astype(np.int64))
    return values


def expected_answers(policy: ir.AgentPolicy, asked: Questions) -> Int64:
    """A reset, then the action taken and the memory after it, by the reference, [1 + n, 1 + n_memories]."""
    width = len(policy.features) - len(policy.memory)
    actions, after = step_memory(policy, asked.known, asked.rows[:, :width])
    return np.concatenate([[[0, *initial_memory(policy)]], np.column_stack([actions, after])]).astype(np.int64)


def drive_machine(step: Callable[[list[float]], int], memory: dict[str, int], rows: Float64) -> Int64:
    """The same of a machine in Python. `memory`: where it keeps what it remembers, after a reset."""
    width, told = rows.shape[1] - len(memory), [[0, *memory.values()]]
    for row in probes.iterate_rows(rows):
        if row[width] == row[width]:  # no NaN
            memory.update(zip(memory, map(int, row[width:]), strict=True))
        told.append([step(row[:width]), *memory.values()])
    return np.array(told, np.int64)
