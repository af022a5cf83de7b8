"""Episodes: controllers of any kind, one for each agent, played in a batch of games.

Does: rolls out a whole batch of episodes and returns everything that happened as arrays; counts what is played.
Assumes: all agents that are still in play act at once.
Does not: score episodes (measures.py) or learn from them.
"""

import math
import threading
import time
from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, Protocol, cast

import numpy as np

from codegen import ir
from codegen.deciding import decide_taken
from codegen.ir import Bool, Float32, Float64
from maviper.worlds import World
from maviper.worlds.world import Int

TOGETHER = 1_000  # episodes of our games that are played at once, about
Policy = Callable[[Float32], Any]  # [batch, n_features] float32 -> [batch] action indices, or [batch, n_outputs]


class Controller(Protocol):
    """A player that decides for agents: an expert, a team of trees, a script."""

    def act(self, agents: Sequence[int], observations: Sequence[Float32], state: Any) -> Int:
        """The actions of some agents, [batch, len(agents)]; where agents give numbers, [batch, len(agents), n_outputs]
        float32.

        `observations`: every agent's, each [batch, n_features]; `state`: the world's state, which scripts may read.
        """
        ...


@dataclass
class Tally(threading.local):
    """The episodes that were played in this thread, and how long they took."""

    episodes: int = 0
    seconds: float = 0.0
    batches: int = 0
    squares: float = 0.0  # of the batches' episodes, added up
    products: float = 0.0  # of their episodes and seconds
    starting: float = 0.0  # seconds in which the next batch started
    on_played: Callable[[], None] = lambda: None  # told after each batch

    def add(self, episodes: int, seconds: float) -> None:
        """Counts a batch."""
        seconds, self.starting = seconds + self.starting, 0.0
        self.episodes, self.seconds = self.episodes + episodes, self.seconds + seconds
        self.squares, self.products = self.squares + episodes**2, self.products + episodes * seconds
        self.batches += 1
        self.on_played()

    def expect(self, world: World, *counts: int) -> float:
        """Seconds that so many further episodes of each kind will take, by those that were played."""
        pace = self.seconds / max(1, self.episodes)
        if world.games is not None:
            return pace * sum(counts)
        # our games are played many at once: a batch takes some time, and each of its episodes a little more
        spread, tilt = self.squares - self.episodes * (mean := self.episodes / max(1, self.batches)), 0.0
        if spread > 0:  # batches of several sizes
            tilt = min(max(0.0, (self.products - self.seconds * mean) / spread), pace)
        batches = sum(math.ceil(count / TOGETHER) for count in counts)
        return batches * (self.seconds - tilt * self.episodes) / max(1, self.batches) + tilt * sum(counts)


TALLY = Tally()


@contextmanager
def counting_played(told: Callable[[int], None]) -> Generator[None]:
    """`told` hears how many episodes were played inside so far."""
    begun = TALLY.episodes
    TALLY.on_played = lambda: told(TALLY.episodes - begun)
    try:
        yield
    finally:
        TALLY.on_played = lambda: None


STEPS_AT_ONCE = 64  # for which room is made ahead


@dataclass(frozen=True)
class Policies:
    """A controller of one function for each agent, from its own observations to its actions."""

    functions: Sequence[Policy]

    def act(self, agents: Sequence[int], observations: Sequence[Float32], state: Any) -> Int:
        """Returns the actions of some agents; see `Controller.act`."""
        return in_columns([self.functions[agent](observations[agent]) for agent in agents])


def in_columns(acted: Sequence[Any]) -> Any:
    """Stacks what agents do, each [batch] or [batch, n_outputs], into [batch, n_agents] or [batch, n_agents, widest],
    zeros standing for outputs that an agent has not.
    """
    if acted[0].ndim == 1:
        return np.stack(acted, axis=1)
    widest = max(each.shape[1] for each in acted)
    return np.stack([np.pad(each, ((0, 0), (0, widest - each.shape[1]))) for each in acted], axis=1)


def tree_policies(policies: Sequence[ir.AgentPolicy]) -> Policies:
    """Tree policies with their reference semantics."""
    return Policies([partial(decide_taken, policy) for policy in policies])


class Observed(Sequence[Float32]):
    """The observations of all agents in a state, made once somebody looks: a script does not."""

    def __init__(self, world: World, state: Any) -> None:
        self._world, self._state = world, state

    @cached_property
    def _each(self) -> tuple[Float32, ...]:
        return self._world.observe(self._state)

    def __len__(self) -> int:
        return len(self._world.agents)

    def __getitem__(self, place: Any) -> Any:
        return cast("Any", self._each)[place]


