"""What extraction from an own environment and own networks costs, over forty lines of DAgger with scikit-learn.

    python -m tests.benchmarks.doorway [--rounds 3] [--json]
    python -m tests.benchmarks.doorway --seeds 10 [--json]
    python -m tests.benchmarks.doorway --cartpole [--json]
    python -m tests.benchmarks.doorway --left [--json]
    python -m tests.benchmarks.doorway --simulator [--json]

Two robots meet at a doorway: a PettingZoo environment as a researcher writes it, and networks of NumPy. `maviper
extract` and the forty lines (`dagger`) play as many episodes, held-out ones included, each in a process of its own,
in turns. All that either spends counts, from the start of Python on. With `--seeds`, what their trees reach is compared
over so many seeds, in TESTED episodes that neither has seen. With `--cartpole` the expert is a PPO of
Stable-Baselines3, trained for TRAINED steps, and `maviper evaluate` counts too. With `--left`, the share of an
extraction's time that is still to come when its clock first says that nothing is left; of this environment, and of a
game of ours. With `--simulator`, the environment stands in for a slow simulator: it works for a second an episode,
prints each step, and fails where a process has two of it; told is what our own process spends beside it.
"""

import multiprocessing
import os
import sys
import time
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory

import gymnasium
import numpy as np
from gymnasium.spaces import Box, Discrete
from pettingzoo import ParallelEnv

from tests.benchmarks.common import figure, interleave_commands, reader, tell

HERE = "tests.benchmarks.doorway"
EPISODES, DEPTH, ROUNDS, HELD_OUT = 300, 3, 5, 37
WORK = 1.0  # seconds of CPU of a simulator's longest episode
TRAINED, PLACE = 30_000, "CARTPOLE"  # steps of the PPO; the variable that says where its file is
TESTED, FIRST_TESTED, SEEDS_APART = 500, 10_000_000, 300_000


class Doorway(ParallelEnv):
    """Robots on either side of a door, which must not meet in it. They have one reward, and leave when through."""

    metadata = {"name": "doorway_v0"}  # noqa: RUF012 - as PettingZoo has it

    def __init__(self, max_cycles=40):
        self.possible_agents = ["left", "right"]
        self.max_cycles = max_cycles
        self.action_names = {agent: ["back", "wait", "go"] for agent in self.possible_agents}
        self._seen, self._acted = Box(-5, 5, (4,), np.float32), Discrete(3)

    def observation_space(self, agent):
        return self._seen

    def action_space(self, agent):
        return self._acted

    def _observe(self, agent):
        other = self.possible_agents[1 - self.possible_agents.index(agent)]
        return np.array([self.place[agent], self.speed[agent], self.place[other], self.speed[other]], np.float32)

    def reset(self, seed=None, options=None):
        rng = np.random.default_rng(seed)
        self.agents = list(self.possible_agents)
        self.place = {agent: float(rng.uniform(1, 3)) for agent in self.agents}  # distance to the door
        self.speed = dict.fromkeys(self.agents, 0.0)
        self.steps = 0
        return {agent: self._observe(agent) for agent in self.agents}, {agent: {} for agent in self.agents}

    def step(self, actions):
        for agent, action in actions.items():
            self.speed[agent] = 0.5 * self.speed[agent] + 0.15 * (int(action) - 1)
            self.place[agent] = float(np.clip(self.place[agent] - self.speed[agent], -2, 4))
        self.steps += 1
        through = {agent: self.place[agent] <= -1 for agent in actions}
        crash = all(abs(self.place[agent]) < 0.5 for agent in self.possible_agents)
        reward = sum(through.values()) - 0.05 - crash
        cut = self.steps >= self.max_cycles
        self.agents = [agent for agent in self.agents if agent in actions and not through[agent] and not cut]
        seen = {agent: self._observe(agent) for agent in actions}
        paid, cuts = dict.fromkeys(actions, float(reward)), dict.fromkeys(actions, cut)
        return seen, paid, through, cuts, {agent: {} for agent in actions}


def make():
    """A fresh environment."""
    return Doorway()


class Simulator(Doorway):
    """The doorway behind a simulator of which a process has one: a second of work an episode, and a line a step."""

    begun = 0

    def __init__(self):
        super().__init__()
        Simulator.begun += 1
        assert Simulator.begun == 1, "a process has one simulation"

    def step(self, actions):
        print("step", self.steps)
        until = time.process_time() + WORK / self.max_cycles
        while time.process_time() < until:
            pass
        return super().step(actions)

    def close(self):
        Simulator.begun -= 1


