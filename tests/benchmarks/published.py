"""The paper's comparison as it was published: MAVIPER with all of its rounds, and the authors' released code.

    python -m tests.benchmarks.published [--plan | --tables] [--cells FOLDER] [--groups NAME,...] [--record PLACE]

The register stands in published.toml: claims, cells in the order in which they are made, and their words. --plan prints
it with its cells, CPU time and power. Without an option the missing cells are made, one after the other, then the
tables are printed; --tables only prints. Every cell is a file in the folder, so an interrupted run goes on where it
was. --record writes the finished cells and the tables into a folder.
"""

import argparse
import csv
import hashlib
import io
import json
import lzma
import tarfile
import time
import tomllib
from dataclasses import astuple, dataclass, fields
from functools import cache
from itertools import product
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from maviper.episodes import measures
from maviper.experts.finding import find_expert
from maviper.extraction.algorithms import extract
from maviper.extraction.settings import Settings
from maviper.files import runs
from maviper.files.profiles import version
from maviper.reproduction.cells.cell import EPISODES
from maviper.reproduction.cells.making import replacing
from maviper.reproduction.statistics import holm, of_differences, size, untestable
from maviper.worlds import Measure
from maviper.worlds.world import RETURN
from tests.benchmarks.paired import BETTER, NOT_DECIDED, WORSE, Paired, detectable

REGISTER = Path(__file__).with_suffix(".toml")
FOLDER = Path("/tmp/maviper-published")
ARCHIVE, TABLE, TEXT, README = "cells.tar.xz", "cells.csv", "tables.txt", "README.md"
MAX_CELL_BYTES = 2**22


@cache
def read_register():
    """The register, and its hash."""
    data = REGISTER.read_bytes()
    return tomllib.loads(data.decode()), hashlib.sha256(data).hexdigest()


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
    """The cells of a group, all of one seed before the next."""
    grid = product(register["seeds"], group["experts"], group["depths"], group["algorithms"])
    return [
        Cell(group["game"], expert, group["preset"], algorithm, depth, seed) for seed, expert, depth, algorithm in grid
    ]


@cache
def expert_of(game, label):
    """The shipped expert, and its world."""
    return find_expert(game if label == "mappo" else f"{game}@{label}")


def settings_of(register, world, cell):
    """What the cell's extraction is asked for."""
    given = {**register["presets"][cell.preset], **register["algorithms"][cell.algorithm]}
    given = {name: value[cell.game] if isinstance(value, dict) else value for name, value in given.items()}
    return Settings.of({**given, "max_depth": cell.depth, "seed": cell.seed}, world).checked().resolved(world)


def make(register, digest, cell, folder):
    """Makes one cell."""
    started = time.process_time()
    expert, world = expert_of(cell.game, cell.expert)
    settings = settings_of(register, world, cell)
    profile = extract(world, expert, settings)
    lineups = {name: each for name, each in replacing(world, expert, profile).items() if name != "all"}
    lineups["expert"] = [expert] * len(world.agents), tuple(world.teams)
    values = {}
    for name, (controllers, teams) in lineups.items():
        found = measures.values(world, controllers, cell.episodes)
        values[name] = {each.label: column.tolist() for each, column in found.items() if each.team in teams}
    told = {
        "register": digest,
        "tool": f"maviper {version()}",
        "expert": expert.hash,
        "iterations": settings.iterations,
    }
    told |= {"training": dict(profile.provenance.training), "seconds": round(time.process_time() - started, 1)}
    runs.write(folder / cell.name, json.dumps({**told, "values": values}, sort_keys=True) + "\n")


def made(digest, cell, folder):
    """A cell's document, or None; the benchmark ends where it is of another register."""
    place = folder / cell.name
    if not place.exists():
        return None
    document = json.loads(runs.read(place, MAX_CELL_BYTES))
    if document["register"] != digest:
        raise SystemExit(f"{place} is of another register: choose another folder with --cells")
    return document


# --- numbers


class Found:
    """The cells that are there, and the ratios to the expert."""

    def __init__(self, register, digest, folder):
        self.register = register
        self.documents = {}
        for group in register["groups"]:
            for cell in cells_of(register, group):
                document = made(digest, cell, folder)
                if document:
                    self.documents[cell] = document

    def ratios(self, claim, side, expert, depth):
        """Seed -> the joint ratio of the claim's team to the expert, higher being better."""
        chosen = claim[side]
        found = {}
        for seed in self.register["seeds"]:
            cell = Cell(claim["game"], expert, chosen["preset"], chosen["algorithm"], depth, seed)
            if cell in self.documents:
                found[seed] = ratio(self.documents[cell]["values"], expert_of(cell.game, expert)[1], claim["measure"])
        return found

    def paired(self, claim, expert, depth):
        """The first less the second, by seed."""
        first, second = (self.ratios(claim, side, expert, depth) for side in ("first", "second"))
        return Paired(tuple(first[seed] - second[seed] for seed in first if seed in second))

    def ceiling(self, claim, expert, depth):
        """Whether the second one keeps so much of the expert that a lead over it cannot be seen."""
        values = list(self.ratios(claim, "second", expert, depth).values())
        return len(values) > 1 and untestable(of_differences(values).interval()[0])


