"""Tilts of turned sets: whoever passes is in the set, and nearly all that are in it pass."""

import numpy as np
import pytest

from codegen.lowering.glances.tilting import LANES, tilt_alone, tilt_sets
from codegen.lowering.searching import Boxes
from codegen.lowering.turning import turn_sets
from tests.support.frames import is_in_frame


def drawn(rng, size, scale, far):
    """A set: its box, which holds all of it, and a frame whose rest is about `scale` of it, `far` from 0."""
    turned, _ = np.linalg.qr(rng.normal(size=(size, size)))
    matrix = rng.normal(size=(size, size)) + 3.0 * np.eye(size)  # seldom flat
    centre, rest = far * rng.normal(size=size), scale * rng.random(size)
    reach = 1.01 * (np.abs(matrix).sum(axis=1) + np.abs(turned) @ rest)
    made = turn_sets(
        Boxes((centre - reach)[None], (centre + reach)[None]), centre[None], matrix[None], rest[None], turned[None], "."
    )
    return made, centre, matrix, rest, turned


def numbers_of(tilt):
    """The constants [lanes] and factors [variables, lanes] of a tilt, as a compiler reads them."""
    first, *along = (
        np.array([float.fromhex(each.removesuffix("F")) for each in row]) for row in (tilt.first, *tilt.along)
    )
    assert all((row == row.astype(np.float32)).all() for row in (first, *along))
    return first.astype(np.float32), np.array(along, dtype=np.float32)


def pass_of(tilt, states):
    """Which states pass, sum by sum as code has it."""
    first, along = numbers_of(tilt)
    sums = np.tile(first, (len(states), 1))
    for at, row in enumerate(along):
        sums = sums + row * states[:, at, None].astype(np.float32)
    return (sums * sums <= np.float32(1.0)).all(axis=1)


def at_the_border(rng, tilt, size, count):
    """States whose sums are within 1, but for one that is nearly 1, give or take what float32 tells apart."""
    first, along = (each.astype(np.float64) for each in numbers_of(tilt))
    sums = rng.uniform(-1, 1, (count, size))
    near = 1.0 + rng.choice([-1e-6, -1e-7, 0.0, 1e-7], count)
    sums[np.arange(count), rng.integers(size, size=count)] = rng.choice([-1.0, 1.0], count) * near
    return np.linalg.solve(along[:, :size].T, (sums - first[:size]).T).T


@pytest.mark.parametrize("size", [2, 3, 6])
@pytest.mark.parametrize("scale", [0.0, 1e-9, 0.2])
@pytest.mark.parametrize("count", [2, pytest.param(20, marks=pytest.mark.slow)])
def test_who_passes_is_vouched_for(size, scale, count):
    """At the border too; of what is within 1 in z, and of what rest makes up for, most states pass."""
    rng = np.random.default_rng(size)
    whole = passed = borders = 0
    for _ in range(count):
        made, centre, matrix, rest, turned = drawn(rng, size, scale, rng.choice([0.1, 10.0]))
        (tilt,) = tilt_sets(made)
        assert len(tilt.first) % LANES == 0
        if np.linalg.cond(matrix) > 100.0:  # roundings may hide too much
            continue
        z, r = rng.uniform(-1, 1, (200, size)), rng.uniform(-1, 1, (200, size))
        states = centre + z @ matrix.T + (r * rest) @ turned.T
        border = at_the_border(rng, tilt, size, 400)
        passing = pass_of(tilt, border)
        assert made.holds(border[passing]).all()
        assert made.holds(states[pass_of(tilt, states)]).all()
        if size == 2:
            assert all(is_in_frame(point, centre, matrix, rest, turned) for point in border[passing][:60])
        whole, passed, borders = whole + 200, passed + int(pass_of(tilt, states).sum()), borders + int(passing.sum())
    assert passed > (0.99 if scale < 0.1 else 0.5) * whole
    assert borders > 100 * count  # of 400


