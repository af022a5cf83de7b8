"""What an agent decides, whatever its tree tests and its leaves give: the questions that everybody asks of a policy.

Does: decides by the reference; names what a tree compares and what a leaf does; counts the numbers in a tree; refuses
  profiles with sums, in one sentence, for those who read trees of single tests only.
Assumes: checked policies (check.py); a test goes through all targets and commands, so that none forgets to ask.
Does not: know any target, or a world.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np

from codegen import ir
from codegen.errors import InputError
from codegen.ir import CONSTANT, NO_FEATURE, AgentPolicy, PolicyProfile, Tree, among
from codegen.memory import describe_update
from codegen.wording import NO_UNIT, describe_sum

DIGITS = 3  # of weights, where people read them
VERIFIER = "the verifier"  # who refuses sums
# the targets that take sums, and those that take memory
SUMMING = ("c", "shared", "python", "json", "javascript", "rust", "svg", "onnx", "onnx-old", "jax", "torch")
REMEMBERING = ("c", "python", "javascript", "json", "st")


def decide(policy: AgentPolicy, obs: Any) -> Any:
    """The reference: the actions [batch] int32 of an agent, or the numbers that it gives, [batch, n_outputs]."""
    return ir.outputs(policy, obs) if policy.outputs else ir.act(policy, obs)


def decide_taken(policy: AgentPolicy, obs: Any) -> Any:
    """The actions that are taken, by their places [batch] int32, or numbers as in `decide`."""
    return take_actions(policy, decide(policy, obs))


def decide_at(policy: AgentPolicy, leaf: ir.Int32, obs: ir.Floats) -> Any:
    """The same where the leaf of each observation is known: `leaf` [batch]."""
    return ir.outputs(policy, obs) if policy.outputs else take_actions(policy, policy.tree.action[leaf])


def take_actions(policy: AgentPolicy, chosen: Any) -> Any:
    """The actions that are taken where leaves choose `chosen`, which may change memory, too; numbers as they are."""
    return np.array(policy.taken, np.int32)[chosen] if policy.memory else chosen


def name_outputs(policy: AgentPolicy, obs: Any) -> dict[str, ir.Floats]:
    """The numbers that an agent gives by `AGENT.OUTPUT`, [batch] each; none of an agent that takes actions."""
    if not policy.outputs:
        return {}
    given = ir.outputs(policy, obs)
    return {f"{policy.agent}.{each.name}": given[:, place] for place, each in enumerate(policy.outputs)}


def sums_in(profile: PolicyProfile) -> list[AgentPolicy]:
    """The agents that test sums or give numbers."""
    return [policy for policy in profile.agents if policy.tree.arithmetic]


def only_acts(profile: PolicyProfile) -> bool:
    """Returns True if every agent takes actions, and none gives numbers."""
    return not any(policy.outputs for policy in profile.agents)


def ensure_forgets(profile: PolicyProfile, who: str) -> PolicyProfile:
    """The profile itself; InputError where an agent remembers anything, which `who` does not take."""
    remembering = [policy.agent for policy in profile.agents if policy.memory]
    if remembering:
        advice = f"`maviper show` and `maviper compile --target {','.join(REMEMBERING)}` take it"
        if who == VERIFIER:
            advice += ", and `maviper verify --system` in a world file"
        raise InputError(f"{who} does not take memory yet", f"{', '.join(remembering)}: remembers", advice)
    return profile


def ensure_floats(profile: PolicyProfile, who: str) -> PolicyProfile:
    """The profile itself; InputError where an agent observes whole numbers, which `who` does not take."""
    whole = [policy.agent for policy in profile.agents if policy.whole]
    if whole:
        advice = "import the tree with --numbers float32, or float64 where it has whole numbers of 32 bits"
        raise InputError(f"{who} does not take whole numbers yet", f"{', '.join(whole)}: observes them", advice)
    return profile


def ensure_plain(profile: PolicyProfile, who: str, *, memory: bool = False) -> PolicyProfile:
    """The profile itself; InputError where an agent tests sums of features or gives numbers, which `who` does not take,
    or remembers anything, unless it takes `memory`.

    `who`: such as "the target rust".
    """
    summing = sums_in(profile)
    if summing:
        agents = ", ".join(policy.agent for policy in summing)
        where = "tests of sums" if only_acts(profile) else "numbers as outputs"
        advice = f"`maviper show` and `maviper compile --target {','.join(SUMMING)}` take them"
        raise InputError(f"{who} does not take sums yet", f"{agents}: {where}", advice)
    return profile if memory else ensure_forgets(profile, who)


def read_by(tree: Tree, tested: int, n_features: int) -> tuple[tuple[float, int], ...]:
    """The weights and features, of `n_features`, that a test reads: the one feature, or those of its sum multiplied
    out, 0 for one that cancels.
    """
    if tested < n_features:
        return ((1.0, tested),)
    exact = tree.sums[tested - n_features].expand()
    return tuple((float(weight), place) for place, weight in exact.items() if place != CONSTANT)


def list_operands(policy: AgentPolicy) -> list[str]:
    """Names what tests may compare: the features, and the sums that are tested."""
    names = [feature.name for feature in policy.features]
    return names + [describe_sum(each.terms, names, DIGITS) for each in policy.tree.sums]


def compute_operands(policy: AgentPolicy, observation: ir.Floats) -> list[float]:
    """Computes what the tree's tests compare in an observation [n_features]: its numbers, then the tested sums."""
    return among(observation[None], policy.tree.sums, policy.tree.arithmetic)[0].tolist()


