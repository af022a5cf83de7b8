"""Predator-prey: K predators chase M faster prey among L obstacles.

Does: mpe2's `simple_tag_v3` as a batched world, with the observation of the paper, of the released code or of mpe2.
Assumes: discrete actions, silent agents.
Does not: local observations, or a curriculum.
"""

from collections.abc import Sequence
from functools import partial
from itertools import combinations
from typing import Any

import numpy as np

from codegen.dynamics import MPE2
from codegen.errors import UnknownNameError
from codegen.ir import FORK, PHYSICS, EntitySpec, FeatureSpec, Float64, Meaning
from maviper.worlds.games.features import own, relative, top_speed, velocity
from maviper.worlds.games.particle import (
    ACTIONS,
    EPISODE_STEPS,
    ParticleWorld,
    WorldState,
    distances,
    mpe2_spec,
    planes,
)
from maviper.worlds.world import Measure, unusual

PREDATORS = "predators"
PREY = "prey"
TOUCHES = "touches"
OBSERVATIONS = ("paper", "released", "mpe2")
TOUCH_REWARD = 10.0
OBSTACLE_START = (-0.9, 0.9)
INSIDE = 5.0  # the most that a prey pays on average, in an episode, for leaving the arena and counts as inside
NEARNESS = 0.1  # weight of distances in the shaping term, as in the released code


