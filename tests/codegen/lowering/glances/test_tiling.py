"""Tiles of lists of turned sets: whoever is in one that counts is in the list, as code asks it."""

import numpy as np
import pytest

from codegen.lowering.glances.tiling import tile_lists
from codegen.lowering.searching import Boxes
from codegen.lowering.turning import turn_sets


def drawn(rng, size, far):
    """A list of turned sets whose middles lie side by side on a line, `far` from 0, some cut by their boxes; and states
    on that line.
    """
    count, (turned, _) = 9, np.linalg.qr(rng.normal(size=(size, size)))
    centre = far + np.linspace(0.0, 1.0, count)[:, None] * np.ones(size)
    matrix = 0.3 * (np.eye(size) + 0.3 * rng.normal(size=(count, size, size)))
    rest = np.full((count, size), 1e-3)
    reach = np.abs(matrix).sum(axis=2) * rng.choice([1.01, 0.6], (count, 1)) + 2e-3
    sets = turn_sets(Boxes(centre - reach, centre + reach), centre, matrix, rest, np.tile(turned, (count, 1, 1)), ".")
    return sets, far + rng.random((100, 1)) * np.ones(size) + rng.normal(scale=0.03, size=(100, size))


def look(tiles, states, at):
    """Which states are in a tile of a list, in the operations of code."""
    cells = np.full(len(states), at)
    for column, row in enumerate(tiles.rows[at]):
        low, high, scale = (float.fromhex(each.hex) for each in row)
        above = np.where(states[:, column] > low, states[:, column], low)
        place = ((np.where(above < high, above, high) - low) * scale).astype(int)
        assert ((place >= 0) & (place < tiles.size)).all()
        cells = cells * tiles.size + place
    return (np.array(tiles.octets)[cells >> 3] >> (cells & 7)) & 1 == 1


@pytest.mark.parametrize("size", [1, 2, 3])
@pytest.mark.parametrize("far", [0.0, 1e3])
def test_who_is_in_a_tile_is_in_the_list(size, far):
    """Next to the borders of cells too; and nearly all that is visited is in one."""
    rng = np.random.default_rng(size)
    lists = [drawn(rng, size, far) for _ in range(2)]
    tiles = tile_lists([sets for sets, _ in lists], [states for _, states in lists])
    assert tiles is not None and len(tiles.octets) * 8 == 2 * tiles.size**size
    for at, (sets, states) in enumerate(lists):
        assert look(tiles, states, at).mean() > 0.8
        rows = np.array([[float.fromhex(each.hex) for each in row] for row in tiles.rows[at]]).T
        cells = rng.integers(tiles.size, size=(6_000, size))
        asked = rows[0] + (cells + rng.choice([0.0, 0.5, 1.0], cells.shape)) / rows[2]
        asked = np.where(
            rng.random(asked.shape) < 0.5, asked, np.nextafter(asked, rng.choice([-9e9, 9e9], asked.shape))
        )
        told = look(tiles, asked, at)
        assert sets.holds(asked[told]).all() and 100 < told.sum() < 5_900


def test_what_is_no_number_or_far_away_is_in_no_tile():
    sets, states = drawn(np.random.default_rng(0), 2, 0.0)
    tiles = tile_lists([sets], [states])
    for strange in (np.nan, np.inf, -np.inf, 1e300, -1e300, 7.0):
        for column in range(2):
            asked = states.copy()
            asked[:, column] = strange
            assert not look(tiles, asked, 0).any()


def test_lists_have_no_tiles_where_too_little_is_visited_or_rounding_hides_too_much_or_there_are_many_variables():
    rng = np.random.default_rng(0)
    sets, states = drawn(rng, 2, 0.0)
    assert tile_lists([sets], [states]) is not None
    assert tile_lists([sets], []) is None and tile_lists([sets], [states[:3]]) is None
    assert tile_lists([sets], [states + 9.0]) is None
    assert tile_lists([sets, sets], [states, np.full_like(states, 0.5)]) is None  # no width
    far, states = drawn(rng, 2, 1e8)
    assert tile_lists([far], [states]) is None
    wide, states = drawn(rng, 4, 0.0)
    assert tile_lists([wide], [states]) is None


@pytest.mark.parametrize("floats", [1, 10, 1_000])
def test_what_is_far_from_visited_states_a_few_floats_wide_is_in_no_tile(floats):
    """A wide set with states about at one place, as where all comes to rest; and no cell beyond the last is read."""
    rng = np.random.default_rng(0)
    sets, _ = drawn(rng, 1, 1.0)
    middle, lists = sets.centre[4], 12
    seen = middle + 1e-3 * rng.uniform(-1.0, 1.0, (200, 1))
    thin = middle + np.spacing(middle) * rng.integers(0, floats + 1, (200, 1))
    some = tile_lists([sets] * lists, [*[seen] * (lists - 1), thin])
    assert some is not None
    for tiles in filter(None, (some, tile_lists([sets] * lists, [thin] * lists))):
        for at in range(lists):
            assert not look(tiles, np.array([[1e300], [-1e300]]), at).any()
