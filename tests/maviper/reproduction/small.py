"""Reproductions small enough for a test: cells that cost nothing, and one that is real."""

import re

from maviper.console import Console
from maviper.reproduction import run
from maviper.reproduction.cells.cell import DONE, FORMAT, Document, Made
from maviper.reproduction.cells.making import EPISODES_FILE, FACTS_FILE, HEAD

QUIET = Console(quiet=True)
REAL = {"games": ("physical-deception",), "depths": (1,), "algorithms": ("imitation",), "seeds": 1}


def cheap(calls=None):
    """What stands for `make_cell`: two episodes of one measure, and a note of every call."""

    def made(task, profiles):
        if calls is not None:
            calls.append(task.cell.said)
        assert set(profiles) == set(task.of)
        first = task.cell.episodes.start
        rows = f"all,defenders return,{first},0.5\nall,defenders return,{first + 1},1.5\n"
        files = {EPISODES_FILE: HEAD + rows, FACTS_FILE: "{}\n", "profile.json": "{}"}
        document = Document(FORMAT, task.cell, task.identity, DONE, "", ["agents D"], 0.25)
        return Made(task.id, document, {name: text.encode() for name, text in files.items()})

    return made


def reproduced(folder, **options):
    return run.reproduce_paper(folder, run.request(options), QUIET)


def contents(folder):
    """Every file below a folder, what it costs aside."""
    found = {}
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder).as_posix()
        if path.name in ("summary.txt", "report.html"):
            cost = r"[0-9.]+ CPU hours|(?<=CPU hours</th><td>)[0-9.]+|(?m: +[0-9.]+$)"  # the last: a column of compare
            found[name] = re.sub(cost, "", path.read_text())
        elif path.is_file() and path.name not in ("cell.json", "cells.csv", "table.csv"):
            found[name] = path.read_bytes()
        elif path.name in ("cells.csv", "table.csv"):
            found[name] = [line.rpartition(",")[0] for line in path.read_text().splitlines()]
    return found
