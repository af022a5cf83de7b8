"""Why joint extraction pays (E5): experts whose roles follow from the state in a share of episodes, teams of 2 to 6.

    python -m tests.benchmarks.roles [--plan | --tables] [--cells FOLDER] [--agents N,...] [--seeds N,...] [--json]
        [--record PLACE]

The register stands in roles.toml: cells, predictors, hypotheses. Without an option the missing cells are made, whole
seeds first, then the tables are printed. Every cell is a file in the folder, so an interrupted run goes on. The terms
of a cell are those of `maviper evaluate --why`, for the trees that were extracted one by one. --record writes the
finished cells, the tables and a page into a folder.
"""

import argparse
import hashlib
import json
import time
import tomllib
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from maviper.episodes import measures
from maviper.episodes.trees import among
from maviper.evaluation.crossplay import Cast
from maviper.evaluation.why import causes
from maviper.experts.finding import find_expert
from maviper.extraction.algorithms import extract
from maviper.extraction.settings import Settings
from maviper.files import runs
from maviper.reproduction.statistics import holm, of_differences
from tests.benchmarks import compact
from tests.benchmarks.registered import kept_in

FILE = Path(__file__).with_name("roles.toml")
FOLDER = "/tmp/maviper-roles"
PAGE = """# Why joint extraction pays: roles by state in a share of the episodes

    python -m tests.benchmarks.roles --cells FOLDER --record generated/reproduction/roles

{state} {count} of {total} cells.
Register: tests/benchmarks/roles.toml, sha256 {digest}.
It was committed before the first cell was made.

- `tables.txt`: losses, their terms and gains, then the hypotheses.
- `{file}`: every cell under the name of its file.

To go on, copy `{file}` into FOLDER and run the command: it makes only what is missing.
"""
MAX_CELL_BYTES = 2**20
HOLDS, REFUTED, OPEN = "HOLDS", "REFUTED", "OPEN"
NOTHING_ADDED = "H2b"  # which a slope above 0 refutes, and nothing shows
SECONDS = {2: 9, 3: 13, 4: 20, 6: 40}  # of a cell, by agents: a pilot of seed 999 with three agents, scaled


def read_register():
    """The register, and its hash."""
    data = FILE.read_bytes()
    return tomllib.loads(data.decode()), hashlib.sha256(data).hexdigest()


@dataclass(frozen=True, order=True)
class Cell:
    """One expert, one seed, all ways of extraction."""

    seed: int
    agents: int
    share: str

    @property
    def name(self):
        return f"agents-{self.agents}.share-{self.share}.seed-{self.seed}.json"


def cells_of(register):
    """All cells, whole seeds first."""
    return [Cell(*each) for each in product(register["seeds"], register["agents"], register["shares"])]


def settings_of(register, world, seed, way):
    """What one way of extraction is asked for; the episodes of a round are dealt to all agents."""
    asked, n_agents = register["ways"][way], len(world.agents)
    parts = {"rollouts": "rollouts_by", "selection": "selection_by"}
    dealt = {
        name: register["per_round"][name] // (n_agents if asked[by] == "agent" else 1) for name, by in parts.items()
    }
    given = {**register["settings"], **asked, "seed": seed, "rollouts": dealt["rollouts"]}
    return Settings.of({**given, "selection_episodes": dealt["selection"]}, world).complete().deal_budget(world)


