"""The figures of a register's record: what experts and their trees reach, and the figure that a register describes.

Does: draws those rows that have all of their cells.
Assumes: cells as registered.py finds them.
Does not: write files.
"""

import numpy as np

from maviper.reproduction import figures
from maviper.reproduction.statistics import of_differences
from tests.benchmarks.registered import Cell

PRIMARY, EXPERT = "primary", "expert"
LEVELS = {
    "maviper-every-round": "MAVIPER, all rounds",
    "maviper": "MAVIPER, stops early",
    "iviper": "IVIPER",
    "iviper-equal-episodes": "IVIPER, equal data",
    "imitation": "imitation",
}
MEASURED = {
    "defenders success r=0.316": "share of episodes in which the defenders succeed",
    "agents D": "summed distance to the targets that is left",
}


def absolute_of(document, label):
    """The team's mean, and the expert's."""
    team = label.partition(" ")[0]
    return [document["values"][lineup][label]["mean"] for lineup in (f"joint:{team}", "expert")]


def levels(register, found):
    """A figure for each game of the primary claims, by file name: what experts and their trees reach, absolute, mean
    and 95 % interval over seeds.
    """
    drawings = {}
    primary = [
        claim for claim in register["claims"] if claim["family"] == PRIMARY and claim["first"]["preset"] == "paper"
    ]
    for (game, label), depth in dict.fromkeys(((c["game"], c["measure"]), c["depths"][0]) for c in primary):
        rows = []
        for group in register["groups"]:
            if group["game"] == game and group["preset"] == "paper" and depth in group["depths"]:
                for expert in group["experts"]:
                    rows += level_rows(register, found, group, expert, depth, label)
        if rows:
            title = f"{game.replace('-', ' ').capitalize()}, trees of depth {depth}"
            drawings[f"{game}.svg"] = figures.dots(title, MEASURED[label], rows)
    return drawings


def level_rows(register, found, group, expert, depth, label):
    """The rows of one expert: itself, then what its trees reach by each algorithm that has all seeds."""
    whole = {}
    for algorithm in LEVELS:
        cells = [Cell(group["game"], expert, group["preset"], algorithm, depth, seed) for seed in register["seeds"]]
        documents = [found.document(cell) for cell in cells]
        if all(documents):
            whole[algorithm] = np.array([absolute_of(document, label) for document in documents])
    columns = {name: values[:, 0] for name, values in whole.items()}
    if whole:  # every algorithm has the expert in the same episodes
        columns = {EXPERT: next(iter(whole.values()))[:, 1], **columns}
    return [
        (
            LEVELS.get(name, f"expert by {expert.upper()}"),
            name.partition("-")[0],
            figures.Point(np.mean(values), *of_differences(list(values)).interval()),
        )
        for name, values in columns.items()
    ]


def drawn(register, found):
    """The figure that a register describes: rows with a printed number, a ratio, or a ratio less another; rows without
    their cells are left out.
    """
    about = register["figure"]
    rows = []
    for row in about["rows"]:
        values = [row["value"]] if "value" in row else row_values(register, found, about, row)
        if len(values) == 1:
            rows.append((row["label"], row["mark"], figures.Point(values[0], np.nan, np.nan)))
        elif values:
            rows.append((row["label"], row["mark"], figures.Point(np.mean(values), *of_differences(values).interval())))
    return figures.dots(about["title"], about["x"], rows)


def row_values(register, found, about, row):
    """By seed, once all are there: the ratios of a row, less those of `less`."""
    claim = {"game": about["game"], "measure": about["measure"], **row}
    sides = [found.ratios(claim, side, about["expert"], about["depth"]) for side in ("of", "less") if side in row]
    seeds = [seed for seed in register["seeds"] if all(seed in side for side in sides)]
    if len(seeds) < len(register["seeds"]):
        return []
    return [sides[0][seed] - (sides[1][seed] if len(sides) > 1 else 0.0) for seed in seeds]
