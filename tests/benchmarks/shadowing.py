"""By how much a difference between two episodes of a game grows, where both have the same actions.

    python -m tests.benchmarks.shadowing [--json] [--episodes N]

Of random starts at rest; the second episode starts 1e-10 away in every position. The table has by how many times the
largest difference of a position is larger after 25 steps: the most of all episodes, and half of them. A monitor that
follows episodes needs a start of the proof near the true one, so what measured numbers are off by must not grow: proofs
leave room for 2^-30, and a monitor lets each number be off by 2^-40, a thousandth of that.
"""

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np

from codegen.dynamics import Motion
from maviper import load
from tests.support.monitored import acting

VERDICTS = Path(__file__).parents[2] / "generated" / "verdicts"
GAMES = ("physical_deception", "cooperative_navigation", "predator_prey")
STEPS, OFF = 25, 1e-10
ROOM = 2.0**10  # between 2^-40 and 2^-30


def growth(game: str, episodes: int) -> Any:
    """By how many times the difference is larger, of each episode."""
    profile = load(VERDICTS / game / "profile.json")
    world, rng = profile.world, np.random.default_rng(0)
    policies = {policy.agent: policy for policy in profile.agents}
    motion = Motion(world, [policies[agent.name].actions for agent in world.agents])
    entities = world.agents + world.landmarks
    place = rng.uniform(-1, 1, (len(entities), 2, episodes))
    speed = np.zeros((len(world.agents), 2, episodes))
    beside, faster = place + OFF * rng.choice([-1, 1], place.shape), speed.copy()
    at = {name: column for column, name in enumerate(world.coordinates())}
    for _ in range(STEPS):
        w = np.zeros((episodes, len(at)))
        for number, entity in enumerate(entities):
            for axis, name in enumerate("xy"):
                w[:, at[f"{entity.name}.{name}"]] = place[number, axis]
                if number < len(world.agents):
                    w[:, at[f"{entity.name}.v{name}"]] = speed[number, axis]
        for name in "xy" if world.goals else "":
            w[:, at[f"goal.{name}"]] = w[:, at[f"{world.goals[0]}.{name}"]]
        acted = acting(profile, w)
        actions = np.column_stack([acted[agent.name] for agent in world.agents])
        place, speed = motion.step(place, speed, actions)
        beside, faster = motion.step(beside, faster, actions)
    return np.abs(beside - place).max(axis=(0, 1)) / OFF


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--episodes", type=int, default=20_000)
    given = parser.parse_args()
    grown = {game: growth(game, given.episodes) for game in GAMES}
    if given.json:
        aim = {"reach": ROOM, "stretch": ROOM, "better": "lower"}
        figures = [{"name": f"growth in {game}", "value": float(each.max())} | aim for game, each in grown.items()]
        print(json.dumps({"figures": figures}))
        return
    for game, each in grown.items():
        print(f"{game:25}{each.max():12,.1f}{np.median(each):12,.1f}")


if __name__ == "__main__":
    main()
