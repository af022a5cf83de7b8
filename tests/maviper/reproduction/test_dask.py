"""Dask for real, under reproduce, compare and verify: a scheduler and two workers on the loopback, of which one is
killed, and then the scheduler.
"""

import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest

from codegen.errors import ExitCode, InputError, MissingToolError
from maviper.files import jobs
from tests.maviper.reproduction.small import contents

pytest.importorskip("distributed", reason="the extra maviper[scale] is not installed")
pytestmark = pytest.mark.slow
ROOT = Path(__file__).parents[3]
GRID = ["--depths", "1", "--algorithms", "maviper-iviper-resampling", "--seeds", "10"]
ASKED = {
    "reproduce": ["reproduce", "--games", "physical-deception", *GRID],
    "compare": ["compare", "physical-deception", "--max-episodes", "2000", *GRID],
}
CELLS = {"reproduce": 11, "compare": 20}  # enough of them that some are open when two are finished
PATIENCE = 300.0  # seconds, on a busy machine


def until(what):
    end = time.monotonic() + PATIENCE
    while not what():
        assert time.monotonic() < end
        time.sleep(0.1)


def free_port():
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return found.getsockname()[1]


def answers(port):
    with socket.socket() as asking:
        return asking.connect_ex(("127.0.0.1", port)) == 0


class Cluster:
    """A scheduler and two workers, each a process of its own."""

    def __init__(self, folder):
        self.address = f"tcp://127.0.0.1:{(port := free_port())}"
        self.folder = folder
        self.scheduler = self._start("scheduler", "--host", "127.0.0.1", "--port", str(port))
        until(lambda: answers(port))
        self.workers = [self._start("worker", self.address, "--nthreads", "1", "--no-nanny") for _ in range(2)]

    def _start(self, name, *options):
        command = [sys.executable, "-m", f"distributed.cli.dask_{name}", "--no-dashboard", *options]
        with (self.folder / f"{name}.log").open("ab") as log:
            return subprocess.Popen(command, stdout=log, stderr=log, cwd=self.folder, start_new_session=True)

    def stop(self):
        for process in (*self.workers, self.scheduler):
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


@pytest.fixture
def cluster(tmp_path):
    found = Cluster(tmp_path)
    yield found
    found.stop()


@pytest.fixture(scope="module", params=["compare", pytest.param("reproduce", marks=pytest.mark.nightly)])
def local(request, tmp_path_factory):
    """A verb, and what it writes on this machine alone."""
    folder = tmp_path_factory.mktemp("local")
    assert subprocess.run([*command(request.param, folder), "--jobs", "2"], check=False).returncode == ExitCode.DONE
    return request.param, contents(folder)


def command(verb, folder):
    return [sys.executable, "-m", "maviper", *ASKED[verb], "-o", str(folder)]


def started(verb, folder, cluster):
    asked = [*command(verb, folder), "--backend", "dask"]
    variables = {**os.environ, "DASK_SCHEDULER_ADDRESS": cluster.address}
    process = subprocess.Popen(asked, stderr=subprocess.PIPE, text=True, env=variables)
    until(lambda: len(finished(folder)) > 1 or process.poll() is not None)
    return process


def finished(folder):
    return {path.parent.name: path.stat().st_mtime_ns for path in folder.glob("cells/*/cell.json")}


def test_a_lost_worker_changes_nothing(cluster, local, tmp_path):
    folder, (verb, whole) = tmp_path / "out", local
    process = started(verb, folder, cluster)
    before = finished(folder)
    cluster.workers[0].kill()
    told = process.communicate(timeout=PATIENCE)[1]
    assert process.returncode == ExitCode.DONE, told
    assert 1 < len(before) < CELLS[verb] and before.items() <= finished(folder).items()
    assert contents(folder) == whole


def test_a_lost_scheduler_ends_the_run_and_another_run_finishes_it(cluster, local, tmp_path):
    folder, (verb, whole) = tmp_path / "out", local
    process = started(verb, folder, cluster)
    cluster.scheduler.kill()
    told = process.communicate(timeout=PATIENCE)[1]
    assert process.returncode == ExitCode.MISSING, told
    assert "error: the connection to the Dask scheduler is lost" in told and "Traceback" not in told
    before = finished(folder)
    assert 1 < len(before) < CELLS[verb] and not list(folder.rglob("claim-*"))
    assert subprocess.run(command(verb, folder), check=False).returncode == ExitCode.DONE
    assert before.items() <= finished(folder).items() and contents(folder) == whole


def test_claims_by_workers_of_whom_one_is_lost_give_the_same_bytes(cluster, tmp_path):
    subject = ROOT / "generated" / "physical_deception" / "extracted" / "profile.json"
    claims = [word for name in ("distinct_targets", "alive_leaves", "stays_in(steps=5)") for word in ("--claim", name)]
    variables = {**os.environ, "DASK_SCHEDULER_ADDRESS": cluster.address}
    said = []
    for number, more in enumerate(([], ["--jobs", "dask"])):
        asked = ["verify", str(subject), *claims, "-o", "report", *more]
        (tmp_path / str(number)).mkdir()
        process = subprocess.Popen(
            [sys.executable, "-m", "maviper", *asked],
            cwd=tmp_path / str(number),
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env=variables,
        )
        if more:
            until(lambda: b"Receive client connection" in (tmp_path / "scheduler.log").read_bytes())
            cluster.workers[0].kill()
        told = process.communicate(timeout=PATIENCE)[0]
        files = {path.name: path.read_bytes() for path in (tmp_path / str(number) / "report").iterdir()}
        said.append((process.returncode, told, files))
    assert said[0] == said[1] and said[0][0] == ExitCode.VIOLATED


def test_a_scheduler_that_does_not_answer_is_told(monkeypatch):
    monkeypatch.setattr(jobs, "CONNECT_SECONDS", 0.5)
    monkeypatch.delenv("DASK_SCHEDULER_ADDRESS", raising=False)
    with pytest.raises(MissingToolError, match="no Dask scheduler answers"):
        list(jobs.on_dask(len, [], f"tcp://127.0.0.1:{free_port()}"))
    with pytest.raises(InputError, match="scheduler is not said"):
        list(jobs.on_dask(len, [], None))
