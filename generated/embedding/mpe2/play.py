"""The generated policies as the players of mpe2's simple_adversary: plays seeded episodes and counts successes.

Does: lets `physical_deception.py` (the committed module) decide for every agent, from mpe2's own observations.
Assumes: mpe2 is installed (`pip install mpe2`); nothing of maviper is.
Does not: learn; draw.
"""

import argparse
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

from mpe2 import simple_adversary_v3

STEPS = 25
SQUARED_RADIUS = 0.1  # the radius is its root, 0.316; as in maviper/worlds/games/particle.py, SQUARED_RADII


def policies() -> ModuleType:
    """The generated module, from its folder beside ours."""
    sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "physical_deception"))
    import physical_deception

    return physical_deception


def played(env: Any, deciders: Mapping[str, Callable[[Any], int]], seed: int) -> tuple[bool, bool, list[str]]:
    """One episode: whether the adversary succeeded, whether the defenders did, and each step's actions.

    The success of maviper/worlds/games/physical_deception.py (`values`): at some step after the start the adversary is
    within the radius of the goal; at some one such step each target has a defender of its own within it.
    """
    observations, _ = env.reset(seed=seed)
    adversary = defenders = False
    steps = []
    for _ in range(STEPS):
        actions = {agent: decide(observations[agent]) for agent, decide in deciders.items()}
        steps.append("".join(str(action) for action in actions.values()))
        observations, _, _, _, infos = env.step(actions)
        # squared distances: of the adversary to the goal, of a defender to either landmark, then to the goal
        to_goal, first, second = (info["benchmark_data"] for info in infos.values())
        near = [[float(squared) < SQUARED_RADIUS for squared in each[:2]] for each in (first, second)]
        adversary = adversary or float(to_goal) < SQUARED_RADIUS
        defenders = defenders or (near[0][0] and near[1][1]) or (near[0][1] and near[1][0])
    return adversary, defenders, steps


def main() -> None:
    """Reads the options, plays, prints."""
    parser = argparse.ArgumentParser(description="Plays mpe2's simple_adversary with the generated policies.")
    parser.add_argument("--episodes", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0, help="of the first episode; the next ones count up")
    parser.add_argument("--each", action="store_true", help="also a line an episode: successes, then actions by step")
    options = parser.parse_args()
    if options.episodes < 1 or options.seed < 0:
        parser.error("--episodes starts at 1, --seed at 0")
    module = policies()
    deciders = {agent: getattr(module, f"act_{agent}") for agent in module.AGENTS}
    env = simple_adversary_v3.parallel_env(max_cycles=STEPS, benchmark_data=True)
    found = []
    for seed in range(options.seed, options.seed + options.episodes):
        adversary, defenders, steps = played(env, deciders, seed)
        found.append((adversary, defenders))
        if options.each:
            print(int(adversary), int(defenders), *steps)
    for team, successes in zip(("adversaries", "defenders"), zip(*found, strict=True), strict=True):
        print(f"{team} success r=0.316: {sum(successes)} of {len(found)} episodes, {sum(successes) / len(found):.3f}")


if __name__ == "__main__":
    main()
