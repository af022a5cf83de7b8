"""Learning from a replay buffer: MADDPG (Lowe et al. 2017) and VDN (Sunehag et al. 2018).

Does: keeps transitions in a ring, plays with exploration, updates as often as the settings say: one actor and one
  centralized critic per agent (MADDPG), or one value network per agent, Q_i(o_i, a_i), with double Q-learning on the
  team's reward (VDN). For actors that learned otherwise it fits a critic of joint actions afterwards (fitted Q
  evaluation): plays the frozen policies with some actions replaced by random ones, and fits Q_i(x, joint action), what
  agent i earns when everybody follows the policies from then on, up to the end of its episode if that ends by itself.
Assumes: the extra `maviper[train]`; settings with `batch`, `buffer` and `steps_per_update`; discrete actions, through a
  straight-through Gumbel softmax (MADDPG); each team learns for itself, the other teams are part of its world (VDN).
Does not: mix values by a network. QMIX (Rashid et al. 2018) represents more, but its Q_i only order an agent's actions:
  their differences are no returns, and the extraction weights V_i - min Q_i need differences that are.
"""

import math
from abc import abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from torch import Tensor

from codegen.ir import Float32
from maviper.experts.network import ACTOR_CRITIC, VALUE
from maviper.experts.training.nets import Adam, Joint, Nets, average_rows
from maviper.experts.training.trainer import Trainer, Transition
from maviper.worlds import World

USUAL_STEPS = 25_600  # steps of a batch in our games: 1,024 episodes of 25 steps


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


@dataclass(frozen=True)
class MaddpgSettings:
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

    def __init__(self, world: World, settings: MaddpgSettings, device: str) -> None:
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


@dataclass(frozen=True)
class VdnSettings:
    """Training settings of VDN."""

    steps: int = 3_000_000  # joint environment steps
    games: int = 1_024
    batch: int = 2_048  # transitions per update
    steps_per_update: int = 200
    hidden: int = 64
    scaled: int = 0  # 1: the first layer scales observations, by mean and deviation in random play
    learning_rate: float = 1e-3  # Adam, falls linearly to a tenth
    gamma: float = 0.95
    tau: float = 0.01
    shaping: float = 1.0
    explore_end: float = 0.05
    explore_share: float = 0.3
    gradient_norm: float = 5.0
    buffer: int = 1_000_000
    checkpoint_steps: int = 102_400
    seed: int = 0


class Vdn(OffPolicy):
    """Value networks, their slow copies and the replay buffer."""

    networks = VALUE

    def __init__(self, world: World, settings: VdnSettings, device: str) -> None:
        super().__init__(world, settings, device)
        joint, hidden = self.joint, settings.hidden
        sizes = (joint.widest, hidden, hidden, joint.n_actions)
        nets, slow = (Nets(sizes, joint.widths, self.generator, device) for _ in range(2))
        slow.copy_from(nets, 1.0)
        self.nets = {"value": nets, "value.slow": slow}
        self.optimisers = {"value": Adam((nets,), settings.learning_rate, settings.gradient_norm)}
        teams = [[float(agent in members) for agent in world.agents] for members in world.teams.values()]
        self.teams = torch.tensor(teams, device=device)  # [n_teams, n_agents]

    def act(self, seen: Tensor) -> tuple[Any, float]:
        """Returns the greedy actions and the share of uniform ones; see `OffPolicy.act`."""
        with torch.no_grad():
            return self._q("value", seen).argmax(2).T.cpu().numpy(), self.exploration(1.0)

    def _q(self, nets: str, seen: Tensor) -> Tensor:
        """[n_agents, batch, n_actions]."""
        return self.nets[nets](self.joint.views(seen)) + self.joint.forbidden

    def update(self) -> float:
        """One update of all value networks on the temporal differences of all teams together."""
        settings = self.settings
        batch = self.replay.sample(settings.batch, self.generator)
        alive, goes_on = batch["alive"].T, batch["goes_on"].T  # who has left adds nothing to its team's value
        acting = ((self.teams @ alive) > 0).float()  # [n_teams, batch]
        sizes = self.teams.sum(dim=1, keepdim=True)
        reward = (self.teams / sizes) @ (self.scale_rewards(batch["reward"]) * alive)  # [n_teams, batch]
        with torch.no_grad():
            best = self._q("value", batch["following"]).argmax(2, keepdim=True)
            then = self._q("value.slow", batch["following"]).gather(2, best)[..., 0]
            target = reward + settings.gamma * self.teams @ (then * goes_on)
        chosen = self._q("value", batch["seen"]).gather(2, batch["acted"].T[:, :, None])[..., 0] * alive
        loss = average_rows((self.teams @ chosen - target).square(), acting).sum()
        self.optimisers["value"].descend(loss, settings.learning_rate * (1 - 0.9 * self.progress))
        self.nets["value.slow"].copy_from(self.nets["value"], settings.tau)
        return float(loss.detach())

    def tensors(self) -> dict[str, Float32]:
        """Returns the tensors of the value networks; see `Trainer.tensors`."""
        return self.joint.export_actors(self.nets["value"], VALUE)


