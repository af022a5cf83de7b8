"""Integration of differential equations, as far as we use it."""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

class _Solution:
    y: npt.NDArray[np.float64]
    success: bool

def solve_ivp(
    fun: Callable[[float, npt.NDArray[np.float64]], npt.NDArray[np.float64]],
    t_span: tuple[float, float],
    y0: npt.NDArray[np.float64],
    method: str,
    *,
    t_eval: npt.NDArray[np.float64],
    rtol: float,
    atol: float,
) -> _Solution: ...
