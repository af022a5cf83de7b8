"""The built-in claims, each declared once: name, words, parameters, and the class that users make it of.

Does: a class for each, from which files, the command line, reports, `maviper verify --list` and `maviper.claims` take
  what they know of it.
Assumes: None is as usual (`maviper verify --list`). What a claim means stands in the class of its name in decisions.py,
  relations.py or episodes.py, which certificates rest on; a parameter's type and help in parameters.py.
Does not: check values, or know a profile: whoever verifies does. It loads no NumPy.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, ClassVar

from verify.claims.parameters import Names, Number, Steps


@dataclass(frozen=True)
class Claim:
    """A built-in claim about a team of a profile; None: the team with as many agents as landmarks.

    For example:

        maviper.verify(team, claims.NoDouble("defenders"))
    """

    name: ClassVar[str]
    words: ClassVar[str]  # what it says of the {team}
    team: str | None = None

    @classmethod
    def parameters(cls) -> tuple[str, ...]:
        """The parameters that it reads beside its team."""
        return tuple(field.name for field in fields(cls) if field.name != "team")

    @property
    def options(self) -> dict[str, Any]:
        """Its parameters that are not None, as options of `maviper.verify`."""
        said = {field.name: getattr(self, field.name) for field in fields(self)}
        return {name: value for name, value in said.items() if value is not None}


# --- about single decisions


@dataclass(frozen=True, kw_only=True)
class _Engaging(Claim):
    margin: Number | None = None  #: length of the world
    radius: Number | None = None  #: length of the world


@dataclass(frozen=True, kw_only=True)
class DistinctTargets(_Engaging):
    """The agents engage different landmarks.

    For example:

        maviper.verify(team, claims.DistinctTargets(margin="1/40"))
    """

    name = "distinct_targets"
    words = (
        "in every world state of the region, the {team} can be matched one-to-one to the landmarks so that each closes "
        "on its own landmark or is at it"
    )


@dataclass(frozen=True, kw_only=True)
class OwnTarget(_Engaging):
    """Each agent engages its own landmark.

    For example:

        maviper.verify(team, claims.OwnTarget(landmarks=["landmark_1", "landmark_0"]))
    """

    name = "own_target"
    words = "in every world state of the region, each of the {team} closes on its fixed landmark or is at it"
    landmarks: Names | None = None


@dataclass(frozen=True, kw_only=True)
class NoDouble(Claim):
    """No landmark has two agents closing on it.

    For example:

        maviper.verify(team, claims.NoDouble(margin=0.05))
    """

    name = "no_double"
    words = "in no world state of the region do two of the {team} close on exactly the same single landmark"
    margin: Number | None = None


@dataclass(frozen=True, kw_only=True)
class Aligned(_Engaging):
    """Each agent closes on a landmark that is ahead of it, by `kappa` times the sideways offset.

    For example:

        maviper.verify(team, claims.Aligned(kappa="1/4"))
    """

    name = "aligned"
    words = (
        "in every world state of the region, the {team} can be matched one-to-one to the landmarks so that each is at "
        "its own landmark, or closes on it and is ahead by at least kappa times the sideways offset"
    )
    kappa: Number | None = None


@dataclass(frozen=True, kw_only=True)
class Assignment(_Engaging):
    """Agents that engage landmarks do so in some one-to-one matching.

    For example:

        maviper.verify(team, claims.Assignment(), region="near.toml")
    """

    name = "assignment"
    words = (
        "in every world state of the region, each of the {team} closes on or is at its landmark in a matching of least "
        "summed L1 distance"
    )


@dataclass(frozen=True, kw_only=True)
class Steady(Claim):
    """Another claim stays true where each feature is off by at most `eps`.

    For example:

        maviper.verify(team, claims.Steady(of=claims.NoDouble(margin=0.05), eps=0.01))
    """

    name = "steady"
    words = "what the claim named by `of` says"
    eps: Number | None = None  #: in the features' units
    of: Claim = DistinctTargets()  #: about single decisions

    @property
    def options(self) -> dict[str, Any]:
        """Its own and the other claim's parameters that are not None, as options of `maviper.verify`."""
        return {**self.of.options, **super().options, "of": self.of.name}


@dataclass(frozen=True, kw_only=True)
class AliveLeaves(Claim):
    """Every leaf decides somewhere.

    For example:

        maviper.verify(team, claims.AliveLeaves("defenders"))
    """

    name = "alive_leaves"
    words = "every leaf of every agent of the {team} is reached in some world state of the region"


