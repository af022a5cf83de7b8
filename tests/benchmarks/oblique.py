"""What tests of sums do for trees of numbered actions in cooperative navigation.

    python -m tests.benchmarks.oblique [--ways WAY+WAY] [--record FILE] [--journal FOLDER] [--json]

D of trees of 16 leaves, by what they test, and of four leaves by hand. --record FILE keeps the rows in a file of JSON,
measures none that it has, and prints them as the manual's table. --journal FOLDER: extractions that were ended go on.
Physical deception: halves.py.
"""

import argparse
import json
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from codegen import ir
from codegen.deciding import size
from codegen.ir import NO_ACTION, NO_CHILD, NO_FEATURE, GrownTree
from codegen.lowering.deploy import SummedTree
from maviper.episodes.measures import MEASUREMENT_SEEDS, evaluate
from maviper.episodes.play import tree_policies
from maviper.episodes.trees import agent_policies
from maviper.evaluation import held_out
from maviper.experts.expert import Expert
from maviper.experts.finding import find_expert
from maviper.extraction.algorithms import extract
from maviper.extraction.journal import NOTHING_KEPT, Journal
from maviper.extraction.settings import Settings
from maviper.worlds import World, find
from tests.benchmarks.scores import Row, align, find_rows, keep_rows, read_rows
from tests.benchmarks.settled import Settled
from tests.benchmarks.sharing import extract_shared

GAME = "cooperative-navigation"
GROWN: dict[str, Any] = {
    "least_right": "0",
    "weights": "equal",
    "max_leaves": 16,
    "max_depth": 9,
    "iterations": 10,
    "rollouts": 60,
    "selection_episodes": 60,
    "patience": 100,
}
SHARED: dict[str, Any] = {"splits": "sums", "measure": "D"}
REFINED_SUMS = {"splits": "sums", "refinement": 1_500_000, "measure": "D"}


class Way(NamedTuple):
    """How trees of navigation are extracted."""

    settings: Mapping[str, Any]
    features: str = ""  # beyond those that agents observe
    script: str = ""  # in place of the shipped expert
    settled: bool = False  # whether the expert is to think its mates on their landmarks
    shared: bool = False  # whether the first tests share out the landmarks (sharing.py)


TESTED = {
    "single features": Way({"splits": "histogram"}),
    "differences": Way({"splits": "differences"}),
    "sums": Way({"splits": "sums"}),
    "sums, refined": Way(REFINED_SUMS),
    "sums of where agents come to rest": Way({"splits": "sums", "measure": "D"}, "coasting"),
    "sums of where agents come to rest, refined": Way(REFINED_SUMS, "coasting"),
    "sums, mates settled": Way({"splits": "sums", "measure": "D"}, settled=True),
    "sums, mates settled, refined": Way(REFINED_SUMS, settled=True),
    "sums that share out landmarks": Way(SHARED, shared=True),
    "sums that share out landmarks, refined": Way({**SHARED, "refinement": 600_000}, shared=True),
    "sums of where a script with fixed roles comes to rest": Way(
        {"splits": "sums", "measure": "D"}, "coasting", "@fixed-roles"
    ),
}
BY_HAND = "two sums, by hand"
BRAKE = 0.2  # seconds
EPISODES = 400
REACH, STRETCH = 0.8, 0.7  # of D


def measure(way: str, given: Way, expert: Expert, world: World, journal: Journal = NOTHING_KEPT) -> Row:
    """A row of one extraction: D in held-out episodes, and what taught the trees reaches there. Seed 0."""
    held_out.EVALUATION_EPISODES = EPISODES
    started = time.process_time()
    taught, settings = Settled(expert, world) if given.settled else expert, Settings.of(given.settings, world)
    if given.shared:
        profile = extract_shared(world, expert, settings, journal)
    else:
        profile = extract(world, taught, settings, journal=journal)
    reached = profile.provenance.evaluation
    row: Row = {
        "game": GAME,
        "way": way,
        "asked": given.settings["max_leaves"],
        "leaves": [len(ir.leaves(policy.tree)) for policy in profile.agents],
        "numbers": [size(policy) for policy in profile.agents],
        "measure": "D",
        "values": {team: round(float(reached[f"{team} D"]), 3) for team in world.teams},
        "taught_by": {team: round(float(reached[f"{team} expert D"]), 3) for team in world.teams},
        "episodes": EPISODES,
        "seed": 0,
        "expert_sha256": expert.hash,
    }
    told = f"{row['asked']} leaves: {row['values']}, taught by {row['taught_by']}"
    print(f"{GAME}, {way}, {told}, {time.process_time() - started:.0f} CPU s", flush=True)
    return row


