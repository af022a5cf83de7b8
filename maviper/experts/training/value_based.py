"""VDN (Sunehag et al. 2018): value-based learning for teams, whose joint value is the sum of its members' values.

Does: trains one value network per agent, Q_i(o_i, a_i), with double Q-learning on the team's reward.
Assumes: the extra `maviper[train]`; each team learns for itself, the other teams are part of its world.
Does not: mix values by a network. QMIX (Rashid et al. 2018) represents more, but its Q_i only order an agent's actions:
  their differences are no returns, and the extraction weights V_i - min Q_i need differences that are.
"""

from dataclasses import dataclass
from typing import Any

import torch
from torch import Tensor

from codegen.ir import Float32
from maviper.experts.network import VALUE
from maviper.experts.training.nets import Adam, Nets, average_rows
from maviper.experts.training.replay import OffPolicy
from maviper.worlds import World


@dataclass(frozen=True)
class Settings:
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

    def __init__(self, world: World, settings: Settings, device: str) -> None:
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
