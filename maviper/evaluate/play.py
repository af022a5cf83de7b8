"""Episodes: policies of any kind, one per agent, played in a batch of games.

Does: rolls out a whole batch of episodes and returns everything that happened as arrays.
Assumes: a policy is a function from observations to action indices; all agents act at once.
Does not: score episodes (metrics.py) or learn from them.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from codegen.ir import Float32, Float64
from maviper.worlds import ParticleWorld, WorldState
from maviper.worlds.particle import Int

Policy = Callable[[Float32], Int]  # [batch, n_features] float32 -> [batch] action indices


@dataclass(frozen=True)
class Episodes:
    """A batch of episodes of `steps` steps; step t acts on `observations[t]` and ends in `position[t]`."""

    observations: tuple[Float32, ...]  # per agent [steps, batch, n_features]
    actions: Int  # [steps, batch, n_agents]
    position: Float64  # [steps, batch, n_entities, 2] after each step
    goal: Int  # [batch]


def play(world: ParticleWorld, policies: Sequence[Policy], start: WorldState) -> Episodes:
    """Plays one episode from each start state with `policies` (one per agent, in the world's order)."""
    state = start
    observations: list[tuple[Float32, ...]] = []
    actions: list[Int] = []
    position: list[Float64] = []
    for _ in range(world.spec.episode_steps):
        seen = world.observe(state)
        chosen = np.stack([policy(obs) for policy, obs in zip(policies, seen, strict=True)], axis=1)
        state = world.step(state, chosen)
        observations.append(seen)
        actions.append(chosen)
        position.append(state.position)
    per_agent = tuple(np.stack([seen[agent] for seen in observations]) for agent in range(len(policies)))
    return Episodes(per_agent, np.stack(actions), np.stack(position), start.goal)
