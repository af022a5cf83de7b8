"""Exact volumes: known polytopes, and a count of the simplices that integer difference bounds are made of."""

from itertools import permutations, product
from math import factorial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from verify.zones.volume import FacesError, Volumes


def closed(bounds, size):
    """The closed matrix, row by row, of {(i, j): most of x_i - x_j}; None when nothing meets the bounds."""
    rows = [[0 if i == j else bounds.get((i, j), 10**60) for j in range(size)] for i in range(size)]
    for k, i, j in product(range(size), repeat=3):
        rows[i][j] = min(rows[i][j], rows[i][k] + rows[k][j])
    return None if any(rows[i][i] < 0 for i in range(size)) else [cell for row in rows for cell in row]


def measure(bounds, size):
    cells = closed(bounds, size)
    return 0 if cells is None else Volumes().measure(cells, size)


def box(sides):
    return {key: most for k, side in enumerate(sides, 1) for key, most in (((k, 0), side), ((0, k), 0))}


@given(st.lists(st.integers(0, 10**30), max_size=6))
def test_boxes(sides):
    assert measure(box(sides), len(sides) + 1) == factorial(len(sides)) * np.prod([1, *sides], dtype=object)


@pytest.mark.parametrize("n", range(1, 7))
def test_an_order_of_coordinates_leaves_the_simplices_of_a_cube_that_keep_it(n):
    """A chain leaves one, either way; one least element below all others, these free, (n - 1)! orders of them."""
    chain, star = ({(k, k + 1): 0 for k in range(1, n)}, {(1, k): 0 for k in range(2, n + 1)})
    back = {(b, a): 0 for a, b in chain}
    assert measure(box([1] * n) | chain, n + 1) == measure(box([1] * n) | back, n + 1) == 1
    assert measure(box([1] * n) | star, n + 1) == factorial(n - 1)


def simplices(cells, size):
    """How many unit simplices (integer corner, order of the fractional parts) lie inside: each has 1/d! of volume."""
    d, count = size - 1, 0
    ranges = [range(-cells[k], cells[k * size]) for k in range(1, size)]
    for corner in product(*ranges):
        for order in permutations(range(1, d + 1)):
            # the middle of the simplex, d + 1 times as large
            middle = [0, *((d + 1) * c + rank for c, rank in zip(corner, order, strict=True))]
            pairs = product(range(size), repeat=2)
            count += all(middle[i] - middle[j] <= (d + 1) * cells[i * size + j] for i, j in pairs)
    return count


@st.composite
def polytopes(draw):
    size = draw(st.integers(2, 5))
    sides = draw(st.lists(st.integers(0, 3), min_size=size - 1, max_size=size - 1))
    shift = draw(st.lists(st.integers(-2, 2), min_size=size - 1, max_size=size - 1))
    bounds = box(sides)
    for k, by in enumerate(shift, 1):
        bounds[k, 0] += by
        bounds[0, k] -= by
    pairs = [(i, j) for i, j in product(range(1, size), repeat=2) if i != j]
    if pairs:
        bounds |= draw(st.dictionaries(st.sampled_from(pairs), st.integers(-3, 3), max_size=6))
    return bounds, size


@given(polytopes())
def test_integer_bounds_by_their_simplices(polytope):
    cells = closed(*polytope)
    assert measure(*polytope) == (0 if cells is None else simplices(cells, polytope[1]))


@given(polytopes(), st.integers(2, 10**20))
def test_volume_scales(polytope, factor):
    bounds, size = polytope
    larger = {key: most * factor for key, most in bounds.items()}
    assert measure(larger, size) == measure(bounds, size) * factor ** (size - 1)


def test_the_budget_of_faces():
    cells = closed(box([7, 8, 9, 10]) | {(1, 2): 1, (2, 3): 2, (3, 4): 1, (4, 1): 3, (1, 3): 2}, 5)
    volumes = Volumes()
    found = volumes.measure(cells, 5)
    assert found > 0 and Volumes(volumes.faces).measure(cells, 5) == found
    with pytest.raises(FacesError):
        Volumes(volumes.faces - 1).measure(cells, 5)
