"""The folder of a reproduction: finished cells, claims on those that are being made, and the table of all.

Does: reads and writes cells; lets one process at a time make a cell, and others take over where it died; cells.csv, one
  row for each cell, line-up and measure; reads the table again, with the episodes and facts of its cells, and checks
  what it reads.
Assumes: a folder that all processes see, whose file system creates files exclusively and renames atomically; a table's
  files are those of one run, written by this version; episodes are named by their held-out seeds.
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
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from codegen.errors import InputError
from codegen.ir import Float64
from maviper.files import runs
from maviper.reproduction.cells.cell import DONE, KINDS, Cell, Document, Made, tool
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


TABLE_FILE = "cells.csv"
MAX_EPISODES_BYTES = 2**28
ABOUT = tuple(field.name for field in fields(Cell))  # the columns that say what a cell is
COLUMNS = ("cell", *ABOUT, "lineup", "measure", "higher_is_better", "episodes", "mean", "cpu_seconds")


@dataclass(frozen=True)
class Kept:
    """The cells of a folder that count, and how many do not."""

    cells: dict[str, Document]  # id -> its document, in the table's order
    other: int  # cells of another version of the tool, or of other claims
    doubled: int  # cells that stand for the same as one that counts: another expert of the same label, say


def find_finished(store: Store, wanted: Collection[str], register: str) -> Kept:
    """The finished cells of this version and register; of two about the same, the one that is `wanted` now."""
    finished: dict[Cell, tuple[str, Document]] = {}
    other = doubled = 0
    for id_, document in store.documents():
        identity = document.identity
        if (identity.get("tool"), identity.get("register")) != (tool(), register):
            other += 1
        elif document.outcome == DONE:
            doubled += document.cell in finished
            if document.cell not in finished or id_ in wanted:
                finished[document.cell] = id_, document
    ordered = sorted(finished, key=_place)
    return Kept(dict(finished[cell] for cell in ordered), other, doubled)


def _place(cell: Cell) -> tuple[int, Cell | tuple[str | int, ...]]:
    known = KINDS.index(cell.kind) if cell.kind in KINDS else len(KINDS)
    return known, tuple(getattr(cell, name) for name in ABOUT)


def write(store: Store, cells: dict[str, Document]) -> Path:
    """Writes cells.csv."""
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(COLUMNS)
    for id_, document in cells.items():
        about = [getattr(document.cell, name) for name in ABOUT]
        data = runs.read(store.cells / id_ / EPISODES_FILE, MAX_EPISODES_BYTES).decode()
        by_lineup: dict[tuple[str, str], list[float]] = {}
        for lineup, measure, _, value in csv.reader(io.StringIO(data.removeprefix(HEAD))):
            by_lineup.setdefault((lineup, measure), []).append(float(value))
        for (lineup, measure), values in sorted(by_lineup.items()):
            higher, mean = int(measure not in document.lower_is_better), math.fsum(values) / len(values)
            table.writerow([id_, *about, lineup, measure, higher, len(values), repr(mean), document.cpu_seconds])
    return runs.write(store.folder / TABLE_FILE, text.getvalue())


EPISODE_COLUMNS = tuple(HEAD.strip().split(","))
MAX_TABLE_BYTES, MAX_EPISODE_BYTES, MAX_FACTS_BYTES = 2**28, 2**28, 2**24
AGAIN = "run maviper reproduce again in this folder"


@dataclass(frozen=True, order=True)
class Row(Cell):
    """A cell as `cells.csv` names it, its game without options."""

    cell: str = ""
    cpu_seconds: float = field(default=0.0, compare=False)


Values = tuple[Float64, Float64]  # episodes' seeds, and the value in each


@dataclass(frozen=True)
class Results:
    """The contents of a folder. `higher`: measure -> whether higher is better."""

    folder: Path
    rows: tuple[Row, ...]
    higher: Mapping[str, bool]
    _values: dict[str, dict[tuple[str, str], Values]] = field(default_factory=dict[str, dict[tuple[str, str], Values]])
    _facts: dict[str, dict[str, Any]] = field(default_factory=dict[str, dict[str, Any]])

    def cells(self, **wanted: Any) -> list[Row]:
        """The cells whose columns are as wanted."""
        return [row for row in self.rows if all(getattr(row, column) == value for column, value in wanted.items())]

    def list_values(self, column: str, **wanted: Any) -> list[Any]:
        """The values of a column in the cells that are as wanted, sorted."""
        return sorted({getattr(row, column) for row in self.cells(**wanted)})

    def values(self, cell: str) -> dict[tuple[str, str], Values]:
        """(line-up, measure) -> the values in each episode of a cell."""
        if cell not in self._values:
            self._values[cell] = _episodes(self.folder / CELLS / cell / EPISODES_FILE)
        return self._values[cell]

    def facts(self, cell: str) -> dict[str, Any]:
        """Returns the facts that are known of a cell besides its episodes; {} where nothing is."""
        if cell not in self._facts:
            path = self.folder / CELLS / cell / FACTS_FILE
            what = "the facts of a cell are no JSON object"
            read = runs.decode_file(path, MAX_FACTS_BYTES, dict[str, Any], what, AGAIN) if path.exists() else {}
            self._facts[cell] = read
        return self._facts[cell]


def read_table(folder: Path) -> Results:
    """The table of a folder. InputError where it is not one."""
    rows: dict[str, Row] = {}
    higher: dict[str, bool] = {}
    path = folder / TABLE_FILE
    for line in _table(path, MAX_TABLE_BYTES, COLUMNS):
        try:
            rows[line["cell"]] = _row(line)
        except ValueError as error:
            raise InputError("a row of the table is no cell", f"{path}: {error}", AGAIN) from None
        higher[line["measure"]] = line["higher_is_better"].lower() in ("1", "true")
    return Results(folder, tuple(sorted(rows.values())), higher)


def _row(line: Mapping[str, str]) -> Row:
    if line["kind"] not in KINDS:
        raise ValueError(f"kind {line['kind']!r}")
    about: dict[str, Any] = {name: line[name] for name in ABOUT}
    about |= {"game": line["game"].partition(",")[0]}
    about |= {name: int(line[name] or 0) for name in ("depth", "leaves", "seed")}
    return Row(**about, cell=line["cell"], cpu_seconds=float(line["cpu_seconds"] or 0))


def _episodes(path: Path) -> dict[tuple[str, str], Values]:
    """All that a cell's episodes are worth; plain lists, since there are millions of rows."""
    lines = csv.reader(io.StringIO(runs.read(path, MAX_EPISODE_BYTES).decode("utf-8", "replace"), newline=""))
    if next(lines, None) != list(EPISODE_COLUMNS):
        raise InputError("the table lacks columns", f"{path}: {', '.join(EPISODE_COLUMNS)}", AGAIN)
    by_lineup: dict[tuple[str, str], tuple[list[float], list[float]]] = {}
    try:
        of: tuple[str, str] | None = None
        seeds, values = list[float](), list[float]()
        for lineup, measure, episode, *columns in lines:
            if of != (lineup, measure):  # most rows are of the same as the row before
                of = lineup, measure
                seeds, values = by_lineup.setdefault(of, ([], []))
            if len(columns) == 1:
                seeds.append(int(episode))
                values.append(float(columns[0]))
            else:  # records of an earlier form pack episodes that follow one another in one row
                seeds.extend(range(int(episode), int(episode) + len(columns)))
                values.extend(map(float, columns))
    except ValueError as error:
        raise InputError("a row of the episodes is damaged", f"{path}: line {lines.line_num}: {error}", AGAIN) from None
    if any(len(set(seeds)) < len(seeds) for seeds, _ in by_lineup.values()):
        raise InputError("a row of the episodes is damaged", f"{path}: an episode stands there twice", AGAIN)
    sorted_by_seed: dict[tuple[str, str], Values] = {}
    for key, (seeds, values) in by_lineup.items():
        order = np.argsort(seeds, kind="stable")
        sorted_by_seed[key] = np.array(seeds, dtype=np.float64)[order], np.array(values)[order]
    return sorted_by_seed


def _table(path: Path, limit: int, columns: Iterable[str]) -> Iterable[dict[str, str]]:
    """The rows of a CSV file with at least those columns."""
    reader = csv.DictReader(io.StringIO(runs.read(path, limit).decode("utf-8", "replace"), newline=""))
    missing = [column for column in columns if column not in (reader.fieldnames or ())]
    if missing:
        raise InputError("the table lacks columns", f"{path}: {', '.join(missing)}", AGAIN)
    for row in reader:
        if None in row.values():
            raise InputError("a row of the table is cut off", f"{path}: line {reader.line_num}", AGAIN)
        yield row
