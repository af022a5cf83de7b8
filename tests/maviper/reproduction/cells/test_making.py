"""What cells of several profiles play, and how often."""

import csv
import io
from dataclasses import replace
from itertools import product

import pytest

from codegen import policy_json
from maviper.episodes import measures
from maviper.episodes.play import tree_policies
from maviper.experts.finding import find_expert
from maviper.reproduction.cells import making
from maviper.reproduction.cells.cell import CROSSPLAY, DONE, Cell, Source, Task

GAME = "physical-deception"
CELL = Cell(CROSSPLAY, GAME, "mappo", "paper", "", 4, 0, "histogram", 1)
TASK = Task(CELL, Source(GAME, world=GAME), "e" * 64, "")


def rows(made):
    assert made.document.outcome == DONE, made.document.message
    return list(csv.DictReader(io.StringIO(made.files["episodes.csv"].decode())))


def means(made):
    found = {}
    for row in rows(made):
        found.setdefault((row["lineup"], row["measure"]), []).append(float(row["value"]))
    return {key: sum(values) / len(values) for key, values in found.items()}


@pytest.fixture
def data(profile):
    return policy_json.dumps(profile).encode()


def test_everybody_meets_everybody_and_each_line_up_is_played_once(data, monkeypatch):
    played = []
    real = measures.values
    monkeypatch.setattr(measures, "values", lambda *given: played.append(given) or real(*given))
    made = making.make_cell(replace(TASK, of={"maviper": "a", "iviper": "b"}), {"maviper": data, "iviper": data})
    players = ("maviper", "iviper", "expert")
    named = {f"{team}:{a}-vs-{b}" for team in ("adversaries", "defenders") for a, b in product(players, players)}
    found = means(made)
    assert {lineup for lineup, _ in found} == named and len(played) == len(players) ** 2
    assert len(rows(made)) == len(named) * 3 * 200
    assert {int(row["episode"]) for row in rows(made)} == set(CELL.episodes)
    for lineup, measure in found:  # a team's own measures only
        assert measure.startswith(lineup.partition(":")[0])


def test_a_team_of_trees_meets_the_opponents_that_the_line_up_names(data, profile):
    found = means(making.make_cell(replace(TASK, of={"maviper": "a"}), {"maviper": data}))
    expert, world = find_expert(GAME)
    ours = tree_policies(profile.agents)
    lineup = [expert, ours, ours]  # one adversary, two defenders
    for measure, values in measures.values(world, lineup, CELL.episodes).items():
        name = {"defenders": "defenders:maviper-vs-expert", "adversaries": "adversaries:expert-vs-maviper"}
        assert found[name[measure.team], measure.label] == pytest.approx(values.mean())
