"""Counterexamples as files: replayed as they were found, judged anew for another policy, refused when damaged."""

import json

import pytest
from click.testing import CliRunner

import maviper
from codegen.errors import InputError
from codegen.policy_json import dumps
from maviper.cli.main import cli
from tests.support.episode_cases import arriving
from tests.support.ready_tests import outcomes
from tests.support.teams import team, towards
from tests.support.verifying import ensure_told

pytestmark = [pytest.mark.solver, pytest.mark.usefixtures("few_states_throughout")]
NAMED = "counterexample-1-distinct_targets.json"
EPISODES = ("counterexample-3-reaches.json", "counterexample-4-covers.json")


@pytest.fixture(scope="module")
def folder(tmp_path_factory, profile):
    found = tmp_path_factory.mktemp("report")
    same = team(profile, towards(0, 0), towards(0, 1))
    (found / "same.json").write_text(dumps(same))
    (found / "arriving.json").write_text(dumps(team(profile, arriving(0), arriving(1))))
    (found / "roles.json").write_text(dumps(team(profile, towards(0, 0), towards(1, 1))))
    words = ["verify", str(found / "same.json"), *(["--claim", "distinct_targets", "--claim", "steady"])]
    words += ["--claim", "reaches(steps=20)", "--claim", "covers(steps=20)"]
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


def test_an_episode_fails_for_its_policy_and_holds_for_a_mended_one(folder):
    for name in EPISODES:
        ran = run("replay", folder / name)
        assert ran.return_value == 1 and "VIOLATED" in ran.output and "simulator" in ran.output
        found = maviper.replay(folder / name, folder / "same.json")
        assert found.violated and found.same_policy and found.actions == found.before
        assert found.by == ("reference", "simulator", "compiled C", "mpe2.simple_adversary_v3")
        assert all(len(actions.split()) == 20 for actions in found.actions.values()) and len(found.actions) == 3
    mended = run("replay", folder / EPISODES[0], "--profile", folder / "arriving.json")
    assert mended.return_value == 0 and "holds" in mended.output and "(was " in mended.output


def test_a_file_says_what_a_report_says(folder):
    """And a file of before, without what is said there, is still replayed."""
    report = json.loads((folder / "report.json").read_text())
    for name, result in zip((NAMED, "counterexample-2-steady.json", *EPISODES), report["results"], strict=True):
        document = json.loads((folder / name).read_text())
        assert document["explanation"] == result["counterexample"]["explanation"]
        assert {"unique", "fails by", "free"} <= set(document["explanation"]["says"])
        assert document["position"] == result["counterexample"]["position"]
        for coordinate, value in document["position"].items():
            interval = document["explanation"]["coordinates"][coordinate]
            assert interval["low"] <= value <= interval["high"]
        (folder / "before.json").write_text(json.dumps({k: v for k, v in document.items() if k != "explanation"}))
        assert maviper.replay(folder / "before.json", folder / "same.json").violated
    text, page = ((folder / f"report.{form}").read_text() for form in ("txt", "html"))
    for said in ("other counterexamples exist", "fails by", "in brackets: ", "does not matter"):
        assert said.lower() in text and said.lower() in page.lower(), said
    assert "changes when moved by" in page and "Not tested: " in page


def test_the_ready_test_of_an_episode_fails_until_the_policy_is_mended(folder, tmp_path):
    files = [folder / name for name in (EPISODES[0], "test_counterexample_3_reaches.py")]
    found = outcomes(tmp_path, files, [folder / "same.json", folder / "arriving.json"])
    assert found == {"same": "FAILED", "arriving": "PASSED"}


