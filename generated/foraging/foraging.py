"""Level-based foraging with forced cooperation, from the package `lbforaging`, as a world of ours.

Does: an adapter to PettingZoo's parallel API, whose observations say where food and mates lie from the agent; a script
  that agrees on one food without talking, and a greedy forager that looks at itself alone.
Assumes: `pip install lbforaging`; every agent is of level 1 and every food of as many levels as there are agents, so
  that food is loaded by all of them at once or not at all.
Does not: change the game's rules. All agents are paid what any of them is, so a return is the share of food loaded.
"""

from collections.abc import Mapping, Sequence
from typing import Any, cast

import numpy as np
import numpy.typing as npt
from gymnasium.spaces import Box, Discrete
from pettingzoo import ParallelEnv

from maviper.profiles import FeatureSpec
from maviper.worlds import World, find

PARTS = ("down", "right", "away", "later")
STAY, NORTH, SOUTH, WEST, EAST, LOAD = range(6)
Floats = npt.NDArray[np.floating[Any]]
Ints = npt.NDArray[np.integer[Any]]


class Foraging(ParallelEnv):
    """Agents see, in cells, how far down, right and away each food is, how much farther than to the first food left all
    of them would walk to it, and where each mate is. Nobody stands on food, so 0 cells away says that it is gone.
    """

    metadata: dict[str, Any] = {"name": "foraging"}  # noqa: RUF012

    def __init__(self, size: int, agents: int, food: int, max_cycles: int) -> None:
        from lbforaging.foraging.environment import ForagingEnv

        self.env = ForagingEnv(
            players=agents,
            min_player_level=1,
            max_player_level=1,
            min_food_level=agents,
            max_food_level=agents,
            field_size=(size, size),
            max_num_food=food,
            sight=size,
            max_episode_steps=max_cycles,
            force_coop=True,
        )
        self.possible_agents = [f"forager_{k}" for k in range(agents)]
        self.teams = {"foragers": self.possible_agents}
        self.max_cycles, self.food, self.farthest = max_cycles, food, 2.0 * size * agents
        self.features = {agent: self._features(agent) for agent in self.possible_agents}
        self._places: list[tuple[int, int]] = []  # of food at the start

    def _features(self, agent: str) -> list[FeatureSpec]:
        del agent
        names = [f"food_{k}_{part}" for k in range(self.food) for part in PARTS]
        names += [f"mate_{k}_{axis}" for k in range(len(self.possible_agents) - 1) for axis in PARTS[:2]]
        return [FeatureSpec(name, "cells", -self.farthest, self.farthest, None) for name in names]

    def observation_space(self, agent: Any) -> Box:
        """Offsets in cells."""
        return Box(-self.farthest, self.farthest, (len(self.features[agent]),), np.float32)

    def action_space(self, agent: Any) -> Discrete:
        """Stay, north, south, west, east, load."""
        return Discrete(6)

    def reset(self, seed: int | None = None, options: Any = None) -> tuple[dict[str, Any], dict[str, Any]]:
        """A new field; everything follows from the seed."""
        self.env.reset(seed=seed)
        self.agents = list(self.possible_agents)
        self._places = [(int(row), int(column)) for row, column in zip(*np.nonzero(self.env.field), strict=True)]
        return self._seen(), {agent: {} for agent in self.agents}

    def step(self, actions: Mapping[str, int]) -> tuple[dict[str, Any], ...]:
        """One step of all agents; over when no food is left, cut after `max_cycles`."""
        chosen = [actions[agent] for agent in self.possible_agents]
        _, rewards, over, _, _ = self.env.step(chosen)
        acted, left = self.agents, bool(self.env.field.any())
        ended, cut = dict.fromkeys(acted, not left), dict.fromkeys(acted, bool(over and left))
        self.agents = [] if over or not left else acted
        paid = dict.fromkeys(acted, float(sum(rewards)))
        return self._seen(), paid, ended, cut, {agent: {} for agent in acted}

    def _seen(self) -> dict[str, Any]:
        places = [cast(tuple[int, int], player.position) for player in self.env.players]
        there = [bool(self.env.field[place]) for place in self._places]
        needed = [sum(abs(r - y) + abs(c - x) for y, x in places) for r, c in self._places]
        first = next((need for need, left in zip(needed, there, strict=True) if left), 0)
        seen = {}
        for k, (agent, (row, column)) in enumerate(zip(self.possible_agents, places, strict=True)):
            numbers: list[float] = []
            for (r, c), left, need in zip(self._places, there, needed, strict=True):
                down, right = r - row, c - column
                numbers += (down, right, abs(down) + abs(right), need - first) if left else (0, 0, 0, 0)
            numbers += [0] * (len(PARTS) * self.food - len(numbers))
            for other, (r, c) in enumerate(places):
                numbers += (r - row, c - column) if other != k else ()
            seen[agent] = np.array(numbers, dtype=np.float32)
        return seen


