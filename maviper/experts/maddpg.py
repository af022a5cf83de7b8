"""MADDPG (Lowe et al. 2017) in torch, all agents' networks stacked into batched products.

Does: trains one actor and one centralized critic per agent on a batched world, keeps the best checkpoint.
Assumes: the extra `maviper[train]`; discrete actions through a straight-through Gumbel softmax.
Does not: write files (train.py) or play a part in extraction, which needs numpy only.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from torch import Tensor
from torch.nn.functional import gumbel_softmax, one_hot

from codegen.ir import Float32
from maviper.experts.network import LAYERS
from maviper.worlds import ParticleWorld


@dataclass(frozen=True)
class Settings:
    """Training settings; differences from the released code are noted."""

    steps: int = 6_000_000  # joint environment steps
    games: int = 1_024  # played in parallel (released: 1)
    batch: int = 1_024  # transitions per update (released: 25,600)
    steps_per_update: int = 100  # joint steps per update round (as released)
    hidden: int = 64
    learning_rate: float = 0.01  # Adam, decays linearly to a tenth (released: constant)
    gamma: float = 0.95
    tau: float = 0.01  # soft target update
    covering: float = 1.0  # weight of the world's shaping term; 0 is plain MADDPG
    explore_start: float = 1.0  # share of uniform actions, falling linearly ...
    explore_end: float = 0.05
    explore_share: float = 0.3  # ... over this share of the steps
    logit_penalty: float = 0.001
    gradient_norm: float = 0.5
    buffer: int = 1_000_000  # transitions
    checkpoint_steps: int = 102_400
    seed: int = 0


class Nets:
    """One two-hidden-layer network per agent, as stacked weights [n_agents, inputs, outputs]."""

    def __init__(self, sizes: tuple[int, int, int, int], fan_in: list[int], generator: torch.Generator) -> None:
        self.parameters: list[Tensor] = []
        for layer in LAYERS:
            inputs, outputs = sizes[layer - 1], sizes[layer]
            fans = fan_in if layer == 1 else [inputs] * len(fan_in)
            bound = torch.tensor([fan**-0.5 for fan in fans])[:, None, None]
            for rows in (inputs, 1):
                uniform = torch.rand(len(fan_in), rows, outputs, generator=generator) * 2 - 1
                self.parameters.append((uniform * bound).requires_grad_())

    def __call__(self, x: Tensor) -> Tensor:
        """x: [n_agents, batch, inputs] -> [n_agents, batch, outputs]."""
        w1, b1, w2, b2, w3, b3 = self.parameters
        x = torch.relu(torch.baddbmm(b1, x, w1))
        x = torch.relu(torch.baddbmm(b2, x, w2))
        return torch.baddbmm(b3, x, w3)

    def copy_from(self, other: "Nets", share: float) -> None:
        """Moves every weight by `share` towards `other`'s."""
        with torch.no_grad():
            for mine, theirs in zip(self.parameters, other.parameters, strict=True):
                mine.lerp_(theirs, share)