class Network:
    """4-32-32-3, tanh. The first layer sees who is nearer; that one goes, and the other waits."""

    def __init__(self, seed):
        rng = np.random.default_rng(seed)
        self.weights = [rng.normal(0, 0.5, shape).astype(np.float32) for shape in ((4, 32), (32, 32), (32, 3))]

    def __call__(self, rows):
        hidden = np.tanh(np.tanh(rows @ self.weights[0]) @ self.weights[1])
        logits = hidden @ self.weights[2] * 0.1
        logits[:, 2] += (rows[:, 0] < rows[:, 2]) | (rows[:, 2] < -0.7)
        logits[:, 1] += (rows[:, 0] >= rows[:, 2]) & (rows[:, 0] > 0.8)
        return logits


NETWORKS = {"left": Network(0), "right": Network(1)}


def act(agent, observations):
    """The expert: the actions of an agent, [n], for observations [n, 4]."""
    return NETWORKS[agent](observations).argmax(axis=1)


class Alone(ParallelEnv):
    """CartPole, with one agent."""

    possible_agents, game = ["agent"], gymnasium.make("CartPole-v1")

    def reset(self, seed=None, options=None):
        self.agents = self.possible_agents
        return {"agent": self.game.reset(seed=seed)[0]}, {}

    def step(self, actions):
        seen, paid, fell, cut, _ = self.game.step(actions["agent"])
        self.agents = [] if fell or cut else self.agents
        return {"agent": seen}, {"agent": paid}, {}, {}, {}


@lru_cache
def ppo():
    """The PPO of Stable-Baselines3 that plays CartPole: trained, or loaded where it is there."""
    import torch
    from stable_baselines3 import PPO

    torch.set_num_threads(1)
    if not Path(os.environ[PLACE]).exists():
        PPO("MlpPolicy", "CartPole-v1", n_steps=256, seed=0, device="cpu").learn(TRAINED).save(os.environ[PLACE])
    return PPO.load(os.environ[PLACE], device="cpu")


def balance(agent, observations):
    """The PPO as an expert."""
    return ppo().predict(observations, deterministic=True)[0]


def dagger(env, act, episodes, depth, rounds, held_out, seed=0):
    """Forty lines of DAgger with scikit-learn: the policy of the best round, and returns of it and of the expert."""
    from sklearn.tree import DecisionTreeClassifier

    agents = env.possible_agents
    each = (episodes - 2 * held_out) // rounds // 2  # as many to learn from as to choose by
    rows, apart = {agent: [] for agent in agents}, SEEDS_APART * seed

    def expert(agent, row):
        return int(act(agent, row[None])[0])

    def play(policy, start, keep=False):
        seen, _ = env.reset(seed=apart + start)
        total = 0.0
        while env.agents:
            if keep:
                for agent in env.agents:
                    rows[agent].append(seen[agent])
            seen, paid, *_ = env.step({agent: policy(agent, seen[agent]) for agent in env.agents})
            total += sum(paid.values()) / len(agents)
        return total

    def mean(policy, first, count):
        return float(np.mean([play(policy, first + k) for k in range(count)]))

    best, score, policy = None, -np.inf, expert
    for turn in range(rounds):
        for k in range(each):
            play(policy, 1_000 * turn + k, keep=True)
        trees = {}
        for agent in agents:
            data = np.array(rows[agent])
            trees[agent] = DecisionTreeClassifier(max_depth=depth, random_state=0).fit(data, act(agent, data))

        def policy(agent, row, trees=trees):
            return int(trees[agent].predict(row[None])[0])

        reached = mean(policy, 100_000 + 1_000 * turn, each)
        if reached > score:
            best, score = policy, reached
    return best, mean(best, 200_000, held_out), mean(expert, 200_000, held_out)


def compare(rounds, cartpole):
    """The figures, from the medians of so many turns."""
    expert, world = (f"{HERE}:balance", "gymnasium:CartPole-v1") if cartpole else (f"{HERE}:act", f"{HERE}:make")
    with TemporaryDirectory() as folder:
        os.environ[PLACE], file, run = f"{folder}/ppo.zip", f"{folder}/team.json", [sys.executable, "-m"]
        given = ["--max-depth", DEPTH, "--max-episodes", EPISODES, "--held-out", HELD_OUT, "--world", world]
        commands = {"forty": [*run, HERE, "--forty"], "extract": [*run, "maviper", "extract", expert, *given]}
        commands["extract"] += ["-o", file]
        if cartpole:
            ppo()
            commands["forty"].append("--cartpole")
            given = ["--expert", expert, "--world", world, "--episodes", HELD_OUT]
            commands["evaluate"] = [*run, "maviper", "evaluate", file, *given]
        forty, *ours = (np.array(took) for took in interleave_commands(commands, rounds).values())
    name = " and ".join([*commands][1:])
    yield figure("forty lines of DAgger with scikit-learn, CPU s", float(np.median(forty)))
    yield figure(f"maviper {name} of as many episodes, CPU s", float(np.median(sum(ours))))
    yield figure(f"{name} over the forty lines, CPU", float(np.median(sum(ours) / forty)), 2, 1.2)


