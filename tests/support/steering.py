"""A game in which agents give numbers, `tests.support.steering:tugs`, and an expert for it."""

import numpy as np
from gymnasium.spaces import Box, Discrete
from pettingzoo import ParallelEnv

from codegen.ir import FeatureSpec, OutputSpec

STEPS = 12


class Tugs(ParallelEnv):
    """Two tugs on a line, each with a goal. The first gives a speed, the second a speed and a light."""

    metadata = {"name": "tugs"}  # noqa: RUF012
    max_cycles = STEPS

    def __init__(self, told=True):
        self.possible_agents = ["tug_0", "tug_1"]
        self.box = Box(-9, 9, (2,), np.float32)
        if told:
            self.features = {agent: [FeatureSpec(name, "m", -9, 9, None) for name in ("place", "goal")]
                             for agent in self.possible_agents}  # fmt: skip
            self.outputs = {"tug_0": [OutputSpec("speed", "m/s", -1, 1)]}

    def observation_space(self, agent):
        return self.box

    def action_space(self, agent):
        return Box(-1, 1, (1,), np.float32) if agent == "tug_0" else Box(np.float32([-1, 0]), np.float32([1, 3]))

    def reset(self, seed=None, options=None):
        rng = np.random.default_rng(seed)
        self.seen = {agent: rng.uniform(-2, 2, 2).astype(np.float32) for agent in self.possible_agents}
        self.agents, self.time = list(self.possible_agents), 0
        return dict(self.seen), {agent: {} for agent in self.agents}

    def step(self, actions):
        assert all(self.action_space(agent).contains(given) for agent, given in actions.items()), actions
        self.time += 1
        self.seen = {agent: seen + np.float32([actions[agent][0] / 2, 0]) for agent, seen in self.seen.items()}
        rewards = {agent: -float(abs(seen[0] - seen[1])) for agent, seen in self.seen.items()}
        cut = dict.fromkeys(self.agents, self.time >= STEPS)
        infos, ended = {agent: {} for agent in self.agents}, dict.fromkeys(self.agents, False)
        self.agents = [] if self.time >= STEPS else self.agents
        return dict(self.seen), rewards, ended, cut, infos


def tugs():
    return Tugs()


def untold():
    return Tugs(told=False)


class _Mixed(Tugs):
    def action_space(self, agent):
        return Discrete(3) if agent == "tug_0" else super().action_space(agent)


def mixed():
    return _Mixed(told=False)


class _Boundless(Tugs):
    def action_space(self, agent):
        return Box(-np.inf, np.inf, (1,), np.float32)


def boundless():
    return _Boundless(told=False)


class Pulling:
    """Everybody goes to its goal; a light is bright to the right of it."""

    hash, card, centralized = "", {}, False

    def __init__(self, world):
        self.world, self.agents = world, world.agents

    def act(self, agents, observations, state):
        found = np.zeros((len(observations[0]), len(agents), 2), np.float32)
        for place, agent in enumerate(agents):
            seen = observations[agent]
            found[:, place, 0] = np.clip(2 * (seen[:, 1] - seen[:, 0]), -1, 1)
            found[:, place, 1] = np.where(seen[:, 0] > seen[:, 1], 2.5, 0.5) * (agent == 1)
        return found

    def q(self, agent, observations, state, joint, given):
        raise NotImplementedError


def pulling():
    from maviper.worlds import find

    return Pulling(find("tests.support.steering:tugs", giving=True))
