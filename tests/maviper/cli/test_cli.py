"""The command line: exit codes, suggestions, files that are whole or absent."""

import json
import os
import shlex
import sys
from pathlib import Path

import pytest
from mpe2.simple_tag_v3 import parallel_env

from codegen import policy_json
from codegen.errors import ExitCode
from tests.support.verifying import run


def names(folder):
    return sorted(path.name for path in folder.rglob("*"))


def test_help_states_the_exit_codes(capsys):
    code, out, _ = run(capsys, "--help")
    assert code == 0
    for number in ExitCode:
        assert f"  {int(number)} " in out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["extract", "physical-deception", "--max-depth", "four", "-o", "x.json"], "not a valid integer"),
        (["extract", "physical-deception", "-o", "a.txt"], "choose a folder: -o a, or a file that ends in .json"),
        (["compile", "{profile}", "-o", "policy.h"], "choose a folder: -o policy"),
        (["verify", "{profile}", "--smt", "queries.smt2"], "choose a folder: --smt queries"),
        (["repair", "{profile}", "-o", "Fixed.JSON"], "-o names a folder here"),
        (["compile", "{profile}", "--prefix", "9", "-o", "{out}"], "not a usable prefix"),
        (["verify", "{profile}", "--region", "nowhere.toml"], "cannot read the file"),
        (["verify", "{profile}", "--claim", "distinct_targets(margin=-1)"], "margin must be between 0 and"),
        (["verify", "{profile}", "--claim", "distinct_targets(steps=3)"], "distinct_targets has no parameter steps"),
        (["verify", "{profile}", "--claim", "reaches(steps=-1)"], "steps must be between"),
        (["verify", "{profile}", "--claim", "reaches(margin=1/40)"], "reaches has no parameter margin"),
        (["verify", "{profile}", "--claim", "reaches(landmarks=[landmark_2])"], "unknown landmark"),
        (["verify", "{profile}", "--claim", "covers", "--set", "max_zones=0"], "zones must be between"),
        (["verify", "none.json"], "cannot read the file"),
        (["verify", "{profile}", "--region", "strat"], "'strat' is neither `start` nor a file"),
        (["verify", "{folder}"], "a folder, not a profile"),
        (["compile", "{profile}", "--target", "cpp", "-o", "{out}"], "choose c, whose header is C++17 too"),
        (["evaluate", "{profile}", "--against", "nobody"], "write scripted, random, a profile's .json or an expert"),
        (["extract", "gymnasium:CartPole-v1", "-o", "{out}"], "this is an environment, not an expert"),
        (["demo", "-o", "/proc/nowhere"], "cannot make the output folder"),
    ],
)
def test_bad_input_is_answered_in_three_lines_and_exit_2(capsys, profile_file, tmp_path, arguments, message):
    places = {"profile": profile_file, "folder": Path(profile_file).parent, "out": tmp_path / "out"}
    filled = [word.format(**places) for word in arguments]
    code, _, err = run(capsys, *filled)
    assert code == ExitCode.INPUT
    assert message in err and "Traceback" not in err
    assert not (tmp_path / "out").exists()


def test_show_prints_one_rule_a_leaf(capsys, profile, profile_file):
    code, out, _ = run(capsys, "show", profile_file, "--agent", "agent_1")
    assert code == 0
    from codegen.ir import leaves

    assert len(out.splitlines()) == 1 + len(leaves(profile.policy("agent_1").tree))


@pytest.mark.compile
def test_compile_writes_what_it_proved(capsys, profile_file, tmp_path):
    code, _, err = run(capsys, "compile", profile_file, "-o", tmp_path / "code")
    assert code == 0 and "0 differ" in err
    stem = "physical_deception"
    written = [".agreement.json", ".h", ".json", ".py", "_reader.py"]
    assert names(tmp_path / "code") == [stem + ending for ending in written]
    evidence = json.loads((tmp_path / "code" / f"{stem}.agreement.json").read_text())
    targets = {row["target"] for row in evidence["agreement"]}
    assert {"c", "python", "json", "tree as grown", "episodes driven by c"} <= targets
    assert all(row["differences"] == 0 for row in evidence["agreement"])
    assert sum(row["observations"] for row in evidence["agreement"] if row["target"] == "tree as grown") > 300_000


@pytest.mark.usefixtures("few_observations")
def test_compile_without_a_compiler_is_skipped_and_exit_3(capsys, profile_file, tmp_path, monkeypatch):
    monkeypatch.setenv("CC", "no-such-compiler")
    code, _, err = run(capsys, "compile", profile_file, "-o", tmp_path / "code")
    assert code == ExitCode.INCONCLUSIVE and "SKIPPED" in err