def ratio(values, world, label):
    """The team's mean over the expert's in the same episodes; a return is divided by the mean size of the expert's."""
    known = [*world.measures, *(Measure(team, RETURN) for team in world.teams)]
    measure = next(each for each in known if each.label == label)
    ours, theirs = values[f"joint:{measure.team}"][label], values["expert"][label]
    scale = float(np.mean(np.abs(theirs))) if measure.name == RETURN else None
    return float(measures.quotient(measure, float(np.mean(ours)), float(np.mean(theirs)), scale))


def comparisons_of(register):
    """(family, claim, expert, depth) for everything that is compared."""
    return [
        (claim["family"], claim, expert, depth)
        for claim in register["claims"]
        for expert, depth in product(claim["experts"], claim["depths"])
    ]


# --- what is told


def plan_lines(register):
    """The groups with their cells and CPU time, then what each comparison can see."""
    lines = [f"{'cells':>6}{'CPU s':>8}  group"]
    total = 0
    for group in register["groups"]:
        cells = cells_of(register, group)
        rate = sum(group["seconds"][cell.algorithm] for cell in cells)
        lines.append(f"{len(cells):>6}{rate:>8.0f}  {group['name']}")
        total += rate
    lines += [f"{total / 3600:.1f} CPU hours in all, by a pilot of one cell a row", "", "effect seen with power .8"]
    counts = {family: sum(each[0] == family for each in comparisons_of(register)) for family in families(register)}
    for family, claim, expert, depth in comparisons_of(register):
        alpha = register["alpha"] / counts[family]
        seen = detectable(claim["deviation"], len(register["seeds"]), alpha, register["power"])
        lines.append(f"  {seen:.3f} of {claim['effect']:.3f}  {claim['id']}, {expert}, depth {depth}")
    return lines


def families(register):
    return list(dict.fromkeys(claim["family"] for claim in register["claims"]))


def table_lines(register, found):
    """Ratios and rounds of every row, then the comparisons of each family."""
    total = sum(len(cells_of(register, group)) for group in register["groups"])
    lines = [f"{len(found.documents)} of {total} cells", "", "joint ratio to the expert, mean and deviation over seeds"]
    for group in register["groups"]:
        for expert, depth, algorithm in product(group["experts"], group["depths"], group["algorithms"]):
            lines += row_lines(register, found, group, expert, depth, algorithm)
    for family in families(register):
        lines += family_lines(register, found, family)
    return lines


def row_lines(register, found, group, expert, depth, algorithm):
    lines = []
    for label in group["measures"]:
        claim = {"game": group["game"], "measure": label, "row": {"preset": group["preset"], "algorithm": algorithm}}
        values = found.ratios(claim, "row", expert, depth)
        if values:
            numbers = list(values.values())
            spread = f"{np.std(numbers, ddof=1):.3f}" if len(numbers) > 1 else "-"
            name = f"{group['game']} {expert} {group['preset']} {algorithm} depth {depth}: {label}"
            cells = [Cell(group["game"], expert, group["preset"], algorithm, depth, seed) for seed in values]
            rounds = np.median([found.documents[cell]["training"]["stopped_after"] for cell in cells])
            absolute = np.mean([absolute_of(found.documents[cell], label) for cell in cells], axis=0)
            told = f"{absolute[0]:.3f} of {absolute[1]:.3f}, median of {rounds:g} rounds"
            lines.append(f"  {np.mean(numbers):.3f} {spread:>6}  {len(values):>2} seeds  {name}, {told}")
    return lines


def absolute_of(document, label):
    """The team's mean, and the expert's."""
    team = label.partition(" ")[0]
    return [float(np.mean(document["values"][lineup][label])) for lineup in (f"joint:{team}", "expert")]


def family_lines(register, found, family):
    """Comparisons with interval and size; words only once the whole family has all of its seeds."""
    named = [each for each in comparisons_of(register) if each[0] == family]
    pairs = [found.paired(*each[1:]) for each in named]
    whole = all(len(each.differences) == len(register["seeds"]) for each in pairs)
    words = words_of(pairs, register["alpha"], register["margin"]) if whole else [""] * len(pairs)
    lines = ["", f"family {family}" + ("" if whole else ": not whole, so no word is given yet")]
    for (_, claim, expert, depth), pair, word in zip(named, pairs, words, strict=True):
        name = f"{claim['id']}, {expert}, depth {depth}"
        count = len(pair.differences)
        if count < len(register["seeds"]):
            lines.append(f"  {name}: {count} of {len(register['seeds'])} seeds")
            continue
        low, high = pair.interval()
        told = f"{size(claim['effect'], low, high)} against {claim['effect']:g}"
        beside = "; UNTESTABLE by the rule of the ceiling" if found.ceiling(claim, expert, depth) else ""
        lines.append(f"  {name}: {pair.mean:+.3f} [{low:+.3f}, {high:+.3f}]  {word or 'no word yet'}; {told}{beside}")
    return lines


