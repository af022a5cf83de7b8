"""Networks of all agents in torch, stacked into batched matrix products, and what trainers share around them.

Does: stacked weights and two-hidden-layer networks, joint observations and their views by agent, Adam with state that
  can be saved; what actors put out, as actions: logits of numbered ones, or the means of numbers within bounds
  (Gaussian actors). Takes mean and deviation of every feature from random play, since networks learn from scaled
  observations, and folds them into a first layer, or out of it: networks are stored for plain ones.
Assumes: the extra `maviper[train]`; one scale for a whole training, the same for the same seed.
Does not: know an algorithm; follow a policy to where it leads later, clip, or scale actions. Masks are read from plain
  observations.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from torch import Tensor
from torch.nn.functional import one_hot

from codegen.ir import Float32, Float64
from codegen.paths import LEGAL
from maviper.experts.network import ACTOR, CRITIC, LAYERS, give_numbers
from maviper.worlds import World

# Added to the logit of an action that an agent does not have, or that is illegal: its probability is 0 then. With -inf
# the entropy would be NaN.
FORBIDDEN = -1e9
LEAST_POINTS = 5_000  # joint observations of random play, in whole batches of episodes
LEAST_SHARE = 0.1  # of a feature's largest size that its deviation is taken to be at least
DRAWS = 1_701  # beside the seed, so that the draws are not those of the training


class Stacked:
    """Weights of all agents, each stacked as [n_agents, ..., ...].

    Agents may share them: then they are [n_networks, ..., ...], and `owner` says whose is whose.
    """

    owner: Tensor | None = None  # [n_agents]: the index of each agent's network; None: each its own

    def __init__(self, parameters: list[Tensor]) -> None:
        self.parameters = parameters

    def give_each(self, parameters: Sequence[Tensor]) -> Sequence[Tensor]:
        """Weights like its own, as each agent has them, [n_agents, ..., ...]."""
        return parameters if self.owner is None else [parameter[self.owner] for parameter in parameters]


class Nets(Stacked):
    """One two-hidden-layer network per agent, as stacked weights [n_agents, inputs, outputs]."""

    def __init__(
        self, sizes: Sequence[int], fan_in: Sequence[int], generator: torch.Generator, device: str, last: float = 1.0
    ) -> None:
        """`fan_in`: each network's own inputs; the rest of its first layer never sees data. `last` scales the
        output.
        """
        super().__init__([])
        for layer in LAYERS:
            inputs, outputs = sizes[layer - 1], sizes[layer]
            fans = fan_in if layer == 1 else [inputs] * len(fan_in)
            bound = torch.tensor([fan**-0.5 for fan in fans])[:, None, None] * (last if layer == LAYERS[-1] else 1.0)
            for rows in (inputs, 1):
                uniform = torch.rand(len(fan_in), rows, outputs, generator=generator) * 2 - 1
                self.parameters.append((uniform * bound).to(device).requires_grad_())

    def __call__(self, x: Tensor) -> Tensor:
        """x: [n_agents, batch, inputs] -> [n_agents, batch, outputs]."""
        return self.apply_weights(self.parameters, x)

    def apply_weights(self, parameters: Sequence[Tensor], x: Tensor) -> Tensor:
        """The same with other weights than its own."""
        w1, b1, w2, b2, w3, b3 = self.give_each(parameters)
        x = torch.relu_(torch.baddbmm(b1, x, w1))
        x = torch.relu_(torch.baddbmm(b2, x, w2))
        return torch.baddbmm(b3, x, w3)

    def copy_from(self, other: "Nets", share: float) -> None:
        """Moves every weight by `share` towards `other`'s."""
        with torch.no_grad():
            for mine, theirs in zip(self.parameters, other.parameters, strict=True):
                mine.lerp_(theirs, share)

    def export_weights(
        self, agents: Sequence[str], net: str, inputs: Sequence[int], outputs: Sequence[int]
    ) -> dict[str, Any]:
        """The weights in the names and shapes of `network.NetworkExpert`, padding cut off."""
        named: dict[str, Float32] = {}
        for index, agent in enumerate(agents):
            own = index if self.owner is None else int(self.owner[index])
            arrays = [parameter.detach()[own].cpu().numpy().copy() for parameter in self.parameters]
            for layer in LAYERS:
                weight, bias = arrays[2 * layer - 2], arrays[2 * layer - 1][0]
                weight = weight[: inputs[index]] if layer == 1 else weight
                last = outputs[index] if layer == LAYERS[-1] else None
                named[f"{agent}.{net}.{layer}.weight"] = weight[:, :last]
                named[f"{agent}.{net}.{layer}.bias"] = bias[:last]
        return named

    def soften(self, share: float) -> None:
        """Scales the outputs by `share`, which leaves the greatest one where it is."""
        with torch.no_grad():
            for parameter in self.parameters[-2:]:
                parameter.mul_(share)

    def load(self, tensors: Mapping[str, Float32], agents: Sequence[str], net: str) -> None:
        """Takes over weights in the names and shapes of `network.NetworkExpert`."""
        with torch.no_grad():
            for index, agent in enumerate(agents):
                for layer in LAYERS:
                    weight, bias = (torch.from_numpy(tensors[f"{agent}.{net}.{layer}.{k}"]) for k in ("weight", "bias"))
                    rows, columns = weight.shape
                    self.parameters[2 * layer - 2][index, :rows, :columns] = weight
                    self.parameters[2 * layer - 1][index, 0, :columns] = bias


