"""A MADDPG expert as numpy arrays: one actor and one centralized critic per agent.

Does: the forward pass of actors (argmax of logits) and critics (Q of joint actions).
Assumes: two hidden ReLU layers; a critic reads all observations, then all agents' actions one-hot.
Does not: learn, or need torch.

Weights are float32, the pass runs in float64: libraries for matrix products add up in different orders on different
processors, and in float64 that is too small to turn a decision, so an extraction gives the same trees everywhere.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from codegen.ir import Float32, Float64
from maviper.evaluate.play import Policy
from maviper.worlds.particle import Int

LAYERS = (1, 2, 3)
AS_GIVEN = -1  # in a column of `joint`: take each state's own action


@dataclass(frozen=True)
class Expert:
    """Weights of all agents' networks.

    `tensors` holds, for each agent name A, each net in (actor, critic) and each layer L in 1, 2, 3,
    `A.net.L.weight` [inputs, outputs] and `A.net.L.bias` [outputs], float32. `card` says what made them and how
    good they are; `hash` is the SHA-256 of the file.
    """

    agents: tuple[str, ...]
    n_actions: tuple[int, ...]
    tensors: Mapping[str, Float32]
    card: Mapping[str, Any]
    hash: str
    _wide: Mapping[str, Float64] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_wide", {name: tensor.astype(np.float64) for name, tensor in self.tensors.items()})

    def policies(self) -> list[Policy]:
        """Each agent's greedy policy."""
        return [partial(self.act, agent) for agent in range(len(self.agents))]

    def act(self, agent: int, obs: Float32) -> Int:
        """The greedy action of one agent, [batch]. `obs`: [batch, n_features] float32."""
        return np.argmax(self._head(f"{self.agents[agent]}.actor", self._first(agent, obs)), axis=1)

    def q(self, agent: int, observations: Sequence[Float32], joint: Int, given: Int) -> Float64:
        """Q of one agent for chosen joint actions, [batch, n_joint].

        `observations`: every agent's, each [batch, n_features]. `joint`: [n_joint, n_agents] action indices asked for
        in every state; where it says AS_GIVEN, the agent's action is that of `given` [batch, n_agents]. The first
        layer's part for observations and given actions is computed once per state.
        """
        net = f"{self.agents[agent]}.critic"
        weight = self._wide[f"{net}.1.weight"]
        seen = np.concatenate(list(observations), axis=1).astype(np.float64)
        state = seen @ weight[: seen.shape[1]] + self._wide[f"{net}.1.bias"]
        first_row = seen.shape[1] + np.concatenate([[0], np.cumsum(self.n_actions)[:-1]])
        asked = np.zeros((len(joint), state.shape[1]))
        for other, row in enumerate(first_row):
            if joint[0, other] == AS_GIVEN:
                state = state + weight[row + given[:, other]]
            else:
                asked = asked + weight[row + joint[:, other]]
        first = state[:, None, :] + asked
        flat = self._head(net, first.reshape(-1, first.shape[-1]))
        return flat.reshape(first.shape[:2])

    def _first(self, agent: int, obs: Float32) -> Float64:
        net = f"{self.agents[agent]}.actor"
        return np.asarray(obs, np.float64) @ self._wide[f"{net}.1.weight"] + self._wide[f"{net}.1.bias"]

    def _head(self, net: str, first: Float64) -> Float64:
        hidden = np.maximum(first, 0)
        hidden = np.maximum(hidden @ self._wide[f"{net}.2.weight"] + self._wide[f"{net}.2.bias"], 0)
        return hidden @ self._wide[f"{net}.3.weight"] + self._wide[f"{net}.3.bias"]
