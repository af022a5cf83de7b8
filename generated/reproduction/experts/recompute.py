"""Prints what the cells of this folder come to, and a word for each comparison (needs numpy alone): python recompute.py"""

import hashlib
import json
import lzma
import tomllib
from functools import cache
from itertools import product
from pathlib import Path

import numpy as np

AT = Path(__file__).parent
CELLS = json.loads(lzma.open(AT / "cells.json.xz").read())["cells"]
LOWER = ("agents D", "agents collisions", "agents D + collisions", "prey touches", "prey touches inside")
CEILING = 0.97  # where a baseline keeps so much of the expert, a lead over it cannot be seen


def read(path):
    """A register, its combinations of factors said as algorithms and its effects as means of half of these."""
    register = {"sha256": hashlib.sha256(path.read_bytes()).hexdigest(), **tomllib.loads(path.read_text())}
    factors = register.get("factors", {})
    names = ["-".join(levels) for levels in product(*factors.values())]
    lower = {name: [list(of).index(at) == 0 for of, at in zip(factors.values(), name.split("-"))] for name in names}
    for claim in register["claims"]:
        if "group" in claim:
            (of,) = (group for group in register["groups"] if group["name"] == claim["group"])
            claim |= {**of, "family": of["name"], "measure": of["measures"][0]}
            claim["id"] = f"{claim['first']} over {claim['second']}"
            claim |= {side: {"preset": of["preset"], "algorithm": claim[side]} for side in ("first", "second")}
        if "effect_of" in claim:
            places = [list(factors).index(factor) for factor in claim["effect_of"]]
            halves = [[name for name in names if sum(lower[name][k] for k in places) % 2 == half] for half in (0, 1)]
            claim |= dict(zip(("first", "second"), ({"preset": claim["preset"], "algorithm": of} for of in halves)))
        claim["experts"] = [tuple(claim["experts"])] if register.get("unit") == "expert" else claim["experts"]
    return register


def seeds_of(register, expert):
    """The seeds of an expert's trees: each trained expert has its own, and so its own held-out episodes."""
    trained = [f"{name}-{seed}" for name, recipe in register.get("trained", {}).items() for seed in recipe["seeds"]]
    place = trained.index(expert) if expert in trained else 0
    return [seed + place * len(register["seeds"]) for seed in register["seeds"]]


def documents(about, side, expert, depth, seed):
    """The cells of a side of a comparison, of one algorithm or several; None for one that is not there."""
    names = side["algorithm"] if isinstance(side["algorithm"], list) else [side["algorithm"]]
    start = f"{about['game']}.{expert}.{side['preset']}"
    return [CELLS.get(f"{start}.{name}.depth-{depth}.seed-{seed}.json") for name in names]


def numbers_of(document, label):
    """A team's ratio to the expert, its mean and the expert's; a return is divided by the mean size of the expert's."""
    ours, theirs = (document["values"][lineup][label] for lineup in (f"joint:{label.partition(' ')[0]}", "expert"))
    ours, theirs, scale = ours["mean"], theirs["mean"], theirs.get("size", abs(theirs["mean"]))
    return np.array([theirs / ours if label in LOWER else 1 + (ours - theirs) / scale, ours, theirs])


def values_of(register, about, side, expert, depth):
    """Seed -> numbers, once all algorithms are there; of several experts, expert -> the mean of its seeds."""
    if isinstance(expert, tuple):
        rows = {one: list(values_of(register, about, side, one, depth).values()) for one in expert}
        return {one: np.mean(row, axis=0) for one, row in rows.items() if len(row) == len(register["seeds"])}
    cells = {seed: documents(about, side, expert, depth, seed) for seed in seeds_of(register, expert)}
    told = {seed: [numbers_of(each, about["measure"]) for each in of] for seed, of in cells.items() if all(of)}
    return {seed: np.mean(of, axis=0) for seed, of in told.items()}


@cache
def student(n):
    """Values of Student's t and its distribution function; t is the tangent of an angle."""
    angle = np.linspace(-np.pi / 2, np.pi / 2, 400_001)
    mass = np.cumsum(np.cos((angle[1:] + angle[:-1]) / 2) ** (n - 1))
    return np.tan(angle[1:-1]) * n**0.5, mass[:-1] / mass[-1]


def interval(values):
    """The 95 % interval of the mean."""
    half = float(np.interp(0.975, *student(len(values) - 1)[::-1])) * np.std(values, ddof=1) / len(values) ** 0.5
    return np.mean(values) - half, np.mean(values) + half


def p_above(values, bound):
    """One-sided, of the mean lying above a bound."""
    error = max(np.std(values, ddof=1), 1e-12) / len(values) ** 0.5
    return 1 - float(np.interp((np.mean(values) - bound) / error, *student(len(values) - 1)))


