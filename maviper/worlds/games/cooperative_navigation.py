"""Cooperative navigation: N agents cover N targets and do not bump into each other.

Does: mpe2's `simple_spread_v3` as a batched world; distance, collisions and success.
Assumes: full observability; mpe2's discrete actions, or its continuous ones; silent agents (their words are features
  that are always 0).
Does not: local observations.
"""

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np

from codegen.dynamics import MPE2
from codegen.ir import PHYSICS, EntitySpec, FeatureSpec, Float64, Meaning
from maviper.worlds.games.features import own, relative
from maviper.worlds.games.particle import (
    ACTIONS,
    EPISODE_STEPS,
    FORCE,
    SQUARED_RADII,
    SUCCESS,
    ParticleWorld,
    WorldState,
    covers_targets,
    distances,
    mpe2_spec,
    planes,
    squared_distances,
)
from maviper.worlds.world import CONTINUOUS, Measure, unusual

AGENTS = "agents"
WORDS = 2  # width of mpe2's communication channel
LOCAL_RATIO = 0.5  # mpe2's default: half the shared reward, half the agent's own


class CooperativeNavigation(ParticleWorld):
    """The game with `agents` agents and as many targets. `continuous` 1: agents give numbers in place of actions."""

    _newest: tuple[Any, Any] = (None, None)  # of the state that was asked for last, `gaps`

    def __init__(self, agents: int = 3, features: str = "", physics: str = MPE2, continuous: int = 0) -> None:
        names = tuple(f"agent_{index}" for index in range(agents))
        targets = [f"landmark_{index}" for index in range(agents)]
        self.spec = mpe2_spec(
            unusual(
                CooperativeNavigation,
                {"agents": agents, "features": features, PHYSICS: physics, CONTINUOUS: continuous},
            ),
            name="cooperative-navigation",
            reference="mpe2.simple_spread_v3",
            agents=(EntitySpec(name, size=0.15, force=FORCE, max_speed=None, collides=True) for name in names),
            landmarks=(EntitySpec(name, size=0.05, force=0.0, max_speed=None, collides=False) for name in targets),
        )
        self.teams = {AGENTS: names}
        self.actions = tuple(ACTIONS for _ in names)
        base = [self._features(name) for name in names]
        self.features, self.shown = self.extend_features(base, features), tuple(len(each) for each in base)
        lower = (Measure(AGENTS, name, lower_is_better=True) for name in ("D + collisions", "D", "collisions"))
        self.measures = (*lower, *(Measure(AGENTS, name, share=True) for name in SUCCESS))
        self.spec = self.choose_acting(continuous, self.choose_physics(physics, self.spec))

    def _features(self, agent: str) -> tuple[FeatureSpec, ...]:
        others = [name for name in self.agents if name != agent]
        mine = own(agent, self.spec)
        seen = [entity.name for entity in self.spec.landmarks] + others
        apart = [feature for other in seen for feature in relative(other, agent, self.spec)]
        words = [FeatureSpec(f"{name}_word{k}", "none", 0.0, 0.0, Meaning(())) for name in others for k in range(WORDS)]
        return (*mine["velocity"], *mine["position"], *apart, *words)

    def rewards(self, state: WorldState) -> Float64:
        """Half of minus the sum of distances of targets to their nearest agents, half of minus own collisions."""
        return self._paid(state, self._collisions(state)).T

    def reward(self, state: WorldState, agent: int) -> Float64:
        """One agent's reward: its own collisions are counted alone."""
        position, sizes = planes(state.position), self._sizes
        others = [other for other in range(len(sizes)) if other != agent]
        hit = distances(position[others], position[agent]) < (sizes[others] + sizes[agent])[:, None]
        return self._paid(state, hit.sum(axis=0))

    def _paid(self, state: WorldState, collisions: Any) -> Float64:
        return -self._distance(state) * (1 - LOCAL_RATIO) + -collisions * LOCAL_RATIO

    def shaping(self, state: WorldState) -> Float64:
        """Returns the worth of an agent's presence: the sum over targets of how much farther the nearest agent would be
        without it. A shared reward alone does not tell an agent its own part.
        """
        gaps = np.sqrt(self.gaps(state))
        if len(gaps) == 1:
            return np.zeros((len(state), 1))
        nearest, second = np.partition(gaps, 1, axis=0)[:2]
        return ((gaps == nearest) * (second - nearest)).sum(axis=1).T

    def gaps(self, state: WorldState) -> Float64:
        """Squared distances between agents and landmarks, [n_agents, n_landmarks, batch]."""
        known, gaps = self._newest
        if known is not state:
            n_agents = len(self.agents)
            position = planes(state.position)
            gaps = np.empty((n_agents, n_agents, len(state)))
            for gap, place in zip(gaps, position, strict=False):  # one after the other stays in a cache
                gap[...] = squared_distances(place, position[n_agents:])
            self._newest = state, gaps
        return gaps

    @cached_property
    def _sizes(self) -> Float64:
        return np.array([agent.size for agent in self.spec.agents])

    def _distance(self, state: WorldState) -> Float64:
        """The sum over targets of the nearest agent's distance, [batch]."""
        nearest = np.sqrt(self.gaps(state).min(axis=0))
        total = nearest[0].copy()
        for row in nearest[1:]:  # one after the other, as mpe2 adds them
            total += row
        return total

    def _collisions(self, state: WorldState) -> Float64:
        """With how many others each agent collides, [n_agents, batch]."""
        position = planes(state.position)
        collisions = np.zeros((len(self.agents), len(state)))
        for a, size in enumerate(self._sizes[:-1]):
            others = slice(a + 1, len(collisions))
            hit = distances(position[a], position[others]) < (size + self._sizes[others])[:, None]
            collisions[a] += hit.sum(axis=0)
            collisions[others] += hit
        return collisions

    def values(self, states: Sequence[WorldState]) -> Float64:
        """D: mean over steps of the sum of distances to the nearest agents. Collisions: mean over steps and agents.
        Success: at some one step every target has an agent of its own within the radius, and nobody ever collides.
        """
        distance = list[Float64]()
        covered = np.zeros((len(SQUARED_RADII), len(states[0])), dtype=bool)
        for state in states:
            distance.append(self._distance(state))
            for done, squared in zip(covered, SQUARED_RADII, strict=True):
                done |= covers_targets(self.gaps(state) < squared)
        collisions = np.stack([self._collisions(state).mean(axis=0) for state in states])
        apart, hit = np.stack(distance).mean(axis=0), collisions.mean(axis=0)
        unhurt = ~collisions.any(axis=0)
        return np.stack([apart + hit, apart, hit, *(covered & unhurt).astype(np.float64)])

    def reference_env(self) -> Any:
        """mpe2's parallel environment."""
        self.ensure_reference()
        from mpe2 import simple_spread_v3  # pyright: ignore[reportMissingTypeStubs]

        return simple_spread_v3.parallel_env(
            N=len(self.agents), max_cycles=EPISODE_STEPS, continuous_actions=self.continuous
        )
