"""Rows of benchmarks of trees: scores with their intervals, records of rows as JSON, and tables as the manual has them.

Does: keeps one row for each question, and finds it again; the options that such benchmarks share.
Assumes: rows with the keys of IDENTITY, those that they have; a row of another expert answers another question.
Does not: measure anything.
"""

import argparse
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from codegen.ir import Float64

IDENTITY = ("game", "team", "asked", "way", "seed")  # what one row of a record is about
DRAWS = 2_000  # of a bootstrap
INTERVAL = (0.025, 0.975)

Row = dict[str, Any]


def parse_options(described: str | None, games: Sequence[str], ways: Sequence[str], *more: str) -> argparse.Namespace:
    """The options of a command line. `games`, `ways`: the usual ones; `more`: switches of this benchmark alone."""
    parser = argparse.ArgumentParser(description=str(described).splitlines()[0])
    parser.add_argument("games", nargs="*", default=list(games))
    parser.add_argument("--train", type=Path)
    parser.add_argument("--experts", type=Path)
    parser.add_argument("--leaves", type=int)
    parser.add_argument("--ways", help="several with +", default="+".join(ways))
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--record", type=Path)
    for switch in (*more, "--json"):
        parser.add_argument(switch, action="store_true")
    return parser.parse_args()


def draw_scores(tree: Float64, expert: Float64, random: Float64) -> Float64:
    """The score (tree - random) / (expert - random) in each of DRAWS draws of episodes, the same draws for all trees.
    Each: [episodes].
    """
    rng = np.random.default_rng(0)
    drawn = rng.integers(len(tree), size=(DRAWS, len(tree)))
    ours, theirs, chance = (each[drawn].mean(axis=1) for each in (tree, expert, random))
    return (ours - chance) / (theirs - chance)


def quantiles(drawn: Float64) -> tuple[float, float]:
    """The interval of a bootstrap."""
    low, high = np.quantile(drawn, INTERVAL)
    return float(low), float(high)


def scored(tree: Float64, expert: Float64, random: Float64) -> tuple[float, float, float]:
    """The score of all episodes and the interval of a paired bootstrap. Each: [episodes]."""
    value = (tree.mean() - random.mean()) / (expert.mean() - random.mean())
    return float(value), *quantiles(draw_scores(tree, expert, random))


def read_rows(record: Path | None) -> list[Row]:
    """The rows of a record; none where there is no file."""
    return json.loads(record.read_text()) if record and record.exists() else []


def find_rows(record: Path | None, **wanted: object) -> list[Row]:
    """The rows of a record that have all of these values."""
    return [row for row in read_rows(record) if all(row.get(key) == value for key, value in wanted.items())]


def keep_rows(record: Path | None, rows: Sequence[Mapping[str, Any]]) -> None:
    """Writes rows into a record, if there is one, in the place of those with the same identity."""
    if record is None:
        return
    by_key = {tuple(str(row.get(key, "")) for key in IDENTITY): row for row in (*read_rows(record), *rows)}
    record.parent.mkdir(parents=True, exist_ok=True)
    record.write_text("[\n" + ",\n".join(json.dumps(by_key[key]) for key in sorted(by_key)) + "\n]\n")


def tell_score(row: Row) -> str:
    """A row's score with its interval."""
    return f"{row['score']:.3f} [{row['low']:.3f}, {row['high']:.3f}]"


def align(cells: Sequence[Sequence[str]]) -> list[str]:
    """The lines of a table in Markdown, its first row the heads."""
    wide = [max(map(len, column)) for column in zip(*cells, strict=True)]
    lines = ["| " + " | ".join(map(str.ljust, row, wide)) + " |" for row in cells]
    return [lines[0], "|" + "|".join("-" * (width + 2) for width in wide) + "|", *lines[1:]]
