"""Runs: made once, resumed, shared, and told when something fails."""

import csv
import errno
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import maviper
from codegen.errors import ExitCode, InputError, MissingToolError, UnknownNameError
from maviper.cli import main
from maviper.files import jobs
from maviper.reproduction import grid, run
from maviper.reproduction.cells import cell as cells
from maviper.reproduction.cells import making
from maviper.reproduction.cells.cell import CROSSPLAY, FAILED
from maviper.reproduction.cells.plan import Asked, plan_cells
from tests.maviper.reproduction.small import REAL, cheap, contents, reproduced

GAME = {"games": ("physical-deception",), "depths": (4,), "seeds": 2}


@pytest.fixture
def calls(monkeypatch):
    """The cells that are made, in words; none costs anything."""
    found = []
    monkeypatch.setattr(grid, "make_cell", cheap(found))
    return found


def rows(folder):
    return list(csv.DictReader((folder / "cells.csv").read_text().splitlines()))


def test_a_cell_is_made_once(tmp_path, calls):
    first = reproduced(tmp_path, **GAME)
    assert len(calls) == first.made == len(first.plan.tasks) > 10 and first.code == ExitCode.DONE
    before = contents(tmp_path)
    again = reproduced(tmp_path, **GAME)
    assert len(calls) == first.made and again.made == 0 and contents(tmp_path) == before
    more = reproduced(tmp_path, **{**GAME, "seeds": 3})
    assert more.made == len(calls) - first.made == (len(first.plan.tasks) - 1) // 2


def test_the_table_has_a_row_for_each_lineup_and_measure(tmp_path, calls):
    done = reproduced(tmp_path, **GAME)
    table = rows(tmp_path)
    assert len(table) == len(done.plan.tasks)
    assert list(table[0])[:6] == ["cell", "kind", "game", "expert", "preset", "algorithm"]
    assert list(table[0])[6:] == [
        *("depth", "leaves", "splits", "seed", "lineup", "measure", "higher_is_better", "episodes", "mean"),
        "cpu_seconds",
    ]
    assert {(row["mean"], row["episodes"], row["higher_is_better"]) for row in table} == {("1.0", "2", "1")}
    kinds = [row["kind"] for row in table]
    assert kinds == sorted(kinds, key=cells.KINDS.index)


def test_a_cell_that_fails_is_told_the_rest_goes_on_and_it_is_tried_again(tmp_path, monkeypatch, capsys):
    good = cheap()

    def made(task, profiles):
        if task.cell.algorithm == "iviper":
            document = cells.Document(cells.FORMAT, task.cell, task.identity, FAILED, "it broke", [], 0.0)
            return cells.Made(task.id, document, {"error.txt": b"why"})
        return good(task, profiles)

    monkeypatch.setattr(grid, "make_cell", made)
    asked = ["--games", "physical-deception", "--depths", "4", "--seeds", "1", "-o", str(tmp_path)]
    assert main.run(["reproduce", *asked]) == ExitCode.VIOLATED
    told = capsys.readouterr()
    assert "failed      extraction physical-deception mappo paper iviper depth 4 seed 0: it broke" in told.err
    assert "6 cells failed" in told.out  # the others need it: a crossplay, and four profiles that it answers
    names = {row["algorithm"] for row in rows(tmp_path)}
    assert {"maviper", "imitation"} <= names and "iviper" not in names
    assert not [row for row in rows(tmp_path) if row["kind"] == CROSSPLAY]
    monkeypatch.setattr(grid, "make_cell", good)
    assert main.run(["reproduce", *asked]) == ExitCode.DONE
    assert {"iviper", ""} <= {row["algorithm"] for row in rows(tmp_path)}
    assert not list(tmp_path.rglob("error.txt"))


def test_what_goes_wrong_inside_a_cell_is_its_outcome(monkeypatch):
    def broken(*given):
        raise ZeroDivisionError("by nothing")

    monkeypatch.setattr(making, "_files", broken)
    task = plan_cells(Asked(quick=True), "").tasks[1]
    made = making.make_cell(task, {})
    assert (made.id, made.document.outcome) == (task.id, FAILED)
    assert made.document.message == "ZeroDivisionError: by nothing" and b"by nothing" in made.files["error.txt"]


def test_a_worker_with_another_version_makes_no_cell(monkeypatch):
    task = plan_cells(Asked(quick=True), "").tasks[1]
    assert task.identity["tool"]
    monkeypatch.setattr(making, "tool", lambda: "maviper 0.0.1")
    made = making.make_cell(task, {})
    assert made.document.outcome == FAILED and "the worker has maviper 0.0.1" in made.document.message


