"""Our games as PettingZoo parallel environments, so that other people's tools can play and learn them.

Does: plays one game of a world's batched simulator, number for number; draws it with the reference environment.
Assumes: nothing about the game beyond `World`; pictures are of particle worlds.
Does not: shape rewards; wrap a user's environment, which is a PettingZoo one already.

An environment says about itself what `maviper.worlds.outside.pettingzoo` reads: `max_cycles`, `teams` and `features`.
Features that speak of landmarks or of the goal lose their meaning there: a user's world has no landmarks to speak of.
All of it is in `world`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium.spaces import Box, Discrete
from pettingzoo import ParallelEnv

from codegen.errors import InputError, UnknownNameError
from codegen.ir import ActionSpec, FeatureSpec, Float32, OutputSpec
from maviper.worlds.games.particle import ParticleWorld, place_entities
from maviper.worlds.seeds import TRAINING
from maviper.worlds.world import World

RGB = "rgb_array"
VIEW = 1.0  # half the width, in length units, at which mpe2 draws entities at their usual size

Seen = dict[str, Float32]
Infos = dict[str, dict[str, Any]]


class WorldEnv(ParallelEnv[str, Any, Any]):
    """One game of `world`. `render_mode`: None, or rgb_array for particle worlds; UnknownNameError for another.

    `max_cycles` is the length of an episode in steps; all agents are truncated there, and it may be set.
    """

    def __init__(self, world: World, render_mode: str | None = None) -> None:
        modes = [RGB] if isinstance(world, ParticleWorld) else []
        if render_mode is not None and render_mode not in modes:
            raise UnknownNameError("render mode", render_mode, modes, world.name)
        self.world, self.render_mode = world, render_mode
        self.metadata = {"name": world.name, "render_modes": modes}
        if isinstance(world, ParticleWorld):
            self.metadata["render_fps"] = round(1 / world.moving.dt)
        self.possible_agents, self.agents = list(world.agents), []
        self.max_cycles = world.spec.episode_steps
        self.teams = {team: list(members) for team, members in world.teams.items()}
        features = dict(zip(self.possible_agents, world.features, strict=True))
        self.features = {agent: _without_landmarks(each, world.agents) for agent, each in features.items()}
        self._boxes = {agent: _box(each) for agent, each in features.items()}
        acting = zip(self.possible_agents, world.decided, strict=True)
        self._choices = {agent: _choices(does) for agent, does in acting}
        self._rng: np.random.Generator | None = None  # made late, so that copies of a fresh environment differ
        self._state: Any = None
        self._seed, self._steps = 0, 0
        self._drawn: tuple[Any, int] | None = None  # the reference environment, and the seed of the episode in it

    def observation_space(self, agent: str) -> Box:
        """The agent's Box, [n_features] float32, always the same object.

        Only signs, flags and constants are bounded: contacts carry agents beyond the range that their features state.
        """
        return self._boxes[agent]

    def action_space(self, agent: str) -> Discrete | Box:
        """The agent's Discrete(n), or its Box where agents give numbers, always the same object; what its numbers mean
        is in `world.decided`.
        """
        return self._choices[agent]

    def reset(self, seed: int | None = None, options: Mapping[str, Any] | None = None) -> tuple[Seen, Infos]:
        """Starts an episode, as the reference environment does with that seed. `options` are ignored.

        Without a seed the episode's is drawn from those that our trainings use, after the last seed that was given;
        held-out episodes are never among them.
        """
        if seed is not None or self._rng is None:
            self._rng = np.random.default_rng(seed)
        self._seed = int(self._rng.integers(*TRAINING)) if seed is None else int(seed)
        self._state = self.world.start_from_seeds([self._seed])
        self._steps, self.agents = 0, list(self.possible_agents)
        return self._observe_agents(self.agents), {agent: {} for agent in self.agents}

    def step(
        self, actions: Mapping[str, Any]
    ) -> tuple[Seen, dict[str, float], dict[str, bool], dict[str, bool], Infos]:
        """Observations, rewards, terminations, truncations and infos of the agents that acted.

        `actions`: one for each agent in `agents`; others are ignored. InputError for a missing or unknown action, and
        where no episode is going on.
        """
        acted = self.agents
        if not acted:
            raise InputError("no episode is going on", self.world.name, "call reset first")
        chosen: Any = np.zeros((1, *self.world.acting_shape), np.float32 if self.world.continuous else np.int64)
        for place, agent in enumerate(self.possible_agents):
            if agent in acted:
                chosen[0, place] = self._action(agent, actions)
        self._state = self.world.step(self._state, chosen)
        self._steps += 1
        rewards, ended = self._of(acted, self.world.rewards), self._of(acted, self.world.terminated)
        alive = self._of(acted, self.world.alive)
        cut = {agent: not ended[agent] and (not alive[agent] or self._steps >= self.max_cycles) for agent in acted}
        self.agents = [agent for agent in acted if not ended[agent] and not cut[agent]]
        return self._observe_agents(acted), rewards, ended, cut, {agent: {} for agent in acted}

    def render(self) -> npt.NDArray[np.uint8] | None:
        """The present state, [height, width, 3] uint8, as mpe2 draws it; None without a render mode.

        InputError before the first reset.
        """
        if self.render_mode is None:
            return None
        if self._state is None:
            raise InputError("there is no state to draw", self.world.name, "call reset first")
        return place_entities(self._reference(), self._state).aec_env.unwrapped.render()

    def close(self) -> None:
        """Lets the drawing environment go."""
        if self._drawn is not None:
            self._drawn[0].close()
            self._drawn = None

    def _action(self, agent: str, actions: Mapping[str, Any]) -> Any:
        space, given = self._choices[agent], actions.get(agent)
        if given is None or not space.contains(given):
            said = f"{agent} has no action" if given is None else f"{agent}'s action is {given}"
            wanted = "numbers within its Box" if isinstance(space, Box) else f"a whole number from 0 to {space.n - 1}"
            raise InputError(said, self.world.name, f"give it {wanted}")
        return given

    def _observe_agents(self, agents: Sequence[str]) -> Seen:
        """Each agent's observation, [n_features] float32, in memory of its own."""
        seen = dict(zip(self.possible_agents, self.world.observe(self._state), strict=True))
        return {agent: np.array(seen[agent][0]) for agent in agents}

    def _of(self, agents: Sequence[str], part: Any) -> dict[str, Any]:
        """Returns the result of a method of the world for each agent in the present state."""
        said = dict(zip(self.possible_agents, part(self._state)[0].tolist(), strict=True))
        return {agent: said[agent] for agent in agents}

    def _reference(self) -> Any:
        """The reference environment in this episode: reset with its seed, since colours show the goal."""
        if self._drawn is None:
            env = self.world.reference_env()
            raw = env.aec_env.unwrapped
            raw.render_mode, raw.original_cam_range = self.render_mode, VIEW  # or a random start would scale pictures
        else:
            env, seed = self._drawn
            if seed == self._seed:
                return env
        env.reset(seed=self._seed)
        self._drawn = env, self._seed
        return env


def _choices(does: Sequence[ActionSpec] | Sequence[OutputSpec]) -> Discrete | Box:
    """The action space of an agent: of its actions, or of the numbers that it gives."""
    ends = [(each.low, each.high) for each in does if isinstance(each, OutputSpec)]
    return Box(*np.array(ends, np.float32).T, dtype=np.float32) if ends else Discrete(len(does))


def _box(features: Sequence[FeatureSpec]) -> Box:
    meanings = [feature.meaning for feature in features]
    bounded = [each is not None and (each.function != "" or not each.terms) for each in meanings]
    low, high = np.array([(each.low, each.high) for each in features], dtype=np.float32).T
    free = np.float32(np.inf)
    return Box(np.where(bounded, low, -free), np.where(bounded, high, free), dtype=np.float32)


def _without_landmarks(features: Sequence[FeatureSpec], agents: Sequence[str]) -> tuple[FeatureSpec, ...]:
    """The features, without the meanings that speak of anything but agents."""
    kept: list[FeatureSpec] = []
    for feature in features:
        told = {name.rpartition(".")[0] for _, name in feature.meaning.terms} if feature.meaning else set[str]()
        kept.append(feature if told <= set(agents) else replace(feature, meaning=None))
    return tuple(kept)
