"""Learning from a replay buffer: what MADDPG and VDN share.

Does: keeps transitions in a ring, plays with exploration, updates as often as the settings say.
Assumes: the extra `maviper[train]`; settings with `batch`, `buffer` and `steps_per_update`.
Does not: know what an update is.
"""

from abc import abstractmethod
from collections.abc import Mapping
from typing import Any

import numpy as np
import torch
from torch import Tensor

from maviper.experts.training.nets import Joint
from maviper.experts.training.trainer import Trainer, Transition
from maviper.worlds import World


class Replay:
    """A ring of transitions: joint observations before and after, actions, rewards, who acted and whose episode goes
    on. Those in which nobody acted are not kept.
    """

    def __init__(self, joint: Joint, size: int) -> None:
        self.joint, self.size = joint, size
        wide = joint.n_obs + 1
        self.columns = {
            "seen": torch.zeros(size, wide, device=joint.device),
            "following": torch.zeros(size, wide, device=joint.device),
            "acted": torch.zeros(size, joint.n_agents, dtype=torch.int64, device=joint.device),
            "reward": torch.zeros(size, joint.n_agents, device=joint.device),
            "alive": torch.zeros(size, joint.n_agents, device=joint.device),
            "goes_on": torch.zeros(size, joint.n_agents, device=joint.device),
        }
        self.filled = self.cursor = 0

    def store(self, step: Transition) -> None:
        """Appends a batch of transitions, over the oldest ones when full."""
        kept = torch.from_numpy(np.flatnonzero(step.alive.any(axis=1)))
        count = len(kept)
        rows = (torch.arange(count) + self.cursor) % self.size
        numbers = (torch.from_numpy(each).float() for each in (step.reward, step.alive, step.goes_on))
        added = (step.seen, step.following, torch.from_numpy(step.acted), *numbers)
        for column, values in zip(self.columns.values(), added, strict=True):
            column[rows] = values.to(column.device)[kept.to(column.device)]
        self.cursor = (self.cursor + count) % self.size
        self.filled = min(self.filled + count, self.size)

    def sample(self, count: int, generator: torch.Generator) -> dict[str, Tensor]:
        """`count` transitions, uniform, with replacement."""
        rows = torch.randint(self.filled, (count,), generator=generator).to(self.joint.device)
        return {name: column[rows] for name, column in self.columns.items()}

    def state(self) -> dict[str, Tensor]:
        """Returns the filled part of each column, by name, and the place where it ends."""
        kept = {name: column[: self.filled].cpu() for name, column in self.columns.items()}
        return kept | {"cursor": torch.tensor(self.cursor)}

    def restore(self, state: Mapping[str, Tensor]) -> None:
        """Takes over what `state` gave."""
        self.filled, self.cursor = len(state["acted"]), int(state["cursor"])
        for name, column in self.columns.items():
            column[: self.filled] = state[name].to(column.device)


class OffPolicy(Trainer):
    """A trainer that learns from a replay buffer."""

    def __init__(self, world: World, settings: Any, device: str) -> None:
        super().__init__(world, settings, device)
        self.replay = Replay(self.joint, settings.buffer)
        self.updates = 0

    @abstractmethod
    def act(self, seen: Tensor) -> tuple[Any, float]:
        """The learner's actions, [batch, n_agents], and the share of uniform ones that shall replace them."""

    @abstractmethod
    def update(self) -> float:
        """One update; returns its loss."""

    def advance(self) -> dict[str, float]:
        """Plays one episode of every game, with an update for every `steps_per_update`; see `Trainer.advance`."""
        settings, loss, paid = self.settings, 0.0, 0.0
        for transition in self.transitions(self.act):
            self.replay.store(transition)
            paid += float(transition.reward.mean()) / self.world.spec.episode_steps
            while self.updates < (self.steps - settings.batch) // settings.steps_per_update:
                loss = self.update()
                self.updates += 1
        return {"reward": paid, "loss": loss}

    def exploration(self, start: float) -> float:
        """The share of uniform actions, falling linearly from `start` to `explore_end` over `explore_share`."""
        done = min(1.0, self.progress / self.settings.explore_share)
        return start + (self.settings.explore_end - start) * done

    def memory(self) -> dict[str, Tensor]:
        """Returns the replay buffer and the count of updates; see `Trainer.memory`."""
        return self.replay.state() | {"updates": torch.tensor(self.updates)}

    def remember(self, memory: Mapping[str, Tensor]) -> None:
        """Takes over what `memory` gave; see `Trainer.remember`."""
        self.replay.restore(memory)
        self.updates = int(memory["updates"])
