"""Records a finished reproduction in generated/reproduction/: report, claims, table, and how it was made.

    maviper reproduce --experts maddpg --jobs 2 -o FOLDER
    python -m tests.benchmarks.record FOLDER generated/reproduction/paper/maddpg -- --experts maddpg

Copies report.html, summary.txt, claims.json and recompute.py as the command wrote them; the page has every figure. What
recompute.py needs besides is packed into cells.json.xz, in the form of compact.py: what the episodes of each cell come
to, their hash, the facts that numbers take, and what each number is made of. Single episodes stay where a number needs
them: its error is drawn over the episodes of one seed, or it takes only some of a line-up's.
Writes README.md with command, versions and core-hours; the command's options stand after --. Equal folders give equal
bytes. Nothing is played, and nothing in FOLDER is changed.
"""

import argparse
import csv
import functools
import json
import platform
import shutil
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from maviper.files import runs
from maviper.reproduction import report
from maviper.reproduction.cells.making import EPISODES_FILE
from maviper.reproduction.cells.table import ABOUT, CELLS, COLUMNS, TABLE_FILE, read_table
from tests.benchmarks import compact

COPIED = (report.PAGE, report.SUMMARY, report.CLAIMS, report.SCRIPT)
README = "README.md"
PACKAGES = ("maviper", "numpy", "scipy", "mpe2", "pettingzoo", "torch")  # torch, if there: responders learn with it


def recorded(folder: Path, place: Path, options: str = "") -> list[Path]:
    """Writes the record of a finished folder into `place`; the files. FileNotFoundError where a report is missing."""
    shutil.rmtree(place / report.FIGURES, ignore_errors=True)
    for name in COPIED:
        runs.write(place / name, (folder / name).read_bytes())
    runs.write(place / compact.FILE, cells(folder))
    runs.write(place / README, page(place, options))
    return sorted(path for path in place.rglob("*") if path.is_file())


def rows(place: Path) -> list[dict[str, str]]:
    """The table of a record, a row per line-up and measure of each cell."""
    found: list[dict[str, str]] = []
    for name, cell in compact.unpacked(place / compact.FILE)["cells"].items():
        for lineup, columns in cell["values"].items():
            for measure, told in columns.items():
                higher = str(int(measure not in cell["lower_is_better"]))
                numbers = {"episodes": str(told["count"]), "mean": repr(told.get("mean", float("nan")))}
                row = {"cell": name, **cell["about"], "lineup": lineup, "measure": measure}
                row |= {"higher_is_better": higher, **numbers, "cpu_seconds": cell["cpu_seconds"]}
                found.append({column: row[column] for column in COLUMNS})
    return found


def cells(folder: Path) -> bytes:
    """The cells of a finished folder in the form of records, and what each number of its report is made of."""
    numbers = json.loads((folder / report.NUMBERS).read_text())
    table = read_table(folder)
    whole, paths = needed(numbers, table)
    with (folder / TABLE_FILE).open(encoding="utf-8", newline="") as file:
        first = {row["cell"]: row for row in reversed(list(csv.DictReader(file)))}
    lower = sorted(measure for measure, better in table.higher.items() if not better)
    found = {}
    for name, row in first.items():
        text = (folder / CELLS / name / EPISODES_FILE).read_text(encoding="utf-8")
        told = {"sha256": compact.hash_of(text), "values": summed_up(table, name, whole)}
        told |= {"about": {column: row[column] for column in ABOUT}, "lower_is_better": lower}
        told |= {"facts": kept_facts(table.facts(name), paths.get(name, set()))} if name in paths else {}
        found[name] = {**told, "cpu_seconds": row["cpu_seconds"]}
    return compact.packed(found, numbers=numbers)


