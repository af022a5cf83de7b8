"""What actors put out, as actions: logits of numbered ones, or the means of numbers within bounds (Gaussian actors).

Does: draws actions, hands them to a world, says how likely they were and how large the entropy is.
Assumes: the extra `maviper[train]`; outputs of stacked networks, [n_agents, batch, n_outputs].
Does not: learn, or know how outputs came about.
"""

import math
from abc import ABC, abstractmethod
from typing import Any

import numpy as np
import torch
from torch import Tensor

from maviper.experts.network import give_numbers
from maviper.experts.training.nets import Joint, Nets, Stacked
from maviper.worlds import World
from maviper.worlds.world import bounds

DEVIATION, LEAST_DEVIATION = 0.6, 0.02  # of drawn numbers, in halves of their ranges: at first, and at least


class Head(ABC):
    """The reader of a network's outputs. `nets`: what is learned beside the actors, by name."""

    def __init__(self, joint: Joint, rng: np.random.Generator) -> None:
        self.joint, self.rng = joint, rng
        self.nets: dict[str, Stacked] = {}

    @abstractmethod
    def draw(self, outputs: Tensor, seen: Tensor) -> Any:
        """Draws in joint observations `seen`: [n_agents, batch] actions, or [n_agents, batch, n_outputs]."""

    @abstractmethod
    def hand_over(self, drawn: Any) -> Any:
        """Converts a draw to what `World.step` takes, agents behind games."""

    @abstractmethod
    def log_probabilities(self, outputs: Tensor, seen: Tensor, drawn: Tensor) -> tuple[Tensor, Tensor]:
        """Of what was drawn, and the entropy, each [n_agents, batch]. `drawn`: games before agents."""


class Choices(Head):
    """Numbered actions, drawn from the softmax of logits; never an illegal one."""

    def draw(self, outputs: Tensor, seen: Tensor) -> Any:
        """Draws actions, legal ones where there are masks; see `Head.draw`."""
        logits = (outputs + self.joint.mask_actions(seen)).cpu().numpy()
        return np.argmax(logits + self.rng.gumbel(size=logits.shape), axis=2)

    def hand_over(self, drawn: Any) -> Any:
        """Returns the numbers of the actions; see `Head.hand_over`."""
        return drawn.T

    def log_probabilities(self, outputs: Tensor, seen: Tensor, drawn: Tensor) -> tuple[Tensor, Tensor]:
        """Returns log-probabilities and entropy; see `Head.log_probabilities`."""
        logits = (outputs + self.joint.mask_actions(seen)).log_softmax(dim=2)
        return logits.gather(2, drawn.T[:, :, None])[..., 0], -(logits.exp() * logits).sum(dim=2)


class Numbers(Head):
    """Numbers within bounds, drawn from normal distributions and then clipped. A mean of -1 stands for the low bound
    and 1 for the high one; deviations are learned too, one for each output of a network.
    """

    def __init__(self, joint: Joint, rng: np.random.Generator, world: World, actor: Nets) -> None:
        super().__init__(joint, rng)
        self.bounds = [bounds(outputs) for outputs in world.outputs]
        n_networks = len(actor.parameters[0])
        started = torch.full((n_networks, 1, joint.n_actions), math.log(DEVIATION), device=joint.device)
        self.spread = Stacked([started.requires_grad_()])
        self.spread.owner = actor.owner
        self.nets = {"spread": self.spread}
        self.own = (joint.forbidden == 0).float()  # [n_agents, 1, n_outputs]: which outputs an agent has

    def _log_deviations(self) -> Tensor:
        """[n_agents, 1, n_outputs]."""
        (logs,) = self.spread.give_each(self.spread.parameters)
        return logs.clamp(min=math.log(LEAST_DEVIATION))

    def draw(self, outputs: Tensor, seen: Tensor) -> Any:
        """Draws numbers, not yet clipped, in halves of the ranges; see `Head.draw`."""
        del seen
        means, deviations = outputs.cpu().numpy(), self._log_deviations().exp().detach().cpu().numpy()
        return (means + deviations * self.rng.standard_normal(means.shape)).astype(np.float32)

    def hand_over(self, drawn: Any) -> Any:
        """Returns numbers within bounds, 0 behind those of an agent that has fewer than others."""
        numbers: Any = np.zeros(drawn.shape, np.float32)
        for mine, (low, high), parts in zip(numbers, self.bounds, drawn, strict=True):
            mine[:, : len(low)] = give_numbers(parts[:, : len(low)], low, high)
        return numbers.swapaxes(0, 1)

    def log_probabilities(self, outputs: Tensor, seen: Tensor, drawn: Tensor) -> tuple[Tensor, Tensor]:
        """Returns log-probabilities and entropy before clipping; see `Head.log_probabilities`."""
        del seen
        logs = self._log_deviations()
        off = (drawn.transpose(0, 1) - outputs) / logs.exp()
        likely = -(off.square() / 2 + logs + math.log(2 * math.pi) / 2) * self.own
        entropy = ((logs + math.log(2 * math.pi * math.e) / 2) * self.own).sum(dim=2)
        return likely.sum(dim=2), entropy.expand(-1, outputs.shape[1])


def head_of(world: World, joint: Joint, actor: Nets, rng: np.random.Generator) -> Head:
    """Returns the head that reads the outputs of the actors of a world's agents."""
    return Numbers(joint, rng, world, actor) if world.outputs else Choices(joint, rng)