@pytest.mark.usefixtures("few_observations")
def test_a_disagreement_is_exit_4_and_leaves_nothing(capsys, profile_file, tmp_path, monkeypatch):
    from codegen.targets import TARGETS

    emit = TARGETS["python"]
    wrong = lambda model, profile: {k: v.replace("<=", "<") for k, v in emit(model, profile).items()}  # noqa: E731
    monkeypatch.setitem(TARGETS, "python", wrong)
    code, _, err = run(capsys, "compile", profile_file, "-o", tmp_path / "code")
    assert code == ExitCode.DISAGREES and "disagrees with the profile" in err
    assert not (tmp_path / "code").exists()


def test_training_without_torch_is_exit_5(capsys, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "torch", None)
    code, _, err = run(capsys, "train", "physical-deception", "-o", tmp_path / "run")
    assert code == ExitCode.MISSING and "maviper[train]" in err


def test_our_own_bugs_are_exit_70(capsys, monkeypatch, profile_file):
    monkeypatch.setattr("maviper.evaluation.show.rules", lambda policy: 1 // 0)
    code, _, err = run(capsys, "show", profile_file)
    assert code == ExitCode.BUG and "a bug in maviper" in err and "Traceback" in err


@pytest.mark.solver
def test_verify_answers_on_stdout_and_by_exit_code(capsys, profile_file, tmp_path):
    code, out, err = run(capsys, "verify", profile_file, "--json", "-o", tmp_path / "report")
    facts = json.loads(out)
    result = facts["results"][0]
    assert code == ExitCode.VIOLATED and result["verdict"] == "VIOLATED" and "VIOLATED" in err
    assert result["counterexample"]["replayed_by"][-1] == "mpe2.simple_adversary_v3"
    assert result["conflict"]["samples"] == 100_000
    found = "counterexample-1-distinct_targets"
    reports = ["play.html", "profile.json", "report.html", "report.json", "report.txt"]
    test = f"test_{found}.py".replace("-", "_")
    given = [".maviper.json", f"{found}.json", *reports, "states-1-distinct_targets.json", test]
    assert names(tmp_path / "report") == given
    assert json.loads((tmp_path / "report" / "report.json").read_text()) == facts


@pytest.mark.solver
def test_claims_about_episodes_in_a_report(capsys, profile_file, tmp_path):
    asked = ["--claim", "reaches(radius=2/5)", "--claim", "distinct_targets"]
    code, out, err = run(capsys, "verify", profile_file, *asked, "--json", "-o", tmp_path / "report")
    facts = json.loads(out)
    result = facts["results"][0]
    assert code == ExitCode.VIOLATED and [each["property"] for each in facts["results"]] == [
        "reaches",
        "distinct_targets",
    ]
    assert {"simulator", "mpe2.simple_adversary_v3"} <= set(result["counterexample"]["replayed_by"])
    assert result["steps"] == 25 and result["violating"]["samples"] == 20_000
    assert all(len(agent["places"]) == 26 for agent in result["counterexample"]["agents"])
    assert "comes within" in err
    page, text = ((tmp_path / "report" / f"report.{form}").read_text() for form in ("html", "txt"))
    assert "<polyline" in page and "conflict share" in page and "idle share" in page
    assert "fulfil it without moving" in text and "whatever" not in text
    assert len(facts["limits"]) == 4 and any("start at rest" in limit for limit in facts["limits"])
    again = shlex.split(result["command"])[2:]
    repeated = run(capsys, "-q", "verify", profile_file, *again[1:], "--json")[1]
    assert json.loads(repeated)["results"][0] == result


@pytest.mark.solver
@pytest.mark.usefixtures("few_states")
def test_verify_inconclusive_is_exit_3(capsys, profile_file, tmp_path):
    region = tmp_path / "empty.toml"
    region.write_text('[difference]\n"agent_0.x - agent_1.x" = [3, 4]\n')
    code, out, _ = run(capsys, "-q", "verify", "-v", profile_file, "--region", region)
    assert code == ExitCode.INCONCLUSIVE and "VACUOUS" in out
    assert run(capsys, "-q", "verify", profile_file, "--set", "solver_units=5")[0] == ExitCode.INCONCLUSIVE


@pytest.mark.solver
@pytest.mark.usefixtures("few_states")
def test_the_report_is_self_contained_and_repeats(capsys, profile_file, tmp_path):
    import re

    for name in ("a", "b"):
        run(capsys, "verify", profile_file, "-o", tmp_path / name)
    page = (tmp_path / "a" / "report.html").read_text()
    assert not re.search(r"<script|https?://(?!www\.w3\.org)|src=|@import|url\((?!#)", page)
    assert "<svg" in page and "VIOLATED" in page and "conflict share" in page and "maviper verify profile.json" in page
    for file in ("report.html", "report.json", "report.txt"):
        assert (tmp_path / "a" / file).read_bytes() == (tmp_path / "b" / file).read_bytes()


def test_worlds_list_and_show(capsys):
    code, out, _ = run(capsys, "worlds", "list")
    assert code == 0 and "physical-deception@1" in out and "observation=paper" in out
    code, out, _ = run(capsys, "worlds", "show", "physical-deception")
    assert code == 0 and "goal.x - agent_0.x" in out
    code, out, _ = run(capsys, "worlds", "show", "predator-prey")
    world = parallel_env(num_good=2, num_adversaries=2, num_obstacles=2).unwrapped.world
    for entity in (*world.agents, *world.landmarks):
        name = entity.name.replace("landmark ", "obstacle_")
        line = next(line for line in out.splitlines() if line.split()[:1] == [name])
        speed = f", top speed {entity.max_speed:g}" if entity.max_speed else ""
        assert f"radius {entity.size:g}, " in line and f"{speed}, {'collides' if entity.collide else 'passes'}" in line
        assert not entity.movable or f"acceleration {entity.accel:g}" in line


def test_schema_is_json(capsys):
    code, out, _ = run(capsys, "show", "x", "--schema")
    assert code == 0 and json.loads(out)["$schema"].startswith("https://json-schema.org")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_read_only_folder_is_an_input_error(capsys, profile_file, tmp_path):
    locked = tmp_path / "locked"
    locked.mkdir(mode=0o500)
    code, _, err = run(capsys, "compile", profile_file, "-o", locked / "code")
    assert code == ExitCode.INPUT and "cannot make the output folder" in err


@pytest.mark.parametrize(
    ("compiler", "message"), [("gcc '", "cannot read $CC"), ("true", "cannot load"), ("false", "does not work")]
)
@pytest.mark.usefixtures("few_observations")
def test_a_broken_compiler_is_something_outside(capsys, profile_file, tmp_path, monkeypatch, compiler, message):
    monkeypatch.setenv("CC", compiler)
    code, _, err = run(capsys, "compile", profile_file, "-o", tmp_path / "code")
    assert code == ExitCode.MISSING and message in err and "Traceback" not in err
    assert not (tmp_path / "code").exists()


def hashless(profile_file, change):
    """The profile after an edit made on purpose."""
    document = json.loads(profile_file.read_text())
    del document["content_hash"]
    change(document)
    profile_file.write_text(json.dumps(document))


def add_action(document, agents):
    for agent in agents:
        document["agents"][agent]["actions"].append({"name": "jump", "effect": [0.5, 0.5]})


@pytest.mark.compile
@pytest.mark.usefixtures("few_observations", "few_states")
@pytest.mark.parametrize(
    "change",
    [
        lambda document: add_action(document, (0, 1, 2)),
        lambda document: add_action(document, (1,)),
        lambda document: [agent["actions"].reverse() for agent in document["agents"]],
        lambda document: [agent.update(team="everybody") for agent in document["agents"][:1]],
        lambda document: document["agents"][1]["features"][0].update(meaning="goal.y - agent_0.x"),
    ],
)
def test_a_profile_of_another_world_is_not_played_in_ours(capsys, profile_file, tmp_path, change):
    """It compiles and verifies without our simulator and mpe2, and both say what was left out."""
    hashless(profile_file, change)
    code, _, err = run(capsys, "compile", profile_file, "-o", tmp_path / "code")
    assert code == ExitCode.INCONCLUSIVE and "SKIPPED" in err and "no built-in game has" in err
    code, out, _ = run(capsys, "-q", "verify", "-v", profile_file)
    assert code in (ExitCode.DONE, ExitCode.VIOLATED)
    assert "SKIPPED mpe2.simple_adversary_v3" in out and "not checked: this version cannot play" in out
    assert "visited" not in out and "replays    reference, compiled C" in out


@pytest.mark.solver
@pytest.mark.usefixtures("few_states")
def test_the_repeating_command_is_quoted(capsys, profile, tmp_path, monkeypatch):
    import shlex

    monkeypatch.chdir(tmp_path)
    (tmp_path / "my profile.json").write_text(policy_json.dumps(profile))
    (tmp_path / "start").write_text("default = [-0.1, 0.1]")
    asked = ("--region", "./start", "--claim", "distinct_targets(margin=1/40)", "--json")
    _, out, _ = run(capsys, "-q", "verify", "my profile.json", *asked)
    first = json.loads(out)["results"][0]
    _, out, _ = run(capsys, "-q", *shlex.split(first["command"])[1:], "--json")
    assert json.loads(out)["results"][0] == first and first["region"]["box"]["agent_0.x"] == ["-0.1", "0.1"]


def test_no_arguments_print_the_help(capsys):
    code, _, err = run(capsys)
    assert code == ExitCode.INPUT and err.startswith("Usage: maviper")
