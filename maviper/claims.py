"""Built-in claims as objects: `maviper.verify(team, claims.Reaches(steps=25))`.

Does: a class for each built-in claim, with the parameters that it reads as typed fields; name and options of one.
Assumes: None is as usual (`maviper verify --list`); `verify.claims.catalogue` finds the claim of a name.
Does not: check values, or know a profile: whoever verifies does.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, ClassVar

from codegen.errors import InputError
from verify.claims.parameters import NAMES, Names, Number, Steps


@dataclass(frozen=True)
class Claim:
    """A built-in claim about a team of a profile; None: the team with as many agents as landmarks."""

    name: ClassVar[str]
    team: str | None = None

    @property
    def options(self) -> dict[str, Any]:
        """Its parameters that are not None, as options of `maviper.verify`."""
        said = {field.name: getattr(self, field.name) for field in fields(self)}
        return {name: value for name, value in said.items() if value is not None}


@dataclass(frozen=True, kw_only=True)
class _Engaging(Claim):
    margin: Number | None = None  #: length of the world
    radius: Number | None = None  #: length of the world


@dataclass(frozen=True, kw_only=True)
class DistinctTargets(_Engaging):
    """The agents engage different landmarks."""

    name = "distinct_targets"


@dataclass(frozen=True, kw_only=True)
class OwnTarget(_Engaging):
    """Each agent engages its own landmark."""

    name = "own_target"
    landmarks: Names | None = None


@dataclass(frozen=True, kw_only=True)
class NoDouble(Claim):
    """No landmark has two agents closing on it."""

    name = "no_double"
    margin: Number | None = None


@dataclass(frozen=True, kw_only=True)
class Aligned(_Engaging):
    """Each agent closes on a landmark that is ahead of it, by `kappa` times the sideways offset."""

    name = "aligned"
    kappa: Number | None = None


@dataclass(frozen=True, kw_only=True)
class Assignment(_Engaging):
    """Agents that engage landmarks do so in some one-to-one matching."""

    name = "assignment"


@dataclass(frozen=True, kw_only=True)
class Steady(Claim):
    """Another claim stays true where each feature is off by at most `eps`."""

    name = "steady"
    of: Claim = DistinctTargets()  #: about single decisions
    eps: Number | None = None  #: in the features' units

    @property
    def options(self) -> dict[str, Any]:
        """Its own and the other claim's parameters that are not None, as options of `maviper.verify`."""
        return {**self.of.options, **super().options, "of": self.of.name}


@dataclass(frozen=True, kw_only=True)
class AliveLeaves(Claim):
    """Every leaf decides somewhere."""

    name = "alive_leaves"


@dataclass(frozen=True, kw_only=True)
class Agree(Claim):
    """Two agents always act alike."""

    name = "agree"
    agents: Names


@dataclass(frozen=True, kw_only=True)
class Differ(Claim):
    """Two agents never act alike."""

    name = "differ"
    agents: Names


@dataclass(frozen=True, kw_only=True)
class Monotone(Claim):
    """Raising a feature never moves an agent's action down in the order, or with `direction` decreasing never up."""

    name = "monotone"
    feature: str
    agent: str | None = None
    direction: str | None = None
    order: Names | None = None  #: all actions, lowest first


@dataclass(frozen=True, kw_only=True)
class Ignores(Claim):
    """An agent takes the same action whatever value one feature has."""

    name = "ignores"
    feature: str
    agent: str | None = None
    actions: Names | None = None  #: only whether it takes one of these matters


@dataclass(frozen=True, kw_only=True)
class Symmetric(Claim):
    """Where features have the opposite sign, an agent takes the opposite action of the order."""

    name = "symmetric"
    agent: str | None = None
    features: Names | None = None  #: whose sign changes; None: all
    order: Names | None = None  #: all actions: the first is opposite to the last


@dataclass(frozen=True, kw_only=True)
class _OfEpisodes(Claim):
    steps: Steps | None = None
    radius: Number | None = None  #: length of the world


@dataclass(frozen=True, kw_only=True)
class Reaches(_OfEpisodes):
    """Each agent comes within the radius of its own landmark at some step."""

    name = "reaches"
    landmarks: Names | None = None


@dataclass(frozen=True, kw_only=True)
class Covers(_OfEpisodes):
    """After the last step, the team is matched to the landmarks."""

    name = "covers"
    landmarks: Names | None = None


@dataclass(frozen=True, kw_only=True)
class KeepsApart(_OfEpisodes):
    """No agent of the team ever comes too near to the others."""

    name = "keeps_apart"
    others: Names | None = None


@dataclass(frozen=True, kw_only=True)
class StaysIn(_OfEpisodes):
    """No agent of the team ever goes farther from the origin than the radius: for ever, unless steps are given."""

    name = "stays_in"


def name_of(claim: str | Claim) -> str:
    """The name of a claim, given as an object or by its name."""
    return claim.name if isinstance(claim, Claim) else claim


def parameters_of(claim: str | Claim) -> dict[str, Any]:
    """What an object says itself; a name says nothing."""
    return claim.options if isinstance(claim, Claim) else {}


def complete_parameters(claim: str | Claim, given: Mapping[str, Any]) -> dict[str, Any]:
    """The options that were given, with what an object says itself. InputError for what it says and an option too."""
    said = {name: value for name, value in given.items() if value is not None}
    if not isinstance(claim, Claim):
        return said
    twice = [name for name in said if name in (*NAMES, "team")]
    if twice:
        what = f"the claim is an object, which has {', '.join(twice)} itself"
        raise InputError(what, twice[0], f"write it among the parameters of {type(claim).__name__}")
    return said | claim.options
