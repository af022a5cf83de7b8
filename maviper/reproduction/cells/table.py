"""The folder of a reproduction: finished cells, claims on those that are being made, and the table of all.

Does: reads and writes cells; lets one process at a time make a cell, and others take over where it died; cells.csv, one
  row for each cell, line-up and measure, with companions named by the cell.
Assumes: a folder that all processes see, whose file system creates files exclusively and renames atomically.
Does not: make cells (making.py); read experts, profiles or settings; compute anything but means.

A claim is the file `claim-K` in the cell's folder. It is created exclusively, and touched every BEAT seconds while its
process lives. It is stale once it was not touched for STALE seconds by the file system's own clock (NAMELESS seconds if
it is empty), or when its process was one of this machine and is gone. Whoever takes a stale claim over creates
claim-(K+1), so that only one of several can. A finished cell has cell.json, which is written last; a cell that two
processes made nevertheless, because one slept longer than STALE, is the same bytes twice.
"""

import contextlib
import csv
import io
import math
import os
import socket
import tempfile
import threading
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path

import msgspec

from maviper.files import runs
from maviper.reproduction.cells.cell import DONE, FAILED, KINDS, Cell, Document, Made, tool
from maviper.reproduction.cells.making import EPISODES_FILE, FACTS_FILE, HEAD

CELLS, CELL_FILE, CLAIM = "cells", "cell.json", "claim-"
MAX_CELL_BYTES, MAX_PROFILE_BYTES = 2**22, 2**26
BEAT, STALE = 15.0, 120.0  # seconds
NAMELESS = 2.0  # seconds, after which whoever made an empty claim was killed before writing down who it is


