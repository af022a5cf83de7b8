"""The aggregated data of an extraction: states met, the expert's actions there, and each agent's weights.

Does: plays and labels rollouts, aggregates them, resamples per agent as multiplicities.
Assumes: every point carries all agents' observations and labels (the paper's x and joint action).
Does not: compute weights (weights.py).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from operator import add
from typing import Any

import numpy as np

from codegen.ir import Float32, Float64
from maviper.evaluate.play import Controller, Episodes, rollout
from maviper.experts.expert import Expert
from maviper.worlds import World
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


# from all agents' observations, the states and the expert's actions to each agent's weights
Weigh = Callable[[tuple[Float32, ...], Any, Int], Float64]


@dataclass(frozen=True)
class Met:
    """What rollouts gave: points; each team's primary measure in its episodes; how far the agents acted as experts."""

    data: Dataset
    values: Mapping[str, Float64]
    agreement: float  # share of the actions of the agents that the rollouts were about

    def arrays(self) -> dict[str, np.ndarray]:
        """As named arrays."""
        seen = {f"observations.{agent:03d}": rows for agent, rows in enumerate(self.data.observations)}
        values = {f"values.{team}": row for team, row in self.values.items()}
        agreement = np.array([self.agreement])
        return seen | values | {"labels": self.data.labels, "weights": self.data.weights, "agreement": agreement}

    @staticmethod
    def of(arrays: Mapping[str, np.ndarray]) -> "Met":
        """From what `arrays` gave."""
        seen = tuple(arrays[key] for key in sorted(arrays) if key.startswith("observations."))
        values = {key.partition(".")[2]: row for key, row in arrays.items() if key.startswith("values.")}
        return Met(Dataset(seen, arrays["labels"], arrays["weights"]), values, float(arrays["agreement"][0]))


def collect(
    world: World,
    expert: Expert,
    controllers: Sequence[Controller],
    agents: Sequence[int],
    seeds: Sequence[int],
    weigh: Weigh,
) -> Met:
    """Plays episodes and labels what they meet. `agents`: those that the rollouts are about."""
    found: list[Dataset] = []
    values: dict[str, list[Float64]] = {world.team_of(world.agents[agent]): [] for agent in agents}
    agreed = asked = 0
    for episodes in rollout(world, controllers, seeds):
        observations, state = points(episodes)
        wanted = labels(expert, observations, state)
        found.append(Dataset(observations, wanted, weigh(observations, state, wanted)))
        agreed += int((episodes.actions.reshape(wanted.shape) == wanted)[:, list(agents)].sum())
        asked += len(wanted) * len(agents)
        for team, rows in values.items():
            rows.append(episodes.values[world.measures.index(world.primary(team))])
    joined = {team: np.concatenate(rows) for team, rows in values.items()}
    return Met(reduce(add, found), joined, agreed / asked)


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
