"""Physical deception: N defenders cover N targets, one of which is the goal; an adversary looks for the goal.

Does: mpe2's `simple_adversary_v3` as a batched world, bit for bit; the success measure of the paper.
Assumes: full observability, discrete actions.
Does not: collisions (the game has none).
"""

from typing import Any

import numpy as np

from codegen.ir import Bool, EntitySpec, FeatureSpec, Float64, Meaning, WorldSpec
from maviper.worlds.particle import ACTIONS, Int, ParticleWorld, WorldState
from verify.matching import matched

ADVERSARIES = "adversaries"
DEFENDERS = "defenders"
FORCE = 5.0
DT = 0.1
DAMPING = 0.25
EPISODE_STEPS = 25
# The released evaluation compares squared distances with 0.1, so the radius of the paper's tables is its root, 0.316.
SQUARED_RADII = (0.1, 0.1**2)


class PhysicalDeception(ParticleWorld):
    """The game with `n_defenders` defenders and as many targets."""

    def __init__(self, n_defenders: int = 2) -> None:
        agents = ("adversary_0", *(f"agent_{index}" for index in range(n_defenders)))
        landmarks = tuple(f"landmark_{index}" for index in range(n_defenders))
        self.spec = WorldSpec(
            name="physical-deception",
            reference="mpe2.simple_adversary_v3",
            agents=tuple(EntitySpec(name, size=0.15, force=FORCE, max_speed=None, collides=False) for name in agents),
            landmarks=tuple(
                EntitySpec(name, size=0.08, force=0.0, max_speed=None, collides=False) for name in landmarks
            ),
            goals=landmarks,
            dt=DT,
            damping=DAMPING,
            start_low=-1.0,
            start_high=1.0,
            episode_steps=EPISODE_STEPS,
        )
        self.teams = {ADVERSARIES: agents[:1], DEFENDERS: agents[1:]}
        self.actions = tuple(ACTIONS for _ in agents)
        self.features = tuple(self._features(agent) for agent in agents)
        self.squared_radii = SQUARED_RADII

    def _features(self, agent: str) -> tuple[FeatureSpec, ...]:
        seen = [entity.name for entity in self.spec.landmarks] + [name for name in self.agents if name != agent]
        if agent in self.teams[DEFENDERS]:
            seen = ["goal", *seen]
        reach = farthest(self.spec)
        features: list[FeatureSpec] = []
        for other in seen:
            bound = 2.0 + (2 * reach if other in self.agents else reach)
            for axis in "xy":
                meaning = Meaning(((1, f"{other}.{axis}"), (-1, f"{agent}.{axis}")))
                features.append(FeatureSpec(f"{other}_d{axis}", "length", -bound, bound, meaning))
        return tuple(features)

    def rewards(self, state: WorldState) -> Float64:
        """Adversary: minus its distance to the goal. Defenders: that distance minus the nearest defender's."""
        n_agents = len(self.agents)
        goal = state.position[np.arange(len(state)), n_agents + state.goal]
        distance = _distance(state.position[:, :n_agents], goal[:, None])
        shared = -distance[:, 1:].min(axis=1) + distance[:, 0]
        rewards = np.repeat(shared[:, None], n_agents, axis=1)
        rewards[:, 0] = -distance[:, 0]
        return rewards

    def shaping(self, state: WorldState) -> Float64:
        """The covering term: for defenders, minus the sum over targets of the nearest defender's distance."""
        n_agents = len(self.agents)
        distance = _distance(state.position[:, 1:n_agents, None], state.position[:, None, n_agents:])
        terms = np.zeros((len(state), n_agents))
        terms[:, 1:] = -distance.min(axis=1).sum(axis=1)[:, None]
        return terms

    def success(self, position: Float64, goal: Int, squared_radius: float) -> dict[str, Bool]:
        """Adversary: within the radius of the goal at some step. Defenders: at some one step every target has a
        defender of its own within the radius.
        """
        n_agents = len(self.agents)
        batch = np.arange(len(goal))
        adversary = _squared(position[:, :, 0], position[:, batch, n_agents + goal]) < squared_radius
        near = _squared(position[:, :, 1:n_agents, None], position[:, :, None, n_agents:]) < squared_radius
        return {ADVERSARIES: np.any(adversary, axis=0), DEFENDERS: np.any(matched(near), axis=0)}

    def reference_env(self) -> Any:
        """mpe2's parallel environment."""
        from mpe2 import simple_adversary_v3

        return simple_adversary_v3.parallel_env(N=len(self.teams[DEFENDERS]), max_cycles=EPISODE_STEPS)


def farthest(spec: WorldSpec) -> float:
    """How far an agent can travel from rest within an episode along one axis, rounded up to a tenth."""
    place = speed = 0.0
    for _ in range(spec.episode_steps):
        place += speed * spec.dt
        speed = speed * (1 - spec.damping) + max(entity.force for entity in spec.agents) * spec.dt
    return float(np.ceil(place * 10) / 10)


def _squared(a: Float64, b: Float64) -> Float64:
    return np.square(a - b).sum(axis=-1)


def _distance(a: Float64, b: Float64) -> Float64:
    return np.sqrt(_squared(a, b))
