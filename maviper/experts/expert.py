"""What extraction asks of an expert, however it came about.

Does: states the protocol that networks, scripts, adapters and measured critics share.
Assumes: discrete actions; the critic is asked for joint actions in states that some controller met.
Does not: know any kind of expert.
"""

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from codegen.ir import Float32, Float64
from maviper.episodes.play import Controller
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
