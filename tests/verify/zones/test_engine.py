"""Points of zones, exactly: closed bounds against all paths, and points against the bounds that they are to meet."""

from fractions import Fraction as F
from itertools import pairwise, permutations

import numpy as np
import pytest

from verify.zones.engine import ROOM, _below, _close_bounds, middle, state
from verify.zones.tables import EPSILON, Problem, ZoneTree, infinite

NAMES = ("x", "y", "z")
SIZE, SCALE = len(NAMES) + 1, 4 * EPSILON
PLACES = {name: (0, node) for node, name in enumerate(NAMES, 1)}


def around(rng, count):
    """Bounds that a random point meets, some of them strict: (problem, (upper, lower, most, strict) of each)."""
    values = {0: F(0)} | {node: F(int(rng.integers(-8, 9)), 4) for node in range(1, SIZE)}
    bounds, edges, weights = [], [], []
    for _ in range(count):
        a, b = (int(node) for node in rng.choice(SIZE, 2, replace=False))
        room, strict = F(int(rng.integers(0, 3)), 4), bool(rng.random() < 0.5)
        strict = strict and room > 0
        most = values[a] - values[b] + room
        bounds.append((a, b, most, strict))
        edges.append((0, a, b))
        weights.append(int(most * SCALE) - strict)
    for node in range(1, SIZE):  # every coordinate has ends
        for a, b, most in ((node, 0, values[node] + 2), (0, node, 2 - values[node])):
            bounds.append((a, b, most, False))
            edges.append((0, a, b))
            weights.append(int(most * SCALE))
    return Problem([SIZE], edges, weights, infinite([SIZE], weights), SCALE, PLACES), bounds


def meets(bounds, found):
    values = {0: F(0)} | {PLACES[name][1]: value for name, value in found.items()}
    gaps = [(values[a] - values[b], most, strict) for a, b, most, strict in bounds]
    return all(gap < most if strict else gap <= most for gap, most, strict in gaps)


def matrix(problem):
    cells = [0 if i == j else problem.infinite for i in range(SIZE) for j in range(SIZE)]
    for (_, a, b), weight in zip(problem.edges, problem.weights, strict=True):
        cells[a * SIZE + b] = min(cells[a * SIZE + b], weight)
    return cells


@pytest.mark.parametrize("seed", range(40))
def test_a_point_meets_its_bounds_strict_ones_too(seed):
    problem, bounds = around(np.random.default_rng(seed), 6)
    found = state(problem, range(len(bounds)), NAMES)
    assert tuple(found) == NAMES and meets(bounds, found)


@pytest.mark.parametrize("seed", range(20))
def test_closed_bounds_are_the_least_over_all_paths(seed):
    problem, _ = around(np.random.default_rng(seed), 5)
    cells = matrix(problem)
    closed = _close_bounds(list(cells), SIZE)
    for a in range(SIZE):
        for b in range(SIZE):
            others = [node for node in range(SIZE) if node not in (a, b)]
            paths = [(a, *way, b) for n in range(len(others) + 1) for way in permutations(others, n)]
            least = min(sum(cells[i * SIZE + j] for i, j in pairwise(path)) for path in paths)
            assert closed[a * SIZE + b] == (0 if a == b else least)


@pytest.mark.parametrize("seed", range(20))
def test_a_wanted_point_is_met_where_there_is_room_and_neared_where_not(seed):
    rng = np.random.default_rng(seed)
    problem, bounds = around(rng, 6)
    zone = [_close_bounds(matrix(problem), SIZE)]
    wanted = {name: F(int(rng.integers(-12, 13)), 4) for name in NAMES}
    found = middle(problem, zone, NAMES, wanted)
    assert meets(bounds, found)
    high, low = zone[0][SIZE], -zone[0][1]  # of the first coordinate, which nothing was chosen before
    room = (high - low) // ROOM
    value = wanted["x"] * problem.scale
    assert found["x"] * problem.scale == min(max(value, low + room), high - room)


def test_a_point_without_wishes_is_in_the_middle_of_what_is_left():
    """x in [0, 2], y - x in [0, 1]: x = 1, and then y in [1, 2]."""
    edges = [(0, 1, 0), (0, 0, 1), (0, 2, 1), (0, 1, 2)]
    weights = [2 * SCALE, 0, SCALE, 0]
    problem = Problem([3], edges, weights, infinite([3], weights), SCALE, PLACES)
    assert state(problem, range(4), ("x", "y")) == {"x": F(1), "y": F(3, 2)}
    assert state(problem, range(4), ("y", "x")) == {"y": F(3, 2), "x": F(1)}


def test_below_a_node_holds_what_holds_at_all_its_leaves():
    tree = ZoneTree([1, -1, 3, -1, -1], [2, -1, 4, -1, -1], [(None, None)] * 5, [0] * 5)
    assert _below(tree, [0, 0b110, 0, 0b111, 0b011]) == [0b010, 0b110, 0b011, 0b111, 0b011]
