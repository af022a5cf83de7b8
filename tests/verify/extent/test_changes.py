"""The largest change of an output, against what the reference gives at every float nearby and at random ones."""

from dataclasses import replace
from fractions import Fraction
from itertools import product

import numpy as np
import pytest

from codegen import ir
from codegen.errors import InputError
from codegen.floats import FLOAT32
from codegen.sums import ARITHMETICS, DOUBLE_SUMS
from tests.support import summed
from verify.extent.radius import ends_of


def given(policy, rows):
    return ir.outputs(policy, np.asarray(rows)).astype(np.float64)


def drawn(seed, at, error, count=300):
    """Observations within the errors: random ones, the ends of all features, and numbers right beside `at`."""
    rng = np.random.default_rng(seed)
    low, high = at - error, at + error
    corners = np.array(list(product(*zip(low, high, strict=True))))
    beside = np.nextafter(at, rng.choice([-1.0, 1.0], (20, len(at))) * np.inf)
    rows = np.concatenate([rng.uniform(low, high, (count, len(at))), corners, beside, [at]])
    # neither a sum nor a draw is exact
    least, most = ([Fraction(one) + side * Fraction(error) for one in at.tolist()] for side in (-1, 1))
    held = [all(map(lambda a, x, b: a <= x <= b, least, row, most)) for row in rows.tolist()]
    return rows[held]


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
@pytest.mark.parametrize(("seed", "inner"), [*product(range(4), [0.0]), (205, 0.3), (217, 0.3)])
def test_no_observation_within_the_errors_changes_an_output_by_more(seed, inner, arithmetic):
    levels = 2 if inner else 3
    policy = summed.policy(seed, arithmetic, outputs=2, levels=levels, n_features=3, inner=inner)
    rng = np.random.default_rng(seed)
    for _ in range(4):
        at, error = rng.normal(0, 1, 3), float(rng.choice([0.0, 1e-9, 0.125, 2.0]))
        for place, ends in enumerate(ends_of(policy, at.tolist(), [Fraction(error)] * 3)):
            value, *others = given(policy, [at, ends.lowest, ends.highest])[:, place]
            assert (ends.value, ends.seen) == (value, tuple(others))
            assert np.abs(np.array([ends.lowest, ends.highest]) - at).max() <= error * (1 + 1e-15)
            seen = given(policy, drawn(seed, at, error))[:, place]
            assert ends.least <= seen.min() and seen.max() <= ends.most
            assert np.abs(seen - value).max() <= ends.change and ends.change_seen <= ends.change


def test_a_feature_that_raises_a_sum_and_lowers_it_is_refused():
    """The least of (a + b) - 0.5 a among floats lies in no corner that is known."""
    policy = stump(2.0, 0.0)
    twice = ir.Sum(((1.0, ir.Sum(((1.0, 0), (1.0, 1)))), (-0.5, 0)))
    policy = replace(policy, tree=replace(policy.tree, vectors=((twice,), policy.tree.vectors[1])))
    with pytest.raises(InputError, match="with and against its sign"):
        ends_of(policy, [0.0, 0.0], [Fraction(1)] * 2)


def stump(weight, threshold, numbers=FLOAT32):
    """Left of a threshold 1, right of it twice the second feature less the first."""
    sums = ((ir.Sum(((1.0, ir.CONSTANT),)),), (ir.Sum(((weight, 1), (-1.0, 0))),))
    nodes = ([0, ir.NO_FEATURE, ir.NO_FEATURE], [threshold, 0, 0], [1, -1, -1], [2, -1, -1], [ir.NO_ACTION, 0, 1])
    tree = ir.Tree(*map(np.array, nodes), numbers=numbers, arithmetic=DOUBLE_SUMS, vectors=sums, gives="float64")
    features = tuple(ir.FeatureSpec(name, "none", -10, 10, None) for name in "ab")
    return ir.AgentPolicy("cart", "team", features, (), tree, outputs=(ir.OutputSpec("push", "none", None, 15.0),))


def test_ends_of_single_tests_are_exact_to_the_last_bit():
    policy, just = stump(2.0, 0.5), float(np.nextafter(np.float32(0.5), np.float32(1)))
    (ends,) = ends_of(policy, [0.25, 3.0], [Fraction(1, 2)] * 2)
    assert (ends.value, ends.least, ends.most) == (1.0, 1.0, 7.0 - just) and ends.exact
    assert ends.change == ends.change_seen == 6.0 - just and ends.highest == (just, 3.5)
    (ends,) = ends_of(policy, [0.25, 3.0], [Fraction(0), Fraction(1)])  # one feature errs alone
    assert (ends.least, ends.most, ends.change) == (1.0, 1.0, 0.0)
    (ends,) = ends_of(policy, [1.0, 9.0], [Fraction(1, 4)] * 2)
    assert ends.most == 15.0 and ends.exact  # the output's bound


def test_an_error_that_rounding_takes_away_reaches_the_threshold_it_rounds_to():
    """0.5 + 2^-26 is read as 0.5, by an agent that observes float32; a little more is not."""
    just = float(np.nextafter(np.float32(0.5), np.float32(1)))
    half = Fraction(just) / 2 - Fraction(1, 4)
    assert ends_of(stump(2.0, 0.5), [0.5, 3.0], [half, Fraction(0)])[0].change == 0
    assert ends_of(stump(2.0, 0.5), [0.5, 3.0], [half + Fraction(1, 2**50), Fraction(0)])[0].change > 4


def test_what_may_be_infinite_has_no_bound():
    policy, free = stump(2.0, 0.5), (ir.OutputSpec("push", "none", None, None),)
    loud = replace(policy, outputs=free, tree=replace(policy.tree, gives="float32"))
    (ends,) = ends_of(loud, [0.25, 3.0], [Fraction(0), Fraction(10) ** 39])
    assert ends.change == 0  # the other leaf is out of reach
    (ends,) = ends_of(loud, [0.25, 3.0], [Fraction(1), Fraction(10) ** 39])
    assert ends.change == ends.most == np.inf
