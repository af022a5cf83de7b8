"""Losses, gains and hypotheses of the cells of this folder (needs numpy alone): python recompute.py

All is a share of the expert's D. First the means of every kind of cell, then for each hypothesis of register.toml the
mean over seeds of a slope or a difference, its 95 % interval, and its word after Holm's correction. What is gained is also
told as a share of what the trees lose alone.
"""

import json
import lzma
import tomllib
from itertools import product
from pathlib import Path

import numpy as np

AT = Path(__file__).parent
REGISTER = tomllib.loads((AT / "register.toml").read_text())
CELLS = json.loads(lzma.open(AT / "cells.json.xz").read())["cells"]
NAMES = ("alone", "individual", "shift", "interaction", "joint", "voted")


def numbers(agents, share, seed):
    """Gains and terms of a cell, in units of the expert's D."""
    document = CELLS[f"agents-{agents}.share-{share}.seed-{seed}.json"]
    reached = {way: value / document["D"]["expert"] for way, value in document["D"].items()}
    terms = {name: value / document["D"]["expert"] for name, value in document["why"].items()}
    gains = {"joint": reached["alone"] - reached["joint"], "voted": reached["joint"] - reached["voted"]}
    return {**terms, **gains, "alone": reached["alone"] - 1}


def slopes(target, *predictors):
    """Of the least-squares plane with an intercept: one slope for each predictor."""
    rows = np.stack([np.ones(len(target)), *map(np.asarray, predictors)], axis=1)
    return np.linalg.lstsq(rows, np.asarray(target), rcond=None)[0][1:]


def hypotheses(seed):
    """Name -> the number of a seed, of which the mean should be above 0 (H2b: not above)."""
    sizes, shares = REGISTER["agents"], REGISTER["shares"]
    cells = {key: numbers(*key, seed) for key in product(sizes, shares)}
    column = {name: [each[name] for each in cells.values()] for name in NAMES}
    both = slopes(column["joint"], column["shift"], column["interaction"])
    told = {"H2 joint by shift": both[0], "H2b joint by interaction": both[1]}
    told["H3 voted by interaction"] = slopes(column["voted"], column["interaction"])[0]
    for size in sizes:
        gains = [cells[size, share]["joint"] for share in shares]
        told[f"H1 joint by share, {size} agents"] = slopes(gains, [float(share) for share in shares])[0]
        last = cells[size, shares[-1]]
        told[f"H4 shift less interaction, {size} agents"] = last["shift"] - last["interaction"]
    return told


def student(n):
    """Values of Student's t and its distribution function; t is the tangent of an angle."""
    angle = np.linspace(-np.pi / 2, np.pi / 2, 400_001)
    mass = np.cumsum(np.cos((angle[1:] + angle[:-1]) / 2) ** (n - 1))
    return np.tan(angle[1:-1]) * n**0.5, mass[:-1] / mass[-1]


def main():
    """Prints the tables."""
    print(f"{len(CELLS)} cells; all as shares of the expert's D; won back: of what is lost alone", "", sep="\n")
    heads = "".join(f"{name:>13}" for name in (*NAMES, "won back"))
    print(f"{'agents':>6}{'share':>7}{'seeds':>6}{heads}")
    for size, share in product(REGISTER["agents"], REGISTER["shares"]):
        rows = [numbers(size, share, seed) for seed in REGISTER["seeds"]]
        means = {name: np.mean([row[name] for row in rows]) for name in NAMES}
        told = "".join(f"{means[name]:>13.3f}" for name in NAMES)
        print(f"{size:>6}{share:>7}{len(rows):>6}{told}{means['joint'] / means['alone']:>13.3f}")
    print("", "alone: what the trees lose that were extracted one by one; joint, voted: what is gained", "", sep="\n")
    print("hypotheses")
    by_seed = [hypotheses(seed) for seed in REGISTER["seeds"]]
    count, (t, mass) = len(by_seed), student(len(by_seed) - 1)
    values = {name: [float(of[name]) for of in by_seed] for name in by_seed[0]}
    errors = {name: float(np.std(of, ddof=1)) / count**0.5 for name, of in values.items()}
    p = {name: 1 - np.interp(np.mean(of) / errors[name], t, mass) for name, of in values.items()}
    least, above = 0.0, {}
    for rank, name in enumerate(sorted(p, key=p.__getitem__)):
        least = max(least, (len(p) - rank) * p[name])
        above[name] = least <= REGISTER["alpha"]
    for name, of in values.items():
        half = float(np.interp(0.975, mass, t)) * errors[name]
        low, high = np.mean(of) - half, np.mean(of) + half
        holds, refuted = (False, above[name]) if name.startswith("H2b") else (above[name], high < 0)
        word = "HOLDS" if holds else "REFUTED" if refuted else "OPEN"
        print(f"  {name}: {np.mean(of):+.3f} [{low:+.3f}, {high:+.3f}]  {word}")


if __name__ == "__main__":
    main()
