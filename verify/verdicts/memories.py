"""Two profiles that remember the same, as two that remember nothing: an action with other updates is another action.

Does: gives both profiles one list of actions; makes features of what is remembered; says where actions with unlike
  updates do the same: where a counter already is what another action sets it to.
Assumes: profiles whose memory has the same names and initial values, or it refuses them.
Does not: decide.

They are compared where what is remembered is in the ranges of both. That is enough: both begin there alike, and one
leaves the other's range by an update that the other does not make.

Memory is whole, and zones are of real numbers. A test of memory is moved down to a whole number, and what is said of it
is closed and has whole ends. So each zone of it is (a, b] between whole numbers, or ends at one, and holds a whole one.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction

import numpy as np

from codegen.errors import InputError
from codegen.ir import ActionSpec, AgentPolicy, FeatureSpec, PolicyProfile, Update
from codegen.memory import tabulate_updates
from verify.claims.formula import Acts, Formula, below, conjunction, disjunction
from verify.claims.region import Region
from verify.claims.relations import counterpart

ROUNDING = Fraction(1, 1 << 22)  # more than float32 hides beside a number
UNSHARED = "what is remembered has values that no episode may meet"
Does = tuple[str, frozenset[Update]]  # the action that is taken, and what it updates


def unite_actions(first: PolicyProfile, second: PolicyProfile) -> tuple[PolicyProfile, PolicyProfile]:
    """Both profiles with the same actions: those that are taken, then all that change memory. InputError where an agent
    remembers or takes something else in the other one.
    """
    others = {policy.agent: policy for policy in second.agents}
    pairs = [_unite(policy, others[policy.agent]) for policy in first.agents if policy.agent in others]
    united = [{each.agent: each for each in side} for side in zip(*pairs, strict=True)]
    return tuple(  # type: ignore[return-value]
        replace(profile, agents=tuple(of.get(each.agent, each) for each in profile.agents))
        for profile, of in zip((first, second), united, strict=True)
    )


def _unite(one: AgentPolicy, other: AgentPolicy) -> tuple[AgentPolicy, AgentPolicy]:
    if [(each.name, each.initial) for each in one.memory] != [(each.name, each.initial) for each in other.memory]:
        told = " and ".join(", ".join(map(_tell, policy.memory)) or "nothing" for policy in (one, other))
        advice = "name it alike in both sources, and begin with the same; or verify the same claims of both"
        raise InputError(f"{one.agent} remembers different things: {told}", one.agent, advice)
    plain = [[each for each in policy.actions if not each.acts] for policy in (one, other)]
    if plain[0] != plain[1]:
        raise InputError(f"{one.agent} takes different actions in the two profiles", one.agent, "name them alike")
    actions = {_does(each): each for each in plain[0]}
    taken = {each.name for each in plain[0]}
    for each in (each for policy in (one, other) for each in policy.actions if each.acts):
        if _does(each) not in actions:
            name = next(n for n in (each.name, *(f"{each.name}_{k}" for k in range(2, 1_000))) if n not in taken)
            taken.add(name)
            actions[_does(each)] = replace(each, name=name)
    order = {each: place for place, each in enumerate(actions)}
    return _renumber(one, order, [*actions.values()]), _renumber(other, order, [*actions.values()])


def _tell(memory: FeatureSpec) -> str:
    return f"{memory.name} {memory.low:g} to {memory.high:g}, {memory.initial} first"


def _does(action: ActionSpec) -> Does:
    return action.acts or action.name, frozenset(action.updates)


def _renumber(policy: AgentPolicy, order: dict[Does, int], actions: Sequence[ActionSpec]) -> AgentPolicy:
    places = np.array([order[_does(each)] for each in policy.actions])
    chosen = np.where(policy.tree.action >= 0, places[policy.tree.action], policy.tree.action)
    return replace(policy, actions=tuple(actions), tree=replace(policy.tree, action=chosen), grown=None)


def forget(profile: PolicyProfile, other: PolicyProfile) -> PolicyProfile:
    """The profile as if its memory were observed, in the ranges that it and another one have."""
    theirs = {policy.agent: {each.name: each for each in policy.memory} for policy in other.agents}
    return replace(profile, agents=tuple(_forget(policy, theirs.get(policy.agent, {})) for policy in profile.agents))


def _forget(policy: AgentPolicy, others: Mapping[str, FeatureSpec]) -> AgentPolicy:
    if not policy.memory:
        return policy
    width, tree = len(policy.features) - len(policy.memory), policy.tree
    threshold = np.where(tree.feature >= width, np.floor(tree.threshold), tree.threshold)
    features = tuple(_narrow(each, others.get(each.name, each)) for each in policy.features)
    return replace(policy, features=features, tree=replace(tree, threshold=threshold))


def _narrow(one: FeatureSpec, other: FeatureSpec) -> FeatureSpec:
    if one.initial is None:
        return one
    return replace(one, initial=None, low=max(one.low, other.low), high=min(one.high, other.high))


def say_alike(first: PolicyProfile, view: PolicyProfile) -> Callable[[Sequence[str]], Formula]:
    """Returns what says that agents do the same in both profiles, memory included. `view`: the first one, as claims
    over observations read it.
    """

    def state(agents: Sequence[str]) -> Formula:
        return conjunction(*(_alike(first.policy(agent), view.policy(agent)) for agent in agents))

    return state


def _alike(policy: AgentPolicy, viewed: AgentPolicy) -> Formula:
    other, taken = counterpart(policy.agent), policy.taken
    keeps, adds = tabulate_updates(policy)
    names = list(name_memory(viewed, [each.name for each in policy.memory]))
    ways: list[Formula] = []
    for k in range(len(taken)):
        for j in range(len(taken)):
            if taken[k] == taken[j]:
                same = (_same(*each) for each in zip(names, keeps[k], adds[k], keeps[j], adds[j], strict=True))
                ways.append(conjunction(Acts(policy.agent, k), Acts(other, j), *same))
    return disjunction(*ways)


def _same(name: str, kept: int, added: int, kept_there: int, added_there: int) -> Formula:
    """Where both leave the same number: everywhere, nowhere, or at one number."""
    if kept == kept_there:
        return below({}, 0 if added == added_there else -1)
    at = int(added_there - added) if kept else int(added - added_there)
    return conjunction(below({name: 1}, at + 1, strict=True), below({name: -1}, 1 - at, strict=True))


def name_memory(viewed: AgentPolicy, remembered: Sequence[str]) -> tuple[str, ...]:
    """The variables of a view that are what an agent remembers."""
    features = {each.name: each for each in viewed.features}
    return tuple(features[name].meaning.terms[0][1] for name in remembered)  # type: ignore[union-attr]


def list_whole(profile: PolicyProfile) -> set[str]:
    """The variables of a view that are whole numbers, since actions update them."""
    named = {policy.agent: {each.memory for a in policy.actions for each in a.updates} for policy in profile.agents}
    return {name for policy in profile.agents for name in name_memory(policy, sorted(named[policy.agent]))}


def round_whole(number: Fraction) -> Fraction:
    """The whole number that a number in a zone stands for: the next one, unless it is a rounding above one."""
    return Fraction(math.ceil(number - (abs(number) + 1) * ROUNDING))


def make_whole(region: Region, names: Sequence[str]) -> Region:
    """The region with whole bounds of what is remembered. InputError where it holds no whole number, or compares it."""
    box = dict(region.box)
    for name in names:
        low, high = box[name]
        box[name] = type(low)(math.ceil(low)), type(high)(math.floor(high))
        if box[name][0] > box[name][1]:
            raise InputError(f"{name} is remembered, and no whole number is in the region", "--region", "widen it")
    for a, b, _ in region.differences:
        if {a, b} & {*names}:
            raise InputError(f"the region compares {a} and {b}, and memory is compared with numbers", "--region", "")
    return replace(region, box=box)
