"""MAPPO (Yu et al. 2022): proximal policy optimisation with centralized values, all agents in one batched update.

Does: trains one actor and one centralized value function per agent on a batched world, episode by episode; before that,
  where it is asked for, imitates a scripted teacher with the same networks (DAgger, Ross et al. 2011). In a share of
  the games opponents play that are not learned from: the training's own earlier actors, finished experts, or a script.
Assumes: the extra `maviper[train]`. Where agents give numbers, actors are Gaussian (nets.py). A teacher decides from
  the world's state, in a world of ours in which nobody's episode ends early.
Does not: give a critic of joint actions (off_policy.py fits one to the frozen policy), write files.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import torch
from torch import Tensor
from torch.nn.functional import cross_entropy

from codegen.errors import InputError
from codegen.ir import Float32
from maviper.episodes.play import Controller
from maviper.experts import cards, network
from maviper.experts.cards import IMITATION, REWARD, VALUES
from maviper.experts.finding import Observing
from maviper.experts.network import ACTOR
from maviper.experts.scripted import build_script
from maviper.experts.training.nets import Adam, Head, Joint, Nets, average_rows, head_of
from maviper.experts.training.trainer import Trainer
from maviper.worlds import World

KEPT = 1_000_000  # points, the newest
MINIBATCH = 4_096
UPDATES = 60  # per batch of episodes


VERSIONS = 20  # of the actor that are kept in a whole training, at equal distances


class Opponents(ABC):
    """Whoever plays for agents that are not the learner's in a game, asked for every step of a batch in order."""

    def begin(self, progress: float) -> None:  # noqa: B027 - most stay who they are
        """A batch of games is about to start; `progress`: the share of the training that is done."""

    @abstractmethod
    def act(self, seen: Tensor, observations: Sequence[Float32], state: Any) -> Any:
        """Everybody's actions, [n_agents, batch], or what a `Head` draws. `seen`: the joint observations."""

    def memory(self) -> dict[str, Tensor]:
        """Returns the tensors that a resumed training needs: none, where the opponents stay as they are."""
        return {}

    def remember(self, memory: Mapping[str, Tensor]) -> None:  # noqa: B027 - as `memory`
        """Takes over what `memory` gave."""


class Past(Opponents):
    """The actor as it was at equal distances of the training so far, one of them for each batch, sampled from as the
    present one is.
    """

    def __init__(self, joint: Joint, actor: Nets, head: Head) -> None:
        self.joint, self.actor, self.head = joint, actor, head
        self.versions: list[list[Tensor]] = []  # of all parameters
        self.drawn = 0

    def begin(self, progress: float) -> None:
        """Keeps the present actor when one is due, and draws the version that plays; see `Opponents.begin`."""
        if progress * VERSIONS >= len(self.versions):
            self.versions.append([parameter.detach().clone() for parameter in self.actor.parameters])
        self.drawn = int(self.head.rng.integers(len(self.versions)))

    def act(self, seen: Tensor, observations: Sequence[Float32], state: Any) -> Any:
        """Draws the actions of the drawn version; see `Opponents.act`."""
        with torch.no_grad():
            outputs = self.actor.apply_weights(self.versions[self.drawn], self.joint.views(seen))
        return self.head.draw(outputs, seen)

    def memory(self) -> dict[str, Tensor]:
        """Returns the versions that are kept; see `Opponents.memory`."""
        return {str(k): torch.stack(every) for k, every in enumerate(zip(*self.versions, strict=True))}

    def remember(self, memory: Mapping[str, Tensor]) -> None:
        """Takes over the versions that `memory` gave; see `Opponents.remember`."""
        stacked = [memory[str(k)].to(self.joint.device) for k in range(len(memory))]
        self.versions = [list(parameters) for parameters in zip(*stacked, strict=True)]


class Finished(Opponents):
    """Finished experts, one of them for each batch."""

    def __init__(self, world: World, experts: Sequence[Controller], rng: np.random.Generator) -> None:
        self.experts, self.agents, self.rng = experts, range(len(world.agents)), rng
        self.drawn = experts[0]

    def begin(self, progress: float) -> None:
        """Draws the expert that plays the batch; see `Opponents.begin`."""
        self.drawn = self.experts[int(self.rng.integers(len(self.experts)))]

    def act(self, seen: Tensor, observations: Sequence[Float32], state: Any) -> Any:
        """Returns the drawn expert's greedy actions; see `Opponents.act`."""
        return self.drawn.act(self.agents, observations, state).T


class Script(Opponents):
    """The world's script."""

    def __init__(self, world: World) -> None:
        self.script, self.agents = build_script(world), range(len(world.agents))

    def act(self, seen: Tensor, observations: Sequence[Float32], state: Any) -> Any:
        """Returns the script's actions; see `Opponents.act`."""
        return self.script.act(self.agents, observations, state).T


