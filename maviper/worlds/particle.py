"""Batched particle worlds: the dynamics and observations that all games share, thousands of episodes at once.

Does: starts, steps and observes a batch of games in numpy, with the arithmetic of mpe2 operation by operation, so that
  results are equal bit for bit; a game adds its entities, features, rewards and measure in one file.
Assumes: the features' meanings say how an observation is made from the world (the verifier assumes the same).
Does not: contact forces and speed limits yet (no shipped game needs them); learn; render.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from codegen.ir import ActionSpec, Bool, FeatureSpec, Float32, Float64, WorldSpec
from codegen.observe import observe

Int = npt.NDArray[np.integer[Any]]

# mpe2's discrete actions, in its order
ACTIONS = (
    ActionSpec("stay", (0.0, 0.0)),
    ActionSpec("left", (-1.0, 0.0)),
    ActionSpec("right", (1.0, 0.0)),
    ActionSpec("down", (0.0, -1.0)),
    ActionSpec("up", (0.0, 1.0)),
)


@dataclass(frozen=True)
class WorldState:
    """A batch of world states; entities are the agents, then the landmarks."""

    position: Float64  # [batch, n_entities, 2], length units
    velocity: Float64  # [batch, n_agents, 2], length units / s
    goal: Int  # [batch] index of the goal landmark; 0 where the game has no goal

    def __len__(self) -> int:
        return len(self.position)


class ParticleWorld(ABC):
    """A game. Subclasses state `spec`, `teams`, `features`, `actions` and implement rewards and success."""

    spec: WorldSpec
    teams: Mapping[str, tuple[str, ...]]  # team -> its agents, in the order of `agents`
    features: tuple[tuple[FeatureSpec, ...], ...]  # per agent
    actions: tuple[tuple[ActionSpec, ...], ...]  # per agent
    squared_radii: tuple[float, ...]  # squares of the success radii to report, the primary one first

    @property
    def name(self) -> str:
        """The world's name on the command line."""
        return self.spec.name

    @property
    def agents(self) -> tuple[str, ...]:
        """Agents' names, in the order of every per-agent array."""
        return tuple(entity.name for entity in self.spec.agents)

    def team_of(self, agent: str) -> str:
        """The team that an agent plays for."""
        return next(team for team, members in self.teams.items() if agent in members)

    def members(self, team: str) -> list[int]:
        """Indices of a team's agents."""
        return [self.agents.index(agent) for agent in self.teams[team]]

    # --- starting

    def start(self, n: int, rng: np.random.Generator) -> WorldState:
        """`n` random start states from one generator: at rest, positions uniform in the start box, goal uniform."""
        low, high = self.spec.start_low, self.spec.start_high
        n_agents, n_entities = len(self.spec.agents), len(self.spec.agents) + len(self.spec.landmarks)
        goal = rng.integers(max(1, len(self.spec.goals)), size=n)
        return WorldState(rng.uniform(low, high, (n, n_entities, 2)), np.zeros((n, n_agents, 2)), goal)

    def start_from_seeds(self, seeds: Sequence[int] | Int) -> WorldState:
        """The start states of the reference environment after `reset(seed=...)`, one for each seed."""
        low, high = self.spec.start_low, self.spec.start_high
        n_agents, n_entities = len(self.spec.agents), len(self.spec.agents) + len(self.spec.landmarks)
        position = np.empty((len(seeds), n_entities, 2))
        goal = np.zeros(len(seeds), dtype=np.int64)
        for row, seed in enumerate(seeds):
            rng = np.random.Generator(np.random.PCG64(np.random.SeedSequence(int(seed))))
            if self.spec.goals:
                goal[row] = rng.integers(len(self.spec.goals))
            position[row] = rng.uniform(low, high, (n_entities, 2))
        return WorldState(position, np.zeros((len(seeds), n_agents, 2)), goal)

    # --- dynamics

    def step(self, state: WorldState, actions: Int) -> WorldState:
        """The next states. `actions`: [batch, n_agents] indices. Positions move first, with the old velocity."""
        n_agents = len(self.spec.agents)
        effect = np.array([[action.effect or (0.0, 0.0) for action in choices] for choices in self.actions])
        force = np.array([entity.force for entity in self.spec.agents])
        push = effect[np.arange(n_agents), actions] * force[:, None]
        position = state.position.copy()
        position[:, :n_agents] += state.velocity * self.spec.dt
        velocity = state.velocity * (1.0 - self.spec.damping) + push * self.spec.dt
        return WorldState(position, velocity, state.goal)

    def coordinates(self, state: WorldState) -> Float64:
        """All world coordinates, [batch, n_coordinates], in the order of `spec.coordinates()`."""
        batch = len(state)
        parts = [state.position.reshape(batch, -1)]
        if self.spec.goals:
            parts.append(state.position[np.arange(batch), len(self.spec.agents) + state.goal])
        parts.append(state.velocity.reshape(batch, -1))
        return np.concatenate(parts, axis=1)

    def observe(self, state: WorldState) -> tuple[Float32, ...]:
        """Each agent's observation, [batch, n_features] float32: subtracted in float64, then rounded."""
        coordinates = self.coordinates(state)
        return tuple(observe(features, coordinates, self.spec) for features in self.features)

    # --- what a game adds

    @abstractmethod
    def rewards(self, state: WorldState) -> Float64:
        """The environment's rewards on entering `state`, [batch, n_agents]."""

    @abstractmethod
    def shaping(self, state: WorldState) -> Float64:
        """A training aid that may be added to the rewards, [batch, n_agents]; never part of a measure."""

    @abstractmethod
    def success(self, position: Float64, goal: Int, squared_radius: float) -> dict[str, Bool]:
        """Each team's primary measure for whole episodes.

        `position`: [steps, batch, n_entities, 2] after each step; `goal`: [batch]. Returns team -> [batch].
        """

    @abstractmethod
    def reference_env(self) -> Any:
        """The reference environment (a PettingZoo parallel environment of mpe2)."""


def placed(env: Any, state: WorldState) -> Any:
    """Puts the reference environment into one world state (`state` has batch 1) and returns the environment."""
    world = env.aec_env.unwrapped.world
    for entity, position in zip(world.agents + world.landmarks, state.position[0], strict=True):
        entity.state.p_pos = position.copy()
        entity.state.p_vel = np.zeros(2)
    for agent, velocity in zip(world.agents, state.velocity[0], strict=True):
        agent.state.p_vel = velocity.copy()
        agent.goal_a = world.landmarks[int(state.goal[0])]
    return env
