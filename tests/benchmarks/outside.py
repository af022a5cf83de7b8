"""Games of other libraries, in these libraries' own loops: what trees return there, and whether their code is theirs.

Each function yields figures. `code` is the generated Python module. A share is that of the trees in what the expert
returns above random actions. Run by interop.py.
"""

import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import maviper
from codegen import ir
from codegen.ir import PolicyProfile
from maviper.experts import network
from maviper.experts.cards import Request
from maviper.experts.finding import Unweighted
from maviper.extraction.algorithms import extract
from maviper.extraction.settings import Settings
from maviper.worlds import find
from tests.support.lawful import Player

REACH, STRETCH = 0.9, 1.0
TURNS = {"algorithm": "iviper", "max_depth": 10, "iterations": 8, "rollouts": 200, "selection_episodes": 50}
TURN_EPISODES = 400  # in each seat
NAVIGATION = {"n_agents": 2, "collisions": False}
TRAINED = {"steps": 384_000, "games": 256, "minibatch": 3_200, "checkpoint_steps": 128_000}
TREES = {"max_depth": 4, "iterations": 6, "rollouts": 32, "selection_episodes": 32}
STEPS, GAMES, SEED = 50, 200, 1_000
Choose = Callable[[str, np.ndarray], np.ndarray]  # an agent's actions in observations [n, n_features]


class Counted(NamedTuple):
    """What was played: returns, decisions, and how many of these were wrong."""

    returns: list[float]
    decisions: int = 0
    illegal: int = 0


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


def figures(name: str, code: Code, returns: Sequence[Sequence[float]], leaves: int) -> Iterator[dict[str, Any]]:
    """`returns`: those of trees, of the expert and of random actions."""
    tree, best, chance = (float(np.mean(each)) for each in returns)
    what = f"{name}: code other than profile, of {code.asked:,} decisions"
    yield {"name": what, "value": code.different, "reach": 0, "stretch": 0, "better": "lower"}
    said = f"{name}: share, {leaves} leaves, {tree:.2f} of {best:.2f} over {chance:.2f}"
    share = (tree - chance) / (best - chance)
    yield {"name": said, "value": share, "reach": REACH, "stretch": STRETCH, "better": "higher"}


def leaves_of(profile: PolicyProfile) -> int:
    """Leaves of all trees."""
    return sum(len(ir.leaves(policy.tree)) for policy in profile.agents)


# --- PettingZoo: turns, dictionaries, masks


def opened() -> Any:
    """PettingZoo's TicTacToe after up to four random moves: two players without chance would always play one game."""
    from pettingzoo.classic.tictactoe import tictactoe as game
    from pettingzoo.utils.wrappers import BaseWrapper

    class Opened(BaseWrapper[Any, Any, Any]):
        def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> None:
            super().reset(seed=seed, options=options)
            rng = np.random.default_rng(seed)
            for _ in range(rng.integers(5)):
                legal = self.env.observe(self.env.agent_selection)["action_mask"]
                self.env.step(int(rng.choice(np.flatnonzero(legal))))

    return Opened(game.env())


def turns(settings: dict[str, Any] = TURNS, episodes: int = TURN_EPISODES) -> Iterator[dict[str, Any]]:
    """TicTacToe against random moves, in both seats, in PettingZoo's own AEC loop."""
    world = find("tests.benchmarks.outside:opened,wrap=turns+flatten+rivals,max_steps=9")
    expert = Player(world)
    profile = extract(world, expert, Settings.of(settings, world))
    world.close()
    code, rng = Code(profile), np.random.default_rng(0)

    def best(agent: str, seen: np.ndarray) -> np.ndarray:
        return np.where(seen[:, 18:] > 0, expert.worth(seen), -np.inf).argmax(axis=1)

    def chance(agent: str, seen: np.ndarray) -> np.ndarray:
        return np.array([rng.choice(np.flatnonzero(row[18:])) for row in seen])

    played = [tictactoe(choose, episodes) for choose in (code, best, chance)]
    what = f"PettingZoo TicTacToe: illegal of {played[0].decisions:,} actions"
    yield {"name": what, "value": played[0].illegal, "reach": 0, "stretch": 0, "better": "lower"}
    yield from figures("PettingZoo TicTacToe", code, [each.returns for each in played], leaves_of(profile))


def tictactoe(choose: Choose, episodes: int) -> Counted:
    """Games against random moves, half of them in each seat. PettingZoo ends a game at an illegal move."""
    from pettingzoo.classic.tictactoe import tictactoe as game

    rng, returns, decisions, illegal = np.random.default_rng(1), [], 0, 0
    for number in range(2 * episodes):
        env = game.env()
        env.reset(seed=number)
        mine, paid = env.possible_agents[number % 2], 0.0
        for agent in env.agent_iter():
            seen, _, ended, cut, _ = env.last()
            paid += env.rewards[mine] if env.agents else 0.0
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
        returns.append(paid)
    return Counted(returns, decisions, illegal)


# --- VMAS: trained by reward


def vmas(
    trained: dict[str, Any] = TRAINED, settings: dict[str, Any] = TREES, games: int = GAMES, steps: int = STEPS
) -> Iterator[dict[str, Any]]:
    """Navigation of two agents, with an expert that `maviper train` made, in VMAS's own batch."""
    from maviper.experts.training.train import train

    name = ",".join(["vmas:navigation", *(f"{key}={value}" for key, value in NAVIGATION.items()), f"max_steps={steps}"])
    world = find(name)
    with tempfile.TemporaryDirectory() as folder:
        train(world, Path(folder), Request(overrides=trained, critic=False))
        expert, _ = network.load(folder, world)
    profile = extract(world, Unweighted(expert), Settings.of(settings, world))
    code, rng = Code(profile), np.random.default_rng(0)

    def best(agent: str, seen: np.ndarray) -> np.ndarray:
        return expert.logits(world.agents.index(agent), seen).argmax(axis=1)

    def chance(agent: str, seen: np.ndarray) -> np.ndarray:
        return rng.integers(len(world.actions[0]), size=len(seen))

    returns = [navigation(choose, games, steps) for choose in (code, best, chance)]
    yield from figures("VMAS navigation", code, returns, leaves_of(profile))


def navigation(choose: Choose, games: int, steps: int) -> list[float]:
    """Returns of a batch that VMAS starts, the agents' mean. A game that has ended pays nothing more."""
    import torch
    from vmas import make_env

    env = make_env("navigation", num_envs=games, continuous_actions=False, seed=SEED, **NAVIGATION)
    seen, over, total = env.reset(), np.zeros(games, bool), np.zeros(games)
    for _ in range(steps):
        actions = [choose(body.name, each.numpy()) for body, each in zip(env.agents, seen, strict=True)]
        seen, paid, ended, _ = env.step([torch.from_numpy(each)[:, None].float() for each in actions])
        total += np.where(over, 0.0, np.mean([each.numpy() for each in paid], axis=0))
        over |= ended.numpy()
    return total.tolist()
