"""Prey by return beside touches: what the committed records of predator-prey say once leaving the arena counts.

    python -m tests.benchmarks.prey [RECORD ...] [--json]

RECORD is a name in generated/reproduction, or a path. One that published.py made has the name of its register.

A prey's return is what it pays for touches and a fine for leaving the arena, so fine = -return - 5 * touches, per prey.
For each kind of expert, depth and algorithm: touches, fine, share of episodes inside (a fine of at most 5), touches in
those episodes, and the return. Then MAVIPER or best responses less each other one, paired by seed, by return, by
touches and by touches inside: positive is better. Records that keep nothing of the episodes inside have the first two
and the return.

A register's record also has the ratio of the return to the expert's: 1 is as much, 0 is twice the loss. Where a kind
has several experts, they are the units in place of seeds, each with the mean of its own. An expert has touches inside
where each of its seeds has such episodes.
"""

import argparse
import json
from collections import defaultdict
from itertools import groupby, product
from pathlib import Path

import numpy as np

from maviper.reproduction.statistics import of_differences
from tests.benchmarks.compact import INSIDE, PER_TOUCH, RETURN, TOUCHES
from tests.benchmarks.record import rows
from tests.benchmarks.registered import HERE, Found, ratio, read_register

RECORDS = Path(__file__).parents[2] / "generated" / "reproduction"
NAMES = ("maddpg-predator-prey", "mappo-predator-prey", "maddpg", "mappo")
GAME, LINEUP = "predator-prey", "joint:prey"
COMPARED = {
    "best-response": ("maviper", "iviper", "imitation"),
    "maviper-every-round": ("iviper", "imitation"),
    "maviper": ("iviper", "imitation", "fitted-q"),
}
COLUMNS = ("touches", "fine", "inside", "touches inside", "return", "ratio")
SIGNS = {"return": 1, "ratio": 1, "touches": -1, "touches inside": -1}


def by_cell(record):
    """(kind of expert, preset, depth, algorithm) -> seed -> measure -> (episodes, mean)."""
    found = defaultdict(lambda: defaultdict(dict))
    for row in rows(record):
        asked = row["kind"], row["game"], row["preset"], row["splits"], row["lineup"]
        if asked == ("extraction", GAME, "paper", "histogram", LINEUP):
            seeds = found[row["expert"], row["preset"], int(row["depth"]), row["algorithm"]]
            seeds[int(row["seed"])][row["measure"]] = int(row["episodes"]), float(row["mean"])
    return found


def told(cell):
    """A seed's numbers, each higher being better but the fine and the touches, which are as they are."""
    (episodes, touches), (_, returns) = cell[TOUCHES], cell[RETURN]
    numbers = {"touches": touches, "fine": -returns - PER_TOUCH * touches, "return": returns}
    if INSIDE in cell:
        inside, touched = cell[INSIDE]
        numbers |= {"inside": inside / episodes, "touches inside": touched}
    return numbers


def told_beside_the_expert(values, world):
    """The numbers of a register's cell, with the ratio."""
    cell = {measure: (of["count"], of.get("mean", np.nan)) for measure, of in values[LINEUP].items()}
    return told(cell) | {"ratio": ratio(values, world, RETURN)}


def by_unit(record):
    """(kind of expert, preset, depth, algorithm) -> seed or expert -> its numbers."""
    if not (HERE / f"{record.name}.toml").exists():
        return {key: {seed: told(cell) for seed, cell in of.items()} for key, of in by_cell(record).items()}
    register, digest = read_register(record.name)
    found, units = Found(register, digest, record), {}
    for group in register["groups"]:
        kinds = groupby(group["experts"], lambda label: label.partition("-")[0]) if group["game"] == GAME else ()
        experts_of = [(kind, tuple(labels)) for kind, labels in kinds]
        for (kind, experts), depth, algorithm in product(experts_of, group["depths"], group["algorithms"]):
            side = {"game": GAME, "row": {"preset": group["preset"], "algorithm": algorithm}}
            units[kind, group["preset"], depth, algorithm] = numbers_of(found, side, experts, depth)
    return units


def numbers_of(found, side, experts, depth):
    """Expert -> its numbers, or seed -> its numbers of a lone one."""
    asked = side, "row", experts if len(experts) > 1 else experts[0], depth
    columns = {
        name: found.numbers(*asked, lambda values, world, name=name: told_beside_the_expert(values, world)[name])
        for name in COLUMNS
    }
    return {unit: {name: column[unit] for name, column in columns.items()} for unit in columns["return"]}


def rows_of(record):
    """Rows of algorithms, and of comparisons with their intervals."""
    units, levels, compared = by_unit(record), [], []
    for (kind, preset, depth, algorithm), of in sorted(units.items()):
        row = {"expert": kind, "preset": preset, "depth": depth}
        levels.append({**row, "algorithm": algorithm, "units": len(of)} | means(of))
        for other in COMPARED.get(algorithm, ()):
            if theirs := units.get((kind, preset, depth, other)):
                compared.append({**row, "algorithm": algorithm, "other": other} | differences(of, theirs))
    return levels, compared


def means(units):
    """Each number's mean over the units that have it."""
    found = {}
    for name in COLUMNS:
        numbers = [each[name] for each in units.values() if np.isfinite(each.get(name, np.nan))]
        found |= {name: float(np.mean(numbers))} if numbers else {}
    return found


def differences(ours, theirs):
    """Measure -> the mean difference, its interval and the number of units in which both have a number."""
    found = {}
    for name, sign in SIGNS.items():
        pairs = [
            sign * (ours[unit][name] - theirs[unit][name]) for unit in ours if unit in theirs and name in ours[unit]
        ]
        pairs = [each for each in pairs if np.isfinite(each)]
        if len(pairs) > 1:
            found[name] = [float(np.mean(pairs)), *map(float, of_differences(pairs).interval()), len(pairs)]
    return found


def lines_of(name, levels, compared):
    """The record's tables for people."""
    columns = [column for column in COLUMNS if any(column in row for row in levels)]
    yield f"{name}: prey, all trees, against expert predators"
    yield f"  {'expert':<16}{'depth':<6}{'algorithm':<22}{'units':>6}" + "".join(f"{each:>16}" for each in columns)
    for row in levels:
        numbers = "".join(f"{row[column]:>16.2f}" if column in row else f"{'-':>16}" for column in columns)
        expert = f"{row['expert']} {row['preset']}"
        yield f"  {expert:<16}{row['depth']:<6}{row['algorithm']:<22}{row['units']:>6}{numbers}"
    for row in compared:
        said = "; ".join(
            f"{name} {row[name][0]:+.3f} [{row[name][1]:+.3f}, {row[name][2]:+.3f}] of {row[name][3]}"
            for name in SIGNS
            if name in row
        )
        of = f"{row['expert']} {row['preset']}, depth {row['depth']}"
        yield f"  {of}, {row['algorithm']} less {row['other']}: {said}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("records", nargs="*", type=Path, default=[RECORDS / name for name in NAMES])
    parser.add_argument("--json", action="store_true")
    given = parser.parse_args()
    records = [record if record.exists() else RECORDS / record for record in given.records]
    found = {record.name: rows_of(record) for record in records}
    if given.json:
        print(json.dumps(found, indent=1))
        return
    for name, (levels, compared) in found.items():
        print("\n".join([*lines_of(name, levels, compared), ""]))


if __name__ == "__main__":
    main()
