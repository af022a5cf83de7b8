"""Shares of a region: how often a claim could fail there, and how often it does.

Does: conflict share, contested share and violating fraction by uniform sampling, with 95 % intervals.
Assumes: few enough joint actions to enumerate.
Does not: prove anything; the solver's verdict stands on its own.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from codegen.errors import InputError
from codegen.ir import Bool, Float64, Int32, PolicyProfile
from verify.matching import matched
from verify.spec import Property, Region
from verify.world import chosen, offsets, possible, sample

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

    conflict: Share  # some joint action, every agent closing on a landmark, would violate the claim
    contested: Share | None  # two agents, both inside the landmarks' rectangle; None for other team sizes
    violating: Share  # the team as it is violates the claim


def measure(profile: PolicyProfile, claim: Property, region: Region, seed: int, count: int = SAMPLES) -> Shares:
    """The shares of `region`, from at most `count` uniform world states at rest."""
    coordinates, _ = sample(region, profile.world, count, seed)
    n = len(coordinates)
    conflicting = int(conflicts(profile, claim, coordinates).sum())
    contested = _contested(profile, claim, coordinates)
    failing = int(violating(profile, claim, coordinates).sum())
    return Shares(
        Share(conflicting, n), None if contested is None else Share(int(contested.sum()), n), Share(failing, n)
    )


def violating(profile: PolicyProfile, claim: Property, coordinates: Float64) -> Bool:
    """Where the team's own actions violate the claim, [batch]."""
    engaged, _ = possible(profile, claim, coordinates)
    actions = [chosen(policy, coordinates, profile.world) for policy in profile.team(claim.team)]
    return ~matched(_taken(engaged, actions))


def conflicts(profile: PolicyProfile, claim: Property, coordinates: Float64) -> Bool:
    """Where some joint action, every agent closing on at least one landmark, violates the claim, [batch]."""
    engaged, closes = possible(profile, claim, coordinates)
    n_actions = [len(policy.actions) for policy in profile.team(claim.team)]
    if math.prod(n_actions) > MOST_JOINT_ACTIONS:
        raise InputError(
            f"{math.prod(n_actions)} joint actions are too many for the conflict share", f"team {claim.team}"
        )
    found = np.zeros(len(coordinates), dtype=bool)
    for joint in product(*(range(n) for n in n_actions)):
        actions = [np.full(len(coordinates), action, dtype=np.int32) for action in joint]
        willing = np.all(_taken(closes, actions).any(axis=2), axis=1)
        found |= willing & ~matched(_taken(engaged, actions))
    return found


def _taken(by_action: Bool, actions: Sequence[Int32]) -> Bool:
    """[batch, n_agents, n_actions, n_landmarks] at the chosen actions, [batch, n_agents, n_landmarks]."""
    batch = np.arange(len(by_action))
    return np.stack([by_action[batch, agent, action] for agent, action in enumerate(actions)], axis=1)


def _contested(profile: PolicyProfile, claim: Property, coordinates: Float64) -> Bool | None:
    gap = offsets(profile, claim, coordinates)
    if gap.shape[1:3] != (2, 2):
        return None
    # inside the rectangle: on each axis the two landmarks do not lie on the same side of the agent
    return np.asarray((gap[:, :, 0] * gap[:, :, 1] <= 0).all(axis=(1, 2)))
