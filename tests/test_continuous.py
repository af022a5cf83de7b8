"""generated/continuous/: scores of trees with numbers and sums, and the manual's tables of them."""

import json
import re
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest

from codegen import ir
from codegen.ir import NO_CHILD, NO_FEATURE, GrownTree
from maviper.episodes.trees import agent_policies
from maviper.evaluation import held_out
from maviper.worlds import find
from tests.benchmarks import continuous, gaussian, halves, oblique
from tests.benchmarks.scores import find_rows, keep_rows
from tests.benchmarks.settled import Settled
from tests.benchmarks.sharing import Sharing, choose_sharing, join_trees

ROOT = Path(__file__).parent.parent
RECORD = ROOT / "generated/continuous/scores.json"
ROWS = json.loads(RECORD.read_text())


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row['game']} {row['asked']} {row['way']}")
def test_a_score_is_that_of_its_returns(row):
    assert row["way"] in (*continuous.WAYS, *continuous.PLAIN) and row["episodes"] == continuous.EPISODES
    score = (row["return"] - row["random"]) / (row["expert"] - row["random"])
    assert score == pytest.approx(row["score"], abs=1e-3) and row["low"] <= row["score"] <= row["high"]
    assert 1 <= row["leaves"] <= row["asked"] and re.fullmatch(r"[0-9a-f]{64}", row["expert_sha256"])


TEAMS, OBLIQUE, HALVES = (RECORD.with_name(f"{name}.json") for name in ("teams", "oblique", "halves"))
PAGE = (ROOT / "maviper/manual/extraction.md").read_text()


def test_the_manual_has_the_tables_of_the_records():
    assert "\n".join(continuous.table(RECORD)) in PAGE and "\n".join(gaussian.table(TEAMS)) in PAGE
    assert "\n".join(oblique.table(OBLIQUE)) in PAGE and "\n".join(halves.table(json.loads(HALVES.read_text()))) in PAGE


@pytest.mark.parametrize(
    "row", json.loads(HALVES.read_text()), ids=lambda row: f"{row['team']} {row['way']} {row['asked']}"
)
def test_a_score_in_deception_is_that_of_its_returns(row):
    assert (row["way"], row["asked"]) in halves.ASKED and row["episodes"] == halves.EPISODES
    score = (row["return"] - row["random"]) / (row["expert"] - row["random"])
    assert score == pytest.approx(row["score"], abs=2e-3) and row["low"] <= row["score"] <= row["high"]
    assert row["above_low"] <= row["above_high"] and max(row["leaves"]) <= row["asked"]


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


def test_landmarks_are_shared_out_by_the_tests_with_the_shortest_ways():
    world, seeds = find("cooperative-navigation"), range(300)
    chosen, state = choose_sharing(world, seeds), world.start_from_seeds(seeds)
    goals = share_out(world, chosen, state)
    assert set(map(tuple, goals.tolist())) == set(chosen.roles)
    assert measure_ways(state, goals) == pytest.approx(chosen.length)
    rng = np.random.default_rng(0)
    entities = [*world.agents, *(f"landmark_{place}" for place in range(3))]
    for _ in range(20):  # others are no shorter
        pairs = [rng.choice(entities, 2, replace=False).tolist() for _ in range(3)]
        root, *below = [(one, other, str(rng.choice(["x", "y"]))) for one, other in pairs]
        other = Sharing(root, (below[0], below[1]), cast("Any", [tuple(rng.permutation(3)) for _ in range(4)]), 0.0)
        goals = share_out(world, other, state)
        assert {*map(tuple, goals.tolist())} <= {*other.roles}
        assert measure_ways(state, goals) > chosen.length


def share_out(world, sharing, state):
    """The landmark that each agent's tree takes, [batch, n_agents]: below the tests are leaves with its number."""
    leaves = {(agent, goal): leaf(goal) for agent in range(3) for goal in range(3)}
    policies = agent_policies(world, join_trees(world, sharing, leaves))
    sums = [each.terms for policy in policies for each in policy.tree.sums]
    assert not any(len(terms) == 1 and dict(terms).keys() == {1.0} for terms in sums)  # that is the feature itself
    observed = world.observe(state)
    return np.array(
        [each.tree.action[ir.apply(each.tree, obs)] for each, obs in zip(policies, observed, strict=True)]
    ).T


def leaf(action):
    return GrownTree(*(np.array([value]) for value in (NO_FEATURE, 0.0, NO_CHILD, NO_CHILD, action)))


def measure_ways(state, goals):
    """The mean length of all agents' ways, straight to the landmarks `goals`, [batch, 3]."""
    place = state.position
    to = np.take_along_axis(place[:, 3:], goals[..., None], axis=1)
    return np.linalg.norm(place[:, :3] - to, axis=-1).sum(axis=1).mean()


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
        assert oblique.measure_once(record, row["way"], way) == wanted
    assert json.loads(record.read_text()) == [fresh]
