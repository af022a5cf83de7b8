"""Keeps the finished extractions of a reproduction that is not whole yet, so that another machine can go on with it.

    python -m tests.benchmarks.kept pack FOLDER generated/reproduction/paper/mappo.kept.xz
    python -m tests.benchmarks.kept unpack generated/reproduction/paper/mappo.kept.xz FOLDER

Of each extraction its trees, its facts and the hash of its episodes are packed. To unpack plays these episodes again,
which takes a second a cell, compares the hash, and writes the cell; where the hash is another one the cell is left out,
and `maviper reproduce` makes it anew. Cells that are there are kept. All other kinds of cells are made anew, too: an
expert and cross-play take a second, responders to the trees of one extraction 20. The ids of cells hold for the commit
that made them, so a run is continued by that commit. Shipped experts only.
"""

import argparse
import json
import lzma
from dataclasses import asdict
from pathlib import Path

import msgspec
from threadpoolctl import threadpool_limits

from codegen.profiles import loads
from maviper.files import runs
from maviper.reproduction.cells.cell import DONE, EXTRACTION, Document, Made, Source, Task
from maviper.reproduction.cells.making import EPISODES_FILE, FACTS_FILE, play_lineups, replacing
from maviper.reproduction.cells.plan import MAPPO
from maviper.reproduction.cells.table import Store
from tests.benchmarks.compact import MAX_BYTES, hash_of

FORM = "maviper-kept-1"


def pack(folder, place):
    """Writes the extractions of a folder that are finished into one file; how many there are."""
    store, cells = Store(folder), {}
    for name, document in store.documents():
        if document.outcome == DONE and document.cell.kind == EXTRACTION:
            facts, profile, episodes = (
                (store.cells / name / file).read_text() for file in (FACTS_FILE, runs.PROFILE_FILE, EPISODES_FILE)
            )
            told = {"document": asdict(document), "facts": facts, "profile": profile, "sha256": hash_of(episodes)}
            cells[name] = told
    text = json.dumps({"form": FORM, "cells": cells}, sort_keys=True, separators=(",", ":"))
    runs.write(place, lzma.compress(text.encode(), preset=9 | lzma.PRESET_EXTREME))
    return len(cells)


def unpack(place, folder):
    """Writes the cells of a file that a folder lacks; how many there are, and those that play otherwise here."""
    kept = json.loads(runs.read_unpacked(place, MAX_BYTES))
    if kept.get("form") != FORM:
        raise SystemExit(f"{place} is not of the form {FORM}")
    store, written, others = Store(folder), 0, []
    for name, told in kept["cells"].items():
        document = msgspec.convert(told["document"], Document)
        if store.is_done(name):
            continue
        rows = played_again(document, told["profile"])
        if hash_of(rows) != told["sha256"]:
            others.append(document.cell.said)
            continue
        files = {FACTS_FILE: told["facts"], runs.PROFILE_FILE: told["profile"], EPISODES_FILE: rows}
        store.write(Made(name, document, {file: text.encode() for file, text in files.items()}))
        written += 1
    return written, others


def played_again(document, profile):
    """The episodes of an extraction, by its trees."""
    cell, world = document.cell, document.identity["world"]
    name = world if cell.expert == MAPPO else f"{world}@{cell.expert}"
    task = Task(cell, Source(name, world=world), document.identity["expert"], document.identity["register"])
    expert, played = task.source.read()
    if expert.hash != task.expert_hash:
        raise SystemExit(f"{name} is another expert than that of the cells: {expert.hash}, not {task.expert_hash}")
    with threadpool_limits(1):
        return play_lineups(played, task.episodes, replacing(played, expert, loads(profile, cell.said)))


def main():
    """Packs or unpacks."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("pack", "unpack"))
    parser.add_argument("source", type=Path)
    parser.add_argument("target", type=Path)
    given = parser.parse_args()
    if given.what == "pack":
        print(f"{pack(given.source, given.target)} extractions, {given.target.stat().st_size:,} bytes")
        return
    written, others = unpack(given.source, given.target)
    print(f"{written} extractions written")
    for said in others:
        print(f"plays otherwise here, so it is to be made anew: {said}")


if __name__ == "__main__":
    main()
