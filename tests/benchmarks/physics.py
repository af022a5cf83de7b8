"""The games by mpe2's physics and by those of the authors' fork: what the same networks reach, and a recipe to train.

    python -m tests.benchmarks.physics [--episodes 2000] [--json]
    python -m tests.benchmarks.physics --train FOLDER [--worlds NAME;...] [--seeds K,...]
    python -m tests.benchmarks.physics --spread FOLDER [--record]
    python -m tests.benchmarks.physics --plan

The first prints the rows of physics.toml: mpe2's physics, accelerations that count twice, velocities that change first,
and both, which is what the option `physics=released` means. Each with the standard error over episodes. The second
trains the experts that physics.toml fixes, seed by seed, one run folder each; finished ones are left alone, begun ones
go on. The third prints what experts reach beside what is published: those whose runs are there, which it plays, and
those of the record, which --record adds to. The last says what the training takes.
"""

import argparse
import json
import tomllib
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np

import maviper
from codegen.dynamics import Motion
from codegen.ir import FORK, PHYSICS
from maviper.episodes import measures
from maviper.experts.finding import find_expert
from maviper.experts.scripted import build_script
from maviper.experts.training.train import CARD_FILE, METRICS_FILE
from maviper.files import runs
from maviper.worlds import find

REGISTER = tomllib.loads(Path(__file__).with_suffix(".toml").read_text())
RECORD = Path(__file__).parents[2] / "generated" / "reproduction" / "physics.json"
FIRST = 13_000_000  # of the held-out episodes; nothing else uses them
VARIANTS = {
    "mpe2": (False, False),
    "accelerations twice": (True, False),
    "velocities first": (False, True),
    "both": (True, True),
}


def moved(name, twice, velocity_first):
    """A world that moves with one of the fork's two differences, with both, or with neither."""
    world = find(name)
    strong = find(f"{name},{PHYSICS}={FORK}").spec.agents if twice else world.spec.agents
    spec = replace(world.spec, agents=strong)
    for quick, motion in ((True, "_quick"), (False, "_exact")):
        vars(world)[motion] = Motion(spec, world.actions, quick, velocity_first)
    return world


def player(text):
    """An expert; a script as it plays by mpe2's physics, for which it was written."""
    name, _, kind = text.partition("@")
    return build_script(find(name)) if kind == "scripted" else find_expert(text)[0]


def row_of(row, episodes):
    """Variant -> the measure's mean and its standard error."""
    team = row["measure"].partition(" ")[0]
    first, second = player(row["first"]), player(row["second"])
    found = {}
    for variant, (twice, velocity_first) in VARIANTS.items():
        world = moved(row["world"], twice, velocity_first)
        controllers = [first if world.team_of(agent) == team else second for agent in world.agents]
        values = measures.values(world, controllers, range(FIRST, FIRST + episodes))
        column = next(column for measure, column in values.items() if measure.label == row["measure"])
        found[variant] = float(np.mean(column)), float(np.std(column, ddof=1) / np.sqrt(len(column)))
    return found


def plan_lines():
    """The experts that are to be trained, with their CPU hours."""
    asked, total, lines = REGISTER["training"], 0.0, [f"{'experts':>7}{'CPU h':>8}  world"]
    for name in asked["worlds"]:
        hours = asked["hours"][name] * len(asked["seeds"])
        lines.append(f"{len(asked['seeds']):>7}{hours:>8.1f}  {name}")
        total += hours
    return [*lines, f"{total:.0f} CPU hours in all, judgements not counted"]


def run_of(folder, name, seed):
    """The run folder of an expert."""
    return folder / f"{name.partition(',')[0]}-{seed}"


def reached_by(folder, episodes):
    """World -> seed -> what the finished experts reach, with their hashes: those of a folder, and of the record."""
    known = json.loads(RECORD.read_text()) if RECORD.exists() else {}
    for name, seed in product(REGISTER["training"]["worlds"], REGISTER["training"]["seeds"]):
        run = run_of(folder, name, seed)
        if (run / CARD_FILE).exists():
            expert, world = find_expert(str(run))
            values = measures.values(world, [expert] * len(world.agents), range(FIRST, FIRST + episodes))
            means = {each.label: float(np.mean(column)) for each, column in values.items()}
            card = json.loads((run / CARD_FILE).read_text())
            told = {"expert": expert.hash, "episodes": episodes, "reached": means, "last": last_of(run)}
            told |= {"card": {name: card[name] for name in ("command", "schedule", "steps", "seconds")}}
            known.setdefault(name, {})[str(seed)] = told
    return {name: dict(sorted(of.items(), key=lambda item: int(item[0]))) for name, of in sorted(known.items())}