def words_of(pairs, alpha, margin):
    """A word for each comparison of a family. Both tests of all are corrected together, as in verdicts.decided: of the
    two hypotheses of a comparison only one can be true.
    """
    adjusted = holm([p for pair in pairs for p in (pair.p_differs(), pair.p_equal(margin))], len(pairs))
    words = []
    for pair, differs, equal in zip(pairs, adjusted[::2], adjusted[1::2], strict=True):
        told = BETTER if pair.mean > 0 else WORSE
        words.append("EQUAL" if equal <= alpha else told if differs <= alpha else NOT_DECIDED)
    return words


# --- the record


def recorded(register, digest, found, folder, place):
    """Writes the finished cells, a table of their means, the tables and a page."""
    data = io.BytesIO()
    with tarfile.open(fileobj=data, mode="w", format=tarfile.USTAR_FORMAT) as tar:
        for cell in sorted(found.documents):
            content = (folder / cell.name).read_bytes()
            member = tarfile.TarInfo(cell.name)
            member.size = len(content)
            tar.addfile(member, io.BytesIO(content))
    runs.write(place / ARCHIVE, lzma.compress(data.getvalue(), preset=6))
    runs.write(place / TABLE, means(found))
    runs.write(place / TEXT, "\n".join(table_lines(register, found)) + "\n")
    runs.write(place / README, page(register, digest, found))


def means(found):
    """A row for each cell, line-up and measure, as CSV."""
    table = io.StringIO()
    rows = csv.writer(table, lineterminator="\n")
    rows.writerow([*(field.name for field in fields(Cell)), "lineup", "measure", "mean", "rounds"])
    for cell, document in sorted(found.documents.items()):
        for lineup, columns in document["values"].items():
            for label, values in columns.items():
                mean = repr(float(np.mean(values)))
                rows.writerow([*astuple(cell), lineup, label, mean, document["training"]["stopped_after"]])
    return table.getvalue()


def page(register, digest, found):
    """README.md: what is here, what is not yet, and how to go on."""
    lines = []
    for group in register["groups"]:
        cells = cells_of(register, group)
        lines.append(f"| {group['name']} | {sum(cell in found.documents for cell in cells)} of {len(cells)} |")
    total = sum(len(cells_of(register, group)) for group in register["groups"])
    hours = sum(document["seconds"] for document in found.documents.values()) / 3600
    partial = len(found.documents) < total
    state = (
        "**This record is partial.** Families that are not whole get no word." if partial else "The record is whole."
    )
    return f"""# MAVIPER with all of its rounds, and the released code

    python -m tests.benchmarks.published --cells FOLDER --record generated/reproduction/published

{state} {len(found.documents)} of {total} cells, {hours:.1f} core-hours.
Register: tests/benchmarks/published.toml, sha256 {digest}.
It was committed before the first cell was made.

| group | cells |
|---|---|
{chr(10).join(lines)}

- `{TEXT}`: ratios to the expert, then every comparison with its interval and words.
- `{TABLE}`: the mean of every line-up and measure, and the rounds that were played.
- `{ARCHIVE}`: every cell with the value of every episode.

To go on, unpack `{ARCHIVE}` into FOLDER and run the command: it makes only what is missing.
"""


def main():
    """Makes what is missing, and prints the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--plan", action="store_true", help="print cells, CPU time and power")
    parser.add_argument("--tables", action="store_true", help="make nothing")
    parser.add_argument("--cells", type=Path, default=FOLDER, help="where cells lie")
    parser.add_argument("--groups", help="names, separated by commas; all others are left for another time")
    parser.add_argument("--record", type=Path, help="where the record is written")
    given = parser.parse_args()
    register, digest = read_register()
    if given.plan:
        print("\n".join(plan_lines(register)))
        return
    wanted = given.groups.split(",") if given.groups else [group["name"] for group in register["groups"]]
    with threadpool_limits(1):
        for group in register["groups"] if not given.tables else []:
            for cell in cells_of(register, group) if group["name"] in wanted else []:
                if made(digest, cell, given.cells) is None:
                    make(register, digest, cell, given.cells)
                    print(f"{time.strftime('%H:%M:%S')}  {cell.name}", flush=True)
    found = Found(register, digest, given.cells)
    print("\n".join(table_lines(register, found)))
    if given.record:
        recorded(register, digest, found, given.cells, given.record)


if __name__ == "__main__":
    main()
