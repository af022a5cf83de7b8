"""Steps a second through the PettingZoo door, beside a plain loop over the same environment, in one interleaved run.

    python -m tests.benchmarks.door

One core, so that the door plays one copy in its own process, as the plain loop does. Both play the same episodes with
the same actions; rounds alternate, and the ratio is that of each round's two times, the middle one of all rounds.
"""

import argparse
import importlib.util
import json
import os
import statistics
import sys
import time
from pathlib import Path

import numpy as np

from maviper.worlds.outside.making import import_maker
from maviper.worlds.outside.pettingzoo import PettingZooWorld
from maviper.worlds.outside.sources import parse_source

REACH, STRETCH = 0.5, 0.8
EXAMPLE = Path(__file__).parents[2] / "generated" / "foraging"
EMPTY = ("line",)  # an environment that computes next to nothing: what is left is the door's own time, without a target
ENVIRONMENTS = {"line": "tests.support.environments:short,length=25", "spread": "tests.support.environments:spread"}
FORAGING = {"foraging": "foraging:make"}


def plain(env, names, seeds, actions):
    """Seconds and joint steps of a loop as anybody writes it."""
    started, steps = time.perf_counter(), 0
    for seed, episode in zip(seeds, actions, strict=True):
        env.reset(seed=int(seed))
        for row in episode:
            if not env.agents:
                break
            env.step({name: int(action) for name, action in zip(names, row, strict=True) if name in env.agents})
            steps += 1
    return time.perf_counter() - started, steps


def door(world, seeds, actions):
    """Seconds and joint steps of the same episodes through a world."""
    started, steps = time.perf_counter(), 0
    for seed, episode in zip(seeds, actions, strict=True):
        state = world.start_from_seeds([seed])
        for row in episode:
            if not world.alive(state).any():
                break
            world.observe(state)
            state = world.step(state, row[None])
            world.rewards(state)
            steps += 1
    return time.perf_counter() - started, steps


def measured(text, rounds, episodes):
    """Steps a second of both, and the middle of the rounds' ratios."""
    source = parse_source(text)
    world = PettingZooWorld(import_maker(source), source.text, games=1)
    env, rng = world.reference_env(), np.random.default_rng(0)
    sizes = [len(choices) for choices in world.actions]
    shape = (episodes, world.spec.episode_steps, len(sizes))
    ours, theirs, ratios = [], [], []
    for number in range(rounds + 1):
        actions, seeds = rng.integers(sizes, size=shape), range(number * episodes, (number + 1) * episodes)
        both = plain(env, world.env_agents, seeds, actions), door(world, seeds, actions)
        (slow, steps), (seconds, ended) = both
        assert steps == ended, "not the same episodes"
        if number:  # the first one warms up
            theirs.append(steps / slow)
            ours.append(steps / seconds)
            ratios.append(slow / seconds)
    world.close()
    return statistics.median(ours), statistics.median(theirs), statistics.median(ratios)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--episodes", type=int, default=20, help="a round")
    parser.add_argument("--json", action="store_true")
    asked = parser.parse_args()
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    sys.path.insert(0, str(EXAMPLE))
    known = importlib.util.find_spec("lbforaging") is not None
    figures = []
    for name, text in (ENVIRONMENTS | (FORAGING if known else {})).items():
        ours, theirs, ratio = measured(text, asked.rounds, asked.episodes)
        target = {} if name in EMPTY else {"reach": REACH, "stretch": STRETCH}
        figures.append({"name": f"door {name}", "value": round(ratio, 3), **target})
        if not asked.json:
            print(f"{name:<10} door {ours:9,.0f} steps/s  plain loop {theirs:9,.0f} steps/s  ratio {ratio:.2f}")
    if not known:
        print("foraging   not run: pip install lbforaging", file=sys.stderr)
    if asked.json:
        print(json.dumps({"figures": [{**each, "better": "higher"} for each in figures]}))


if __name__ == "__main__":
    main()
