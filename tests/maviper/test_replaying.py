"""Counterexamples as files: replayed as they were found, judged anew for another policy, refused when damaged."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

import maviper
from codegen.errors import InputError
from codegen.policy_json import dumps
from maviper.cli import cli
from tests.teams import team, towards

pytestmark = pytest.mark.solver
NAMED = "counterexample-1-distinct_targets.json"
ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def folder(tmp_path_factory, profile):
    found = tmp_path_factory.mktemp("report")
    same = team(profile, towards(0, 0), towards(0, 1))
    (found / "same.json").write_text(dumps(same))
    (found / "roles.json").write_text(dumps(team(profile, towards(0, 0), towards(1, 1))))
    words = ["verify", str(found / "same.json"), "--property", "distinct_targets", "--property", "steady"]
    ran = CliRunner().invoke(cli, [*words, "-o", str(found)], standalone_mode=False)
    assert ran.return_value == 1, ran.output
    return found


def run(*words):
    return CliRunner().invoke(cli, [str(word) for word in words], standalone_mode=False)


def test_it_fails_for_the_policy_that_it_is_about_and_holds_for_a_mended_one(folder):
    for name in (NAMED, "counterexample-2-steady.json"):
        ran = run("replay", folder / name)
        assert ran.return_value == 1 and "VIOLATED" in ran.output and "reference" in ran.output
    mended = run("replay", folder / NAMED, "--profile", folder / "roles.json")
    assert mended.return_value == 0 and "holds" in mended.output
    assert "not the one" in mended.output and "(was " in mended.output
    found = maviper.replay(folder / NAMED, folder / "same.json")
    assert found.violated and found.same_policy and found.actions == found.before
    assert found.by[0] == "reference" and "mpe2.simple_adversary_v3" in found.by


def test_the_ready_test_fails_until_the_policy_is_mended(folder, tmp_path):
    for name in (NAMED, "test_counterexample_1_distinct_targets.py"):
        (tmp_path / name).write_bytes((folder / name).read_bytes())
    for policy, wanted in (("same.json", 1), ("roles.json", 0)):
        (tmp_path / "profile.json").write_bytes((folder / policy).read_bytes())
        command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(tmp_path)]
        ran = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
        assert ran.returncode == wanted, ran.stdout


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"counterexample": "maviper-counterexample-9"}, "another version"),
        ({"goal": "landmark_7"}, "another world"),
        ({"team": "nobody"}, "another world"),
        ({"position": {"agent_0.x": 0.5}}, "another world"),
        ({"errors": {"agent_0:smell": 0.1}}, "another world"),
        ({"formula": {"sum": [["1/0", "agent_0.x"]], "most": "1"}}, "formula"),
        ({"formula": {"goal": 7}}, "formula"),
        ({"position": {"agent_0.x": "far"}}, "not a counterexample"),
        ({"more": 1}, "not a counterexample"),
    ],
)
def test_a_damaged_file_is_told(folder, tmp_path, change, said):
    document = json.loads((folder / NAMED).read_text()) | change
    (tmp_path / "damaged.json").write_text(json.dumps(document))
    with pytest.raises(InputError, match=said):
        maviper.replay(tmp_path / "damaged.json", folder / "same.json")


def test_a_truncated_file_is_told(folder, tmp_path):
    (tmp_path / "cut.json").write_bytes((folder / NAMED).read_bytes()[:200])
    with pytest.raises(InputError, match="not a counterexample"):
        maviper.replay(tmp_path / "cut.json", folder / "same.json")