@dataclass(frozen=True)
class Scale:
    """The numbers that scale an observation, (plain - mean) / deviation; each [n_columns]."""

    mean: Float64
    deviation: Float64

    def fold(self, weight: Float32, bias: Float32, columns: Sequence[int]) -> tuple[Float32, Float32]:
        """The first layer for plain observations, of one for scaled ones. `weight`: [n_inputs, width], of which the
        first rows are those of `columns`; `bias`: [width].
        """
        wide, count, read = weight.astype(np.float64), len(columns), list(columns)
        wide[:count] /= self.deviation[read, None]
        return wide.astype(np.float32), (bias - self.mean[read] @ wide[:count]).astype(np.float32)

    def unfold(self, weight: Float32, bias: Float32, columns: Sequence[int]) -> tuple[Float32, Float32]:
        """The first layer for scaled observations, of one for plain ones: `fold` the other way."""
        wide, count, read = weight.astype(np.float64), len(columns), list(columns)
        moved = bias + self.mean[read] @ wide[:count]
        wide[:count] *= self.deviation[read, None]
        return wide.astype(np.float32), moved.astype(np.float32)


def measure_scale(world: World, games: int, seed: int, shared: bool) -> Scale:
    """The scale of joint observations, side by side as agents are. `games`: played in parallel; `shared`: team-mates
    have one, since they have one network. A feature that does not change is moved, not stretched.
    """
    rng = np.random.default_rng([DRAWS, seed])
    points = np.concatenate(_play_at_random(world, games, rng)).astype(np.float64)
    mine = np.split(points, np.cumsum([len(features) for features in world.features])[:-1], axis=1)
    means, deviations = list[Float64](), list[Float64]()
    for agent, name in enumerate(world.agents):
        alike = world.members(world.team_of(name)) if shared else [agent]
        seen = np.concatenate([mine[other] for other in alike])
        least = LEAST_SHARE * np.abs(seen).max(axis=0)
        deviation = np.maximum(seen.std(axis=0), least)
        means.append(seen.mean(axis=0))
        deviations.append(np.where(deviation > 0, deviation, 1.0))
    return Scale(np.concatenate(means), np.concatenate(deviations))


