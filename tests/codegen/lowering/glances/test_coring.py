"""Cores of lists of boxes: whoever is in one is in the list, and nearly all that is visited is in one."""

import numpy as np
import pytest

from codegen.lowering.glances import coring
from codegen.lowering.glances.coring import ENOUGH, find_cores, lay_row
from codegen.lowering.searching import Boxes, clip_boxes


def drawn(rng, size, far):
    """A list whose boxes lie along a bent line, `far` from 0, and states on that line."""
    middle = (
        np.linspace(0.0, 1.0, 30)[:, None] + np.sin(3.0 * np.arange(size)) * np.linspace(0.0, 1.0, 30)[:, None] ** 2
    )
    half = rng.uniform(0.08, 0.2, (30, size))
    at = rng.random((200, 1))
    states = at + np.sin(3.0 * np.arange(size)) * at**2
    return Boxes(far + middle - half, far + middle + half), far + states


def look(cores, states, at, numbers=None):
    """Which states are in a core of a list, in the operations of code; with `numbers`, in float32 or float64."""
    cells = np.full(len(states), at + 1)
    if cores.axis is not None:
        low, high, scale, begin = (float.fromhex(each.hex) for each in cores.rows[at + 1])
        above = np.where(states[:, cores.axis] > low, states[:, cores.axis], low)
        cells = (np.where(above < high, above, high) * scale + begin).astype(int)
        assert ((cells >= 0) & (cells < len(cores.boxes))).all()
        assert len(cores.rows) == 1 + (len(cores.boxes) - 1) // cores.size
    of = states[:, list(cores.columns)]
    if numbers is np.float32:
        middle, square = (
            np.array([[float.fromhex(each.removesuffix("F")) for each in row] for row in of_all])
            for of_all in zip(*cores.centred, strict=True)
        )
        assert (middle.astype(np.float32) == middle).all() and (square.astype(np.float32) == square).all()
        with np.errstate(over="ignore", invalid="ignore"):
            off = of.astype(np.float32) - middle.astype(np.float32)[cells]
            return np.asarray((off * off <= square.astype(np.float32)[cells]).all(axis=1))
    low, high = (
        np.array([[float.fromhex(each.hex) for each in ends] for ends in of_all])
        for of_all in zip(*cores.boxes, strict=True)
    )
    return np.asarray(((of >= low[cells]) & (of <= high[cells])).all(axis=1))


def test_there_is_a_box_that_holds_no_state_for_no_list():
    """Where there is no turn: its row leads to the last box, and without rows the first one is it."""
    rng = np.random.default_rng(0)
    boxes, states = drawn(rng, 2, 0.0)
    rows, alone = find_cores([boxes], [states]), find_cores([boxes.take(np.arange(1))], [])
    assert rows is not None and rows.axis is not None and alone is not None and alone.axis is None
    for cores in (rows, alone):
        assert not look(cores, states, -1).any()
        with np.errstate(over="ignore"):
            assert not look(cores, np.array([[np.nan, 0.5], [1e300, 0.5], [0.5, np.inf]]), -1).any()


def at_the_borders(rng, cores, boxes, at, count):
    """States of a list next to the ends of its cells and boxes, by a float or two."""
    states = boxes.low + rng.random((count, *boxes.low.shape)) * (boxes.high - boxes.low)
    states = states[np.arange(count), rng.integers(len(boxes.low), size=count)]
    ends = np.concatenate(boxes)
    for column in range(states.shape[1]):
        moved = rng.random(count) < 0.5
        values = ends[rng.integers(len(ends), size=count), column]
        if column == cores.axis:
            low, _, scale, _ = (float.fromhex(each.hex) for each in cores.rows[at + 1])
            values = np.where(rng.random(count) < 0.7, low + rng.integers(cores.size + 1, size=count) / scale, values)
        for _ in range(2):
            values = np.nextafter(values, rng.choice([-np.inf, np.inf], count))
        states[moved, column] = values[moved]
    return states


@pytest.mark.parametrize("size", [1, 2, 3])
@pytest.mark.parametrize("far", [0.0, 1e6, 1e15])
@pytest.mark.parametrize("seen", [True, False])
def test_who_is_in_a_core_is_in_the_list(size, far, seen):
    rng, told = np.random.default_rng(size), 0
    lists = [drawn(rng, size, far) for _ in range(2)]
    cores = find_cores([boxes for boxes, _ in lists], [states for _, states in lists] if seen else [])
    if cores is None:
        assert far > 1e6 or size > 1
        return
    for at, (boxes, states) in enumerate(lists):
        borders = at_the_borders(rng, cores, boxes, at, 500)
        inside = look(cores, borders, at)
        assert boxes.holds(borders[inside]).all()
        if cores.centred:
            near = look(cores, borders, at, np.float32)
            assert not (near & ~inside).any() and near.sum() > 0.6 * inside.sum()
        told += int(inside.sum())
        assert look(cores, states, at).mean() > ENOUGH - 0.1 or not seen
    assert told > 100  # of 1,000


