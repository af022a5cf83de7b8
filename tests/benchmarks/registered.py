"""Registered cells: extractions that a register names before any is made, and experts that are trained for them.

    python -m tests.benchmarks.registered REGISTER --plan
    python -m tests.benchmarks.registered REGISTER --experts RUNS --train
    python -m tests.benchmarks.registered REGISTER --experts RUNS --cells FOLDER [--groups NAME,...] [--record]
    python -m tests.benchmarks.registered REGISTER --cells FOLDER --cell NAME

A register is a file of a record, such as generated/reproduction/experts/learner-experts.toml. --plan prints its cells
and experts with their CPU time. --train trains the experts that are missing, one after the other, and goes on with what
was interrupted. Then the cells are made that neither FOLDER nor the record has, each a file, so that an interrupted run
goes on where it was. --record adds what the finished cells come to to the record's cells.json.xz, in the form of
compact.py, and writes its tables.txt, which the record's own recompute.py prints. --cell makes one cell, and prints the
hash of its episodes beside the recorded one.
"""

import argparse
import hashlib
import json
import subprocess
import sys
import time
import tomllib
from collections import Counter
from dataclasses import dataclass
from functools import cache
from itertools import permutations, product
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from codegen.errors import InputError
from maviper.console import Console
from maviper.episodes import measures
from maviper.episodes.play import rollout
from maviper.experts.finding import find_expert
from maviper.experts.training.train import CARD_FILE, train_expert
from maviper.extraction.algorithms import extract
from maviper.extraction.settings import JOINT, PAPER, Settings
from maviper.files import runs
from maviper.files.profiles import version
from maviper.reproduction.cells.cell import EPISODES
from maviper.reproduction.cells.making import replacing
from tests.benchmarks import compact

ROOT = Path(__file__).parents[2]
RECORDS = ROOT / "generated" / "reproduction"
MAX_CELL_BYTES = 2**22
EARLY = 10  # rounds without a gain after which MAVIPER stopped in the preset `paper` when registers were written
SCRIPT, TABLES = "recompute.py", "tables.txt"


def read_register(place):
    """A register, its combinations of factors said as algorithms, with its hash and its record's folder."""
    data = place.read_bytes()
    register = {"sha256": hashlib.sha256(data).hexdigest(), "folder": place.parent, **tomllib.loads(data.decode())}
    factors, algorithms = register.get("factors", {}), dict(register.get("algorithms", {}))
    for levels in product(*factors.values()) if factors else ():
        chosen = [of[at] for of, at in zip(factors.values(), levels, strict=True)]
        settings = {name: value for one in (register["base"], *chosen) for name, value in one.items()}
        algorithms["-".join(levels)] = settings
    return {**register, "algorithms": algorithms}


# --- experts


def recipe_of(register, label):
    """The recipe and seed of a trained expert's label, None for a shipped expert's."""
    name, _, seed = label.rpartition("-")
    recipe = register.get("trained", {}).get(name)
    return (recipe, int(seed)) if recipe and seed.isdecimal() and int(seed) in recipe["seeds"] else None


def labels_of(register):
    """All trained experts of all recipes."""
    return [f"{name}-{seed}" for name, recipe in register.get("trained", {}).items() for seed in recipe["seeds"]]


def tree_seeds_of(register, expert):
    """The seeds of an expert's trees: each trained expert has its own, and so its own held-out episodes."""
    seeds, labels = register["seeds"], labels_of(register)
    place = labels.index(expert) if expert in labels else 0
    return [seed + place * len(seeds) for seed in seeds]


def runs_of(register, groups):
    """The trained experts that groups play, as (game, label), each once."""
    known = labels_of(register)
    return list(dict.fromkeys((each["game"], label) for each in groups for label in each["experts"] if label in known))


@cache
def expert_of(game, label, run=None):
    """An expert and its world: that of a finished run, or the shipped one."""
    if run is None:
        return find_expert(game if label == "mappo" else f"{game}@{label}")
    if not (run / CARD_FILE).exists():
        raise InputError(f"the expert {label} of {game} is not trained", str(run), "train it first, with --train")
    return find_expert(str(run))


def run_of(folder, game, label):
    """The run folder of a trained expert."""
    return folder / f"{game}.{label}"


def train_missing(register, folder, groups):
    """Trains what is missing in groups; yields the game, the label and the card of each expert."""
    for game, label in runs_of(register, groups):
        recipe, seed = recipe_of(register, label)
        run, options = run_of(folder, game, label), recipe["options"][game]
        resume = runs.holds_run(run)
        yield game, label, train_expert(game, run, Console(quiet=True), **options, seed=seed, resume=resume)