def write_trees(world: World) -> list[GrownTree]:
    """Four leaves an agent by hand: agent k steers along the longer axis to landmark k, less BRAKE of its velocity."""
    left, right, down, up = range(1, 5)
    trees: list[GrownTree] = []
    for agent, features in enumerate(world.features):
        names = [feature.name for feature in features]
        tests = np.zeros((2, len(names)), np.float32)
        for axis, signs in (("x", (1.0, 1.0)), ("y", (1.0, -1.0))):
            tests[:, names.index(f"landmark_{agent}_d{axis}")] = signs
            tests[:, names.index(f"v{axis}")] = np.multiply(signs, -BRAKE)
        feature = np.array([len(names), len(names) + 1, len(names) + 1, *[NO_FEATURE] * 4])
        action = np.array([NO_ACTION] * 3 + [left, down, up, right])
        one, other = np.array([1, 3, 5, *[NO_CHILD] * 4]), np.array([2, 4, 6, *[NO_CHILD] * 4])
        trees.append(SummedTree(feature, np.zeros(7), one, other, action, tests, np.zeros((0, 0, len(names) + 1))))
    return trees


def measure_by_hand(record: Path | None) -> Row:
    """The row of trees by hand, as `measure` gives it."""
    for row in find_rows(record, game=GAME, way=BY_HAND):
        return row
    world = find(GAME)
    policies = agent_policies(world, write_trees(world))
    episodes = range(MEASUREMENT_SEEDS, MEASUREMENT_SEEDS + EPISODES)
    players = [tree_policies(policies)] * len(policies)
    (value,) = (each.value for key, each in evaluate(world, players, episodes).items() if key.name == "D")
    row: Row = {
        "game": GAME,
        "way": BY_HAND,
        "asked": 4,
        "leaves": [len(ir.leaves(each.tree)) for each in policies],
    }
    row |= {"numbers": [size(each) for each in policies], "measure": "D", "values": {"agents": round(float(value), 3)}}
    row |= {"taught_by": {}, "episodes": EPISODES, "seed": 0, "expert_sha256": ""}
    print(f"{GAME}, {BY_HAND}: {row['values']}", flush=True)
    keep_rows(record, [row])
    return row


def measure_once(record: Path | None, way: str, given: Way, journal: Journal = NOTHING_KEPT) -> Row:
    """A row as the record has it, for the expert of this way, or measured and kept there."""
    expert, world = find_expert(f"{GAME}{given.script}", "none" if given.script else "learned", features=given.features)
    about = {"game": GAME, "way": way, "asked": given.settings["max_leaves"], "expert_sha256": expert.hash}
    for row in find_rows(record, **about):
        return row
    row = measure(way, given, expert, world, journal.part(way))
    keep_rows(record, [row])
    return row


def compare_tests(record: Path | None, ways: Sequence[str], journal: Journal) -> list[Row]:
    """Figures of D of trees of 16 leaves, by what they test."""
    figures: list[Row] = []
    measure_by_hand(record)
    for name, way in ((name, TESTED[name]) for name in ways):
        row = measure_once(record, name, way._replace(settings={**GROWN, **way.settings}), journal)
        (value,) = row["values"].values()
        told = f"navigation: D at 16 leaves, {name}"
        figures.append({"name": told, "value": value, "reach": REACH, "stretch": STRETCH, "better": "lower"})
    return figures


def table(record: Path) -> list[str]:
    """The lines of a table of a record's rows, as the manual has them."""
    rows = read_rows(record)
    ways = [*TESTED, BY_HAND]
    rows.sort(key=lambda row: (-row["asked"], ways.index(row["way"])))
    teams = list(rows[0]["values"])
    cells = [("tests", "leaves", "numbers", *(f"{team}, {rows[0]['measure']} (of what taught it)" for team in teams))]
    for row in rows:
        taught = {team: f" ({value:.3f})" for team, value in row["taught_by"].items()}
        reached = (f"{row['values'][team]:.3f}{taught.get(team, '')}" for team in teams)
        cells.append((row["way"], str(row["asked"]), ", ".join(map(str, row["numbers"])), *reached))
    return align(cells)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--ways", help="several with +", default="+".join(TESTED))
    parser.add_argument("--record", type=Path)
    parser.add_argument("--journal", type=Path)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    figures = compare_tests(options.record, options.ways.split("+"), Journal(options.journal))
    if options.record:
        print("\n".join(table(options.record)))
    if options.json:
        print(json.dumps({"figures": figures}))


if __name__ == "__main__":
    main()
