"""Assignments, as far as we use them."""

import numpy as np
import numpy.typing as npt

def linear_sum_assignment(
    cost_matrix: npt.NDArray[np.float64],
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]: ...
