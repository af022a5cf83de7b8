"""Claims over observations: a profile seen as if each number that an agent observes were a coordinate of the world.

Does: derives that profile, its view; names the variables.
Assumes: a checked profile.
Does not: know what an environment can show. In a view every combination of numbers is a state.

The world of a view has no entities and no motion. Its variables are the agents' features, each a number as the agent
compares it: rounded to float32, or the float64 number that it is given. One agent's variables have the names of its
features; of several agents they are named AGENT.FEATURE, or FEATURE alone where it is said that the agents that have it
share it. A view may hold one agent twice: the copy, which stands last and is called AGENT_raised, shares all variables
with it but one; or it is called AGENT_mirrored, shares them all, and observes some with the opposite sign.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Final, NamedTuple

from codegen.errors import InputError, UnknownNameError
from codegen.ir import AgentPolicy, Meaning, PolicyProfile, VariableSpec

RAISED: Final = "_raised"  # ends the name of a copy
MIRRORED: Final = "_mirrored"
MAX_NAME: Final = 64
ADVICE = "rename it where the profile comes from"


class Raised(NamedTuple):
    """One feature of one agent, of which a copy of the agent observes another value."""

    agent: str
    feature: str


class Mirrored(NamedTuple):
    """Features of one agent, of which a copy of the agent observes the opposites; (): all of them."""

    agent: str
    features: tuple[str, ...] = ()


@dataclass(frozen=True)
class View:
    """The way in which the observations of a profile are put together. It has one copy at most."""

    shared: tuple[str, ...] = ()  # features that the agents that have them observe alike
    raised: Raised | None = None
    mirrored: Mirrored | None = None

    @property
    def copied(self) -> str:
        """The agent that stands twice; "": none does."""
        twice = self.raised or self.mirrored
        return "" if twice is None else twice.agent

    @property
    def copy(self) -> str:
        """The name of the copy."""
        return self.copied + (RAISED if self.raised is not None else MIRRORED)

    def original(self, agent: str) -> str:
        """The agent of the profile whose tree an agent of the view has."""
        return self.copied if self.copied and agent == self.copy else agent


def view_from(document: Mapping[str, Sequence[str]]) -> View:
    """The view in a document. ValueError for anything else."""
    raised, mirrored = document.get("raised", ()), document.get("mirrored", ())
    known = set(document) - {"mirrored"} == {"shared", "raised"} and (bool(mirrored) == ("mirrored" in document))
    if not known or len(raised) not in (0, len(Raised._fields)) or (raised and mirrored):
        raise ValueError("$.view: states shared features, and agent and features of a copy")
    opposite = Mirrored(mirrored[0], tuple(mirrored[1:])) if mirrored else None
    return View(tuple(document["shared"]), Raised(*raised) if raised else None, opposite)


def copy_of(agent: str) -> str:
    """The name of an agent's copy."""
    return agent + RAISED


def ensure_several(profile: PolicyProfile, names: Sequence[str]) -> None:
    """UnknownNameError for a feature that no agent has, InputError for one that only one has."""
    several = of_several(profile)
    known = list(dict.fromkeys(feature.name for policy in profile.agents for feature in policy.features))
    for name in names:
        if name not in known:
            raise UnknownNameError("feature", name, known, "--shared")
        if name not in several:
            raise InputError(f"only one agent observes {name}", "--shared", "name features that several agents have")


def of_several(profile: PolicyProfile) -> list[str]:
    """The features that several agents have, in the profile's order."""
    names = [feature.name for policy in profile.agents for feature in policy.features]
    return [name for name in dict.fromkeys(names) if names.count(name) > 1]


@lru_cache(maxsize=16)  # questions, their results and reports speak of one and the same
def over(profile: PolicyProfile, view: View) -> PolicyProfile:
    """The view of a profile. UnknownNameError for an agent or feature that it does not have; InputError for shared
    features with unlike ranges or units, and where a copy's name is taken.
    """
    ensure_several(profile, view.shared)
    policies = [*profile.agents, *_copy(profile, view)]
    variables: dict[str, VariableSpec] = {}
    seen: list[AgentPolicy] = []
    for policy in policies:
        names = [variable(profile, view, policy.agent, feature.name) for feature in policy.features]
        for name, feature in zip(names, policy.features, strict=True):
            one = VariableSpec(name, feature.unit, feature.low, feature.high)
            before = variables.setdefault(name, one)
            if before != one:
                what = f"agents that share {name} give it unlike ranges or units"
                said = ", ".join(f"[{each.low:g}, {each.high:g}] {each.unit}" for each in (before, one))
                raise InputError(what, f"--shared: {said}", "do not share it, or state the same range and unit")
        opposite: tuple[str, ...] = ()
        if view.mirrored is not None and policy.agent == view.copy:
            opposite = view.mirrored.features or tuple(feature.name for feature in policy.features)
        features = tuple(
            replace(feature, meaning=Meaning(((-1.0 if feature.name in opposite else 1.0, name),)))
            for feature, name in zip(policy.features, names, strict=True)
        )
        seen.append(replace(policy, features=features, grown=None))
    alone = replace(profile.world, agents=(), landmarks=(), goals=(), variables=tuple(variables.values()))
    still = replace(alone, dt=0.0, damping=0.0, contact_force=0.0, contact_margin=0.0)  # nothing is said to move
    return replace(profile, world=still, agents=tuple(seen), region=None)


def _copy(profile: PolicyProfile, view: View) -> Iterator[AgentPolicy]:
    if not view.copied:
        return
    agents = [policy.agent for policy in profile.agents]
    if view.copied not in agents:
        raise UnknownNameError("agent", view.copied, agents, "agent")
    policy = profile.policy(view.copied)
    features = [feature.name for feature in policy.features]
    named = (view.raised.feature,) if view.raised is not None else view.mirrored.features if view.mirrored else ()
    for feature in named:
        if feature not in features:
            raise UnknownNameError("feature", feature, features, "feature" if view.raised is not None else "features")
    if view.copy in agents or len(view.copy) > MAX_NAME:
        raise InputError(f"the copy of {view.copied} cannot be called {view.copy}", "agent", ADVICE)
    yield replace(policy, agent=view.copy)


def variable(profile: PolicyProfile, view: View, agent: str, feature: str) -> str:
    """The variable that a feature of an agent of the view is."""
    copied = view.original(agent) != agent
    if copied and view.raised is not None and feature == view.raised.feature:
        return f"{agent}.{feature}"
    alone = len(profile.agents) == 1
    return feature if alone or feature in view.shared else f"{view.original(agent)}.{feature}"
