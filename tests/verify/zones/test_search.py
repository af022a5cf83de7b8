"""The search through difference bounds, against every point of a grid: such bounds have a point there if anywhere."""

from itertools import pairwise, product

import numpy as np
import pytest

from verify.zones.search import BudgetError, ZoneSearch
from verify.zones.tables import TRUE, Flat, Problem, ZoneTree, infinite

NODES, MOST, WIDE = 3, 3, 9  # nodes beside the origin, the largest weight, and how far points are tried
GRID = np.array(list(product(range(-WIDE, WIDE + 1), repeat=NODES)))
AT = np.column_stack([np.zeros(len(GRID), dtype=int), GRID])


def drawn(rng, count):
    """Random bounds a - b <= weight over one component of four nodes."""
    edges = [(0, *map(int, rng.choice(NODES + 1, 2, replace=False))) for _ in range(count)]
    weights = [int(weight) for weight in rng.integers(-MOST, MOST + 1, count)]
    return Problem([NODES + 1], edges, weights, infinite([NODES + 1], weights), 1, {})


def random_flat(rng, problem, choices=2):
    pick = lambda most: tuple(int(n) for n in rng.integers(len(problem.edges), size=int(rng.integers(0, most))))  # noqa: E731
    parts = lambda: tuple(Flat(pick(3), ()) for _ in range(int(rng.integers(1, 4))))  # noqa: E731
    return Flat(pick(4), tuple(parts() for _ in range(int(rng.integers(0, choices + 1)))))


def where(flat, problem):
    """In which points of the grid all bounds, and some part of each choice, hold; nowhere for None."""
    if flat is None:
        return np.zeros(len(AT), dtype=bool)
    found = np.ones(len(AT), dtype=bool)
    for number in flat.edges:
        _, a, b = problem.edges[number]
        found &= AT[:, a] - AT[:, b] <= problem.weights[number]
    for choice in flat.ors:
        found &= np.logical_or.reduce([where(part, problem) for part in choice])
    return found


def random_tree(rng, problem, depth):
    """A complete tree, children behind their parents, some of whose sides nobody passes."""
    inner = 2**depth - 1
    left = [2 * node + 1 if node < inner else -1 for node in range(2 * inner + 1)]
    right = [2 * node + 2 if node < inner else -1 for node in range(2 * inner + 1)]
    side = lambda: None if rng.random() < 0.1 else random_flat(rng, problem, 1)  # noqa: E731
    sides = [(side(), side()) if node < inner else (None, None) for node in range(2 * inner + 1)]
    return ZoneTree(left, right, sides, [node % 3 for node in range(2 * inner + 1)])


def ways(tree, problem, node=0):
    """(leaf, where its tests hold) of each leaf."""
    if tree.left[node] < 0:
        yield node, np.ones(len(AT), dtype=bool)
        return
    for child, flat in zip((tree.left[node], tree.right[node]), tree.sides[node], strict=True):
        for leaf, met in ways(tree, problem, child):
            yield leaf, met & where(flat, problem)


@pytest.mark.parametrize("seed", range(60))
def test_a_region_is_inhabited_where_the_grid_has_a_point_of_it(seed):
    rng = np.random.default_rng([1, seed])
    problem = drawn(rng, 8)
    region = random_flat(rng, problem, 3)
    search = ZoneSearch(problem, region, 10_000)
    assert search.is_inhabited() == where(region, problem).any()
    if search.is_inhabited():
        assert (where(Flat(tuple(search.open), ()), problem) & where(region, problem)).any()
        assert not (where(Flat(tuple(search.open), ()), problem) & ~where(region, problem)).any(), (
            "open says too little"
        )


