"""Opponents that are not learned from: a training's own earlier actors, or the world's script.

Does: keeps an actor every twentieth of a training, plays a batch of games as one of them; plays as a script.
Assumes: the extra `maviper[train]`; asked for every step of a batch in order.
Does not: learn, or choose who plays where.
"""

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np
import torch
from torch import Tensor

from codegen.ir import Float32
from maviper.experts.scripted import scripted
from maviper.experts.training.nets import Joint, Nets
from maviper.worlds import World

VERSIONS = 20  # kept in a whole training, at equal distances


class Opponents(Protocol):
    """Whoever plays for agents that are not the learner's in a game."""

    def begin(self, progress: float) -> None:
        """A batch of games is about to start; `progress`: the share of the training that is done."""
        ...

    def act(self, seen: Tensor, observations: Sequence[Float32], state: Any) -> Any:
        """Everybody's actions, [n_agents, batch]. `seen`: the joint observations."""
        ...

    def memory(self) -> dict[str, Tensor]:
        """What a resumed training needs."""
        ...

    def remember(self, memory: Mapping[str, Tensor]) -> None:
        """Takes over what `memory` gave."""
        ...


class Past:
    """The actor as it was at equal distances of the training so far, one of them for each batch, sampled from."""

    def __init__(self, joint: Joint, actor: Nets, rng: np.random.Generator) -> None:
        self.joint, self.actor, self.rng = joint, actor, rng
        self.versions: list[list[Tensor]] = []  # of all parameters
        self.drawn = 0

    def begin(self, progress: float) -> None:
        """As `Opponents.begin`."""
        if progress * VERSIONS >= len(self.versions):
            self.versions.append([parameter.detach().clone() for parameter in self.actor.parameters])
        self.drawn = int(self.rng.integers(len(self.versions)))

    def act(self, seen: Tensor, observations: Sequence[Float32], state: Any) -> Any:
        """As `Opponents.act`."""
        with torch.no_grad():
            logits = self.actor.applied(self.versions[self.drawn], self.joint.views(seen)) + self.joint.forbidden
        return sampled(logits, self.rng)

    def memory(self) -> dict[str, Tensor]:
        """As `Opponents.memory`."""
        return {str(k): torch.stack(every) for k, every in enumerate(zip(*self.versions, strict=True))}

    def remember(self, memory: Mapping[str, Tensor]) -> None:
        """As `Opponents.remember`."""
        stacked = [memory[str(k)].to(self.joint.device) for k in range(len(memory))]
        self.versions = [list(parameters) for parameters in zip(*stacked, strict=True)]


class Script:
    """The world's script."""

    def __init__(self, world: World) -> None:
        self.script, self.agents = scripted(world), range(len(world.agents))

    def begin(self, progress: float) -> None:
        """As `Opponents.begin`: nothing to do."""

    def act(self, seen: Tensor, observations: Sequence[Float32], state: Any) -> Any:
        """As `Opponents.act`."""
        return self.script.act(self.agents, observations, state).T

    def memory(self) -> dict[str, Tensor]:
        """As `Opponents.memory`: nothing."""
        return {}

    def remember(self, memory: Mapping[str, Tensor]) -> None:
        """As `Opponents.remember`: nothing."""


def sampled(logits: Tensor, rng: np.random.Generator) -> Any:
    """An action for each row of logits [n_agents, batch, n_actions], drawn from their softmax, [n_agents, batch]."""
    numbers = logits.cpu().numpy()
    return np.argmax(numbers + rng.gumbel(size=numbers.shape), axis=2)
