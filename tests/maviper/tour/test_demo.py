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
        assert "0 differ" in process.stderr
        said = [line.split()[0] for line in process.stderr.splitlines() if not line.startswith(" ")]
        stages = ["expert", "extracted", "VIOLATED", "repaired", "PROVED", "accepted", "code", "report", "next"]
        assert [word for word in said if word in stages] == stages
        assert all(len(line) <= 100 for line in process.stderr.splitlines())


@pytest.mark.compile
def test_the_tours_session_is_a_real_one(tours, request):
    """The session in the manual's tour, line by line."""
    before, rest = PAGE.read_text().split("    $ maviper demo -o demo\n")
    session, after = rest.split("\n- `expert`", 1)
    found = tours[1][0].stderr
    if request.config.getoption("--update-golden"):
        again = "".join(f"    {line}\n" for line in found.splitlines())
        PAGE.write_text(f"{before}    $ maviper demo -o demo\n{again}\n- `expert`{after}")
        return

    assert found.splitlines() == [line.removeprefix("    ") for line in session.splitlines()]


def files_of(folder):
    return {str(path.relative_to(folder)): path for path in sorted(folder.rglob("*")) if path.is_file()}


def test_two_runs_leave_equal_bytes(tours):
    folders, _ = tours
    first, second = ({name: path.read_bytes() for name, path in files_of(folder).items()} for folder in folders)
    assert first == second
    assert {"report.html", "physical_deception.h", "extracted/report.html"} <= set(first)


def test_nothing_in_the_files_speaks_of_the_machine(tours):
    import platform

    folders, _ = tours
    for name, path in files_of(folders[0]).items():
        text = path.read_text()
        for fact in (str(folders[0]), "/tmp/", "/home/", platform.release()):
            assert fact not in text, (name, fact)
        # a name of its own, not letters within the packed weights of a page
        assert not re.search(rf"(?<![\w+/]){re.escape(platform.node())}(?![\w+/])", text), name


def results_of(folder):
    return json.loads((folder / "report.json").read_text())["results"]


def test_the_proof_means_something(tours):
    folders, _ = tours
    (violated,), (proved,) = results_of(folders[0] / "extracted"), results_of(folders[0])
    assert violated["verdict"] == "VIOLATED" and len(violated["counterexample"]["replayed_by"]) >= 2
    assert proved["verdict"] == "PROVED" and proved["conflict"]["low"] > 0
    assert proved["of_start"] == {"share": 1.0, "low": 1.0, "high": 1.0, "exact": True}
    assert proved["shuffled_control"] == "VIOLATED"
    evaluation = json.loads((folders[0] / "profile.json").read_text())["provenance"]["evaluation"]
    assert evaluation["defenders success r=0.316"] >= 0.95 * evaluation["defenders expert success r=0.316"]


def test_the_commands_give_the_tours_files_again(tours, tmp_path, capsys, monkeypatch):
    from maviper.cli import main

    folders, _ = tours
    monkeypatch.chdir(folders[0])
    assert main.run(["verify", "extracted/profile.json", "-o", str(tmp_path / "before")]) == 1
    assert main.run(["repair", "extracted/profile.json", "--max-depth", "6", "-o", str(tmp_path / "after")]) == 0
    assert main.run(["check", "certificate-1-distinct_targets.json"]) == 0
    for made, kept in (("before", folders[0] / "extracted"), ("after", folders[0])):
        for name, path in files_of(tmp_path / made).items():
            if not name.startswith(("states-", "report.", ".")):  # the tour's reports name the hashes of its code
                assert path.read_bytes() == (kept / name).read_bytes(), name
        assert json.loads((tmp_path / made / "report.json").read_text())["results"] == results_of(kept)


def test_without_compiler_display_or_torch(tmp_path):
    (tmp_path / "torch.py").write_text("raise ImportError('blocked')")
    process = tour(tmp_path / "demo", CC="no-such-compiler", DISPLAY="", PYTHONPATH=str(tmp_path))
    assert process.returncode == 0, process.stderr
    assert "SKIPPED     C: no compiler found" in process.stderr
