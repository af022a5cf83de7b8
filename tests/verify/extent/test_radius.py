"""The radius around an observation against all cells of its tree, and against float64 neighbours."""

import math
from fractions import Fraction

import numpy as np
import pytest

from tests.support.observations import acts, blind_tree, distance
from tests.support.teams import tree
from verify.extent.changes import radius


@pytest.mark.parametrize("seed", range(40))
def test_equals_the_distance_over_all_cells(seed):
    rng = np.random.default_rng(seed)
    grown = blind_tree(rng, 2)
    for _ in range(4):
        observation = [float(value) for value in rng.choice([0.0, 0.5, -0.7, 0.1, float(rng.uniform(-1.5, 1.5))], 2)]
        found = radius(grown, observation)
        assert found.action == acts(grown, observation)
        assert (found.distance, found.beyond) == distance(grown, observation)


@pytest.mark.parametrize("threshold", [0.5, 0.1, -0.7, 0.0, 1.0, 16777217.0])
@pytest.mark.parametrize("start", [-3.0, 0.25, 3.0])
def test_the_largest_number_is_the_last_one_that_keeps_the_action(threshold, start):
    single = tree((0, np.float32(threshold), 1, 2), 0, 1)
    found = radius(single, [start])
    sign = 1 if found.action == 0 else -1
    last = Fraction(start) + sign * Fraction(found.largest)
    end = found.distance
    assert end is not None and 0 <= end - Fraction(found.largest) <= Fraction(math.ulp(float(end)))
    inside = math.nextafter(float(last), -sign * math.inf)
    outside = math.nextafter(float(Fraction(start) + sign * end), sign * math.inf)
    assert acts(single, [inside]) == found.action != acts(single, [outside])


def test_no_other_action_has_no_distance():
    assert radius(tree(1), [0.0]).largest == math.inf
    assert radius(tree((0, 0.5, 1, 2), 1, 1), [0.0]).distance is None


def test_leaves_that_nothing_reaches_do_not_count():
    dead = tree((0, 0.5, 1, 4), (0, 0.75, 2, 3), 0, 1, 0)
    assert radius(dead, [0.0]).distance is None


def test_an_observation_on_a_tie_has_no_room():
    single = tree((0, 1.0, 1, 2), 0, 1)  # the middle above 1 goes to 1, whose significand is even
    middle = 1 + 2.0**-24
    assert acts(single, [middle]) == 0
    found = radius(single, [middle])
    assert found.largest == 0 and found.beyond
