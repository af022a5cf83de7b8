"""What can be claimed about whole episodes from rest: `reaches`, `covers`, `keeps_apart`, `stays_in`; a class each.

Does: the data of such a claim, what it says of distances, and its words.
Assumes: landmarks and agents are those of the profile's world.
Does not: decide, play or check.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import combinations, product
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError, UnknownNameError
from codegen.ir import Bool, PolicyProfile
from verify.claims.claim import Parameter, TeamClaim, check_range, ensure_team
from verify.claims.observed import View
from verify.claims.region import Interval
from verify.kinds import ALWAYS, Kind

RADIUS = Fraction(2, 5)
MAX_STEPS = 1_000
PLAYED = 200  # steps of a claim for ever, in which counterexamples are looked for
ORIGIN = ""  # a mark that is no entity: the point from which places are measured
ARENA = Fraction(3)  # in which agents stay, where nobody says another
MAX_RADIUS = 1 << 13  # zones hold lengths below eight times that (episodes/zones.py)
Gaps = npt.NDArray[Any]  # [steps, ...] L-infinity distances: float64, or exact
Between = Callable[[str, str], Interval]  # of an entity and an axis: least and greatest place
Pairs = tuple[tuple[int, int], ...]  # pairs: the number of an agent in the team, and of a mark


@dataclass(frozen=True)
class EpisodeClaim(TeamClaim):
    """A claim about whole episodes from rest: about distances of the team's agents from some marks."""

    kind: ClassVar[Kind] = Kind.EPISODES
    limits: ClassVar[tuple[str, ...]] = ("max_zones",)
    title: ClassVar[str]  # the name of the property
    words: ClassVar[str]
    whom: ClassVar[str]  # the parameter that names entities
    nobody_named: ClassVar[str]  # what it means where that is empty
    always: ClassVar[bool] = True  # whether every step counts, or the last one only
    apart: ClassVar[bool] = False  # whether distances are to be large
    landmark_each: ClassVar[bool] = True  # whether it speaks of a landmark for each agent
    lasting: ClassVar[bool] = False  # whether it may be claimed for ever
    of_the_world: ClassVar[tuple[str, ...]] = ("steps",)  # parameters whose usual value the world says
    usually: ClassVar[Mapping[str, Parameter]] = {}  # others that are no defaults of its fields

    steps: int
    radius: Fraction = RADIUS
    ever: bool = field(default=False, kw_only=True)  # about all steps; `steps`: in which counterexamples are looked for

    @property
    def by_edges(self) -> bool:
        """Whether a proof holds for any number of steps."""
        return self.ever

    @property
    def name(self) -> str:
        """The name of the property."""
        return self.title

    @property
    def named(self) -> tuple[str, ...]:
        """The entities that the claim names."""
        return getattr(self, self.whom) if self.whom else ()

    @property
    def sentence(self) -> str:
        """The claim in words."""
        until = "for ever" if self.ever else f"up to step {self.steps}"
        own = self._own(self.named)
        return self.words.format(team=self.team, radius=self.radius, steps=self.steps, own=own, until=until)

    @property
    def parameters(self) -> Mapping[str, Parameter]:
        """What the claim reads beside its team."""
        said: dict[str, Parameter] = {"steps": ALWAYS if self.ever else self.steps, "radius": self.radius}
        return said | ({self.whom: self.named} if self.whom else {})

    def of_view(self, view: View) -> View:
        """Never: InputError."""
        what = f"{self.name} is about episodes, and observations alone do not say what comes next"
        raise InputError(what, "", "ask about single decisions")

    @classmethod
    def reads(cls) -> tuple[str, ...]:
        """The names of the parameters."""
        return ("steps", "radius", cls.whom) if cls.whom else ("steps", "radius")

    @classmethod
    def usual(cls, profile: PolicyProfile, team: str, given: Mapping[str, Any]) -> dict[str, Any]:
        """The parameters that a profile and those given make usual."""
        return {"steps": profile.world.episode_steps}

    @classmethod
    def in_general(cls) -> str:
        """The claim in words, without values."""
        until = "up to step `steps`, or for ever" if cls.lasting else ""
        return cls.words.format(team="team", radius="`radius`", steps="`steps`", own=cls._own(None), until=until)

    @staticmethod
    def _own(named: tuple[str, ...] | None) -> str:
        """Words for the entities named; None: for any."""
        raise NotImplementedError

    @property
    def arrival(self) -> "Arrival | None":
        """The claim itself, if it is one to arrive."""
        return None

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
        return episode if self.always else episode[-1:]

    def mark_of(self, profile: PolicyProfile, number: int, gaps: Gaps) -> int:
        """The mark that is named with an agent of the team, for its distances [steps + 1, marks] in an episode."""
        raise NotImplementedError

    def worst(self, gaps: Gaps) -> int:
        """The step of [steps + 1] distances of a pair that is told first."""
        return int(gaps.argmin())

    @property
    def farthest(self) -> Fraction | None:
        """How far from the origin the team may go; None where the claim does not say."""
        return None

    def describe_broken(self, profile: PolicyProfile, between: Between) -> str:
        """What is not shown by bounds of where everybody ever is, in words; "" where they show the claim."""
        return f"edges do not show {self.name}"

    @classmethod
    def resolve_steps(cls, given: Mapping[str, Any]) -> dict[str, Any]:
        """Parameters with their `steps` as claims have them: ALWAYS is any number. InputError where no claim of this
        name speaks of all steps.
        """
        if given.get("steps") != ALWAYS:
            return {**given, "ever": False}
        if not cls.lasting:
            names = " and ".join(name for name, kind in EPISODE_CLAIMS.items() if kind.lasting)
            what = f"{cls.title} is about a number of steps, not about all steps"
            raise InputError(what, "steps", f"give a number; {names} may be claimed for ever")
        return {**given, "steps": PLAYED, "ever": True}

    def ensure(self, profile: PolicyProfile) -> None:
        """InputError for a claim about nobody, which would be true whatever the profile does."""
        ensure_team(profile, self.team)

    def check_ranges(self) -> None:
        """InputError for a parameter out of its range."""
        check_range("steps", self.steps, MAX_STEPS)
        check_range("radius", self.radius, MAX_RADIUS)


