"""Budgeted extraction: quality over the episodes spent, against the published protocol.

    python tests/benchmarks/budget.py [EXPERT] [--seeds 2] [--jobs 2] [--full] [--json]

Each budget covers rollouts, selection and refinement together (`maviper extract --max-episodes`). The protocol: 100
iterations of 50 rollouts, every iterate on 100 episodes per team, without refinement; quick: 30 iterations, named so.
--full: 10 seeds, the whole protocol. One row a budget: each team's primary measure, mean over seeds on 1,000 held-out
episodes, and seconds. Figures: the least budget whose teams are all within 0.02 of the protocol's (deception:
defenders), and the seconds it takes.
"""

import argparse
import json
import time

import numpy as np

from maviper.evaluation.held_out import read_measure
from maviper.experts import network
from maviper.extraction.algorithms import extract
from maviper.extraction.settings import Settings
from maviper.files.jobs import side_by_side

BUDGETS = (250, 500, 1_000, 2_000, 5_000, 10_000, 30_000, 100_000, 300_000)
NEAR = 0.02


def one(name, given):
    """Seconds of an extraction, and each team's primary measure."""
    expert, world = network.load(name)
    started = time.perf_counter()
    profile = extract(world, expert, Settings.of(given))
    seconds = time.perf_counter() - started
    measured = profile.provenance.evaluation
    return seconds, [read_measure(measured, world.primary(team))[0] for team in world.teams]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("expert", nargs="?", default="physical-deception")
    parser.add_argument("--seeds", type=int, default=None)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--full", action="store_true")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    seeds, iterations = options.seeds or (10 if options.full else 2), 100 if options.full else 30
    _, world = network.load(options.expert)
    whole = {"iterations": iterations, "patience": 1_000, "selection": "uniform", "refinement": 0}
    kinds = [(f"protocol, {iterations} iterations", whole), *((f"budget {n:,}", {"budget": n}) for n in BUDGETS)]
    tasks = [(options.expert, {**given, "seed": seed}) for _, given in kinds for seed in range(seeds)]
    runs = list(side_by_side(one, tasks, options.jobs))
    rows = []
    for place, (name, _) in enumerate(kinds):
        mine = runs[place * seeds : (place + 1) * seeds]
        reached = np.array([run[1] for run in mine])
        rows.append((name, float(np.mean([run[0] for run in mine])), reached))
        if not options.json:
            texts = [
                f"{world.primary(team).label} {column.mean():.3f} (least {column.min():.3f}, most {column.max():.3f})"
                for team, column in zip(world.teams, reached.T, strict=True)
            ]
            print(f"{name}: {'; '.join(texts)}; {rows[-1][1]:.1f} s", flush=True)
    signs = np.array([-1 if world.primary(team).lower_is_better else 1 for team in world.teams])
    if "defenders" in world.teams:
        signs = signs * np.array([team == "defenders" for team in world.teams])
    aim = rows[0][2].mean(axis=0)
    enough = [
        (budget, seconds)
        for budget, (_, seconds, reached) in zip(BUDGETS, rows[1:], strict=True)
        if (signs * reached.mean(axis=0) >= signs * aim - NEAR).all()
    ]
    figures = []
    if enough:
        budget, seconds = enough[0]
        targets = ({"reach": 1_000, "stretch": 500}, {"reach": 10, "stretch": 3})
        texts = (f"episodes within {NEAR} of the protocol", f"seconds within {NEAR} of the protocol")
        for name, value, goal in zip(texts, (budget, seconds), targets, strict=True):
            figures.append({"name": f"{name}, {options.expert}", "value": value, "better": "lower", **goal})
    if options.json:
        print(json.dumps({"figures": figures}))
        return
    for item in figures:
        print(f"{item['name']}: {item['value']:.4g} (reach {item['reach']:g}, stretch {item['stretch']:g})")


if __name__ == "__main__":
    main()
