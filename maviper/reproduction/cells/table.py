"""The table of a reproduction: cells.csv, with every cell's episodes and facts beside it.

Does: one row for each cell, line-up and measure; companions named by the cell.
Assumes: finished cells; the means are all that is computed here.
Does not: read experts, profiles or settings; judge anything.
"""

import contextlib
import csv
import io
import math
import os
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, fields
from pathlib import Path

from maviper.files import runs
from maviper.reproduction.cells.cell import DONE, FAILED, KINDS, Cell, Document, tool
from maviper.reproduction.cells.making import EPISODES_FILE, FACTS_FILE, HEAD
from maviper.reproduction.cells.store import Store

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
