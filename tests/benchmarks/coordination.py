"""How far each algorithm's trees are from the best team of trees of their depth, in coordination games.

    python tests/benchmarks/coordination.py [--agents 2,3,4] [--games payoff=0,payoff=100] [--depth 2] [--kinds 2]
        [--seeds 10] [--full] [--json]

One row for each game and team size: the optimum, the expert's worth and each algorithm's optimality gap, medians over
seeds. All are exact, in the game's own payoff. Then in how many seeds `maviper` is nearer to the optimum than `iviper`,
and in how many farther from it. Every seed is another table and another extraction seed, the same ones for all
algorithms. Extractions: 5 iterations of 200 rollouts, every iterate judged on 500 episodes, no refinement. --full:
depths 1 and 2, one kind of agents and two, 50 seeds.
"""

import argparse
import json
import time
from itertools import product

import numpy as np

from maviper.experts.finding import find_expert
from maviper.extraction.algorithms import extract
from maviper.extraction.settings import IMITATION, IVIPER, IVIPER_RESAMPLING, MAVIPER, NO_PREDICTION, Settings
from maviper.worlds import find
from tests.support.optimum import optimum, rules_of, worth

ALGORITHMS = (IMITATION, IVIPER, NO_PREDICTION, IVIPER_RESAMPLING, MAVIPER)
GAMES = ("payoff=0", "payoff=50", "payoff=100", "agree=50", "rule=climbing", "rule=penalty")
PROTOCOL = {"selection": "uniform", "iterations": 5, "rollouts": 200, "selection_episodes": 500, "refinement": 0}
TIE = 1e-9


def reached(name, algorithm, depth, seed):
    """The worth of an extracted team, and the seconds that it took."""
    expert, world = find_expert(name)
    given = {"algorithm": algorithm, "max_depth": depth, "seed": seed, "patience": 5, **PROTOCOL}
    started = time.process_time()
    profile = extract(world, expert, Settings.of(given, world))
    return worth(world, rules_of(world, profile.agents)), time.process_time() - started


def measured(game, depth, seeds):
    """Arrays over seeds: the optimum, the expert's worth, each algorithm's gap, and the seconds of all of its runs."""
    best, experts = [], []
    gaps, seconds = {algorithm: [] for algorithm in ALGORITHMS}, {algorithm: [] for algorithm in ALGORITHMS}
    for seed in range(seeds):
        name = f"{game},table={seed}"
        world = find(name)
        best.append(optimum(world, depth).worth)
        experts.append(worth(world, np.stack([world.demanded] * len(world.agents))))
        for algorithm in ALGORITHMS:
            found, taken = reached(name, algorithm, depth, seed)
            assert found <= best[-1] + TIE, (name, algorithm)
            gaps[algorithm].append(best[-1] - found)
            seconds[algorithm].append(taken)
    return np.array(best), np.array(experts), {key: np.array(rows) for key, rows in gaps.items()}, seconds


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--agents", default="2,3,4")
    parser.add_argument("--games", default=",".join(GAMES))
    parser.add_argument("--depth", type=int, default=2)
    parser.add_argument("--kinds", type=int, default=2)
    parser.add_argument("--seeds", type=int, default=None)
    parser.add_argument("--full", action="store_true")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    seeds = options.seeds or (50 if options.full else 10)
    find_expert("coordination")
    reached("coordination", MAVIPER, 1, 0)  # imports are not what is timed
    figures, spent = [], {algorithm: [] for algorithm in ALGORITHMS}
    for depth, kinds in product((1, 2), (1, 2)) if options.full else [(options.depth, options.kinds)]:
        if not options.json:
            print(f"depth {depth}, kinds={kinds}, {seeds} seeds: median gap to the optimum")
            columns = ("agents", "optimum", "expert", *ALGORITHMS, "nearer/farther")
            print(f"{'game':<14}" + "".join(f"{name:>{max(9, len(name) + 2)}}" for name in columns))
        for game, agents in product(options.games.split(","), options.agents.split(",")):
            name = f"coordination,agents={agents},kinds={kinds},{game}"
            best, expert, gaps, seconds = measured(name, depth, seeds)
            change = gaps[IVIPER] - gaps[MAVIPER]
            wins = f"{(change > TIE).sum()}/{(change < -TIE).sum()}"
            medians = {algorithm: float(np.median(rows)) for algorithm, rows in gaps.items()}
            for algorithm, value in medians.items():
                label = f"{name}, depth {depth}: gap of {algorithm}"
                figures.append({"name": label, "value": value, "better": "lower"})
                spent[algorithm] += seconds[algorithm]
            if not options.json:
                cells = [f"{np.median(best):9.3f}{np.median(expert):9.3f}"]
                cells += [f"{value:{max(9, len(algorithm) + 2)}.3f}" for algorithm, value in medians.items()]
                print(f"{game:<14}{agents:>9}" + "".join(cells) + f"{wins:>16}", flush=True)
    for algorithm, rows in spent.items():
        figures.append(
            {"name": f"CPU seconds per run of {algorithm}", "value": float(np.median(rows)), "better": "lower"}
        )
        if not options.json:
            print(f"{algorithm}: {np.median(rows):.3f} CPU seconds per run")
    if options.json:
        print(json.dumps({"figures": figures}))


if __name__ == "__main__":
    main()