@dataclass(frozen=True)
class Episodes:
    """A batch of episodes; step t acts on `observations[t]` in `states[t]` and ends in `states[t + 1]`.

    There are as many steps as the longest episode has. Where an agent's own has ended before, `alive` is False: what
    stands for it there is no observation, and no action, of the game.
    """

    observations: tuple[Float32, ...]  # per agent [steps, batch, n_features]; () where they were not kept
    actions: Any  # [steps, batch, n_agents] int, or [steps, batch, n_agents, n_outputs] float32
    alive: Bool  # [steps, batch, n_agents] who acts
    states: Sequence[Any]  # steps + 1 batches, the starts first
    values: Float64  # [n_measures, batch], in the order of the world's measures
    returns: Float64  # [n_agents, batch] all rewards together
    cut: Bool  # [batch] stopped at a length that nobody stated


def choose_actions(controllers: Sequence[Controller], observations: Sequence[Float32], state: Any) -> Any:
    """Everybody's actions in states, [batch, n_agents], or numbers [batch, n_agents, n_outputs]; a controller of
    several agents is asked once for them all.
    """
    shared: dict[int, list[int]] = {}
    for agent, controller in enumerate(controllers):
        shared.setdefault(id(controller), []).append(agent)
    answers: list[Any] = [controllers[agents[0]].act(agents, observations, state) for agents in shared.values()]
    widest = max(given.shape[2] if given.ndim > 2 else 0 for given in answers)
    shape = len(state), len(controllers)
    acted = np.zeros((*shape, widest), np.float32) if widest else np.empty(shape, np.int64)
    for agents, given in zip(shared.values(), answers, strict=True):
        if widest:
            acted[:, agents, : given.shape[2]] = given
        else:
            acted[:, agents] = given
    return acted


def play(world: World, controllers: Sequence[Controller], start: Any, keep: bool = True) -> Episodes:
    """Plays one episode from each start state. `controllers`: one for each agent, in the world's order; `keep`: what
    agents observe, which is most of what episodes take.
    """
    states, began = [start], time.monotonic()
    observations = _Kept(world.spec.episode_steps if keep else 0)
    actions: list[Int] = []
    alive = [world.alive(start)]
    returns = np.zeros((len(controllers), len(start)))
    for _ in range(world.spec.episode_steps):
        seen = Observed(world, states[-1])
        acted = choose_actions(controllers, seen, states[-1])
        states.append(world.step(states[-1], acted))
        returns += world.rewards(states[-1]).T
        if keep:
            observations.add(seen)
        actions.append(acted)
        alive.append(world.alive(states[-1]))
        if not world.playing(states[-1]).any():
            break
    acting = np.stack(alive[: len(actions)])
    cut: Any = world.playing(states[-1]).any(axis=1) & (not world.length_stated)
    kept, values = observations.concatenate(), world.values(states[1:])
    TALLY.add(len(start), time.monotonic() - began)
    return Episodes(kept, np.stack(actions), acting, states, values, returns, cut)


class _Kept:
    """Each agent's observations, written step by step where they stay: lists of steps, joined, take twice the room."""

    def __init__(self, steps: int) -> None:
        self._steps, self._done = min(steps, STEPS_AT_ONCE), 0
        self._blocks: list[list[Float32]] = []  # of so many steps, per agent [steps, batch, n_features]

    def add(self, seen: Sequence[Float32]) -> None:
        """Adds what the agents observe in the next step."""
        step = self._done % self._steps
        if not step:
            self._blocks.append([np.empty((self._steps, *rows.shape), rows.dtype) for rows in seen])
        for kept, rows in zip(self._blocks[-1], seen, strict=True):
            kept[step] = rows
        self._done += 1

    def concatenate(self) -> tuple[Float32, ...]:
        """Per agent [steps, batch, n_features]; () where nothing was kept."""
        blocks = zip(*self._blocks, strict=True)
        return tuple((each[0] if len(each) == 1 else np.concatenate(each))[: self._done] for each in blocks)


def start_games(world: World, seeds: Sequence[int] | Int) -> Any:
    """The start states from `seeds`; what that takes, long in some environments, is part of their episodes' time."""
    began = time.monotonic()
    states = world.start_from_seeds(seeds)
    TALLY.starting += time.monotonic() - began
    return states


def rollout(
    world: World,
    controllers: Sequence[Controller],
    seeds: Sequence[int],
    keep: bool = True,
    over: Callable[[], bool] = lambda: False,
) -> list[Episodes]:
    """The episodes that start from `seeds`, in batches of as many games as the world plays at once; `keep` as in
    `play`. `over`: asked after each batch; True ends with those that were played.
    """
    at_once = world.games or max(1, len(seeds))
    played: list[Episodes] = []
    for low in range(0, len(seeds), at_once):
        played.append(play(world, controllers, start_games(world, seeds[low : low + at_once]), keep))
        if over():
            break
    return played


def points(episodes: Episodes) -> tuple[tuple[Float32, ...], Any]:
    """All observations of a batch of episodes, per agent [steps * batch, n_features], and the states they show, those
    in which an agent no longer acts among them.
    """
    observations = tuple(seen.reshape(-1, seen.shape[-1]) for seen in episodes.observations)
    kind = cast("Any", type(episodes.states[0]))
    return observations, kind.concatenate(episodes.states[:-1])
