"""Claims that compare decisions with one another: of two agents, of one agent in two states, of one in two profiles.

Does: states each as a formula over actions and, of one agent in two states, over a view that holds the agent twice;
  puts the agents of a second profile beside those of the first under names of their own; refuses profiles that cannot
  be compared.
Assumes: checked profiles; as decisions.py; views are those of observed.py.
Does not: know places or landmarks, or decide.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

from codegen.errors import InputError, UnknownNameError
from codegen.ir import AgentPolicy, PolicyProfile
from verify.claims.claim import readable
from verify.claims.decisions import DecisionClaim
from verify.claims.formula import Acts, Formula, below, conjunction, disjunction, negate
from verify.claims.observed import MIRRORED, Mirrored, Raised, View, copy_of

INCREASING, DECREASING = "increasing", "decreasing"
DIRECTIONS: Final = (INCREASING, DECREASING)


@dataclass(frozen=True)
class Agree(DecisionClaim):
    """That two agents take actions of the same name."""

    of = "agree"
    reads = ("agents",)
    hardens = landmark_each = False

    agents: tuple[str, ...] = ()

    def states(self, profile: PolicyProfile) -> Formula:
        """Returns the formula that is claimed where the assumption holds."""
        first, second = ([action.name for action in profile.policy(agent).actions] for agent in self.agents)
        ways = [(first.index(name), second.index(name)) for name in first if name in second]
        a, b = self.agents
        return disjunction(*(conjunction(Acts(a, one), Acts(b, other)) for one, other in ways))

    def ensure(self, profile: PolicyProfile) -> None:
        """InputError unless it names two agents of the team."""
        super().ensure(profile)
        members = [policy.agent for policy in profile.team(self.team)]
        for agent in self.agents:
            if agent not in members:
                raise UnknownNameError("agent", agent, members, "agents")
        if len(set(self.agents)) != 2 or len(self.agents) != 2:
            raise InputError(f"{self.of} is about two agents", "agents", "write two names: agents=[A, B]")


@dataclass(frozen=True)
class Differ(Agree):
    """That two agents never take actions of the same name: of two lights never both are green."""

    of = "differ"

    def states(self, profile: PolicyProfile) -> Formula:
        """Returns the formula that is claimed where the assumption holds."""
        return negate(super().states(profile))


@dataclass(frozen=True)
class _Moving(DecisionClaim):
    """A claim about an agent's action where one feature has another value and all others stay.

    It is about a view in which the agent stands twice, the copy with a value of its own of the feature.
    """

    reads = ("agent", "feature")
    hardens = landmark_each = False

    agent: str = ""
    feature: str = ""

    def of_view(self, view: View) -> View:
        """The view that the claim is about: with a copy of the agent."""
        return replace(view, raised=Raised(self.agent, self.feature))

    def _twice(self, profile: PolicyProfile) -> tuple[AgentPolicy, AgentPolicy, str, str]:
        """The agent, its copy, and the feature's variable of either. LookupError for a profile without the copy."""
        one, other = (profile.policy(name) for name in (self.agent, copy_of(self.agent)))
        return one, other, self._variable(one), self._variable(other)

    def _variable(self, policy: AgentPolicy) -> str:
        meaning = next((one.meaning for one in policy.features if one.name == self.feature), None)
        if meaning is None:
            raise LookupError(self.feature)
        return meaning.terms[0][1]

    def ensure(self, profile: PolicyProfile) -> None:
        """InputError unless agent and feature are the profile's."""
        super().ensure(profile)
        if profile.world.variables and not (self.agent and self.feature):
            raise InputError(f"{self.of} is about one feature of one agent", "", "name them: agent=A, feature=F")
        features = [feature.name for feature in _one_of(self, self.agent, profile).features]
        if self.feature not in features:
            raise UnknownNameError("feature", self.feature, features, "feature")


@dataclass(frozen=True)
class Monotone(_Moving):
    """That raising one feature alone never makes an agent's action fall (or rise), actions being in some order; with
    `actions` that it never makes an agent leave these (or come to them).
    """

    of = "monotone"
    reads = ("agent", "feature", "direction", "order", "actions")

    direction: str = INCREASING
    order: tuple[str, ...] = ()  # all actions, lowest first; empty: in the profile's order
    actions: tuple[str, ...] = ()  # only whether it takes one of these matters; empty: which one it takes

    def states(self, profile: PolicyProfile) -> Formula:
        """Returns the formula claimed where the assumption holds. LookupError for a profile without the copy."""
        lower, higher, low, high = self._twice(profile)
        names = [action.name for action in lower.actions]
        ranks = [names.index(name) for name in self.order or names]
        ranks = ranks[::-1] if self.direction == DECREASING else ranks
        upper = [ranks[k:] for k in range(1, len(ranks))]
        if self.actions:  # the highest ones, or the lowest
            upper = [[k for k in ranks if (names[k] in self.actions) is (self.direction == INCREASING)]]
        above = [(_takes(lower.agent, each), _takes(higher.agent, each)) for each in upper]
        keeps = [disjunction(negate(of_lower), of_higher) for of_lower, of_higher in above]
        return disjunction(negate(below({low: 1, high: -1}, 0)), conjunction(*keeps))

    def ensure(self, profile: PolicyProfile) -> None:
        """InputError unless direction and order too are the profile's."""
        super().ensure(profile)
        if self.direction not in DIRECTIONS:
            raise UnknownNameError("direction", self.direction, DIRECTIONS, "direction")
        _ensure_order(self.order, _one_of(self, self.agent, profile))
        _ensure_known(self.actions, _one_of(self, self.agent, profile))
        if self.order and self.actions:
            raise InputError("monotone is about an order or about some actions", "actions", "leave out one of them")


