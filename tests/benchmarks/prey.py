"""Prey by return beside touches: what the committed records of predator-prey say once leaving the arena counts.

    python -m tests.benchmarks.prey [RECORD ...] [--json]

A prey's return is what it pays for touches and a fine for leaving the arena, so fine = -return - 5 * touches, per prey.
For each algorithm and depth: touches, fine, share of episodes inside (a fine of at most 5), touches in those episodes,
and the return. Then MAVIPER less each other one, paired by seed, by return, by touches and by touches inside: positive
is better. Records that keep nothing of the episodes inside have the first two and the return.
"""

import argparse
import json
from collections import defaultdict
from pathlib import Path

import numpy as np

from maviper.reproduction.statistics import of_differences
from tests.benchmarks.compact import INSIDE, PER_TOUCH, RETURN, TOUCHES
from tests.benchmarks.record import rows

RECORDS = Path(__file__).parents[2] / "generated" / "reproduction"
NAMES = ("maddpg-predator-prey", "mappo-predator-prey", "maddpg", "mappo")
OTHERS = ("iviper", "imitation", "fitted-q")
LINEUP = "joint:prey"


def by_cell(record):
    """(algorithm, depth) -> seed -> measure -> (episodes, mean)."""
    found = defaultdict(lambda: defaultdict(dict))
    for row in rows(record):
        asked = row["kind"], row["game"], row["preset"], row["splits"], row["lineup"]
        if asked == ("extraction", "predator-prey", "paper", "histogram", LINEUP):
            seeds = found[row["algorithm"], int(row["depth"])]
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


def rows_of(record):
    """Rows of algorithms, and of comparisons with their intervals."""
    by_seed = {key: {seed: told(cell) for seed, cell in of.items()} for key, of in by_cell(record).items()}
    levels = [
        {"depth": depth, "algorithm": algorithm, "seeds": len(of)}
        | {name: float(np.nanmean([each[name] for each in of.values()])) for name in next(iter(of.values()))}
        for (algorithm, depth), of in sorted(by_seed.items(), key=lambda item: item[0][::-1])
    ]
    compared = []
    for depth in sorted({depth for _, depth in by_seed}):
        for other in OTHERS:
            if ("maviper", depth) in by_seed and (other, depth) in by_seed:
                ours, theirs = by_seed["maviper", depth], by_seed[other, depth]
                compared.append({"depth": depth, "other": other} | differences(ours, theirs))
    return levels, compared


def differences(ours, theirs):
    """Measure -> the mean difference and its interval over the seeds in which both have a number."""
    found = {}
    for name, sign in (("return", 1), ("touches", -1), ("touches inside", -1)):
        pairs = [
            sign * (ours[seed][name] - theirs[seed][name]) for seed in ours if seed in theirs and name in ours[seed]
        ]
        pairs = [each for each in pairs if np.isfinite(each)]
        if len(pairs) > 1:
            found[name] = [float(np.mean(pairs)), *map(float, of_differences(pairs).interval()), len(pairs)]
    return found


def lines_of(name, levels, compared):
    """The record's tables for people."""
    columns = [column for column in ("touches", "fine", "inside", "touches inside", "return") if column in levels[0]]
    yield f"{name}: prey, all trees, against expert predators"
    yield f"  {'depth':<6}{'algorithm':<28}{'seeds':>6}" + "".join(f"{column:>16}" for column in columns)
    for row in levels:
        numbers = "".join(f"{row[column]:>16.2f}" for column in columns)
        yield f"  {row['depth']:<6}{row['algorithm']:<28}{row['seeds']:>6}{numbers}"
    for row in compared:
        said = "; ".join(
            f"{name} {value:+.2f} [{low:+.2f}, {high:+.2f}]"
            for name, (value, low, high, _) in ((name, row[name]) for name in row if isinstance(row[name], list))
        )
        yield f"  depth {row['depth']}, MAVIPER less {row['other']}: {said}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("records", nargs="*", type=Path, default=[RECORDS / name for name in NAMES])
    parser.add_argument("--json", action="store_true")
    given = parser.parse_args()
    found = {record.name: rows_of(record) for record in given.records}
    if given.json:
        print(json.dumps(found, indent=1))
        return
    for name, (levels, compared) in found.items():
        print("\n".join([*lines_of(name, levels, compared), ""]))


if __name__ == "__main__":
    main()
