"""Opponents that are not learned from: a training's own earlier actors, finished experts, or the world's script.

Does: keeps an actor every twentieth of a training, plays a batch of games as one of them; plays as an expert that
  learned by reward alone; plays as a script.
Assumes: the extra `maviper[train]`; asked for every step of a batch in order.
Does not: learn, or choose who plays where.
"""

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np
import torch
from torch import Tensor

from codegen.errors import InputError
from codegen.ir import Float32
from maviper.episodes.play import Controller
from maviper.experts import cards, network
from maviper.experts.finding import Observing
from maviper.experts.scripted import build_script
from maviper.experts.training.nets import Head, Joint, Nets
from maviper.worlds import World

VERSIONS = 20  # kept in a whole training, at equal distances


class Opponents(Protocol):
    """Whoever plays for agents that are not the learner's in a game."""

    def begin(self, progress: float) -> None:
        """A batch of games is about to start; `progress`: the share of the training that is done."""
        ...

    def act(self, seen: Tensor, observations: Sequence[Float32], state: Any) -> Any:
        """Everybody's actions, [n_agents, batch], or what a `Head` draws. `seen`: the joint observations."""
        ...

    def memory(self) -> dict[str, Tensor]:
        """Returns the tensors that a resumed training needs."""
        ...

    def remember(self, memory: Mapping[str, Tensor]) -> None:
        """Takes over what `memory` gave."""
        ...


class Past:
    """The actor as it was at equal distances of the training so far, one of them for each batch, sampled from as the
    present one is.
    """

    def __init__(self, joint: Joint, actor: Nets, head: Head) -> None:
        self.joint, self.actor, self.head = joint, actor, head
        self.versions: list[list[Tensor]] = []  # of all parameters
        self.drawn = 0

    def begin(self, progress: float) -> None:
        """Keeps the present actor when one is due, and draws the version that plays; see `Opponents.begin`."""
        if progress * VERSIONS >= len(self.versions):
            self.versions.append([parameter.detach().clone() for parameter in self.actor.parameters])
        self.drawn = int(self.head.rng.integers(len(self.versions)))

    def act(self, seen: Tensor, observations: Sequence[Float32], state: Any) -> Any:
        """Draws the actions of the drawn version; see `Opponents.act`."""
        with torch.no_grad():
            outputs = self.actor.apply_weights(self.versions[self.drawn], self.joint.views(seen))
        return self.head.draw(outputs, seen)

    def memory(self) -> dict[str, Tensor]:
        """Returns the versions that are kept; see `Opponents.memory`."""
        return {str(k): torch.stack(every) for k, every in enumerate(zip(*self.versions, strict=True))}

    def remember(self, memory: Mapping[str, Tensor]) -> None:
        """Takes over the versions that `memory` gave; see `Opponents.remember`."""
        stacked = [memory[str(k)].to(self.joint.device) for k in range(len(memory))]
        self.versions = [list(parameters) for parameters in zip(*stacked, strict=True)]


class Finished:
    """Finished experts, one of them for each batch."""

    def __init__(self, world: World, experts: Sequence[Controller], rng: np.random.Generator) -> None:
        self.experts, self.agents, self.rng = experts, range(len(world.agents)), rng
        self.drawn = experts[0]

    def begin(self, progress: float) -> None:
        """Draws the expert that plays the batch; see `Opponents.begin`."""
        self.drawn = self.experts[int(self.rng.integers(len(self.experts)))]

    def act(self, seen: Tensor, observations: Sequence[Float32], state: Any) -> Any:
        """Returns the drawn expert's greedy actions; see `Opponents.act`."""
        return self.drawn.act(self.agents, observations, state).T

    def memory(self) -> dict[str, Tensor]:
        """Returns nothing to keep; see `Opponents.memory`."""
        return {}

    def remember(self, memory: Mapping[str, Tensor]) -> None:
        """Does nothing: there is nothing to take over; see `Opponents.remember`."""


def by_reward_alone(world: World, names: Sequence[str]) -> dict[str, network.NetworkExpert]:
    """The named experts, shipped ones or files, each for all agents of `world`.

    InputError for an expert of another game, and for one that learned from a script, or does not say how it learned.
    """
    return {name: _by_reward_alone(world, name) for name in names}


def _by_reward_alone(world: World, name: str) -> Any:
    expert, played = network.load(name)
    same = ("agents", "landmarks", "episode_steps")
    if any(getattr(played.spec, each) != getattr(world.spec, each) for each in same) or played.teams != world.teams:
        raise InputError("the expert plays another game", f"--against {name}: {played.name}, not {world.name}")
    learned = cards.count_steps(expert.card)
    if not learned or learned[cards.IMITATION] or expert.card["settings"].get("scripted"):
        advice = "choose an expert that learned by reward alone"
        raise InputError("the expert learned from a script, or does not say how", f"--against {name}", advice)
    return expert if played.name == world.name else Observing(expert, played)


class Script:
    """The world's script."""

    def __init__(self, world: World) -> None:
        self.script, self.agents = build_script(world), range(len(world.agents))

    def begin(self, progress: float) -> None:
        """Does nothing; see `Opponents.begin`."""

    def act(self, seen: Tensor, observations: Sequence[Float32], state: Any) -> Any:
        """Returns the script's actions; see `Opponents.act`."""
        return self.script.act(self.agents, observations, state).T

    def memory(self) -> dict[str, Tensor]:
        """Returns nothing to keep; see `Opponents.memory`."""
        return {}

    def remember(self, memory: Mapping[str, Tensor]) -> None:
        """Does nothing: there is nothing to take over; see `Opponents.remember`."""
