"""Seconds that each file of tests takes: recorded by a run, kept in a committed table, which orders later runs.

Does: as a plugin, writes what a run took by file, why tests were skipped and which passed (`pytest --seconds RECORD`,
  and `--left-of RECORD` runs those that did not pass there); as a command
  (`python -m tests.seconds RECORD`), prints the longest files and what was skipped; `--update` renews the table for
  the files that ran.
Assumes: the table is of README's line of tests, on two idle cores.
Does not: run inside a test; no test asserts a time.
"""

import argparse
import json
import sys
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

ROOT = Path(__file__).parent.parent
TABLE = Path(__file__).parent / "seconds.json"


class Recorder:
    """What the reports of a run add up to, by file; with several workers, in the process that hears of all."""

    def __init__(self, place: Path) -> None:
        self.place = place
        self.seconds: Counter[str] = Counter()
        self.skipped: dict[str, str] = {}
        self.passed: set[str] = set()

    def pytest_runtest_logreport(self, report):
        """Setup, call and teardown of one test."""
        self.seconds[report.nodeid.split("::")[0]] += report.duration
        if report.when == "call" and report.passed:
            self.passed.add(report.nodeid)
        self._note_skip(report)

    def pytest_collectreport(self, report):
        """A whole file may be skipped while it is read."""
        self._note_skip(report)

    def pytest_sessionfinish(self):
        """Writes the record."""
        record = {
            "seconds": {name: round(spent, 2) for name, spent in sorted(self.seconds.items())},
            "skipped": dict(sorted(self.skipped.items())),
            "passed": sorted(self.passed),
        }
        self.place.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")

    def _note_skip(self, report):
        if report.skipped and isinstance(report.longrepr, tuple):
            self.skipped[report.nodeid] = report.longrepr[2].removeprefix("Skipped: ")


def table() -> dict[str, float]:
    """Seconds by file, as committed."""
    return json.loads(TABLE.read_text(encoding="utf-8"))


def longest_first(items, seconds):
    """The same tests, those of long files first, so that no worker ends alone with one; unknown files before all. The
    order is the same in whatever order files were read.
    """

    def place(item):
        file = item.nodeid.split("::")[0]
        return -seconds.get(file, float("inf")), file

    return sorted(items, key=place)


def passed_in(records: Iterable[Path]) -> set[str]:
    """The tests that passed in some of the runs recorded."""
    return set().union(*(json.loads(place.read_text(encoding="utf-8"))["passed"] for place in records))


def told_skips(skipped) -> list[str]:
    """How many tests were skipped, and why."""
    reasons = Counter(skipped.values())
    return [f"{len(skipped)} skipped", *(f"  {count:4d}  {why}" for why, count in sorted(reasons.items()))]


def skipped_of(skipped, folders):
    """Skipped tests of folders whose every test is to run, a line each."""
    under = tuple(folder.rstrip("/") + "/" for folder in folders)
    return [f"NOT TO BE SKIPPED: {name}: {why}" for name, why in skipped.items() if under and name.startswith(under)]


def main(arguments: list[str]) -> int:
    """The command; 1 where a test was skipped that must not be."""
    parser = argparse.ArgumentParser(prog="python -m tests.seconds", description="What a run of the tests took.")
    parser.add_argument("record", type=Path, help="made by pytest --seconds RECORD")
    parser.add_argument("--update", action="store_true", help="renew the table, for the files that ran")
    parser.add_argument(
        "--all-of", action="append", default=[], metavar="FOLDER", help="fail if a test there is skipped"
    )
    asked = parser.parse_args(arguments)
    record = json.loads(asked.record.read_text(encoding="utf-8"))
    spent = record["seconds"]
    lines = [f"{sum(spent.values()):.0f} s of tests in {len(spent)} files, the longest:"]
    lines += [f"  {spent[name]:5.1f} s  {name}" for name in sorted(spent, key=spent.__getitem__, reverse=True)[:5]]
    missing = skipped_of(record["skipped"], asked.all_of)
    print("\n".join([*lines, *told_skips(record["skipped"]), *missing]))
    if asked.update:
        kept = {name: spent for name, spent in table().items() if (ROOT / name).exists()}
        rounded = kept | {name: round(spent) for name, spent in record["seconds"].items()}
        lasting = {name: spent for name, spent in sorted(rounded.items()) if spent}
        TABLE.write_text(json.dumps(lasting, indent=1) + "\n", encoding="utf-8")
    return 1 if missing else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
