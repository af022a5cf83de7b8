"""Where joint extraction helps: the six rungs from IVIPER to MAVIPER and beyond, over experts, depths and seeds.

    python -m tests.benchmarks.joint [--plan | --quick | --pilot | --report]
        [--worlds deception,navigation,coordination] [--experts clone,reward,roles=RUN,...] [--protocols equal,paper]
        [--cells FOLDER] [--jobs 1] [--json]

The plan stands in joint.toml: what is compared, by which statistic and with which words. --plan prints it with the
number of cells. Every cell is a file in the folder, so an interrupted run goes on where it was, and the tables at the
end are of what is there. --report plays nothing. --experts chooses experts by label, and says where one lies that the
plan does not name. --pilot: three seeds, for the effect that can be seen. --quick: a few small cells, in minutes.
"""

import argparse
import hashlib
import json
import sys
import time
import tomllib
from dataclasses import asdict
from itertools import pairwise, product
from pathlib import Path

import numpy as np

from codegen.errors import MaviperError
from maviper.episodes import measures
from maviper.evaluation.held_out import read_measure
from maviper.experts.finding import find_expert
from maviper.extraction.algorithms import extract
from maviper.extraction.settings import RUNGS, Settings
from maviper.files import runs
from maviper.files.jobs import side_by_side
from maviper.files.profiles import version
from maviper.worlds import find
from tests.benchmarks.paired import Paired, detectable, verdicts
from tests.benchmarks.registered import with_early_stop
from tests.support.optimum import optimum, rules_of, worth

PLAN_FILE = Path(__file__).with_suffix(".toml")
FULL, PILOT, QUICK = "full", "pilot", "quick"
EQUAL, PAPER = "equal", "paper"
COORDINATION = "coordination"
FOLDER = Path("/tmp/maviper-joint")
MAX_CELL_BYTES = 2**20


def read_plan():
    """The plan, and its hash."""
    data = PLAN_FILE.read_bytes()
    return tomllib.loads(data.decode()), hashlib.sha256(data).hexdigest()


# --- experts


def experts_of(plan, label, asked):
    """(expert's label, where it lies) for a world of the plan. `asked`: label -> where, or "" for the plan's."""
    known = plan["worlds"][label]["experts"]
    chosen = {name: where for name, where in asked.items() if name in known} if asked else dict.fromkeys(known, "")
    return [(name, where or known[name]) for name, where in chosen.items()]


def present(plan, labels, asked):
    """(world, expert) -> (where, the expert's hash, the world's name); one that cannot be had is said to be missing."""
    found = {}
    for label in labels:
        for name, where in experts_of(plan, label, asked):
            try:
                if not where:
                    raise FileNotFoundError(f"give --experts {name}=FILE")
                expert, world = find_expert(where)
                if world.spec.name != plan["worlds"][label]["game"]:
                    raise FileNotFoundError(f"it plays {world.name}")
            except (MaviperError, OSError) as error:
                print(f"missing   {label} {name}: {str(error).splitlines()[0]}", flush=True)
                continue
            found[label, name] = where, expert.hash, world.name
    return found


# --- cells


def cells_of(plan, experts, form, protocols):
    """(world, expert, protocol, depth, rung, seed), all of one seed before the next."""
    found = []
    for label, expert in experts:
        grids = plan["worlds"][label]["grids"]
        chosen = {form: grids[form]} if form != FULL else {name: grids[name] for name in protocols if name in grids}
        for name, grid in chosen.items():
            protocol = EQUAL if name == PILOT else name
            found += [
                (label, expert, protocol, depth, rung, seed)
                for seed, depth, rung in product(grid["seeds"], grid["depths"], plan["rungs"])
            ]
    return sorted(found, key=lambda cell: cell[5])


def place_of(folder, cell):
    label, expert, protocol, depth, rung, seed = cell
    return folder / label / f"{expert}.{protocol}.depth-{depth}.{rung}.seed-{seed}.json"


