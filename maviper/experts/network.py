"""Experts as numpy arrays: per agent an actor and a centralized critic, or one value network.

Does: the forward pass of actors (argmax of logits, or numbers within bounds), critics (Q of joint actions) and value
  networks (Q of own actions).
Assumes: two hidden ReLU layers; a critic reads all observations, then all agents' actions one-hot.
Does not: learn, or need torch.

Weights are float32, the pass runs in float64: libraries for matrix products add up in different orders on different
processors, and in float64 that is too small to turn a decision, so an extraction gives the same trees everywhere.
Greedy actions ask float32 first, which takes half the time, and keep its answer where the best logit leads by more than
rounding can turn.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from codegen.errors import InputError
from codegen.ir import Float32, Float64
from codegen.legality import Mask
from maviper.episodes.play import in_columns
from maviper.experts.expert import AS_GIVEN
from maviper.worlds.world import Int, legal_in

LAYERS = (1, 2, 3)
ROWS = 512  # at once: what a layer gives for so many stays in the cache, twice as fast as thousands together
FEW = 256  # rows, which float64 alone decides as soon
ERROR = 2.0**-24 + 2.0**-53  # of one operation in float32, and of the same in float64, relative
LARGEST = 2.0**100  # a sum that is certain to stay below it does not overflow in float32
TINIEST = 2.0**-100  # more than products lose that are too small for float32
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
    bounds: tuple[tuple[Float64, Float64], ...] = ()  # of the numbers that each agent gives; (): agents have actions
    _wide: Mapping[str, Float64] = field(init=False, repr=False)
    _errors: Mapping[str, tuple[Float64, Float64]] = field(init=False, repr=False)  # by acting network

    def __post_init__(self) -> None:
        object.__setattr__(self, "_wide", {name: tensor.astype(np.float64) for name, tensor in self.tensors.items()})
        nets = [self._net(agent) for agent in range(len(self.agents))]
        object.__setattr__(self, "_errors", {net: _largest_errors(net, self._wide) for net in nets})

    @property
    def centralized(self) -> bool:
        """Critics see all agents; value networks see their own."""
        return not self._has(VALUE)

    def _has(self, net: str) -> bool:
        return f"{self.agents[0]}.{net}.1.weight" in self.tensors

    def act(self, agents: Sequence[int], observations: Sequence[Float32], state: Any = None) -> Int:
        """Returns each agent's greedy action, among legal ones if any is, or its numbers, means clipped to the bounds;
        see `Controller.act`.
        """
        if self.bounds:
            return in_columns([self._give(agent, observations[agent]) for agent in agents])
        return np.stack([self._greedy(agent, observations[agent]) for agent in agents], axis=1)

    def _give(self, agent: int, obs: Float32) -> Float32:
        """[batch, n_outputs]; the least batch is two rows, as in `_greedy`."""
        rows = obs if len(obs) > 1 else np.resize(obs, (2, obs.shape[1]))
        return give_numbers(self.logits(agent, rows), *self.bounds[agent])[: len(obs)]

    def _greedy(self, agent: int, obs: Float32) -> Int:
        """In float64 only where float32 leaves a doubt; the least batch of a product is two rows, as one row alone is
        added up in another order.
        """
        doubt = self._doubt(agent, obs) if len(obs) >= FEW and obs.dtype == np.float32 else np.inf
        if doubt == np.inf:
            return np.argmax(self._legal(agent, obs, self.logits(agent, obs)), axis=1)
        actions, lead = _best(self._legal(agent, obs, self._logits(agent, obs, self.tensors)))
        doubtful = np.flatnonzero(~(lead > doubt))
        if len(doubtful):
            rows = np.resize(doubtful, max(2, len(doubtful)))
            actions[rows] = np.argmax(self._legal(agent, obs[rows], self.logits(agent, obs[rows])), axis=1)
        return actions

    def _legal(self, agent: int, obs: Float32, logits: Any) -> Any:
        """The same logits, but for illegal actions."""
        mask = self.masks[agent] if self.masks else None
        return logits if mask is None else np.where(legal_in(mask, obs), logits, -np.inf)

    def _doubt(self, agent: int, obs: Float32) -> float:
        """By how much the difference of two logits in float32 may be off from the one in float64, in every row; inf
        where sums may overflow or are of no numbers.

        Each sum of n products is off by at most n * ERROR of the sum of their sizes (Higham, Accuracy and Stability of
        Numerical Algorithms, 3.1), in whatever order it is added up, and ReLU makes no difference larger.
        """
        size = max(float(obs.max()), -float(obs.min()))
        per_unit, constant = self._errors[self._net(agent)]
        largest, error = (per_unit * size + constant).tolist() if size < LARGEST else (np.inf, np.inf)
        return 2 * error + TINIEST if largest < LARGEST else np.inf

    def _net(self, agent: int) -> str:
        return f"{self.agents[agent]}.{ACTOR if self.centralized else VALUE}"

    def logits(self, agent: int, obs: Float32) -> Float64:
        """Returns the values whose argmax is the greedy action, [batch, n_actions]."""
        return self._logits(agent, obs, self._wide)

    def _logits(self, agent: int, obs: Float32, tensors: Mapping[str, Any]) -> Any:
        """Logits in the precision of `tensors`."""
        net = self._net(agent)
        weight, bias = (tensors[f"{net}.1.{part}"] for part in ("weight", "bias"))
        return _in_parts(lambda rows: self._head(net, np.asarray(rows, weight.dtype) @ weight + bias, tensors), obs)

    def q(self, agent: int, observations: Sequence[Float32], state: Any, joint: Int, given: Int) -> Float64:
        """Returns Q. The first layer's part for observations and given actions is computed once per state."""
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
        flat = _in_parts(lambda rows: self._head(net, rows, self._wide), first.reshape(-1, first.shape[-1]))
        return flat.reshape(first.shape[:2])

    def _head(self, net: str, first: Any, tensors: Mapping[str, Any]) -> Any:
        """Computes the layers after the first layer's sums, [batch, n_actions]. `first` is overwritten."""
        hidden = np.maximum(first, 0, out=first) @ tensors[f"{net}.2.weight"]
        hidden += tensors[f"{net}.2.bias"]
        outputs = np.maximum(hidden, 0, out=hidden) @ tensors[f"{net}.3.weight"]
        outputs += tensors[f"{net}.3.bias"]
        return outputs