# --- cells


@dataclass(frozen=True, order=True)
class Cell:
    """One extraction."""

    game: str
    expert: str
    preset: str
    algorithm: str
    depth: int
    seed: int

    @property
    def name(self):
        return f"{self.game}.{self.expert}.{self.preset}.{self.algorithm}.depth-{self.depth}.seed-{self.seed}.json"

    @property
    def episodes(self):
        """The held-out episodes of its seed, the same ones for every algorithm, preset and depth."""
        first = measures.MEASUREMENT_SEEDS + EPISODES * self.seed
        return range(first, first + EPISODES)


def cells_of(register, group):
    """The cells of a group: all of one seed before the next or, where the expert is the unit, all of one expert."""
    seeds = {expert: tree_seeds_of(register, expert) for expert in group["experts"]}
    cells = [
        Cell(group["game"], expert, group["preset"], algorithm, depth, seeds[expert][place])
        for place in range(len(register["seeds"]))
        for expert, depth, algorithm in product(group["experts"], group["depths"], group["algorithms"])
    ]
    several = register.get("unit") == "expert"
    return sorted(cells, key=lambda cell: group["experts"].index(cell.expert)) if several else cells


def settings_of(register, world, cell):
    """What the cell's extraction is asked for, with the stop that MAVIPER had in `paper` when it was registered."""
    given = {**register["presets"][cell.preset], **register["algorithms"][cell.algorithm]}
    given = {name: value[cell.game] if isinstance(value, dict) else value for name, value in given.items()}
    if given["preset"] == PAPER and given["algorithm"] in JOINT and "budget" not in given:
        given = {"patience": EARLY, **given}
    return Settings.of({**given, "max_depth": cell.depth, "seed": cell.seed}, world).complete().deal_budget(world)


def make(register, cell, folder, experts):
    """Makes one cell. `experts`: the folder of trained ones."""
    started = time.process_time()
    run = run_of(experts, cell.game, cell.expert) if recipe_of(register, cell.expert) else None
    expert, world = expert_of(cell.game, cell.expert, run)
    profile = extract(world, expert, settings_of(register, world, cell))
    lineups = {name: each for name, each in replacing(world, expert, profile).items() if name != "all"}
    lineups["expert"] = [expert] * len(world.agents), tuple(world.teams)
    values = {}
    for name, (controllers, teams) in lineups.items():
        found = measures.values(world, controllers, cell.episodes)
        values[name] = {each.label: column.tolist() for each, column in found.items() if each.team in teams}
    told = {"register": register["sha256"], "tool": f"maviper {version()}", "expert": expert.hash}
    told |= {"usual": usual_assignment(world, expert, cell)} if register.get("roles") else {}
    told |= {"training": dict(profile.provenance.training), "seconds": round(time.process_time() - started, 1)}
    runs.write(folder / cell.name, json.dumps({**told, "values": values}, sort_keys=True) + "\n")


def usual_assignment(world, expert, cell):
    """The share of the held-out episodes that end in the most frequent assignment of agents to landmarks: the one with
    the least sum of distances.
    """
    (played,) = rollout(world, [expert] * len(world.agents), cell.episodes, keep=False)
    position = np.asarray(played.states[-1].position)
    first, marks = len(world.agents), len(world.spec.landmarks)
    members = [agent for agent in range(first) if world.team_of(world.agents[agent]) in ("defenders", "agents")]
    place = {agent: [position[:, first + mark] - position[:, agent] for mark in range(marks)] for agent in members}
    gaps = {key: [np.hypot(*each.T) for each in of] for key, of in place.items()}
    ways = list(permutations(range(marks), len(members)))
    costs = [sum(gaps[agent][mark] for agent, mark in zip(members, way, strict=True)) for way in ways]
    return Counter(np.argmin(costs, axis=0).tolist()).most_common(1)[0][1] / len(cell.episodes)


def made(register, cell, folder):
    """A cell in compact form, from its own file or from the record, or None. SystemExit where it is of another
    register.
    """
    place = folder / cell.name
    document = json.loads(runs.read(place, MAX_CELL_BYTES)) if place.exists() else kept_in(register).get(cell.name)
    if document and document["register"] != register["sha256"]:
        raise SystemExit(f"{place} is of another register: choose another folder with --cells")
    if document is None or "sha256" in document:
        return document
    values = document["values"]
    told = {"values": compact.summed_up(values), "sha256": compact.hash_of(compact.table_of(values, cell.episodes[0]))}
    return {**document, **told}


