"""Experts of cooperative navigation with fixed roles, from experts that share out landmarks by the state."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from codegen.ir import Float32
from maviper.experts.finding import Wrapped
from maviper.worlds import World


@dataclass(frozen=True)
class Settled(Wrapped):
    """An expert that decides as if every mate were on the landmark of its role. So each agent heads for its own,
    wherever mates are, which a tree of few leaves can learn. Q is as the expert's, of the states as they are.
    """

    world: World
    roles: Sequence[int] = ()  # the landmark of each agent; (): that of its own number

    def act(self, agents: Sequence[int], observations: Sequence[Float32], state: Any) -> Any:
        """As `Controller.act`."""
        mine = [self._settle_mates(agent, seen) for agent, seen in zip(agents, observations, strict=True)]
        return super().act(agents, mine, state)

    def _settle_mates(self, agent: int, obs: Float32) -> Float32:
        names, settled = [feature.name for feature in self.world.features[agent]], obs.copy()
        for place, mate in enumerate(self.world.agents):
            role = self.roles[place] if self.roles else place
            for axis in ("dx", "dy") if place != agent else ():
                settled[:, names.index(f"{mate}_{axis}")] = obs[:, names.index(f"landmark_{role}_{axis}")]
        return settled
