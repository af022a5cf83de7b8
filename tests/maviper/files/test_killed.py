"""Commands that are killed at any instant: what they leave is whole, and the same command again ends as if nothing was.

The small form kills the writer itself at each of its calls of the system; the slow one kills commands after random
delays.
"""

import json
import os
import random
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import pytest

from codegen.errors import ExitCode
from maviper.files import runs
from tests.support.killing import killed_at, needs_fork
from tests.support.tiers import sweep

ROOT = Path(__file__).parents[3]
PROFILE = ROOT / "generated" / "proved_defenders" / "profile.json"
OLD = {"a": "old a", "b": "old b", "mine": "untouched", "stale": "of before"}
NEW = {"a": "new a" * 100, "b": "new b", "deeper/c": "new c"}


def contents(folder):
    files = (path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in files}


def whole_files(folder):
    """Without scratch, which nobody takes for a file of the set."""
    return {name: data for name, data in contents(folder).items() if ".part" not in name}


def encoded(files):
    return {name: text.encode() for name, text in files.items()}


@needs_fork
@pytest.mark.parametrize("old", [{}, OLD], ids=["no folder", "old files"])
def test_a_writer_killed_at_each_of_its_calls(tmp_path, old):
    new, gone = encoded(NEW), ["stale"] if old else []
    done = {**encoded(old), **new}
    done.pop("stale", None)
    seen = set()
    for last in range(1, 200):
        place = tmp_path / str(last)
        folder = place / "out"
        place.mkdir()
        for name, text in old.items():
            folder.mkdir(exist_ok=True)
            (folder / name).write_text(text)

        write = partial(runs.write_all, folder, NEW, gone)
        cut, calls = killed_at(last, write)
        assert cut or calls
        left = whole_files(folder)
        seen.add(tuple(sorted(left.items())))
        if not old:  # all or nothing
            assert left in ({}, new)
        for name, data in left.items():
            assert data in (encoded(old).get(name), new.get(name)), name
        assert left.keys() >= OLD.keys() - {"stale"} or not old
        assert killed_at(0, write)[1] and contents(folder) == done and not list(place.rglob("*.part"))
        if not cut:
            break
    else:
        raise AssertionError("it never came to its end")
    assert last > 10 and len(seen) >= 2


SMALL = ("--iterations", "3", "--rollouts", "20", "--set", "selection_episodes=20", "--refinement-episodes", "0")
COMMANDS = {  # command, and what it ends with
    "compile": (["compile", PROFILE, "--target", "c,python,json"], ExitCode.DONE),
    "verify": (["verify", PROFILE, "--claim", "distinct_targets"], ExitCode.DONE),
    "repair": (["repair", PROFILE, "--episodes", "5"], ExitCode.DONE),
    "extract": (["extract", "physical-deception", *SMALL], ExitCode.DONE),
    "extract file": (["extract", "physical-deception", *SMALL], ExitCode.DONE),
}
RESUMED = {"extract"}


def command_of(name, folder, *more):
    words, _ = COMMANDS[name]
    out = folder / ("profile.json" if name == "extract file" else "out")
    return [sys.executable, "-m", "maviper", "-q", *map(str, words), "-o", str(out), *more], out


def ended(command, cwd):
    ran = subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False, timeout=300)
    assert "Traceback" not in ran.stderr, ran.stderr
    return ran.returncode


def same(files):
    """What two runs have in common: their commands differ in folders, and in --resume."""
    return {name: data for name, data in files.items() if Path(name).name != "config.json"}


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """(seconds, files) of a command that nobody kills, by name."""
    known = {}

    def run(name):
        if name not in known:
            place = tmp_path_factory.mktemp("whole")
            command, _ = command_of(name, place)
            began = time.monotonic()
            assert ended(command, place) == COMMANDS[name][1]
            known[name] = time.monotonic() - began, contents(place)
        return known[name]

    return run


@pytest.mark.compile
@pytest.mark.solver
@pytest.mark.parametrize("attempt", sweep(range(6), every=6))
@pytest.mark.parametrize("name", list(COMMANDS))
def test_a_command_killed_at_a_random_instant(tmp_path, undisturbed, name, attempt):
    seconds, files = undisturbed(name)
    command, out = command_of(name, tmp_path)
    process = subprocess.Popen(
        command, cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True
    )
    time.sleep(random.Random(f"{name}{attempt}").uniform(0.3, 1.0) * seconds)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    left = whole_files(tmp_path)
    if name not in RESUMED:
        assert same(left) in ({}, same(files))
    for path, data in left.items():
        if path.endswith(".json"):
            json.loads(data)
        if path.endswith((".safetensors", "profile.json")):  # steps that are finished, as they are without us
            assert data == files[path], path
    begun = name in RESUMED and (out / "config.json").exists()
    command, _ = command_of(name, tmp_path, *(["--resume"] if begun else []))
    assert ended(command, tmp_path) == COMMANDS[name][1]
    assert same(contents(tmp_path)) == same(files)
