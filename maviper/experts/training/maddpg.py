"""MADDPG (Lowe et al. 2017), all agents' networks in one batched update.

Does: trains one actor and one centralized critic per agent on a batched world.
Assumes: the extra `maviper[train]`; discrete actions through a straight-through Gumbel softmax.
Does not: write files (train.py) or play a part in extraction, which needs numpy only.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from torch import Tensor

from codegen.ir import Float32
from maviper.experts.network import ACTOR_CRITIC
from maviper.experts.training.nets import Adam, Nets, average_rows
from maviper.experts.training.replay import OffPolicy
from maviper.worlds import World


@dataclass(frozen=True)
class Settings:
    """Training settings; differences from the released code are noted."""

    steps: int = 6_000_000  # joint environment steps
    games: int = 1_024  # played in parallel (released: 1)
    batch: int = 1_024  # transitions per update (released: 25,600)
    steps_per_update: int = 100  # joint steps per update round (as released)
    hidden: int = 64
    scaled: int = 0  # 1: the first layer scales observations, by mean and deviation in random play
    learning_rate: float = 0.01  # Adam
    final_rate: float = 0.1  # share of the learning rate left at the end (released: 1, constant)
    gamma: float = 0.95
    tau: float = 0.01  # soft target update
    shaping: float = 1.0  # weight of the world's shaping term; 0 is plain MADDPG
    explore_start: float = 1.0  # share of uniform actions, falling linearly ...
    explore_end: float = 0.05
    explore_share: float = 0.3  # ... over this share of the steps
    logit_penalty: float = 0.001
    gradient_norm: float = 0.5
    buffer: int = 1_000_000  # transitions
    checkpoint_steps: int = 102_400
    seed: int = 0


class Maddpg(OffPolicy):
    """Actors, critics, their slow copies and the replay buffer."""

    networks = ACTOR_CRITIC

    def __init__(self, world: World, settings: Settings, device: str) -> None:
        super().__init__(world, settings, device)
        joint, hidden = self.joint, settings.hidden
        for name, sizes, fans in (
            ("actor", (joint.widest, hidden, hidden, joint.n_actions), joint.widths),
            ("critic", (joint.critic_inputs, hidden, hidden, 1), [joint.critic_inputs] * joint.n_agents),
        ):
            nets, slow = (Nets(sizes, fans, self.generator, device) for _ in range(2))
            slow.copy_from(nets, 1.0)
            self.nets |= {name: nets, f"{name}.slow": slow}
            self.optimisers[name] = Adam((nets,), settings.learning_rate, settings.gradient_norm)

    def act(self, seen: Tensor) -> tuple[Any, float]:
        """Returns samples of the policies; see `OffPolicy.act`."""
        with torch.no_grad():
            logits = self._logits("actor", seen).cpu().numpy()
        sampled = np.argmax(logits + self.rng.gumbel(size=logits.shape), axis=2).T
        return sampled, self.exploration(self.settings.explore_start)

    def _logits(self, nets: str, seen: Tensor) -> Tensor:
        return self.nets[nets](self.joint.views(seen)) + self.joint.forbidden

    def update(self) -> float:
        """One update of all critics, all actors and the slow copies, on one shared sample."""
        settings, joint = self.settings, self.joint
        batch = self.replay.sample(settings.batch, self.generator)
        seen, following = batch["seen"], batch["following"]
        reward, alive, goes_on = self.scale_rewards(batch["reward"])[:, :, None], batch["alive"].T, batch["goes_on"].T
        rate = settings.learning_rate * (1 - (1 - settings.final_rate) * self.progress)
        with torch.no_grad():
            then = joint.one_hot(self._logits("actor.slow", following).argmax(2).T)
            later = self.nets["critic.slow"](joint.critic_input(following, then))
            target = reward + settings.gamma * goes_on[:, :, None] * later
        q = self.nets["critic"](joint.critic_input(seen, joint.one_hot(batch["acted"])))
        loss = average_rows((q - target).square(), alive).sum()
        self.optimisers["critic"].descend(loss, rate)

        logits = self._logits("actor", seen)
        others = joint.one_hot(logits.detach().argmax(2).T)  # [batch, n_agents, n_actions]
        mask = torch.eye(joint.n_agents, device=self.device)[:, None, :, None]
        acted = self._straight_through(logits)[:, :, None, :] * mask + others[None] * (1 - mask)
        q = self.nets["critic"](joint.critic_input(seen, acted))
        penalty = average_rows((logits * (joint.forbidden == 0)).square(), alive)
        self.optimisers["actor"].descend((-average_rows(q, alive) + settings.logit_penalty * penalty).sum(), rate)
        for name in ("actor", "critic"):
            self.nets[f"{name}.slow"].copy_from(self.nets[name], settings.tau)
        return float(loss.detach())

    def _straight_through(self, logits: Tensor) -> Tensor:
        """A hard Gumbel-softmax sample (Jang et al. 2017) whose gradient is the soft one's."""
        noise = -torch.log(-torch.log(self.uniform(*logits.shape).clamp(1e-12, 1 - 1e-7)))
        soft = (logits + noise).softmax(dim=2)
        hard = torch.nn.functional.one_hot(soft.argmax(dim=2), soft.shape[2]).float()
        return hard - soft.detach() + soft

    def tensors(self) -> dict[str, Float32]:
        """Returns the tensors of the actors and critics; see `Trainer.tensors`."""
        return self.joint.export_actors(self.nets["actor"]) | self.joint.export_critics(self.nets["critic"])