class Learner:
    """The networks, their optimisers and the replay buffer."""

    def __init__(self, world: ParticleWorld, settings: Settings) -> None:
        self.world, self.settings = world, settings
        self.generator = torch.Generator().manual_seed(settings.seed)
        torch.manual_seed(settings.seed)
        self.widths = [len(features) for features in world.features]
        self.n_agents, self.n_actions = len(self.widths), len(world.actions[0])
        self.n_obs = sum(self.widths)
        wide, hidden = max(self.widths), settings.hidden
        # columns of the joint observation that each agent sees; the spare column n_obs is zero
        starts = np.concatenate([[0], np.cumsum(self.widths)[:-1]])
        view = [
            [*range(start, start + width), *[self.n_obs] * (wide - width)]
            for start, width in zip(starts, self.widths, strict=True)
        ]
        self.view = torch.tensor(view)
        critic_inputs = self.n_obs + self.n_agents * self.n_actions
        shapes = ((wide, hidden, hidden, self.n_actions), (critic_inputs, hidden, hidden, 1))
        fans = (self.widths, [critic_inputs] * self.n_agents)
        self.actor, self.actor_target = self._pair(shapes[0], fans[0])
        self.critic, self.critic_target = self._pair(shapes[1], fans[1])
        self.optimisers = [
            torch.optim.Adam(nets.parameters, lr=settings.learning_rate) for nets in (self.actor, self.critic)
        ]
        size = settings.buffer
        self.seen = torch.zeros(size, self.n_obs + 1)
        self.following = torch.zeros(size, self.n_obs + 1)
        self.acted = torch.zeros(size, self.n_agents, dtype=torch.int64)
        self.reward = torch.zeros(size, self.n_agents)
        self.filled = self.cursor = 0

    def _pair(self, sizes: tuple[int, int, int, int], fans: list[int]) -> tuple[Nets, Nets]:
        nets, target = (Nets(sizes, fans, self.generator) for _ in range(2))
        target.copy_from(nets, 1.0)
        return nets, target

    def _views(self, joint: Tensor) -> Tensor:
        """[batch, n_obs + 1] -> [n_agents, batch, widest]."""
        return joint[:, self.view].transpose(0, 1)

    def explore(self, observations: tuple[Float32, ...], share: float, rng: np.random.Generator) -> np.ndarray:
        """Actions for training, [batch, n_agents]: uniform with probability `share`, else sampled from the policy."""
        joint = self._joint(observations)
        with torch.no_grad():
            logits = self.actor(self._views(joint)).numpy()
        sampled = np.argmax(logits + rng.gumbel(size=logits.shape), axis=2).T
        uniform = rng.integers(self.n_actions, size=sampled.shape)
        return np.where(rng.random(sampled.shape) < share, uniform, sampled)

    def _joint(self, observations: tuple[Float32, ...]) -> Tensor:
        batch = len(observations[0])
        return torch.from_numpy(np.concatenate([*observations, np.zeros((batch, 1), np.float32)], axis=1))

    def store(
        self, seen: tuple[Float32, ...], acted: np.ndarray, reward: np.ndarray, following: tuple[Float32, ...]
    ) -> None:
        """Appends a batch of transitions to the ring buffer."""
        count = len(acted)
        rows = (torch.arange(count) + self.cursor) % self.settings.buffer
        self.seen[rows], self.following[rows] = self._joint(seen), self._joint(following)
        self.acted[rows], self.reward[rows] = torch.from_numpy(acted), torch.from_numpy(reward.astype(np.float32))
        self.cursor = (self.cursor + count) % self.settings.buffer
        self.filled = min(self.filled + count, self.settings.buffer)

    def update(self, mean: Tensor, deviation: Tensor) -> None:
        """One update round of all critics, all actors and the targets, on one shared sample."""
        rows = torch.randint(self.filled, (self.settings.batch,), generator=self.generator)
        seen, following = self.seen[rows], self.following[rows]
        reward = ((self.reward[rows] - mean) / deviation).T[:, :, None]
        with torch.no_grad():
            next_acted = self._one_hot(self.actor_target(self._views(following)).argmax(2).T)
            target = reward + self.settings.gamma * self.critic_target(self._critic_input(following, next_acted))
        q = self.critic(self._critic_input(seen, self._one_hot(self.acted[rows])))
        loss = (q - target).square().mean(dim=(1, 2)).sum()
        self._descend(self.optimisers[1], self.critic, loss)

        logits = self.actor(self._views(seen))
        own = gumbel_softmax(logits, hard=True)
        others = self._one_hot(logits.detach().argmax(2).T)  # [batch, n_agents, n_actions]
        mask = torch.eye(self.n_agents)[:, None, :, None]
        acted = own[:, :, None, :] * mask + others[None] * (1 - mask)
        q = self.critic(self._critic_input(seen, acted))
        loss = (-q.mean(dim=(1, 2)) + self.settings.logit_penalty * logits.square().mean(dim=(1, 2))).sum()
        self._descend(self.optimisers[0], self.actor, loss)
        self.actor_target.copy_from(self.actor, self.settings.tau)
        self.critic_target.copy_from(self.critic, self.settings.tau)

    def _one_hot(self, acted: Tensor) -> Tensor:
        return one_hot(acted, self.n_actions).float()

    def _critic_input(self, seen: Tensor, acted: Tensor) -> Tensor:
        """acted: [batch, n_agents, n_actions], or with a leading [n_agents] where the critics are asked differently."""
        state = seen[:, : self.n_obs].expand(self.n_agents, -1, -1)
        flat = acted.flatten(-2).expand(self.n_agents, -1, -1)
        return torch.cat([state, flat], dim=2)

    def _descend(self, optimiser: torch.optim.Optimizer, nets: Nets, loss: Tensor) -> None:
        gradients = torch.autograd.grad(loss, nets.parameters)
        norm = sum(gradient.square().sum(dim=(1, 2)) for gradient in gradients)
        scale = (self.settings.gradient_norm / (torch.as_tensor(norm).sqrt() + 1e-6)).clamp(max=1.0)
        for parameter, gradient in zip(nets.parameters, gradients, strict=True):
            parameter.grad = gradient * scale[:, None, None]
        optimiser.step()

    def tensors(self) -> dict[str, Float32]:
        """The networks in the names and shapes of `network.Expert`."""
        named: dict[str, Float32] = {}
        for index, agent in enumerate(self.world.agents):
            for net, nets, inputs in (("actor", self.actor, self.widths[index]), ("critic", self.critic, None)):
                arrays = [parameter.detach()[index].numpy().copy() for parameter in nets.parameters]
                for layer in LAYERS:
                    weight, bias = arrays[2 * layer - 2], arrays[2 * layer - 1]
                    named[f"{agent}.{net}.{layer}.weight"] = weight[:inputs] if layer == 1 else weight
                    named[f"{agent}.{net}.{layer}.bias"] = bias[0]
        return named


