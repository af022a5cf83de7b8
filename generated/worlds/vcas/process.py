"""The decision process of a collision advisory system: its table of scores, and what the table decides in a state.

Does: value iteration over height, climb rate, time and previous advisory; scores and decisions between grid points.
Assumes: the plant of ARCH-COMP's VCAS (verivital/ARCH-COMP2025): a level intruder, steps of one second.
Does not: know trees, or the files of the worlds.

The own aircraft climbs with v, the intruder is h above it. An advisory acts in the second in which it is given:

    h' = h - v - a/2,   v' = v + a

The pilot takes any acceleration of the advisory's three; none if the advisory is repeated and v complies with it. The
cost is the claim's: 1 once |h| is at most 100 ft, whatever the pilot takes, and a price for each second of an alert,
which counts less the later it comes.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
G = 32.2  # ft/s^2
CLEAR = 100.0  # ft: a height of at most this is lost
HORIZON = 25  # s until the aircraft are no longer side by side


class Advisory(NamedTuple):
    """Accelerations that the pilot may take, in units of g/24, and the climb rate in ft/min that complies."""

    choices: tuple[int, ...]
    complies: tuple[float, float]  # least and most; empty where none does
    strength: int


NEVER, ANY = (1.0, -1.0), float("inf")
ADVISORIES: Mapping[str, Advisory] = {
    "COC": Advisory((-3, 0, 3), NEVER, 0),
    "DNC": Advisory((-8, -7, -6), (-ANY, 0), 0),
    "DND": Advisory((6, 7, 8), (0, ANY), 0),
    "DES1500": Advisory((-8, -7, -6), (-ANY, -1500), 1),
    "CL1500": Advisory((6, 7, 8), (1500, ANY), 1),
    "SDES1500": Advisory((-8,), (-ANY, -1500), 2),
    "SCL1500": Advisory((8,), (1500, ANY), 2),
    "SDES2500": Advisory((-8,), (-ANY, -2500), 3),
    "SCL2500": Advisory((8,), (2500, ANY), 3),
}
NAMES = tuple(ADVISORIES)
UNIT = G / 24
ALERT, STRONGER = 0.01, 0.001  # prices: of a second of alert, and of each step by which it is stronger
LATER = 0.5  # what a price is worth a second later
HEIGHTS: Floats = np.array([*np.arange(100.0, 160.0, 0.5), *160 * (1500 / 160) ** np.linspace(0, 1, 60)])
HEIGHTS = np.concatenate([-HEIGHTS[::-1], HEIGHTS])  # none within the band, which is lost
RATES: Floats = np.arange(-45, 46) * UNIT


def price(given: int) -> float:
    """What a second of an advisory costs."""
    return ALERT + STRONGER * ADVISORIES[NAMES[given]].strength if given else 0.0


class Table:
    """Scores of all advisories on the grid: `scores` [time, before, given, height, rate]; the least is taken."""

    def __init__(self) -> None:
        n, shape = len(NAMES), (len(HEIGHTS), len(RATES))
        self.scores: npt.NDArray[np.float32] = np.zeros((HORIZON + 1, n, n, *shape), dtype=np.float32)
        moves = {a: _Move(a) for advisory in ADVISORIES.values() for a in (*advisory.choices, 0)}
        prices = np.array([price(given) for given in range(n)])[:, None, None]
        lost, paid = np.zeros((n, *shape)), np.zeros((n, *shape))
        for left in range(1, HORIZON + 1):
            worst = [self._ahead(moves, given, lost[given], 1.0) for given in range(n)]
            dear = [self._ahead(moves, given, paid[given], 0.0) for given in range(n)]
            losing = np.stack([np.stack([worst[given][given == before] for given in range(n)]) for before in range(n)])
            paying = np.stack([np.stack([dear[given][given == before] for given in range(n)]) for before in range(n)])
            paying = prices + LATER * paying
            self.scores[left] = losing + paying
            best = np.argmin(self.scores[left], axis=1)[:, None]
            lost, paid = (np.take_along_axis(each, best, axis=1)[:, 0] for each in (losing, paying))

    @staticmethod
    def _ahead(moves: Mapping[int, "_Move"], given: int, ahead: Floats, lost: float) -> tuple[Floats, Floats]:
        """What is to be paid after the worst acceleration of an advisory: when it is new, and when it is repeated."""
        advisory = ADVISORIES[NAMES[given]]
        worst = np.max([moves[a].after(ahead, lost) for a in advisory.choices], axis=0)
        complies = (advisory.complies[0] <= 60 * RATES) & (advisory.complies[1] >= 60 * RATES)
        return worst, np.where(complies, moves[0].after(ahead, lost), worst)

    @property
    def entries(self) -> int:
        """How many scores it holds."""
        return self.scores[1:].size

    def of(self, height: Floats, rate: Floats, left: Ints, before: Ints) -> Floats:
        """Scores between grid points, [batch, advisories]: in straight lines along height and rate."""
        i, s = _between(HEIGHTS, height)
        j, t = _between(RATES, rate)
        found = np.zeros((len(height), len(NAMES)))
        for di, dj, weight in ((0, 0, (1 - s) * (1 - t)), (1, 0, s * (1 - t)), (0, 1, (1 - s) * t), (1, 1, s * t)):
            found += weight[:, None] * self.scores[left, before, :, i + di, j + dj]
        return found

    def decide(self, height: Floats, rate: Floats, left: Ints, before: Ints) -> Ints:
        """The advisory with the least score, the weaker of equal ones, [batch]."""
        return np.argmin(np.round(self.of(height, rate, left, before), 6), axis=1)


class _Move:
    """A second with one acceleration, from every grid point."""

    def __init__(self, acceleration: int) -> None:
        height = HEIGHTS[:, None] - RATES[None] - acceleration * UNIT / 2
        self._lost = np.abs(height) <= CLEAR
        self._row, self._share = _between(HEIGHTS, height)
        self._column = np.clip(np.arange(len(RATES)) + acceleration, 0, len(RATES) - 1)[None]

    def after(self, ahead: Floats, lost: float) -> Floats:
        """What is still to be paid then; `lost` within the band."""
        low, high = ahead[self._row, self._column], ahead[self._row + 1, self._column]
        return np.where(self._lost, lost, low + self._share * (high - low))


def _between(grid: Floats, values: Any) -> tuple[Ints, Floats]:
    """Of each value the grid point below, and which share of the way to the next one it has gone. The two grid points
    beside the band count as one each for what lies within.
    """
    below = np.clip(np.searchsorted(grid, values, side="right") - 1, 0, len(grid) - 2)
    share = np.clip((values - grid[below]) / (grid[below + 1] - grid[below]), 0.0, 1.0)
    return below, share


def episodes(decide: Any, starts: tuple[Floats, Floats], rng: np.random.Generator, steps: int) -> dict[str, Any]:
    """Episodes of a controller with random pilots: states [steps, batch], advisories, and who was lost."""
    height, rate = (each.copy() for each in starts)
    before = np.zeros(len(height), dtype=np.int64)
    seen: dict[str, list[Any]] = {name: [] for name in ("height", "rate", "left", "before", "given", "alive")}
    alive = np.abs(height) > CLEAR
    least = np.array([[(each.choices * 3)[k] for k in range(3)] for each in ADVISORIES.values()])
    bounds = np.array([each.complies for each in ADVISORIES.values()])
    for step in range(steps):
        left = np.full(len(height), HORIZON - step)
        given = decide(height, rate, left, before)
        for name, values in zip(seen, (height, rate, left, before, given, alive), strict=True):
            seen[name].append(values)
        taken = least[given, rng.integers(3, size=len(height))]
        complies = (given == before) & (60 * rate >= bounds[given, 0]) & (60 * rate <= bounds[given, 1])
        a = np.where(complies, 0, taken) * UNIT
        height, rate, before = height - rate - a / 2, rate + a, given
        alive = alive & (np.abs(height) > CLEAR)
    return {name: np.array(values) for name, values in seen.items()} | {"lost": ~alive}