def settings_of(plan, world, cell):
    label, _, protocol, depth, rung, seed = cell
    given = {**plan["protocols"][protocol], "refinement": None, "measure": plan["worlds"][label]["measure"]}
    given = {**given, "max_depth": depth, "seed": seed, **RUNGS[rung]}
    if "budget" not in given:
        given["refinement"] = 0
    return Settings.of(with_early_stop(given), world)


def play(cell, where, digest, plan_hash, folder):
    """Makes one cell, unless it is there already."""
    place = place_of(folder, cell)
    if place.exists():
        checked(place, plan_hash, digest)
        return
    plan, _ = read_plan()
    expert, world = find_expert(where)
    settings = settings_of(plan, world, cell)
    started = time.process_time()
    profile = extract(world, expert, settings)
    seconds = time.process_time() - started
    told = profile.provenance
    document = {
        "plan": plan_hash,
        "expert": digest,
        "world": world.name,
        "tool": told.tool,
        "settings": asdict(settings.deal_budget(world)),
        "training": dict(told.training),
        "evaluation": dict(told.evaluation),
        "seconds": round(seconds, 3),
    }
    runs.write(place, runs.as_json(document))


def checked(place, plan_hash, digest=None):
    """A cell's document; the benchmark ends where it is of another plan or another expert."""
    document = json.loads(runs.read(place, MAX_CELL_BYTES))
    if document["plan"] != plan_hash or (digest is not None and document["expert"] != digest):
        raise SystemExit(f"{place} is of another plan or expert: choose another folder with --cells")
    return document


def value_of(plan, label, document):
    """The joint ratio to the expert of the team that has to coordinate, higher being better."""
    asked = plan["worlds"][label]
    world = find(document["world"])
    measure = next(each for each in world.measures if (each.team, each.name) == (asked["team"], asked["measure"]))
    found = measures.ratio(measure, *read_measure(document["evaluation"], measure))
    return float("nan") if found is None else found


# --- coordination games


def games_of(plan, form):
    asked = plan[COORDINATION]
    small = asked["quick"] if form == QUICK else {}
    told = {name: small.get(name, asked[name]) for name in ("games", "agents", "depths", "tables")}
    return list(product(told["games"], told["agents"], told["depths"], [told["tables"]]))


def place_of_game(folder, cell):
    game, agents, depth, tables = cell
    return folder / COORDINATION / f"{game.replace('=', '-')}.agents-{agents}.depth-{depth}.tables-{tables}.json"


def play_game(cell, plan_hash, folder):
    """Makes the cell of a game, all tables and rungs, unless it is there already."""
    game, agents, depth, tables = cell
    place = place_of_game(folder, cell)
    if place.exists():
        checked(place, plan_hash)
        return
    plan, _ = read_plan()
    asked = plan[COORDINATION]
    best, gaps = [], {rung: [] for rung in plan["rungs"]}
    seconds = {rung: [] for rung in plan["rungs"]}
    for table in range(tables):
        expert, world = find_expert(f"{asked['world']},agents={agents},{game},table={table}")
        best.append(optimum(world, depth).worth)
        for rung in plan["rungs"]:
            settings = Settings.of({**asked["settings"], "max_depth": depth, "seed": table, **RUNGS[rung]}, world)
            started = time.process_time()
            profile = extract(world, expert, settings)
            seconds[rung].append(round(time.process_time() - started, 4))
            gaps[rung].append(best[-1] - worth(world, rules_of(world, profile.agents)))
    document = {"plan": plan_hash, "tool": f"maviper {version()}", "optimum": best, "gaps": gaps, "seconds": seconds}
    runs.write(place, runs.as_json(document))


# --- tables


