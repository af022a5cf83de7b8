"""A critic of joint actions for policies that are frozen: fitted Q evaluation.

Does: plays the policies with some actions replaced by random ones and fits Q_i(x, joint action), what agent i earns
  when everybody follows the policies afterwards, up to the end of its episode if that ends by itself.
Assumes: the extra `maviper[train]`; actors in the shapes of `network.NetworkExpert`.
Does not: change a policy.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import torch

from codegen.ir import Float32
from maviper.experts.training.nets import Adam, Nets, average_rows
from maviper.experts.training.off_policy import Replay
from maviper.experts.training.trainer import Trainer
from maviper.worlds import World

USUAL = 25_600  # steps of a batch in our games: 1,024 episodes of 25 steps


@dataclass(frozen=True)
class Settings:
    """Settings of the fit."""

    steps: int = 512_000  # joint environment steps; the training's at most, where few games play at once
    games: int = 1_024
    explore: float = 0.3  # share of uniform actions, so that Q is known beside the policy too
    updates: int = 120  # per batch of episodes, or USUAL steps in a world that plays few games at once
    batch: int = 2_048
    hidden: int = 64
    learning_rate: float = 2e-3  # Adam, falls linearly to a tenth
    gamma: float = 0.95
    tau: float = 0.02
    shaping: float = 1.0
    gradient_norm: float = 5.0
    scaled: int = 0  # as the actors' training
    seed: int = 0


class Fit(Trainer):
    """The critic of frozen actors."""

    networks = "critic"

    def __init__(self, world: World, actors: Mapping[str, Float32], settings: Settings, device: str) -> None:
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
        updates = self._due()
        self.updated += updates
        return {"loss": sum(self._update() for _ in range(updates)) / updates}

    def _due(self) -> int:
        """Counts the updates that follow the batch."""
        if self.world.games is None:
            return self.settings.updates
        return max(1, self.settings.updates * self.steps // USUAL - self.updated)

    def _greedy(self, seen: torch.Tensor) -> torch.Tensor:
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


def fit(
    world: World,
    actors: Mapping[str, Float32],
    settings: Settings,
    device: str,
    on_step: Callable[[int, int, float], None] = lambda done, total, loss: None,
) -> dict[str, Any]:
    """Critics for frozen actors, in the names and shapes of `network.NetworkExpert`. `on_step`: gets the joint steps
    played, those to play, and the last loss.
    """
    fitting, loss = Fit(world, actors, settings, device), math.nan
    on_step(0, settings.steps, loss)
    while fitting.steps < settings.steps:
        loss = fitting.advance()["loss"]
        on_step(fitting.steps, settings.steps, loss)
    return fitting.tensors()
