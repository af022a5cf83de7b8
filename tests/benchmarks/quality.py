"""How much of what an expert achieves its trees keep, over extraction seeds.

    python tests/benchmarks/quality.py [EXPERT] [--seeds 16] [--full] [--json]

One row a seed: each team's primary measure (in deception, success at r = 0.316) for depth-4 MAVIPER trees (10
iterations of 50 rollouts as in the demo; --full: the paper's 100) against expert opponents on 1,000 held-out episodes,
and its ratio to the expert's on the same episodes, the inverse where lower is better.
"""

import argparse
import json

import numpy as np

from maviper.evaluate.metrics import ratio
from maviper.experts import store
from maviper.extract.algorithms import extract
from maviper.extract.outcome import measured_of
from maviper.extract.settings import Settings

DEMO_RATIO = 0.80


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("expert", nargs="?", default="physical-deception")
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--full", action="store_true")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    expert, world = store.load(options.expert)
    size = {} if options.full else {"iterations": 10, "selection_episodes": 50}
    ratios: dict[str, list[float]] = {team: [] for team in world.teams}
    for seed in range(options.seeds):
        measured = extract(world, expert, Settings.of({"seed": seed, **size})).provenance.evaluation
        row = []
        for team in world.teams:
            measure = world.primary(team)
            ours, theirs = measured_of(measured, measure)
            kept = ratio(measure, ours, theirs)
            if kept is not None:
                ratios[team].append(kept)
            text = "no ratio" if kept is None else f"{kept:.2f}"
            row.append(f"{measure.label} {ours:.3f} beside {theirs:.3f} ({text})")
        if not options.json:
            print(f"seed {seed}: {'; '.join(row)}", flush=True)
    figures = [
        {"name": f"{team} ratio, mean over {len(values)} seeds", "value": float(np.mean(values)), "better": "higher"}
        | ({"reach": DEMO_RATIO} if team == "defenders" else {})
        for team, values in ratios.items()
        if values
    ]
    if options.json:
        print(json.dumps({"figures": figures}))
    else:
        for team, values in ((team, values) for team, values in ratios.items() if values):
            above = np.mean(np.array(values) >= DEMO_RATIO)
            print(f"{team}: mean {np.mean(values):.3f}, least {min(values):.3f}, {above:.0%} at least {DEMO_RATIO}")


if __name__ == "__main__":
    main()
