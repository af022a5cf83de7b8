"""Learned against measured critics: the extraction weights that they give, and the trees that grow from them.

    python tests/benchmarks/critics.py [EXPERT ...] [--seeds 4] [--json]

Rank correlation of the MAVIPER weights over the same states (episodes of the expert), per agent; then the primary
measures of depth-4 trees (10 iterations, selection on 50 episodes), the mean over extraction seeds, with each critic.
"""

import argparse
import json

import numpy as np
from scipy.stats import spearmanr

from maviper.episodes.play import play, points
from maviper.evaluation.held_out import read_measure
from maviper.experts import store
from maviper.experts.expert import labels
from maviper.experts.measured import Measured
from maviper.extraction.algorithms import extract
from maviper.extraction.growth.weights import maviper_weights
from maviper.extraction.settings import Settings

EPISODES = range(9_200_000, 9_200_030)


def compare(name, seeds):
    expert, world = store.load(name)
    shaping = expert.card["settings"]["shaping"]
    critics = {"learned": expert, "measured": Measured(world, expert), "measured, shaped": None}
    critics["measured, shaped"] = Measured(world, expert, shaping=shaping)
    episodes = play(world, [expert] * len(world.agents), world.start_from_seeds(EPISODES))
    observations, state = points(episodes)
    wanted = labels(expert, observations, state)
    weights = {kind: maviper_weights(world, found, observations, state, wanted) for kind, found in critics.items()}
    for kind in list(critics)[1:]:
        for agent, one in enumerate(world.agents):
            rank = spearmanr(weights["learned"][:, agent], weights[kind][:, agent]).statistic
            yield f"{name}: {one}, rank correlation of learned and {kind} weights", float(rank)
    for kind, found in critics.items():
        rows = []
        for seed in range(seeds):
            measured = extract(world, found, Settings.of({"iterations": 10, "refinement": 0, "seed": seed}))
            rows.append([read_measure(measured.provenance.evaluation, world.primary(team))[0] for team in world.teams])
        for team, value in zip(world.teams, np.mean(rows, axis=0), strict=True):
            yield f"{name}: {world.primary(team).label} of trees with {kind} weights", float(value)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("experts", nargs="*", default=["physical-deception", "cooperative-navigation"])
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    figures = []
    for name in options.experts:
        for label, value in compare(name, options.seeds):
            figures.append({"name": label, "value": value, "better": "lower" if "collisions" in label else "higher"})
            if not options.json:
                print(f"{label}: {value:.3f}", flush=True)
    if options.json:
        print(json.dumps({"figures": figures}))


if __name__ == "__main__":
    main()
