"""Worlds of others, whose environments say what is observed and paid: what they share once they are made.

Does: holds what is known of a batch of games at one step, and answers from it.
Assumes: `source` names the environment; `start_from_seeds` and `step` fill such batches.
Does not: make or step an environment.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import count
from typing import Any

import numpy as np

from codegen.ir import Bool, Float32, Float64
from maviper.worlds.outside.branching import Pasts
from maviper.worlds.outside.processes import Copy
from maviper.worlds.outside.sources import Source
from maviper.worlds.seeds import TRAINING
from maviper.worlds.world import World

START_EPISODES = 4  # that are played at most before anything is asked: a probe, and a trial of copies
PAST = -1  # the moment of a state that cannot be stepped: a part of one, or several joined
MOMENTS = count()  # unlike in all worlds


@dataclass(frozen=True)
class EnvStates:
    """The known part of a batch of games at one step; the games themselves live in their copies."""

    observations: tuple[Float32, ...]  # per agent [batch, n_features]
    rewards: Float64  # [batch, n_agents] on entering the state
    done: Bool  # [batch, n_agents] whose episode has ended
    terminated: Bool  # [batch, n_agents] ... and was not just cut
    acting: Bool  # [batch, n_agents] who acts in the next step
    moment: int = PAST
    pasts: Pasts | None = None  # how each game got here, where it may be branched
    copies: tuple[Copy, ...] = ()  # of its own, where it was branched

    def __len__(self) -> int:
        return len(self.rewards)

    def __getitem__(self, rows: Any) -> "EnvStates":
        observations = tuple(seen[rows] for seen in self.observations)
        pasts = None if self.pasts is None else self.pasts[rows]
        ends = self.done[rows], self.terminated[rows], self.acting[rows]
        return EnvStates(observations, self.rewards[rows], *ends, pasts=pasts)

    @staticmethod
    def concatenate(states: Sequence["EnvStates"]) -> "EnvStates":
        """Several batches as one, in their order."""
        observations = zip(*(state.observations for state in states), strict=True)
        parts = zip(*((state.rewards, state.done, state.terminated, state.acting) for state in states), strict=True)
        rewards, done, terminated, acting = map(np.concatenate, parts)
        known = [state.pasts for state in states if state.pasts is not None]
        pasts = np.concatenate(known) if len(known) == len(states) else None
        return EnvStates(tuple(map(np.concatenate, observations)), rewards, done, terminated, acting, pasts=pasts)


class OutsideWorld(World):
    """A world whose states are `EnvStates`. Its measures are the returns of its teams."""

    source: Source

    @property
    def name(self) -> str:
        """The name of the environment, with its options."""
        return self.source.text

    def start(self, n: int, rng: np.random.Generator) -> EnvStates:
        """`n` random start states, `n` at most `games`: each game is reset with a seed of its own."""
        return self.start_from_seeds(rng.integers(*TRAINING, size=n))

    def observe(self, state: EnvStates) -> tuple[Float32, ...]:
        """Each agent's observation, [batch, n_features] float32."""
        return state.observations

    def rewards(self, state: EnvStates) -> Float64:
        """The environment's rewards on entering `state`, [batch, n_agents]; 0 at the start and for who was done."""
        return state.rewards

    def alive(self, state: EnvStates) -> Bool:
        """Returns True for the agents that act in `state`, [batch, n_agents]."""
        return state.acting

    def terminated(self, state: EnvStates) -> Bool:
        """Whose episode has ended by itself, [batch, n_agents]: the environment did not say that it was cut."""
        return state.terminated

    def values(self, states: Sequence[EnvStates]) -> Float64:
        """Each team's return, [n_teams, batch]: the mean over its agents of all rewards of an episode."""
        total = np.sum([state.rewards for state in states], axis=0)
        return np.stack([total[:, self.members(team)].mean(axis=1) for team in self.teams])
