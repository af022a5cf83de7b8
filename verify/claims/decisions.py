"""What can be claimed about a team's decisions: the built-in properties, one class each, and the predicates in them.

Does: states as formulas when an agent closes on a target, is at it, or is engaged with it; one-to-one matchings of a
  team with the landmarks; each property's class with its parameters, formula and assumption.
Assumes: a checked profile whose features have meanings; actions push along axes.
Does not: decide, read files, or know claims about episodes (episodes.py).

With u(a) the direction of the chosen action, agent i closes on target k iff u(a_i) . (l_k - p_i) > margin; it is at k
iff their L-infinity distance is at most the radius; engaged is either. Lengths are in the world's unit.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field
from fractions import Fraction
from functools import cache, lru_cache
from itertools import combinations, permutations, product
from typing import ClassVar

from codegen.errors import InputError
from codegen.ir import AgentPolicy, PolicyProfile
from verify.claims.claim import Parameter, TeamClaim, check_landmarks, check_range, ensure_landmark_each, ensure_team
from verify.claims.formula import TRUE, Acts, Condition, Formula, below, conjunction, disjunction, negate
from verify.claims.observed import View
from verify.kinds import SEMANTICS, Kind

MAX_MATCHINGS = 720  # six agents and six landmarks: formulas that name every matching stay readable to the engines


def matchings(n_agents: int, n_landmarks: int) -> list[tuple[int, ...]]:
    """Every way to give each agent a landmark of its own, as landmark numbers in the agents' order.

    InputError when there are more than MAX_MATCHINGS.
    """
    count = math.perm(n_landmarks, n_agents)
    if count > MAX_MATCHINGS:
        what = f"{n_agents} agents and {n_landmarks} landmarks have {count:,} matchings, more than {MAX_MATCHINGS}"
        raise InputError(what, "", "claim own_target (in episodes: name the landmarks), which fixes one of them")
    return list(permutations(range(n_landmarks), n_agents))


def closes(policy: AgentPolicy, action: int, target: str, margin: Fraction) -> Formula:
    """The action takes the agent towards the target: u(action) . (l - p) > margin."""
    effect = policy.actions[action].effect or (0.0, 0.0)
    terms: dict[str, Fraction] = {}
    for axis, part in zip("xy", effect, strict=True):
        terms[f"{policy.agent}.{axis}"], terms[f"{target}.{axis}"] = _exact(part), _exact(-part)
    return below(terms, -margin, strict=True)


@lru_cache(maxsize=1 << 10)
def _exact(part: float) -> Fraction:
    return Fraction(part)


def closing(policy: AgentPolicy, target: str, margin: Fraction) -> Formula:
    """The agent's chosen action closes on the target."""
    return disjunction(
        *(
            conjunction(Acts(policy.agent, action), closes(policy, action, target, margin))
            for action in range(len(policy.actions))
        )
    )


def at(agent: str, target: str, radius: Fraction) -> Formula:
    """The L-infinity distance of agent and target is at most the radius."""
    gaps = [{f"{agent}.{axis}": sign, f"{target}.{axis}": -sign} for axis in "xy" for sign in (1, -1)]
    return conjunction(*(below(gap, radius) for gap in gaps))


def ahead(agent: str, landmark: str, direction: tuple[Fraction, Fraction]) -> Formula:
    """The direction's product with the landmark's offset is at most 0."""
    terms: dict[str, Fraction] = {}
    for axis, part in zip("xy", direction, strict=True):
        terms |= {f"{landmark}.{axis}": part, f"{agent}.{axis}": -part}
    return below(terms, 0)


def no_longer(matching: Sequence[tuple[AgentPolicy, str]], other: Sequence[tuple[AgentPolicy, str]]) -> Formula:
    """The L1 length of one matching is at most that of another: some signs of the other's offsets give a sum
    that no signs of the one's exceed.
    """

    def sums(pairs: Sequence[tuple[AgentPolicy, str]]) -> list[dict[str, int]]:
        all_terms: list[dict[str, int]] = []
        for signs in product((1, -1), repeat=2 * len(pairs)):
            terms: dict[str, int] = {}
            for sign, (policy, landmark, axis) in zip(
                signs, [(*pair, axis) for pair in pairs for axis in "xy"], strict=True
            ):
                terms[f"{landmark}.{axis}"] = terms.get(f"{landmark}.{axis}", 0) + sign
                terms[f"{policy.agent}.{axis}"] = terms.get(f"{policy.agent}.{axis}", 0) - sign
            all_terms.append(terms)
        return all_terms

    def difference(a: Mapping[str, int], b: Mapping[str, int]) -> dict[str, int]:
        return {name: a.get(name, 0) - b.get(name, 0) for name in {**a, **b}}

    return disjunction(
        *(conjunction(*(below(difference(own, bound), 0) for own in sums(matching))) for bound in sums(other))
    )