def test_cells_of_another_version_are_ignored_with_a_note(tmp_path, calls, monkeypatch, capsys):
    monkeypatch.setattr(cells, "version", lambda: "0.0.1")
    asked = ["--games", "physical-deception", "--depths", "4", "--seeds", "1", "-o", str(tmp_path)]
    assert main.run(["reproduce", *asked]) == ExitCode.DONE
    old = {row["cell"] for row in rows(tmp_path)}
    monkeypatch.undo()
    monkeypatch.setattr(grid, "make_cell", cheap())
    assert main.run(["reproduce", *asked]) == ExitCode.DONE
    assert f"{len(old)} cells of another version of maviper" in capsys.readouterr().err
    assert not old & {row["cell"] for row in rows(tmp_path)}


def test_report_only_makes_nothing(tmp_path, calls):
    with pytest.raises(InputError, match="no finished cells"):
        reproduced(tmp_path, report_only=True, **GAME)
    reproduced(tmp_path, **GAME)
    (tmp_path / "cells.csv").unlink()
    count = len(calls)
    reproduced(tmp_path, report_only=True, **GAME)
    assert len(calls) == count == len(rows(tmp_path))


def test_plan_says_cells_and_cpu_time_and_touches_nothing(tmp_path, capsys):
    place = tmp_path / "none"
    assert main.run(["reproduce", "--quick", "--plan", "-o", str(place)]) == ExitCode.DONE
    lines = capsys.readouterr().out.splitlines()
    count = len(plan_cells(Asked(quick=True), "").tasks)
    assert lines[-1].startswith(f"{count} cells, 0 of them finished; ") and not place.exists()
    counts = [int(line.split()[0]) for line in lines[1:-1] if line.split()[1].isdigit()]
    assert sum(counts) == count and lines[0].split() == ["cells", "CPU", "s", "what"]


def test_shards_make_the_same_folder_as_one_run(tmp_path, calls):
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    reproduced(whole, **GAME)
    made = [reproduced(parts, shard=f"{number}/3", **GAME).made for number in (3, 1, 2)]
    assert sum(made) == len(rows(whole)) and contents(parts) == contents(whole)


def test_a_cell_of_another_process_is_waited_for(tmp_path, calls, monkeypatch):
    from maviper.reproduction.cells.table import Store

    monkeypatch.setattr(grid, "POLL", 0.05)
    task = plan_cells(run.request(GAME), run.register.read().sha256).tasks[1]
    with Store(tmp_path) as other:
        assert other.claim(task.id)
        looks = []

        def finish(seconds):
            if seconds == grid.POLL:  # not another thread's
                looks.append(seconds)
                other.write(cheap()(task, {}))

        monkeypatch.setattr(grid.time, "sleep", finish)
        done = reproduced(tmp_path, **GAME)
    assert looks == [0.05] and task.cell.said not in calls
    assert done.made == len(done.plan.tasks) - 1 == len(calls)


def test_a_full_disk_ends_the_run_with_5_and_keeps_whole_files(tmp_path, calls, monkeypatch, capsys):
    written, replace = [], Path.replace

    def full(self, target):
        if tmp_path in Path(target).parents:  # not another thread's
            written.append(target)
        if len(written) > 9:
            raise OSError(errno.ENOSPC, "No space left on device")
        return replace(self, target)

    monkeypatch.setattr(Path, "replace", full)
    asked = ["--games", "physical-deception", "--depths", "4", "--seeds", "1", "-o", str(tmp_path)]
    assert main.run(["reproduce", *asked]) == ExitCode.MISSING
    told = [line for line in capsys.readouterr().err.splitlines() if line.startswith("error:")]
    assert len(told) == 1 and told[0].startswith("error: cannot write")
    assert not list(tmp_path.rglob("claim-*")) and not list(tmp_path.rglob("*.part"))
    count = len(calls)
    monkeypatch.undo()
    monkeypatch.setattr(grid, "make_cell", cheap(calls))
    assert main.run(["reproduce", *asked]) == ExitCode.DONE
    assert len(calls) == len(rows(tmp_path)) + 1 and count == 3  # the third could not be written


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"shard": "0/3"}, "no shard"),
        ({"shard": "4/3"}, "no shard"),
        ({"shard": "half"}, "no shard"),
        ({"jobs": 0}, "--jobs"),
        ({"seeds": 0}, "--seeds"),
        ({"depths": (0,)}, "depth"),
        ({"backend": "ray"}, "backend"),
        ({"backend": "dask", "jobs": 2}, "workers"),
        ({"games": ("tag",)}, "game"),
        ({"experts": ("nobody",)}, "expert"),
    ],
)
def test_bad_options_are_told_before_anything_is_made(tmp_path, calls, options, said):
    with pytest.raises((InputError, UnknownNameError), match=said):
        reproduced(tmp_path / "new", **options)
    assert not calls and not (tmp_path / "new").exists()


