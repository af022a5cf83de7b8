"""Imitating a scripted teacher with the networks that are trained on afterwards (DAgger, Ross et al. 2011).

Does: plays with the learner, asks the teacher what it would do there, fits the actors to the answers.
Assumes: the extra `maviper[train]`; a teacher that decides from the world's state; a world that has one, so one of
  ours, in which nobody's episode ends early.
Does not: need rewards; the critic comes later.
"""

from collections.abc import Mapping

import numpy as np
import torch
from torch import Tensor
from torch.nn.functional import cross_entropy

from maviper.episodes.play import Controller
from maviper.experts.training.nets import Adam, Joint, Nets
from maviper.worlds import World

KEPT = 1_000_000  # points, the newest
MINIBATCH = 4_096
UPDATES = 60  # per batch of episodes


class Imitation:
    """The points met so far, labelled by the teacher, and the fit to them."""

    def __init__(
        self, world: World, joint: Joint, actor: Nets, teacher: Controller, generator: torch.Generator
    ) -> None:
        self.world, self.joint, self.actor, self.teacher, self.generator = world, joint, actor, teacher, generator
        self.seen = torch.zeros(0, joint.n_obs + 1, device=joint.device)
        self.wanted = torch.zeros(0, joint.n_agents, dtype=torch.int64, device=joint.device)

    def round(self, games: int, rng: np.random.Generator, optimiser: Adam, rate: float) -> tuple[int, float, float]:
        """One batch of episodes and UPDATES steps; returns the joint steps played, the fidelity and the loss.

        The learner plays greedily from the second round on; the teacher plays the first.
        """
        state = self.world.start(games, rng)
        seen, wanted, agreed = [], [], 0.0
        everybody = range(self.joint.n_agents)
        for _ in range(self.world.spec.episode_steps):
            observations = self.world.observe(state)
            seen.append(self.joint.tensor(observations))
            labels = self.teacher.act(everybody, observations, state)
            with torch.no_grad():
                chosen = (self.actor(self.joint.views(seen[-1])) + self.joint.forbidden).argmax(dim=2).T.cpu().numpy()
            agreed += float((chosen == labels).mean()) / self.world.spec.episode_steps
            state = self.world.step(state, chosen if len(self.seen) else labels)
            wanted.append(torch.from_numpy(labels).to(self.joint.device))
        self.seen = torch.cat([self.seen, *seen])[-KEPT:]
        self.wanted = torch.cat([self.wanted, *wanted])[-KEPT:]
        loss = torch.zeros(())
        for _ in range(UPDATES):
            rows = torch.randint(len(self.seen), (MINIBATCH,), generator=self.generator).to(self.joint.device)
            logits = self.actor(self.joint.views(self.seen[rows])) + self.joint.forbidden
            labels = self.wanted[rows].T
            loss = cross_entropy(logits.flatten(0, 1), labels.flatten()) * self.joint.n_agents
            optimiser.descend(loss, rate)
        return games * self.world.spec.episode_steps, agreed, float(loss.detach())

    def state(self) -> dict[str, Tensor]:
        """The points met so far, by name."""
        return {"seen": self.seen.cpu(), "wanted": self.wanted.cpu()}

    def restore(self, state: Mapping[str, Tensor]) -> None:
        """Takes over what `state` gave."""
        self.seen, self.wanted = (state[name].to(self.joint.device) for name in ("seen", "wanted"))
