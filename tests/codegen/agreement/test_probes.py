"""Draws of the probes are those of NumPy's own function; observations kept in files come back as they were."""

import numpy as np
import pytest

from codegen.agreement import probes
from codegen.agreement.probes import BLOCK, Kept, iterate_rows


@pytest.mark.parametrize("numbers", [np.float32, np.float64])
def test_uniform_draws_are_those_of_numpy(numbers):
    ends = np.sort(np.random.default_rng(1).normal(0, 10, (2, 7)).astype(numbers), axis=0)
    ends[:, 0], ends[:, 1] = 0.5, (-1e30, 1e30)
    drawn = probes._uniform(np.random.default_rng(0), *ends, (50, 7))
    assert drawn.tobytes() == np.random.default_rng(0).uniform(*ends, (50, 7)).tobytes()
    signed = probes._uniform(np.random.default_rng(0), np.zeros(2), -np.zeros(2), (3, 2))
    assert not signed.any()


@pytest.mark.parametrize("numbers", ["float32", "float64"])
@pytest.mark.parametrize("count", [0, 1, 3 * BLOCK + 1])
def test_rows_come_back_bit_by_bit(numbers, count):
    rng = np.random.default_rng(0)
    parts = [rng.normal(size=(each, 3)).astype(numbers) for each in (count, 0, 2)]
    parts[-1][0] = [np.nan, -0.0, np.inf]
    with Kept() as kept:
        for part in parts:
            kept.keep("a", part)
        kept.keep("b", parts[-1])
        whole = np.concatenate(parts)
        assert list(kept) == ["a", "b"] and kept["a"].tobytes() == whole.tobytes() and kept["a"].dtype == numbers
        assert kept["b"].tobytes() == parts[-1].tobytes()
        assert np.array(list(iterate_rows(kept["a"]))).tobytes() == whole.astype(float).tobytes()


def test_blocks_of_several_hold_the_same_rows_of_each():
    count = 64 * BLOCK + 5
    rows = np.arange(2 * (count + 9), dtype=np.float32).reshape(-1, 2)
    with Kept() as kept:
        kept.keep("a", rows)
        kept.keep("b", -rows)
        blocks = list(kept.together(["b", "a"], count))
    assert [len(a) for _, a in blocks] == [64 * BLOCK, 5]
    assert all((a == -b).all() for b, a in blocks)
    assert (np.concatenate([a for _, a in blocks]) == rows[:count]).all()