def list_decided(policy: AgentPolicy) -> list[str]:
    """Names what an agent decides: the actions that it takes, or the numbers that it gives."""
    return [each.name for each in policy.outputs or policy.actions if not getattr(each, "acts", "")]


def list_bounds(policy: AgentPolicy) -> list[tuple[str, float | None, float | None]]:
    """The name, low and high of each number that an agent gives, None without a bound; nothing where it acts."""
    return [(each.name, each.low, each.high) for each in policy.outputs]


def shape_decided(policy: AgentPolicy) -> tuple[int, ...]:
    """The shape of one decision: () for an action, (n_outputs,) for numbers."""
    return (len(policy.outputs),) if policy.outputs else ()


def kind_decided(policy: AgentPolicy) -> str:
    """What an agent decides, in one word: `actions` or `outputs`."""
    return "outputs" if policy.outputs else "actions"


def describe_leaf(policy: AgentPolicy, leaf: int) -> str:
    """The action of a leaf, or the sums that it gives, in words."""
    return ", ".join(describe_given(policy, leaf)) or describe_action(policy.actions[int(policy.tree.action[leaf])])


def name_with_updates(action: ir.ActionSpec) -> str:
    """The action that is taken, and what becomes of memory, for use within a sentence: `heat (timer += 1)`."""
    updates = ", ".join(map(describe_update, action.updates))
    return f"{action.acts or action.name} ({updates})" if updates else action.name


def describe_action(action: ir.ActionSpec) -> str:
    """The action that is taken, and what becomes of memory: `heat, timer += 1`."""
    return ", ".join([action.acts or action.name, *map(describe_update, action.updates)])


def describe_given(policy: AgentPolicy, leaf: int) -> Iterator[str]:
    """What a leaf gives for each output, in words; nothing of an agent that takes actions."""
    names = [feature.name for feature in policy.features]
    for place, output in enumerate(policy.outputs):
        each = policy.tree.vectors[int(policy.tree.action[leaf])][place]
        yield f"{output.name} = {describe_sum(each.terms, names, DIGITS)}"


def describe_decision(policy: AgentPolicy, observation: Any, sign: str = " = ", *, units: bool = True) -> str:
    """The decision for one observation [n_features], in words: the action, or each number with its unit."""
    (decided,) = decide(policy, [observation])
    if not policy.outputs:
        return describe_action(policy.actions[int(decided)])
    named = zip(policy.outputs, decided.tolist(), strict=True)
    return ", ".join(
        f"{output.name}{sign}{value:.6g}{' ' + output.unit if units and output.unit not in NO_UNIT else ''}"
        for output, value in named
    )


def size(policy: AgentPolicy) -> int:
    """Counts the numbers in a tree: a test's threshold and a sum's weights, a leaf's action or all of its terms."""
    tree, n = policy.tree, len(policy.features)
    tested: list[int] = tree.feature[tree.feature != NO_FEATURE].tolist()
    chosen: list[int] = tree.action[tree.feature == NO_FEATURE].tolist()
    tests = [1 if each < n else 1 + _count_weights(tree.sums[each - n]) for each in tested]
    given = [sum(map(_count_weights, vector)) for vector in tree.vectors] or [1] * len(policy.actions)
    return sum(tests) + sum(given[each] for each in chosen)


def _count_weights(each: ir.Sum) -> int:
    return sum(len(part.terms) for part in each.parts())
