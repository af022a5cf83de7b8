"""Files and sets of files: whole, all or none, claimed once, and no scratch stays."""

import lzma
import os
import signal
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from codegen.errors import InputError, MissingToolError
from maviper.files import runs

CONFIG = {"format": "x-1", "settings": {}, "command": "x"}
SET = {"a": "first", "deeper/b": b"second", "c": "third" * 1000}


def contents(folder):
    return {path.relative_to(folder).as_posix(): path.read_text() for path in folder.rglob("*") if path.is_file()}


OLD = {"a": "old a", "c": "old c", "mine": "untouched"}


@pytest.fixture(params=["no folder", "old files"])
def folder(request, tmp_path):
    place = tmp_path / "out"
    if request.param == "old files":
        for name, text in OLD.items():
            runs.write(place / name, text)
    return place


def test_a_set_of_files(folder):
    old = contents(folder) if folder.exists() else {}
    runs.write_all(folder, SET)
    new = {name: text if isinstance(text, str) else text.decode() for name, text in SET.items()}
    assert contents(folder) == old | new and not list(folder.parent.rglob("*.part"))


@pytest.mark.parametrize("when", range(3))
def test_a_set_that_cannot_be_written_changes_nothing(folder, when, monkeypatch):
    """The disk is full at each file of the set in turn."""
    before, written = contents(folder) if folder.exists() else None, []

    def full(file, content):
        written.append(content)
        if len(written) > when:
            raise OSError(28, "No space left on device")
        file.write(content.encode() if isinstance(content, str) else content)

    monkeypatch.setattr(runs, "_fill", full)
    with pytest.raises(MissingToolError, match="cannot write"):
        runs.write_all(folder, SET)
    assert (contents(folder) if folder.exists() else None) == before and not list(folder.parent.rglob("*.part"))


@pytest.mark.parametrize("stop", [OSError(5, "Input/output error"), KeyboardInterrupt()], ids=["error", "Ctrl-C"])
@pytest.mark.parametrize("when", range(3))
def test_a_set_that_cannot_be_moved_is_moved_back(tmp_path, when, stop, monkeypatch):
    place = tmp_path / "out"
    for name, text in OLD.items():
        runs.write(place / name, text)
    replace, moved = Path.replace, []

    def stopped(self, target):
        if "files" in self.parent.name or "files" in self.parent.parent.name:
            moved.append(target)
            if len(moved) > when:
                raise stop
        return replace(self, target)

    monkeypatch.setattr(Path, "replace", stopped)
    with pytest.raises(InputError if isinstance(stop, OSError) else KeyboardInterrupt):
        runs.write_all(place, SET)
    assert contents(place) == OLD and len(moved) == when + 1


def test_a_folder_in_the_way_of_a_file(tmp_path):
    (tmp_path / "c").mkdir()
    runs.write(tmp_path / "a", "old a")
    with pytest.raises(InputError, match="cannot write"):
        runs.write_all(tmp_path, SET)
    assert contents(tmp_path) == {"a": "old a"}


LIMITED = """
import resource, signal, sys
from maviper.cli import main
from maviper.files import runs
write_all = runs.write_all
def limited(*given):  # from here on: what is compiled to be replayed is larger
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))
    write_all(*given)
runs.write_all = limited
sys.exit(main.run(["-q", "compile", sys.argv[1], "--target", "c,python,json", "-o", sys.argv[2]]))
"""


@pytest.mark.compile
def test_compile_writes_all_or_nothing(tmp_path):
    """Files may have 20,000 bytes: some of the set are smaller, the header is larger."""
    profile = Path(__file__).parents[3] / "generated" / "physical_deception" / "profile.json"
    command = [sys.executable, "-c", LIMITED, str(profile), str(tmp_path / "out")]
    ended = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    assert ended.returncode == 2 and "File too large" in ended.stderr, ended
    assert list(tmp_path.iterdir()) == []


def scratch_of(process):
    return f".file.{process}-0.maviper.part"


HOLDING = """
import sys, time
from pathlib import Path
from maviper.files.runs import scratch_file, scratch_folder
with scratch_file(Path("file")), scratch_folder(Path("folder")):
    print("ready", flush=True)
    time.sleep(60)
"""


