"""Steps folded into thresholds: the tree decides as the steps and the tree after them, for every kind of number."""

import numpy as np
import pytest

from codegen import ir
from codegen.importers.onnx.fitted import LARGEST, Asked, fold_steps
from codegen.ir import GrownTree, Tree
from codegen.lowering.deploy import deploy_tree
from codegen.numbers.rounding import neighbour

ONE = np.float32
STEPS = {
    "nothing": (lambda x: x, True),
    "times a tenth": (lambda x: x * ONE(0.1), True),
    "minus, then times": (lambda x: (x - ONE(1.7)) * ONE(0.07), True),
    "times a negative number": (lambda x: x * ONE(-3), False),
    "from a number": (lambda x: ONE(0.3) - x, False),
    "so large that most is infinite": (lambda x: x * ONE(3e38), True),
    "so small that most is 0": (lambda x: x * ONE(-1e-40), False),
    "by way of doubles": (lambda x: (x.astype(np.float64) * 0.3 + 1e-9).astype(np.float32), True),
    "clipped": (lambda x: np.clip(x, ONE(-1), ONE(0.2)), True),
    "compared": (lambda x: (x > ONE(0.25)).astype(np.float32), True),
    "compared, turned": (lambda x: (x < ONE(0.25)).astype(np.float32), False),
}
THRESHOLDS = [0.2, -0.2, 0.0, 1e-45, -1e30, 0.5]
SPECIAL = np.array([0, -0.0, 1e-45, -1e-45, LARGEST, -LARGEST, np.inf, -np.inf, 1, -1], dtype=np.float32)


def stump(threshold):
    return GrownTree([0, -1, -1], [threshold, 0, 0], [1, -1, -1], [2, -1, -1], [-1, 0, 1])


@pytest.mark.parametrize("threshold", THRESHOLDS)
@pytest.mark.parametrize("name", STEPS)
def test_a_folded_test_decides_as_the_steps(name, threshold):
    step, rising = STEPS[name]

    def passes(numbers):
        with np.errstate(all="ignore"):
            return step(numbers) <= np.float64(threshold)

    made = fold_steps(stump(threshold), Asked(np.array([2]), np.array([rising]), passes))
    tree: Tree = deploy_tree(made.tree)
    if not np.isfinite(tree.threshold).all():  # only -infinity is on one side, which no profile can say
        assert tree.threshold[0] == -np.inf
        return
    rng = np.random.default_rng(0)
    numbers = rng.normal(size=3_000).astype(np.float32) * np.float32(10.0) ** rng.integers(-30, 30, 3_000)
    at = tree.threshold[tree.feature >= 0]
    beside = [neighbour(at, -np.inf), at, neighbour(at, np.inf)]
    numbers = np.concatenate([numbers.astype(np.float32), SPECIAL, *beside])
    rows = np.zeros((len(numbers), 3), dtype=np.float32)
    rows[:, 2] = numbers
    assert (tree.action[ir.apply(tree, rows)] == np.where(passes(numbers), 0, 1)).all()
    nan = np.full(1, np.nan, dtype=np.float32)
    said = tree.action[ir.apply(tree, np.full((1, 3), nan))][0]
    assert made.nan == (said == (0 if passes(nan)[0] else 1))


def test_tests_that_cannot_fail_or_hold_disappear_from_the_middle_of_a_tree():
    grown = GrownTree([0, 1, -1, -1, -1], [9, 0.5, 0, 0, 0], [1, 3, -1, -1, -1], [2, 4, -1, -1, -1], [-1, -1, 2, 0, 1])
    tests = Asked(np.array([0, 1]), np.array([True, True]), lambda numbers: np.array([True, bool(numbers[1] <= 0.5)]))
    tree = fold_steps(grown, tests).tree
    assert tree.feature.tolist() == [1, -1, -1] and tree.action.tolist() == [-1, 0, 1]
    assert fold_steps(GrownTree([-1], [0], [-1], [-1], [1]), tests).tree.action.tolist() == [1]


def test_only_finite_numbers_count_where_infinite_ones_are_not_taken():
    tests = Asked(np.array([0]), np.array([True]), lambda numbers: numbers <= LARGEST)
    assert fold_steps(stump(0.0), tests, LARGEST).tree.action.tolist() == [0]
    assert fold_steps(stump(0.0), tests).tree.threshold[0] == LARGEST
