"""A reproduction killed at any instant: finished cells stay, and the same call again ends as if nothing was."""

import os
import signal
import sys

import pytest

from maviper.reproduction import run
from maviper.reproduction.cells import store
from maviper.reproduction.cells.store import CELL_FILE, Store
from tests.maviper.reproduction.small import cheap, contents, reproduced

TINY = {"games": ("physical-deception",), "depths": (4,), "seeds": 1}
CALLS = ("open", "os.rename", "os.link", "os.remove", "os.mkdir", "os.rmdir", "os.scandir", "os.listdir", "os.utime")
OTHERS = 12  # instants between the first and the last call


def killed_at(folder, last):
    """Whether a reproduction in a process of its own is killed at its call `last`, and how many calls it makes."""
    told, tell = os.pipe()
    process = os.fork()
    if not process:
        calls = 0

        def count(event, _):
            nonlocal calls
            if event in CALLS:
                calls += 1
                if calls == last:
                    os.kill(os.getpid(), signal.SIGKILL)

        sys.addaudithook(count)
        try:
            reproduced(folder, **TINY)
            os.write(tell, str(calls).encode())
        finally:
            os._exit(0)
    os.close(tell)
    _, status = os.waitpid(process, 0)
    with os.fdopen(told) as said:
        return os.WIFSIGNALED(status), int(said.read() or 0)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="a process is forked, and killed by a signal")
def test_a_reproduction_killed_at_many_of_its_calls(tmp_path, monkeypatch):
    for module, name, value in ((run, "made", cheap()), (run, "POLL", 0.02), (store, "NAMELESS", 0.05)):
        monkeypatch.setattr(module, name, value)
    reproduced(tmp_path / "whole", **TINY)  # which also imports what a process imports once
    cut, total = killed_at(tmp_path / "counted", 0)
    assert not cut and total > 100
    whole, found = contents(tmp_path / "whole"), set()
    for last in range(1, total, total // OTHERS):
        folder = tmp_path / str(last)
        cut, _ = killed_at(folder, last)
        assert cut
        left = {place.parent.name for place in folder.rglob(CELL_FILE)}
        found.add(len(left))
        assert all(Store(folder).done(cell) for cell in left)
        again = reproduced(folder, **TINY)
        assert again.made == len(again.plan.tasks) - len(left)
        assert set(contents(folder)) == set(whole)
        assert contents(folder) == whole
        assert not [place for place in folder.rglob("*") if place.name.startswith((".", "claim-"))]
    assert len(found) > OTHERS // 2