def last_of(run):
    """What the networks reached at the end of a training, in the episodes by which its checkpoints were judged."""
    judged = json.loads((run / METRICS_FILE).read_text().splitlines()[-1])
    return {row["measure"]: judged[row["measure"]][0] for row in REGISTER["spread"] if row["measure"] in judged}


def spread_lines(known):
    """Mean, deviation and range over experts, each the best of its checkpoints, beside the mean at the end of training
    and the published number; then each expert's by seed.
    """
    lines = [f"{'experts':>7}{'mean':>8}{'sd':>8}{'least':>8}{'most':>8}{'at end':>8}{'paper':>8}  measure"]
    for row in REGISTER["spread"]:
        reached = {seed: of["reached"][row["measure"]] for seed, of in known.get(row["world"], {}).items()}
        numbers = list(reached.values())
        if not numbers:
            lines.append(f"{0:>7}{'':>48}  {row['world']}: {row['measure']}")
            continue
        spread = np.std(numbers, ddof=1) if len(numbers) > 1 else np.nan  # of one expert there is none
        last = np.mean([of["last"][row["measure"]] for of in known[row["world"]].values()])
        told = "".join(f"{each:>8.3f}" for each in (np.mean(numbers), spread, min(numbers), max(numbers), last))
        paper = f"{row['published']:.2f}" if "published" in row else "-"
        each = ", ".join(f"{seed}: {number:.3f}" for seed, number in reached.items())
        lines.append(f"{len(numbers):>7}{told}{paper:>8}  {row['world']}: {row['measure']} ({each})")
    return lines


def trained(folder, worlds, seeds):
    """Trains what is missing."""
    asked = REGISTER["training"]
    for seed in seeds or asked["seeds"]:
        for name in worlds or asked["worlds"]:
            place = run_of(folder, name, seed)
            if (place / CARD_FILE).exists():
                continue
            maviper.train(
                name,
                place,
                recipe=asked["recipe"],
                seed=seed,
                settings=asked["set"].get(name, {}),
                resume=place.exists(),
            )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--episodes", type=int, default=REGISTER["episodes"])
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--train", type=Path, help="where run folders lie")
    parser.add_argument("--spread", type=Path, help="where run folders lie, whose experts are played")
    parser.add_argument("--record", action="store_true", help=f"keep what they reach in {RECORD.name}")
    parser.add_argument("--plan", action="store_true", help="print what the training takes")
    parser.add_argument("--worlds", default="", help="some of those of physics.toml, separated by semicolons")
    parser.add_argument("--seeds", default="", help="some of those of physics.toml, separated by commas")
    given = parser.parse_args()
    if given.plan:
        print("\n".join(plan_lines()))
        return
    if given.train:
        trained(given.train, [*filter(None, given.worlds.split(";"))], [int(k) for k in given.seeds.split(",") if k])
        return
    if given.spread and given.json:
        parser.error("--spread prints no JSON: choose --record")
    if given.spread:
        known = reached_by(given.spread, given.episodes)
        print("\n".join(spread_lines(known)))
        if given.record:
            runs.write(RECORD, json.dumps(known, indent=1) + "\n")
        return
    table = [{**row, "values": row_of(row, given.episodes)} for row in REGISTER["rows"]]
    if given.json:
        print(json.dumps({"rows": table}, indent=1))
        return
    print("  ".join(f"{name:>20}" for name in VARIANTS))
    for row in table:
        numbers = "  ".join(f"{f'{mean:.3f} +- {error:.3f}':>20}" for mean, error in row["values"].values())
        print(f"{numbers}  {row['measure']}, {row['first']} against {row['second']}")


if __name__ == "__main__":
    main()