def test_dask_without_dask_is_told(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(MissingToolError, match="Dask is not installed") as error:
        list(jobs.on_dask(len, [], "tcp://127.0.0.1:1"))
    assert "maviper[scale]" in error.value.next_step


# --- for real


@pytest.fixture(scope="module")
def real(tmp_path_factory):
    folder = tmp_path_factory.mktemp("real")
    return folder, reproduced(folder, **REAL)


@pytest.mark.slow
def test_two_jobs_and_the_python_verb_give_the_same_bytes(real, tmp_path):
    folder, _ = real
    cell = next(row["cell"] for row in rows(folder) if row["lineup"] == "all")
    lineups = {row["lineup"]: row["measure"] for row in rows(folder) if row["cell"] == cell}
    agents = {f"individual:{agent}" for agent in ("adversary_0", "agent_0", "agent_1")}
    assert set(lineups) == {"joint:adversaries", "joint:defenders", "all", *agents}
    told = json.loads((folder / "cells" / cell / "facts.json").read_text())
    assert set(told["trees"]) == {"adversary_0", "agent_0", "agent_1"}
    assert all(tree == {"leaves": 2, "depth": 1} for tree in told["trees"].values())


@pytest.mark.slow
def test_values_are_those_that_evaluate_finds(real):
    """Joint and individual line-ups by another way: `maviper.evaluate` on the first of the same episodes."""
    folder, _ = real
    cell = next(row["cell"] for row in rows(folder) if row["lineup"] == "all")
    profile = folder / "cells" / cell / "profile.json"
    found = maviper.evaluate(profile, expert="physical-deception", episodes=200)
    means = {(row["lineup"], row["measure"]): float(row["mean"]) for row in rows(folder) if row["cell"] == cell}
    for standing in found.against["physical-deception"]:
        team, label = standing.measure.team, standing.measure.label
        assert means[f"joint:{team}", label] == pytest.approx(standing.value.value, abs=1e-12)
        for agent, alone in standing.agents.items():
            assert means[f"individual:{agent}", label] == pytest.approx(alone.value.value, abs=1e-12)


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="signals")
def test_ctrl_c_keeps_what_is_finished_and_the_next_call_goes_on(tmp_path):
    asked = [sys.executable, "-m", "maviper", "reproduce", "--games", "physical-deception", "--depths", "1"]
    asked += ["--algorithms", "maviper-iviper-resampling", "--seeds", "2", "--jobs", "2", "-o", str(tmp_path)]
    first = subprocess.Popen(asked, stderr=subprocess.PIPE, text=True)
    while not list(tmp_path.glob("cells/*/cell.json")) and first.poll() is None:
        time.sleep(0.05)
    first.send_signal(signal.SIGINT)
    told = first.communicate(timeout=60)[1]
    assert first.returncode == ExitCode.INTERRUPTED, told
    assert "run the command again" in told and "--resume" not in told
    assert not list(tmp_path.rglob("claim-*"))
    kept = {path: path.stat().st_mtime_ns for path in tmp_path.glob("cells/*/cell.json")}
    assert subprocess.run(asked, check=False, capture_output=True).returncode == ExitCode.DONE
    assert len(rows(tmp_path)) > len(kept) and all(path.stat().st_mtime_ns == then for path, then in kept.items())


@pytest.mark.slow
def test_two_processes_share_a_folder(tmp_path):
    asked = [sys.executable, "-m", "maviper", "reproduce", "--games", "physical-deception", "--depths", "1"]
    asked += ["--algorithms", "maviper-iviper-resampling", "--seeds", "3", "-o", str(tmp_path)]
    both = [subprocess.Popen(asked, stderr=subprocess.PIPE, text=True) for _ in range(2)]
    told = [each.communicate(timeout=300)[1] for each in both]
    assert [each.returncode for each in both] == [0, 0], told
    counts = [int(text.partition("cells, ")[2].split()[0]) for text in told]
    assert sum(counts) == 4, told  # nothing was made twice
