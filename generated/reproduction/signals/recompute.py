"""The table of cells.json.xz (needs nothing installed): python recompute.py [unpack FOLDER | pack FOLDER]

Of the expert, of two rules and of each cell the mean delay in the same held-out hours, with a 95 % interval over hours;
whether it is within 5 % of the expert's, and at most max pressure's. `unpack` writes the cells, so that `maviper compare`
goes on in FOLDER; `pack` takes those of a FOLDER that are finished.
"""

import csv
import json
import lzma
import sys
from math import sqrt
from pathlib import Path
from statistics import mean, stdev

KEPT, RULES = (Path(__file__).with_name(name) for name in ("cells.json.xz", "rules.csv"))


def pack(folder):
    """Keeps the finished cells of a comparison."""
    done = [place.parent for place in sorted(folder.glob("cells/*/episodes.csv"))]
    files = {place.name: {each.name: each.read_text() for each in sorted(place.iterdir())} for place in done}
    KEPT.write_bytes(lzma.compress(json.dumps(files).encode(), preset=9))


def unpack(folder):
    """Writes them."""
    for name, files in json.loads(lzma.decompress(KEPT.read_bytes())).items():
        place = folder / "cells" / name
        place.mkdir(parents=True)
        for file, text in files.items():
            (place / file).write_text(text)


def players():
    """The name of each, what it is, and its delay by hour; the expert first."""
    found = []
    for files in json.loads(lzma.decompress(KEPT.read_bytes())).values():
        cell, facts = json.loads(files["cell.json"])["cell"], json.loads(files["facts.json"])
        rows = csv.DictReader(files["episodes.csv"].splitlines())
        delays = {row["episode"]: float(row["value"]) for row in rows if row["measure"] == "signal delay"}
        name, told = "expert", ""
        if cell["kind"] == "extraction":
            name = f"{cell['algorithm']}, depth {cell['depth']}, seed {cell['seed']}"
            told = f"{facts['trees']['signal_0']['leaves']} leaves, fidelity {facts['fidelity']['signal_0']:.2f}"
        found.append((cell["depth"], name, told, delays))
    for row in csv.DictReader(RULES.read_text().splitlines()):
        if not found or found[-1][1] != row["rule"]:
            found.append((0, row["rule"], "", {}))
        found[-1][3][row["episode"]] = float(row["delay"])
    return [each[1:] for each in sorted(found, key=lambda each: (each[1] != "expert", *each[:2]))]


def main():
    """Prints a row for each."""
    found = players()
    means = {name: mean(delays.values()) for name, _, delays in found}
    print(f"{'player':<28}{'delay s':<20}{'within 5 %':<12}{'max pressure':<14}trees")
    for name, told, delays in found:
        assert delays.keys() == found[0][2].keys(), "other hours"
        half = 2.01 * stdev(delays.values()) / sqrt(len(delays))  # Student's t of 49
        words = ["yes" if means[name] <= bound else "no" for bound in (1.05 * means["expert"], means["max_pressure"])]
        print(f"{name:<28}{means[name]:.1f} +- {half:<12.1f}{words[0]:<12}{words[1]:<14}{told}".rstrip())


if __name__ == "__main__":
    if sys.argv[1:]:
        {"pack": pack, "unpack": unpack}[sys.argv[1]](Path(sys.argv[2]))
    else:
        main()
