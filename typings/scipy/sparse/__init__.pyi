"""Sparse matrices, as far as we use them."""

import numpy as np
import numpy.typing as npt

class csr_array:
    def __init__(self, dense: npt.NDArray[np.bool_]) -> None: ...