def _play_at_random(world: World, games: int, rng: np.random.Generator) -> list[Any]:
    """Joint observations of whole episodes, each [n, n_columns], of games in which somebody plays."""
    met: list[Any] = []
    everybody, count = range(len(world.agents)), 0
    while count < LEAST_POINTS:
        state = world.start(games, rng)
        for _ in range(world.spec.episode_steps):
            observations, playing = world.observe(state), np.flatnonzero(world.playing(state).any(axis=1))
            if not len(playing):
                break
            met.append(np.concatenate(observations, axis=1)[playing])
            count += len(playing)
            uniform = rng.random((len(observations[0]), *world.acting_shape))
            state = world.step(state, world.draw_actions(everybody, observations, uniform))
    return met


class Joint:
    """The conversion of a world's observations and actions to tensors.

    A joint observation is all agents' observations side by side and one zero column, which pads the views of agents
    that see less than others. `scale`: what networks read is scaled by it, and their first layers are given and taken
    for plain observations; None: they read plain ones.
    """

    def __init__(self, world: World, device: str, scale: Scale | None = None) -> None:
        self.device = device
        self.agents = world.agents
        self.widths = [len(features) for features in world.features]
        self.choices = [len(does) for does in world.decided]  # or numbers that an agent gives
        self.n_agents, self.n_actions = len(self.widths), max(self.choices)
        self.n_obs, self.widest = sum(self.widths), max(self.widths)
        starts = np.concatenate([[0], np.cumsum(self.widths)[:-1]])
        self.scale, self.columns = scale, [range(at, at + width) for at, width in zip(starts, self.widths, strict=True)]
        padded = [] if scale is None else [(scale.mean, 0.0), (scale.deviation, 1.0)]
        self._scaling = [torch.tensor([*numbers, pad], device=device).float() for numbers, pad in padded]
        view = [
            [*range(start, start + width), *[self.n_obs] * (self.widest - width)]
            for start, width in zip(starts, self.widths, strict=True)
        ]
        self.view = torch.tensor(view, device=device)
        self.teams = torch.tensor([list(world.teams).index(world.team_of(agent)) for agent in world.agents])
        self.alike = all(len({self.widths[k] for k in world.members(team)}) == 1 for team in world.teams)
        nearest = [
            sorted(range(self.n_agents), key=lambda other, k=k: (other != k, self.teams[other] != self.teams[k]))
            for k in range(self.n_agents)
        ]
        order = [
            [c for other in row for c in range(starts[other], starts[other] + self.widths[other])] for row in nearest
        ]
        self.order = torch.tensor(order, device=device)  # [n_agents, n_obs]
        own = torch.arange(self.n_actions)[None, :] < torch.tensor(self.choices)[:, None]
        self.forbidden = torch.where(own, 0.0, FORBIDDEN)[:, None, :].to(device)  # [n_agents, 1, n_actions]
        self.masked = world.masked
        self.asked, self.always = (each.to(device) for each in self._masks(world, starts))
        # the rows of a critic's inputs that real agents and actions use
        self.critic_inputs = self.n_obs + self.n_agents * self.n_actions

    def _masks(self, world: World, starts: Sequence[int]) -> tuple[Tensor, Tensor]:
        """Locates the column of a joint observation that says whether an action is legal, and marks the actions that
        always are; each [n_agents, n_actions].
        """
        asked = torch.full((self.n_agents, self.n_actions), self.n_obs)
        always = torch.zeros(self.n_agents, self.n_actions, dtype=torch.bool)
        for agent, start in enumerate(starts):
            for action, place in enumerate(world.mask(agent) or [None] * self.choices[agent]):
                if place is None:
                    always[agent, action] = True
                else:
                    asked[agent, action] = int(start) + place
        return asked, always

    def mask_actions(self, joint: Tensor) -> Tensor:
        """Returns what is added to logits in joint observations [batch, n_obs + 1]: FORBIDDEN for actions that an agent
        does not have, or that are illegal, else 0; [n_agents, batch or 1, n_actions]. Where none of its own is legal,
        an agent does not act, and all of them count.
        """
        if not self.masked:
            return self.forbidden
        legal = (_columns(joint, self.asked) > LEGAL) | self.always[:, None]
        legal |= ~legal.any(dim=2, keepdim=True)
        return torch.where(legal, self.forbidden, FORBIDDEN)

    def tensor(self, observations: Sequence[Float32]) -> Tensor:
        """[batch, n_obs + 1]."""
        batch = len(observations[0])
        joint = np.concatenate([*observations, np.zeros((batch, 1), np.float32)], axis=1)
        return torch.from_numpy(joint).to(self.device)

    def _scale_joint(self, joint: Tensor) -> Tensor:
        """Joint observations as networks read them."""
        if not self._scaling:
            return joint
        mean, deviation = self._scaling
        return (joint - mean) / deviation

    def views(self, joint: Tensor) -> Tensor:
        """[batch, n_obs + 1] -> [n_agents, batch, widest]."""
        return _columns(self._scale_joint(joint), self.view)

    def share_observations(self, joint: Tensor) -> Tensor:
        """[batch, n_obs + 1] -> [n_agents, batch, n_obs]: everybody's critic sees everything."""
        return self._scale_joint(joint)[:, : self.n_obs].expand(self.n_agents, -1, -1)

    def own_first(self, joint: Tensor) -> Tensor:
        """Arranges observations for each agent: its own come first, then its team-mates', then the others'."""
        return _columns(self._scale_joint(joint), self.order)

    def one_hot(self, acted: Tensor) -> Tensor:
        """[batch, n_agents] -> [batch, n_agents, n_actions]."""
        return one_hot(acted, self.n_actions).float()

    def critic_input(self, seen: Tensor, acted: Tensor) -> Tensor:
        """acted: [batch, n_agents, n_actions], or with a leading [n_agents] where the critics are asked differently."""
        flat = acted.flatten(-2).expand(self.n_agents, -1, -1)
        return torch.cat([self.share_observations(seen), flat], dim=2)

    def export_critics(self, critic: Nets) -> dict[str, Float32]:
        """Critics in the shapes of `network.NetworkExpert`: rows of actions that no agent has are left out."""
        named = critic.export_weights(self.agents, CRITIC, [self.critic_inputs] * self.n_agents, [1] * self.n_agents)
        rows = [*range(self.n_obs)]
        for agent, choices in enumerate(self.choices):
            rows += range(self.n_obs + agent * self.n_actions, self.n_obs + agent * self.n_actions + choices)
        named = {name: array[rows] if name.endswith("critic.1.weight") else array for name, array in named.items()}
        return named if self.scale is None else self._fold(self.scale.fold, named, CRITIC)

    def export_actors(self, actor: Nets, net: str = ACTOR) -> dict[str, Float32]:
        """Actors, or value networks, in the shapes of `network.NetworkExpert`."""
        named = actor.export_weights(self.agents, net, self.widths, self.choices)
        return named if self.scale is None else self._fold(self.scale.fold, named, net)

    def load_actors(self, actor: Nets, tensors: Mapping[str, Float32], net: str = ACTOR) -> None:
        """Gives actors, or value networks, what `export_actors` gave."""
        given = tensors if self.scale is None else self._fold(self.scale.unfold, tensors, net)
        actor.load(given, self.agents, net)

    def _fold(self, moved: Any, tensors: Mapping[str, Float32], net: str) -> dict[str, Float32]:
        """The tensors, with the first layers of `net` as `moved` gives them."""
        folded = dict(tensors)
        for agent, columns in zip(self.agents, self.columns, strict=True):
            names = [f"{agent}.{net}.1.{part}" for part in ("weight", "bias")]
            read = range(self.n_obs) if net == CRITIC else columns
            folded |= zip(names, moved(*(tensors[name] for name in names), read), strict=True)
        return folded