class PredatorPrey(ParticleWorld):
    """The game with that many predators, prey and obstacles.

    `observation`: `paper` (own position and velocity, of everything else only signs), `released` (the authors' layout
    of it, 0 or 1 instead of signs) or `mpe2` (everything as numbers).
    """

    def __init__(
        self,
        predators: int = 2,
        prey: int = 2,
        obstacles: int = 2,
        observation: str = "paper",
        features: str = "",
        physics: str = MPE2,
    ) -> None:
        if observation not in OBSERVATIONS:
            raise UnknownNameError("observation", observation, OBSERVATIONS, "predator-prey")
        hunters = tuple(f"adversary_{index}" for index in range(predators))
        hunted = tuple(f"agent_{index}" for index in range(prey))
        given = {"predators": predators, "prey": prey, "obstacles": obstacles}
        given |= {"observation": observation, "features": features, PHYSICS: physics}
        # the authors' fork multiplies by the acceleration where an action is taken, and once more where it pushes
        power = 2 if physics == FORK else 1
        predator = partial(EntitySpec, size=0.075, force=3.0**power, max_speed=1.0, collides=True)
        runner = partial(EntitySpec, size=0.05, force=4.0**power, max_speed=1.3, collides=True)
        block = partial(EntitySpec, size=0.2, force=0.0, max_speed=None, collides=True, start=OBSTACLE_START)
        self.spec = mpe2_spec(
            unusual(PredatorPrey, given),
            name="predator-prey",
            reference="mpe2.simple_tag_v3",
            agents=[*map(predator, hunters), *map(runner, hunted)],
            landmarks=(block(f"obstacle_{index}") for index in range(obstacles)),
        )
        self.teams = {PREDATORS: hunters, PREY: hunted}
        self.observation = observation
        self.actions = tuple(ACTIONS for _ in self.agents)
        layout = {"paper": self._paper, "released": self._build_released, "mpe2": self._mpe2}[observation]
        base = [layout(agent) for agent in self.agents]
        self.features = self.extend_features(base, features)
        self.shown = tuple(len(each) if observation == "mpe2" else 0 for each in base)
        self.measures = (Measure(PREDATORS, TOUCHES), Measure(PREY, TOUCHES, lower_is_better=True))
        self.return_first = (PREY,)
        inside = Measure(PREY, "touches inside", lower_is_better=True, partial=True)
        self.beside = (Measure(PREY, "fine", lower_is_better=True), Measure(PREY, "inside", share=True), inside)
        self.spec = self.choose_physics(physics, self.spec)

    # --- observations

    def _others(self, agent: str) -> list[str]:
        return [name for name in self.agents if name != agent]

    def _offsets(self, agent: str) -> list[FeatureSpec]:
        """Where all obstacles and all other agents are."""
        names = [entity.name for entity in self.spec.landmarks] + self._others(agent)
        return [feature for name in names for feature in relative(name, agent, self.spec)]

    def _velocities_of_prey(self, agent: str) -> list[FeatureSpec]:
        """How other prey move."""
        others = [name for name in self.teams[PREY] if name != agent]
        return [feature for name in others for feature in velocity(name, f"{name}_", top_speed(self.spec))]

    def _paper(self, agent: str) -> tuple[FeatureSpec, ...]:
        """Own position and velocity; signs of: relative positions, relative velocities (predators see those of prey
        only), the comparison of the opponents' positions, and of the own team's.
        """
        mine = own(agent, self.spec)
        positions = [_sign(feature) for feature in self._offsets(agent)]
        watched = self._others(agent) if agent in self.teams[PREY] else list(self.teams[PREY])
        velocities = [
            _sign_feature(f"{other}_dv{axis}", (1, f"{other}.v{axis}"), (-1, f"{agent}.v{axis}"))
            for other in watched
            for axis in "xy"
        ]
        opponents, team = sorted(self.teams.values(), key=lambda members: agent in members)
        compared = [
            _sign_feature(f"{a}_{b}_{axis}", (1, f"{a}.{axis}"), (-1, f"{b}.{axis}"))
            for members in (opponents, team)
            for a, b in combinations(members, 2)
            for axis in "xy"
        ]
        return (*mine["position"], *mine["velocity"], *positions, *velocities, *compared)

    def _build_released(self, agent: str) -> tuple[FeatureSpec, ...]:
        """Own velocity and position; whether these are positive: relative positions, velocities of other prey, the
        comparison of the opponents, and, once for each opponent, that of the own team.
        """
        mine = own(agent, self.spec)
        numbers = self._offsets(agent) + self._velocities_of_prey(agent)
        opponents, team = sorted(self.teams.values(), key=lambda members: agent in members)
        repeats = [("", opponents), *((f"_{count}", team) for count in range(len(opponents)))]
        for suffix, members in repeats:
            for a, b in combinations(members, 2):
                for axis in "xy":
                    meaning = Meaning(((1, f"{a}.{axis}"), (-1, f"{b}.{axis}")))
                    numbers.append(FeatureSpec(f"{a}_{b}_{axis}{suffix}", "length", -1.0, 1.0, meaning))
        return (*mine["velocity"], *mine["position"], *(_positive(feature) for feature in numbers))

    def _mpe2(self, agent: str) -> tuple[FeatureSpec, ...]:
        """Own velocity and position, relative positions, velocities of other prey."""
        mine = own(agent, self.spec)
        return (*mine["velocity"], *mine["position"], *self._offsets(agent), *self._velocities_of_prey(agent))

    # --- rewards and measures

    def _touching(self, state: WorldState) -> Float64:
        """[n_predators, n_prey, batch]: 1 where a predator touches a prey."""
        position, hunters = planes(state.position), len(self.teams[PREDATORS])
        n_agents = len(self.agents)
        reach = self.spec.agents[0].size + self.spec.agents[-1].size
        return (distances(position[:hunters, None], position[None, hunters:n_agents]) < reach).astype(np.float64)

    def rewards(self, state: WorldState) -> Float64:
        """Predators share 10 for every touch; a prey pays 10 for every touch of its own, and for leaving the arena."""
        touching = self._touching(state)
        hunters, n_agents = len(self.teams[PREDATORS]), len(self.agents)
        rewards = np.empty((n_agents, len(state)))
        rewards[:hunters] = TOUCH_REWARD * touching.sum(axis=(0, 1))
        away = outside(np.abs(planes(state.position)[hunters:n_agents]))
        rewards[hunters:] = -TOUCH_REWARD * touching.sum(axis=0) - away[:, 0] - away[:, 1]
        return rewards.T

    def shaping(self, state: WorldState) -> Float64:
        """The released code's term: predators lose a tenth of all distances to their nearest prey, a prey gains
        a tenth of all its distances to the predators.
        """
        position, hunters = planes(state.position), len(self.teams[PREDATORS])
        gap = distances(position[:hunters, None], position[None, hunters : len(self.agents)])
        terms = np.empty((len(self.agents), len(state)))
        terms[:hunters] = -NEARNESS * gap.min(axis=1).sum(axis=0)
        terms[hunters:] = NEARNESS * gap.sum(axis=0)
        return terms.T

    def values(self, states: Sequence[WorldState]) -> Float64:
        """Touches: predator-prey contacts in all steps of an episode."""
        touches = np.stack([self._touching(state).sum(axis=(0, 1)) for state in states]).sum(axis=0)
        return np.stack([touches, touches])

    def values_beside(self, states: Sequence[WorldState]) -> Float64:
        """The fine of an episode, whether it is at most INSIDE, and the touches of episodes in which it is."""
        prey = slice(len(self.teams[PREDATORS]), len(self.agents))
        away = [outside(np.abs(planes(state.position)[prey])) for state in states]
        fine = np.sum([each.sum(axis=1).mean(axis=0) for each in away], axis=0)
        inside = fine <= INSIDE
        return np.stack([fine, inside, np.where(inside, self.values(states)[0], np.nan)])

    def reference_env(self) -> Any:
        """mpe2's parallel environment."""
        self.ensure_reference()
        from mpe2 import simple_tag_v3  # pyright: ignore[reportMissingTypeStubs]

        return simple_tag_v3.parallel_env(
            num_good=len(self.teams[PREY]),
            num_adversaries=len(self.teams[PREDATORS]),
            num_obstacles=len(self.spec.landmarks),
            max_cycles=EPISODE_STEPS,
        )


def outside(x: Float64) -> Float64:
    """The price of a coordinate's distance from the origin: nothing up to 0.9, then rising steeply, 10 at most."""
    price = np.zeros_like(x)
    near = (x >= 0.9) & (x < 1.0)
    price[near] = (x[near] - 0.9) * 10
    far = x >= 1.0
    price[far] = np.minimum(np.exp(2 * x[far] - 2), 10)
    return price


def _sign_feature(name: str, *terms: tuple[float, str]) -> FeatureSpec:
    return FeatureSpec(name, "sign", -1.0, 1.0, Meaning(terms, "sign"))


def _sign(feature: FeatureSpec) -> FeatureSpec:
    assert feature.meaning is not None
    return _sign_feature(f"{feature.name}_sign", *feature.meaning.terms)


def _positive(feature: FeatureSpec) -> FeatureSpec:
    assert feature.meaning is not None
    return FeatureSpec(f"{feature.name}_positive", "none", 0.0, 1.0, Meaning(feature.meaning.terms, "positive"))
