"""Boxes in float32: whoever passes is in the box, to the last float64, and nearly all that are in a wide one pass."""

import numpy as np
import pytest

from codegen.lowering.glances.centring import MOSTLY, centre_boxes
from codegen.lowering.searching import Boxes


def pass_of(middle, square, states):
    """Which states pass, in the operations of code."""
    with np.errstate(over="ignore", invalid="ignore"):
        off = states.astype(np.float32) - middle
        return np.asarray((off * off <= square).all(axis=-1))


def near_ends(rng, low, high, count):
    """States at the ends of one side, by a share of it or by floats of either kind, and within it."""
    ends = rng.choice([low, high], count)
    with np.errstate(over="ignore", invalid="ignore"):
        states = ends + (high - low) * rng.choice([-1e-3, -1e-6, -1e-7, -1e-15, 0.0, 1e-15, 1e-7, 1e-6, 1e-3], count)
    for _ in range(3):
        states = np.nextafter(states, rng.choice([-np.inf, np.inf], count))
    return np.where(rng.random(count) < 0.2, low + rng.random(count) * (high - low), states)


@pytest.mark.parametrize("far", [0.0, 1e-30, 1.0, -1e3, 1e6, 1e18, -1e300])
@pytest.mark.parametrize("half", [0.0, 1e-300, 1e-40, 1e-13, 1e-3, 1.0, 1e6, 1e17])
def test_who_passes_is_in_the_box(far, half):
    rng, held = np.random.default_rng(0), 0
    for _ in range(20):
        middle = far * rng.uniform(0.5, 1.0)
        low, high = middle - half * rng.uniform(0.5, 1.0), middle + half * rng.uniform(0.5, 1.0)
        states = near_ends(rng, low, high, 400)
        states[:4] = low, high, 0.0, 5e-324
        passed = pass_of(*centre_boxes(Boxes(np.array([[low]]), np.array([[high]]))), states[:, None])
        assert ((states[passed] >= low) & (states[passed] <= high)).all()
        held += int(passed.sum())
    wide = abs(far) < MOSTLY * 2.0**60 and half > 1e-11 and half > 1e-3 * abs(far)
    assert (held > 2_000) if wide else (held == 0 or half > 1e-12)  # of 8,000


def test_no_state_passes_that_is_no_number_or_in_an_empty_box():
    boxes = Boxes(np.array([[-1.0, -1.0], [1.0, -1.0]]), np.array([[1.0, 1.0], [-1.0, 1.0]]))
    middle, square = centre_boxes(boxes)
    assert pass_of(middle[0], square[0], np.zeros((1, 2))).all()
    for strange in (np.nan, np.inf, -np.inf, 1e300, -1e300, 1.0):
        assert not pass_of(middle[0], square[0], np.array([[0.0, strange], [strange, 0.0]])).any()
    assert not pass_of(middle[1], square[1], np.zeros((1, 2))).any()


def test_a_side_without_an_end_is_one_to_a_far_number():
    most = float(np.finfo(np.float64).max)
    middle, square = centre_boxes(Boxes(np.array([[-most], [0.5]]), np.array([[most], [most]])))
    assert pass_of(middle[0], square[0], np.array([[0.0], [-1e17], [1e17], [1e19], [np.inf]])).tolist() == (
        [True] * 3 + [False] * 2
    )
    assert pass_of(middle[1], square[1], np.array([[-1e-3], [0.0], [1e17]])).tolist() == [False, False, True]
