"""The aggregated data of an extraction: states met, the expert's actions there, and each agent's weights.

Does: labels episodes, aggregates them, resamples per agent as multiplicities.
Assumes: every point carries all agents' observations and labels (the paper's x and joint action).
Does not: compute weights (weights.py).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from codegen.ir import Float32, Float64
from maviper.evaluate.play import Episodes
from maviper.experts.expert import Expert
from maviper.worlds.world import Int


@dataclass(frozen=True)
class Dataset:
    """`n` points, in the order in which they were met."""

    observations: tuple[Float32, ...]  # per agent [n, n_features]
    labels: Int  # [n, n_agents] the expert's actions
    weights: Float64  # [n, n_agents] each agent's resampling weight, >= 0

    def __len__(self) -> int:
        return len(self.labels)

    def __add__(self, other: "Dataset") -> "Dataset":
        observations = tuple(np.concatenate(pair) for pair in zip(self.observations, other.observations, strict=True))
        labels = np.concatenate([self.labels, other.labels])
        return Dataset(observations, labels, np.concatenate([self.weights, other.weights]))


def points(episodes: Episodes) -> tuple[tuple[Float32, ...], Any]:
    """All observations of a batch of episodes, per agent [steps * batch, n_features], and the states they show."""
    observations = tuple(seen.reshape(-1, seen.shape[-1]) for seen in episodes.observations)
    return observations, type(episodes.states[0]).joined(episodes.states[:-1])


def labels(expert: Expert, observations: Sequence[Float32], state: Any) -> Int:
    """The expert's joint action in each state, [n, n_agents]."""
    return expert.act(range(len(observations)), observations, state)


def resample(weights: Float64, max_samples: int, rng: np.random.Generator) -> Int:
    """How often each point is drawn, [n]: min(max_samples, n) draws with replacement, proportional to `weights`.

    Counts say the same as the drawn list, and every later step (splits, majorities, votes) treats them so. Where all
    weights are zero, the draw is uniform.
    """
    total = weights.sum()
    shares = weights / total if total > 0 else np.full(len(weights), 1 / len(weights))
    return rng.multinomial(min(max_samples, len(weights)), shares)
