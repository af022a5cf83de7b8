"""What we use of Gymnasium's spaces. What is in a space is read as an array, whatever it was."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

class Space:
    contains: Callable[[Any], bool]
    @property
    def shape(self) -> tuple[int, ...] | None: ...
    def sample(self) -> Any: ...
    def seed(self, seed: int | None = None) -> object: ...

class Box(Space):
    low: npt.NDArray[Any]
    high: npt.NDArray[Any]
    dtype: np.dtype[Any]
    def __init__(
        self,
        low: npt.ArrayLike,
        high: npt.ArrayLike,
        shape: Sequence[int] | None = None,
        dtype: npt.DTypeLike = ...,
    ) -> None: ...
    @property
    def shape(self) -> tuple[int, ...]: ...

class Discrete(Space):
    n: np.integer[Any]
    start: np.integer[Any]
    def __init__(self, n: int, seed: int | None = None, start: int = 0) -> None: ...

class MultiDiscrete(Space):
    nvec: npt.NDArray[np.integer[Any]]
    start: npt.NDArray[np.integer[Any]]

class MultiBinary(Space): ...

class Dict(Space):
    spaces: dict[str, Space]
    def __init__(self, spaces: Mapping[str, Space]) -> None: ...

class Tuple(Space):
    spaces: tuple[Space, ...]
    def __init__(self, spaces: Sequence[Space]) -> None: ...

def flatdim(space: Space) -> int: ...
def flatten(space: Space, x: Any) -> Any: ...
def flatten_space(space: Space) -> Space: ...
