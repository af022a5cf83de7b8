"""The aggregated data of an extraction: states met, the expert's actions there, and each agent's weights.

Does: plays and labels rollouts, aggregates them, resamples per agent as multiplicities.
Assumes: every point carries all agents' observations and labels (the paper's x and joint action). An agent whose
  episode has ended takes no part in a point: it is in none of its own data, and nobody's vote or weight depends on
  what it would do. Points in which nobody acts any more are left out.
Does not: compute weights (extraction/growth/weights.py).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from operator import add
from typing import Any

import numpy as np

from codegen.ir import Bool, Float32, Float64
from maviper.episodes.measures import likeness
from maviper.episodes.play import Controller, points, rollout
from maviper.experts.expert import Expert, labels
from maviper.worlds import World
from maviper.worlds.world import Int


@dataclass(frozen=True)
class Dataset:
    """`n` points, in the order in which they were met."""

    observations: tuple[Float32, ...]  # per agent [n, n_features]
    labels: Any  # [n, n_agents] the expert's actions; or its numbers, [n, n_agents, n_outputs] float32
    weights: Float64  # [n, n_agents] each agent's resampling weight, >= 0; 0 where it takes no part
    alive: Bool  # [n, n_agents] who takes part

    def __len__(self) -> int:
        return len(self.labels)

    def __add__(self, other: "Dataset") -> "Dataset":
        observations = tuple(np.concatenate(pair) for pair in zip(self.observations, other.observations, strict=True))
        labels = np.concatenate([self.labels, other.labels])
        weights, alive = np.concatenate([self.weights, other.weights]), np.concatenate([self.alive, other.alive])
        return Dataset(observations, labels, weights, alive)

    def before(self, count: int) -> "Dataset":
        """All points but the last `count`."""
        return self._rows(slice(0, len(self) - count))

    def since(self, count: int) -> "Dataset":
        """All points but the first `count`."""
        return self._rows(slice(count, None))

    def _rows(self, rows: slice) -> "Dataset":
        observations = tuple(seen[rows] for seen in self.observations)
        return Dataset(observations, self.labels[rows], self.weights[rows], self.alive[rows])


# from all agents' observations, the states and the expert's actions to each agent's weights
Weigh = Callable[[tuple[Float32, ...], Any, Int], Float64]


@dataclass(frozen=True)
class Met:
    """The result of rollouts: points, each team's primary measure in its episodes, and the agents' fidelity."""

    data: Dataset
    values: Mapping[str, Float64]
    fidelity: float  # how like the expert's actions are those of the agents that the rollouts were about

    def arrays(self) -> dict[str, np.ndarray]:
        """Returns the result as named arrays."""
        seen = {f"observations.{agent:03d}": rows for agent, rows in enumerate(self.data.observations)}
        values = {f"values.{team}": row for team, row in self.values.items()}
        data = {"labels": self.data.labels, "weights": self.data.weights, "alive": self.data.alive}
        return seen | values | data | {"fidelity": np.array([self.fidelity])}

    @staticmethod
    def of(arrays: Mapping[str, np.ndarray]) -> "Met":
        """From what `arrays` gave."""
        seen = tuple(arrays[key] for key in sorted(arrays) if key.startswith("observations."))
        values = {key.partition(".")[2]: row for key, row in arrays.items() if key.startswith("values.")}
        data = Dataset(seen, arrays["labels"], arrays["weights"], arrays["alive"])
        return Met(data, values, float(arrays["fidelity"][0]))


def collect(
    world: World,
    expert: Expert,
    controllers: Sequence[Controller],
    agents: Sequence[int],
    seeds: Sequence[int],
    weigh: Weigh,
    over: Callable[[], bool] = lambda: False,
) -> Met:
    """Plays episodes and labels what they meet. `agents`: those that the rollouts are about, and that `weigh` gives a
    column of weights each; only the steps in which one of them acts become points. `over`: as in `rollout`.
    """
    mine = list(agents)
    datasets: list[Dataset] = []
    values: dict[str, list[Float64]] = {world.team_of(world.agents[agent]): [] for agent in agents}
    agreed, asked = 0.0, 0
    for episodes in rollout(world, controllers, seeds, over=over):
        observations, state = points(episodes)
        acted = episodes.actions.reshape(-1, *episodes.actions.shape[2:])
        alive = episodes.alive.reshape(acted.shape[:2])
        some = alive[:, mine].any(axis=1)
        if not some.all():
            observations, state = tuple(seen[some] for seen in observations), state[some]
            acted, alive = acted[some], alive[some]
        wanted = labels(expert, observations, state)
        given = weigh(observations, state, wanted) * alive[:, mine]
        datasets.append(Dataset(observations, wanted, given, alive))
        for agent in mine:
            rows = alive[:, agent]
            agreed += float(likeness(world.given[agent], acted[rows, agent], wanted[rows, agent]).sum())
        asked += int(alive[:, mine].sum())
        for team, rows in values.items():
            rows.append(episodes.values[world.measures.index(world.primary(team))])
    joined = {team: np.concatenate(rows) for team, rows in values.items()}
    return Met(reduce(add, datasets), joined, agreed / asked)


def resample(weights: Float64, alive: Bool, max_samples: int, rng: np.random.Generator) -> Int:
    """Draws counts of points, [n]: draws with replacement, proportional to `weights`; as many as there are points in
    which the agent takes part (`alive`, [n]), at most `max_samples`.

    Counts say the same as the drawn list, and every later step (splits, majorities, votes) treats them so. Where all
    weights are zero, the draw is uniform among these.
    """
    total, n = weights.sum(), int(alive.sum())
    shares = weights / total if total > 0 else np.where(alive, 1 / n, 0.0)
    return rng.multinomial(min(max_samples, n), shares)