def make(size: int = 6, agents: int = 2, food: int = 2, max_cycles: int = 25) -> Foraging:
    """The game, as `maviper worlds check foraging:make` reads it."""
    return Foraging(size, agents, food, max_cycles)


class Forager:
    """Goes to one food, beside it loads. `together`: the food that all are nearest to in sum, else the agent's own."""

    centralized, hash = False, ""

    def __init__(self, world: World, together: bool) -> None:
        self.world, self.agents, self.together = world, world.agents, together
        self.card = {"algorithm": "scripted forager" if together else "greedy forager"}
        self.mates = len(world.agents) - 1

    def act(self, agents: Sequence[int], observations: Sequence[Floats], state: Any) -> Ints:
        """The actions of some agents, [batch, len(agents)]."""
        return np.stack([self._act(observations[agent].astype(np.int64)) for agent in agents], axis=1)

    def _act(self, seen: Ints) -> Ints:
        ends = seen.shape[1] - 2 * self.mates
        things, mates = seen[:, :ends].reshape(len(seen), -1, len(PARTS)), seen[:, ends:].reshape(len(seen), -1, 2)
        food, gone = things[:, :, :2], things[:, :, 2] == 0
        cost = np.where(gone, np.iinfo(np.int64).max, things[:, :, 3 if self.together else 2])
        offset = food[np.arange(len(food)), cost.argmin(axis=1)]  # of equals the first, for everybody
        chosen = np.full(len(seen), STAY)
        for row, (down, right) in enumerate(offset.tolist()):
            chosen[row] = self._step(
                down, right, {tuple(place) for place in (*mates[row].tolist(), *food[row].tolist())}
            )
        return chosen

    def _step(self, down: int, right: int, taken: set[tuple[int, int]]) -> int:
        """Towards the food along the longer way, along the shorter where that cell is taken, or around."""
        if abs(down) + abs(right) == 1:
            return LOAD
        longer, shorter = ((down, 0), (0, right)) if abs(down) >= abs(right) else ((0, right), (down, 0))
        aside = ((0, 1), (0, -1)) if longer[0] else ((1, 0), (-1, 0))
        for d, r in (longer, shorter, *aside):
            step = (int(np.sign(d)), int(np.sign(r)))
            if step != (0, 0) and step not in taken:
                return {(-1, 0): NORTH, (1, 0): SOUTH, (0, -1): WEST, (0, 1): EAST}[step]
        return STAY

    def q(self, agent: int, observations: Sequence[Floats], state: Any, joint: Ints, given: Ints) -> Floats:
        """A script has no critic."""
        raise NotImplementedError("extract with --critic none")


def agreed(**options: int) -> Forager:
    """An expert by hand: all go to one food."""
    return Forager(find(_text(options)), together=True)


def greedy(**options: int) -> Forager:
    """The baseline: each goes to the food that is nearest to itself."""
    return Forager(find(_text(options)), together=False)


def _text(options: Mapping[str, int]) -> str:
    return ",".join(["foraging:make", *(f"{key}={value}" for key, value in options.items())])