@pytest.mark.parametrize("seed", range(25))
def test_two_trees_are_refuted_where_no_point_of_the_grid_is_left(seed):
    """What is known of an agent is its leaf; each pair of leaves has a denial of its own, or none."""
    rng = np.random.default_rng([2, seed])
    problem = drawn(rng, 10)
    trees, region = [random_tree(rng, problem, depth) for depth in (2, 1)], random_flat(rng, problem, 1)
    denials = {
        pair: None if rng.random() < 0.3 else random_flat(rng, problem, 1)
        for pair in product(range(len(trees[0].left)), range(len(trees[1].left)))
    }
    resolve = lambda known: TRUE if any(t.left[n] >= 0 for t, n in zip(trees, known, strict=True)) else denials[known]  # noqa: E731
    classes = [list(range(len(tree.left))) for tree in trees]
    left = {
        (one, two): where(region, problem) & met & also & where(denials[one, two], problem)
        for (one, met), (two, also) in product(*(list(ways(tree, problem)) for tree in trees))
    }
    violating = {pair for pair, points in left.items() if points.any()}
    search = ZoneSearch(problem, region, 100_000)
    _, closed = search.refutation(trees, classes, resolve)
    assert closed == (not violating)
    branches, complete = ZoneSearch(problem, region, 100_000).violations(trees, classes, resolve, 10_000)
    assert complete and {leaves for leaves, _ in branches} == violating
    for leaves, cells in branches:
        bounds = np.array(cells).reshape(NODES + 1, NODES + 1)
        gaps = AT[:, :, None] - AT[:, None, :]
        assert (left[leaves] & (gaps <= bounds).all(axis=(1, 2))).any()
    if branches:
        assert ZoneSearch(problem, region, 100_000).violations(trees, classes, resolve, 0) == ([], False)


@pytest.mark.parametrize("seed", range(25))
def test_a_part_holds_at_a_leaf_where_no_point_denies_it(seed):
    rng = np.random.default_rng([3, seed])
    problem = drawn(rng, 10)
    tree, region = random_tree(rng, problem, 2), random_flat(rng, problem, 1)
    parts = [[None if rng.random() < 0.2 else random_flat(rng, problem, 1) for _ in range(2)] for _ in range(3)]
    _, masks = ZoneSearch(problem, region, 100_000).lemmas(tree, parts, None)
    for leaf, met in ways(tree, problem):
        here = met & where(region, problem)
        holds = [not (here & where(denial, problem)).any() for denial in parts[tree.action[leaf]]]
        if here.any():
            assert [bool(masks[leaf] >> bit & 1) for bit in range(2)] == holds
        else:
            assert masks[leaf] in (-1, 3), "everything holds where nobody comes"
    _, fewer = ZoneSearch(problem, region, 100_000).lemmas(tree, parts, [2] * len(tree.left))
    assert all(mask == -1 or not mask & 1 for mask in fewer), "only parts that may be tried"


def test_a_budget_ends_before_the_node_that_it_has_not():
    problem = Problem([2], [(0, 1, 0), (0, 0, 1)], [1, -1], 100, 1, {})
    region = Flat((0,), ((Flat((1,), ()), Flat((), ())),))
    search = ZoneSearch(problem, region, 100)
    assert search.is_inhabited() and search.nodes == 2
    with pytest.raises(BudgetError):
        ZoneSearch(problem, region, 1).is_inhabited()
    assert ZoneSearch(problem, region, 2).is_inhabited()


def test_a_closed_branch_is_written_as_the_places_of_its_cycle():
    """a <= 1, 2 <= a, between bounds that do not matter: the cycle names the second and the first of them."""
    problem = Problem([3], [(0, 2, 0), (0, 1, 0), (0, 0, 1)], [5, 1, -2], 100, 1, {})
    search = ZoneSearch(problem, Flat((0, 1, 2), ()), 10)
    proof, closed = search.refutation((), (), lambda known: TRUE)
    assert closed and list(proof) == [2, 2, 1]


def test_each_cycle_that_closes_a_branch_is_one_and_negative():
    """Its places are those of bounds on the branch, the upper end of each the lower end of the one before."""
    closed = 0
    for seed in range(120):
        rng = np.random.default_rng([4, seed])
        problem = drawn(rng, 9)
        search = ZoneSearch(problem, Flat(tuple(range(9)), ()), 10)
        proof, empty = search.refutation((), (), lambda known: TRUE)
        assert empty != where(search.region, problem).any()
        if empty:
            size, *places = proof
            bounds = [problem.edges[place] for place in places]
            assert size == len(places) and sum(problem.weights[place] for place in places) < 0
            for (_, _, lower), (_, upper, _) in pairwise([*bounds, bounds[0]]):
                assert upper == lower
            closed += 1
    assert 20 < closed < 100
