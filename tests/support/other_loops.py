"""Generated Python code in the loops of other libraries: what it decides there, beside its profile; an
expert of tic-tac-toe.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

import maviper
from codegen import ir
from codegen.ir import PolicyProfile

Choose = Callable[[str, np.ndarray], np.ndarray]  # an agent's actions in observations [n, n_features]


class Code:
    """The generated Python module, which counts where it decides otherwise than the profile."""

    def __init__(self, profile: PolicyProfile) -> None:
        files = maviper.compile(profile, ["python"], prefix="team").files
        self.functions: dict[str, Any] = {"__name__": "team"}
        exec(files["team.py"], self.functions)
        self.policies = {policy.agent: policy for policy in profile.agents}
        self.asked = self.different = 0

    def __call__(self, agent: str, seen: np.ndarray) -> np.ndarray:
        found = np.array([self.functions[f"act_{agent}"](row.tolist()) for row in seen])
        self.asked += len(seen)
        self.different += int((found != ir.act(self.policies[agent], seen)).sum())
        return found


def play_tictactoe(choose: Choose, episodes: int) -> tuple[int, int]:
    """Decisions and illegal ones in games against random moves, half of them in each seat, in PettingZoo's AEC loop."""
    from pettingzoo.classic.tictactoe import tictactoe as game

    rng, decisions, illegal = np.random.default_rng(1), 0, 0
    for number in range(2 * episodes):
        env = game.env()
        env.reset(seed=number)
        mine = env.possible_agents[number % 2]
        for agent in env.agent_iter():
            seen, _, ended, cut, _ = env.last()
            if ended or cut:
                break
            legal = seen["action_mask"]
            row = np.concatenate([seen["observation"].ravel(), legal]).astype(np.float32)
            if agent == mine:
                action = int(choose(agent, row[None])[0])
                decisions += 1
                illegal += not legal[action]
            else:
                action = int(rng.choice(np.flatnonzero(legal)))
            env.step(action)
    return decisions, illegal


def play_navigation(choose: Choose, games: int, steps: int) -> None:
    """Plays navigation of two agents in VMAS's own batch."""
    import torch
    from vmas import make_env

    env = make_env("navigation", num_envs=games, continuous_actions=False, seed=1_000, n_agents=2, collisions=False)
    seen = env.reset()
    for _ in range(steps):
        actions = [choose(body.name, each.numpy()) for body, each in zip(env.agents, seen, strict=True)]
        seen, *_ = env.step([torch.from_numpy(each)[:, None].float() for each in actions])


LINES = [(0, 1, 2), (3, 4, 5), (6, 7, 8), (0, 3, 6), (1, 4, 7), (2, 5, 8), (0, 4, 8), (2, 4, 6)]


class Player:
    """Wins, blocks, or takes a corner, whether that is free or not: its Q knows what else there is."""

    hash, card, centralized = "", {"algorithm": "by hand"}, False

    def __init__(self, world):
        self.world, self.agents = world, world.agents

    def worth(self, obs):
        own, other = obs[:, 0:18:2], obs[:, 1:18:2]
        found = np.tile(np.array([3, 1, 3, 1, 4, 1, 3, 1, 3.0]), (len(obs), 1))
        for line in LINES:
            for cell in line:
                rest = [each for each in line if each != cell]
                found[:, cell] += 100 * own[:, rest].all(axis=1) + 10 * other[:, rest].all(axis=1)
        return found

    def act(self, agents, observations, state):
        return np.stack([self.worth(observations[agent]).argmax(axis=1) for agent in agents], axis=1)

    def q(self, agent, observations, state, joint, given):
        return self.worth(observations[agent])[:, joint[:, agent]]
