"""Boxes that several boxes of a list hold together: whoever is in one is in the list."""

import numpy as np
import pytest

from codegen.lowering.glances.coring import find_cores
from codegen.lowering.glances.spanning import is_held, span_states
from codegen.lowering.searching import Boxes


def tiled(rng, size, gap):
    """A box from 0 to 1 as 40 boxes that meet, each cut in two somewhere; `gap`: floats that are left between two."""
    low, high = np.zeros((1, size)), np.ones((1, size))
    for _ in range(39):
        at, axis = rng.integers(len(low)), rng.integers(size)
        cut = rng.uniform(low[at, axis], high[at, axis])
        low, high = np.concatenate([low, low[at : at + 1]]), np.concatenate([high, high[at : at + 1]])
        high[at, axis] = low[-1, axis] = cut
        for _ in range(gap):
            low[-1, axis] = np.nextafter(low[-1, axis], 2.0)
    return Boxes(low, high)


@pytest.mark.parametrize("size", [1, 2, 4])
def test_boxes_that_meet_hold_the_whole_and_none_that_leave_a_float_out(size):
    rng, whole = np.random.default_rng(size), Boxes(np.zeros((1, size)), np.ones((1, size)))
    for gap in (0, 1):
        assert is_held(tiled(rng, size, gap), whole)  # one float after the end of a box there is no other one
    assert not is_held(tiled(rng, size, 2), whole)
    boxes = tiled(rng, size, 0)
    for left_out in range(0, 40, 7):
        assert not is_held(boxes.take(np.arange(40) != left_out), whole)
    boxes.high[boxes.high == 1.0] = np.nextafter(1.0, 0.0)
    assert not is_held(boxes, whole)


def test_a_span_lies_within_the_list_and_is_as_wide_as_states_that_no_box_holds_alone():
    rng = np.random.default_rng(0)
    boxes, states = tiled(rng, 3, 1), rng.uniform(0.2, 0.8, (60, 3))
    span = span_states(boxes, states)
    assert span is not None and span.holds(states).all()
    assert not any(((states >= low) & (states <= high)).all() for low, high in zip(*boxes, strict=True))
    drawn = span.low + rng.random((2_000, 3)) * (span.high - span.low)
    drawn = np.where(rng.random(drawn.shape) < 0.1, rng.choice([span.low[0], span.high[0]], 2_000), drawn)
    assert boxes.holds(drawn).all()
    cores = find_cores([boxes], [states])
    assert cores is not None and cores.axis is None and cores.columns == (0, 1, 2)


def test_a_span_leaves_out_a_hole():
    """A list without its middle has no box around it."""
    low = np.array([[0.0, 0.0], [0.6, 0.0], [0.0, 0.0], [0.0, 0.6]])
    high = np.array([[0.4, 1.0], [1.0, 1.0], [1.0, 0.4], [1.0, 1.0]])
    around = np.random.default_rng(0).uniform(0.0, 1.0, (50, 2))
    assert span_states(Boxes(low, high), around) is None
    beside = np.array([[0.05, 0.1], [0.35, 0.9]])
    span = span_states(Boxes(low, high), beside)
    assert span is not None and span.holds(beside).all() and not span.holds(np.array([[0.5, 0.5]])).any()