def test_the_ready_test_fails_until_the_policy_is_mended(folder, tmp_path):
    files = [folder / name for name in (NAMED, "test_counterexample_1_distinct_targets.py")]
    found = outcomes(tmp_path, files, [folder / "same.json", folder / "roles.json"])
    assert found == {"same": "FAILED", "roles": "PASSED"}


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
        ({"position/agent_0.x": float("nan")}, "not a counterexample"),
        ({"position/agent_0.x": float("inf")}, "not a counterexample"),
        ({"position/agent_0.x": 1e300}, "not a counterexample"),
        ({"position/agent_7.x": 0.5}, "another world"),
        ({"errors/agent_0:goal_dx": -1e12}, "not a counterexample"),
        ({"actions/agent_7": "up"}, "another world"),
        ({"formula": {"goal": "landmark_7"}}, "another world"),
        ({"formula": {"agent": "agent_0", "takes": 9}}, "another world"),
        ({"formula": {"agent": "agent_7", "takes": 1}}, "another world"),
        ({"formula": {"sum": [["1", "agent_7.x"]], "most": "1"}}, "another world"),
        ({"explanation": 7}, "not a counterexample"),
    ],
)
def test_a_damaged_file_is_told(folder, tmp_path, change, said):
    ensure_told(folder / NAMED, folder / "same.json", tmp_path, change, said)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"counterexample": "maviper-episode-counterexample-9"}, "another version"),
        ({"claim": "reach"}, "unknown claim"),
        ({"claim": "distinct_targets"}, "unknown claim"),
        ({"team": "nobody"}, "team"),
        ({"goal": "landmark_7"}, "another world"),
        ({"position": {}}, "another world"),
        ({"position/agent_7.x": 0.5}, "another world"),
        ({"position/agent_0.x": float("nan")}, "not a counterexample"),
        ({"position/agent_0.x": 1e300}, "not a counterexample"),
        ({"position/agent_0.vx": 0.1}, "at rest"),
        ({"actions/agent_7": "up"}, "another world"),
        ({"actions": {"agent_0": ["up"]}}, "not a counterexample"),
        ({"parameters/steps": -1}, "steps"),
        ({"parameters/steps": "25"}, "steps"),
        ({"parameters/steps": 10**9}, "steps"),
        ({"parameters/radius": "-1"}, "radius"),
        ({"parameters/radius": "1/0"}, "not a number"),
        ({"parameters/radius": 1}, "radius"),
        ({"parameters/speed": 1}, "parameter"),
        ({"parameters/landmarks": ["landmark_0", "landmark_7"]}, "landmark"),
        ({"parameters/landmarks": ["landmark_0", "landmark_0"]}, "landmark"),
        ({"more": 1}, "not a counterexample"),
    ],
)
def test_a_damaged_episode_is_told(folder, tmp_path, change, said):
    ensure_told(folder / EPISODES[0], folder / "same.json", tmp_path, change, said)


def edited(folder, tmp_path, name, **members):
    document = json.loads((folder / name).read_text()) | members
    (tmp_path / "edited.json").write_text(json.dumps(document))
    return tmp_path / "edited.json"


def test_a_property_is_named_where_the_formula_is_its_own(folder, tmp_path):
    """A file's word for its claim is told as that."""
    same = folder / "same.json"
    assert maviper.replay(folder / NAMED, same).property == "distinct_targets"
    assert maviper.replay(folder / EPISODES[0], same).property == "reaches"
    for stated in ("own_target", "assignment", "no_double", "harmless", "дело"):
        renamed = edited(folder, tmp_path, NAMED, property=stated)
        ran = run("replay", renamed, "--profile", same)
        told = stated.encode("ascii", "backslashreplace").decode()
        assert ran.return_value == 1 and f"VIOLATED    formula (in the file: '{told}')" in ran.output, ran.output
    changed = edited(folder, tmp_path, NAMED, formula={"any": []})
    assert maviper.replay(changed, same).property == "formula (in the file: 'distinct_targets')"
    relabelled = edited(folder, tmp_path, EPISODES[1], property="arrives")
    assert maviper.replay(relabelled, same).property == "covers (in the file: 'arrives')"


def test_what_a_file_says_of_its_own_policy_is_compared(folder, tmp_path):
    for name in (NAMED, EPISODES[0]):
        actions = json.loads((folder / name).read_text())["actions"]
        changed = edited(folder, tmp_path, name, actions=actions | {"agent_0": "sideways\x1b"})
        with pytest.raises(InputError, match="edited after it was written") as caught:
            maviper.replay(changed, folder / "same.json")
        assert "agent_0: the policy takes" in caught.value.where
        other = run("replay", changed, "--profile", folder / "roles.json")
        assert "(was sideways\\x1b)" in other.output
        silent = run("replay", edited(folder, tmp_path, name, actions={}), "--profile", folder / "same.json")
        assert silent.return_value == 1 and "(was" not in silent.output


def test_a_truncated_file_is_told(folder, tmp_path):
    for name in (NAMED, EPISODES[0]):
        (tmp_path / "cut.json").write_bytes((folder / name).read_bytes()[:200])
        with pytest.raises(InputError, match="not a counterexample") as caught:
            maviper.replay(tmp_path / "cut.json", folder / "same.json")
        assert "truncated" in caught.value.where


@pytest.mark.parametrize("number", [0, 1])
def test_a_file_nested_too_deeply_is_told(folder, tmp_path, number):
    document = json.loads((folder / (NAMED, EPISODES[0])[number]).read_text())
    text = json.dumps(document | {"explanation": {}}).replace(
        '"explanation": {}', f'"explanation": {{"a": {"[" * 10**5}'
    )
    (tmp_path / "deep.json").write_text(text)
    with pytest.raises(InputError, match="not a counterexample"):
        maviper.replay(tmp_path / "deep.json", folder / "same.json")
