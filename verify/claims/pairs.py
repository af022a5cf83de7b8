"""Two profiles side by side in one world, and the claim that they act alike.

Does: puts the agents of a second profile beside those of the first under names of their own; states that each agent
  takes the same action in both; refuses profiles that cannot be compared.
Assumes: checked profiles.
Does not: decide; belongs to what must be right for a certificate about two profiles to mean something.
"""

from collections.abc import Sequence
from dataclasses import replace

from codegen.errors import InputError, UnknownNameError
from codegen.ir import AgentPolicy, PolicyProfile
from verify.claims.claim import readable
from verify.claims.formula import Acts, Formula, conjunction, disjunction

SECOND = "'"  # ends the names of the second profile's agents; no name of a profile holds it
COMPARED = ("features", "actions", "team")


def counterpart(agent: str) -> str:
    """The name that an agent of the second profile has beside the first."""
    return agent + SECOND


def pair_profiles(first: PolicyProfile, second: PolicyProfile) -> PolicyProfile:
    """Both profiles as one, whose world has the places of the first. No file holds it."""
    others = tuple(replace(policy, agent=counterpart(policy.agent)) for policy in second.agents)
    return replace(first, agents=(*first.agents, *others))


def alike(first: PolicyProfile, agents: Sequence[str]) -> Formula:
    """That each of these agents takes the same action in both profiles."""
    return conjunction(*map(_alike, map(first.policy, agents)))


def _alike(policy: AgentPolicy) -> Formula:
    other = counterpart(policy.agent)
    actions = range(len(policy.actions))
    return disjunction(*(conjunction(Acts(policy.agent, k), Acts(other, k)) for k in actions))


def ensure_comparable(first: PolicyProfile, second: PolicyProfile, agents: Sequence[str]) -> None:
    """InputError unless both are about the same world and these agents observe and may do the same in it, by features
    whose meanings are known; UnknownNameError for an agent that the first profile does not have.
    """
    names, others = ([policy.agent for policy in one.agents] for one in (first, second))
    for agent in agents:
        if agent not in names:
            raise UnknownNameError("agent", agent, names, "--agent")
        if agent not in others:
            raise InputError(f"the second profile has no agent {agent}", "", f"its agents: {', '.join(others)}")
    if not agents:
        raise InputError("no agent is compared", "--agent", f"the agents: {', '.join(names)}")
    if first.world != second.world:
        differing = [name for name in vars(first.world) if getattr(first.world, name) != getattr(second.world, name)]
        what = f"the profiles are about different worlds: {', '.join(differing)}"
        raise InputError(what, "", "compare policies of one world, extracted with the same options")
    for agent in agents:
        one, other = first.policy(agent), second.policy(agent)
        for member in COMPARED:
            if getattr(one, member) != getattr(other, member):
                what = f"{agent} has a different {member}" if member == "team" else f"{agent} has different {member}"
                raise InputError(f"{what} in the two profiles", "", "compare policies that observe and may do the same")
        readable(one)
        readable(other)
