"""Claims as they are asked, told and measured: what engines, files and reports read of them, and no certificate needs.

Does: states that every leaf is reached, and formulas of users' own; finds the built-in properties by name; says what
  each claims, in general and of a team, with usual parameters; formulas, regions and views as data that the checker
  reads; an account of each class of claims about episodes: whose distances it means, where they are as claimed.
Assumes: claims of decisions.py, relations.py and episodes.py, of which certificates need no more than is there.
Does not: belong to what proofs rest on, touch files, or play (states/episodes.py).
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any, ClassVar, Generic, TypeVar

import numpy as np
import numpy.typing as npt

from codegen.floats import rational_literal
from codegen.ir import Bool, PolicyProfile
from verify.claims.built_in import CLAIMS
from verify.claims.claim import Parameter
from verify.claims.decisions import BY_NAME, OWN, DecisionClaim
from verify.claims.episodes import Arrival, Covers, EpisodeClaim, KeepsApart, Reaches, StaysIn
from verify.claims.formula import TRUE, Acts, And, Formula, Goal, Linear, Not
from verify.claims.observed import View
from verify.claims.region import Region
from verify.decimals import text
from verify.kinds import ALWAYS, Kind


@dataclass(frozen=True)
class AliveLeaves(DecisionClaim):
    """That every leaf is reached: no formula over world states, so nothing is claimed of any one of them."""

    kind: ClassVar[Kind] = Kind.LEAVES
    per_state: ClassVar[bool] = False
    of = "alive_leaves"
    reads = ()
    hardens = landmark_each = False

    def states(self, profile: PolicyProfile) -> Formula:
        """Returns TRUE: nothing is claimed of a world state."""
        return TRUE


@dataclass(frozen=True)
class OwnFormula(DecisionClaim):
    """A formula of the user's own."""

    of = OWN
    hardens = landmark_each = False

    statement: Formula = field(kw_only=True)

    @property
    def name(self) -> str:
        """`formula`, whatever errors are allowed."""
        return OWN

    @property
    def parameters(self) -> Mapping[str, Parameter]:
        """The parameters that the claim reads beside its team."""
        return {"margin": self.margin, "radius": self.radius} | ({"eps": self.eps} if self.eps else {})

    def states(self, profile: PolicyProfile) -> Formula:
        """Returns the formula that is claimed where the assumption holds."""
        return self.statement


BUILT_IN: dict[str, type[DecisionClaim]] = {**BY_NAME, AliveLeaves.of: AliveLeaves}


WITH_ERRORS = ", even when every feature{who} is off by up to eps, each by an error of its own"
OF_ALL = " of each of the {team}"  # whose features may be off
WHOSE = {OWN: ""}  # the same, where it is not said
OWN_WORDS = "in every world state of the region, the formula holds for the actions of the {team}"


def spell_rounded(rounded: Iterable[tuple[str, str]]) -> list[str]:
    """The floats that decimals beside features are read as."""
    return [f"{written}, read as {near}" for written, near in rounded]


def spell_decisions(claim: DecisionClaim) -> str:
    """The claim in words, without its assumption."""
    errors = WITH_ERRORS.format(who=WHOSE.get(claim.of, OF_ALL)) if claim.eps else ""
    words = OWN_WORDS if claim.of == OWN else CLAIMS[claim.of].words
    return (words + errors).format(team=claim.team)


def formula_document(node: Formula) -> dict[str, Any]:
    """The formula as plain data; numbers are exact texts."""
    if isinstance(node, Linear):
        terms = [[rational_literal(weight), name] for weight, name in node.terms]
        return {"sum": terms, "below" if node.strict else "most": rational_literal(node.bound)}
    if isinstance(node, Acts):
        return {"agent": node.agent, "takes": node.action}
    if isinstance(node, Goal):
        return {"goal": node.landmark}
    if isinstance(node, Not):
        return {"not": formula_document(node.part)}
    return {"all" if isinstance(node, And) else "any": [formula_document(part) for part in node.parts]}


def region_document(region: Region) -> dict[str, Any]:
    """The region as plain data, numbers as exact text."""
    return {
        "goals": list(region.goals),
        "box": {name: [text(bound) for bound in bounds] for name, bounds in region.box.items()},
        "difference": {f"{a} - {b}": [text(bound) for bound in bounds] for a, b, bounds in region.differences},
        "apart": {f"{a} - {b}": text(least) for a, b, least in region.apart},
    }


