"""Registered cells: extractions that a register names before any is made, and the numbers that claims take from them.

Does: reads a register (such as published.toml) with its hash and says its factors as algorithms, makes a cell as a
  file, finds those that there are, each a file or in a record, also in another record, and pairs them by seed, or the
  means of an expert's seeds by expert.
Assumes: a register that stands in this folder.
Does not: print or draw (published.py).
"""

import hashlib
import json
import time
import tomllib
from dataclasses import dataclass
from functools import cache
from itertools import product
from pathlib import Path

import numpy as np

from maviper.episodes import measures
from maviper.experts.finding import find_expert
from maviper.extraction.algorithms import extract
from maviper.extraction.settings import JOINT, PAPER, Settings
from maviper.files import runs
from maviper.files.profiles import version
from maviper.reproduction.cells.cell import EPISODES
from maviper.reproduction.cells.making import replacing
from maviper.reproduction.statistics import of_differences, untestable
from maviper.worlds import Measure, find_built_in
from maviper.worlds.world import RETURN
from tests.benchmarks import compact
from tests.benchmarks.paired import Paired
from tests.benchmarks.trained import find_trained, recipe_of, tree_seeds_of

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
MAX_CELL_BYTES = 2**22
EARLY = 10  # rounds without a gain after which MAVIPER stopped in the preset `paper` when registers were written


@cache
def read_register(name="published"):
    """The register of a name, and its hash."""
    data = (HERE / f"{name}.toml").read_bytes()
    return with_factors(tomllib.loads(data.decode())), hashlib.sha256(data).hexdigest()


def with_factors(register):
    """A register whose factors are said as algorithms, each called by its levels, and whose effects are said as the
    mean of half of these less that of the other half.
    """
    if "factors" not in register:
        return register
    levels = [list(factor) for factor in register["factors"].values()]
    algorithms, signs = {}, {}
    for combined in product(*levels):
        chosen = zip(register["factors"].values(), combined, strict=True)
        name = "-".join(combined)
        algorithms[name] = {**register["base"], **{key: value for of, at in chosen for key, value in of[at].items()}}
        places = [names.index(level) for names, level in zip(levels, combined, strict=True)]
        signs[name] = dict(zip(register["factors"], places, strict=True))
    claims = []
    for claim in register["claims"]:
        if "effect_of" in claim:
            halves = {0: [], 1: []}
            for name, places in signs.items():
                lower = sum(not places[factor] for factor in claim["effect_of"])
                halves[lower % 2].append(name)
            sides = [{"preset": claim["preset"], "algorithm": tuple(halves[half])} for half in (0, 1)]
            claim = {**claim, "first": sides[0], "second": sides[1]}
        claims.append(claim)
    return {**register, "algorithms": {**register.get("algorithms", {}), **algorithms}, "claims": claims}


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
    return sorted(cells, key=lambda cell: group["experts"].index(cell.expert)) if by_expert(register) else cells


@cache
def expert_of(game, label):
    """The shipped expert, and its world."""
    return find_expert(game if label == "mappo" else f"{game}@{label}")


def world_of(register, game, label):
    """What an expert plays; a trained one's run is not asked."""
    return find_built_in(game) if recipe_of(register, label) else expert_of(game, label)[1]


def settings_of(register, world, cell):
    """What the cell's extraction is asked for, with the stop that MAVIPER had in `paper` when it was registered."""
    given = {**register["presets"][cell.preset], **register["algorithms"][cell.algorithm]}
    if given["preset"] == PAPER and given["algorithm"] in JOINT:
        given = {"patience": EARLY, **given}
    given = {name: value[cell.game] if isinstance(value, dict) else value for name, value in given.items()}
    return Settings.of({**given, "max_depth": cell.depth, "seed": cell.seed}, world).complete().deal_budget(world)


def make(register, digest, cell, folder, experts):
    """Makes one cell. `experts`: the folder of trained ones."""
    started = time.process_time()
    trained = recipe_of(register, cell.expert)
    expert, world = find_trained(experts, cell.game, cell.expert) if trained else expert_of(cell.game, cell.expert)
    profile = extract(world, expert, settings_of(register, world, cell))
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
    }
    told |= {"training": dict(profile.provenance.training), "seconds": round(time.process_time() - started, 1)}
    runs.write(folder / cell.name, json.dumps({**told, "values": values}, sort_keys=True) + "\n")


def made(digest, cell, folder):
    """What a cell comes to, from its own file or from the record in the folder, or None; the benchmark ends where it is
    of another register.
    """
    place = folder / cell.name
    document = json.loads(runs.read(place, MAX_CELL_BYTES)) if place.exists() else kept_in(folder).get(cell.name)
    if document and document["register"] != digest:
        raise SystemExit(f"{place} is of another register: choose another folder with --cells")
    return in_compact_form(document, cell) if document and "sha256" not in document else document