class Found:
    """The values of the cells that are there."""

    def __init__(self, plan, plan_hash, folder, cells):
        self.plan, self.values, self.seconds = plan, {}, {}
        for cell in cells:
            place = place_of(folder, cell)
            if place.exists():
                document = checked(place, plan_hash)
                self.values[cell] = value_of(plan, cell[0], document)
                self.seconds[cell] = document["seconds"]

    def by_seed(self, label, expert, protocol, rung, depths, seeds):
        """Seed -> the mean over depths, of the seeds that are whole."""
        found = {}
        for seed in seeds:
            cells = [(label, expert, protocol, depth, rung, seed) for depth in depths]
            if all(cell in self.values for cell in cells):
                found[seed] = float(np.mean([self.values[cell] for cell in cells]))
        return found

    def paired(self, label, expert, protocol, pair, depths, seeds):
        """The second rung less the first, by seed."""
        below, above = (self.by_seed(label, expert, protocol, rung, depths, seeds) for rung in pair)
        return Paired(tuple(above[seed] - below[seed] for seed in seeds if seed in above and seed in below))


def said(name, comparison, planned, word):
    """One line of a comparison."""
    count = len(comparison.differences)
    if not count:
        return f"  {name:<44}{'no pair yet':>12}"
    low, high = comparison.interval()
    told = word if count >= planned else f"{count} of {planned} seeds"
    return f"  {name:<44}{comparison.mean:>+9.3f}   [{low:+.3f}, {high:+.3f}]   {told}"


def say_family(plan, title, named, planned):
    """Comparisons of one family with their words; name -> comparison."""
    print(title)
    whole = {name: each for name, each in named.items() if len(each.differences) >= planned[name]}
    words = dict(zip(whole, verdicts(list(whole.values()), plan["alpha"], plan["margin"]), strict=True))
    if len(whole) < len(named):
        words = dict.fromkeys(named, "the family is not whole: no word")
    for name, each in named.items():
        print(said(name, each, planned[name], words.get(name, "")))


def grid_of(plan, label, protocol, form):
    return plan["worlds"][label]["grids"].get(form if form != FULL else protocol)


def say_means(plan, found, experts, form, protocols):
    """Means over seeds of the joint ratio, a row for each depth."""
    for (label, expert), protocol in product(experts, protocols):
        grid = grid_of(plan, label, protocol, form)
        if grid is None:
            continue
        columns = "".join(f"{rung:>18}" for rung in plan["rungs"])
        print(
            f"\n{label}, {expert}, protocol {protocol}: mean joint ratio to the expert (seeds)\n{'depth':>7}{columns}"
        )
        for depth in grid["depths"]:
            row = f"{depth:>7}"
            for rung in plan["rungs"]:
                values = found.by_seed(label, expert, protocol, rung, [depth], grid["seeds"]).values()
                row += f"{np.mean(list(values)):>13.3f} ({len(values)})".rjust(18) if values else f"{'-':>18}"
            print(row)


def say_comparisons(plan, found, experts, protocols):
    """The primary family, then each world's and expert's."""
    primary, planned = {}, {}
    for label, expert in experts:
        grid = grid_of(plan, label, EQUAL, FULL)
        name = f"{label}, {expert}"
        primary[name] = found.paired(label, expert, EQUAL, plan["primary"], grid["depths"], grid["seeds"])
        planned[name] = len(grid["seeds"])
    if primary and EQUAL in protocols:
        say_family(plan, "\nprimary: vote-N-1 less iviper, equal episodes, mean over depths", primary, planned)
    for (label, expert), protocol in product(experts, protocols):
        grid = grid_of(plan, label, protocol, FULL)
        if grid is None:
            continue
        named = {
            f"{above} less {below}": found.paired(
                label, expert, protocol, (below, above), grid["depths"], grid["seeds"]
            )
            for below, above in pairwise(plan["rungs"])
        }
        title = f"\nsecondary: {label}, {expert}, protocol {protocol}, mean over depths"
        say_family(plan, title, named, dict.fromkeys(named, len(grid["seeds"])))