def by_reward_alone(world: World, names: Sequence[str]) -> dict[str, Any]:
    """The named experts, shipped ones or files, each for all agents of `world`.

    InputError for an expert of another game, and for one that learned from a script, or does not say how it learned.
    """
    experts: dict[str, Any] = {}
    for name in names:
        expert, played = network.load(name)
        same = ("agents", "landmarks", "episode_steps")
        if any(getattr(played.spec, each) != getattr(world.spec, each) for each in same) or played.teams != world.teams:
            raise InputError("the expert plays another game", f"--against {name}: {played.name}, not {world.name}")
        learned = cards.count_steps(expert.card)
        if not learned or learned[cards.IMITATION] or expert.card["settings"].get("scripted"):
            advice = "choose an expert that learned by reward alone"
            raise InputError("the expert learned from a script, or does not say how", f"--against {name}", advice)
        experts[name] = expert if played.name == world.name else Observing(expert, played)
    return experts


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


@dataclass(frozen=True)
class Settings:
    """Training settings of MAPPO."""

    steps: int = 4_000_000  # joint environment steps, those of imitation included
    imitate_steps: int = 0  # first imitate the world's scripted expert for so many steps ...
    value_steps: int = 128_000  # ... and then learn values alone for so many, before the actors move again
    imitate_rate: float = 3e-3
    games: int = 1_024  # played in parallel, a whole episode between updates
    epochs: int = 4
    minibatch: int = 6_400  # transitions
    hidden: int = 64
    scaled: int = 0  # 1: the first layer scales observations, by mean and deviation in random play
    shared: int = 0  # 1: team-mates have one network, so that what tells them apart is what they see
    learning_rate: float = 1e-3  # falls linearly to a tenth
    gamma: float = 0.95
    trace: float = 0.95  # lambda of the generalised advantage
    clip: float = 0.2
    entropy: float = 0.01  # bonus, falls linearly to zero
    shaping: float = 1.0  # weight of the world's shaping term
    critic_shaping: float = 1.0  # share of it in the reward that the critic is fitted to; 0: the environment's alone
    past: float = 0.0  # share of games in which each team meets opponents as they were earlier in this training
    scripted: float = 0.0  # share of games in which each team meets the world's scripted opponents
    against: float = 0.25  # share of games in which each team meets experts, where some are named
    gradient_norm: float = 0.5
    checkpoint_steps: int = 102_400
    seed: int = 0


class Played(NamedTuple):
    """A batch of whole episodes."""

    seen: Tensor  # joint observations [steps + 1, games, n_obs + 1]
    acted: Any  # [steps, games, n_agents], as the rest; of numbers [steps, games, n_agents, n_outputs], as drawn
    rewards: Any
    acting: Any  # who acted
    playing: Any  # ... or waited for its turn
    goes_on: Any  # ... and whose episode did not end by itself with that step


class Meeting(NamedTuple):
    """Opponents, and what they play."""

    opponents: Opponents
    theirs: Any  # [n_agents, games]


