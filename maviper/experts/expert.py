"""What extraction asks of an expert, however it came about; and critics without a network.

Does: states the protocol that networks, scripts, adapters and measured critics share; gives any controller a critic by
  branching the simulator: step once with the joint action that is asked for, follow the controller for a while, add up
  the discounted rewards.
Assumes: the critic is asked for joint actions in states that some controller met; to measure, a world whose states can
  be stepped more than once (ours, or a single-agent environment that can be copied).
Does not: know any kind of expert; say what happens beyond its horizon.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Protocol

import numpy as np

from codegen.ir import Float32, Float64
from maviper.episodes.play import Controller, Observed
from maviper.worlds import World
from maviper.worlds.world import Int

AS_GIVEN = -1  # in a column of `joint`: take each state's own action


class Expert(Controller, Protocol):
    """Decides for all agents (`act`, greedily) and says what joint actions are worth (`q`)."""

    @property
    def agents(self) -> tuple[str, ...]:
        """Names, in the world's order."""
        ...

    @property
    def card(self) -> Mapping[str, Any]:
        """The record of what made the expert and how good it is; {} when nobody knows."""
        ...

    @property
    def hash(self) -> str:
        """Of its content; "" when there is none."""
        ...

    @property
    def centralized(self) -> bool:
        """True if Q depends on all agents' observations and actions, not on the agent's own only."""
        ...

    def q(self, agent: int, observations: Sequence[Float32], state: Any, joint: Int, given: Int) -> Float64:
        """Q of one agent for chosen joint actions, [batch, n_joint].

        `observations`: every agent's, each [batch, n_features]; `state`: the world's state. `joint`:
        [n_joint, n_agents] action indices asked for in every state; where it says AS_GIVEN, the agent's action is that
        of `given` [batch, n_agents]. An agent whose episode has ended is never asked about; for the others, its
        observation is its last one, and its action means nothing.
        """
        ...


def labels(expert: Expert, observations: Sequence[Float32], state: Any) -> Int:
    """The expert's joint action in each state, [n, n_agents]."""
    return expert.act(range(len(observations)), observations, state)


MEASURED = "measured"  # whose Q it is
GAMMA = 0.95
HORIZON = 12  # steps; what lies beyond it weighs at most 0.95^12 = 0.54 of what lies within
CROWDED = 24  # steps times the root of the number of agents, at most: see `Measured.steps`
FAR, FAR_GAMMA = 50, 0.99  # of single-agent environments, whose episodes are long
BRANCHES_AT_ONCE = 16_384  # bounds the memory
PAIRS_AT_ONCE = 550_000  # of agents in all branches: what is computed of them stays in a processor's cache
COPIES_AT_ONCE = 512  # ... where each branch is a copy of an environment


@dataclass(frozen=True)
class Measured:
    """A controller with measured Q, an expert. `shaping`: weight of the world's shaping term in what is added up;
    `horizon`: steps that are added up, 0: as many as suit the number of agents.
    """

    world: World
    controller: Controller
    shaping: float = 0.0
    horizon: int = 0
    gamma: float = GAMMA
    critic: ClassVar = MEASURED
    centralized: bool = field(default=True, init=False, repr=False)  # Q depends on everybody's actions

    def __post_init__(self) -> None:
        self.world.branch()

    @staticmethod
    def for_world(world: World, controller: Controller) -> "Measured":
        """With the horizon of the world's kind."""
        return Measured(world, controller) if world.games is None else Measured(world, controller, 0.0, FAR, FAR_GAMMA)

    @property
    def card(self) -> Mapping[str, Any]:
        """The controller's."""
        return getattr(self.controller, "card", {})

    @property
    def hash(self) -> str:
        """The controller's."""
        return getattr(self.controller, "hash", "")

    @property
    def agents(self) -> tuple[str, ...]:
        """The world's agents."""
        return self.world.agents

    @property
    def steps(self) -> int:
        """How many steps are added up, with more than four agents fewer: in one arena the nearest of n is nearer by the
        root of n, and once an action has moved another agent, returns differ by who bumped into whom.
        """
        far = min(HORIZON, int(CROWDED / len(self.agents) ** 0.5))
        return min(self.horizon or far, self.world.spec.episode_steps)

    def act(self, agents: Sequence[int], observations: Sequence[Float32], state: Any) -> Int:
        """Returns the controller's actions; see `Controller.act`."""
        return self.controller.act(agents, observations, state)

    def q(self, agent: int, observations: Sequence[Float32], state: Any, joint: Int, given: Int) -> Float64:
        """Returns the measured Q of the agent; see `Expert.q`."""
        n_joint = len(joint)
        q_values = np.empty((len(state), n_joint))
        branches = BRANCHES_AT_ONCE if self.world.games is None else COPIES_AT_ONCE
        at_once = max(1, min(branches, PAIRS_AT_ONCE // len(self.agents) ** 2) // n_joint)
        for low in range(0, len(state), at_once):
            rows = np.arange(low, min(low + at_once, len(state)))
            asked = np.where(joint[None] == AS_GIVEN, given[rows, None], joint[None]).reshape(-1, len(self.agents))
            q_values[rows] = self._returns(agent, state[np.repeat(rows, n_joint)], asked, n_joint).reshape(-1, n_joint)
        return q_values

    def _returns(self, agent: int, state: Any, first: Int, n_joint: int) -> Float64:
        """An agent's discounted rewards of following the controller after a first joint action, [batch]. `n_joint`: so
        many states, side by side, are the same.
        """
        everybody = range(len(self.agents))
        total, actions = np.zeros(len(state)), first
        state = self.world.branch_states(state)
        for step in range(self.steps):
            if step and not (step == self.steps - 1 and self.world.rewards_lag):
                actions = self.controller.act(everybody, Observed(self.world, state), state)
            state = self.world.step(state, actions)
            alike = 1 if step or not self.world.rewards_lag else n_joint
            paid = state[::alike] if alike > 1 else state
            rewards = self.world.reward(paid, agent)
            if self.shaping:
                rewards = rewards + self.shaping * self.world.shaping(paid)[:, agent]
            total += self.gamma**step * np.repeat(rewards, alike)
        return total
