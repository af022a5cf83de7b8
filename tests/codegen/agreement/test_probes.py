"""Draws of the probes are those of NumPy's own function, number for number."""

import numpy as np
import pytest

from codegen.agreement import probes


@pytest.mark.parametrize("numbers", [np.float32, np.float64])
def test_uniform_draws_are_those_of_numpy(numbers):
    ends = np.sort(np.random.default_rng(1).normal(0, 10, (2, 7)).astype(numbers), axis=0)
    ends[:, 0], ends[:, 1] = 0.5, (-1e30, 1e30)
    drawn = probes._uniform(np.random.default_rng(0), *ends, (50, 7))
    assert drawn.tobytes() == np.random.default_rng(0).uniform(*ends, (50, 7)).tobytes()
    signed = probes._uniform(np.random.default_rng(0), np.zeros(2), -np.zeros(2), (3, 2))
    assert not signed.any()
