"""Shares of a region: how often a claim could fail there, and how often it does.

Does: conflict share, contested share and violating fraction by uniform sampling, with 95 % intervals.
Assumes: a profile and a claim about it.
Does not: prove anything; the solver's verdict stands on its own.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from codegen.ir import AgentPolicy, Bool, Float64, PolicyProfile
from verify import noise
from verify.formula import TRUE, And, Batch, Formula, agents, disjunction, given
from verify.matching import preventable
from verify.predicates import closes
from verify.properties import DISTINCT, Property, engaged, formula
from verify.spec import Region
from verify.world import batch, chosen, sample

SAMPLES = 100_000
SAMPLE_SEED = 7
MOST_JOINT_ACTIONS = 1_000
Z95 = 1.959963984540054  # two-sided 95 % quantile of the normal distribution


@dataclass(frozen=True)
class Share:
    """`hits` of `count` sampled states, with the Wilson interval of the share."""

    hits: int
    count: int

    @property
    def value(self) -> float:
        """The share itself; 0 for an empty sample."""
        return self.hits / self.count if self.count else 0.0

    @property
    def interval(self) -> tuple[float, float]:
        """The 95 % interval (Wilson 1927)."""
        if not self.count:
            return 0.0, 1.0
        p, n, z2 = self.value, self.count, Z95**2
        middle = (p + z2 / (2 * n)) / (1 + z2 / n)
        half = Z95 * math.sqrt(p * (1 - p) / n + z2 / (4 * n * n)) / (1 + z2 / n)
        return max(0.0, middle - half) if self.hits else 0.0, min(1.0, middle + half) if self.hits < self.count else 1.0

    def document(self) -> dict[str, float | int]:
        """The share as plain data."""
        low, high = self.interval
        return {
            "share": self.value,
            "low": round(low, 9),
            "high": round(high, 9),
            "hits": self.hits,
            "samples": self.count,
        }

    def __str__(self) -> str:
        if not self.count:
            return "not measured (no sampled state lies in the region)"
        low, high = self.interval
        return f"{100 * self.value:.3g} % [{100 * low:.3g}, {100 * high:.3g}]"


@dataclass(frozen=True)
class Shares:
    """What a region is like for a claim."""

    conflict: Share | None  # some joint action, every agent closing on a landmark, would violate the claim; None:
    # there are too many joint actions to try
    contested: Share | None  # two agents, both inside the landmarks' rectangle; None for other team sizes
    violating: Share  # the team as it is violates the claim, with some errors where the claim allows them
    changing: Share | None = None  # errors can change some agent's action; None for claims without errors


def measure(profile: PolicyProfile, claim: Property, region: Region, seed: int, count: int = SAMPLES) -> Shares:
    """The shares of `region`, from at most `count` uniform world states at rest that meet the assumption."""
    coordinates, _ = sample(region, profile.world, count, seed)
    if claim.assume != TRUE:
        coordinates = coordinates[batch(coordinates, profile.world).holds(claim.assume, {})]
    n = len(coordinates)
    conflicting = conflicts(profile, claim, coordinates)
    contested = _contested(profile, claim, coordinates)
    failing = int(violating(profile, claim, coordinates).sum())
    changing = int(noise.changeable(profile, claim, coordinates).sum()) if claim.eps else None
    return Shares(
        None if conflicting is None else Share(int(conflicting.sum()), n),
        None if contested is None else Share(int(contested.sum()), n),
        Share(failing, n),
        None if changing is None else Share(changing, n),
    )


def violating(profile: PolicyProfile, claim: Property, coordinates: Float64) -> Bool:
    """Where the team's own actions violate the claim, with some errors where it allows them, [batch]."""
    if claim.eps:
        return noise.violable(profile, claim, coordinates)
    actions = {p.agent: chosen(p, coordinates, profile.world) for p in profile.team(claim.team)}
    return ~batch(coordinates, profile.world).holds(formula(profile, claim), actions)


def conflicts(profile: PolicyProfile, claim: Property, coordinates: Float64) -> Bool | None:
    """Where some joint action, every agent closing on at least one landmark, violates the claim, [batch].

    None when a part of the claim speaks of too many joint actions to try them all.
    """
    team, stated = {policy.agent: policy for policy in profile.team(claim.team)}, formula(profile, claim)
    states = batch(coordinates, profile.world)
    willing = {
        agent: [states.holds(_willing(profile, policy, action, claim), {}) for action in range(len(policy.actions))]
        for agent, policy in team.items()
    }
    found, moving = np.zeros(len(coordinates), dtype=bool), np.logical_and.reduce([*map(_any, willing.values())])
    for part in stated.parts if isinstance(stated, And) else (stated,):
        acting = [agent for agent in team if agent in agents(part)]
        if math.prod(len(willing[agent]) for agent in acting) > MOST_JOINT_ACTIONS:
            if DISTINCT not in (claim.name, claim.of) or claim.assume != TRUE:
                return None
            return _unmatchable(profile, claim, states, willing)
        for joint in product(*(range(len(willing[agent])) for agent in acting)):
            chosen_by = dict(zip(acting, joint, strict=True))
            possible = np.logical_and.reduce([moving, *(willing[agent][chosen_by[agent]] for agent in acting)])
            found |= possible & ~states.holds(given(part, chosen_by), {})
    return found


def _any(ways: Sequence[Bool]) -> Bool:
    return np.asarray(np.logical_or.reduce(ways))


def _unmatchable(profile: PolicyProfile, claim: Property, states: Batch, willing: Mapping[str, Sequence[Bool]]) -> Bool:
    """Where willing actions can leave no matching of the team to the landmarks, by Hall's theorem."""
    marks = [landmark.name for landmark in profile.world.landmarks]

    def related(policy: AgentPolicy, action: int) -> Bool:
        own = [given(engaged(policy, mark, claim), {policy.agent: action}) for mark in marks]
        return np.stack([states.holds(each, {}) for each in own], axis=1)

    choices = [
        [(allowed, related(policy, action)) for action, allowed in enumerate(willing[policy.agent])]
        for policy in profile.team(claim.team)
    ]
    return preventable(choices, len(marks))


def _willing(profile: PolicyProfile, policy: AgentPolicy, action: int, claim: Property) -> Formula:
    """The action closes on some landmark."""
    return disjunction(*(closes(policy, action, mark.name, claim.margin) for mark in profile.world.landmarks))


def _contested(profile: PolicyProfile, claim: Property, coordinates: Float64) -> Bool | None:
    """Two agents, both inside the landmarks' rectangle."""
    team, landmarks = profile.team(claim.team), profile.world.landmarks
    if len(team) != 2 or len(landmarks) != 2:
        return None
    at = dict(zip(profile.world.coordinates(), coordinates.T, strict=True))
    found = np.ones(len(coordinates), dtype=bool)
    for policy, axis in product(team, "xy"):
        # inside: on each axis the two landmarks do not lie on the same side of the agent
        first, second = (at[f"{mark.name}.{axis}"] - at[f"{policy.agent}.{axis}"] for mark in landmarks)
        found &= first * second <= 0
    return found