def say_effect(plan, found, experts):
    """What ten seeds can see, by the deviation of the pilot's differences."""
    print("\nthe effect that the full form sees with power .8, by the pilot's deviation between seeds")
    pairs = [tuple(plan["primary"]), *pairwise(plan["rungs"])]
    for (label, expert), (below, above) in product(experts, pairs):
        grid, full = (plan["worlds"][label]["grids"][form] for form in (PILOT, EQUAL))
        each = found.paired(label, expert, EQUAL, (below, above), grid["depths"], grid["seeds"])
        if len(each.differences) < 2:
            continue
        family = len(experts) if (below, above) == tuple(plan["primary"]) else len(plan["rungs"]) - 1
        effect = detectable(each.deviation, len(full["seeds"]), plan["alpha"] / family, plan["power"])
        reach = "within the margin" if effect <= plan["margin"] else "beyond the margin"
        name = f"{label}, {expert}: {above} less {below}"
        print(f"  {name:<60}deviation {each.deviation:.3f}   effect {effect:.3f} at first step of Holm, {reach}")


def say_games(plan, plan_hash, folder, form):
    """The optimality gap of each rung, and what is decided."""
    documents = {}
    for cell in games_of(plan, form):
        place = place_of_game(folder, cell)
        if place.exists():
            documents[cell] = checked(place, plan_hash)
    if not documents:
        return
    rungs = plan["rungs"]
    for depth in dict.fromkeys(cell[2] for cell in documents):
        columns = "".join(f"{rung:>18}" for rung in rungs)
        print(f"\ncoordination, depth {depth}: mean gap to the optimum\n{'game':<16}{'N':>3}{'optimum':>9}{columns}")
        for cell, document in documents.items():
            if cell[2] == depth:
                gaps = "".join(f"{np.mean(document['gaps'][rung]):>18.3f}" for rung in rungs)
                print(f"{cell[0]:<16}{cell[1]:>3}{np.mean(document['optimum']):>9.3f}{gaps}")
    spent = {rung: [s for each in documents.values() for s in each["seconds"][rung]] for rung in rungs}
    print(
        "milliseconds per run (CPU, median): " + ", ".join(f"{r} {1000 * np.median(s):.0f}" for r, s in spent.items())
    )
    if form == FULL:
        say_game_families(plan, documents)


def gap_pairs(plan, documents, game, depth, pair):
    """By table, the gap of the first rung less that of the second, averaged over team sizes."""
    sizes = [(game, agents, depth, plan[COORDINATION]["tables"]) for agents in plan[COORDINATION]["agents"]]
    if not all(cell in documents for cell in sizes):
        return Paired(())
    below, above = (np.mean([documents[cell]["gaps"][rung] for cell in sizes], axis=0) for rung in pair)
    return Paired(tuple((below - above).tolist()))


def say_game_families(plan, documents):
    asked = plan[COORDINATION]
    depth = asked["primary_depth"]
    named = {game: gap_pairs(plan, documents, game, depth, plan["primary"]) for game in asked["games"]}
    title = f"\nprimary: by how much vote-N-1 is nearer to the optimum than iviper, depth {depth}, mean over team sizes"
    say_family(plan, title, named, dict.fromkeys(named, asked["tables"]))
    for game, depth in product(asked["games"], asked["depths"]):
        named = {
            f"{above} less {below}": gap_pairs(plan, documents, game, depth, (below, above))
            for below, above in pairwise(plan["rungs"])
        }
        say_family(plan, f"\nsecondary: {game}, depth {depth}", named, dict.fromkeys(named, asked["tables"]))


# --- the command


def say_plan(plan, plan_hash):
    """The plan's text, and how many cells each form has."""
    print(PLAN_FILE.read_text())
    print(f"sha256 {plan_hash}")
    for form in (FULL, PILOT, QUICK):
        for label, asked in plan["worlds"].items():
            cells = cells_of(plan, [(label, name) for name in asked["experts"]], form, (EQUAL, PAPER))
            print(f"{form:<6} {label:<13} {len(cells):>5} cells with every expert")
        if form != PILOT:
            print(f"{form:<6} {COORDINATION:<13} {len(games_of(plan, form)):>5} cells, all rungs and tables in each")