def in_compact_form(document, cell):
    """A cell without its episodes."""
    values = document["values"]
    told = {"values": compact.summed_up(values), "sha256": compact.hash_of(compact.table_of(values, cell.episodes[0]))}
    return {**document, **told}


@cache
def kept_in(folder):
    """The cells of a record, by name; none where the folder holds no record."""
    place = folder / compact.FILE
    return compact.unpacked(place)["cells"] if place.exists() else {}


# --- numbers


def cells_of_side(claim, side, expert, depth, seed):
    """The cells of one side of a comparison."""
    names = claim[side]["algorithm"]
    several = names if isinstance(names, tuple) else (names,)
    return [Cell(claim["game"], expert, claim[side]["preset"], name, depth, seed) for name in several]


def beside_of(register):
    """Cells of another record, of the register that it was made by, by cell."""
    other, digest = read_register(register["beside"]["register"])
    if digest != register["beside"]["sha256"]:
        raise SystemExit(f"{register['beside']['register']}.toml is not the register that this one names")
    cells = {cell.name: cell for group in other["groups"] for cell in cells_of(other, group)}
    documents = kept_in(ROOT / register["beside"]["record"])
    wrong = [name for name, document in documents.items() if document["register"] != digest]
    if wrong:
        raise SystemExit(f"{wrong[0]} in {register['beside']['record']} is of another register")
    return {cells[name]: document for name, document in documents.items()}


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
        ensure_same_experts(register, self.documents)
        self.beside = beside_of(register) if "beside" in register else {}

    def document(self, cell):
        """A cell of this register, or of the record beside it; None where it is not made."""
        return self.documents.get(cell) or self.beside.get(cell)

    def ratios(self, claim, side, expert, depth):
        """The joint ratios of the claim's team to the expert, higher being better, as `numbers` has them."""
        return self.numbers(claim, side, expert, depth, lambda values, world: ratio(values, world, claim["measure"]))

    def numbers(self, claim, side, expert, depth, number):
        """Seed -> `number` of a cell's values and world; of several algorithms their mean, once all are there. Of
        several experts: expert -> the mean of its seeds, once all are there.
        """
        if isinstance(expert, tuple):
            by_expert = {each: list(self.numbers(claim, side, each, depth, number).values()) for each in expert}
            whole = len(self.register["seeds"])
            return {each: float(np.mean(numbers)) for each, numbers in by_expert.items() if len(numbers) == whole}
        world, found = world_of(self.register, claim["game"], expert), {}
        for seed in tree_seeds_of(self.register, expert):
            documents = [self.document(cell) for cell in cells_of_side(claim, side, expert, depth, seed)]
            if all(documents):
                found[seed] = float(np.mean([number(document["values"], world) for document in documents]))
        return found

    def paired(self, claim, expert, depth):
        """The first less the second, by seed or, of several experts, by expert."""
        first, second = (self.ratios(claim, side, expert, depth) for side in ("first", "second"))
        return Paired(tuple(first[seed] - second[seed] for seed in first if seed in second))

    def ceiling(self, claim, expert, depth):
        """Whether the second one keeps so much of the expert that a lead over it cannot be seen."""
        values = list(self.ratios(claim, "second", expert, depth).values())
        return len(values) > 1 and untestable(of_differences(values).interval()[0])


def ensure_same_experts(register, documents):
    """SystemExit where cells of one trained expert were made from different networks."""
    hashes = {}
    for cell, document in documents.items():
        if (
            recipe_of(register, cell.expert)
            and hashes.setdefault((cell.game, cell.expert), document["expert"]) != (document["expert"])
        ):
            raise SystemExit(f"{cell.name} is of another network than other cells of {cell.expert}: remove its cells")


def ratio(values, world, label):
    """The team's mean over the expert's in the same episodes; a return is divided by the mean size of the expert's."""
    known = [*world.measures, *(Measure(team, RETURN) for team in world.teams)]
    measure = next(each for each in known if each.label == label)
    ours, theirs = values[f"joint:{measure.team}"][label], values["expert"][label]
    scale = theirs.get("size", abs(theirs["mean"])) if measure.name == RETURN else None
    return float(measures.quotient(measure, ours["mean"], theirs["mean"], scale))


def comparisons_of(register):
    """(family, claim, expert, depth) for everything that is compared; where experts are the units, all of a claim's
    together in place of one.
    """
    return [
        (claim["family"], claim, expert, depth)
        for claim in register["claims"]
        for expert, depth in product(
            [tuple(claim["experts"])] if by_expert(register) else claim["experts"], claim["depths"]
        )
    ]


def by_expert(register):
    """Whether the unit is the expert, in place of the seed."""
    return register.get("unit") == "expert"


def units_of(register, expert):
    """How many units a comparison has: seeds of one expert, or experts."""
    return len(expert) if isinstance(expert, tuple) else len(register["seeds"])
