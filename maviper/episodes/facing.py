"""A game as the opponents of one team see it: that team's policies are frozen and belong to the world.

Does: a world of the remaining agents, so that a trainer of ours learns an answer; seats that answer in the whole game.
Assumes: policies that follow from observations and state alone; at least one team besides the frozen one.
Does not: learn.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from codegen.ir import Bool, Float32, Float64
from maviper.episodes.play import Controller
from maviper.worlds import World
from maviper.worlds.world import Int


class Facing(World):
    """`world` without `team`, all of whose agents `policies` (one controller for each agent of the world) decide for.

    `mark` tells the frozen policies from others in the world's name, such as a hash of their content.
    """

    def __init__(self, world: World, team: str, policies: Sequence[Controller], mark: str) -> None:
        self.whole, self.policies, self.main, self.games = world, policies, world.main, world.games
        self.frozen = world.members(team)
        self.mine = [agent for agent in range(len(world.agents)) if agent not in self.frozen]
        self.teams = {name: members for name, members in world.teams.items() if name != team}
        self.features = tuple(world.features[agent] for agent in self.mine)
        self.actions = tuple(world.actions[agent] for agent in self.mine)
        self._rows = [row for row, measure in enumerate(world.measures) if measure.team != team]
        self.measures = tuple(world.measures[row] for row in self._rows)
        options = {**world.spec.options, "against": f"{team}-{mark}"}
        self.spec = replace(world.spec, agents=tuple(world.spec.agents[k] for k in self.mine), options=options)

    def seat_controllers(self, answer: Controller) -> list[Controller]:
        """Controllers of the whole game, one for each agent: the frozen policies, and `answer` among this world's."""
        seat = _Seat(answer, tuple(self.mine))
        return [seat if agent in self.mine else policy for agent, policy in enumerate(self.policies)]

    def start(self, n: int, rng: np.random.Generator) -> Any:
        """Returns random start states; see `World.start`."""
        return self.whole.start(n, rng)

    def start_from_seeds(self, seeds: Sequence[int] | Int) -> Any:
        """Returns one start state for each seed; see `World.start_from_seeds`."""
        return self.whole.start_from_seeds(seeds)

    def step(self, state: Any, actions: Int) -> Any:
        """Returns the next states, the frozen team acting by its policies; see `World.step`."""
        joint = np.empty((len(state), len(self.whole.agents)), dtype=np.int64)
        joint[:, self.mine] = actions
        observations = self.whole.observe(state)
        for agent in self.frozen:
            joint[:, agent] = self.policies[agent].act([agent], observations, state)[:, 0]
        return self.whole.step(state, joint)

    def observe(self, state: Any) -> tuple[Float32, ...]:
        """Returns the observation of each of these agents; see `World.observe`."""
        seen = self.whole.observe(state)
        return tuple(seen[agent] for agent in self.mine)

    def rewards(self, state: Any) -> Float64:
        """Returns the rewards of these agents; see `World.rewards`."""
        return self.whole.rewards(state)[:, self.mine]

    def alive(self, state: Any) -> Bool:
        """Returns True for those of these agents that act in `state`; see `World.alive`."""
        return self.whole.alive(state)[:, self.mine]

    def playing(self, state: Any) -> Bool:
        """Returns True for agents that play: an episode goes on while one of them does; see `World.playing`."""
        return self.whole.playing(state)[:, self.mine]

    def terminated(self, state: Any) -> Bool:
        """Returns True for agents whose episode has ended by itself; see `World.terminated`."""
        return self.whole.terminated(state)[:, self.mine]

    def shaping(self, state: Any) -> Float64:
        """Returns the training aid of these agents; see `World.shaping`."""
        return self.whole.shaping(state)[:, self.mine]

    @property
    def shaped(self) -> bool:
        """True if the world has a training aid; see `World.shaped`."""
        return self.whole.shaped

    def values(self, states: Sequence[Any]) -> Float64:
        """Returns the measures of whole episodes; see `World.values`."""
        return self.whole.values(states)[self._rows]

    def reference_env(self) -> Any:
        """The whole game's reference environment, in which the frozen team must be played too."""
        return self.whole.reference_env()


@dataclass(frozen=True)
class _Seat:
    """A controller of some agents, asked in the whole game's terms."""

    answer: Controller
    agents: tuple[int, ...]

    def act(self, agents: Sequence[int], observations: Sequence[Float32], state: Any) -> Int:
        """Returns the actions of some agents; see `Controller.act`."""
        own = [observations[agent] for agent in self.agents]
        return self.answer.act([self.agents.index(agent) for agent in agents], own, state)
