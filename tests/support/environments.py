"""Environments as users write them, sound and unsound: `tests.support.environments:NAME`, which calls NAME."""

import os

import gymnasium
import numpy as np
from gymnasium.spaces import Box, Discrete
from pettingzoo import ParallelEnv

from codegen.ir import FeatureSpec, Meaning
from maviper.worlds import parallel_env


class Line(ParallelEnv):
    """Two runners on a line; `left runner` is done once it has made `goal` steps. Cut after `length` steps."""

    metadata = {"name": "line"}  # noqa: RUF012

    def __init__(self, goal=99, length=8, bound=20.0):
        self.possible_agents = ["left runner", "runner_1"]
        self.goal, self.length = goal, length
        self._box = Box(-bound, bound, (3,), np.float32)
        self._seen = np.zeros(3, np.float32)  # one buffer for ever, as some environments have it

    def observation_space(self, agent):
        return self._box

    def action_space(self, agent):
        return Discrete(3)

    def reset(self, seed=None, options=None):
        self.rng = np.random.default_rng(seed)
        drawn = self.rng.uniform(-1, 1, len(self.possible_agents))
        self.place = dict(zip(self.possible_agents, drawn, strict=True))
        self.agents, self.time = list(self.possible_agents), 0
        return self.observations(), {agent: {} for agent in self.agents}

    def observations(self):
        return {agent: self.observe(agent) for agent in self.agents}

    def observe(self, agent):
        self._seen[:] = (self.place[agent], self.time, 0)
        return self._seen.copy() if agent == "left runner" else self._seen

    def step(self, actions):
        assert set(actions) == set(self.agents), actions
        assert all(type(action) is int for action in actions.values())
        self.time += 1
        for agent, action in actions.items():
            self.place[agent] += action - 1
        rewards = {agent: -abs(self.place[agent]) for agent in self.agents}
        ended = {agent: agent == "left runner" and self.time >= self.goal for agent in self.agents}
        cut = dict.fromkeys(self.agents, self.length is not None and self.time >= self.length)
        observations, infos = self.observations(), {agent: {} for agent in self.agents}
        self.agents = [agent for agent in self.agents if not ended[agent] and not cut[agent]]
        return observations, rewards, ended, cut, infos


class disturbing(Line):
    """Everybody is shaken at every step, by the one generator that all copies in a process share."""

    def reset(self, seed=None, options=None):
        np.random.seed(seed)  # noqa: NPY002
        return super().reset(seed, options)

    def step(self, actions):
        for agent in self.agents:
            self.place[agent] += np.random.uniform(-1, 1)  # noqa: NPY002
        return super().step(actions)


def spread(**options):
    from mpe2 import simple_spread_v3

    return simple_spread_v3.parallel_env(**options)


def adversary(**options):
    from mpe2 import simple_adversary_v3

    return simple_adversary_v3.parallel_env(**options)


def ours(game="physical-deception", **options):
    return parallel_env(",".join([game, *(f"{key}={value}" for key, value in options.items())]))


def in_turns():
    from mpe2 import simple_spread_v3

    return simple_spread_v3.env()


class shared(Line):
    """Three agents, of whom all, two or none are paid the same."""

    def __init__(self, rewards="all"):
        super().__init__()
        self.possible_agents, self.max_cycles, self.paid = ["left", "right", "third_0"], 8, rewards

    def step(self, actions):
        observations, rewards, *others = super().step(actions)
        together = dict.fromkeys(rewards, sum(rewards.values()))
        paid = {"all": together, "own": rewards, "nothing": dict.fromkeys(rewards, 0.0)}
        paid["pairs"] = together | {"third_0": rewards.get("third_0", 0.0)}
        return observations, paid[self.paid], *others


def solitary(says):
    env = described()
    env.alone = True if says == "True" else says
    return env


def early():
    return Line(goal=3)


def short(length: int):
    return Line(length=length)


class vanishing(Line):
    """All are done after three steps, of themselves."""

    def step(self, actions):
        observations, rewards, _, _, infos = super().step(actions)
        over = dict.fromkeys(actions, self.time >= 3)
        self.agents = [] if self.time >= 3 else self.agents
        return observations, rewards, over, dict.fromkeys(actions, False), infos


def small_space():
    return Line(bound=1.5)


def nothing():
    return "no environment"


class continuous(Line):
    def action_space(self, agent):
        return Box(0, 1, (2,)) if agent == "runner_1" else Discrete(3, start=1)

    def observation_space(self, agent):
        return Discrete(4) if agent == "runner_1" else Box(0, 255, (2, 2), np.float32)


