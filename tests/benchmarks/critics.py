"""Learned against measured critics: the extraction weights that they give, and the trees that grow from them.

    python -m tests.benchmarks.critics [EXPERT ...] [--seeds 4] [--replies] [--json]

Rank correlation of the MAVIPER weights over the same states (episodes of the expert), per agent; then the primary
measures of depth-4 trees (10 iterations, selection on 50 episodes), the mean over extraction seeds, with each critic.
With --replies instead: in what share of these states a learned Q has another action than the expert's clearly better,
beside experts and beside a mate that takes a random other action, and how many of the latter `best-response` believes.
"""

import argparse
import json

import numpy as np
from scipy.stats import spearmanr

from maviper.episodes.play import play, points
from maviper.evaluation.held_out import read_measure
from maviper.experts import network
from maviper.experts.expert import Measured, labels
from maviper.experts.finding import find_expert
from maviper.extraction.algorithms import extract
from maviper.extraction.dataset import Dataset
from maviper.extraction.growth.weights import LEAST_GAIN, Replies, joint_actions, maviper_weights
from maviper.extraction.settings import Settings

EPISODES = range(9_200_000, 9_200_030)


def compare(name, seeds):
    expert, world = network.load(name)
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


def compare_replies(name):
    expert, world = find_expert(name)
    episodes = play(world, [expert] * len(world.agents), world.start_from_seeds(EPISODES))
    observations, state = points(episodes)
    wanted, rng = labels(expert, observations, state), np.random.default_rng(0)
    everywhere = np.ones(wanted.shape)
    data = Dataset(observations, wanted, everywhere, everywhere.astype(bool))
    for agent, one in enumerate(world.agents):
        mates = [mate for mate in world.members(world.team_of(one)) if mate != agent]
        if mates:
            acting, choices = wanted.copy(), len(world.actions[mates[0]])
            acting[:, mates[0]] = (wanted[:, mates[0]] + rng.integers(1, choices, size=len(wanted))) % choices
            given = (agent, observations, state, joint_actions(world, agent, []))
            believed = Replies(world, expert, agent).to(acting, data, state).labels != wanted[:, agent]
            usual, misled = (clear(expert.q(*given, joint), wanted, agent) for joint in (wanted, acting))
            yield f"{name}: {one}, another action is clearly better beside experts", usual
            yield f"{name}: {one}, ... beside a mate that errs", misled
            yield f"{name}: {one}, ... and is believed", float(believed.mean())


def clear(q, wanted, agent):
    """In what share of states another action than the expert's is better by the least gain."""
    gained = q.max(axis=1) - np.take_along_axis(q, wanted[:, [agent]], axis=1)[:, 0]
    return float((gained > LEAST_GAIN * np.ptp(q, axis=1)).mean())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("experts", nargs="*", default=["physical-deception", "cooperative-navigation"])
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--replies", action="store_true")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    figures = []
    for name in options.experts:
        for label, value in compare_replies(name) if options.replies else compare(name, options.seeds):
            figures.append({"name": label, "value": value, "better": "lower" if "collisions" in label else "higher"})
            if not options.json:
                print(f"{label}: {value:.3f}", flush=True)
    if options.json:
        print(json.dumps({"figures": figures}))


if __name__ == "__main__":
    main()
