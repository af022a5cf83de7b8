"""What trees of fewer leaves return in physical deception once they test sums, beside axis-aligned ones of 64 leaves.

    python -m tests.benchmarks.halves [--record FILE] [--json]

Both teams of the shipped expert are extracted, with the same settings but for tests and leaves, seed 0. A row says
what a team returns against the expert over held-out episodes, the same ones for all: its score (tree - random) /
(expert - random) with the interval of a paired bootstrap, how far that is above the score of the axis-aligned trees of
64 leaves, in the same draws of episodes, and how often the team succeeds. --record FILE keeps the rows in a file of
JSON, and measures none if it has them all of this expert.
"""

import argparse
import json
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from codegen import ir
from codegen.deciding import size
from codegen.ir import Float64
from maviper.episodes import measures
from maviper.episodes.play import Controller, play, tree_policies
from maviper.evaluation import held_out
from maviper.evaluation.crossplay import Uniform
from maviper.experts.expert import Expert
from maviper.experts.finding import find_expert
from maviper.extraction.algorithms import extract
from maviper.extraction.settings import Settings
from maviper.worlds import World
from tests.benchmarks.oblique import GROWN
from tests.benchmarks.scores import Row, align, draw_scores, find_rows, keep_rows, quantiles, tell_score

GAME = "physical-deception"
EPISODES = 1_000
WHOLE, WITHIN = 64, 0.02  # leaves of the axis-aligned trees; of their score
SETTINGS = {**GROWN, "max_depth": 12, "iterations": 5, "rollouts": 40, "selection_episodes": 40}
SPLITS = {"single features": "histogram", "sums": "sums"}
ALIGNED, SUMS = SPLITS
ASKED = ((ALIGNED, WHOLE), (ALIGNED, WHOLE // 2), (SUMS, WHOLE // 2), (ALIGNED, WHOLE // 4), (SUMS, WHOLE // 4))
SUCCESS = "success r=0.316"


def play_team(world: World, subject: Controller, expert: Controller, team: str) -> tuple[Float64, float]:
    """What a team returns in each held-out episode if a subject plays it and the expert everybody else, the mean of its
    agents; and the share of episodes in which it succeeds.
    """
    members = world.members(team)
    players = [subject if agent in members else expert for agent in range(len(world.agents))]
    seeds = range(measures.MEASUREMENT_SEEDS, measures.MEASUREMENT_SEEDS + EPISODES)
    played = play(world, players, world.start_from_seeds(seeds), keep=False)
    success = next(place for place, one in enumerate(world.measures) if (one.team, one.name) == (team, SUCCESS))
    return played.returns[members].mean(axis=0), float(played.values[success].mean())


def measure_all(world: World, expert: Expert) -> list[Row]:
    """A row of each way and team."""
    seeds = range(measures.MEASUREMENT_SEEDS, measures.MEASUREMENT_SEEDS + EPISODES)
    base = {team: play_team(world, expert, expert, team)[0] for team in world.teams}
    chance = {team: play_team(world, Uniform(world).start_episodes(seeds), expert, team)[0] for team in world.teams}
    whole, rows = dict[str, Float64](), list[Row]()
    for tests, leaves in ASKED:
        started = time.process_time()
        settings = Settings.of({**SETTINGS, "splits": SPLITS[tests], "max_leaves": leaves}, world)
        agents = extract(world, expert, settings).agents
        print(f"{tests}, {leaves} leaves: {time.process_time() - started:.0f} CPU s", flush=True)
        for team in world.teams:
            values, share = play_team(world, tree_policies(agents), expert, team)
            drawn = draw_scores(values, base[team], chance[team])
            whole.setdefault(team, drawn)
            figures = dict(zip(("low", "high"), quantiles(drawn), strict=True))
            figures |= dict(zip(("above_low", "above_high"), quantiles(drawn - whole[team]), strict=True))
            figures |= {"expert": base[team].mean(), "random": chance[team].mean(), "return": values.mean()}
            figures["score"] = (values.mean() - chance[team].mean()) / (base[team].mean() - chance[team].mean())
            figures["success"] = share
            members = world.members(team)
            row: Row = {"game": GAME, "team": team, "way": tests, "asked": leaves}
            row["leaves"] = [len(ir.leaves(agents[agent].tree)) for agent in members]
            row["numbers"] = [size(agents[agent]) for agent in members]
            row |= {key: round(float(value), 3) for key, value in figures.items()}
            row |= {"episodes": EPISODES, "seed": 0, "expert_sha256": expert.hash}
            print(f"  {team}: {row['return']:.3f}, score {tell_score(row)}, success {share:.3f}", flush=True)
            rows.append(row)
    return rows


def table(rows: Sequence[Row]) -> list[str]:
    """The lines of a table of the rows, as the manual has them."""
    cells = [("team", "leaves", "tests", "numbers", "return", "score", "above 64 leaves", "success")]
    places = {each: place for place, each in enumerate(ASKED)}
    for row in sorted(rows, key=lambda row: (row["team"], places[row["way"], row["asked"]])):
        above = f"[{row['above_low']:+.3f}, {row['above_high']:+.3f}]" if row["asked"] != WHOLE else ""
        told = f"{row['return']:.2f}", tell_score(row), above, f"{row['success']:.3f}"
        cells.append((row["team"], str(row["asked"]), row["way"], ", ".join(map(str, row["numbers"])), *told))
    return align(cells)


def compare(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """Figures of the lowest score of a team of fewer leaves with sums, above that of the axis-aligned trees."""
    scores = {(row["team"], row["way"], row["asked"]): row["score"] for row in rows}
    teams = {row["team"] for row in rows}
    figures: list[dict[str, Any]] = []
    for leaves in (leaves for tests, leaves in ASKED if tests == SUMS):
        least = min(scores[team, SUMS, leaves] - scores[team, ALIGNED, WHOLE] for team in teams)
        told = f"deception: score at {leaves} leaves with sums, above that at {WHOLE}"
        figures.append({"name": told, "value": round(least, 3), "reach": -WITHIN, "stretch": 0.0, "better": "higher"})
    return figures


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--record", type=Path)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    held_out.EVALUATION_EPISODES = 10  # a profile's own figures are not asked for
    expert, world = find_expert(GAME, "learned")
    rows = find_rows(options.record, game=GAME, expert_sha256=expert.hash)
    if len(rows) < len(ASKED) * len(world.teams):
        rows = measure_all(world, expert)
        keep_rows(options.record, rows)
    print("\n".join(table(rows)))
    figures = compare(rows)
    print("\n".join(f"{each['name']}: {each['value']:+.3f}" for each in figures))
    if options.json:
        print(json.dumps({"figures": figures}))


if __name__ == "__main__":
    main()