def reached_by(policy):
    """The mean return of a policy, (agent, row) -> action, in the tested episodes."""
    env, total = make(), 0.0
    for seed in range(FIRST_TESTED, FIRST_TESTED + TESTED):
        seen, _ = env.reset(seed=seed)
        while env.agents:
            seen, paid, *_ = env.step({agent: policy(agent, seen[agent]) for agent in env.agents})
            total += sum(paid.values()) / len(env.possible_agents)
    return total / TESTED


def compare_quality(seeds):
    """What trees of extract's defaults reach beside those of the forty lines, from as many episodes."""
    import maviper

    def ours(seed):
        options = {"max_depth": DEPTH, "max_episodes": EPISODES, "held_out": HELD_OUT, "seed": seed}
        team = maviper.extract(f"{HERE}:act", world=f"{HERE}:make", **options)
        return lambda agent, row: int(team[agent].act(row[None])[0])

    def theirs(seed):
        return dagger(make(), act, EPISODES, DEPTH, ROUNDS, HELD_OUT, seed)[0]

    yield figure("return of the expert", reached_by(lambda agent, row: int(act(agent, row[None])[0])), better="higher")
    means = {}
    for name, way in (("forty lines of DAgger with scikit-learn", theirs), ("maviper extract", ours)):
        returns = [reached_by(way(seed)) for seed in range(seeds)]
        means[name] = float(np.mean(returns))
        yield figure(f"return of {name}, mean of {seeds} seeds", means[name], better="higher")
        yield figure(f"return of {name}, lowest", min(returns), better="higher")
    theirs_mean, ours_mean = means.values()
    yield figure("return of extract less that of the forty lines", ours_mean - theirs_mean, 0, 0, better="higher")


def after_nothing_left(*given, **options):
    """The share of the time of `extract` after its line first says "0 s left", but for the second in which it may."""
    import maviper
    from maviper.console import LiveLine

    told, show = [], LiveLine.show

    def note(self, done, text, left):
        if left is not None and left < 0.5:
            told.append(time.monotonic())
        show(self, done, text, left)

    LiveLine.show = note
    try:
        began = time.monotonic()
        maviper.extract(*given, progress=lambda *_: None, **options)
        ended = time.monotonic()
    finally:
        LiveLine.show = show
    return max(0.0, ended - told[0] - 1) / (ended - began) if told else 0.0


def compare_clocks():
    """The figures of the clock."""
    mine = after_nothing_left(f"{HERE}:act", world=f"{HERE}:make", max_depth=DEPTH, max_episodes=EPISODES)
    yield figure("share of the time after '0 s left', doorway", mine, 0)
    ours = after_nothing_left("physical-deception", max_episodes=1_000)
    yield figure("share of the time after '0 s left', physical-deception", ours, 0)


def beside_a_simulator():
    """The figure of a slow simulator: what our process spends, from before the extraction, over what its copies do."""
    import maviper

    maviper.extract(f"{HERE}:act", world=f"{HERE}:make", max_episodes=30, held_out=2)  # imports are no part of it
    before = time.process_time()
    maviper.extract(f"{HERE}:act", world=f"{HERE}:Simulator", max_depth=DEPTH, max_episodes=40, held_out=5)
    mine, ticks = time.process_time() - before, os.sysconf("SC_CLK_TCK")
    lines = [Path(f"/proc/{child.pid}/stat").read_text().split() for child in multiprocessing.active_children()]
    theirs = sum(int(line[13]) + int(line[14]) for line in lines) / ticks  # user and system, of copies that are kept
    yield figure("our process beside a simulator of a second an episode, CPU", mine / theirs, 0.1)


def main():
    parser = reader(__doc__)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--seeds", type=int, default=0, help="compare what trees reach, over so many seeds")
    parser.add_argument("--forty", action="store_true", help="run the forty lines once")
    parser.add_argument("--cartpole", action="store_true", help="a PPO of Stable-Baselines3 in CartPole")
    parser.add_argument("--left", action="store_true", help="how long it goes on after nothing is left")
    parser.add_argument("--simulator", action="store_true", help="what a slow simulator costs beside its own work")
    options = parser.parse_args()
    if options.left or options.simulator:
        tell(compare_clocks() if options.left else beside_a_simulator(), options.json)
        return
    if options.forty:
        given = (Alone(), balance) if options.cartpole else (make(), act)
        print("returns of trees and of the expert", *dagger(*given, EPISODES, DEPTH, ROUNDS, HELD_OUT)[1:])
        return
    tell(compare_quality(options.seeds) if options.seeds else compare(options.rounds, options.cartpole), options.json)


if __name__ == "__main__":
    main()
