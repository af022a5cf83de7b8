"""Volumes of overlapping zones against simplices counted one by one."""

from itertools import permutations, product

import numpy as np
import pytest

from verify.extent.violations import union
from verify.zones.tables import EPSILON, Problem

SIDE = 4  # zones lie in a cube of this side, all their bounds integers
# of each simplex of a unit cube (one for each order of the coordinates' fractions) a point: any such zone holds all of
# the simplex, or none of it but edges
POINTS = [
    [4 * corner + part for corner, part in zip(cube, order, strict=True)]  # in quarters
    for cube in product(range(SIDE), repeat=3)
    for order in permutations((1, 2, 3))
]
ENDS = np.array([[0, *point] for point in POINTS])
NODES = 4  # the origin, and three coordinates
CUBE = Problem([NODES], [], [], 1 << 40, EPSILON, {name: (0, k + 1) for k, name in enumerate("xyz")})


def drawn(rng):
    """The cells of a random zone, closed, with some strict bounds; None where it is empty."""
    most = [[0 if a == b else SIDE for b in range(NODES)] for a in range(NODES)]
    for k in range(1, NODES):
        low, high = sorted(rng.choice(SIDE + 1, 2, replace=False).tolist())
        most[k][0], most[0][k] = high, -low
    for _ in range(int(rng.integers(0, 3))):
        a, b = rng.choice(np.arange(1, NODES), 2, replace=False)
        most[a][b] = int(rng.integers(-1, 3))
    cells = [
        [cell * EPSILON - (a != b and rng.random() < 0.3) for b, cell in enumerate(row)] for a, row in enumerate(most)
    ]
    for through, a, b in product(range(NODES), repeat=3):
        cells[a][b] = min(cells[a][b], cells[a][through] + cells[through][b])
    return None if any(cells[a][a] < 0 for a in range(NODES)) else [cell for row in cells for cell in row]


def inside(zone):
    """Which of POINTS a zone holds."""
    gaps = ENDS[:, :, None] - ENDS[:, None, :]
    return (gaps * EPSILON <= 4 * np.array(zone[1]).reshape(NODES, NODES)).all(axis=(1, 2))


def count(zone):
    """The simplices in a zone: six times its volume."""
    return int(inside(zone).sum())


def together(zones):
    return int(np.any([inside(zone) for zone in zones], axis=0).sum())


def test_what_several_zones_hold_is_counted_once_and_nothing_is_lost():
    """Exactly: a part that is lost or counted twice shows however small it is."""
    rng, overlapping, cut = np.random.default_rng(7), 0, 0
    for _ in range(40):
        zones = [((), cells) for cells in (drawn(rng) for _ in range(12)) if cells is not None]
        own = [count(zone) for zone in zones]
        found = union(CUBE, zones, own, {}, count, 10_000)
        wanted = together(zones)
        assert found.least == found.most == wanted
        overlapping += wanted < sum(own)
        cut += found.parts > len(zones)
    assert overlapping > 20 and cut > 10


@pytest.mark.parametrize("budget", [0, 1, 3])
def test_a_spent_budget_leaves_bounds(budget):
    rng = np.random.default_rng(8)
    zones = [((), cells) for cells in (drawn(rng) for _ in range(20)) if cells is not None]
    found = union(CUBE, zones, [count(zone) for zone in zones], {}, count, budget)
    wanted = together(zones)
    assert found.least <= wanted <= found.most and found.least < found.most
