"""The command `maviper repair`: what it writes, says and refuses."""

import json
from dataclasses import replace
from fractions import Fraction

import pytest

from codegen import policy_json
from codegen.policy_json import content_hash
from codegen.profiles import loads
from maviper import load
from maviper.cli import main
from tests.support.small import small_profile
from tests.support.teams import DOWN, STAY, UP, team, towards, tree

pytestmark = pytest.mark.solver


def written(place, profile):
    place.mkdir(exist_ok=True)
    path = place / "team.json"
    path.write_text(policy_json.dumps(profile))
    return path


@pytest.fixture(scope="module")
def before():
    return team(small_profile(), towards(0, 0), tree((5, 0.4, 1, 2), DOWN, UP))


def test_profile_certificate_report_and_costs_are_written(before, tmp_path, capsys):
    out = tmp_path / "out"
    path = written(tmp_path, before)
    assert main.run(["repair", str(path), "--max-depth", "4", "--episodes", "50", "-o", str(out)]) == 0
    said = "".join(capsys.readouterr())
    assert "agent_0 for landmark_" in said and "PROVED" in said
    assert main.run(["check", str(out / "certificate-1-distinct_targets.json")]) == 0
    after, cost = load(out / "profile.json"), json.loads((out / "repair.json").read_text())
    assert after.provenance.training["profile before repair"] == cost["profile_before"] == content_hash(before)
    assert after.provenance.training["repair"] == "distinct_targets of the defenders, region start"
    assert not after.provenance.evaluation, "measures of the trees before say nothing about these"
    assert cost["profile"] == content_hash(after) and cost["opponents"] == "the profile's own trees"
    assert cost["trees"]["agent_1"]["before"] == {"leaves": 2, "depth": 1}
    region = cost["changed"]["region"]
    assert region["low"] - 0.01 < float(Fraction(region["exact"].strip('"'))) < region["high"] + 0.01
    assert 0 < region["share"] < 0.5 and cost["changed"]["met"]["samples"] == 50 * 25
    assert {row["episodes"] for row in cost["measures"]} == {50}
    for row in cost["measures"]:
        assert abs(row["after"]["value"] - row["before"]["value"] - row["difference"]["value"]) < 3e-6
    assert "--max-depth 4" in cost["command"]
    assert (out / "report.html").exists()


def test_a_team_that_is_proved_is_written_as_it_is(tmp_path, capsys):
    roles = team(small_profile(), towards(0, 0), towards(1, 1))
    assert main.run(["repair", str(written(tmp_path, roles)), "--episodes", "10", "-o", str(tmp_path / "out")]) == 0
    assert "nothing: no state of the region violates" in capsys.readouterr().err
    assert (tmp_path / "out" / "profile.json").read_text() == policy_json.dumps(roles)


def test_no_repair_exits_with_3_and_writes_nothing(before, tmp_path, capsys):
    out = tmp_path / "out"
    still = team(before, tree(STAY), tree(STAY))
    assert (
        main.run(["repair", str(written(tmp_path, still)), "--claim", "distinct_targets(radius=0)", "-o", str(out)])
        == 3
    )
    assert "no guard keeps agent_" in capsys.readouterr().err and not out.exists()


def test_a_repair_beyond_the_depth_exits_with_1(before, tmp_path, capsys):
    asked = [
        "repair",
        str(written(tmp_path, before)),
        "--max-depth",
        "1",
        "--episodes",
        "10",
        "-o",
        str(tmp_path / "out"),
    ]
    assert main.run(asked) == 1
    said = "".join(capsys.readouterr())
    assert "too deep" in said and "more than the 1 asked for" in said and "PROVED" in said


def test_a_world_that_cannot_be_played_is_repaired_without_measures(before, tmp_path):
    strange = replace(before, world=replace(before.world, name="elsewhere"))
    region = tmp_path / "near.toml"
    region.write_text('goals = ["landmark_0"]\n')
    out = tmp_path / "out"
    asked = [
        "repair",
        str(written(tmp_path, strange)),
        "--claim",
        "own_target",
        "--region",
        str(region),
        "-o",
        str(out),
    ]
    assert main.run(asked) in (0, 3)
    cost = json.loads((out / "repair.json").read_text())
    assert cost["changed"]["met"] is None and cost["measures"] == [] and "no built-in game has" in cost["opponents"]
    assert cost["property"] == "own_target" and (out / "near.toml").exists()
    assert loads((out / "profile.json").read_text()).world.name == "elsewhere"


@pytest.mark.parametrize(
    "wrong, what",
    [
        (["--episodes", "0"], "the number of episodes"),
        (["--max-depth", "0"], "the depth must be"),
        (["--claim", "no_double"], "no_double cannot be repaired"),
        (["--claim", "distinct_target"], "distinct_targets"),
        (["--landmarks", "landmark_0,landmark_1"], "--landmarks"),
    ],
)
def test_wrong_options_are_input_errors(before, tmp_path, capsys, wrong, what):
    assert main.run(["repair", str(written(tmp_path, before)), *wrong, "-o", str(tmp_path / "out")]) == 2
    assert what in capsys.readouterr().err


def test_one_episode_bounds_nothing_and_is_written(before, tmp_path):
    out = tmp_path / "out"
    assert main.run(["repair", str(written(tmp_path, before)), "--episodes", "1", "-o", str(out)]) == 0
    assert all(one["difference"]["low"] is None for one in json.loads((out / "repair.json").read_text())["measures"])
