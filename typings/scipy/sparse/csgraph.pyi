"""Matchings, as far as we use them."""

import numpy as np
import numpy.typing as npt
from scipy.sparse import csr_array

def maximum_bipartite_matching(graph: csr_array) -> npt.NDArray[np.int32]: ...