def words_of(pairs, alpha, margin):
    """A word for each comparison of a family, by Holm's method: of its two hypotheses only one can be true (Shaffer)."""
    above = [[p_above(pair, bound) for bound in (-margin, 0, margin)] for pair in pairs]
    flat = [p for low, middle, high in above for p in (2 * min(middle, 1 - middle), max(low, 1 - high))]
    least, adjusted = 0.0, {}
    for rank, place in enumerate(np.argsort(flat, kind="stable")):
        adjusted[int(place)] = least = max(least, min(len(flat) - rank, len(pairs)) * flat[place])
    for k, pair in enumerate(pairs):
        told = "BETTER" if np.mean(pair) > 0 else "WORSE"
        yield "EQUAL" if adjusted[2 * k + 1] <= alpha else told if adjusted[2 * k] <= alpha else "NOT DECIDED"


def size(effect, low, high):
    """The size beside a published effect, by the interval."""
    small, large = "OPPOSITE" if high < 0 else "SMALLER THAN HALF", "SAME SIZE" if low >= effect / 2 else "SIZE OPEN"
    return small if high < effect / 2 else large


def rows_of(register):
    """What each algorithm keeps of the expert, and what both reach: means over seeds or experts."""
    for group in register["groups"]:
        experts = [tuple(group["experts"])] if register.get("unit") == "expert" else group["experts"]
        for expert, depth, name, label in product(experts, group["depths"], group["algorithms"], group["measures"]):
            about, side = {"game": group["game"], "measure": label}, {"preset": group["preset"], "algorithm": name}
            values = list(values_of(register, about, side, expert, depth).values())
            if values:
                who = f"{len(values)} experts" if isinstance(expert, tuple) else f"{expert} {len(values)} seeds"
                told = "{:.3f}  {:.3f} of {:.3f}".format(*np.mean(values, axis=0))
                yield f"  {told}  {group['game']} {who} {group['preset']} {name} depth {depth}: {label}"


def family_of(register, name):
    """The comparisons of a family; words only where all of it is there."""
    claims = [claim for claim in register["claims"] if claim["family"] == name]
    asked = [(claim, who, depth) for claim in claims for who, depth in product(claim["experts"], claim["depths"])]
    sides = [[values_of(register, c, c[side], who, depth) for side in ("first", "second")] for c, who, depth in asked]
    pairs = [[first[unit][0] - second[unit][0] for unit in first if unit in second] for first, second in sides]
    units = [len(who) if isinstance(who, tuple) else len(register["seeds"]) for _, who, _ in asked]
    whole = [len(pair) for pair in pairs] == units
    words = words_of(pairs, register["alpha"], register["margin"]) if whole else [""] * len(pairs)
    yield f"family {name}" + ("" if whole else ": not whole, so no word is given yet")
    for (claim, who, depth), pair, count, word, (_, second) in zip(asked, pairs, units, words, sides):
        start = f"  {claim['id']}, {f'{len(who)} experts' if isinstance(who, tuple) else who}, depth {depth}: "
        if len(pair) < count:
            yield f"{start}{len(pair)} of {count}"
            continue
        low, high = interval(pair)
        ceiling = interval([each[0] for each in second.values()])[0] >= CEILING
        word = f"UNTESTABLE ({word} without)" if ceiling else word or "no word yet"
        told = f"{np.mean(pair):+.3f} [{low:+.3f}, {high:+.3f}]  {word}; {size(claim['effect'], low, high)}"
        yield f"{start}{told} against {claim['effect']:g}"


def figure_of(register):
    """The rows of a register's figure: what trees keep of the expert, or a lead, with its interval over seeds."""
    about = register.get("figure", {"rows": []})
    for row in about["rows"]:
        of = [row[side] for side in ("of", "less") if side in row]
        sides = [values_of(register, about, side, about["expert"], about["depth"]) for side in of]
        units = [unit for unit in sides[0] if all(unit in side for side in sides)] if sides else []
        if units:
            mark = row["mark"] + ": " if row["mark"] else "lead: "
            numbers = [sides[0][unit][0] - sum(side[unit][0] for side in sides[1:]) for unit in units]
            yield "  {:.3f} [{:.3f}, {:.3f}]  {}{}".format(np.mean(numbers), *interval(numbers), mark, row["label"])


if __name__ == "__main__":
    for register in map(read, sorted(AT.glob("*.toml"))):
        print(f"# {register.get('name', 'published')}, register {register['sha256']}", *rows_of(register), sep="\n")
        for family in dict.fromkeys(claim["family"] for claim in register["claims"]):
            print(*family_of(register, family), sep="\n")
        if "figure" in register:
            print(f"figure: {register['figure']['title']}", *figure_of(register), sep="\n")
