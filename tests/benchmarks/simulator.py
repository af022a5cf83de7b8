"""Joint steps a second of the batched simulator against mpe2, interleaved, one process.

    python tests/benchmarks/simulator.py [--games 4096] [--rounds 5] [--json]

A step of ours includes the dynamics, float32 observations of all agents and rewards; one of mpe2 is a call of its
parallel environment's step, which includes the same. Random actions; resets are counted on both sides.
"""

import argparse
import json
import time

import numpy as np

from maviper.worlds import find


def ours(world, games: int, seed: int) -> float:
    rng = np.random.default_rng(seed)
    started = time.process_time()
    state = world.start(games, rng)
    world.observe(state)
    for _ in range(world.spec.episode_steps):
        state = world.step(state, rng.integers(5, size=(games, len(world.agents))))
        world.observe(state)
        world.rewards(state)
    return games * world.spec.episode_steps / (time.process_time() - started)


def reference(world, env, episodes: int, seed: int) -> float:
    rng = np.random.default_rng(seed)
    started = time.process_time()
    for episode in range(episodes):
        env.reset(seed=seed + episode)
        for _ in range(world.spec.episode_steps):
            env.step(dict(zip(world.agents, rng.integers(5, size=len(world.agents)).tolist(), strict=True)))
    return episodes * world.spec.episode_steps / (time.process_time() - started)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--games", type=int, default=4096)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    world = find("physical-deception")
    env = world.reference_env()
    ratios, fast, slow = [], [], []
    for seed in range(options.rounds):
        fast.append(ours(world, options.games, seed))
        slow.append(reference(world, env, 40, seed))
        ratios.append(fast[-1] / slow[-1])
    name = f"physical deception, {options.games} games, steps/s over mpe2's"
    figure = {"name": name, "value": float(np.median(ratios))}
    if options.json:
        print(json.dumps({"figures": [figure | {"better": "higher"}]}))
    else:
        print(f"ours {np.median(fast):,.0f} steps/s, mpe2 {np.median(slow):,.0f} steps/s of CPU time")
        print(f"{name}: {figure['value']:.0f} (from {min(ratios):.0f} to {max(ratios):.0f})")


if __name__ == "__main__":
    main()