def make(register, digest, cell, folder):
    """Makes one cell: D of each team and of the expert, and the terms of the team that was extracted one by one."""
    started = time.process_time()
    expert, world = find_expert(f"{register['game']},agents={cell.agents}@mixed-roles-{cell.share}")
    measure = next(each for each in world.measures if each.label == register["measure"])
    first = measures.MEASUREMENT_SEEDS + register["episodes"] * cell.seed
    seeds, experts = range(first, first + register["episodes"]), [expert] * len(world.agents)
    told = {"expert": float(measures.values(world, experts, seeds)[measure].mean())}
    terms = {}
    for way in register["ways"]:
        profile = extract(world, expert, settings_of(register, world, cell.seed, way))
        ours = among(world, profile.agents, experts)
        told[way] = float(measures.values(world, ours, seeds)[measure].mean())
        if way == "alone":
            terms = terms_of(world, ours, experts, measure, seeds[: register["why_episodes"]])
    document = {"register": digest, "D": told, "why": terms, "seconds": round(time.process_time() - started, 1)}
    runs.write(folder / cell.name, json.dumps(document, sort_keys=True) + "\n")


def terms_of(world, ours, experts, measure, seeds):
    """Gap, individual, shift and interaction of a team in a measure."""
    alone = {name: [*experts[:place], ours[place], *experts[place + 1 :]] for place, name in enumerate(world.agents)}
    cast = Cast(measure.team, tuple(ours), tuple(experts), alone)
    (found,) = (each for each in causes(world, cast, seeds) if each.measure == measure)
    return {name: getattr(found, name).value for name in ("gap", "individual", "shift", "interaction")}


def found_in(register, digest, folder):
    """The cells that are there, each a file or in a record in the folder."""
    found, kept = {}, kept_in(folder)
    for cell in cells_of(register):
        place = folder / cell.name
        document = json.loads(runs.read(place, MAX_CELL_BYTES)) if place.exists() else kept.get(cell.name)
        if document is not None:
            found[cell] = document
            if document["register"] != digest:
                raise SystemExit(f"{place} is of another register: choose another folder with --cells")
    return found


# --- numbers


def numbers(document):
    """Gains and predictors of a cell, in units of the expert's D."""
    base, reached = document["D"]["expert"], document["D"]
    told = {
        "joint": (reached["alone"] - reached["joint"]) / base,
        "voted": (reached["joint"] - reached["voted"]) / base,
    }
    told["alone"] = reached["alone"] / base - 1
    return told | {name: document["why"][name] / base for name in ("individual", "shift", "interaction")}


def slopes(target, *predictors):
    """Of the least-squares plane with an intercept: one slope for each predictor."""
    rows = np.stack([np.ones(len(target)), *map(np.asarray, predictors)], axis=1)
    return np.linalg.lstsq(rows, np.asarray(target), rcond=None)[0][1:]


def hypotheses(register, found):
    """Name -> the numbers of every whole seed, of which the mean should be above 0 (H2b: not above)."""
    told = {}
    for seed in register["seeds"]:
        mine = {cell: numbers(found[cell]) for cell in cells_of(register) if cell.seed == seed and cell in found}
        if len(mine) < len(register["agents"]) * len(register["shares"]):
            continue
        column = {name: [each[name] for each in mine.values()] for name in ("joint", "voted", "shift", "interaction")}
        both = slopes(column["joint"], column["shift"], column["interaction"])
        seeds = {"H2 joint by shift": both[0], "H2b joint by interaction": both[1]}
        seeds["H3 voted by interaction"] = slopes(column["voted"], column["interaction"])[0]
        for size in register["agents"]:
            of = {cell.share: each for cell, each in mine.items() if cell.agents == size}
            shares = [float(share) for share in of]
            seeds[f"H1 joint by share, {size} agents"] = slopes([each["joint"] for each in of.values()], shares)[0]
            last = of[register["shares"][-1]]
            seeds[f"H4 shift less interaction, {size} agents"] = last["shift"] - last["interaction"]
        for name, value in seeds.items():
            told.setdefault(name, []).append(float(value))
    return told