def view_document(view: View) -> dict[str, list[str]]:
    """The view as plain data, which `view_from` reads."""
    mirrored = {} if view.mirrored is None else {"mirrored": [view.mirrored.agent, *view.mirrored.features]}
    return {"shared": list(view.shared), "raised": list(view.raised or ()), **mirrored}


ORIGIN = ""  # a mark that is no entity: the point from which places are measured
ARENA = Fraction(3)  # in which agents stay, where nobody says another
Gaps = npt.NDArray[Any]  # [steps, ...] L-infinity distances: float64, or exact
Pairs = tuple[tuple[int, int], ...]  # pairs: the number of an agent in the team, and of a mark
Told = TypeVar("Told", bound=EpisodeClaim)


class Account(Generic[Told]):
    """The words and measurements about a claim."""

    nobody_named: ClassVar[str] = ""  # what it means where the parameter that names entities is empty
    landmark_each: ClassVar[bool] = True  # whether it speaks of a landmark for each agent
    of_the_world: ClassVar[tuple[str, ...]] = ("steps",)  # parameters whose usual value the world says
    usually: ClassVar[Mapping[str, Parameter]] = {}  # others that are no defaults of the claim's fields

    def __init__(self, claim: Told) -> None:
        self.claim = claim

    @property
    def sentence(self) -> str:
        """The claim in words."""
        claim, own = self.claim, self.describe_named(self.claim.named)
        until = "for ever" if claim.ever else f"up to step {claim.steps}"
        return CLAIMS[claim.name].words.format(
            team=claim.team, radius=claim.radius, steps=claim.steps, own=own, until=until
        )

    @staticmethod
    def describe_named(named: tuple[str, ...] | None) -> str:
        """Words for the entities named; None: for any."""
        return ""

    @classmethod
    def usual(cls, profile: PolicyProfile, team: str, given: Mapping[str, Any]) -> dict[str, Any]:
        """The parameters that a profile and those given make usual."""
        return {"steps": profile.world.episode_steps}

    def marks(self, profile: PolicyProfile) -> list[str]:
        """The entities from which distances are measured."""
        raise NotImplementedError

    def way(self, profile: PolicyProfile) -> Pairs | None:
        """The pairs that must have their distances; None: those of any matching of the team and the marks."""
        raise NotImplementedError

    def is_met(self, gaps: Gaps, radius: Fraction | float) -> Bool:
        """Where a pair has its distances, [...], of those after each step that counts; `radius`: of their type."""
        return np.asarray((gaps <= radius).any(axis=0))

    def select_counted(self, episode: Gaps) -> Gaps:
        """Of [steps + 1, ...] the steps that count."""
        return episode if self.claim.always else episode[-1:]

    def mark_of(self, profile: PolicyProfile, number: int, gaps: Gaps) -> int:
        """The mark that is named with an agent of the team, for its distances [steps + 1, marks] in an episode."""
        raise NotImplementedError

    def worst(self, gaps: Gaps) -> int:
        """The step of [steps + 1] distances of a pair that is told first."""
        return int(gaps.argmin())

    @property
    def farthest(self) -> Fraction | None:
        """The largest distance from the origin that the team may reach; None where the claim does not say."""
        return None


class _OfArrival(Account[Arrival]):
    """Of a claim to arrive."""

    nobody_named = "any matching"

    def marks(self, profile: PolicyProfile) -> list[str]:
        """The landmarks."""
        return [entity.name for entity in profile.world.landmarks]

    def way(self, profile: PolicyProfile) -> Pairs | None:
        """Each agent with its landmark, where these are named."""
        marks = self.marks(profile)
        return tuple(enumerate(marks.index(name) for name in self.claim.landmarks)) or None

    def mark_of(self, profile: PolicyProfile, number: int, gaps: Gaps) -> int:
        """The agent's own landmark; where any matching would do the one that it ends nearest to."""
        named = self.claim.landmarks
        return self.marks(profile).index(named[number]) if named else int(gaps[-1].argmin())


