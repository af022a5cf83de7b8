"""Numbers of a profile that are changed on purpose.

Does: puts another threshold at a node, in the tree's own numbers, and says in the provenance what was changed by hand.
Assumes: a checked profile. What was measured, counted or grown before is not true of the new tree, and is left out.
Does not: change which feature is tested, or what a leaf does; play again.
"""

import re
from dataclasses import replace
from numbers import Real
from types import MappingProxyType

import numpy as np

from codegen import ir
from codegen.errors import InputError, UnknownNameError, escape_text
from codegen.ir import AgentPolicy, PolicyProfile
from codegen.numbers import at_most
from codegen.policy_json import content_hash
from codegen.profiles import ensure

BY_HAND = "by hand"  # the end of the keys in a provenance that name a change
BEFORE = "profile before edit"
CHANGE = re.compile(r"(?P<agent>[^/=]+)/(?P<node>[0-9]{1,7})=(?P<value>.+)")


def parse_change(text: str, profile: PolicyProfile) -> tuple[AgentPolicy, int, float]:
    """Whose threshold, at which node, and the number, of a text AGENT/NODE=NUMBER. InputError for another text."""
    found = CHANGE.fullmatch(text)
    if not found:
        raise InputError("a change is AGENT/NODE=NUMBER", escape_text(text[:60]), "such as agent_0/3=0.3")
    known = {policy.agent: policy for policy in profile.agents}
    if found["agent"] not in known:
        raise UnknownNameError("agent", found["agent"], known, escape_text(text[:60]))
    try:
        return known[found["agent"]], int(found["node"]), float(found["value"])
    except ValueError:
        raise InputError("not a number", escape_text(text[:60]), "such as agent_0/3=0.3") from None


def change_threshold(profile: PolicyProfile, policy: AgentPolicy, node: int, value: float) -> PolicyProfile:
    """The profile with another threshold at a split of one of its trees. InputError for a leaf, or no finite number."""
    tree, where = policy.tree, f"{policy.agent}/{node}"
    if node not in range(len(tree.feature)):
        raise InputError(
            f"the tree of {policy.agent} has no node {node!r}", where, f"it has 0 to {len(tree.feature) - 1}"
        )
    if tree.feature[node] == ir.NO_FEATURE:
        splits = ", ".join(map(str, list(ir.splits(tree))[:20]))
        raise InputError(f"node {node} is a leaf, which tests nothing", where, f"splits are {splits or 'none'}")
    if not isinstance(value, Real) or not abs(value) <= float(np.finfo(tree.compared).max):
        raise InputError(f"{value!r} is no finite {tree.compared}", where, "give a number")
    rounded = at_most(value, tree.compared)
    thresholds = tree.threshold.copy()
    before, thresholds[node] = thresholds[node], rounded
    changed = replace(tree, threshold=thresholds, visits=np.zeros(0, np.int64))
    edited = replace(policy, tree=changed, grown=None, seen=())
    facts = dict(profile.provenance.training)
    said = {BEFORE: facts.get(BEFORE, content_hash(profile)), f"{where} {BY_HAND}": f"{before} to {rounded}"}
    provenance = replace(
        profile.provenance, training=MappingProxyType({**facts, **said}), evaluation=MappingProxyType({})
    )
    agents = tuple(edited if each is policy else each for each in profile.agents)
    return ensure(replace(profile, agents=agents, provenance=provenance))