class Store:
    """The cells in a folder. Claims are held, and kept fresh, between `with` and its end."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.cells = folder, folder / CELLS
        self._held: dict[str, Path] = {}
        self._lock, self._over = threading.Lock(), threading.Event()
        self._beating: threading.Thread | None = None

    def __enter__(self) -> "Store":
        self._over.clear()
        self._beating = threading.Thread(target=self._beat, daemon=True)
        self._beating.start()
        return self

    def __exit__(self, *caught: object) -> None:
        self._over.set()
        assert self._beating is not None
        self._beating.join()
        for id_ in list(self._held):
            self.release(id_)

    def _beat(self) -> None:
        while not self._over.wait(BEAT):
            with self._lock:
                for place in self._held.values():
                    with contextlib.suppress(OSError):  # taken away by hand, say; the cell is then made twice
                        os.utime(place)

    # --- what is there

    def document(self, id_: str) -> Document | None:
        """The cell.json of a cell that was made or failed; None where there is none, or none that can be read."""
        try:
            return msgspec.json.decode(runs.read(self.cells / id_ / CELL_FILE, MAX_CELL_BYTES), type=Document)
        except (runs.InputError, msgspec.MsgspecError, UnicodeDecodeError):
            return None

    def documents(self) -> Iterator[tuple[str, Document]]:
        """Every cell that can be read, in the order of names."""
        for place in sorted(self.cells.glob("*/" + CELL_FILE)):
            document = self.document(place.parent.name)
            if document is not None:
                yield place.parent.name, document

    def is_done(self, id_: str) -> bool:
        """Returns True if a cell is finished."""
        document = self.document(id_)
        return document is not None and document.outcome == DONE

    def profile(self, id_: str) -> bytes:
        """The profile of a finished extraction."""
        return runs.read(self.cells / id_ / runs.PROFILE_FILE, MAX_PROFILE_BYTES)

    def write(self, made: Made) -> None:
        """Keeps a cell, and gives its claim back."""
        place = self.cells / made.id
        for old in place.glob("*"):  # of a try that failed, say
            if old.name not in made.files and not old.name.startswith(CLAIM):
                old.unlink(missing_ok=True)
        for name, data in made.files.items():
            runs.write(place / name, data)
        runs.write(place / CELL_FILE, runs.as_json(asdict(made.document)))
        self.release(made.id)

    # --- claims

    def claim(self, id_: str) -> bool:
        """Claims a cell; returns True unless it is finished or a living process is making it."""
        place = runs.folder(self.cells / id_)
        last = max((_number(each) for each in place.glob(CLAIM + "*")), default=-1)
        if self.is_done(id_) or (last >= 0 and not _stale(place / f"{CLAIM}{last}")):
            return False
        mine = place / f"{CLAIM}{last + 1}"
        with self._lock:
            try:
                with mine.open("x", encoding="utf-8") as file:
                    file.write(f"{_machine()} {os.getpid()}\n")
            except FileExistsError:
                return False
            except OSError as error:
                raise runs.unwritten(mine, error) from None
            self._held[id_] = mine
        if self.is_done(id_):  # it was finished between the look and the claim
            self.release(id_)
            return False
        return True

    def release(self, id_: str) -> None:
        """Gives a claim back, with those that it took over."""
        with self._lock:
            mine = self._held.get(id_)
            if mine is None:
                return
            for place in mine.parent.glob(CLAIM + "*"):
                if _number(place) <= _number(mine):
                    place.unlink(missing_ok=True)
            del self._held[id_]  # at last: an interrupt before leaves it to the end of the `with`

    def drop_claims(self, id_: str) -> None:
        """Takes away the claims on a finished cell, which whoever was killed before giving them back has left."""
        for place in (self.cells / id_).glob(CLAIM + "*"):
            place.unlink(missing_ok=True)

    @property
    def held(self) -> Mapping[str, Path]:
        """The claims of this process."""
        return dict(self._held)


def _number(place: Path) -> int:
    text = place.name.removeprefix(CLAIM)
    return int(text) if text.isdigit() else -1


def _machine() -> str:
    """Returns a name that tells machines apart whose processes have numbers of their own."""
    with contextlib.suppress(OSError):
        boot = Path("/proc/sys/kernel/random/boot_id").read_text(encoding="ascii").strip()
        return f"{socket.gethostname()}/{boot}/{Path('/proc/self/ns/pid').readlink()}".replace(" ", "-")
    return socket.gethostname().replace(" ", "-")


def _stale(place: Path) -> bool:
    try:
        owner, _, process = place.read_text(encoding="utf-8").strip().rpartition(" ")
        if owner == _machine() and process.isdigit() and os.name == "posix" and _is_gone(int(process)):
            return True
        with tempfile.TemporaryFile(dir=place.parent) as fresh:  # its time is the file system's own
            return os.fstat(fresh.fileno()).st_mtime - place.stat().st_mtime > (STALE if process else NAMELESS)
    except FileNotFoundError:  # given back meanwhile
        return False
    except OSError as error:
        raise runs.unwritten(place, error) from None


def _is_gone(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return True
    except PermissionError:
        return False
    return False


TABLE_FILE, EPISODES_FOLDER, FACTS_FOLDER = "cells.csv", "episodes", "facts"
MAX_EPISODES_BYTES = 2**28
ABOUT = tuple(field.name for field in fields(Cell))  # the columns that say what a cell is
COLUMNS = ("cell", *ABOUT, "lineup", "measure", "higher_is_better", "episodes", "mean", "cpu_seconds")


@dataclass(frozen=True)
class Kept:
    """The cells of a folder that count, and how many do not."""

    cells: dict[str, Document]  # id -> its document, in the table's order
    other: int  # cells of another version of the tool, or of other claims
    doubled: int  # cells that stand for the same as one that counts: another expert of the same label, say
    failed: dict[str, Document]


def find_finished(store: Store, wanted: Collection[str], register: str) -> Kept:
    """The finished cells of this version and register; of two about the same, the one that is `wanted` now."""
    finished: dict[Cell, tuple[str, Document]] = {}
    other = doubled = 0
    failed: dict[str, Document] = {}
    for id_, document in store.documents():
        identity = document.identity
        if (identity.get("tool"), identity.get("register")) != (tool(), register):
            other += 1
        elif document.outcome == FAILED:
            failed[id_] = document
        elif document.outcome == DONE:
            doubled += document.cell in finished
            if document.cell not in finished or id_ in wanted:
                finished[document.cell] = id_, document
    ordered = sorted(finished, key=_place)
    return Kept(dict(finished[cell] for cell in ordered), other, doubled, failed)


def _place(cell: Cell) -> tuple[int, Cell | tuple[str | int, ...]]:
    known = KINDS.index(cell.kind) if cell.kind in KINDS else len(KINDS)
    return known, tuple(getattr(cell, name) for name in ABOUT)


def write(store: Store, cells: dict[str, Document]) -> Path:
    """Writes cells.csv and its companions, and removes companions of cells that are not in it."""
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(COLUMNS)
    for id_, document in cells.items():
        about = [getattr(document.cell, name) for name in ABOUT]
        data = runs.read(store.cells / id_ / EPISODES_FILE, MAX_EPISODES_BYTES).decode()
        for lineup, measure, values in _means(data):
            higher = int(measure not in document.lower_is_better)
            mean = math.fsum(values) / len(values)
            row = [id_, *about, lineup, measure, higher, len(values), repr(mean), document.cpu_seconds]
            table.writerow(row)
    for name, source in ((EPISODES_FOLDER, EPISODES_FILE), (FACTS_FOLDER, FACTS_FILE)):
        _companions(store, store.folder / name, source, list(cells))
    return runs.write(store.folder / TABLE_FILE, text.getvalue())


def _means(data: str) -> Iterator[tuple[str, str, list[float]]]:
    """Line-up, measure and the values of all its episodes, in the order of the file, sorted by name."""
    by_lineup: dict[tuple[str, str], list[float]] = {}
    for row in csv.reader(io.StringIO(data.removeprefix(HEAD))):
        by_lineup.setdefault((row[0], row[1]), []).append(float(row[3]))
    return ((lineup, measure, values) for (lineup, measure), values in sorted(by_lineup.items()))


def _companions(store: Store, folder: Path, source: str, ids: Sequence[str]) -> None:
    """Files of cells under the cells' names; the same file on disk where the file system can do that."""
    runs.folder(folder)
    ending = Path(source).suffix
    wanted = {f"{id_}{ending}" for id_ in ids}
    for place in folder.glob(f"*{ending}"):
        if place.name not in wanted:
            place.unlink(missing_ok=True)
    for id_ in ids:
        place, origin = folder / f"{id_}{ending}", store.cells / id_ / source
        if place.exists() and place.stat().st_size == origin.stat().st_size:
            continue
        place.unlink(missing_ok=True)
        with contextlib.suppress(OSError):
            os.link(origin, place)
        if not place.exists():
            runs.write(place, runs.read(origin, MAX_EPISODES_BYTES))