def options_of():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    for form in ("plan", QUICK, PILOT, "report"):
        parser.add_argument(f"--{form}", action="store_true")
    parser.add_argument("--worlds", default=f"deception,navigation,{COORDINATION}")
    parser.add_argument("--experts", default="")
    parser.add_argument("--protocols", default=f"{EQUAL},{PAPER}")
    parser.add_argument("--cells", type=Path, default=FOLDER)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--json", action="store_true")
    return parser.parse_args()


def main() -> None:
    options = options_of()
    plan, plan_hash = read_plan()
    if options.plan:
        say_plan(plan, plan_hash)
        return
    form = QUICK if options.quick else PILOT if options.pilot else FULL
    worlds = options.worlds.split(",")
    asked = dict(item.partition("=")[::2] for item in options.experts.split(",")) if options.experts else {}
    experts = present(plan, [label for label in worlds if label in plan["worlds"]], asked)
    protocols = options.protocols.split(",") if form == FULL else [EQUAL if form == PILOT else QUICK]
    cells = cells_of(plan, experts, form, protocols)
    games = games_of(plan, form) if COORDINATION in worlds and form != PILOT else []
    if not options.report:
        tasks = [(cell, *experts[cell[:2]][:2], plan_hash, options.cells) for cell in cells]
        played = [(game, plan_hash, options.cells) for game in games]
        watched("game", side_by_side(play_game, played, options.jobs), games)
        watched("cell", side_by_side(play, tasks, options.jobs), cells)
    report(plan, plan_hash, options, form, experts, cells, protocols, games)


def watched(what, steps, cells):
    """Goes through the steps, with a live line on a terminal."""
    for number, _ in enumerate(steps):
        if sys.stdout.isatty():
            print(f"\r{what} {number + 1} of {len(cells)}", end="\n" if number + 1 == len(cells) else "", flush=True)


def say_rest(found, pilot, cells):
    """What the cells that are not there will take, by those of the same world, protocol and rung, the pilot's too."""
    spent, rest, unknown = {}, 0.0, 0
    for (label, _, protocol, _, rung, _), seconds in (found.seconds | pilot.seconds).items():
        spent.setdefault((label, protocol, rung), []).append(seconds)
    for cell in cells:
        if cell not in found.values:
            known = spent.get((cell[0], cell[2], cell[4]))
            rest, unknown = rest + (np.mean(known) if known else 0.0), unknown + (not known)
    print(
        f"the others take about {rest / 3600:.1f} core-hours" + (f", but for {unknown} of a new kind" * bool(unknown))
    )


def report(plan, plan_hash, options, form, experts, cells, protocols, games):
    """Tables of the cells that are there; what they took and what the rest will."""
    found = Found(plan, plan_hash, options.cells, cells)
    say_means(plan, found, experts, form, protocols)
    if form == FULL:
        say_comparisons(plan, found, experts, protocols)
    if form == PILOT:
        say_effect(plan, found, experts)
    if games:
        say_games(plan, plan_hash, options.cells, form)
    print(f"\n{len(found.values)} of {len(cells)} cells are there; plan sha256 {plan_hash[:16]}")
    spent = {}
    for (label, _, protocol, depth, rung, _), seconds in found.seconds.items():
        spent.setdefault((label, protocol, depth, rung), []).append(seconds)
    for (label, protocol, depth, rung), seconds in sorted(spent.items()):
        print(f"  {label} {protocol} depth {depth} {rung:<18}{np.mean(seconds):8.1f} CPU seconds per cell")
    pilot = Found(plan, plan_hash, options.cells, cells_of(plan, experts, PILOT, protocols))
    say_rest(found, pilot, cells)
    if options.json:
        figures = [
            {"name": f"{' '.join(map(str, cell))}", "value": value, "better": "higher"}
            for cell, value in found.values.items()
        ]
        print(json.dumps({"figures": figures}))


if __name__ == "__main__":
    main()
