"""The table of cells.json.xz (needs nothing installed): python recompute.py [unpack FOLDER | pack FOLDER]

Of the expert, of two rules and of trees the delay in held-out hours, 50 for each seed, and its ratio to the expert's in
the same hours: means over seeds with 95 % intervals. Two words say whether the whole interval is within 5 % of the
expert's, and at most max pressure's, or lies across (open). `unpack` writes the cells, so that `maviper compare`
goes on in FOLDER; `pack` takes those of a FOLDER that are finished.
"""

import csv
import json
import lzma
import sys
from collections import defaultdict
from math import sqrt
from pathlib import Path
from statistics import mean, stdev

STUDENT = {4: 2.776445}  # .975 quantile by degrees of freedom: four
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


def read():
    """By player the delay in each hour, seed by seed; and of trees their leaves and fidelity."""
    delays, trees = defaultdict(dict), defaultdict(list)
    for files in json.loads(lzma.decompress(KEPT.read_bytes())).values():
        cell, facts = json.loads(files["cell.json"])["cell"], json.loads(files["facts.json"])
        rows = [row for row in csv.DictReader(files["episodes.csv"].splitlines()) if row["measure"] == "signal delay"]
        name = "expert"
        if cell["kind"] == "extraction":
            name = f"{cell['algorithm']}, depth {cell['depth']}"
            trees[name].append((facts["trees"]["signal_0"]["leaves"], facts["fidelity"]["signal_0"]))
        delays[name][cell["seed"]] = {row["episode"]: float(row["value"]) for row in rows}
    for row in csv.DictReader(RULES.read_text().splitlines()):
        seed = next(seed for seed, hours in delays["expert"].items() if row["episode"] in hours)
        delays[row["rule"]].setdefault(seed, {})[row["episode"]] = float(row["delay"])
    return delays, trees


def told(numbers):
    """Mean and half of the 95 % interval over seeds."""
    return mean(numbers), STUDENT[len(numbers) - 1] * stdev(numbers) / sqrt(len(numbers))


def word(numbers, bound):
    """Whether the interval lies below a bound."""
    middle, half = told(numbers)
    return "yes" if middle + half <= bound else "no" if middle - half > bound else "open"


def main():
    """Prints a row for each."""
    delays, trees = read()
    print(f"{'player':<20}{'delay s':<18}{'over expert':<18}{'within 5 %':<12}{'max pressure':<14}leaves    fidelity")
    for name in sorted(delays, key=lambda name: (name in trees, name != "expert", name)):
        seeds = delays[name]
        assert all(hours.keys() == delays["expert"][seed].keys() for seed, hours in seeds.items()), "other hours"
        means, expert, pressure = (
            [mean(delays[of][seed].values()) for seed in seeds] for of in (name, "expert", "max_pressure")
        )
        ratios, more = ([ours / beside for ours, beside in zip(means, of)] for of in (expert, pressure))
        row = f"{name:<20}{'{:.1f} +- {:.1f}'.format(*told(means)):<18}{'{:.3f} +- {:.3f}'.format(*told(ratios)):<18}"
        row += f"{word(ratios, 1.05):<12}{word(more, 1.0):<14}"
        if name in trees:
            leaves, fidelity = zip(*trees[name])
            row += f"{f'{min(leaves)} to {max(leaves)}':<10}{mean(fidelity):.2f}"
        print(row.rstrip())


if __name__ == "__main__":
    if sys.argv[1:]:
        {"pack": pack, "unpack": unpack}[sys.argv[1]](Path(sys.argv[2]))
    else:
        main()
