"""What a policy remembers between its decisions: the reference.

Does: decides for observations beside what is remembered, and says what is remembered next.
Assumes: a policy whose last features are remembered (`FeatureSpec.initial`).
Does not: keep anything: who calls it does, as maviper's Team; judge what is remembered (check.py).

After a reset each memory has its initial value. A decision reads them as features, behind those that are observed. The
leaf's action then sets some of them, or adds to them, all at once, and keeps the others. Where nobody asks for a
decision, all are kept.
"""

import math

import numpy as np
import numpy.typing as npt

from codegen.floats import observations
from codegen.ir import AgentPolicy, FeatureSpec, Int32, Int64, Update, act
from codegen.paths import Box

MAX_VALUE = 1 << 24  # up to which each whole number is a float32


def initial_memory(policy: AgentPolicy) -> Int64:
    """What is remembered after a reset, [n_memories]."""
    return np.array([each.initial for each in policy.memory], np.int64)


def step_memory(policy: AgentPolicy, memory: npt.ArrayLike, obs: npt.ArrayLike) -> tuple[Int32, Int64]:
    """Decides: the actions taken, [batch], and what is remembered then, [batch, n_memories].

    `memory`: [batch, n_memories]; `obs`: [batch, n_observed], the features that are not remembered.
    """
    count, known = len(policy.memory), np.asarray(memory, np.int64)
    seen = observations(obs, len(policy.features) - count, policy.agent, policy.numbers)
    chosen = act(policy, np.concatenate([seen, known.astype(policy.numbers)], axis=1))
    keeps, adds = tabulate_updates(policy)
    return np.array(policy.taken, np.int32)[chosen], keeps[chosen] * known + adds[chosen]


def tabulate_updates(policy: AgentPolicy) -> tuple[Int64, Int64]:
    """For each action and memory whether it is kept, 1 or 0, and what is added, [n_actions, n_memories] both."""
    places = {each.name: place for place, each in enumerate(policy.memory)}
    adds = np.zeros((len(policy.actions), len(places)), np.int64)
    keeps = np.ones_like(adds)
    for row, action in enumerate(policy.actions):
        for each in action.updates:
            keeps[row, places[each.memory]], adds[row, places[each.memory]] = each.adds, each.value
    return keeps, adds


def values_in(box: Box, place: int, spec: FeatureSpec) -> tuple[int, int]:
    """The least and most that a memory is in a box."""
    low, high = box.low.get(place), box.high.get(place)
    least, most = int(spec.low), int(spec.high)
    least = least if low is None else max(least, math.floor(low) + 1)
    return least, most if high is None else min(most, math.floor(high))


def describe_update(update: Update) -> str:
    """`mode := 1`, `timer += 1`."""
    sign = ("+=" if update.value > 0 else "-=") if update.adds else ":="
    return f"{update.memory} {sign} {abs(update.value) if update.adds else update.value}"
