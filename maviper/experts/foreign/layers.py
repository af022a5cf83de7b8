"""An expert of one fully connected network: its forward pass in numpy, and observation normalisation before it.

Does: the greedy action of all agents by the same network, or the numbers that they give; the worth of an agent's own
  actions as its outputs say.
Assumes: outputs are Q values, or logits, which tell how sure the policy is and no more; or numbers for bounds that they
  are clipped to (means), or that tanh spreads them over (squashed).
Does not: read files.

Weights are float32 and the pass runs in float64, as for our own networks (network.py).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from codegen.errors import InputError, UnknownNameError
from codegen.ir import Float32, Float64
from maviper.episodes.play import in_columns
from maviper.experts.expert import AS_GIVEN
from maviper.worlds import World
from maviper.worlds.world import Int

LOGITS, Q, MEANS, SQUASHED = "logits", "q", "means", "squashed"
GIVING = (MEANS, SQUASHED)  # where agents give numbers
OUTPUTS = (LOGITS, Q, *GIVING)
LOG_PROBABILITIES, LEARNED, NOBODY = "log-probabilities", "learned", "none"  # whose Q an expert answers with
ACTIVATIONS: Mapping[str, Callable[[Float64], Float64]] = {
    "elu": lambda x: np.where(x > 0, x, np.expm1(np.minimum(x, 0))),
    "leakyrelu": lambda x: np.where(x > 0, x, 0.01 * x),
    "relu": lambda x: np.maximum(x, 0),
    "sigmoid": lambda x: 1 / (1 + np.exp(-np.clip(x, -700, 700))),
    "tanh": np.tanh,
}


class Linear(NamedTuple):
    """One layer: `weight` [outputs, inputs] and `bias` [outputs], float32, as torch has them."""

    weight: Float32
    bias: Float32


@dataclass(frozen=True)
class Normalization:
    """The normalization of a network's observations: clip((x - mean) / sqrt(var + epsilon), -clip, clip).

    `mean`, `var`: [n_features] float64. Of stable-baselines3's VecNormalize: `obs_rms.mean`, `obs_rms.var`,
    `clip_obs` and `epsilon`. InputError for numbers that cannot be that.
    """

    mean: Float64
    var: Float64
    clip: float = 10.0
    epsilon: float = 1e-8

    def __post_init__(self) -> None:
        mean, var = (np.asarray(each, np.float64) for each in (self.mean, self.var))
        finite = np.isfinite([self.clip, self.epsilon]).all() and np.isfinite(mean).all() and np.isfinite(var).all()
        if mean.ndim != 1 or mean.shape != var.shape or not finite or (var + self.epsilon <= 0).any() or self.clip <= 0:
            what = "mean and var are not two rows of finite numbers, or var, clip or epsilon is negative"
            raise InputError(what, "normalization", "take them from the training's VecNormalize")
        object.__setattr__(self, "mean", mean)
        object.__setattr__(self, "var", var)

    def __call__(self, obs: Float32) -> Float32:
        """Returns the normalized observations, [batch, n_features], computed as VecNormalize computes them."""
        moved = (np.asarray(obs, np.float32) - self.mean) / np.sqrt(self.var + self.epsilon)
        return np.clip(moved, -self.clip, self.clip).astype(np.float32)


@dataclass(frozen=True)
class LayersExpert:
    """The same network for every agent of `world`. `outputs`: one of OUTPUTS; `hash`: SHA-256 of its file, or "".

    InputError where the network does not fit an agent's features, and its actions or outputs.
    """

    world: World
    layers: Sequence[Linear]
    activation: str
    outputs: str = LOGITS
    normalization: Normalization | None = None
    card: Mapping[str, Any] = field(default_factory=dict[str, Any])
    hash: str = ""
    centralized: bool = field(default=False, init=False, repr=False)  # the network sees an agent's own observation only
    _wide: Sequence[tuple[Float64, Float64]] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        if self.activation not in ACTIVATIONS:
            raise UnknownNameError("activation", self.activation, ACTIVATIONS, "activation")
        if self.outputs not in OUTPUTS:
            raise UnknownNameError("kind of outputs", self.outputs, OUTPUTS, "outputs")
        sizes = [self.layers[0].weight.shape[1], *(layer.weight.shape[0] for layer in self.layers)]
        for before, layer in zip(sizes, self.layers, strict=False):
            fits = layer.weight.shape[1] == before and layer.bias.shape == layer.weight.shape[:1]
            if not fits or not all(np.isfinite(part).all() for part in layer):
                raise InputError("the network's layers do not follow one another, or are not finite", self.world.name)
        giving = self.world.continuous
        if (self.outputs in GIVING) != giving:
            what = (
                f"the network's outputs are {self.outputs}, and agents {'give numbers' if giving else 'have actions'}"
            )
            advice = f"say outputs={MEANS} or {SQUASHED}" if giving else "name the world that it was trained in"
            raise InputError(what, self.world.name, advice)
        does = self.world.decided
        for agent, features, actions in zip(self.world.agents, self.world.features, does, strict=True):
            wanted = len(features), len(actions)
            if (sizes[0], sizes[-1]) != wanted:
                what = f"the network has {sizes[0]} inputs and {sizes[-1]} outputs"
                has = f"gives {wanted[1]}" if giving else f"has {wanted[1]} actions"
                where = f"{self.world.name}: {agent} observes {wanted[0]} numbers and {has}"
                raise InputError(what, where, "name the world that it was trained in")
        if self.normalization is not None and len(self.normalization.mean) != sizes[0]:
            what = f"the normalisation is of {len(self.normalization.mean)} numbers, not {sizes[0]}"
            raise InputError(what, self.world.name, "take the statistics of the same training")
        wide = [(layer.weight.astype(np.float64).T, layer.bias.astype(np.float64)) for layer in self.layers]
        object.__setattr__(self, "_wide", wide)

    @property
    def agents(self) -> tuple[str, ...]:
        """The world's agents."""
        return self.world.agents

    @property
    def critic(self) -> str:
        """The kind of critic by which states are weighed."""
        if self.outputs in GIVING:
            return NOBODY
        return LEARNED if self.outputs == Q else LOG_PROBABILITIES

    def act(self, agents: Sequence[int], observations: Sequence[Float32], state: Any = None) -> Int:
        """Returns each agent's greedy action, or the numbers that it gives without noise; see `Controller.act`."""
        del state
        if self.outputs in GIVING:
            return in_columns([self.give_numbers(agent, observations[agent]) for agent in agents])
        return np.stack([np.argmax(self.values(observations[agent]), axis=1) for agent in agents], axis=1)

    def give_numbers(self, agent: int, obs: Float32) -> Float32:
        """The numbers that an agent gives, within their bounds; [batch, n_outputs]."""
        low, high = self.world.bounds[agent]
        numbers = self._forward(obs)
        if self.outputs == SQUASHED:
            numbers = low + (np.tanh(numbers) + 1) / 2 * (high - low)
        return np.clip(numbers, low, high).astype(np.float32)

    def values(self, obs: Float32) -> Float64:
        """Q of each action, or its log-probability; [batch, n_actions]."""
        scores = self._forward(obs)
        if self.outputs == Q:
            return scores
        top = scores.max(axis=1, keepdims=True)
        return scores - top - np.log(np.exp(scores - top).sum(axis=1, keepdims=True))

    def _forward(self, obs: Float32) -> Float64:
        activations = np.asarray(obs if self.normalization is None else self.normalization(obs), np.float64)
        hidden = ACTIVATIONS[self.activation]
        for place, (weight, bias) in enumerate(self._wide):
            activations = (hidden(activations) if place else activations) @ weight + bias
        return activations

    def q(self, agent: int, observations: Sequence[Float32], state: Any, joint: Int, given: Int) -> Float64:
        """Returns Q, of logits the log-probabilities: the weight V - min Q is then VIPER's for policies."""
        del state
        if self.outputs in GIVING:
            raise NotImplementedError
        chosen = np.where(joint[:, agent] == AS_GIVEN, given[:, agent, None], joint[:, agent])
        return np.take_along_axis(self.values(observations[agent]), chosen, axis=1)
