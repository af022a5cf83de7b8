"""Physical deception: N defenders cover N targets, one of which is the goal; an adversary looks for the goal.

Does: mpe2's `simple_adversary_v3` as a batched world, bit for bit; the success measure of the paper.
Assumes: full observability, discrete actions.
Does not: collisions (the game has none).
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from codegen.ir import Bool, EntitySpec, FeatureSpec, Float64
from maviper.worlds.features import relative
from maviper.worlds.particle import (
    ACTIONS,
    EPISODE_STEPS,
    FORCE,
    SQUARED_RADII,
    SUCCESS,
    ParticleWorld,
    WorldState,
    covered,
    distances,
    mpe2_spec,
    planes,
    squared_distances,
)
from maviper.worlds.world import Measure, unusual

ADVERSARIES = "adversaries"
DEFENDERS = "defenders"


class PhysicalDeception(ParticleWorld):
    """The game with `defenders` defenders and as many targets.

    `velocity` 1 adds each agent's own velocity to what it observes; mpe2's game has 0.
    """

    def __init__(self, defenders: int = 2, velocity: int = 0, features: str = "") -> None:
        agents = ("adversary_0", *(f"agent_{index}" for index in range(defenders)))
        landmarks = tuple(f"landmark_{index}" for index in range(defenders))
        self.spec = mpe2_spec(
            unusual(PhysicalDeception, {"defenders": defenders, "velocity": velocity, "features": features}),
            name="physical-deception",
            reference="mpe2.simple_adversary_v3",
            agents=(EntitySpec(name, size=0.15, force=FORCE, max_speed=None, collides=False) for name in agents),
            landmarks=(EntitySpec(name, size=0.08, force=0.0, max_speed=None, collides=False) for name in landmarks),
            has_goal=True,
        )
        self.teams = {ADVERSARIES: agents[:1], DEFENDERS: agents[1:]}
        self.actions = tuple(ACTIONS for _ in agents)
        base = [self._features(agent) for agent in agents]
        self.shown = tuple(len(each) for each in base)
        if velocity:
            base = self.extended(base, "velocity")
        self.features = self.extended(base, features)
        self.measures = tuple(Measure(team, name, share=True) for name in SUCCESS for team in self.teams)

    def _features(self, agent: str) -> tuple[FeatureSpec, ...]:
        seen = [entity.name for entity in self.spec.landmarks] + [name for name in self.agents if name != agent]
        if agent in self.teams[DEFENDERS]:
            seen = ["goal", *seen]
        return tuple(feature for other in seen for feature in relative(other, agent, self.spec))

    def rewards(self, state: WorldState) -> Float64:
        """Adversary: minus its distance to the goal. Defenders: that distance minus the nearest defender's."""
        n_agents = len(self.agents)
        distance = distances(planes(state.position)[:n_agents], self.goal_position(state).T)
        rewards = np.empty((n_agents, len(state)))
        rewards[1:] = -distance[1:].min(axis=0) + distance[0]
        rewards[0] = -distance[0]
        return rewards.T

    def shaping(self, state: WorldState) -> Float64:
        """For defenders the covering term: minus the sum over targets of the nearest defender's distance. For the
        adversary minus its distance to the nearest target: in doubt, standing between two would pay as well as going
        to one, and never succeed.
        """
        n_agents = len(self.agents)
        position = planes(state.position)
        distance = distances(position[:n_agents, None], position[None, n_agents:])
        terms = np.empty((n_agents, len(state)))
        terms[0] = -distance[0].min(axis=0)
        terms[1:] = -distance[1:].min(axis=0).sum(axis=0)
        return terms.T

    def values(self, states: Sequence[WorldState]) -> Float64:
        """Adversary: within the radius of the goal at some step. Defenders: at some one step every target has a
        defender of its own within the radius.
        """
        reached = np.stack([self._reached(state) for state in states])
        return reached.any(axis=0).reshape(-1, reached.shape[-1]).astype(np.float64)

    def _reached(self, state: WorldState) -> Bool:
        """[n_radii, n_teams, batch]: which team is where it wants to be in a state."""
        n_agents = len(self.agents)
        position = planes(state.position)
        adversary = squared_distances(position[0], self.goal_position(state).T)
        gap = squared_distances(position[1:n_agents, None], position[None, n_agents:])
        return np.stack([[adversary < squared, covered(gap < squared)] for squared in SQUARED_RADII])

    def reference_env(self) -> Any:
        """mpe2's parallel environment."""
        from mpe2 import simple_adversary_v3

        return simple_adversary_v3.parallel_env(N=len(self.teams[DEFENDERS]), max_cycles=EPISODE_STEPS)