def test_a_bent_line_takes_cells_and_a_single_box_none():
    """The bent line is told by boxes along one variable; two variables are left where one box holds what is visited."""
    rng = np.random.default_rng(0)
    boxes, states = drawn(rng, 2, 0.0)
    cores = find_cores([boxes], [states])
    assert (
        cores is not None and cores.axis is not None and len(cores.columns) == 1 and look(cores, states, 0).mean() > 0.9
    )
    wide = Boxes(np.concatenate([boxes.low, [[-5.0, -5.0]]]), np.concatenate([boxes.high, [[5.0, 5.0]]]))
    cores = find_cores([wide], [states])
    assert cores is not None and cores.axis is None and cores.columns == (0, 1) and look(cores, states, 0).all()


def test_of_many_states_and_boxes_every_so_many_states_stand_for_all(monkeypatch):
    """All but every fifth state are in no box, so that these alone have cores."""
    rng = np.random.default_rng(0)
    boxes, states = drawn(rng, 2, 0.0)
    few = find_cores([boxes], [states[::5]])
    assert few is not None and look(few, states, 0).mean() > 0.9
    states[np.arange(len(states)) % 5 > 0] += 9.0
    assert find_cores([boxes], [states]) is None
    monkeypatch.setattr(coring, "MAX_PAIRS", len(states) * len(boxes.low) // 4 - 1)
    assert find_cores([boxes], [states]) == few


def test_what_is_no_number_or_far_away_is_in_no_core():
    rng = np.random.default_rng(0)
    boxes, states = drawn(rng, 2, 0.0)
    cores = find_cores([boxes], [states])
    assert cores is not None
    for strange in (np.nan, np.inf, -np.inf, 1e300, -1e300, 7.0):
        for column in range(2):
            asked = states.copy()
            asked[:, column] = strange
            assert not look(cores, asked, 0).any()


def test_lists_have_no_cores_where_boxes_are_scattered_or_there_are_none():
    rng = np.random.default_rng(0)
    low = rng.uniform(-1, 1, (400, 3))
    assert find_cores([Boxes(low, low + 0.01)], []) is None
    assert find_cores([Boxes(np.zeros((0, 2)), np.zeros((0, 2)))], []) is None


def test_what_a_list_does_not_bound_is_not_divided():
    low, high = np.array([[-np.inf, 0.0], [-np.inf, 0.5]]), np.array([[np.inf, 0.6], [np.inf, 1.0]])
    cores = find_cores([clip_boxes(low, high)], [])
    assert cores is not None and cores.axis != 0
    assert look(cores, np.array([[1e300, 0.55], [-1e300, 0.1], [0.0, 2.0]]), 0).tolist()[::2] == [True, False]


@pytest.mark.parametrize("low, high", [(0.5, np.inf), (-np.inf, 0.5), (-1.6e308, 1e307), (-5e-324, 5e-324)])
def test_rows_of_lists_that_are_wider_than_floats_or_have_no_width_are_finite(low, high):
    """Cells along such a variable would not be: it is no axis, or its list has no cores."""
    rng = np.random.default_rng(0)
    wide = clip_boxes(np.array([[low, 0.0], [low, 0.5]]), np.array([[high, 0.6], [high, 1.0]]))
    bent, states = drawn(rng, 2, 0.0)
    within = np.stack([np.full(40, np.clip(0.5, low, high)), rng.random(40)], axis=1)
    for lists, visited in (([wide], [within]), ([wide, *[bent] * 10], [within, *[states[:40]] * 10])):
        cores = find_cores(lists, visited)
        assert cores is not None
        assert np.isfinite([[float.fromhex(each.hex) for each in row] for row in cores.rows]).all()
        for at, boxes in enumerate(lists[:2]):
            with np.errstate(over="ignore"):
                borders = at_the_borders(rng, cores, boxes, at, 60)
            assert boxes.holds(borders[look(cores, borders, at)]).all()


@pytest.mark.parametrize("size", [8, 64, 256])
@pytest.mark.parametrize("first", [0.0, 1.0, -1.0, 3.7, 1e8, -1e300])
def test_what_is_beyond_a_row_is_in_its_last_cell_where_boxes_are_a_few_floats_wide(size, first):
    """Next to floats cells are as thin as rounding: `most` was in the cell before the last, or in none."""
    laid = 0
    for floats in [*range(1, 4 * size), 2**20, 2**40]:
        low, high = np.array([first]), np.array([first + floats * np.spacing(abs(first))])
        least, most, scale = lay_row(low, high, size)
        assert scale == 0.0 == least == most or int((most - least) * scale) == size - 1
        laid += scale > 0.0
    assert laid > size or first == 0.0


def test_boxes_that_float32_would_empty_are_compared_in_float64():
    """A side that is a point, and one without an end, which is far from its middle."""
    rng = np.random.default_rng(0)
    boxes, states = drawn(rng, 2, 0.0)
    most = float(np.finfo(np.float64).max)
    for low, high, number in ((0.5, 0.5, 0.5), (-most, 0.7, 0.5), (0.3, most, 0.5)):
        more = [np.full((len(of), 1), end) for of, end in ((boxes.low, low), (boxes.high, high), (states, number))]
        wide = Boxes(np.hstack([boxes.low, more[0]]), np.hstack([boxes.high, more[1]]))
        cores = find_cores([wide], [np.hstack([states, more[2]])])
        assert cores is not None and cores.axis is not None and not cores.centred and not cores.single
    cores = find_cores([boxes], [states])
    assert cores is not None and cores.single