@dataclass(frozen=True, kw_only=True)
class Agree(Claim):
    """Two agents always act alike.

    For example:

        maviper.verify(team, claims.Agree(agents=["a", "b"]), shared=["all"])
    """

    name = "agree"
    words = "in every state of the region, the two agents take the action of the same name"
    agents: Names


@dataclass(frozen=True, kw_only=True)
class Differ(Claim):
    """Two agents never act alike.

    For example:

        maviper.verify(team, claims.Differ(agents=["north", "east"]))
    """

    name = "differ"
    words = "in no state of the region do the two agents take the action of the same name"
    agents: Names


@dataclass(frozen=True, kw_only=True)
class Monotone(Claim):
    """Raising a feature never moves an agent's action down in the order, or with `direction` decreasing never up.

    For example:

        maviper.verify(team, claims.Monotone(feature="speed", order=["brake", "coast", "push"]), observations=True)
    """

    name = "monotone"
    words = (
        "if the feature of the agent is raised and all others stay, its action does not move against the direction "
        "(where actions are named, out of these; if decreasing, into them)"
    )
    agent: str | None = None
    feature: str
    direction: str | None = None
    order: Names | None = None  #: all actions, lowest first
    actions: Names | None = None  #: only whether it takes one of these matters: none leaves them


@dataclass(frozen=True, kw_only=True)
class Ignores(Claim):
    """An agent takes the same action whatever value one feature has.

    For example:

        maviper.verify(team, claims.Ignores(feature="noise"), observations=True)
    """

    name = "ignores"
    words = (
        "whatever value the feature of the agent takes while all others stay, it takes the same action "
        "(or, where actions are named, either one of these or none)"
    )
    agent: str | None = None
    feature: str
    actions: Names | None = None  #: only whether it takes one of these matters


@dataclass(frozen=True, kw_only=True)
class Symmetric(Claim):
    """Where features have the opposite sign, an agent takes the opposite action of the order.

    For example:

        maviper.verify(team, claims.Symmetric(order=["left", "stay", "right"]), observations=True)
    """

    name = "symmetric"
    words = "where the mirrored features have the opposite sign, the agent takes the action opposite in the order"
    agent: str | None = None
    features: Names | None = None  #: whose sign changes; None: all
    order: Names | None = None  #: all actions: the first is opposite to the last


# --- about whole episodes


@dataclass(frozen=True, kw_only=True)
class OfEpisodes(Claim):
    """A claim about whole episodes."""

    steps: Steps | None = None
    radius: Number | None = None  #: length of the world


@dataclass(frozen=True, kw_only=True)
class Reaches(OfEpisodes):
    """Each agent comes within the radius of its own landmark at some step.

    For example:

        maviper.verify(team, claims.Reaches(steps=25, radius="2/5"))
    """

    name = "reaches"
    words = (
        "from every start of the region, at rest, each of the {team} comes within {radius} of its own landmark "
        "({own}) at some step up to step {steps}"
    )
    landmarks: Names | None = None


@dataclass(frozen=True, kw_only=True)
class Covers(OfEpisodes):
    """After the last step, the team is matched to the landmarks.

    For example:

        maviper.verify(team, claims.Covers(landmarks=["landmark_0", "landmark_1"]))
    """

    name = "covers"
    words = (
        "from every start of the region, at rest, after {steps} steps the {team} are matched one-to-one to the "
        "landmarks{own}, each within {radius} of its own"
    )
    landmarks: Names | None = None


@dataclass(frozen=True, kw_only=True)
class KeepsApart(OfEpisodes):
    """No agent of the team ever comes too near to the others.

    For example:

        maviper.verify(team, claims.KeepsApart("prey", others=["adversary_0", "adversary_1"]))
    """

    name = "keeps_apart"
    words = (
        "from every start of the region, at rest, each of the {team} stays at least {radius} (L-infinity) "
        "away from {own} {until}"
    )
    others: Names | None = None


@dataclass(frozen=True, kw_only=True)
class StaysIn(OfEpisodes):
    """No agent of the team ever goes farther from the origin than the radius: for ever, unless steps are given.

    For example:

        maviper.verify(team, claims.StaysIn(steps="always", radius=2.5))
    """

    name = "stays_in"
    words = (
        "from every start of the region, at rest, each of the {team} stays within {radius} (L-infinity) of the origin "
        "{until}"
    )


_KINDS: tuple[type[Claim], ...] = (
    *(DistinctTargets, OwnTarget, NoDouble, Aligned, Assignment, Steady, AliveLeaves),
    *(Agree, Differ, Monotone, Ignores, Symmetric, Reaches, Covers, KeepsApart, StaysIn),
)
CLAIMS = {kind.name: kind for kind in _KINDS}
