"""The coordination games as a PettingZoo parallel environment: the reference that the batched world equals.

Does: one game at a time in plain Python, one decision an episode.
Assumes: options as `Coordination` checks them.
Does not: share code with the batched world beyond the payoffs of pairs, so that each is a check of the other.
"""

from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Any

import numpy as np
from gymnasium.spaces import Box, Discrete, Space
from pettingzoo import ParallelEnv

from codegen.ir import Float32
from maviper.worlds.payoffs import MATCHING, PAIRS

WORD = 2**64


class Stream:
    """SplitMix64: the numbers in [0, 1) that follow from a seed."""

    def __init__(self, seed: int) -> None:
        self._state = self._mix_bits(seed + 0x9E3779B97F4A7C15)

    def draw(self) -> float:
        """The next number."""
        self._state += 0x9E3779B97F4A7C15
        return (self._mix_bits(self._state) >> 11) / 2**53

    @staticmethod
    def _mix_bits(z: int) -> int:
        z %= WORD
        z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9 % WORD
        z = (z ^ (z >> 27)) * 0x94D049BB133111EB % WORD
        return z ^ (z >> 31)


class CoordinationEnv(ParallelEnv[str, Float32, int]):
    """One decision of all agents, after which the episode has ended."""

    metadata: dict[str, Any] = {"name": "coordination", "render_modes": []}  # noqa: RUF012  as PettingZoo declares it
    max_cycles = 1

    def __init__(self, chosen: Mapping[str, Any]) -> None:
        self.chosen = chosen
        self.possible_agents = [f"agent_{index}" for index in range(chosen["agents"])]
        self.agents: list[str] = []
        n_states = chosen["levels"] ** chosen["signals"]
        stream = Stream(chosen["table"])
        drawn = [stream.draw() for _ in range(n_states)]
        order = sorted(range(n_states), key=drawn.__getitem__)
        self._demanded = {state: rank % chosen["conventions"] for rank, state in enumerate(order)}
        high = np.full(chosen["signals"], chosen["levels"] - 1, dtype=np.float32)
        self._seeing, self._choosing = Box(np.zeros_like(high), high), Discrete(chosen["conventions"])
        self._rng = np.random.default_rng()
        self._wanted = 0
        self._seen: dict[str, Float32] = {}

    def observation_space(self, agent: str) -> Space:
        """The levels of all signals."""
        return self._seeing

    def action_space(self, agent: str) -> Space:
        """The conventions."""
        return self._choosing

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Float32], dict[str, dict[str, Any]]]:
        """A hidden state, and what each agent reads of it."""
        del options
        stream = Stream(int(self._rng.integers(2**31)) if seed is None else seed)
        levels, signals = self.chosen["levels"], self.chosen["signals"]
        state = int(stream.draw() * levels**signals)
        self._wanted = self._demanded[state]
        true = [state // levels ** (signals - 1 - signal) % levels for signal in range(signals)]
        self.agents = list(self.possible_agents)
        self._seen = {
            agent: np.array([self._read(stream, level, index, signal) for signal, level in enumerate(true)], np.float32)
            for index, agent in enumerate(self.agents)
        }
        return self._seen, {agent: {} for agent in self.agents}

    def _read(self, stream: Stream, level: int, agent: int, signal: int) -> int:
        kinds, levels = self.chosen["kinds"], self.chosen["levels"]
        clear = signal % kinds == agent % kinds
        error = (self.chosen["noise"] + (0 if clear else self.chosen["blur"])) / 100
        drawn = stream.draw()
        if drawn >= error:
            return level
        return (level + 1 + min(int(drawn / error * (levels - 1)), levels - 2)) % levels

    def step(  # pyright: ignore[reportIncompatibleMethodOverride]
        self, actions: Mapping[str, int]
    ) -> tuple[dict[str, Any], ...]:
        """The payoff of the joint decision, the same for everybody."""
        worth = self._payoff([(actions[agent] - self._wanted) % self.chosen["conventions"] for agent in self.agents])
        ended, self.agents = self.agents, []
        return (
            self._seen,
            dict.fromkeys(ended, worth),
            dict.fromkeys(ended, True),
            dict.fromkeys(ended, False),
            {agent: {} for agent in ended},
        )

    def _payoff(self, roles: Sequence[int]) -> float:
        rule = self.chosen["rule"]
        if rule != MATCHING:
            pairs = [float(PAIRS[rule][pair]) for pair in combinations(roles, 2)]
            return sum(pairs) / len(pairs)
        weight = self.chosen["payoff"] / 100
        right = sum(role == 0 for role in roles) / len(roles)
        together = 1.0 if right == 1 else self.chosen["agree"] / 100 if len(set(roles)) == 1 else 0.0
        return (1 - weight) * right + weight * together


def parallel_env(**chosen: Any) -> CoordinationEnv:
    """The environment of the game with these options, all of them."""
    return CoordinationEnv(chosen)
