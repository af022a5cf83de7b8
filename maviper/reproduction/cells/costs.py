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
    """CPU seconds of a cell; `UNKNOWN` where nothing like it was measured."""
    return PLAYED if _played(cell) else _interpolated(cell, _known(cell) or {"0": UNKNOWN})


def guessed(cell: Cell) -> bool:
    """Whether nothing like a cell was measured."""
    return not _played(cell) and _known(cell) is None


def _played(cell: Cell) -> bool:
    return cell.leaves > 0 and cell.algorithm != RGMDT and key_of(cell) not in measured()


def _known(cell: Cell) -> dict[str, float] | None:
    """Depth, as text -> CPU seconds; those of another preset or other splits are better than nothing."""
    like = key_of(cell, exactly=False)
    near = (rows for name, rows in sorted(measured().items()) if f"{name} ".startswith(f"{like} "))
    return measured().get(key_of(cell)) or next(near, None)


def _interpolated(cell: Cell, known: dict[str, float]) -> float:
    depths = sorted(map(int, known))
    return float(np.interp(cell.depth, depths, [known[str(depth)] for depth in depths]))
