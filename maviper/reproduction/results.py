"""The table of a reproduction, read: cells, their values in each episode, and their facts.

Does: reads `cells.csv`, `episodes/HASH.csv` and `facts/HASH.json` of a folder; selects cells; checks what it reads.
Assumes: the files are those of one run, written by this version; episodes are named by their held-out seeds.
Does not: compute any number of the report, or know the paper.
"""

import csv
import io
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from codegen.errors import InputError
from codegen.ir import Float64
from maviper.files import runs
from maviper.reproduction.cells.cell import KINDS
from maviper.reproduction.cells.making import HEAD
from maviper.reproduction.cells.table import COLUMNS, EPISODES_FOLDER, FACTS_FOLDER, TABLE_FILE

EPISODE_COLUMNS = tuple(HEAD.strip().split(","))
MAX_TABLE_BYTES, MAX_EPISODE_BYTES, MAX_FACTS_BYTES = 2**28, 2**28, 2**24
AGAIN = "run maviper reproduce again in this folder"


@dataclass(frozen=True, order=True)
class Row:
    """A cell as `cells.csv` names it."""

    kind: str
    game: str
    expert: str
    preset: str
    algorithm: str
    depth: int
    leaves: int  # 0: no budget
    splits: str
    seed: int
    cell: str
    cpu_seconds: float = field(compare=False)


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
        """The cells whose columns are as wanted; a list, tuple or set stands for any of its values."""
        matching: list[Row] = []
        for row in self.rows:
            if all(_fits(getattr(row, column), value) for column, value in wanted.items()):
                matching.append(row)
        return matching

    def list_values(self, column: str, **wanted: Any) -> list[Any]:
        """The values of a column in the cells that are as wanted, sorted."""
        return sorted({getattr(row, column) for row in self.cells(**wanted)})

    def values(self, cell: str) -> dict[tuple[str, str], Values]:
        """(line-up, measure) -> the values in each episode of a cell."""
        if cell not in self._values:
            self._values[cell] = _episodes(self.folder / EPISODES_FOLDER / f"{cell}.csv")
        return self._values[cell]

    def facts(self, cell: str) -> dict[str, Any]:
        """Returns the facts that are known of a cell besides its episodes; {} where nothing is."""
        if cell not in self._facts:
            path = self.folder / FACTS_FOLDER / f"{cell}.json"
            what = "the facts of a cell are no JSON object"
            read = runs.decode_file(path, MAX_FACTS_BYTES, dict[str, Any], what, AGAIN) if path.exists() else {}
            self._facts[cell] = read
        return self._facts[cell]


def _fits(value: Any, wanted: Any) -> bool:
    return value in wanted if isinstance(wanted, list | tuple | set) else value == wanted


def read(folder: Path) -> Results:
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
    return Row(
        kind=line["kind"],
        game=line["game"].partition(",")[0],  # without options
        expert=line["expert"],
        preset=line["preset"],
        algorithm=line["algorithm"],
        depth=int(line["depth"] or 0),
        leaves=int(line["leaves"] or 0),
        splits=line["splits"],
        seed=int(line["seed"] or 0),
        cell=line["cell"],
        cpu_seconds=float(line["cpu_seconds"] or 0),
    )


def _episodes(path: Path) -> dict[tuple[str, str], Values]:
    """Everything that a cell's companion holds; plain lists, since there are millions of rows."""
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
    return {
        key: _sort_by_seed(np.array(seeds, dtype=np.float64), np.array(values))
        for key, (seeds, values) in by_lineup.items()
    }


def _sort_by_seed(seeds: Float64, values: Float64) -> Values:
    order = np.argsort(seeds, kind="stable")
    return seeds[order], values[order]


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
