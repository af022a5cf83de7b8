"""Assignments and linear programs, as far as we use them."""

import numpy as np
import numpy.typing as npt

class OptimizeResult:
    status: int
    x: npt.NDArray[np.float64]

def linear_sum_assignment(
    cost_matrix: npt.NDArray[np.float64],
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]: ...
def linprog(
    c: npt.NDArray[np.float64],
    A_ub: npt.NDArray[np.float64],
    b_ub: npt.NDArray[np.float64],
    *,
    bounds: npt.NDArray[np.float64],
) -> OptimizeResult: ...
