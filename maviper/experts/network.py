"""Experts as numpy arrays: per agent an actor and a centralized critic, or one value network.

Does: the forward pass of actors (argmax of logits), critics (Q of joint actions) and value networks (Q of own actions).
Assumes: two hidden ReLU layers; a critic reads all observations, then all agents' actions one-hot.
Does not: learn, or need torch.

Weights are float32, the pass runs in float64: libraries for matrix products add up in different orders on different
processors, and in float64 that is too small to turn a decision, so an extraction gives the same trees everywhere.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from codegen.errors import InputError
from codegen.ir import Float32, Float64
from codegen.legality import Mask
from maviper.experts.expert import AS_GIVEN
from maviper.worlds.world import Int, legal_in

LAYERS = (1, 2, 3)
ROWS = 512  # at once: what a layer gives for so many stays in the cache, twice as fast as thousands together
NO_CRITIC = "finish its training, or measure Q: --critic measured"
ACTOR, CRITIC, VALUE = "actor", "critic", "value"
# what an expert's file may hold for each agent, and its card says
ACTOR_CRITIC = "actor-critic"
NETS = {ACTOR_CRITIC: (ACTOR, CRITIC), ACTOR: (ACTOR,), VALUE: (VALUE,)}


@dataclass(frozen=True)
class NetworkExpert:
    """Weights of all agents' networks.

    `tensors` holds, for each agent name A, each net (actor and critic, or value) and each layer L in 1, 2, 3,
    `A.net.L.weight` [inputs, outputs] and `A.net.L.bias` [outputs], float32. `card` says what made them and how
    good they are; `hash` is the SHA-256 of the file.
    """

    agents: tuple[str, ...]
    n_actions: tuple[int, ...]
    tensors: Mapping[str, Float32]
    card: Mapping[str, Any]
    hash: str
    masks: tuple[Mask | None, ...] = ()  # each agent's; (): all actions are always legal
    _wide: Mapping[str, Float64] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_wide", {name: tensor.astype(np.float64) for name, tensor in self.tensors.items()})

    @property
    def centralized(self) -> bool:
        """Critics see all agents; value networks see their own."""
        return not self._has(VALUE)

    def _has(self, net: str) -> bool:
        return f"{self.agents[0]}.{net}.1.weight" in self.tensors

    def act(self, agents: Sequence[int], observations: Sequence[Float32], state: Any = None) -> Int:
        """As `Controller.act`: each agent's greedy action, among legal ones if any is."""
        return np.stack([self._greedy(agent, observations[agent]) for agent in agents], axis=1)

    def _greedy(self, agent: int, obs: Float32) -> Int:
        logits, mask = self.logits(agent, obs), self.masks[agent] if self.masks else None
        return np.argmax(logits if mask is None else np.where(legal_in(mask, obs), logits, -np.inf), axis=1)

    def logits(self, agent: int, obs: Float32) -> Float64:
        """What the greedy action is the argmax of, [batch, n_actions]."""
        net = f"{self.agents[agent]}.{ACTOR if self.centralized else VALUE}"
        weight, bias = (self._wide[f"{net}.1.{part}"] for part in ("weight", "bias"))
        return _in_parts(lambda rows: self._head(net, np.asarray(rows, np.float64) @ weight + bias), obs)

    def q(self, agent: int, observations: Sequence[Float32], state: Any, joint: Int, given: Int) -> Float64:
        """As `Expert.q`. The first layer's part for observations and given actions is computed once per state."""
        if not self.centralized:
            chosen = np.where(joint[:, agent] == AS_GIVEN, given[:, agent, None], joint[:, agent])
            return np.take_along_axis(self.logits(agent, observations[agent]), chosen, axis=1)
        if not self._has(CRITIC):
            raise InputError("this expert has no critic", self.card.get("world", ""), NO_CRITIC)
        net = f"{self.agents[agent]}.{CRITIC}"
        weight = self._wide[f"{net}.1.weight"]
        seen = np.concatenate(list(observations), axis=1).astype(np.float64)
        shared = seen @ weight[: seen.shape[1]] + self._wide[f"{net}.1.bias"]
        first_row = seen.shape[1] + np.concatenate([[0], np.cumsum(self.n_actions)[:-1]])
        asked = np.zeros((len(joint), shared.shape[1]))
        for other, row in enumerate(first_row):
            if joint[0, other] == AS_GIVEN:
                shared = shared + weight[row + given[:, other]]
            else:
                asked = asked + weight[row + joint[:, other]]
        first = shared[:, None, :] + asked
        flat = _in_parts(lambda rows: self._head(net, rows), first.reshape(-1, first.shape[-1]))
        return flat.reshape(first.shape[:2])

    def _head(self, net: str, first: Float64) -> Float64:
        """What follows the first layer's sums, [batch, n_actions]. `first` is overwritten."""
        hidden = np.maximum(first, 0, out=first) @ self._wide[f"{net}.2.weight"]
        hidden += self._wide[f"{net}.2.bias"]
        found = np.maximum(hidden, 0, out=hidden) @ self._wide[f"{net}.3.weight"]
        found += self._wide[f"{net}.3.bias"]
        return found


def _in_parts(function: Callable[[Any], Float64], rows: Any) -> Float64:
    """What a function gives for each row, [batch, outputs], asked for ROWS of them at a time."""
    return np.concatenate([function(rows[low : low + ROWS]) for low in range(0, max(1, len(rows)), ROWS)])
