"""The one-minute tour, twice: every outcome as expected, every byte the same."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = [pytest.mark.slow, pytest.mark.solver]
PAGE = Path(__file__).parents[3] / "maviper" / "manual" / "tour.md"


def tour(folder, **environment):
    import os

    command = [sys.executable, "-m", "maviper", "demo", "-o", folder.name]
    return subprocess.run(
        command, capture_output=True, text=True, check=False, cwd=folder.parent, env={**os.environ, **environment}
    )


@pytest.fixture(scope="module")
def tours(tmp_path_factory):
    folders = [tmp_path_factory.mktemp(name) / "demo" for name in ("first", "second")]
    # the second run differs in everything that must not matter
    usual = {"TERM": "dumb", "OMP_NUM_THREADS": "2", "OPENBLAS_NUM_THREADS": "2"}
    other = {"PYTHONHASHSEED": "7", "TZ": "Asia/Tokyo", "COLUMNS": "50"}
    other |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    done = [tour(folders[0], **usual), tour(folders[1], **other)]
    return folders, done


def test_every_step_gives_its_expected_outcome(tours):
    _, done = tours
    for process in done:
        assert process.returncode == 0, process.stderr
        assert "10 iterations of 50 rollouts, selection on 50 episodes each" in process.stderr
        assert "0 differ" in process.stderr
        assert "VIOLATED    distinct_targets" in process.stderr and "PROVED      distinct_targets" in process.stderr


def lasting(session):
    """The lines of a session without those that a slow machine prints in between."""
    steps = re.compile(r" *(?:extracting|refining) +(\d+)/(\d+) ")
    found = [(line, steps.match(line)) for line in session.splitlines()]
    return [line for line, step in found if step is None or step[1] == step[2]]


@pytest.mark.compile
def test_the_tours_session_is_a_real_one(tours, request):
    """The session in the manual's tour; only rates and times may differ."""
    before, rest = PAGE.read_text().split("    $ maviper demo -o demo\n")
    session, after = rest.split("\nThe folder `demo/` then")
    found = tours[1][0].stderr
    if request.config.getoption("--update-golden"):
        again = "".join(f"    {line}\n" if line else "\n" for line in lasting(found))
        PAGE.write_text(f"{before}    $ maviper demo -o demo\n{again}\nThe folder `demo/` then{after}")
        return

    def timeless(text):
        return [re.sub(r"  [\d.]+/s  \d+ s left", "", line.strip()) for line in lasting(text) if line.strip()]

    assert timeless(found) == timeless(session)


def test_two_runs_leave_equal_bytes(tours):
    folders, _ = tours
    first, second = ({path.name: path.read_bytes() for path in folder.iterdir()} for folder in folders)
    assert first == second
    assert "report.html" in first and "physical_deception.h" in first


def test_nothing_in_the_files_speaks_of_the_machine(tours):
    import platform

    folders, _ = tours
    for path in folders[0].iterdir():
        text = path.read_text()
        for fact in (str(folders[0]), "/tmp/", "/home/", platform.node(), platform.release()):
            assert fact not in text, (path.name, fact)


def test_the_proof_means_something(tours):
    folders, _ = tours
    violated, proved = json.loads((folders[0] / "report.json").read_text())["results"]
    assert violated["verdict"] == "VIOLATED" and len(violated["counterexample"]["replayed_by"]) >= 2
    assert proved["verdict"] == "PROVED" and proved["conflict"]["low"] > 0
    assert proved["shuffled_control"] == "VIOLATED"
    evaluation = json.loads((folders[0] / "profile.json").read_text())["provenance"]["evaluation"]
    assert evaluation["defenders success r=0.316"] >= 0.80 * evaluation["defenders expert success r=0.316"]


def test_the_report_repeats_from_its_own_files(tours, tmp_path, capsys, monkeypatch):
    from maviper.cli import main

    folders, _ = tours
    monkeypatch.chdir(folders[0])
    results = json.loads((folders[0] / "report.json").read_text())["results"]
    for result in results:
        code = main.run([*result["command"].split()[1:], "--json"])
        again = json.loads(capsys.readouterr().out)["results"][0]
        assert code == (0 if result["verdict"] == "PROVED" else 1)
        assert again == result


def test_without_compiler_display_or_torch(tmp_path):
    (tmp_path / "torch.py").write_text("raise ImportError('blocked')")
    process = tour(tmp_path / "demo", CC="no-such-compiler", DISPLAY="", PYTHONPATH=str(tmp_path))
    assert process.returncode == 0, process.stderr
    assert "SKIPPED     C: no compiler found" in process.stderr
