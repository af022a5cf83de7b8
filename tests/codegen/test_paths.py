"""Paths: the box of a leaf is what the reference sends there; nested trees become arrays and back."""

import numpy as np
import pytest

from codegen import ir
from codegen.boxes import box_of, find_point, split_corners
from codegen.paths import EVERYTHING, Box, in_preorder
from tests.support.games import NAMES, random_profile
from tests.support.teams import tree


def nested(found, node=ir.ROOT):
    if found.feature[node] == ir.NO_FEATURE:
        return int(found.action[node])
    sides = (nested(found, int(child)) for child in (found.left[node], found.right[node]))
    return int(found.feature[node]), float(found.threshold[node]), *sides


@pytest.mark.parametrize("name", NAMES[:2])
def test_boxes_hold_what_the_reference_sends_to_their_leaves(name):
    for policy in random_profile(name).agents:
        rows = np.random.default_rng(0).uniform(-2, 2, (300, len(policy.features))).astype(np.float32)
        rows[::7, 0] = np.inf
        reached = ir.apply(policy.tree, rows)
        for leaf in np.unique(reached):
            box = box_of(policy.tree, int(leaf))
            above = [rows[:, feature] > low for feature, low in box.low.items()]
            below = [rows[:, feature] <= high for feature, high in box.high.items()]
            assert (np.all([reached >= 0, *above, *below], axis=0) == (reached == leaf)).all()
            assert ir.apply(policy.tree, find_point(box, len(policy.features), policy.numbers)[None])[0] == leaf


@pytest.mark.parametrize("name", NAMES[:2])
def test_a_nested_tree_becomes_the_same_arrays(name):
    for policy in random_profile(name).agents:
        found = in_preorder(nested(policy.tree), lambda node: node, policy.numbers)
        for array in ("feature", "threshold", "left", "right", "action"):
            assert getattr(found, array).tobytes() == getattr(policy.tree, array).tobytes()


def test_a_leaf_that_nothing_reaches_has_an_empty_box():
    twice = tree((0, 0.5, 1, 2), 0, (0, 0.25, 3, 4), 1, 2)
    assert box_of(twice, 4) == Box({0: 0.5}, {}) and box_of(twice, 0) == EVERYTHING
    assert box_of(twice, 3) == Box({0: 0.5}, {0: 0.25})


def test_a_test_parts_what_reaches_it():
    low, high = np.float32([-np.inf, -1]), np.float32([np.inf, 1])
    (least, left), (right, most) = split_corners(low, high, 1, np.float32(0.5))
    assert left.tolist() == [np.inf, 0.5] and right.tolist() == [-np.inf, 0.5]
    assert least is low and most is high and high[1] == 1, "what is given stays as it is"
