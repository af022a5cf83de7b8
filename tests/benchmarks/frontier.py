"""The frontier of trees: how well a team of trees plays, by the trees' depth and by what they observe.

    python tests/benchmarks/frontier.py [--kept FILE] [--experts NAME,...] [--features none,coasting,...]
        [--depths 3,4,5,6,7,8] [--measure D] [--team agents] [--seeds 1] [--full | --regret] [--json]

One row for each expert and groups of features, one column for each depth: the measure against the expert's opponents
and, in brackets, the mean number of leaves an agent; means over seeds, 2,000 held-out episodes each. `none`: what the
expert observes. Coarse settings map the frontier: 3 rounds of 200 rollouts, all states alike (--critic none), 20,000
episodes of refinement. --full: 8 rounds of 400, and the preset's refinement. With --kept each run is a line of that
file, and a later call does not run it again. Predators with the paper's signs, beside their expert:

    python tests/benchmarks/frontier.py --experts predator-prey@clone --features none,coasting --depths 6 --full
        --team predators --measure touches

--regret: best responses that split by regret, 50 rounds of 48 and the preset's refinement, in place of MAVIPER.
"""

import argparse
import json
import time
from pathlib import Path

import numpy as np

from codegen import ir
from codegen.errors import InputError
from maviper.episodes.measures import MEASUREMENT_SEEDS, evaluate
from maviper.episodes.play import tree_policies
from maviper.experts.finding import LEARNED, NONE, find_expert
from maviper.extraction.algorithms import extract
from maviper.extraction.settings import Settings

EXPERTS = "cooperative-navigation@clone,cooperative-navigation,cooperative-navigation@fixed-roles"
GROUPS = "none,differences,ahead,ahead+differences,coasting,coasting+differences"
COARSE = {"iterations": 3, "rollouts": 200, "refinement": 20_000}
FULL = {"iterations": 8, "rollouts": 400}
REGRET = {"algorithm": "best-response", "weights": "regret", "splits": "histogram", "patience": 1_000_000}
REGRET |= {"iterations": 50, "rollouts": 48, "selection_episodes": 198}
KINDS = {"coarse": COARSE, "full": FULL, "regret": REGRET}
HELD_OUT = range(MEASUREMENT_SEEDS, MEASUREMENT_SEEDS + 2_000)
REACH, STRETCH, LEAVES = 0.85, 0.75, 64  # of D in navigation, with at most so many leaves an agent


def measured(expert, groups, depth, seed, options):
    """One extraction: the team's measure, its expert's, and its leaves; None where the groups add nothing."""
    started = time.process_time()
    try:
        critic = LEARNED if options.kind == "regret" else NONE
        teacher, world = find_expert(expert, critic, features="" if groups == "none" else groups)
    except InputError as error:
        if "add nothing" not in str(error):
            raise
        return None
    given = {"max_depth": depth, "seed": seed, "measure": options.measure, **KINDS[options.kind]}
    profile = extract(world, teacher, Settings.of(given, world))
    trees = tree_policies(profile.agents)
    lineup = [trees if world.team_of(agent) == options.team else teacher for agent in world.agents]
    measure = next(one for one in world.measures if (one.team, one.name) == (options.team, options.measure))
    leaves = [len(ir.leaves(policy.tree)) for policy in profile.team(options.team)]
    return {
        "value": evaluate(world, lineup, HELD_OUT)[measure].value,
        "expert": evaluate(world, [teacher] * len(lineup), HELD_OUT)[measure].value,
        "leaves": float(np.mean(leaves)),
        "most": max(leaves),
        "lower": measure.lower_is_better,
        "seconds": time.process_time() - started,
    }


def run(expert, groups, depth, seed, options):
    """A run, or what was kept of it."""
    key = [expert, groups, depth, seed, options.team, options.measure, options.kind]
    if options.kept is not None and options.kept.exists():
        for line in options.kept.read_text(encoding="utf-8").splitlines():
            if json.loads(line)["key"] == key:
                return json.loads(line)["found"]
    found = measured(expert, groups, depth, seed, options)
    if options.kept is not None:
        with options.kept.open("a", encoding="utf-8") as file:
            file.write(json.dumps({"key": key, "found": found}) + "\n")
    return found


def row(expert, groups, options):
    """Depth -> means over seeds; empty where the groups add nothing."""
    found = {}
    for depth in map(int, options.depths.split(",")):
        runs = [run(expert, groups, depth, seed, options) for seed in range(options.seeds)]
        if None in runs:
            return {}
        found[depth] = {name: float(np.mean([one[name] for one in runs])) for name in runs[0]}
    return found


def table(expert, options):
    """(features, depth) -> means over seeds, printed row by row."""
    found = {}
    if not options.json:
        head = "".join(f"{f'depth {depth}':>14}" for depth in options.depths.split(","))
        print(f"\n{options.measure} of the {options.team} (leaves an agent), trees of {expert}")
        print(f"{'features':<24}{head}{'expert':>10}{'CPU s':>8}")
    for groups in options.features.split(","):
        cells = row(expert, groups, options)
        found |= {(groups, depth): one for depth, one in cells.items()}
        if cells and not options.json:
            text = "".join(f"{'{value:.3f} ({leaves:.0f})'.format(**one):>14}" for one in cells.values())
            seconds = sum(one["seconds"] for one in cells.values())
            print(f"{groups:<24}{text}{next(iter(cells.values()))['expert']:10.3f}{seconds:8.0f}", flush=True)
    return found


def best(found):
    """(features, depth), means of the best team with at most LEAVES leaves an agent."""
    small = {key: one for key, one in found.items() if one["most"] <= LEAVES}
    return min(small.items(), key=lambda item: item[1]["value"] * (1 if item[1]["lower"] else -1), default=None)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kept", type=Path, default=None)
    parser.add_argument("--experts", default=EXPERTS)
    parser.add_argument("--features", default=GROUPS)
    parser.add_argument("--depths", default="3,4,5,6,7,8")
    parser.add_argument("--measure", default="D")
    parser.add_argument("--team", default="agents")
    parser.add_argument("--seeds", type=int, default=1)
    kind = parser.add_mutually_exclusive_group()
    for name in ("full", "regret"):
        kind.add_argument(f"--{name}", action="store_const", dest="kind", const=name, default="coarse")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    figures = []
    for expert in options.experts.split(","):
        found = best(table(expert, options))
        if found is not None:
            (groups, depth), one = found
            name = f"{options.measure} of trees of {expert}, at most {LEAVES} leaves an agent"
            aims = {"reach": REACH, "stretch": STRETCH} if options.measure == "D" else {"reach": one["expert"]}
            better = "lower" if one["lower"] else "higher"
            figures.append({"name": name, "value": one["value"], "better": better, **aims})
            if not options.json:
                print(f"best, at most {LEAVES} leaves: {one['value']:.3f} with {groups}, depth {depth}")
    if options.json:
        print(json.dumps({"figures": figures}))


if __name__ == "__main__":
    main()