def kept_in(register):
    """The cells of the register's record, by name; none where there is none yet."""
    place = register["folder"] / compact.FILE
    return compact.unpacked(place)["cells"] if place.exists() else {}


def record(register, folder):
    """Adds the finished cells to the record, and writes its tables; how many cells the record has now."""
    kept = kept_in(register)
    cells = [cell for group in register["groups"] for cell in cells_of(register, group)]
    finished = {cell.name: made(register, cell, folder) for cell in cells if (folder / cell.name).exists()}
    ensure_same_experts(register, {**kept, **finished}, cells)
    runs.write(register["folder"] / compact.FILE, compact.packed({**kept, **finished}))
    script = [sys.executable, register["folder"] / SCRIPT]
    runs.write(register["folder"] / TABLES, subprocess.run(script, capture_output=True, check=True).stdout)
    return len({**kept, **finished})


def ensure_same_experts(register, documents, cells):
    """SystemExit where cells of one trained expert were made from different networks."""
    hashes = {}
    for cell in cells:
        if cell.name in documents and recipe_of(register, cell.expert):
            network = documents[cell.name]["expert"]
            if hashes.setdefault((cell.game, cell.expert), network) != network:
                raise SystemExit(f"{cell.name} is of another network than other cells of {cell.expert}")


# --- what is told


def plan_lines(register):
    """The groups with their cells and CPU time, and the experts that are trained for them."""
    lines, total = [f"{'cells':>6}{'CPU s':>8}  group"], 0.0
    for group in register["groups"]:
        cells, rates = cells_of(register, group), group["seconds"]
        seconds = sum(rates[cell.algorithm] if isinstance(rates, dict) else rates for cell in cells)
        lines.append(f"{len(cells):>6}{seconds:>8.0f}  {group['name']}")
        total += seconds
    trained = Counter((game, label.rpartition("-")[0]) for game, label in runs_of(register, register["groups"]))
    for (game, name), count in trained.items():
        seconds = register["trained"][name]["seconds"][game] * count
        lines.append(f"{count:>6}{seconds:>8.0f}  experts {name}, {game}")
        total += seconds
    return [*lines, f"{total / 3600:.1f} CPU hours in all, by the register's seconds"]


def again_lines(register, name, folder, experts):
    """Makes one cell, if it is not in the folder; the hash of its episodes, and what the record has."""
    known = {cell.name: cell for group in register["groups"] for cell in cells_of(register, group)}
    if name not in known:
        raise SystemExit(f"no cell of the register is named {name}: copy the name from {compact.FILE}")
    if not (folder / name).exists():
        with threadpool_limits(1):
            make(register, known[name], folder, experts)
    recorded = kept_in(register).get(name, {}).get("sha256", "none")
    return [f"{made(register, known[name], folder)['sha256']}  {name}", f"{recorded}  in the record"]


def main():
    """Plans, trains, makes what is missing, and records."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("register", type=Path)
    parser.add_argument("--plan", action="store_true", help="print cells and CPU time, and make nothing")
    parser.add_argument("--cells", type=Path, default=Path("/tmp/maviper-cells"), help="where cells lie")
    parser.add_argument("--experts", type=Path, default=Path("/tmp/maviper-experts"), help="where their runs lie")
    parser.add_argument("--train", action="store_true", help="train the experts that are missing, and make no cell")
    parser.add_argument("--groups", help="names, separated by commas; all others are left for another time")
    parser.add_argument("--cell", help="the only one that is made, by its name in a record")
    parser.add_argument("--record", action="store_true", help="add the finished cells to the record")
    given = parser.parse_args()
    register = read_register(given.register)
    if given.plan:
        print("\n".join(plan_lines(register)))
        return
    if given.cell:
        print("\n".join(again_lines(register, given.cell, given.cells, given.experts)))
        return
    wanted = given.groups.split(",") if given.groups else [group["name"] for group in register["groups"]]
    groups = [group for group in register["groups"] if group["name"] in wanted]
    if given.train:
        for game, label, card in train_missing(register, given.experts, groups):
            print(f"{time.strftime('%H:%M:%S')}  {game} {label}, {card['seconds']:.0f} s", flush=True)
        return
    with threadpool_limits(1):
        for cell in (cell for group in groups for cell in cells_of(register, group)):
            if made(register, cell, given.cells) is None:
                make(register, cell, given.cells, given.experts)
                print(f"{time.strftime('%H:%M:%S')}  {cell.name}", flush=True)
    if given.record:
        print(f"{record(register, given.cells)} cells in {register['folder']}")


if __name__ == "__main__":
    main()