def _columns(joint: Tensor, chosen: Tensor) -> Tensor:
    """[batch, n] -> [n_agents, batch, width], of columns [n_agents, width]. Indexing by a table is ten times slower."""
    return joint.index_select(1, chosen.flatten()).unflatten(1, chosen.shape).transpose(0, 1)


class Adam:
    """Adam over stacked networks, the gradient's norm limited for each agent, with state that can be saved."""

    def __init__(self, nets: Sequence[Stacked], rate: float, norm: float) -> None:
        self.parameters = [parameter for net in nets for parameter in net.parameters]
        self.optimiser = torch.optim.Adam(self.parameters, lr=rate, eps=1e-5)
        self.norm = norm

    def descend(self, loss: Tensor, rate: float) -> None:
        """One step against the gradient of a loss that is a sum over agents."""
        gradients = torch.autograd.grad(loss, self.parameters)
        squared = sum(gradient.square().sum(dim=(1, 2)) for gradient in gradients)
        scale = (self.norm / (torch.as_tensor(squared).sqrt() + 1e-6)).clamp(max=1.0)
        for parameter, gradient in zip(self.parameters, gradients, strict=True):
            parameter.grad = gradient * scale[:, None, None]
        self.optimiser.param_groups[0]["lr"] = rate
        self.optimiser.step()

    def state(self) -> dict[str, Tensor]:
        """Moments and counts, by name."""
        state: dict[str, Tensor] = {}
        for index, parameter in enumerate(self.parameters):
            for key, value in self.optimiser.state.get(parameter, {}).items():
                state[f"{index}.{key}"] = torch.as_tensor(value).cpu()
        return state

    def restore(self, state: Mapping[str, Tensor]) -> None:
        """Takes over what `state` gave."""
        for name, value in state.items():
            index, key = name.split(".")
            parameter = self.parameters[int(index)]
            placed = value if key == "step" else value.to(parameter.device)
            self.optimiser.state[parameter][key] = placed.clone()


