"""Exact sets of states: emptiness, overlap, gaps."""

from fractions import Fraction as F

import pytest
from hypothesis import given
from hypothesis import strategies as st

from verify.systems.system import Affine, HalfSpace, apart, box_of, find_gap, is_empty, overlapping

NUMBER = st.fractions(-3, 3, max_denominator=4)


def box(**bounds):
    return {name: (F(low), F(high)) for name, (low, high) in bounds.items()}


@given(st.lists(st.tuples(NUMBER, NUMBER, NUMBER, st.booleans()), max_size=6), st.tuples(NUMBER, NUMBER))
def test_a_region_with_a_state_is_not_empty(rows, state):
    """Of random half spaces those that hold in a state have that state in common."""
    at = dict(zip("xy", state, strict=True))
    halves = [HalfSpace(Affine.of({"x": a, "y": b}, c), strict) for a, b, c, strict in rows]
    assert is_empty(tuple(half for half in halves if half.holds(at))) is False


@given(st.lists(st.tuples(st.integers(-2, 2), st.integers(-2, 2), st.integers(-2, 2)), min_size=1, max_size=5))
def test_an_empty_region_has_no_state_on_a_grid(rows):
    halves = tuple(HalfSpace(Affine.of({"x": F(a), "y": F(b)}, F(c))) for a, b, c in rows)
    grid = [{"x": F(i, 4), "y": F(j, 4)} for i in range(-12, 13) for j in range(-12, 13)]
    found = any(all(half.holds(state) for half in halves) for state in grid)
    assert not (is_empty(halves) and found)


def test_a_strict_border_empties_a_region():
    corner = (*box_of(box(x=(0, 1), y=(0, 1))), HalfSpace(Affine.of({"x": F(-1), "y": F(-1)}, F(2))))
    assert is_empty(corner) is False
    assert is_empty((*corner[:-1], HalfSpace(corner[-1].form, strict=True))) is True


def test_boxes_that_share_a_border_do_not_overlap():
    assert overlapping([box(x=(0, 1)), box(x=(1, 2)), box(x=(2, 3))]) is None
    assert overlapping([box(x=(0, 1)), box(x=(1, 2)), box(y=(2, 3))]) == (0, 2)
    assert not apart(box(x=(0, 2)), box(x=(1, 3)))


@pytest.mark.parametrize("place", [0, 1, 2])
def test_a_box_without_width_overlaps_what_it_lies_in(place):
    """On a border it would be a third piece there, and none of its states is only its own."""
    thin = box(x=(place, place))
    assert overlapping([box(x=(0, 2)), thin]) == (0, 1)
    assert overlapping([thin, box(x=(place, 2 + place))]) == (0, 1)
    assert overlapping([thin, box(x=(3, 4))]) is None
    assert overlapping([box(x=(1, 1), y=(0, 1)), box(x=(1, 1), y=(1, 2))]) is None


@given(st.lists(st.tuples(NUMBER, NUMBER, NUMBER, NUMBER), max_size=5), st.tuples(NUMBER, NUMBER))
def test_what_boxes_leave_out(rows, state):
    """A state inside what is left out lies in none of the boxes; where nothing is left out every state lies in one."""
    whole = box(x=(-3, 3), y=(-3, 3))
    boxes = [box(x=(min(a, b), max(a, b)), y=(min(c, d), max(c, d))) for a, b, c, d in rows]
    gap = find_gap(whole, boxes)
    if gap is None:
        at = dict(zip("xy", state, strict=True))
        assert any(all(low <= at[name] <= high for name, (low, high) in each.items()) for each in boxes)
    else:
        middle = {name: (low + high) / 2 for name, (low, high) in gap.items()}
        assert not any(all(low < middle[name] < high for name, (low, high) in each.items()) for each in boxes)
