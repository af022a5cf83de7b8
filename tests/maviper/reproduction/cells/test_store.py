"""Claims: one process at a time makes a cell, and another takes over where it died."""

import multiprocessing
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from maviper.reproduction.cells import table as stores
from maviper.reproduction.cells.plan import Asked, plan_cells
from maviper.reproduction.cells.table import Store
from tests.maviper.reproduction.small import cheap


def age(store, id_, seconds):
    (place,) = (store.cells / id_).glob("claim-*")
    old = place.stat().st_mtime - seconds
    os.utime(place, (old, old))


def test_one_of_two_has_the_claim_until_it_gives_it_back(tmp_path):
    with Store(tmp_path) as first, Store(tmp_path) as second:
        assert first.claim("a") and not second.claim("a") and not first.claim("a")
        first.release("a")
        assert second.claim("a") and not first.claim("a")
    assert not list(tmp_path.rglob("claim-*"))


def test_a_finished_cell_is_claimed_by_nobody(tmp_path):
    task = plan_cells(Asked(quick=True), "").tasks[0]
    with Store(tmp_path) as store:
        assert store.claim(task.id)
        store.write(cheap()(task, {}))
        assert store.is_done(task.id) and not store.claim(task.id) and not store.held
    assert not list(tmp_path.rglob("claim-*"))


@pytest.mark.skipif(os.name != "posix", reason="processes are asked for by number")
def test_the_claim_of_a_process_that_is_gone_is_taken_over_at_once(tmp_path):
    code = (
        "import os, sys; from pathlib import Path; from maviper.reproduction.cells.table import Store;"
        "store = Store(Path(sys.argv[1])); store.__enter__(); assert store.claim('a'); os._exit(9)"
    )
    assert subprocess.run([sys.executable, "-c", code, str(tmp_path)], check=False).returncode == 9
    with Store(tmp_path) as store:
        assert store.claim("a")
        store.release("a")
    assert not list(tmp_path.rglob("claim-*"))


def test_an_interrupt_while_a_claim_is_given_back_leaves_none(tmp_path, monkeypatch):
    real, told = Path.unlink, []

    def interrupted(place, missing_ok=False):
        told.append(place.name)
        if len(told) == 1:
            raise KeyboardInterrupt
        real(place, missing_ok)

    with pytest.raises(KeyboardInterrupt), Store(tmp_path) as store:
        assert store.claim("a")
        monkeypatch.setattr(Path, "unlink", interrupted)
        store.release("a")
    assert told == ["claim-0"] * 2 and not list(tmp_path.rglob("claim-*"))


def test_a_claim_of_a_process_that_was_killed_before_it_wrote_its_name_is_stale_soon(tmp_path):
    with Store(tmp_path) as store:
        (store.cells / "a").mkdir(parents=True)
        (store.cells / "a" / "claim-0").touch()
        assert not store.claim("a")
        age(store, "a", stores.NAMELESS + 1)
        assert store.claim("a") and [*store.held] == ["a"]
    assert not list(tmp_path.rglob("claim-*"))


def test_a_claim_of_another_machine_is_stale_after_a_while(tmp_path, monkeypatch):
    with Store(tmp_path) as theirs:
        assert theirs.claim("a")
        monkeypatch.setattr(stores, "_machine", lambda: "elsewhere")
        with Store(tmp_path) as mine:
            assert not mine.claim("a")
            age(mine, "a", stores.STALE + 1)
            assert mine.claim("a")


def test_a_claim_is_kept_fresh_while_its_process_lives(tmp_path, monkeypatch):
    monkeypatch.setattr(stores, "BEAT", 0.05)
    monkeypatch.setattr(stores, "_machine", lambda: "elsewhere")
    with Store(tmp_path) as theirs:
        assert theirs.claim("a")
        age(theirs, "a", stores.STALE + 1)
        time.sleep(0.5)
        monkeypatch.setattr(stores, "_machine", lambda: "here")
        assert not Store(tmp_path).claim("a")


def _claimed(folder, count, queue, through):
    with Store(folder) as store:
        for number in range(count):
            if store.claim(f"{number:04d}"):
                queue.put(number)
        queue.put(None)
        through.wait(60)  # holds its claims until the others are through


def test_many_processes_never_have_the_same_claim(tmp_path):
    context = multiprocessing.get_context("spawn")
    queue, through = context.Queue(), context.Event()
    workers = [context.Process(target=_claimed, args=(tmp_path, 50, queue, through)) for _ in range(4)]
    for worker in workers:
        worker.start()
    found, ended = [], 0
    while ended < len(workers):
        number = queue.get(timeout=60)
        ended += number is None
        found += [] if number is None else [number]
    through.set()
    for worker in workers:
        worker.join()
    assert sorted(found) == list(range(50))


def test_a_document_that_cannot_be_read_is_no_cell(tmp_path):
    store = Store(tmp_path)
    (store.cells / "a").mkdir(parents=True)
    (store.cells / "a" / "cell.json").write_text('{"format"')
    assert store.document("a") is None and list(store.documents()) == []
