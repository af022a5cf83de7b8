"""What counterexamples as data do to a team: rounds of verifying and extracting again, beside a repair.

    python tests/benchmarks/refit.py [EXPERT] [--seeds 2] [--rounds 2] [--property distinct_targets] [--max-depth 4]
                                     [--jobs 1] [--full] [--json]

For each extraction seed a team is extracted with the preset `default`; each round draws states in which it violates
the property, extracts again with those of all rounds so far as data (--counterexamples), and measures. The last row is
`maviper repair` of the first team. Violating: share of 300,000 uniform states of the start region, none of which was
learned from. Success: the primary measure of the team against the expert in 4,000 held-out episodes. Changed: share of
the states that the first team meets in which some action is another. Means over seeds, then the violating share of
each. Settings are those of the demo; --full: those of the preset, 5 seeds.
"""

import argparse
import json
import tempfile
import time
from pathlib import Path

import numpy as np

from maviper import tour as demo
from maviper.console import Console
from maviper.evaluation import comparison
from maviper.evaluation.players import EXPERT, Player
from maviper.experts.finding import find_expert
from maviper.extraction import refitting
from maviper.extraction.algorithms import extract
from maviper.extraction.settings import Settings
from maviper.files.jobs import side_by_side
from maviper.verification.files.states import document_of
from maviper.verification.repair import collect_states
from maviper.worlds.matching import matching_world
from verify.claims.catalogue import find_property
from verify.claims.uncertified.starts import everywhere
from verify.question import Question, from_start
from verify.repair.search import repair
from verify.states.failures import failures
from verify.states.shares import SAMPLES, violating
from verify.states.state import sample
from verify.subjects import Game

EPISODES, SAMPLE_SEEDS = 4_000, (41, 42, 43)
DEMO = {"iterations": demo.ITERATIONS, "rollouts": demo.ROLLOUTS, "refinement": demo.REFINEMENT}
DEMO |= {"selection_episodes": demo.SELECTION_EPISODES}
REACH, STRETCH = 0.25, 0.1  # of the violating share that the first round leaves


def share(profile, claim):
    """The share of uniform states of the start region in which the claim fails."""
    found = [
        violating(from_start(profile, claim), sample(everywhere(profile), profile.world, SAMPLES, seed)[0])
        for seed in SAMPLE_SEEDS
    ]
    return float(np.concatenate(found).mean())


def row(kind, first, profile, claim, player, seconds, states):
    world = matching_world(profile)
    cost = comparison.measure_cost(first, profile, claim.team, everywhere(profile), world, player, EPISODES)
    sizes = comparison.sizes(profile, [policy.agent for policy in profile.team(claim.team)])
    return {
        "kind": kind,
        "violating": share(profile, claim),
        "success": cost.compared[0].after.value,
        "changed": cost.met.value,
        "leaves": sum(size["leaves"] for size in sizes.values()),
        "depth": max(size["depth"] for size in sizes.values()),
        "states": states,
        "seconds": seconds,
    }


def one(name, prop, rounds, given):
    """The rows of one extraction seed."""
    expert, world = find_expert(name)
    player = Player(name, EXPERT, expert.hash, expert)
    settings = Settings.of(given)
    started = time.perf_counter()
    first = profile = extract(world, expert, settings)
    claim = find_property(prop, first)
    region = everywhere(first)
    found = [row("extracted", first, first, claim, player, time.perf_counter() - started, 0)]
    with tempfile.TemporaryDirectory() as folder:
        paths = []
        for number in range(1, rounds + 1):
            started = time.perf_counter()
            points = failures(Question(Game(profile), claim, region))
            if points:
                paths.append(Path(folder) / f"states-{number}.json")
                paths[-1].write_text(document_of(profile, claim, region, points, f"maviper verify x --property {prop}"))
            task = refitting.task_of(paths, world, expert, Console(quiet=True))
            profile = extract(world, expert, settings, examples=task.examples) if points else profile
            seconds = time.perf_counter() - started
            found.append(row(f"round {number}", first, profile, claim, player, seconds, len(points)))
    started = time.perf_counter()
    mended = repair(Question(Game(first), claim, region), collect_states(first, world))
    kind = "repaired" if mended.ended else "repair did not end"
    return [*found, row(kind, first, mended.profile, claim, player, time.perf_counter() - started, mended.rounds)]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("expert", nargs="?", default="physical-deception")
    parser.add_argument("--seeds", type=int, default=None)
    parser.add_argument("--rounds", type=int, default=2)
    parser.add_argument("--property", default="distinct_targets", choices=("distinct_targets", "own_target"))
    parser.add_argument("--max-depth", type=int, default=4)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--full", action="store_true")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    seeds = range(options.seeds or (5 if options.full else 2))
    size = {"max_depth": options.max_depth, **({} if options.full else DEMO)}
    tasks = [(options.expert, options.property, options.rounds, {**size, "seed": seed}) for seed in seeds]
    runs = list(side_by_side(one, tasks, options.jobs))
    if not options.json:
        print(f"{'':<12}{'violating %':>12}{'success':>9}{'changed':>9}{'leaves':>8}{'depth':>7}{'states':>8}{'s':>7}")
    for place, first in enumerate(runs[0]):
        rows = [run[place] for run in runs]
        mean = {key: float(np.mean([each[key] for each in rows])) for key in first if key != "kind"}
        kinds = {each["kind"] for each in rows}
        each = "  ".join(f"{100 * one['violating']:.4f}" for one in rows)
        if not options.json:
            print(
                f"{'/'.join(sorted(kinds)):<12}{100 * mean['violating']:>12.4f}{mean['success']:>9.4f}"
                f"{mean['changed']:>9.3f}{mean['leaves']:>8.1f}{mean['depth']:>7.1f}{mean['states']:>8.0f}"
                f"{mean['seconds']:>7.1f}   {each}"
            )
    before, after = (float(np.mean([run[place]["violating"] for run in runs])) for place in (0, 1))
    left = after / before if before else 0.0
    figure = {"name": "violating share that one round leaves", "value": left, "reach": REACH, "stretch": STRETCH}
    if options.json:
        print(json.dumps({"figures": [{**figure, "better": "lower"}], "runs": runs}))
    else:
        print(f"{figure['name']}: {left:.3f} of what it was (reach {REACH}, stretch {STRETCH})")


if __name__ == "__main__":
    main()
