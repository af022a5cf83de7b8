"""Experts with something changed around them: in a world that shows agents more or other things, or without a critic.

Does: passes an expert the features that it knows; gives every action the same worth.
Assumes: a world of the same states as the expert's.
Does not: change what the expert does.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from codegen.errors import InputError
from codegen.ir import Float32, Float64
from maviper.experts import cards
from maviper.experts.expert import AS_GIVEN, Expert
from maviper.experts.measured import Measured
from maviper.worlds import World
from maviper.worlds.world import Int, legal_in


@dataclass(frozen=True)
class Wrapped:
    """An expert as it is."""

    expert: Expert

    @property
    def critic(self) -> str:
        """Whose Q this is."""
        return critic_of(self.expert)

    @property
    def card(self) -> Mapping[str, Any]:
        """The expert's."""
        return self.expert.card

    @property
    def hash(self) -> str:
        """The expert's."""
        return self.expert.hash

    @property
    def agents(self) -> tuple[str, ...]:
        """The expert's."""
        return self.expert.agents

    @property
    def centralized(self) -> bool:
        """The expert's."""
        return self.expert.centralized

    def act(self, agents: Sequence[int], observations: Sequence[Float32], state: Any) -> Int:
        """Returns the wrapped expert's actions; see `Controller.act`."""
        return self.expert.act(agents, observations, state)

    def q(self, agent: int, observations: Sequence[Float32], state: Any, joint: Int, given: Int) -> Float64:
        """Returns the wrapped expert's Q; see `Expert.q`."""
        return self.expert.q(agent, observations, state, joint, given)


@dataclass(frozen=True)
class Narrowed(Wrapped):
    """An expert of `world` in a world of the same states that shows more, the first features being the expert's."""

    world: World

    def act(self, agents: Sequence[int], observations: Sequence[Float32], state: Any) -> Int:
        """Returns the expert's actions on narrowed observations; see `Controller.act`."""
        return super().act(agents, self._narrow_observations(observations), state)

    def q(self, agent: int, observations: Sequence[Float32], state: Any, joint: Int, given: Int) -> Float64:
        """Returns the expert's Q on narrowed observations; see `Expert.q`."""
        return super().q(agent, self._narrow_observations(observations), state, joint, given)

    def _narrow_observations(self, observations: Sequence[Float32]) -> list[Float32]:
        return [seen[:, : len(mine)] for seen, mine in zip(observations, self.world.features, strict=True)]


@dataclass(frozen=True)
class Observing(Wrapped):
    """An expert of `world` in a world of the same states that shows something else: it observes for itself."""

    world: World

    def act(self, agents: Sequence[int], observations: Sequence[Float32], state: Any) -> Int:
        """Returns the expert's actions on the world's own observations; `observations` are not looked at."""
        return super().act(agents, self.world.observe(state), state)

    def q(self, agent: int, observations: Sequence[Float32], state: Any, joint: Int, given: Int) -> Float64:
        """Returns the expert's Q on the world's own observations; see `Expert.q`."""
        return super().q(agent, self.world.observe(state), state, joint, given)


@dataclass(frozen=True)
class Unweighted(Wrapped):
    """An expert to whom all actions are worth the same, so that all states weigh the same: plain DAgger."""

    @property
    def critic(self) -> str:
        """Nobody's."""
        return "none"

    def q(self, agent: int, observations: Sequence[Float32], state: Any, joint: Int, given: Int) -> Float64:
        """Returns a Q of 0 for all; see `Expert.q`."""
        del agent, observations, state
        return np.zeros((len(given), len(joint)))


@dataclass(frozen=True)
class Lawful(Wrapped):
    """An expert in a world of masks: where its action is illegal, the legal one that its Q likes best."""

    world: World

    def act(self, agents: Sequence[int], observations: Sequence[Float32], state: Any) -> Int:
        """Returns legal actions; InputError where the expert acts illegally and its Q cannot be asked."""
        chosen, acting = np.array(super().act(agents, observations, state)), self.world.alive(state)
        for place, agent in enumerate(agents):
            mask = self.world.mask(agent)
            if mask is None:
                continue
            legal = legal_in(mask, observations[agent])
            wrong = np.flatnonzero(acting[:, agent] & ~legal[np.arange(len(legal)), chosen[:, place]])
            if len(wrong):
                worth = self._worth(agent, [seen[wrong] for seen in observations], state[wrong])
                chosen[wrong, place] = np.where(legal[wrong], worth, -np.inf).argmax(axis=1)
        return chosen

    def _worth(self, agent: int, observations: Sequence[Float32], state: Any) -> Float64:
        """Q of the agent's own actions, the others' being the expert's, [batch, n_actions]."""
        n_agents, n_actions = len(self.agents), len(self.world.actions[agent])
        joint = np.full((n_actions, n_agents), AS_GIVEN)
        joint[:, agent] = np.arange(n_actions)
        given = super().act(range(n_agents), observations, state)
        try:
            return self.expert.q(agent, observations, state, joint, given)
        except (NotImplementedError, InputError):
            what = f"the expert takes illegal actions for {self.agents[agent]}, and has no Q to choose another by"
            raise InputError(what, self.world.name, "let it read the mask, the last features it observes") from None


def lawful_expert(expert: Expert, world: World) -> Expert:
    """The expert, taking legal actions only where a world has masks."""
    inner = expert
    while isinstance(inner, Wrapped):
        if isinstance(inner, Lawful):
            return expert
        inner = inner.expert
    return Lawful(expert, world) if world.masked else expert


def critic_of(expert: Expert) -> str:
    """Whose Q an expert answers with: `learned` unless it says otherwise."""
    return str(getattr(expert, "critic", "learned"))


def reward_weighed_by(expert: Expert, world: World) -> str:
    """Returns the kind of reward that an expert's Q adds up; "" where nobody knows, or where there is no Q."""
    whose, card = critic_of(expert), expert.card
    while isinstance(expert, Wrapped):
        expert = expert.expert
    if isinstance(expert, Measured):
        return cards.reward_of({"shaping": expert.shaping}, world) if whose == expert.critic else ""
    return cards.critic_reward(card, world) if whose == "learned" else ""
