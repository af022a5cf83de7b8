"""generated/continuous/: scores of trees with numbers and sums, and the manual's tables of them."""

import json
import re
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest

from codegen import ir
from maviper.episodes.trees import agent_policies
from maviper.evaluation import held_out
from maviper.worlds import find
from tests.benchmarks import continuous, gaussian, oblique
from tests.benchmarks.scores import find_rows, keep_rows
from tests.benchmarks.settled import Settled

ROOT = Path(__file__).parent.parent
RECORD = ROOT / "generated/continuous/scores.json"
ROWS = json.loads(RECORD.read_text())


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row['game']} {row['asked']} {row['way']}")
def test_a_score_is_that_of_its_returns(row):
    assert row["way"] in (*continuous.WAYS, *continuous.PLAIN) and row["episodes"] == continuous.EPISODES
    score = (row["return"] - row["random"]) / (row["expert"] - row["random"])
    assert score == pytest.approx(row["score"], abs=1e-3) and row["low"] <= row["score"] <= row["high"]
    assert 1 <= row["leaves"] <= row["asked"] and re.fullmatch(r"[0-9a-f]{64}", row["expert_sha256"])


TEAMS, OBLIQUE = RECORD.with_name("teams.json"), RECORD.with_name("oblique.json")
PAGE = (ROOT / "maviper/manual/extraction.md").read_text()


def test_the_manual_has_the_tables_of_the_records():
    assert "\n".join(continuous.table(RECORD)) in PAGE and "\n".join(gaussian.table(TEAMS)) in PAGE
    for game in {row["game"] for row in json.loads(OBLIQUE.read_text())}:
        assert "\n".join(oblique.table(OBLIQUE, game)) in PAGE


@pytest.mark.parametrize("row", json.loads(TEAMS.read_text()), ids=lambda row: f"{row['team']} {row['way']}")
def test_a_score_of_a_team_is_that_of_its_returns(row):
    assert row["way"] in (*gaussian.TEAM_WAYS, *gaussian.MATES) and row["episodes"] == continuous.EPISODES
    score = (row["return"] - row["random"]) / (row["expert"] - row["random"])
    assert score == pytest.approx(row["score"], abs=2e-3) and row["low"] <= row["score"] <= row["high"]
    assert max(row["leaves"]) <= row["asked"] and re.fullmatch(r"[0-9a-f]{64}", row["expert_sha256"])


def test_rows_of_tests_of_sums_are_of_their_ways():
    for row in json.loads(OBLIQUE.read_text()):
        assert row["way"] in (*oblique.TESTED, oblique.BY_HAND) and max(row["leaves"]) <= row["asked"]
        assert row["way"] == oblique.BY_HAND or row["values"].keys() == row["taught_by"].keys()


def test_trees_by_hand_steer_along_the_longer_axis_less_what_brakes():
    world = find("cooperative-navigation")
    obs = np.random.default_rng(0).normal(size=(500, len(world.features[1]))).astype(np.float32)
    policy = agent_policies(world, oblique.write_trees(world))[1]
    names = [feature.name for feature in world.features[1]]
    ahead = [obs[:, names.index(f"landmark_1_d{axis}")] - 0.2 * obs[:, names.index(f"v{axis}")] for axis in "xy"]
    across = np.abs(ahead[0]) > np.abs(ahead[1])
    wanted = np.where(across, np.where(ahead[0] > 0, "right", "left"), np.where(ahead[1] > 0, "up", "down"))
    named = [action.name for action in world.actions[1]]
    assert [named[action] for action in ir.act(policy, obs)] == wanted.tolist()


class Seen:
    """What an expert is shown."""

    def act(self, agents, observations, state):
        return observations


def test_a_settled_expert_is_shown_its_mates_on_their_landmarks_and_nothing_else_is_changed():
    world = find("cooperative-navigation")
    shown = [np.arange(len(features), dtype=np.float32)[None] for features in world.features]
    for agent, seen in enumerate(Settled(cast("Any", Seen()), world).act(range(3), shown, None)):
        names = [feature.name for feature in world.features[agent]]
        value = dict(zip(names, seen[0], strict=True))
        for name, number in value.items():
            mate = re.fullmatch(r"agent_(\d)_(d[xy])", name)
            origin = f"landmark_{mate[1]}_{mate[2]}" if mate else name
            assert number == names.index(origin)


def test_known_rows_are_those_of_all_that_is_asked():
    assert find_rows(RECORD, game="Swimmer-v5", asked=64, way="linear leaves", seed=0)
    assert not find_rows(RECORD, game="Swimmer-v5", asked=64, way="linear leaves", seed=1)
    assert not find_rows(None, game="Swimmer-v5")


def test_rows_take_the_place_of_those_of_the_same_question(tmp_path):
    record, row = tmp_path / "deeper" / "rows.json", {**ROWS[0], "score": 0.5, "low": 0.4, "high": 0.6}
    keep_rows(record, ROWS[::-1])
    assert record.read_text() == RECORD.read_text()
    keep_rows(record, [row])
    kept = json.loads(record.read_text())
    assert len(kept) == len(ROWS) and row in kept and ROWS[0] not in kept


@pytest.mark.parametrize(
    ("given", "said"),
    [(["--halves"], "--experts FOLDER measures"), (["--experts", "."], "has no expert of Swimmer-v5: nothing was")],
)
def test_without_an_expert_it_says_that_nothing_was_measured(given, said, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(held_out, "EVALUATION_EPISODES", held_out.EVALUATION_EPISODES)  # which the command lowers
    monkeypatch.setattr("sys.argv", ["continuous", *given, *(["Swimmer-v5"] if len(given) > 1 else [])])
    with pytest.raises(SystemExit) as left:
        continuous.main()
    assert left.value.code not in (0, None)
    assert said in f"{left.value.code}{capsys.readouterr().err}"


def test_a_row_of_another_expert_is_measured_anew(tmp_path, monkeypatch):
    """A record answers for the expert that its hash names alone."""
    record, (row, *_) = tmp_path / "rows.json", (row for row in json.loads(OBLIQUE.read_text()) if row["taught_by"])
    fresh = {**row, "values": {"agents": 9.0}}
    monkeypatch.setattr(oblique, "measure", lambda *_: fresh)
    way = oblique.TESTED[row["way"]]._replace(settings={"max_leaves": row["asked"]})
    for kept, wanted in ((row, row), ({**row, "expert_sha256": "0" * 64}, fresh)):
        keep_rows(record, [kept])
        assert oblique.measure_once(record, row["game"], row["way"], way, row["episodes"]) == wanted
    assert json.loads(record.read_text()) == [fresh]