def needed(numbers, table):
    """The (cell, line-up, measure) of which a number needs single episodes, and the paths of facts by cell."""
    whole: set[tuple[str, str, str]] = set()
    paths: dict[str, set[tuple[str, ...]]] = {}
    for number in numbers.values():
        sources = [each for part in number["parts"] for each in (part["ours"], part["theirs"]) if each]
        for source in sources:
            for cell, _ in source["places"] if source["facts"] else ():
                paths.setdefault(cell, set()).update(tuple(path) for _, path in source["facts"])
        played = [
            [(cell, lineup, each["measure"]) for cell, lineup in each["places"]]
            for each in sources
            if not each["facts"]
        ]
        known = [[table.values(cell)[lineup, measure][0].tolist() for cell, lineup, measure in each] for each in played]
        taken = [sorted(set.intersection(*map(set, seeds)))[: number["episodes"]] for seeds in zip(*known, strict=True)]
        drawn_too = all(each == taken[0] for each in taken)  # and episodes
        for places, seeds in zip(played, known, strict=True):
            kept = (drawn_too or mine != wanted for mine, wanted in zip(seeds, taken, strict=True))
            whole.update(place for place, keep in zip(places, kept, strict=True) if keep)
    return whole, paths


def summed_up(table, cell, whole):
    """What a cell's episodes come to, by line-up and measure: which there are, and the values of those in `whole`."""
    values: dict[str, dict[str, list[float]]] = {}
    for (lineup, measure), (_, column) in table.values(cell).items():
        values.setdefault(lineup, {})[measure] = column.tolist()
    told = compact.summed_up(values)
    for (lineup, measure), (episodes, column) in table.values(cell).items():
        first, count = int(episodes[0]), len(episodes)
        follow = episodes.tolist() == list(range(first, first + count))
        told[lineup][measure] |= {"first": first} if follow else {"episodes": [int(each) for each in episodes]}
        told[lineup][measure] |= {"values": column.tolist()} if (cell, lineup, measure) in whole else {}
    return told


def kept_facts(facts, paths):
    """The numbers at some paths of a cell's facts, where they stand."""
    found = {}
    for path in sorted(paths):
        inner = found
        for name in path[:-1]:
            inner = inner.setdefault(name, {})
        inner[path[-1]] = functools.reduce(dict.__getitem__, path, facts)
    return found


def page(place: Path, options: str) -> str:
    """README.md: what was run, with what, and what lies here."""
    claims = json.loads((place / report.CLAIMS).read_text())
    cells = {row["cell"]: row for row in rows(place)}
    hours = sum(float(row["cpu_seconds"]) for row in cells.values()) / 3600
    words = [(claim["id"], claim["verdict"]) for claim in claims["claims"]]
    experts = ", ".join(sorted({row["expert"] for row in cells.values()}))
    command = " ".join(word for word in ("maviper reproduce", options, "-o FOLDER") if word)
    return f"""# A reproduction of the paper, experts: {experts}

    {command}

{report.counts(words)}. {len(cells)} cells, {hours:.1f} core-hours.
Register of claims: sha256 {claims["register"]}. Versions: {_versions()}.

- `{report.SUMMARY}`: a line for each claim; `{report.CLAIMS}`: every comparison, with p-values.
- `{report.PAGE}`: tables and figures on one page.
- `{compact.FILE}`: the mean of every line-up and measure of every cell, with its CPU time, and what each number of the
  report is made of. {compact.TOLD}
- `{report.SCRIPT}` computes all numbers and verdicts again from `{compact.FILE}`, without maviper.

Episodes are left out but where an error is drawn over those that all seeds share, or where a number takes only some of
them. The command makes them again, as `episodes/CELL.csv`. This folder was written by
`python -m tests.benchmarks.record`.
"""


def _versions() -> str:
    found = [("Python", platform.python_version())]
    for name in PACKAGES:
        with suppress(PackageNotFoundError):
            found.append((name, version(name)))
    return ", ".join(f"{name} {number}" for name, number in found)


def main() -> None:
    """Records the folder that is named."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("place", type=Path)
    parser.add_argument("options", nargs="*", help="those of maviper reproduce")
    given = parser.parse_args()
    for path in recorded(given.folder, given.place, " ".join(given.options)):
        print(f"{path.stat().st_size:>9}  {path}")


if __name__ == "__main__":
    main()