@pytest.mark.skipif(runs.fcntl is None, reason="no file locks here")
def test_scratch_of_a_killed_process_is_removed_and_that_of_a_living_one_is_not(tmp_path):
    process = subprocess.Popen([sys.executable, "-c", HOLDING], cwd=tmp_path, stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout.readline() == "ready\n"
        (tmp_path / ".notes.1-2.part").write_text("somebody else's")
        held = sorted(path.name for path in tmp_path.iterdir())
        assert len(held) == 3
        runs.write(tmp_path / "file", "mine")
        assert sorted(path.name for path in tmp_path.iterdir()) == sorted([*held, "file"])
        process.send_signal(signal.SIGKILL)
        process.wait(timeout=30)
        assert sorted(path.name for path in tmp_path.iterdir()) == sorted([*held, "file"])
        runs._swept.clear()  # as another process begins
        runs.write(tmp_path / "file", "mine again")
        assert sorted(path.name for path in tmp_path.iterdir()) == [".notes.1-2.part", "file"]
    finally:
        process.kill()
        process.communicate()


def claimed(folder):
    try:
        return not runs.claim(folder, CONFIG, (), False)
    except InputError:
        return False


def test_of_several_threads_one_claims_a_folder(tmp_path):
    with ThreadPoolExecutor(4) as pool:
        for attempt in range(100):
            assert sum(pool.map(claimed, [tmp_path / str(attempt)] * 4)) == 1
            assert [path.name for path in (tmp_path / str(attempt)).iterdir()] == [runs.CONFIG_FILE]


CLAIMING = """
import sys
from pathlib import Path
from tests.maviper.files.test_writing import claimed
sys.stdin.readline()
print("".join(str(int(claimed(Path(sys.argv[1]) / str(attempt)))) for attempt in range(100)))
"""


def test_of_several_processes_one_claims_a_folder(tmp_path):
    command, root = [sys.executable, "-c", CLAIMING, str(tmp_path)], Path(__file__).parents[3]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True, "cwd": root}
    processes = [subprocess.Popen(command, **pipes) for _ in range(3)]
    for process in processes:
        process.stdin.write("go\n")
        process.stdin.flush()
    told = [process.communicate(timeout=120)[0].strip() for process in processes]
    assert [sum(map(int, each)) for each in zip(*told, strict=True)] == [1] * 100, told


def test_of_several_threads_one_creates_a_file(tmp_path):
    with ThreadPoolExecutor(4) as pool:
        for attempt in range(50):
            path = tmp_path / str(attempt)
            made = list(pool.map(lambda number, path=path: runs.create(path, f"{number}"), range(4)))
            assert sum(made) == 1 and path.read_text() == str(made.index(True))


def test_nothing_is_left_of_looking_for_room(tmp_path):
    runs.room(tmp_path / "a" / "b")
    assert list(tmp_path.iterdir()) == []
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError):
        runs.room(tmp_path / "file")


def test_a_packed_file_is_read_as_what_it_packs(tmp_path):
    path = tmp_path / "a.json.xz"
    path.write_bytes(lzma.compress(b"{}"))
    assert runs.read_unpacked(path, 100) == b"{}"
    plain = tmp_path / "a.json"
    plain.write_bytes(path.read_bytes())
    assert runs.read_unpacked(plain, 100) == path.read_bytes()  # a name says whether a file is packed


DAMAGED = {  # made when it is asked for: to pack takes long
    "plain": (lambda: b"{}", "cannot unpack"),
    "cut": (lambda: lzma.compress(b"{}")[:-4], "its end is missing"),
    "followed": (lambda: lzma.compress(b"{}") + b"more", "something follows it"),
    "twice": (lambda: lzma.compress(b"{}") * 2, "something follows it"),
    "of the old form": (lambda: lzma.compress(b"{}", lzma.FORMAT_ALONE), "cannot unpack"),
    "bomb": (lambda: lzma.compress(bytes(2**20)), "unpacks to more than 4096 bytes"),
    "memory": (lambda: lzma.compress(b"{}", filters=[{"id": lzma.FILTER_LZMA2, "dict_size": 2**28}]), "cannot unpack"),
}


@pytest.mark.parametrize("name", DAMAGED)
def test_a_packed_file_that_is_damaged_or_a_bomb_is_refused(tmp_path, name):
    make, said = DAMAGED[name]
    path = tmp_path / "a.json.xz"
    path.write_bytes(make())
    with pytest.raises(InputError, match=said):
        runs.read_unpacked(path, 2**12)


def test_what_is_no_file_is_not_replaced(tmp_path):
    """For root a rename would put a file where a device was, such as /dev/null."""
    place = tmp_path / "pipe"
    os.mkfifo(place)
    for refuses in (lambda: runs.write(place, "text"), lambda: runs.target(place)):
        with pytest.raises(InputError, match="device or a pipe"):
            refuses()
    assert place.is_fifo() and [each.name for each in tmp_path.iterdir()] == ["pipe"]