class raising(Line):
    def step(self, actions):
        if self.time == 2:
            raise ArithmeticError("the line is broken")
        return super().step(actions)


class dying(Line):
    max_cycles = 5

    def step(self, actions):
        os._exit(9)


class nondeterministic(Line):
    def reset(self, seed=None, options=None):
        return super().reset()


class small_seeds(Line):
    max_cycles = 5

    def reset(self, seed=None, options=None):
        return super().reset(np.random.RandomState(seed).randint(9))


class tiny_seeds(Line):
    def reset(self, seed=None, options=None):
        assert seed < 2**16, "the seed is too large"
        return super().reset(seed)


class late(Line):
    max_cycles = 5

    def reset(self, seed=None, options=None):
        observations, infos = super().reset(seed)
        self.agents = ["left runner"]
        return {"left runner": observations["left runner"]}, infos


class dropping(Line):
    """Without a flag, runner_1 is not in `agents` after two steps, and is there again after the third."""

    def step(self, actions):
        everybody = dict.fromkeys(self.possible_agents, 1) | actions
        self.agents = list(self.possible_agents)
        outcome = super().step(everybody)
        self.agents = ["left runner"] if self.time == 2 else list(self.possible_agents)
        return outcome


class not_a_number(Line):
    def observations(self):
        return {agent: np.full(3, np.nan) for agent in self.agents}


def described():
    env = Line()
    env.max_cycles = 6
    env.teams = {"first!": ["runner_1"], "second": ["left runner"]}
    place = FeatureSpec("place", "length", -20.0, 20.0, Meaning(((1, "runner_1.x"),)))
    env.features = {
        "runner_1": [
            place,
            FeatureSpec("time", "steps", 0.0, 6.0, None),
            FeatureSpec("zero", "none", 0.0, 0.0, Meaning(())),
        ]
    }
    return env


def unequal():
    """One team, whose agents observe numbers in other units."""
    env = described()
    env.teams = {"all": env.possible_agents}
    return env


def misdescribed():
    env = described()
    env.features["runner_1"][0] = FeatureSpec("place", "length", -1.0, 1.0, Meaning(((1, "runer_1.x"),)))
    return env


def mistaken_teams():
    env = Line()
    env.teams = {"all": ["runner_1"]}
    return env


class _Talking(Line):
    def reset(self, seed=None, options=None):
        print("hello from the environment")
        return super().reset(seed)


def talking():
    print("hello from the function")
    return _Talking()


def leaving():
    raise SystemExit("this is a script")


class Relay(ParallelEnv):
    """Two runners and a chaser. A runner leaves after `first` steps or fewer than `spread` more; the chaser is cut.

    Everybody observes [a random place, the time, `over` for who has left, else 0] and gains 1 per step. As some do, the
    environment still hands out observations, and rewards of 100, for those who have left.
    """

    metadata = {"name": "relay"}  # noqa: RUF012

    def __init__(self, over=1.0, first=2, spread=3, length=8, agents=("runner_0", "runner_1", "chaser_0")):
        self.possible_agents = list(agents)
        runners, chasers = ([agent for agent in agents if agent.startswith(kind)] for kind in ("runner", "chaser"))
        self.teams = {"runner": runners, "chaser": chasers} if chasers else {"runner": runners}
        self.over, self.first, self.spread, self.max_cycles = over, first, spread, length

    def observation_space(self, agent):
        return Box(-20, 20, (3,), np.float32)

    def action_space(self, agent):
        return Discrete(3)

    def reset(self, seed=None, options=None):
        self.rng = np.random.default_rng(seed)
        self.agents, self.time = list(self.possible_agents), 0
        self.leaves = {
            agent: self.first + int(self.rng.integers(self.spread))
            for agent in self.possible_agents
            if agent != "chaser_0"
        }
        return self.observations(), {agent: {} for agent in self.agents}

    def observations(self):
        left = {agent for agent, time in self.leaves.items() if self.time >= time}
        return {
            agent: np.array([self.rng.uniform(-1, 1), self.time, self.over if agent in left else 0], np.float32)
            for agent in self.possible_agents
        }

    def step(self, actions):
        assert set(actions) == set(self.agents), actions
        self.time += 1
        rewards = {agent: 1.0 if agent in self.agents else 100.0 for agent in self.possible_agents}
        ended = {agent: self.time >= self.leaves.get(agent, 99) for agent in self.agents}
        cut = dict.fromkeys(self.agents, self.time >= self.max_cycles)
        infos = {agent: {} for agent in self.agents}
        self.agents = [agent for agent in self.agents if not ended[agent] and not cut[agent]]
        return self.observations(), rewards, ended, cut, infos


