"""What a policy remembers between its decisions: the reference.

Does: decides for observations beside what is remembered, and says what is remembered next; the rules of memory.
Assumes: a policy whose last features are remembered (`FeatureSpec.initial`).
Does not: keep anything: who calls it does, as maviper's Team.

After a reset each memory has its initial value. A decision reads them as features, behind those that are observed. The
leaf's action then sets some of them, or adds to them, all at once, and keeps the others. Where nobody asks for a
decision, all are kept.
"""

import math
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from codegen.floats import observations
from codegen.ir import AgentPolicy, FeatureSpec, Int32, Int64, Update, act
from codegen.paths import Box, boxes_of

MAX_VALUE = 1 << 24  # up to which each whole number is a float32
Fault = tuple[str, str]  # a path below the agent's, and what is wrong there


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
    return least if low is None else max(least, math.floor(low) + 1), most if high is None else min(
        most, math.floor(high)
    )


def describe_update(update: Update) -> str:
    """`mode := 1`, `timer += 1`."""
    sign = ("+=" if update.value > 0 else "-=") if update.adds else ":="
    return f"{update.memory} {sign} {abs(update.value) if update.adds else update.value}"


def memory_faults(policy: AgentPolicy) -> Iterator[Fault]:
    """Every broken rule about memory, of a policy whose tree is sound."""
    known = {each.name: each for each in policy.memory}
    if not known and not any(each.acts or each.updates for each in policy.actions):
        return
    if policy.features[-len(known) :] != policy.memory or len(known) == len(policy.features):
        yield "features", "some are observed, and those that are remembered come last"
    for each in policy.memory:
        ends = (each.low, each.initial or 0, each.high)
        if any(not abs(end) <= MAX_VALUE or end != int(end) for end in ends) or not ends[0] <= ends[1] <= ends[2]:
            yield "features", f"{each.name} is remembered: low <= initial <= high, whole numbers up to {MAX_VALUE}"
        if each.meaning is not None:
            yield "features", f"{each.name} is remembered, and measures nothing"
    if policy.outputs or any(each.legal_if or each.effect for each in policy.actions):
        yield "actions", "an agent that remembers has no outputs, effects or masks"
    plain = [each.name for each in policy.actions if not each.acts]
    if any(each.acts for each in policy.actions[: len(plain)]):
        yield "actions", "those that are taken come first"
    for place, action in enumerate(policy.actions):
        named = [each.memory for each in action.updates]
        if bool(action.acts) != bool(named) or (action.acts and action.acts not in plain):
            yield f"actions[{place}]", "acts names an action without updates, where there are updates"
        if len({*named}) < len(named) or any(each not in known for each in named):
            yield f"actions[{place}].updates", "each names one thing that is remembered"
        elif any(
            each.value == 0 if each.adds else not _within(each.value, known[each.memory]) for each in action.updates
        ):
            yield f"actions[{place}].updates", "what is set lies in its range, and nothing adds 0"
        elif any(each.adds for each in action.updates):
            yield from _leaving(policy, place, known)


def _within(value: int, spec: FeatureSpec) -> bool:
    return spec.low <= value <= spec.high


def _leaving(policy: AgentPolicy, action: int, known: dict[str, FeatureSpec]) -> Iterator[Fault]:
    """The leaves of an action whose additions may leave a range: their tests have to keep a counter below its end."""
    places = {each.name: place for place, each in enumerate(policy.features)}
    for leaf, box in boxes_of(policy.tree):
        for each in policy.actions[action].updates if policy.tree.action[leaf] == action else ():
            ends = values_in(box, places[each.memory], known[each.memory])
            if (
                each.adds
                and ends[0] <= ends[1]
                and not all(_within(end + each.value, known[each.memory]) for end in ends)
            ):
                yield f"tree[{leaf}]", f"{describe_update(each)} may leave its range: test it before"