@dataclass(frozen=True)
class CriticSettings:
    """Settings of the fit of a critic to frozen actors."""

    steps: int = 512_000  # joint environment steps; the training's at most, where few games play at once
    games: int = 1_024
    explore: float = 0.3  # share of uniform actions, so that Q is known beside the policy too
    updates: int = 120  # per batch of episodes, or USUAL_STEPS steps in a world that plays few games at once
    batch: int = 2_048
    hidden: int = 64
    learning_rate: float = 2e-3  # Adam, falls linearly to a tenth
    gamma: float = 0.95
    tau: float = 0.02
    shaping: float = 1.0
    gradient_norm: float = 5.0
    scaled: int = 0  # as the actors' training
    seed: int = 0


class CriticFit(Trainer):
    """The critic of frozen actors."""

    networks = "critic"

    def __init__(self, world: World, actors: Mapping[str, Float32], settings: CriticSettings, device: str) -> None:
        super().__init__(world, settings, device)
        joint, hidden = self.joint, settings.hidden
        width = actors[f"{world.agents[0]}.actor.2.weight"].shape[0]
        self.actor = Nets((joint.widest, width, width, joint.n_actions), joint.widths, self.generator, device)
        joint.load_actors(self.actor, actors)
        sizes = (joint.critic_inputs, hidden, hidden, 1)
        fans = [joint.critic_inputs] * joint.n_agents
        self.critic, self.slow = (Nets(sizes, fans, self.generator, device) for _ in range(2))
        self.slow.copy_from(self.critic, 1.0)
        self.optimiser = Adam((self.critic,), settings.learning_rate, settings.gradient_norm)
        self.replay = Replay(joint, settings.steps)
        self.updated = 0

    def advance(self) -> dict[str, float]:
        """Plays a batch of episodes and updates the critic; see `Trainer.advance`."""
        for transition in self.transitions(lambda seen: (self._greedy(seen).cpu().numpy(), self.settings.explore)):
            self.replay.store(transition)
        updates = self.settings.updates
        if self.world.games is not None:
            updates = max(1, updates * self.steps // USUAL_STEPS - self.updated)
        self.updated += updates
        return {"loss": sum(self._update() for _ in range(updates)) / updates}

    def _greedy(self, seen: Tensor) -> Tensor:
        with torch.no_grad():
            return (self.actor(self.joint.views(seen)) + self.joint.mask_actions(seen)).argmax(2).T

    def _update(self) -> float:
        settings, joint = self.settings, self.joint
        batch = self.replay.sample(settings.batch, self.generator)
        reward, goes_on = self.scale_rewards(batch["reward"])[:, :, None], batch["goes_on"].T[:, :, None]
        with torch.no_grad():
            then = joint.one_hot(self._greedy(batch["following"]))
            target = reward + settings.gamma * goes_on * self.slow(joint.critic_input(batch["following"], then))
        q = self.critic(joint.critic_input(batch["seen"], joint.one_hot(batch["acted"])))
        loss = average_rows((q - target).square(), batch["alive"].T).sum()
        self.optimiser.descend(loss, settings.learning_rate * (1 - 0.9 * self.progress))
        self.slow.copy_from(self.critic, settings.tau)
        return float(loss.detach())

    def tensors(self) -> dict[str, Float32]:
        """The critics alone, in the names and shapes of `network.NetworkExpert`."""
        return self.joint.export_critics(self.critic)


def fit_critic(
    world: World,
    actors: Mapping[str, Float32],
    settings: CriticSettings,
    device: str,
    on_step: Callable[[int, int, float], None] = lambda done, total, loss: None,
) -> dict[str, Any]:
    """Critics for frozen actors, in the names and shapes of `network.NetworkExpert`. `on_step`: gets the joint steps
    played, those to play, and the last loss.
    """
    fitting, loss = CriticFit(world, actors, settings, device), math.nan
    on_step(0, settings.steps, loss)
    while fitting.steps < settings.steps:
        loss = fitting.advance()["loss"]
        on_step(fitting.steps, settings.steps, loss)
    return fitting.tensors()
