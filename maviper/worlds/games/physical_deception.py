"""Physical deception: N defenders cover N targets, one of which is the goal; an adversary looks for the goal.

Does: mpe2's `simple_adversary_v3` as a batched world, bit for bit; the success measure of the paper.
Assumes: full observability; mpe2's discrete actions, or its continuous ones.
Does not: collisions (the game has none).
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from codegen.dynamics import MPE2
from codegen.errors import InputError
from codegen.ir import PHYSICS, EntitySpec, FeatureSpec, Float32, Float64
from codegen.observe import Observer
from maviper.worlds.games.features import relative
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
from maviper.worlds.world import CONTINUOUS, Int, Measure, unusual

ADVERSARIES = "adversaries"
DEFENDERS = "defenders"


class PhysicalDeception(ParticleWorld):
    """The game with `defenders` defenders and as many targets.

    `velocity` 1 adds each agent's own velocity to what it observes; mpe2's game has 0. `shuffled` 1 shows each agent
    the landmarks in an order of its own, drawn anew for each episode: no agent can know which landmark its team-mates
    call the first, so that roles must depend on the state. `continuous` 1: agents give numbers in place of actions.
    """

    def __init__(
        self,
        defenders: int = 2,
        velocity: int = 0,
        shuffled: int = 0,
        features: str = "",
        physics: str = MPE2,
        continuous: int = 0,
    ) -> None:
        agents = ("adversary_0", *(f"agent_{index}" for index in range(defenders)))
        landmarks = tuple(f"landmark_{index}" for index in range(defenders))
        given = {"defenders": defenders, "velocity": velocity, "shuffled": shuffled, "features": features}
        given |= {PHYSICS: physics, CONTINUOUS: continuous}
        self.spec = mpe2_spec(
            unusual(PhysicalDeception, given),
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
            base = self.extend_features(base, "velocity")
        if shuffled and features:
            raise InputError("further features would show the order", "physical-deception,shuffled=1", "leave one out")
        self._in_order = self.features = self.extend_features(base, features)
        if shuffled:
            self.shown = (0,) * len(agents)
            self.features = tuple(map(self._anonymous, self.features))
        self.measures = tuple(Measure(team, name, share=True) for name in SUCCESS for team in self.teams)
        self.spec = self.choose_acting(continuous, self.choose_physics(physics, self.spec))

    def _features(self, agent: str) -> tuple[FeatureSpec, ...]:
        seen = [entity.name for entity in self.spec.landmarks] + [name for name in self.agents if name != agent]
        if agent in self.teams[DEFENDERS]:
            seen = ["goal", *seen]
        return tuple(feature for other in seen for feature in relative(other, agent, self.spec))

    def _anonymous(self, features: Sequence[FeatureSpec]) -> tuple[FeatureSpec, ...]:
        """Features of landmarks without a meaning: which landmark they show differs from episode to episode."""
        marks = {entity.name for entity in self.spec.landmarks}
        shown: list[FeatureSpec] = []
        for feature in features:
            told = {name.split(".")[0] for _, name in feature.meaning.terms} if feature.meaning else set[str]()
            shown.append(replace(feature, name=f"seen_{feature.name}", meaning=None) if told & marks else feature)
        return tuple(shown)

    @cached_property
    def _observer(self) -> Observer:
        return Observer([feature for features in self._in_order for feature in features], self.spec)

    def observe(self, state: WorldState) -> tuple[Float32, ...]:
        """Returns the observations; shuffled, each agent sees the landmarks in its own order."""
        seen = super().observe(state)
        if "shuffled" not in self.spec.options:
            return seen
        marks, shuffled = len(self.spec.landmarks), list[Float32]()
        for agent, mine in enumerate(seen):
            first = next(k for k, feature in enumerate(self.features[agent]) if feature.meaning is None)
            places = first + 2 * orders(planes(state.position)[-marks:, 0], agent)  # of each landmark's dx
            columns = np.stack([places, places + 1], axis=2).reshape(len(mine), -1)
            shuffled.append(mine.copy())
            shuffled[-1][:, first : first + 2 * marks] = np.take_along_axis(mine, columns, axis=1)
        return tuple(shuffled)

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
        n_agents, there = len(self.agents), list[Any]()  # by step, radius and team: who is where it wants to be
        for state in states:
            position = planes(state.position)
            adversary = squared_distances(position[0], self.goal_position(state).T)
            gap = squared_distances(position[1:n_agents, None], position[None, n_agents:])
            there.append([[adversary < squared, covers_targets(gap < squared)] for squared in SQUARED_RADII])
        return np.any(there, axis=0).reshape(-1, len(states[0])).astype(np.float64)

    def reference_env(self) -> Any:
        """mpe2's parallel environment."""
        self.ensure_reference()
        from mpe2 import simple_adversary_v3  # pyright: ignore[reportMissingTypeStubs]

        return simple_adversary_v3.parallel_env(
            N=len(self.teams[DEFENDERS]), max_cycles=EPISODE_STEPS, continuous_actions=self.continuous
        )


def orders(x: Float64, agent: int) -> Int:
    """In which order an agent sees the landmarks of each game, [batch, n_landmarks]: a permutation that their x
    coordinates, [n_landmarks, batch], draw, whose last bits are as good as dice and stay as they are in an episode.
    """
    bits = np.ascontiguousarray(x).view(np.uint64) * np.uint64(2 * agent + 1)
    bits = (bits ^ (bits >> np.uint64(31))) * np.uint64(0x9E3779B97F4A7C15)
    return np.argsort(bits ^ (bits >> np.uint64(29)), axis=0).T