class Mappo(Trainer):
    """Actors, values, earlier actors to play against and, at first, what is imitated."""

    networks = ACTOR

    def __init__(self, world: World, settings: Settings, device: str) -> None:
        super().__init__(world, settings, device)
        joint, hidden = self.joint, settings.hidden
        sizes = (joint.widest, hidden, hidden, joint.n_actions)
        fans = self._fans()
        self.actor = Nets(sizes, fans, self.generator, device, last=0.01)
        self.values = Nets((joint.n_obs, hidden, hidden, 1), [joint.n_obs] * len(fans), self.generator, device)
        if settings.shared:
            self.actor.owner = self.values.owner = joint.teams.to(device)
        self.head = head_of(world, joint, self.actor, self.rng)
        self.nets = {"actor": self.actor, "values": self.values, **self.head.nets}
        for name, nets in (("actor", (self.actor, *self.head.nets.values())), ("values", (self.values,))):
            self.optimisers[name] = Adam(nets, settings.learning_rate, settings.gradient_norm)
        if settings.imitate_steps:
            self.imitation = Imitation(world, joint, self.actor, build_script(world), self.generator)
            self.optimisers["imitation"] = Adam((self.actor,), settings.imitate_rate, norm=5.0)
        self.meetings: list[Meeting] = []
        self.mine = np.ones((joint.n_agents, self.most_games), dtype=bool)  # who is played by the network where
        self.most_met = 0  # games of each team
        if settings.scripted:
            self._meet(Script(world), settings.scripted)
        if settings.past:
            self._meet(Past(joint, self.actor, self.head), settings.past)

    def _fans(self) -> list[int]:
        """The inputs of each network: one for each agent, or for each team that shares one."""
        joint = self.joint
        if not self.settings.shared:
            return joint.widths
        if not joint.alike:
            raise InputError(
                "team-mates that observe differently cannot share a network", "--set shared", "leave it out"
            )
        return [joint.widths[self.world.members(team)[0]] for team in self.world.teams]

    def _arrange_joint(self, joint: Tensor) -> Tensor:
        """Returns the input of the value networks, [n_agents, batch, n_obs]; alike for all who share a network."""
        return self.joint.own_first(joint) if self.settings.shared else self.joint.share_observations(joint)

    def meet(self, experts: Sequence[Controller]) -> None:
        """Plays some games against these experts; see `Trainer.meet`."""
        self._meet(Finished(self.world, experts, self.rng), self.settings.against)

    def _meet(self, opponents: Opponents, share: float) -> None:
        """Gives the opponents a share of games for each team: whoever is not of that team is theirs there."""
        theirs, count = np.zeros_like(self.mine), int(self.most_games * share)
        for team in self.world.teams:
            others = [agent for agent in range(self.joint.n_agents) if agent not in self.world.members(team)]
            theirs[others, self.most_met : self.most_met + count] = True
            self.most_met += count
        if self.most_met > self.most_games:
            which = "--set scripted, past, against"
            raise InputError("teams meet opponents in more games than there are", which, "give smaller shares")
        self.mine &= ~theirs
        self.meetings.append(Meeting(opponents, theirs))

    @property
    def teaches(self) -> str:
        """The stage of the next `advance`: imitation, values or reward; see `Trainer.teaches`."""
        first = self.settings.imitate_steps
        if self.steps < first:
            return IMITATION
        return VALUES if first and self.steps < first + self.settings.value_steps else REWARD

    @property
    def until(self) -> int:
        """The step at which the present stage ends; see `Trainer.until`."""
        settings = self.settings
        ends = {IMITATION: settings.imitate_steps, VALUES: settings.imitate_steps + settings.value_steps}
        return min(settings.steps, ends.get(self.teaches, settings.steps))

    def advance(self) -> dict[str, float]:
        """One batch of episodes and the update from it; returns what to log."""
        settings = self.settings
        if self.teaches == IMITATION:
            rate = settings.imitate_rate * (1 - 0.9 * self.steps / settings.imitate_steps)
            played, fidelity, loss = self.imitation.round(self.games, self.rng, self.optimisers["imitation"], rate)
            self.steps += played
            return {"fidelity": fidelity, "loss": loss}
        played = self._collect()
        self.running.add(played.rewards, played.playing, played.goes_on)
        loss = self._learn(played)
        self.steps += int(played.playing.any(axis=2).sum())
        return {"reward": float(played.rewards.sum() / played.playing.sum()), "loss": loss}

    def _collect(self) -> Played:
        world = self.world
        for meeting in self.meetings:
            meeting.opponents.begin(self.progress)
        state = world.start(self.games, self.rng)
        seen, acted, rewards, goes_on = [], [], [], []
        acting, playing = [], [world.playing(state)]
        for _ in range(world.spec.episode_steps):
            observations = world.observe(state)
            seen.append(self.joint.tensor(observations))
            with torch.no_grad():
                drawn = self.head.draw(self.actor(self.joint.views(seen[-1])), seen[-1])
            for opponents, theirs in self.meetings:
                others, where = opponents.act(seen[-1], observations, state), theirs[:, : len(state)]
                drawn = np.where(where.reshape(*where.shape, *[1] * (drawn.ndim - 2)), others, drawn)
            acting.append(world.alive(state))
            state = world.step(state, self.head.hand_over(drawn))
            acted.append(drawn.swapaxes(0, 1))
            rewards.append(self.rewards(state))
            goes_on.append(playing[-1] & ~world.terminated(state))
            playing.append(world.playing(state))
            if not playing[-1].any():
                break
        seen.append(self.joint.tensor(world.observe(state)))
        return Played(torch.stack(seen), *map(np.stack, (acted, rewards, acting, playing[: len(acted)], goes_on)))

    def _by_agent(self, numbers: Any) -> Tensor:
        """[steps, games, n_agents] -> [n_agents, steps, games]."""
        return torch.from_numpy(numbers).float().to(self.joint.device).permute(2, 0, 1)

    def _learn(self, played: Played) -> float:
        settings, joint = self.settings, self.joint
        mean, deviation = self.running.scale()
        # returns, not rewards, should be of order one
        rewards = self._by_agent((played.rewards - mean) / deviation * (1 - settings.gamma))
        acted, playing = torch.from_numpy(played.acted).to(joint.device), self._by_agent(played.playing)
        steps, n_games = acted.shape[:2]
        flat = played.seen.flatten(0, 1)
        with torch.no_grad():
            values = self.values(self._arrange_joint(flat))[..., 0].unflatten(1, (steps + 1, n_games))
            before = self._log_probabilities(played.seen[:steps].flatten(0, 1), acted.flatten(0, 1))[0]
        advantages = self._advantages(rewards, values, playing, self._by_agent(played.goes_on))
        targets = (advantages + values[:, :steps]).flatten(1)
        advantages = advantages.flatten(1)
        acting, playing = self._by_agent(played.acting).flatten(1), playing.flatten(1)
        mine = torch.from_numpy(self.mine[:, :n_games]).to(joint.device).float().repeat(1, steps) * acting
        count = mine.sum(dim=1, keepdim=True).clamp(min=1)
        centre = (advantages * mine).sum(dim=1, keepdim=True) / count
        spread = ((advantages - centre).square() * mine).sum(dim=1, keepdim=True) / count
        advantages = (advantages - centre) / (spread.sqrt() + 1e-8) * mine
        rate = settings.learning_rate * (1 - 0.9 * self.progress)
        total = 0.0
        points, choices = flat[: steps * n_games], acted.flatten(0, 1)
        some = playing.any(dim=0).nonzero()[:, 0]  # points in which anybody plays
        for _ in range(settings.epochs):
            order = some[torch.randperm(len(some), generator=self.generator).to(joint.device)]
            for rows in order.split(settings.minibatch):
                predictions = self.values(self._arrange_joint(points[rows]))[..., 0]
                loss = average_rows((predictions - targets[:, rows]).square(), playing[:, rows]).sum()
                self.optimisers["values"].descend(loss, rate)
                total += float(loss.detach())
                if self.teaches == REWARD:
                    gain = self._gain(points[rows], choices[rows], before[:, rows], advantages[:, rows], mine[:, rows])
                    gain = average_rows(gain, acting[:, rows]).sum()
                    self.optimisers["actor"].descend(-gain, rate)
        return total / (settings.epochs * len(order.split(settings.minibatch)))

    def _gain(self, seen: Tensor, acted: Tensor, before: Tensor, advantages: Tensor, mine: Tensor) -> Tensor:
        """The clipped objective with its entropy bonus, to be raised, [n_agents, batch]; 0 where it is not `mine`."""
        settings = self.settings
        now, entropy = self._log_probabilities(seen, acted)
        ratio = (now - before).exp()
        gain = torch.min(ratio * advantages, ratio.clamp(1 - settings.clip, 1 + settings.clip) * advantages)
        bonus = settings.entropy * (1 - self.progress) * entropy * mine
        return gain + bonus

    def _log_probabilities(self, seen: Tensor, acted: Tensor) -> tuple[Tensor, Tensor]:
        """Of the actions taken, and the entropy, each [n_agents, batch]."""
        return self.head.log_probabilities(self.actor(self.joint.views(seen)), seen, acted)

    def _advantages(self, rewards: Tensor, values: Tensor, playing: Tensor, goes_on: Tensor) -> Tensor:
        """Generalised advantages (Schulman et al. 2016). Nothing follows where an agent's episode ends by itself; every
        other end, that of all episodes too, is a cut. What an agent is paid while it waits for its turn counts for the
        action before. Where its episode had ended, its number means nothing.
        """
        settings = self.settings
        advantages = torch.empty_like(rewards)
        following = torch.zeros_like(rewards[:, 0])
        for step in reversed(range(rewards.shape[1])):
            surprise = rewards[:, step] + settings.gamma * goes_on[:, step] * values[:, step + 1] - values[:, step]
            following = surprise + settings.gamma * settings.trace * following
            advantages[:, step] = following
            following = following * playing[:, step]  # nothing for the step before, if that was the agent's last
        return advantages

    def tensors(self) -> dict[str, Float32]:
        """Returns the tensors of the actors; see `Trainer.tensors`."""
        return self.joint.export_actors(self.actor)

    def memory(self) -> dict[str, Tensor]:
        """Returns the data of the imitation, or of the opponents after it; see `Trainer.memory`."""
        if self.steps < self.settings.imitate_steps:
            return self.imitation.state()
        return {name: value for meeting in self.meetings for name, value in meeting.opponents.memory().items()}

    def remember(self, memory: Mapping[str, Tensor]) -> None:
        """Takes over what `memory` gave; see `Trainer.remember`."""
        if memory and self.steps < self.settings.imitate_steps:
            self.imitation.restore(memory)
        elif memory:
            for meeting in self.meetings:
                meeting.opponents.remember(memory)