@dataclass(frozen=True)
class Ignores(_Moving):
    """That an agent takes the same action whatever value one feature has."""

    of = "ignores"
    reads = ("agent", "feature", "actions")

    actions: tuple[str, ...] = ()  # only whether it takes one of these matters; empty: which one it takes

    def states(self, profile: PolicyProfile) -> Formula:
        """Returns the formula claimed where the assumption holds. LookupError for a profile without the copy."""
        one, other, *_ = self._twice(profile)
        names = [action.name for action in one.actions]
        alike = [[names.index(name) for name in self.actions]] if self.actions else [[k] for k in range(len(names))]
        pairs = [(_takes(one.agent, group), _takes(other.agent, group)) for group in alike]
        ways = (disjunction(negate(a), b) for first, second in pairs for a, b in ((first, second), (second, first)))
        return conjunction(*ways)

    def ensure(self, profile: PolicyProfile) -> None:
        """InputError unless the actions too are the profile's."""
        super().ensure(profile)
        _ensure_known(self.actions, _one_of(self, self.agent, profile))


@dataclass(frozen=True)
class Symmetric(DecisionClaim):
    """That where features have the opposite sign, an agent takes the opposite action: the k-th of an order from its
    end.

    It is about a view in which the agent stands twice, the copy with the opposite of these features.
    """

    of = "symmetric"
    reads = ("agent", "features", "order")
    hardens = landmark_each = False

    agent: str = ""
    features: tuple[str, ...] = ()  # empty: all
    order: tuple[str, ...] = ()  # all actions, so that the first is opposite to the last; empty: in the profile's order

    def of_view(self, view: View) -> View:
        """The view that the claim is about: with a mirrored copy of the agent."""
        return replace(view, mirrored=Mirrored(self.agent, self.features))

    def states(self, profile: PolicyProfile) -> Formula:
        """Returns the formula claimed where the assumption holds. LookupError for a profile without the copy."""
        one, other = profile.policy(self.agent), profile.policy(self.agent + MIRRORED)
        names = [action.name for action in one.actions]
        ranks = [names.index(name) for name in self.order or names]
        pairs = zip(ranks, reversed(ranks), strict=True)
        ways = (disjunction(negate(Acts(one.agent, k)), Acts(other.agent, back)) for k, back in pairs)
        return conjunction(*ways)

    def ensure(self, profile: PolicyProfile) -> None:
        """InputError unless agent, features and order are the profile's."""
        super().ensure(profile)
        policy = _one_of(self, self.agent, profile)
        known = [feature.name for feature in policy.features]
        for name in self.features:
            if name not in known:
                raise UnknownNameError("feature", name, known, "features")
        _ensure_order(self.order, policy)


def _one_of(claim: DecisionClaim, agent: str, profile: PolicyProfile) -> AgentPolicy:
    """The agent that a claim over observations is about."""
    if not profile.world.variables:
        raise InputError(f"{claim.of} is about observations", "", "ask with --observations")
    policies = {policy.agent: policy for policy in profile.team(claim.team)}
    if not agent:
        raise InputError(f"{claim.of} is about one agent", "", "name it: agent=A")
    if agent not in policies:
        raise UnknownNameError("agent", agent, list(policies), "agent")
    return policies[agent]


def _ensure_order(order: Sequence[str], policy: AgentPolicy) -> None:
    actions = [action.name for action in policy.actions]
    if order and sorted(order) != sorted(actions):
        raise InputError("order must name every action once", "order", f"actions: {', '.join(actions)}")


def _ensure_known(names: Sequence[str], policy: AgentPolicy) -> None:
    known = [action.name for action in policy.actions]
    for name in names:
        if name not in known:
            raise UnknownNameError("action", name, known, "actions")


def _takes(agent: str, actions: Sequence[int]) -> Formula:
    return disjunction(*(Acts(agent, action) for action in actions))


RELATIONS: dict[str, type[DecisionClaim]] = {kind.of: kind for kind in (Agree, Differ, Monotone, Ignores, Symmetric)}


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