ZERO, RADIUS, KAPPA = Fraction(0), Fraction(1, 10), Fraction(1, 2)
OWN, STEADY = "formula", "steady"  # the names of properties that users state, and of built-in ones that allow errors
Matching = tuple[tuple[AgentPolicy, str], ...]  # agents, each with a landmark of its own


@dataclass(frozen=True)
class DecisionClaim(TeamClaim):
    """A claim about every world state of a region that meets the assumption, whatever errors features have.

    Lengths are in the world's unit. A built-in property that allows errors is called `steady`.
    """

    kind: ClassVar[Kind] = Kind.DECISIONS
    per_state: ClassVar[bool] = True
    limits: ClassVar[tuple[str, ...]] = ("solver_units", "max_cells")
    arithmetics: ClassVar[tuple[str, ...]] = SEMANTICS
    of: ClassVar[str]  # the name of the property, whatever errors it allows
    reads: ClassVar[tuple[str, ...]] = ("margin", "radius")
    hardens: ClassVar[bool] = True  # whether a larger margin asks for more
    any_matching: ClassVar[bool] = False  # whether all that is claimed is that agents are engaged in some matching
    landmark_each: ClassVar[bool] = True  # whether it speaks of a landmark for each agent

    margin: Fraction = ZERO  # for closing, in the claim and in what is told of agents
    radius: Fraction = RADIUS  # for being at a landmark, likewise
    _: KW_ONLY
    eps: Fraction = ZERO  # each feature may be off by so much
    assume: Formula = TRUE  # about world states only
    assumption: str = field(default="", compare=False)  # `assume` as the user wrote it
    written: str = field(default="", compare=False)  # a formula of the user's own, likewise
    conditions: tuple[Condition, ...] = field(default=(), compare=False)  # that some state must meet, with `assume`

    @property
    def name(self) -> str:
        """The name of the property: `steady` where features may be off."""
        return STEADY if self.eps else self.of

    @property
    def parameters(self) -> Mapping[str, Parameter]:
        """The parameters that the claim reads beside its team."""
        own = {name: getattr(self, name) for name in self.reads}
        return {"eps": self.eps, "of": self.of, **own} if self.eps else own

    def states(self, profile: PolicyProfile) -> Formula:
        """Returns the formula that is claimed where the assumption holds."""
        raise NotImplementedError

    def of_view(self, view: View) -> View:
        """The view that the claim is about, where observations are put together as in `view`."""
        return view

    def engagements(self, profile: PolicyProfile) -> list[Matching]:
        """The matchings in one of which all agents are to be engaged; none where another thing is claimed."""
        return []

    def ensure(self, profile: PolicyProfile) -> None:
        """InputError unless the claim is about a team of the profile, and its parameters are in their ranges."""
        if self.landmark_each:
            ensure_landmark_each(self.name, profile, self.team)
        ensure_team(profile, self.team)
        for parameter in ("margin", "radius", "eps"):
            check_range(parameter, getattr(self, parameter))


def engages(policy: AgentPolicy, landmark: str, claim: DecisionClaim) -> Formula:
    """The agent closes on the landmark or is at it."""
    return disjunction(closing(policy, landmark, claim.margin), at(policy.agent, landmark, claim.radius))


def _landmarks(profile: PolicyProfile) -> list[str]:
    return [landmark.name for landmark in profile.world.landmarks]


def _matchings(profile: PolicyProfile, team: str) -> list[Matching]:
    policies, landmarks = profile.team(team), _landmarks(profile)
    return [
        tuple((policy, landmarks[number]) for policy, number in zip(policies, numbers, strict=True))
        for numbers in matchings(len(policies), len(landmarks))
    ]


def _some_matching(found: Sequence[Matching], related: Callable[[AgentPolicy, str], Formula]) -> Formula:
    """In one of the matchings each agent is related to its landmark."""
    # many matchings have few pairs: six agents have 36 in 720
    pairs = {(policy.agent, landmark): (policy, landmark) for matching in found for policy, landmark in matching}
    stated = {pair: related(*given) for pair, given in pairs.items()}
    return disjunction(
        *(conjunction(*(stated[policy.agent, landmark] for policy, landmark in matching)) for matching in found)
    )


class _Engaging(DecisionClaim):
    """That all agents are engaged in one of some matchings."""

    def states(self, profile: PolicyProfile) -> Formula:
        """Returns the formula that is claimed where the assumption holds."""
        return _some_matching(self.engagements(profile), lambda policy, landmark: engages(policy, landmark, self))


@dataclass(frozen=True)
class DistinctTargets(_Engaging):
    """That the team is engaged in some matching."""

    of = "distinct_targets"
    any_matching = True

    def engagements(self, profile: PolicyProfile) -> list[Matching]:
        """All matchings."""
        return _matchings(profile, self.team)


