"""Whole commands on environments that wait for each other, print, end their process, hang or raise."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.hostile import COUNTED

ROOT = Path(__file__).parents[4]
LONG = 400  # seconds after which a command counts as one that hangs
pytestmark = pytest.mark.slow


def command(*words):
    return [sys.executable, "-m", "maviper", *words]


def run(*words, **given):
    return subprocess.run(
        command(*words), cwd=ROOT, capture_output=True, text=True, errors="replace", timeout=LONG, check=False, **given
    )


def world(mode, length=6):
    return f"tests.support.hostile:make,length={length},mode={mode}"


def extracting(mode, place, *more):
    return ["extract", f"tests.support.hostile:expert,mode={mode}", "--critic", "none", "-o", str(place), *more]


SMALL = ("--max-episodes", "60", "--max-depth", "1")


@pytest.fixture
def counted(tmp_path):
    """The environment of a command that counts resets, and how many there were."""
    place = tmp_path / "resets"
    place.touch()
    return {**os.environ, COUNTED: str(place)}, lambda: place.stat().st_size


# --- copies that share something


@pytest.mark.parametrize("mode", ["clock", "lock"])
def test_copies_that_wait_for_each_other_play_apart(mode, tmp_path):
    """One simulation a process, as libsumo has it: every command hung for ever, without a word."""
    done = run("evaluate", "random", "--world", world(mode), "--episodes", "4", "--json")
    assert done.returncode == 0 and json.loads(done.stdout)["episodes"] == 4, done.stderr
    done = run("worlds", "check", world(mode))
    assert done.returncode == 0 and "ok       repeats: " in done.stdout, done.stdout
    done = run(*extracting(mode, tmp_path / "p.json", *SMALL))
    assert done.returncode == 0 and (tmp_path / "p.json").exists(), done.stderr


# --- episodes


@pytest.mark.parametrize("more", [(), ("--algorithm", "iviper"), ("--held-out", "3"), ("--preset", "paper")])
def test_no_more_episodes_are_played_than_asked_for(more, tmp_path, counted):
    env, count = counted
    done = run(*extracting("sound", tmp_path / "p.json", "--max-episodes", "80", "--max-depth", "1", *more), env=env)
    assert done.returncode == 0, done.stderr
    assert 40 <= count() <= 80
    (plan,) = [line for line in done.stderr.splitlines() if line.startswith("plan ")]
    assert count() <= int(plan.split()[3]) <= 80
    held = json.loads((tmp_path / "p.json").read_text())["provenance"]["evaluation"]["episodes"]
    assert held == (3 if "--held-out" in more else 9)


def test_the_seeds_of_a_run_share_its_episodes(tmp_path, counted):
    env, count = counted
    more = "--max-episodes", "150", "--max-depth", "1", "--seeds", "2"
    done = run(*extracting("sound", tmp_path / "run", *more), env=env)
    assert done.returncode == 0 and count() <= 150, done.stderr


def test_lines_name_the_agent_and_the_stage(tmp_path):
    done = run(*extracting("sound", tmp_path / "p.json", *SMALL, "--algorithm", "iviper"))
    lines = done.stderr.splitlines()
    assert any(line.startswith(("extracting", "selecting")) and " a_1, " in line for line in lines), done.stderr
    assert any(line.startswith("measuring") and "held-out episodes" in line for line in lines)


def test_a_length_that_nobody_stated_stands_beside_its_numbers(tmp_path):
    """Random players never end, and the environment ends after 1,500 steps."""
    done = run("evaluate", "random", "--world", world("endless", 1_500), "--episodes", "2")
    assert ", 2 cut" in done.stdout and "1,000 steps, a length that nobody stated" in done.stdout
    done = run("evaluate", "random", "--world", world("endless", 1_500), "--episodes", "2", "--json")
    told = json.loads(done.stdout)
    (row,) = told["against"]["random"]["measures"]
    assert told["episodes_are_cut_after"] == 1_000 and row["subject"]["cut"] == 2
    done = run("evaluate", "random", "--world", world("endless", 60), "--episodes", "2")
    assert "cut" not in done.stdout  # it is played to its own end
    asked = extracting("endless,length=1500", tmp_path / "p.json", "--iterations", "1", "--rollouts", "1")
    done = run(*asked, "--set", "selection_episodes=1", "--held-out", "2", "--max-depth", "1")
    assert "2 and 2 of the episodes cut" in done.stderr and "1,000 steps, a length that nobody stated" in done.stderr
    kept = json.loads((tmp_path / "p.json").read_text())["provenance"]["evaluation"]
    assert kept["a cut"] == kept["a expert cut"] == 2


# --- standard output


@pytest.mark.parametrize(("verb", "jobs"), [("extract", 1), ("compare", 2)])
def test_what_an_environment_prints_goes_to_the_log_of_a_run(verb, jobs, tmp_path):
    """By Python, by descriptor, by a child, in whichever process; the file grows when a run goes on."""
    place, log = tmp_path / "run", tmp_path / "run" / "environment.log"
    more = ("--critic", "none", "--max-depth", "1")
    if verb == "compare":
        more = ("--algorithms", "imitation", "--seeds", "1", "--depths", "1", "--json")
    small = ("--max-episodes", "30", "--jobs", str(jobs), "-o", str(place))
    words = (verb, "tests.support.hostile:expert,mode=prints", *small, *more)
    done = run(*words)
    assert done.returncode == 0, done.stderr
    kept = log.read_text(errors="replace")
    assert all(said in kept for said in ("python: made", "python: step", "descriptor 1", "a child"))
    shown = (done.stderr + done.stdout).replace("python: closed\n\0\ufffd descriptor 1\na child\n", "")
    assert "python" not in shown and "descriptor" not in shown, shown  # only the expert's own copy ends later
    assert f"of the environment: {log}" in done.stderr
    assert verb == "extract" or json.loads(done.stdout)["best"]
    done = run(*words, *["--resume"] * (verb == "extract"))
    assert done.returncode == 0 and log.read_text(errors="replace").startswith(kept), done.stderr


@pytest.fixture(scope="module")
def profile(tmp_path_factory):
    place = tmp_path_factory.mktemp("printing") / "p.json"
    done = run(*extracting("prints", place, *SMALL))
    assert done.returncode == 0 and done.stdout == "", done.stderr
    assert "python: step" in done.stderr and "descriptor 1" in done.stderr and "a child" in done.stderr
    return place


@pytest.mark.parametrize(
    "words",
    [
        ("evaluate", "random", "--world", world("prints"), "--episodes", "2", "--json"),
        ("evaluate", "{profile}", "--world", world("prints"), "--episodes", "2", "--json"),
        ("evaluate", "tests.support.hostile:expert,mode=prints", "--episodes", "2", "--json"),
        ("worlds", "check", world("prints")),
        ("worlds", "show", world("prints")),
        ("verify", "--new", world("prints")),
        ("import", "{rules}", "--world", world("prints"), "-o", "{out}"),
    ],
)
def test_standard_output_is_for_results(words, profile, tmp_path):
    """Whatever an environment prints: by Python, by descriptor, by a child, in whichever process."""
    rules, out = tmp_path / "rules.py", tmp_path / "imported.json"
    rules.write_text(
        "".join(f"def {agent}(parity, number):\n    return int(parity > 0.5)\n" for agent in ("a_0", "a_1"))
    )
    done = run(*(word.format(profile=profile, rules=rules, out=out) for word in words))
    assert done.returncode == 0, done.stderr
    assert "python:" in done.stderr and "descriptor 1" in done.stderr and "a child" in done.stderr
    assert not any(printed in done.stdout for printed in ("python:", "descriptor 1", "a child"))
    if "--json" in words:
        json.loads(done.stdout)


# --- environments that misbehave


@pytest.mark.parametrize(
    ("mode", "said"),
    [
        ("dies", "ended by itself, exit code 9"),
        ("exits", "step raised SystemExit: done"),
        ("shape", r"observes an array of shape (3,), its space says (2,)"),
        ("raises", "step raised LinAlgError: Singular matrix"),
        ("nan", "a_0 observes NaN, number 1"),
        ("nan_reward", "a reward is nan"),
    ],
)
def test_what_an_environment_does_wrong_is_said(mode, said, tmp_path):
    for words in (
        ("evaluate", "random", "--world", world(mode), "--episodes", "4"),
        extracting(mode, tmp_path / mode, *SMALL),
    ):
        done = run(*words)
        assert done.returncode == 2 and said in done.stderr and "Traceback" not in done.stderr, done.stderr
    done = run("worlds", "check", world(mode))
    assert done.returncode == 2 and said in done.stdout and "Traceback" not in done.stderr, done.stdout


def test_the_line_that_raised_is_shown_and_the_users_own():
    done = run("evaluate", "random", "--world", world("raises"), "--episodes", "4")
    assert "_linalg.py:" in done.stderr and "hostile.py:" in done.stderr and "in misbehave" in done.stderr


@pytest.mark.parametrize("mode", ["forks", "raises_in_close"])
def test_what_can_be_played_is_played(mode, tmp_path):
    done = run("evaluate", "random", "--world", world(mode), "--episodes", "4", "--json")
    assert done.returncode == 0 and json.loads(done.stdout)["episodes"] == 4, done.stderr
    done = run(*extracting(mode, tmp_path / "p.json", *SMALL))
    assert done.returncode == 0 and "Traceback" not in done.stderr, done.stderr


# --- signals


@pytest.mark.parametrize("mode", ["hangs", "hangs_in_reset"])
@pytest.mark.parametrize("signalled", [signal.SIGINT, signal.SIGTERM])
def test_a_wait_is_said_and_can_be_ended(mode, signalled, tmp_path):
    words = extracting(mode, tmp_path / "run", "--world", world(mode), *SMALL)
    process = subprocess.Popen(command(*words), cwd=ROOT, stderr=subprocess.PIPE, text=True)
    assert any(line.startswith("waiting ") for line in iter(process.stderr.readline, ""))
    process.send_signal(signalled)
    _, rest = process.communicate(timeout=LONG)  # all that hold standard error have ended, copies too
    assert process.returncode == 130 and "error: interrupted" in rest and "Traceback" not in rest
    assert ("--resume" in rest) == (tmp_path / "run" / "config.json").exists()
