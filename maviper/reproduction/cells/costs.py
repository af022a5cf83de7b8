"""What cells cost, in CPU seconds, from measured costs.

Does: estimates a cell by those of its kind, game, algorithm, preset and splits, linearly between depths; one that was
  not measured by the nearest that was, times a factor.
Assumes: costs.toml, which tests/benchmarks/reproduce.py measured on one core of one machine.
Does not: know how fast this machine is.
"""

import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cache
from importlib import resources
from itertools import product

import numpy as np

from maviper.extraction.settings import (
    EXACT,
    EXPLORING,
    FITTED_Q,
    HISTOGRAM,
    IMITATION,
    IVIPER,
    IVIPER_RESAMPLING,
    MAVIPER,
    NO_PREDICTION,
    PAPER,
    RELEASED,
    RGMDT,
    VIPER,
)
from maviper.reproduction.cells.cell import EXTRACTION, Cell, Task

FILE = "costs.toml"
UNKNOWN = 30.0  # CPU seconds of what nothing in the table is like
PLAYED = 2.0  # of a profile that is there already
UNIT = 1_000  # of steps or episodes spent on responders: the table's rows "effort ..." say what so many more cost ...
BEGUN = 0  # ... and what it costs to begin, once
Costs = Mapping[str, Mapping[str, float]]  # what -> depth, as text -> CPU seconds

# Factors of what was not measured. Every threshold costs MAVIPER in deception 1.5 times as much as histograms do;
# games are set apart by their agents, steps and contacts.
MEASURED_GAME = "physical-deception"
GAME_FACTORS = {"cooperative-navigation": 0.8, "predator-prey": 1.3}
EXACT_FACTOR = 1.5
LIKE: Mapping[str, tuple[str, float]] = {  # algorithm -> another one, and how much of its cost: the same loop
    "joint-rollouts": (MAVIPER, 1.0),
    "joint-selection": (MAVIPER, 1.0),
    "vote-N": (MAVIPER, 1.0),
    NO_PREDICTION: (MAVIPER, 0.8),
    IVIPER_RESAMPLING: (MAVIPER, 0.5),
    VIPER: (IVIPER, 1.0),
    RGMDT: (IMITATION, 2.0),
    EXPLORING: (FITTED_Q, 1.0),
}


def key_of(cell: Cell) -> str:
    """Returns the key that cells of the same cost have in common, their depths aside."""
    words = [cell.kind, cell.game.partition(",")[0], cell.algorithm]
    words += [cell.preset, cell.splits, "leaves" if cell.leaves else ""]
    return " ".join(word for word in words if word)


@cache
def load_costs() -> Costs:
    """The table."""
    return tomllib.loads((resources.files("maviper.reproduction.cells") / FILE).read_text(encoding="utf-8"))


def estimate(task: Task) -> float:
    """CPU seconds of a task, with what is spent on responders."""
    rates = ((load_costs().get(f"effort {name}", {}), count) for name, count in task.effort.items() if count)
    spent = sum(rows.get(str(BEGUN), 0.0) + rows.get(str(UNIT), 0.0) * count / UNIT for rows, count in rates)
    return spent + (PLAYED if _is_played(task.cell) else _nearest(task.cell))


def is_guessed(cell: Cell) -> bool:
    """Returns True if a cell's cost is derived from others'."""
    return not _is_played(cell) and key_of(cell) not in load_costs()


def _is_played(cell: Cell) -> bool:
    return cell.leaves > 0 and cell.algorithm != RGMDT and key_of(cell) not in load_costs()


def _nearest(cell: Cell) -> float:
    """CPU seconds of a cell, or of the nearest one that was measured, times a factor."""
    known = ((factor, other) for factor, other in _alike(cell) if key_of(other) in load_costs())
    factor, other = next(known, (1.0, None))
    return UNKNOWN if other is None else factor * _at(other)


def _alike(cell: Cell) -> Iterator[tuple[float, Cell]]:
    """The cell itself, then those like it, the nearest first, each with the factor of its cost."""
    games = [(1.0, cell.game), (GAME_FACTORS.get(cell.game.partition(",")[0], 1.0), MEASURED_GAME)]
    algorithms = [(1.0, cell.algorithm)]
    if cell.algorithm in LIKE:
        other, share = LIKE[cell.algorithm]
        algorithms.append((share, other))
    slow = EXACT_FACTOR if cell.splits == EXACT or cell.preset == RELEASED else 1.0
    styles = [(1.0, cell.preset, cell.splits), (slow, PAPER, HISTOGRAM)]
    for (one, game), (two, algorithm), (three, preset, splits) in product(games, algorithms, styles):
        for leaves in dict.fromkeys((cell.leaves, 0)):
            similar = replace(cell, game=game, algorithm=algorithm, preset=preset, splits=splits, leaves=leaves)
            yield one * two * three, similar


def _at(cell: Cell) -> float:
    """The cost at the cell's depth; where one depth was measured, others have the proportions of deception's."""
    known = load_costs()[key_of(cell)]
    if len(known) > 1 or str(cell.depth) in known:
        return _interpolate_depth(known, cell.depth)
    (depth,) = known
    rows = (
        load_costs().get(key_of(replace(cell, game=MEASURED_GAME, algorithm=name))) for name in (cell.algorithm, IVIPER)
    )
    shape = next((row for row in rows if row and len(row) > 1 and cell.kind == EXTRACTION), {"0": 1.0})
    return known[depth] * _interpolate_depth(shape, cell.depth) / _interpolate_depth(shape, int(depth))


def _interpolate_depth(known: Mapping[str, float], depth: int) -> float:
    depths = sorted(map(int, known))
    return float(np.interp(depth, depths, [known[str(each)] for each in depths]))