@pytest.mark.parametrize("middle", [0.0, 0.5, 1.0, 0.7])
@pytest.mark.parametrize("frame", ["of its own", "set apart"])
def test_a_box_that_is_narrower_than_float32_tells_apart_lets_nobody_pass(middle, frame):
    """A box that cuts a frame, and one of a variable that its frame sets apart: nobody passes beyond it, and where it
    is wide enough for float32 some pass within.
    """
    rng, centre, passed = np.random.default_rng(5), np.array([0.5, middle]), list[int]()
    for most in (1e-15, 1e-8, 1e-7, 1e-6, 1e-5, 1e-3):
        alone, sides = frame == "set apart", np.array([1.0, 1.0 if frame == "set apart" else most])
        matrix, rest = np.diag([0.25, 0.0 if alone else 0.25]), np.array([0.01, most if alone else 0.01])
        boxes = Boxes((centre - sides)[None], (centre + sides)[None])
        made = turn_sets(boxes, centre[None], matrix[None], rest[None], np.eye(2)[None], "here")
        (tilt,) = tilt_sets(made)
        scale = rng.choice([1e-15, 1e-8, 1e-7, 1e-6, 1e-5, most], (2_000, 2))
        states = centre + scale * rng.uniform(-1.5, 1.5, scale.shape)
        passing = pass_of(tilt, states)
        assert made.holds(states[passing]).all()
        passed.append(int(passing.sum()))
    assert passed[0] == 0 and passed[-1] > 1_000


def test_sides_grow_together():
    """Two columns that need one rest share it: neither side is beyond 1 alone, and what needs none grows to 2."""
    matrix = np.array([[1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    rest, reach = np.array([0.2, 0.5, 9.0]), np.full((1, 3), 50.0)
    made = turn_sets(Boxes(-reach, reach), np.zeros((1, 3)), matrix[None], rest[None], np.eye(3)[None], "here")
    (tilt,) = tilt_sets(made)
    corners = np.array([[1.09, 1.09, 0.0], [-1.09, 1.09, 1.9], [1.11, 0.0, 0.0], [0.0, 1.11, 0.0], [0.0, 0.0, 2.01]])
    assert pass_of(tilt, corners @ matrix.T).tolist() == [True, True, False, False, False]
    assert made.holds(corners[:2] @ matrix.T).all()


@pytest.mark.parametrize("state", [np.nan, np.inf, -np.inf, 1e300])
def test_what_is_no_number_never_passes(state):
    made, centre, *_ = drawn(np.random.default_rng(1), 3, 0.1, 1.0)
    (tilt,) = tilt_sets(made)
    assert pass_of(tilt, centre[None]).all()
    for at in range(3):
        with np.errstate(all="ignore"):
            assert not pass_of(tilt, np.where(np.arange(3) == at, state, centre)[None]).any()


def test_nobody_passes_where_roundings_hide_too_much():
    """A set that is small beside its distance from 0; a start that is a point along a variable; skew rest."""
    rng = np.random.default_rng(2)
    far, *_ = drawn(rng, 3, 0.1, 1e6)
    flat = turn_sets(Boxes(np.array([[0.1, 0.3]]), np.array([[0.7, 0.3]])), np.array([[0.4, 0.3]]),
                     np.array([[[0.31, 0.0], [0.0, 0.0]]]), np.zeros((1, 2)), np.eye(2)[None], "here")  # fmt: skip
    near, *_ = drawn(rng, 3, 0.1, 1.0)
    skew = near._replace(turned=near.turned + 0.01)
    for made in (far, flat, skew):
        (tilt,) = tilt_sets(made)
        assert not pass_of(tilt, made.centre).any()
    (tilt,) = tilt_sets(near)
    assert pass_of(tilt, near.centre).all()
    first, *tilts = tilt_alone([near] * 9 + [far])
    assert len(tilts) == 10 and tilt_alone([near] * 8 + [far]) == ()
    assert not pass_of(first, near.centre).any()  # of no step