def table_lines(register, found):
    """Means of every kind of cell, then the hypotheses."""
    lines = [f"{len(found)} of {len(cells_of(register))} cells; all as shares of the expert's D", ""]
    names = ("alone", "individual", "shift", "interaction", "joint", "voted")
    lines.append(f"{'agents':>6}{'share':>7}{'seeds':>6}" + "".join(f"{name:>13}" for name in names))
    for size, share in product(register["agents"], register["shares"]):
        rows = [numbers(document) for cell, document in found.items() if (cell.agents, cell.share) == (size, share)]
        if rows:
            means = "".join(f"{np.mean([row[name] for row in rows]):>13.3f}" for name in names)
            lines.append(f"{size:>6}{share:>7}{len(rows):>6}{means}")
    lines += ["", "alone: what the trees lose that were extracted one by one; joint, voted: what is gained", ""]
    told = hypotheses(register, found)
    whole = bool(told) and len(next(iter(told.values()))) == len(register["seeds"])
    lines.append("hypotheses" if whole else "hypotheses: not every seed is whole, so no word is given yet")
    return [*lines, *words(register, told, whole)]


def words(register, told, whole):
    """A line for each hypothesis: mean, interval, and its word where all seeds are whole."""
    pairs = {name: of_differences(values) for name, values in told.items() if len(values) > 1}
    one_sided = {name: pair.p_above(0.0) for name, pair in pairs.items()}
    adjusted = dict(zip(pairs, holm(list(one_sided.values()), len(pairs)), strict=True)) if pairs else {}
    for name, pair in pairs.items():
        low, high = pair.interval()
        above = adjusted[name] <= register["alpha"]
        holds, refuted = (False, above) if name.startswith(NOTHING_ADDED) else (above, high < 0)
        word = (HOLDS if holds else REFUTED if refuted else OPEN) if whole else "no word yet"
        yield f"  {name}: {pair.value:+.3f} [{low:+.3f}, {high:+.3f}]  {word}"


def recorded(register, digest, found, place):
    """Writes the finished cells, the tables and a page."""
    total = len(cells_of(register))
    state = "The record is whole." if len(found) == total else "**This record is partial.** No hypothesis gets a word."
    page = PAGE.format(state=state, count=len(found), total=total, digest=digest, file=compact.FILE)
    runs.write(place / compact.FILE, compact.packed({cell.name: document for cell, document in found.items()}))
    runs.write(place / "tables.txt", "\n".join(table_lines(register, found)) + "\n")
    runs.write(place / "README.md", page)


def main():
    """Makes what is missing, and prints the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--plan", action="store_true", help="print cells and CPU time")
    parser.add_argument("--tables", action="store_true", help="make nothing")
    parser.add_argument("--cells", type=Path, default=Path(FOLDER), help="where cells lie")
    parser.add_argument("--agents", help="sizes of teams, separated by commas; all others are left for another time")
    parser.add_argument("--seeds", help="likewise")
    parser.add_argument("--record", type=Path, help="where the record is written")
    parser.add_argument("--json", action="store_true", help="print the hypotheses' numbers as one object")
    given = parser.parse_args()
    register, digest = read_register()
    if given.plan:
        total = sum(SECONDS[cell.agents] for cell in cells_of(register))
        print(f"{len(cells_of(register))} cells, {total / 3600:.1f} CPU hours")
        return
    sizes, seeds = ({int(each) for each in text.split(",")} if text else None for text in (given.agents, given.seeds))
    there = found_in(register, digest, given.cells)
    with threadpool_limits(1):
        for cell in cells_of(register) if not given.tables else []:
            wanted = (sizes is None or cell.agents in sizes) and (seeds is None or cell.seed in seeds)
            if wanted and cell not in there:
                make(register, digest, cell, given.cells)
                print(f"{time.strftime('%H:%M:%S')}  {cell.name}", flush=True)
    found = found_in(register, digest, given.cells)
    if given.json:
        told = hypotheses(register, found)
        print(json.dumps({"figures": [{"name": name, "value": float(np.mean(of))} for name, of in told.items()]}))
        return
    print("\n".join(table_lines(register, found)))
    if given.record:
        recorded(register, digest, found, given.record)


if __name__ == "__main__":
    main()