@dataclass(frozen=True)
class Arrival(EpisodeClaim):
    """That each agent of the team comes near a landmark of its own."""

    whom = "landmarks"
    nobody_named = "any matching"

    landmarks: tuple[str, ...] = ()  # one for each agent of the team; empty: any matching will do

    @property
    def arrival(self) -> "Arrival":
        """The claim itself."""
        return self

    def marks(self, profile: PolicyProfile) -> list[str]:
        """The landmarks."""
        return [entity.name for entity in profile.world.landmarks]

    def way(self, profile: PolicyProfile) -> Pairs | None:
        """Each agent with its landmark, where these are named."""
        marks = self.marks(profile)
        return tuple(enumerate(marks.index(name) for name in self.landmarks)) or None

    def mark_of(self, profile: PolicyProfile, number: int, gaps: Gaps) -> int:
        """The agent's own landmark; where any matching would do the one that it ends nearest to."""
        return self.marks(profile).index(self.landmarks[number]) if self.landmarks else int(gaps[-1].argmin())


@dataclass(frozen=True)
class Reaches(Arrival):
    """That each agent comes near at some step."""

    title = "reaches"
    words = (
        "from every start of the region, at rest, each of the {team} comes within {radius} of its own landmark "
        "({own}) at some step up to step {steps}"
    )

    def __post_init__(self) -> None:
        """InputError without landmarks: of any matching each agent might be near another landmark at another step."""
        if not self.landmarks:
            raise InputError(
                f"{self.name} is about each agent's own landmark, but none is named",
                "landmarks",
                "name one for each agent, or claim covers, for which any matching will do",
            )

    @classmethod
    def usual(cls, profile: PolicyProfile, team: str, given: Mapping[str, Any]) -> dict[str, Any]:
        """A whole episode, and the landmarks in the world's order."""
        marks = [entity.name for entity in profile.world.landmarks][: len(profile.team(team))]
        return super().usual(profile, team, given) | {"landmarks": tuple(marks)}

    @staticmethod
    def _own(named: tuple[str, ...] | None) -> str:
        return "in the order of `landmarks`" if named is None else ", ".join(named)


@dataclass(frozen=True)
class Covers(Arrival):
    """That the team is near after the last step."""

    title = "covers"
    words = (
        "from every start of the region, at rest, after {steps} steps the {team} are matched one-to-one to the "
        "landmarks{own}, each within {radius} of its own"
    )
    always = False

    @staticmethod
    def _own(named: tuple[str, ...] | None) -> str:
        if named is None:
            return " (in the order of `landmarks`, if given)"
        return f" (in this order: {', '.join(named)})" if named else ""


