"""What every trainer has: networks, optimisers, random state, reward statistics, and a state that can be saved.

Does: saves and restores everything that a training depends on, so that a resumed run repeats an uninterrupted one.
Assumes: the extra `maviper[train]`; saved at the end of an `advance`.
Does not: know an algorithm or touch files.
"""

import json
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import torch
from torch import Tensor

from codegen.errors import InputError
from codegen.ir import Float32
from maviper.episodes.play import Controller
from maviper.experts.cards import REWARD
from maviper.experts.network import ACTOR, VALUE, NetworkExpert, shapes
from maviper.experts.training.nets import Adam, Joint, Nets, Running, Stacked, measure_scale
from maviper.worlds import World

# from joint observations to actions, [batch, n_agents], and the share of uniform ones that shall replace them
Choose = Callable[[Tensor], tuple[Any, float]]


SOFTENED = 0.1  # of an expert's logits is what a training begins with: where they are sharp, it would try nothing else


class Transition(NamedTuple):
    """One step of every game."""

    seen: Tensor  # joint observations
    acted: Any  # [batch, n_agents], as the rest
    reward: Any
    following: Tensor  # joint observations afterwards
    alive: Any  # who acted, or waited for its turn; of the others nothing else here is to be used
    goes_on: Any  # ... and whose episode did not end by itself with this step