def give_numbers(parts: Any, low: Float64, high: Float64) -> Float32:
    """Numbers within bounds, [batch, n_outputs]: -1 stands for the low one, 1 for the high one, and what is beyond them
    is clipped.
    """
    given = (low + high) / 2 + np.asarray(parts, np.float64) * ((high - low) / 2)
    return np.clip(given, low, high).astype(np.float32)


def _largest_errors(net: str, wide: Mapping[str, Float64]) -> tuple[Float64, Float64]:
    """Bounds the size of an output and its error in float32: the parts for each unit of the largest input, and the
    constant parts.
    """
    inputs = len(wide[f"{net}.1.weight"])
    size, error = np.array([np.ones(inputs), np.zeros(inputs)]), np.zeros((2, inputs))  # [per unit and constant, width]
    for layer in LAYERS:
        weight, bias = (np.abs(wide[f"{net}.{layer}.{part}"]) for part in ("weight", "bias"))
        terms = (len(weight) + 1) * ERROR
        size, error = size @ weight, error @ weight
        size[1] += bias
        error += terms / (1 - terms) * (size + error)
    per_unit, constant = np.stack([(size + error).max(axis=1), error.max(axis=1)], axis=1)
    return per_unit, constant


def _best(logits: Any) -> tuple[Int, Any]:
    """Each row's first largest entry, and by how much it is above the second, both [batch]; no NaN. Column by column:
    reductions over rows that are so short take three times as long.
    """
    first, *others = logits.T.copy()
    actions, second = np.zeros(len(logits), np.int64), np.full(len(logits), -np.inf, logits.dtype)
    for action, column in enumerate(others, 1):
        actions[column > first] = action
        np.maximum(second, np.minimum(first, column), out=second)
        np.maximum(first, column, out=first)
    with np.errstate(invalid="ignore"):  # none is legal: no number, and no lead
        return actions, first - second


def _in_parts(function: Callable[[Any], Any], rows: Any) -> Any:
    """Applies a function to all rows, ROWS of them at a time, and returns its results, [batch, outputs]."""
    return np.concatenate([function(rows[low : low + ROWS]) for low in range(0, max(1, len(rows)), ROWS)])