@dataclass(frozen=True)
class KeepsApart(EpisodeClaim):
    """That no agent of the team comes near some others."""

    title = "keeps_apart"
    words = (
        "from every start of the region, at rest, each of the {team} stays at least {radius} (L-infinity) "
        "away from {own} {until}"
    )
    whom = "others"
    nobody_named = "one another"
    apart = lasting = True
    landmark_each = False
    of_the_world = ("steps", "radius")

    others: tuple[str, ...] = ()  # empty: the team's own agents

    @classmethod
    def usual(cls, profile: PolicyProfile, team: str, given: Mapping[str, Any]) -> dict[str, Any]:
        """A whole episode, and the largest distance at which two of them touch. InputError where there are no two."""
        claim = cls(team, 0, others=given.get("others", ()))
        claim.ensure(profile)
        sizes = {one.name: Fraction(str(one.size)) for one in profile.world.agents + profile.world.landmarks}
        touching = max(sizes[a] + sizes[b] for a, b in claim.pairs(profile))
        return super().usual(profile, team, given) | {"radius": touching}

    @staticmethod
    def _own(named: tuple[str, ...] | None) -> str:
        if named is None:
            return "each of the `others` (without these, of the team)"
        return ", ".join(named) or "all others of them"

    def marks(self, profile: PolicyProfile) -> list[str]:
        """Those from whom the team keeps apart."""
        return list(self.others) or [policy.agent for policy in profile.team(self.team)]

    def pairs(self, profile: PolicyProfile) -> list[tuple[str, str]]:
        """Who keeps apart from whom, each pair once, an agent of the team first."""
        team = [policy.agent for policy in profile.team(self.team)]
        pairs = product(team, self.others) if self.others else combinations(team, 2)
        return list({frozenset(pair): pair for pair in pairs if pair[0] != pair[1]}.values())

    def way(self, profile: PolicyProfile) -> Pairs:
        """All pairs."""
        team, marks = [policy.agent for policy in profile.team(self.team)], self.marks(profile)
        return tuple((team.index(agent), marks.index(other)) for agent, other in self.pairs(profile))

    def describe_broken(self, profile: PolicyProfile, between: Between) -> str:
        """A pair that may be too near on both axes."""
        for one, other in self.pairs(profile):
            both = [(between(one, axis), between(other, axis)) for axis in "xy"]
            if max(max(low - most, least - high) for (low, high), (least, most) in both) < self.radius:
                return f"the edges of {one} and {other} do not keep them {self.radius} apart"
        return ""

    def is_met(self, gaps: Gaps, radius: Fraction | float) -> Bool:
        """Where a pair stays apart."""
        return np.asarray((gaps >= radius).all(axis=0))

    def mark_of(self, profile: PolicyProfile, number: int, gaps: Gaps) -> int:
        """Whom the agent comes nearest to."""
        return int(gaps.min(axis=0).argmin())

    def ensure(self, profile: PolicyProfile) -> None:
        """InputError for entities that there are not, and where nobody keeps apart from anybody."""
        for name in self.others:
            known = [entity.name for entity in profile.world.agents + profile.world.landmarks]
            if name not in known:
                raise UnknownNameError("entity", name, known, "others")
        super().ensure(profile)
        if not self.pairs(profile):
            raise InputError(
                f"{self.name} needs at least two entities",
                f"team {self.team}",
                "name the others to keep apart from",
            )

    def check_ranges(self) -> None:
        """InputError also for a radius that says nothing."""
        super().check_ranges()
        if self.radius == 0:
            raise InputError(f"{self.name} with radius 0 says nothing", "radius", "give a radius above 0")


@dataclass(frozen=True)
class StaysIn(EpisodeClaim):
    """That no agent of the team leaves a square around the origin."""

    title = "stays_in"
    words = (
        "from every start of the region, at rest, each of the {team} stays within {radius} (L-infinity) of the origin "
        "{until}"
    )
    whom = nobody_named = ""
    landmark_each = False
    lasting = True
    of_the_world = ()
    usually: ClassVar[Mapping[str, Parameter]] = {"steps": ALWAYS, "radius": ARENA}

    @property
    def by_edges(self) -> bool:
        """Always: what is proved for ever holds up to any step."""
        return True

    @classmethod
    def usual(cls, profile: PolicyProfile, team: str, given: Mapping[str, Any]) -> dict[str, Any]:
        """The arena, for ever."""
        return dict(cls.usually)

    @staticmethod
    def _own(named: tuple[str, ...] | None) -> str:
        return ""

    def marks(self, profile: PolicyProfile) -> list[str]:
        """The origin."""
        return [ORIGIN]

    def way(self, profile: PolicyProfile) -> Pairs:
        """Each agent with the origin."""
        return tuple((number, 0) for number in range(len(profile.team(self.team))))

    @property
    def farthest(self) -> Fraction:
        """The radius."""
        return self.radius

    def describe_broken(self, profile: PolicyProfile, between: Between) -> str:
        """An agent that may be too far away on some axis."""
        for policy in profile.team(self.team):
            for axis in "xy":
                low, high = between(policy.agent, axis)
                if not -self.radius <= low <= high <= self.radius:
                    return f"the edges of {policy.agent}.{axis} do not lie within {self.radius} of the origin"
        return ""

    def is_met(self, gaps: Gaps, radius: Fraction | float) -> Bool:
        """Where an agent stays."""
        return np.asarray((gaps <= radius).all(axis=0))

    def mark_of(self, profile: PolicyProfile, number: int, gaps: Gaps) -> int:
        """The origin."""
        return 0

    def worst(self, gaps: Gaps) -> int:
        """The step at which the agent is farthest away."""
        return int(gaps.argmax())


EPISODE_CLAIMS: dict[str, type[EpisodeClaim]] = {kind.title: kind for kind in (Reaches, Covers, KeepsApart, StaysIn)}