class Trainer(ABC):
    """One training in progress. `advance` plays some episodes and learns from them."""

    networks: str  # the kind of expert file that `tensors` makes

    def __init__(self, world: World, settings: Any, device: str) -> None:
        self.world, self.settings, self.device = world, settings, device
        scaled, shared = settings.scaled, getattr(settings, "shared", False)
        scale = measure_scale(world, self.most_games, settings.seed, bool(shared)) if scaled else None
        self.joint = Joint(world, device, scale)
        self.generator = torch.Generator().manual_seed(settings.seed)
        self.rng = np.random.default_rng(settings.seed)
        self.running = Running(self.joint.n_agents)
        self.nets: dict[str, Stacked] = {}
        self.optimisers: dict[str, Adam] = {}
        self.steps = 0

    def begin(self, expert: NetworkExpert) -> None:
        """Starts from the expert's actors, or value networks. InputError where they do not fit this training's."""
        kind = VALUE if self.networks == VALUE else ACTOR
        wanted = shapes(self.world, self.settings.hidden, kind)
        actual = {name: expert.tensors[name].shape for name in wanted if name in expert.tensors}
        if actual != wanted or any(nets.owner is not None for nets in self.nets.values()):
            advice = "choose an expert of the same agents, with networks of their own of the same size and kind"
            raise InputError("the training cannot start from these networks", self.world.name, advice)
        for name, nets in self.nets.items():
            if isinstance(nets, Nets) and name.partition(".")[0] == kind:  # a slow copy too
                self.joint.load_actors(nets, expert.tensors, kind)
                if kind == ACTOR:
                    nets.soften(SOFTENED)

    @property
    def progress(self) -> float:
        """Share of the steps that are done."""
        return self.steps / self.settings.steps

    @property
    def teaches(self) -> str:
        """The signal by which the next `advance` teaches the actors, as `cards.count_steps` names it."""
        return REWARD

    @property
    def until(self) -> int:
        """The step at which what `teaches` ends."""
        return self.settings.steps

    @property
    def most_games(self) -> int:
        """Games in parallel: the setting, or fewer where the world plays fewer at once."""
        return min(self.settings.games, self.world.games or self.settings.games)

    @property
    def games(self) -> int:
        """Games of the next batch: fewer where so many would play on beyond `until`."""
        left = -((self.steps - self.until) // self.world.spec.episode_steps)
        return max(1, min(self.most_games, left))

    @abstractmethod
    def advance(self) -> dict[str, float]:
        """One batch of episodes and the updates from it; returns what to log."""

    @abstractmethod
    def tensors(self) -> dict[str, Float32]:
        """The expert so far, in the names and shapes of `network.NetworkExpert`."""

    def meet(self, experts: Sequence[Controller]) -> None:
        """Plays some games against these experts, which are not learned from."""
        raise NotImplementedError

    def rewards(self, state: Any) -> Any:
        """Returns the learner's rewards on entering `state`, [batch, n_agents]."""
        return self.world.rewards(state) + self.settings.shaping * self.world.shaping(state)

    def uniform(self, *shape: int) -> Tensor:
        """Numbers in [0, 1) from the trainer's own generator."""
        return torch.rand(*shape, generator=self.generator).to(self.device)

    def transitions(self, choose: Choose) -> Iterator[Transition]:
        """One episode of every game, step by step; some actions of `choose` are replaced by uniform ones."""
        world = self.world
        state = world.start(self.games, self.rng)
        alive, observations = world.playing(state), world.observe(state)
        seen = self.joint.tensor(observations)
        for _ in range(world.spec.episode_steps):
            chosen, share = choose(seen)
            uniform = self._uniform_actions(observations)
            acted = np.where(self.rng.random(chosen.shape) < share, uniform, chosen)
            state = world.step(state, acted)
            reward = self.rewards(state)
            observations = world.observe(state)
            following = self.joint.tensor(observations)
            goes_on = alive & ~world.terminated(state)
            self.steps += int(alive.any(axis=1).sum())
            self.running.add(reward, alive, goes_on)
            yield Transition(seen, acted, reward, following, alive, goes_on)
            seen, alive = following, world.playing(state)
            if not alive.any():
                return

    def _uniform_actions(self, observations: Sequence[Float32]) -> Any:
        """Everybody's random actions, [batch, n_agents], legal ones where there are masks."""
        shape = len(observations[0]), self.joint.n_agents
        if not self.joint.masked:
            return self.rng.integers(self.joint.choices, size=shape)
        return self.world.draw_actions(range(self.joint.n_agents), observations, self.rng.random(shape))

    def scale_rewards(self, reward: Tensor) -> Tensor:
        """Rewards [batch, n_agents] by the scale of everything seen so far, [n_agents, batch]."""
        mean, deviation = (torch.from_numpy(part).float().to(self.device) for part in self.running.scale())
        return ((reward - mean) / deviation).T

    # --- saving

    def memory(self) -> dict[str, Tensor]:
        """Data that a trainer keeps beside its networks (replay buffers)."""
        return {}

    def remember(self, memory: Mapping[str, Tensor]) -> None:
        """Takes over what `memory` gave."""
        assert not memory

    def state(self) -> tuple[dict[str, Tensor], str]:
        """Everything that the rest of the training depends on: tensors, and the rest as JSON."""
        tensors = {f"memory.{name}": value for name, value in self.memory().items()}
        for name, nets in self.nets.items():
            tensors |= {f"net.{name}.{k}": value.detach().cpu() for k, value in enumerate(nets.parameters)}
        for name, optimiser in self.optimisers.items():
            tensors |= {f"adam.{name}.{key}": value for key, value in optimiser.state().items()}
        tensors["generator"] = self.generator.get_state()
        facts = {
            "steps": self.steps,
            "random": self.rng.bit_generator.state,
            "running": self.running.state(),
        }
        return {name: value.clone().contiguous() for name, value in tensors.items()}, json.dumps(facts)

    def restore(self, tensors: Mapping[str, Tensor], facts: str) -> None:
        """Takes over what `state` gave; KeyError or RuntimeError when it belongs to another training."""
        known = json.loads(facts)
        self.steps = known["steps"]
        self.rng.bit_generator.state = known["random"]
        self.running.restore(known["running"])
        self.generator.set_state(tensors["generator"])
        with torch.no_grad():
            for name, nets in self.nets.items():
                for k, parameter in enumerate(nets.parameters):
                    parameter.copy_(tensors[f"net.{name}.{k}"])
        for name, optimiser in self.optimisers.items():
            optimiser.restore(_under(tensors, f"adam.{name}."))
        self.remember(_under(tensors, "memory."))


def _under(tensors: Mapping[str, Tensor], prefix: str) -> dict[str, Tensor]:
    return {name.removeprefix(prefix): value for name, value in tensors.items() if name.startswith(prefix)}
