"""`robust` and `diff` against every cell of many small random profiles."""

import itertools
import math
from fractions import Fraction

import numpy as np
import pytest

from tests.support import brute
from tests.support.observations import NAMES, blind
from verify.claims.observed import View, over
from verify.claims.region_files import everywhere
from verify.extent.radius import radius
from verify.result import Verdict
from verify.verdicts.differences import difference

pytestmark = pytest.mark.solver
SMALL, LARGE = 60, 1_500
SPAN = Fraction(2)
MOST = 20_000  # cells of a case


def cases(count, many=LARGE):
    return pytest.mark.parametrize(
        "cases",
        [range(count), pytest.param(range(count, count + many), marks=pytest.mark.slow)],
        ids=["small", "large"],
    )


def drawn(seed, n_agents, max_depth=4):
    """(rng, trees by agent, features by agent), float32 or float64 for each agent."""
    rng = np.random.default_rng([30, seed])
    kinds = [str(rng.choice(["float32", "float64"])) for _ in range(n_agents)]
    pool = brute.random_pool(rng)
    trees, features = {}, {}
    for number, kind in enumerate(kinds):
        own = pool.astype(kind)
        if kind == "float64":
            own = np.concatenate([own, np.nextafter(own[np.abs(own) > 0.1], 9.0)])
        n_features = int(rng.integers(1, 4))
        name = "abc"[number]
        trees[name] = brute.random_tree(rng, n_features, max_depth, own, numbers=kind)
        features[name] = list(NAMES[:n_features])
    return rng, trees, features


@cases(SMALL * 10)
def test_radii_are_the_distance_to_the_nearest_cell_of_another_action(cases):
    for seed in cases:
        rng, trees, features = drawn(seed, 1, 5)
        tree, names = trees["a"], features["a"]
        lines = [brute.lines_of([(tree, place)]) for place in range(len(names))]
        cells = [
            (cell, brute.action_of(tree, [brute.float_in(line) for line in cell]))
            for cell in itertools.product(*lines)
            if all(brute.float_in(line) is not None for line in cell)
        ]
        exact = len(cells) == math.prod(map(len, lines))
        pool = [*tree.threshold.tolist(), *(np.nextafter(tree.threshold, 9)).tolist(), *rng.uniform(-2, 2, 3).tolist()]
        for _ in range(4):
            seen = [float(rng.choice(pool)) for _ in names]
            action = brute.action_of(tree, seen)
            found = radius(tree, seen)
            far = [
                max(brute.gap(line, Fraction(value)) for line, value in zip(cell, seen, strict=True))
                for cell, other in cells
                if other != action
            ]
            assert found.action == action, (seed, seen)
            if not far:
                assert not exact or found.distance is None, (seed, seen)
                continue
            distance, beyond = min(far)
            if exact:
                assert (found.distance, found.beyond) == (distance, beyond), (seed, seen)
            assert found.distance is not None and found.distance <= distance, (seed, seen)
            largest, above = Fraction(found.largest), Fraction(math.nextafter(found.largest, math.inf))
            assert largest < distance or (largest == distance and beyond), (seed, seen)
            assert not exact or above > distance or (above == distance and not beyond), (seed, seen)


def cells_of(trees, box, exact=False):
    """Every cell (variable -> part) of a box that trees tell apart. `trees`: (tree, the variables of its features)."""
    parts = []
    for name, bounds in box.items():
        reading = [(tree, names.index(name)) for tree, names in trees if name in names]
        lines = (brute.inside(line, *bounds) for line in brute.lines_of(reading, exact))
        parts.append([line for line in lines if line])
    return (
        [dict(zip(box, cell, strict=True)) for cell in itertools.product(*parts)]
        if math.prod(map(len, parts)) <= MOST
        else []
    )


def volume(cell, box):
    """The share of a box that a cell is."""
    sides = [(line[2] - line[0], box[name][1] - box[name][0]) for name, line in cell.items()]
    return math.prod((Fraction(side, whole) for side, whole in sides), start=Fraction(1))


@cases(SMALL)
def test_a_comparison_tells_the_exact_share_of_cells_that_differ(cases):
    """Teams of one to three agents, which share `angle`; every other agent is left as it was."""
    told = set()
    for seed in cases:
        rng, trees, features = drawn(seed, 1 + seed % 3, 3)
        pool = brute.random_pool(rng)
        changed = {
            agent: brute.random_tree(rng, len(features[agent]), 2, pool.astype(tree.numbers), numbers=tree.numbers)
            for agent, tree in trees.items()
            if rng.random() < 0.5
        }
        view = View(("angle",) if len(trees) > 1 else ())
        wide = {agent: list(NAMES[: len(own)]) for agent, own in features.items()}
        one, other = (over(blind(each, wide, float(SPAN)), view) for each in (trees, {**trees, **changed}))
        own = {
            agent: [name if len(trees) == 1 or name == "angle" else f"{agent}.{name}" for name in names]
            for agent, names in wide.items()
        }
        pairs = [(trees[agent], tree, own[agent]) for agent, tree in changed.items()]
        each = [(tree, names) for first, second, names in pairs for tree in (first, second)]
        cells = cells_of(each, box_of(own))
        if not cells:
            continue
        share, open_ = Fraction(0), False
        for cell in cells:
            differs = [differing(first, second, [cell[name] for name in names]) for first, second, names in pairs]
            open_ |= None in differs and not any(differs)
            share += volume(cell, box_of(own)) if any(differs) else 0
        found = difference(one, other, list(trees), everywhere(one))
        told.add(found.verdict)
        if not open_:
            assert found.verdict is (Verdict.VIOLATED if share else Verdict.PROVED), seed
            assert found.together == (share, share), seed
    assert told == {Verdict.PROVED, Verdict.VIOLATED}


def differing(first, second, cell):
    """Whether two trees act differently in a cell; None where it holds no float64 numbers."""
    values = [brute.float_in(line) for line in cell]
    return None if None in values else brute.action_of(first, values) != brute.action_of(second, values)


def box_of(own):
    return dict.fromkeys(itertools.chain.from_iterable(own.values()), (-SPAN, SPAN))
