"""What a claim about a team has: a name, words, parameters; and whether claims can be made about a team.

Does: the base class of such claims; refuses teams without members, parameters out of their ranges, and policies whose
  features, actions or thresholds claims have no meaning for; says whom a tree reads.
Assumes: a checked profile, whose teams are asked about.
Does not: decide anything, or read claims.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import ClassVar

import numpy as np

from codegen.errors import InputError, UnknownNameError
from codegen.floats import FLOAT32, below_zero
from codegen.ir import FORK, NO_FEATURE, PHYSICS, AgentPolicy, PolicyProfile
from verify.exact import MAX_NUMBER
from verify.kinds import MACHINE, Kind

Parameter = Fraction | int | str | tuple[str, ...]
Rounded = tuple[tuple[str, str], ...]  # numbers as they are written, and the floats that they are read as


@dataclass(frozen=True)
class TeamClaim:
    """A claim about a team."""

    kind: ClassVar[Kind]
    per_state: ClassVar[bool] = False  # whether a single world state fulfils or breaks it
    limits: ClassVar[tuple[str, ...]]  # the budgets, as `Budgets` names them, that deciding it may use up
    arithmetics: ClassVar[tuple[str, ...]] = (MACHINE,)  # by which it may be asked

    team: str
    label: str = field(default="", compare=False, kw_only=True)
    rounded: Rounded = field(default=(), compare=False, kw_only=True)

    @property
    def name(self) -> str:
        """The name of the property."""
        raise NotImplementedError

    @property
    def parameters(self) -> Mapping[str, Parameter]:
        """The parameters that the claim reads beside its team."""
        raise NotImplementedError

    @property
    def shown(self) -> str:
        """The label, or else the name."""
        return self.label or self.name


def ensure_team(profile: PolicyProfile, team: str) -> None:
    """UnknownNameError for a team of which the profile has no agent."""
    if not profile.team(team):
        raise UnknownNameError("team", team, teams(profile))


def teams(profile: PolicyProfile) -> list[str]:
    """The teams of a profile, in the order of its agents."""
    return list(dict.fromkeys(policy.team for policy in profile.agents))


def check_range(parameter: str, value: Fraction | int, most: int = MAX_NUMBER, least: int = 0) -> None:
    """InputError for a value out of its range."""
    if not least <= value <= most:
        raise InputError(f"{parameter} must be between {least} and {most}", parameter)


def verifiable(profile: PolicyProfile, team: str) -> tuple[AgentPolicy, ...]:
    """The team's policies; InputError when a claim about world states cannot be made for them, or there are none."""
    ensure_team(profile, team)
    if profile.world.options.get(PHYSICS) == FORK and profile.world.agents:  # observations alone do not move
        what = f"claims cover mpe2's motion, and this world moves as the authors' code ({PHYSICS}={FORK})"
        raise InputError(what, profile.world.name, f"extract in the world without {PHYSICS}={FORK}")
    for policy in profile.team(team):
        readable(policy)
        for action in policy.actions:
            if action.effect is None and profile.world.agents:  # without entities there is nothing to push
                what = f"action {action.name} of {policy.agent} has no effect"
                raise InputError(what, "", "claims need every effect")
    return profile.team(team)


def read_by(policy: AgentPolicy) -> frozenset[str]:
    """The entities that the tree's tests read, the goal as `goal`."""
    tested: set[int] = {*policy.tree.feature.tolist()} - {NO_FEATURE}
    meanings = [policy.features[place].meaning for place in tested]
    return frozenset(name.rpartition(".")[0] for meaning in meanings if meaning for _, name in meaning.terms)


def readable(policy: AgentPolicy) -> None:
    """InputError when world states do not say what an agent decides: a feature without meaning, a threshold that
    processors may flush to zero, a product of a float64 agent that may be rounded.
    """
    for feature in policy.features:
        if feature.meaning is None:
            what = f"feature {feature.name} of {policy.agent} has no meaning"
            raise InputError(what, "", "claims need every meaning")
        # of the smallest float64 numbers a half is none; rounding to float32 hides that
        if policy.numbers != FLOAT32 and any(abs(weight) < 1 for weight, _ in feature.meaning.terms):
            what = f"feature {feature.name} of {policy.agent}, which compares {policy.numbers}, has a weight below 1"
            raise InputError(what, str(feature.meaning), "claims about it need weights of at least 1")
    threshold = policy.tree.threshold
    plain = (threshold == 0) | (threshold == below_zero(policy.numbers))  # x <= 0, and x < 0, which code writes so
    tiny = ~plain & (np.abs(threshold) < np.finfo(policy.numbers).tiny)
    for node in np.flatnonzero(tiny):
        what = f"node {node} of {policy.agent} has a subnormal threshold"
        raise InputError(what, "", "processors may flush such numbers to zero: write x <= 0, x < 0, or a normal number")


def ensure_landmarks(name: str, profile: PolicyProfile) -> None:
    """InputError without landmarks, for a property that speaks of one for each agent."""
    if not profile.world.landmarks:
        what = f"{name} needs a landmark for each agent, and there are none here"
        raise InputError(what, "", "state what agents do in a formula: see `maviper guide claims`")


def ensure_landmark_each(name: str, profile: PolicyProfile, team: str) -> None:
    """InputError unless the profile has the team, and a landmark for each of its agents."""
    ensure_landmarks(name, profile)
    ensure_team(profile, team)
    if len(profile.team(team)) > len(profile.world.landmarks):
        what = f"{name} needs a landmark for each agent; team {team} has more agents than the world landmarks"
        raise InputError(what)


def check_landmarks(profile: PolicyProfile, team: str, landmarks: Sequence[str]) -> None:
    """InputError unless `landmarks` is empty or names a different one for each agent of the team."""
    known = [landmark.name for landmark in profile.world.landmarks]
    for landmark in landmarks:
        if landmark not in known:
            raise UnknownNameError("landmark", landmark, known, "landmarks")
    if landmarks and (len(landmarks) != len(profile.team(team)) or len(set(landmarks)) != len(landmarks)):
        raise InputError("landmarks must name a different landmark for each agent of the team", "landmarks")