class Running:
    """Mean and deviation of rewards, per agent, over all steps that agents took so far.

    Once an episode has ended by itself the deviation is from 0, and the mean is 0: whoever can end an episode would be
    paid, or spared, what is taken off every reward.
    """

    def __init__(self, n_agents: int) -> None:
        self.count, self.total, self.squares = np.zeros(n_agents), np.zeros(n_agents), np.zeros(n_agents)
        self.ended = False

    def add(self, rewards: Any, alive: Any, goes_on: Any) -> None:
        """All [..., n_agents]: what was paid, who acted, and whose episode did not end by itself with that step."""
        flat, taken = rewards.reshape(-1, rewards.shape[-1]), alive.reshape(-1, rewards.shape[-1])
        if not taken.all():
            flat = np.where(taken, flat, 0.0)
        self.count = self.count + taken.sum(axis=0)
        self.total = self.total + flat.sum(axis=0)
        self.squares = self.squares + np.square(flat).sum(axis=0)
        self.ended = self.ended or bool((alive & ~goes_on).any())

    def scale(self) -> tuple[Any, Any]:
        """(mean, deviation), each [n_agents]."""
        count = np.maximum(self.count, 1)
        mean = self.total / count * (not self.ended)
        return mean, np.sqrt(np.maximum(self.squares / count - mean**2, 1e-6))

    def state(self) -> list[Any]:
        """Everything, as JSON has it."""
        return [self.count.tolist(), self.total.tolist(), self.squares.tolist(), self.ended]

    def restore(self, state: Sequence[Any]) -> None:
        """Takes over what `state` gave."""
        *parts, self.ended = state
        self.count, self.total, self.squares = map(np.array, parts)


def average_rows(values: Tensor, taken: Tensor) -> Tensor:
    """Each agent's mean over the rows in which it acts, [n_agents]. values: [n_agents, batch, ...]; taken: [n_agents,
    batch], 1 or 0.
    """
    share = (taken.sum(dim=1) / taken.shape[1]).clamp(min=1 / taken.shape[1])
    weights = taken.reshape(*taken.shape, *[1] * (values.dim() - 2))
    return (values * weights).mean(dim=tuple(range(1, values.dim()))) / share


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
        self.bounds = world.bounds
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
    return Numbers(joint, rng, world, actor) if world.continuous else Choices(joint, rng)