def train(
    world: ParticleWorld, settings: Settings, score: Callable[[dict[str, Float32]], Any]
) -> Iterator[tuple[int, dict[str, Float32], Any]]:
    """Trains, yielding (steps so far, tensors, score(tensors)) at every checkpoint."""
    learner = Learner(world, settings)
    rng = np.random.default_rng(settings.seed)
    steps = updates = 0
    total = total_squared = np.zeros(len(world.agents))
    next_checkpoint = settings.checkpoint_steps
    while steps < settings.steps:
        state = world.start(settings.games, rng)
        seen = world.observe(state)
        for _ in range(world.spec.episode_steps):
            progress = steps / settings.steps
            explored = min(1.0, progress / settings.explore_share)
            share = settings.explore_start + (settings.explore_end - settings.explore_start) * explored
            acted = learner.explore(seen, share, rng)
            state = world.step(state, acted)
            reward = world.rewards(state) + settings.covering * world.shaping(state)
            following = world.observe(state)
            learner.store(seen, acted, reward, following)
            seen = following
            steps += len(acted)
            total = total + reward.sum(axis=0)
            total_squared = total_squared + np.square(reward).sum(axis=0)
            mean = total / steps
            deviation = np.sqrt(np.maximum(total_squared / steps - mean**2, 1e-6))
            scale = torch.from_numpy(mean).float(), torch.from_numpy(deviation).float()
            for optimiser in learner.optimisers:
                optimiser.param_groups[0]["lr"] = settings.learning_rate * (1 - 0.9 * progress)
            while updates < (steps - settings.batch) // settings.steps_per_update:
                learner.update(*scale)
                updates += 1
        if steps >= next_checkpoint or steps >= settings.steps:
            next_checkpoint += settings.checkpoint_steps
            tensors = learner.tensors()
            yield steps, tensors, score(tensors)
