"""Leaves as cells: every state of a box lies in one of its parts, under the action that the tree chooses there."""

import numpy as np
import pytest

from codegen.ir import act
from tests.support.system_cases import form, policy
from verify.boxes import leaf_cells
from verify.boxes.model import ModelTree
from verify.boxes.rows import Rows
from verify.systems.system import Feature, System

NAMES = ("x", "y", "z")
SYSTEM = System("s", (), {"a": {name: Feature(form(**{name: 1})) for name in NAMES}}, (), ())
COLUMNS = {name: column for column, name in enumerate(NAMES)}


def grown(random, depth):
    """A tree with thresholds on few numbers, so that tests repeat and contradict each other."""
    if depth == 0 or random.random() < 0.1:
        return int(random.integers(3))
    test = int(random.integers(3)), float(random.integers(-4, 5)) / 4
    return test, grown(random, depth - 1), grown(random, depth - 1)


@pytest.mark.parametrize("at_once", [leaf_cells.AT_ONCE, 64])
def test_every_state_keeps_its_action(monkeypatch, at_once):
    monkeypatch.setattr(leaf_cells, "AT_ONCE", at_once)
    for seed in range(8):
        random = np.random.default_rng(seed)
        one = policy("a", NAMES, ["p", "q", "r"], grown(random, 7))
        tree = ModelTree(SYSTEM, one, COLUMNS)
        low = random.integers(-10, 10, (20, 3)) / 8
        boxes = Rows.of(low, low + random.integers(0, 8, (20, 3)) / 8)
        parts = tree.split_at_tests(boxes)
        assert (parts.low <= parts.high).all()
        assert (parts.low >= low[parts.part]).all() and (parts.high <= boxes.high[parts.part]).all()
        for share in (0.0, 1.0, random.random((20, 3))):
            points = low + share * (boxes.high - low)
            for number, (point, action) in enumerate(zip(points, act(one, points), strict=True)):
                holds = (parts.low <= point).all(axis=1) & (point <= parts.high).all(axis=1) & (parts.part == number)
                assert (parts.joint[holds] == action).any()
            alone = tree.split_at_tests(Rows.of(points, points))
            assert alone.part.tolist() == list(range(20)) and alone.joint.tolist() == act(one, points).tolist()


def test_trees_of_one_leaf_and_of_sums():
    boxes = Rows.of(np.zeros((2, 3)), np.ones((2, 3)))
    assert ModelTree(SYSTEM, policy("a", NAMES, ["p", "q"], 1), COLUMNS).split_at_tests(boxes).joint.tolist() == [1, 1]
    summed = System("s", (), {"a": {"x": Feature(form(x=1, y=1))}}, (), ())
    parts = ModelTree(summed, policy("a", ["x"], ["p", "q"], ((0, 0.5), 0, 1)), COLUMNS).split_at_tests(boxes)
    assert sorted(parts.joint.tolist()) == [0, 0, 1, 1]
