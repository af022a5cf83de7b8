"""Losses, gains and hypotheses of the cells of this folder (needs numpy alone): python recompute.py

Scripted experts (register.toml): all is a share of the expert's D. First the means of every kind of cell, then for each
hypothesis the mean over seeds of a slope or a difference, its 95 % interval, and its word after Holm's correction. What
is gained is also told as a share of what the trees lose alone.

Trained experts (experts.toml): the lead of joint rollouts over IVIPER and the demand of every expert, then for each
game the slope of leads over demand, once all of its cells are there.
"""

import json
import lzma
import tomllib
from itertools import product
from pathlib import Path

import numpy as np

AT = Path(__file__).parent
REGISTER, EXPERTS = (tomllib.loads((AT / name).read_text()) for name in ("register.toml", "experts.toml"))
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


def holm(p):
    """Name -> whether it holds at alpha with its p-value, by Holm's correction over all names."""
    least, below = 0.0, {}
    for rank, name in enumerate(sorted(p, key=p.__getitem__)):
        least = max(least, (len(p) - rank) * p[name])
        below[name] = least <= REGISTER["alpha"]
    return below


def leads(group):
    """Expert -> its demand, the lead of joint rollouts over IVIPER as a share of the expert's measure, and the lead as
    a share of what IVIPER loses: means over the seeds of its trees. Only experts of which all cells are there.
    """
    found, (label, *_), count = {}, group["measures"], len(EXPERTS["seeds"])
    for place, expert in enumerate(group["experts"]):
        seeds = [seed + place * count for seed in EXPERTS["seeds"]]
        start = f"{group['game']}.{expert}.{group['preset']}"
        cells = [
            [CELLS.get(f"{start}.{way}.depth-4.seed-{seed}.json") for seed in seeds] for way in group["algorithms"]
        ]
        if all(map(all, cells)):
            joint, alone = (np.mean([ratio(cell, label) for cell in of]) for of in cells)
            demand = 1 - np.mean([cell["usual"] for of in cells for cell in of])
            found[expert] = demand, joint - alone, (joint - alone) / (1 - alone)
    return found


def ratio(document, label):
    """A team's measure over the expert's; of a distance, where less is better, the expert's over the team's."""
    ours, theirs = (document["values"][who][label]["mean"] for who in (f"joint:{label.partition(' ')[0]}", "expert"))
    return theirs / ours if label == "agents D" else ours / theirs


def slope(x, y):
    """The slope of y over x by least squares, its standard error and the degrees of freedom."""
    x, y = np.asarray(x), np.asarray(y)
    spread = ((x - x.mean()) ** 2).sum()
    by = ((x - x.mean()) * y).sum() / spread
    rest = y - y.mean() - by * (x - x.mean())
    return by, ((rest**2).sum() / (len(x) - 2) / spread) ** 0.5, len(x) - 2


def trained():
    """Prints the leads of trained experts over their demand."""
    print(
        "",
        "trained experts: demand, lead of joint rollouts over IVIPER, the lead as a share of what IVIPER loses",
        sep="\n",
    )
    fits = {}
    for group in EXPERTS["groups"]:
        for expert, row in (found := leads(group)).items():
            print(f"  {group['name']} {expert}" + "".join(f"{value:>9.3f}" for value in row))
        if len(found) < len(group["experts"]):
            print(f"  {group['name']}: {len(found)} of {len(group['experts'])} experts, so nothing is said yet")
            continue
        demand, lead, share = np.transpose(list(found.values()))
        fits[group["name"]] = slope(demand, lead)
        print(f"  {group['name']}: slope of the share {slope(demand, share)[0]:+.3f}, beside it")
    p = {name: 1 - np.interp(by / error, *student(df)) for name, (by, error, df) in fits.items()}
    for name, (by, error, df) in fits.items() if len(fits) == len(EXPERTS["groups"]) else ():
        half = float(np.interp(0.975, *student(df)[::-1])) * error
        word = "HOLDS" if holm(p)[name] else "REFUTED" if by + half < 0 else "OPEN"
        print(f"  lead over demand, {name}: {by:+.3f} [{by - half:+.3f}, {by + half:+.3f}]  {word}")


def main():
    """Prints the tables."""
    scripted = sum(name.startswith("agents-") for name in CELLS)
    print(f"{scripted} cells; all as shares of the expert's D; won back: of what is lost alone", "", sep="\n")
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
    above = holm(p)
    for name, of in values.items():
        half = float(np.interp(0.975, mass, t)) * errors[name]
        low, high = np.mean(of) - half, np.mean(of) + half
        holds, refuted = (False, above[name]) if name.startswith("H2b") else (above[name], high < 0)
        word = "HOLDS" if holds else "REFUTED" if refuted else "OPEN"
        print(f"  {name}: {np.mean(of):+.3f} [{low:+.3f}, {high:+.3f}]  {word}")
    trained()


if __name__ == "__main__":
    main()
