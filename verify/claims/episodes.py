"""What can be claimed about whole episodes from rest: `reaches`, `covers`, `keeps_apart`, `stays_in`; a class each.

Does: the data of such a claim, and what it asks of bounds of where everybody ever is.
Assumes: landmarks and agents are those of the profile's world.
Does not: decide, play, measure episodes or find words (wording.py).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import combinations, product
from typing import Any, ClassVar

from codegen.errors import InputError, UnknownNameError
from codegen.ir import PolicyProfile
from verify.claims.claim import Parameter, TeamClaim, check_range, ensure_team
from verify.claims.observed import View
from verify.claims.region import Interval
from verify.kinds import ALWAYS, Kind

RADIUS = Fraction(2, 5)
MAX_STEPS = 1_000
PLAYED = 200  # steps of a claim for ever, in which counterexamples are looked for
MAX_RADIUS = 1 << 13  # zones hold lengths below eight times that (episodes/zones.py)
Between = Callable[[str, str], Interval]  # of an entity and an axis: least and greatest place


@dataclass(frozen=True)
class EpisodeClaim(TeamClaim):
    """A claim about whole episodes from rest: about distances of the team's agents from some marks."""

    kind: ClassVar[Kind] = Kind.EPISODES
    limits: ClassVar[tuple[str, ...]] = ("max_zones",)
    title: ClassVar[str]  # the name of the property
    whom: ClassVar[str]  # the parameter that names entities; "": none does
    always: ClassVar[bool] = True  # whether every step counts, or the last one only
    apart: ClassVar[bool] = False  # whether distances are to be large
    lasting: ClassVar[bool] = False  # whether it may be claimed for ever

    steps: int
    radius: Fraction = RADIUS
    ever: bool = field(default=False, kw_only=True)  # about all steps; `steps`: in which counterexamples are looked for

    @property
    def by_edges(self) -> bool:
        """True if a proof holds for any number of steps."""
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
    def parameters(self) -> Mapping[str, Parameter]:
        """The parameters that the claim reads beside its team."""
        said: dict[str, Parameter] = {"steps": ALWAYS if self.ever else self.steps, "radius": self.radius}
        return said | ({self.whom: self.named} if self.whom else {})

    def of_view(self, view: View) -> View:
        """Never: InputError."""
        what = f"{self.name} is about episodes, and observations alone do not say what comes next"
        raise InputError(what, "", "ask about single decisions")

    @property
    def arrival(self) -> "Arrival | None":
        """The claim itself, if it is one to arrive."""
        return None

    def describe_broken(self, profile: PolicyProfile, between: Between) -> str:
        """Describes what is not shown by bounds of where everybody ever is; "" where they show the claim."""
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

    landmarks: tuple[str, ...] = ()  # one for each agent of the team; empty: any matching will do

    @property
    def arrival(self) -> "Arrival":
        """The claim itself."""
        return self


@dataclass(frozen=True)
class Reaches(Arrival):
    """That each agent comes near at some step."""

    title = "reaches"

    def __post_init__(self) -> None:
        """InputError without landmarks: of any matching each agent might be near another landmark at another step."""
        if not self.landmarks:
            raise InputError(
                f"{self.name} is about each agent's own landmark, but none is named",
                "landmarks",
                "name one for each agent, or claim covers, for which any matching will do",
            )


@dataclass(frozen=True)
class Covers(Arrival):
    """That the team is near after the last step."""

    title = "covers"
    always = False


@dataclass(frozen=True)
class KeepsApart(EpisodeClaim):
    """That no agent of the team comes near some others."""

    title = "keeps_apart"
    whom = "others"
    apart = lasting = True

    others: tuple[str, ...] = ()  # empty: the team's own agents

    def pairs(self, profile: PolicyProfile) -> list[tuple[str, str]]:
        """Lists the pairs that keep apart, each pair once, an agent of the team first."""
        team = [policy.agent for policy in profile.team(self.team)]
        pairs = product(team, self.others) if self.others else combinations(team, 2)
        return list({frozenset(pair): pair for pair in pairs if pair[0] != pair[1]}.values())

    def describe_broken(self, profile: PolicyProfile, between: Between) -> str:
        """A pair that may be too near on both axes."""
        for one, other in self.pairs(profile):
            both = [(between(one, axis), between(other, axis)) for axis in "xy"]
            if max(max(low - most, least - high) for (low, high), (least, most) in both) < self.radius:
                return f"the edges of {one} and {other} do not keep them {self.radius} apart"
        return ""

    def ensure(self, profile: PolicyProfile) -> None:
        """InputError for entities that there are not, and where nobody keeps apart from anybody."""
        for name in self.others:
            known = [entity.name for entity in profile.world.agents + profile.world.landmarks]
            if name not in known:
                raise UnknownNameError("entity", name, known, "others")
        super().ensure(profile)
        if not self.pairs(profile):
            what = f"{self.name} needs at least two entities"
            raise InputError(what, f"team {self.team}", "name the others to keep apart from")

    def check_ranges(self) -> None:
        """InputError also for a radius that says nothing."""
        super().check_ranges()
        if self.radius == 0:
            raise InputError(f"{self.name} with radius 0 says nothing", "radius", "give a radius above 0")


@dataclass(frozen=True)
class StaysIn(EpisodeClaim):
    """That no agent of the team leaves a square around the origin."""

    title = "stays_in"
    whom = ""
    lasting = True

    @property
    def by_edges(self) -> bool:
        """Always: what is proved for ever holds up to any step."""
        return True

    def describe_broken(self, profile: PolicyProfile, between: Between) -> str:
        """An agent that may be too far away on some axis."""
        for policy in profile.team(self.team):
            for axis in "xy":
                low, high = between(policy.agent, axis)
                if not -self.radius <= low <= high <= self.radius:
                    return f"the edges of {policy.agent}.{axis} do not lie within {self.radius} of the origin"
        return ""


EPISODE_CLAIMS: dict[str, type[EpisodeClaim]] = {kind.title: kind for kind in (Reaches, Covers, KeepsApart, StaysIn)}
