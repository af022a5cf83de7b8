"""What cells cost, in CPU seconds, from measured costs.

Does: estimates a cell by those of its kind, game, algorithm, preset and splits, linearly between depths.
Assumes: costs.toml, which tests/benchmarks/reproduce.py measured on one core of one machine.
Does not: know how fast this machine is.
"""

import tomllib
from functools import cache
from importlib import resources

import numpy as np

from maviper.extraction.bundles import RGMDT
from maviper.reproduction.cells.cell import Cell

FILE = "costs.toml"
UNKNOWN = 30.0  # CPU seconds of what was never measured
PLAYED = 2.0  # of a profile that is there already
Costs = dict[str, dict[str, float]]  # what -> depth, as text -> CPU seconds


def key_of(cell: Cell, *, exactly: bool = True) -> str:
    """What cells that cost the same have in common, their depths aside."""
    words = [cell.kind, cell.game.partition(",")[0], cell.algorithm]
    if exactly:
        words += [cell.preset, cell.splits, "leaves" if cell.leaves else ""]
    return " ".join(word for word in words if word)


@cache
def measured() -> Costs:
    """The table."""
    return tomllib.loads((resources.files("maviper.reproduction.cells") / FILE).read_text(encoding="utf-8"))


def estimate(cell: Cell) -> float:
    """CPU seconds of a cell."""
    known = measured().get(key_of(cell))
    if known is None and cell.leaves and cell.algorithm != RGMDT:
        return PLAYED
    if known is None:  # of another preset or other splits: better than nothing
        like = key_of(cell, exactly=False)
        known = next((rows for name, rows in sorted(measured().items()) if name.startswith(like)), {"0": UNKNOWN})
    depths = sorted(map(int, known))
    return float(np.interp(cell.depth, depths, [known[str(depth)] for depth in depths]))