class _OfReaches(_OfArrival):
    @classmethod
    def usual(cls, profile: PolicyProfile, team: str, given: Mapping[str, Any]) -> dict[str, Any]:
        """A whole episode, and the landmarks in the world's order."""
        marks = [entity.name for entity in profile.world.landmarks][: len(profile.team(team))]
        return super().usual(profile, team, given) | {"landmarks": tuple(marks)}

    @staticmethod
    def describe_named(named: tuple[str, ...] | None) -> str:
        """The landmarks."""
        return "in the order of `landmarks`" if named is None else ", ".join(named)


class _OfCovers(_OfArrival):
    @staticmethod
    def describe_named(named: tuple[str, ...] | None) -> str:
        """The landmarks, where an order of them is claimed."""
        if named is None:
            return " (in the order of `landmarks`, if given)"
        return f" (in this order: {', '.join(named)})" if named else ""


class _OfKeepsApart(Account[KeepsApart]):
    nobody_named = "one another"
    landmark_each = False
    of_the_world = ("steps", "radius")

    @classmethod
    def usual(cls, profile: PolicyProfile, team: str, given: Mapping[str, Any]) -> dict[str, Any]:
        """A whole episode, and the largest distance at which two of them touch. InputError where there are no two."""
        claim = KeepsApart(team, 0, others=given.get("others", ()))
        claim.ensure(profile)
        sizes = {one.name: Fraction(str(one.size)) for one in profile.world.agents + profile.world.landmarks}
        touching = max(sizes[a] + sizes[b] for a, b in claim.pairs(profile))
        return super().usual(profile, team, given) | {"radius": touching}

    @staticmethod
    def describe_named(named: tuple[str, ...] | None) -> str:
        """Those from whom the team keeps apart."""
        if named is None:
            return "each of the `others` (without these, of the team)"
        return ", ".join(named) or "all others of them"

    def marks(self, profile: PolicyProfile) -> list[str]:
        """Those from whom the team keeps apart."""
        return list(self.claim.others) or [policy.agent for policy in profile.team(self.claim.team)]

    def way(self, profile: PolicyProfile) -> Pairs:
        """All pairs."""
        team, marks = [policy.agent for policy in profile.team(self.claim.team)], self.marks(profile)
        return tuple((team.index(agent), marks.index(other)) for agent, other in self.claim.pairs(profile))

    def is_met(self, gaps: Gaps, radius: Fraction | float) -> Bool:
        """Where a pair stays apart."""
        return np.asarray((gaps >= radius).all(axis=0))

    def mark_of(self, profile: PolicyProfile, number: int, gaps: Gaps) -> int:
        """Whom the agent comes nearest to."""
        return int(gaps.min(axis=0).argmin())


class _OfStaysIn(Account[StaysIn]):
    landmark_each = False
    of_the_world = ()
    usually: ClassVar[Mapping[str, Parameter]] = {"steps": ALWAYS, "radius": ARENA}

    @classmethod
    def usual(cls, profile: PolicyProfile, team: str, given: Mapping[str, Any]) -> dict[str, Any]:
        """The arena, for ever."""
        return dict(cls.usually)

    def marks(self, profile: PolicyProfile) -> list[str]:
        """The origin."""
        return [ORIGIN]

    def way(self, profile: PolicyProfile) -> Pairs:
        """Each agent with the origin."""
        return tuple((number, 0) for number in range(len(profile.team(self.claim.team))))

    def is_met(self, gaps: Gaps, radius: Fraction | float) -> Bool:
        """Where an agent stays."""
        return np.asarray((gaps <= radius).all(axis=0))

    def mark_of(self, profile: PolicyProfile, number: int, gaps: Gaps) -> int:
        """The origin."""
        return 0

    def worst(self, gaps: Gaps) -> int:
        """The step at which the agent is farthest away."""
        return int(gaps.argmax())

    @property
    def farthest(self) -> Fraction:
        """The radius."""
        return self.claim.radius


ACCOUNTS: dict[type[EpisodeClaim], type[Account[Any]]] = {
    Reaches: _OfReaches,
    Covers: _OfCovers,
    KeepsApart: _OfKeepsApart,
    StaysIn: _OfStaysIn,
}


def account_of(claim: EpisodeClaim) -> Account[EpisodeClaim]:
    """The account of a claim."""
    return ACCOUNTS[type(claim)](claim)