def relay(over: int = 1):
    return Relay(over)


def alone(over: int = 1):
    """One runner, who leaves after three steps."""
    return Relay(over, first=3, spread=1, agents=("runner_0",))


class Single(ParallelEnv):
    """A gymnasium environment as a parallel one of one agent."""

    metadata = {"name": "single"}  # noqa: RUF012

    def __init__(self, name, steps):
        self.env = gymnasium.make(name, max_episode_steps=steps)
        self.possible_agents, self.max_cycles = ["player_0"], steps

    def observation_space(self, agent):
        return self.env.observation_space

    def action_space(self, agent):
        return self.env.action_space

    def reset(self, seed=None, options=None):
        observation, info = self.env.reset(seed=seed)
        self.agents = list(self.possible_agents)
        return {"player_0": observation}, {"player_0": info}

    def step(self, actions):
        parts = self.env.step(actions["player_0"])
        self.agents = [] if parts[2] or parts[3] else self.agents
        return tuple({"player_0": part} for part in parts)


def cart_pole():
    return Single("CartPole-v1", 200)


class walker(gymnasium.Env):
    """One walker, as Gymnasium has it: actions -1, 0 and 1, an observation of the kind that is asked for."""

    def __init__(self, shows="grid"):
        self.action_space = Discrete(3, start=-1)
        kinds = {
            "grid": Box(-9, 9, (2, 2), np.float64),
            "bits": gymnasium.spaces.MultiBinary(3),
            "place": Discrete(5, start=2),
            "parts": gymnasium.spaces.Dict({"x": Box(-1, 1, (1,))}),
            "words": gymnasium.spaces.Text(3),
            "picture": Box(0, 255, (40, 40, 3), np.uint8),
        }
        self.observation_space, self.shows = kinds[shows], shows

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.place, self.time = int(self.np_random.integers(5)), 0
        return self.seen(), {}

    def seen(self):
        if self.shows == "parts":
            return {"x": np.array([self.place / 5], np.float32)}
        if self.shows == "place":
            return 2 + self.place
        if self.shows == "bits":
            return np.array([self.place > k for k in range(3)], np.int8)
        return np.array([[self.place, self.time], [0, 1 / 3]])

    def step(self, action):
        assert self.action_space.contains(np.int64(action)), action
        self.place, self.time = min(4, max(0, self.place + int(action))), self.time + 1
        return self.seen(), float(self.place), self.place == 0, self.time == 6, {}


class Scripted:
    """An expert of a world, by its name, in which everybody acts by one rule of its own observations."""

    hash, card, centralized = "", {"algorithm": "by hand"}, False

    def __init__(self, world, rule):
        from maviper.worlds import find

        self.world, self.rule = find(world), rule
        self.agents = self.world.agents

    def act(self, agents, observations, state):
        return np.stack([self.rule(observations[agent]) for agent in agents], axis=1)

    def q(self, agent, observations, state, joint, given):
        raise NotImplementedError


def walking_expert():
    """To the right until the third place, then back."""
    return Scripted("tests.support.environments:walker", lambda seen: np.where(seen[:, 0] < 3, 2, 0))


class measured(Line):
    """Its infos tell how far everybody went: in each step, and at the end who is left."""

    measures = {  # noqa: RUF012
        "way": ("went", "sum", "lower"),
        "pace": ("went", "mean", "lower"),
        "place": ("place", "last", "higher"),
    }

    def step(self, actions):
        *others, infos = super().step(actions)
        for agent, info in infos.items():
            info |= {"went": abs(actions[agent] - 1)} | ({} if agent in self.agents else {"place": self.place[agent]})
        return *others, infos


class mismeasured(measured):
    """It states a measure in words that mean nothing."""

    measures = {"way": ("went", "total", "lower")}  # noqa: RUF012


class unmeasured(measured):
    """None of its infos has the key."""

    measures = {"way": ("gone", "sum", "lower")}  # noqa: RUF012


class measured_team(measured):
    """Both are one team."""

    teams = {"runners": ["left runner", "runner_1"]}  # noqa: RUF012


def still(agent, observations):
    """An expert that goes nowhere."""
    return np.ones(len(observations), dtype=np.int64)