@dataclass(frozen=True)
class OwnTarget(_Engaging):
    """That each agent is engaged with its own landmark."""

    of = "own_target"
    reads = ("margin", "radius", "landmarks")

    landmarks: tuple[str, ...] = ()  # one for each agent of the team; empty: in the world's order

    def engagements(self, profile: PolicyProfile) -> list[Matching]:
        """The one matching that the landmarks are."""
        team = profile.team(self.team)
        return [tuple(zip(team, self.landmarks or _landmarks(profile)[: len(team)], strict=True))]

    def ensure(self, profile: PolicyProfile) -> None:
        """InputError unless the landmarks too are the profile's."""
        super().ensure(profile)
        check_landmarks(profile, self.team, self.landmarks)


@dataclass(frozen=True)
class NoDouble(DecisionClaim):
    """That no two agents close on exactly the same single landmark."""

    of = "no_double"
    reads = ("margin",)
    hardens = False

    def states(self, profile: PolicyProfile) -> Formula:
        """Returns the formula that is claimed where the assumption holds. InputError for a team of one."""
        team, landmarks = profile.team(self.team), _landmarks(profile)

        @cache  # each is part of a claim about every other agent
        def not_only(agent: int, landmark: str) -> Formula:
            policy = team[agent]
            others = (negate(closing(policy, other, self.margin)) for other in landmarks if other != landmark)
            return negate(conjunction(closing(policy, landmark, self.margin), *others))

        if len(team) < 2:
            what = "no_double is about teams of two or more"
            raise InputError(what, f"team {self.team}", "it says nothing about a single agent")
        pairs = combinations(range(len(team)), 2)
        return conjunction(
            *(disjunction(not_only(a, landmark), not_only(b, landmark)) for a, b in pairs for landmark in landmarks)
        )


@dataclass(frozen=True)
class Aligned(DecisionClaim):
    """That in some matching each agent is at its landmark, or closes on it, ahead by kappa times what is sideways."""

    of = "aligned"
    reads = ("margin", "radius", "kappa")

    kappa: Fraction = KAPPA  # least share of ahead in sideways

    def states(self, profile: PolicyProfile) -> Formula:
        """Returns the formula that is claimed where the assumption holds."""
        return _some_matching(_matchings(profile, self.team), self._straight)

    def _straight(self, policy: AgentPolicy, landmark: str) -> Formula:
        ways = [at(policy.agent, landmark, self.radius)]
        for action, spec in enumerate(policy.actions):
            ux, uy = (Fraction(part) for part in spec.effect or (0.0, 0.0))
            sides = [
                ahead(policy.agent, landmark, (sign * self.kappa * -uy - ux, sign * self.kappa * ux - uy))
                for sign in (1, -1)
            ]
            ways.append(conjunction(Acts(policy.agent, action), closes(policy, action, landmark, self.margin), *sides))
        return disjunction(*ways)

    def ensure(self, profile: PolicyProfile) -> None:
        """InputError unless kappa too is in its range."""
        super().ensure(profile)
        check_range("kappa", self.kappa)


@dataclass(frozen=True)
class Assignment(DecisionClaim):
    """That agents are engaged in a matching of the least L1 distance; more than two have too many cases of signs."""

    of = "assignment"

    def states(self, profile: PolicyProfile) -> Formula:
        """Returns the formula that is claimed where the assumption holds. InputError for a team that is not of two."""
        if len(profile.team(self.team)) != 2:
            raise InputError("assignment is defined for teams of two only", f"team {self.team}", "use distinct_targets")
        pairings = _matchings(profile, self.team)
        ways: list[Formula] = []
        for matching in pairings:
            least = [no_longer(matching, other) for other in pairings if other != matching]
            ways.append(conjunction(*least, *(engages(policy, landmark, self) for policy, landmark in matching)))
        return disjunction(*ways)


BY_NAME: dict[str, type[DecisionClaim]] = {
    kind.of: kind for kind in (DistinctTargets, OwnTarget, NoDouble, Aligned, Assignment)
}
PLAIN = tuple(BY_NAME)  # what can be steady


@lru_cache(maxsize=16)  # questions that differ in their budgets, and the checker, ask for the same one
def formula(profile: PolicyProfile, claim: DecisionClaim) -> Formula:
    """The claim as a formula: true in the world states, with the team's chosen actions, in which it holds or where
    its assumption fails. UnknownNameError where its team has no agents: what is said of all of nobody is true.
    """
    ensure_team(profile, claim.team)
    stated = claim.states(profile)
    return stated if claim.assume == TRUE else disjunction(negate(claim.assume), stated)


def ensure_askable(profile: PolicyProfile, claim: DecisionClaim) -> DecisionClaim:
    """The claim itself, if it is about a team of the profile and its parameters are in their ranges."""
    claim.ensure(profile)
    return claim


def ensure_steady(name: str, claim: DecisionClaim) -> None:
    """InputError for a claim that is called `steady` and allows no errors."""
    if name == STEADY and not claim.eps:
        raise InputError("steady needs an eps above 0", "eps", f"verify {claim.of} itself")
