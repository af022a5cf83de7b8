"""Observations by the hundred thousand, in bounded memory: each agent's in a file, lists of them a block at a time.

Does: keeps what every target is asked in a scratch folder, and hands it out whole, in part, or as lists of numbers.
Assumes: it is used as a context manager, which removes the folder at the end.
Does not: make observations (probes.py).
"""

import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from codegen.ir import Floats

BLOCK = 512  # observations that are lists of Python's numbers at the same time
PART = 1 << 22  # numbers of an array in memory at the same time; twice as many would be fresh memory each time


def iterate_rows(rows: Any) -> Iterator[list[float]]:
    """The rows of an array one after the other, as `tolist` gives them, which needs eight times an array's memory."""
    for low in range(0, len(rows), BLOCK):
        yield from rows[low : low + BLOCK].tolist()


@dataclass(frozen=True)
class _File:
    """Rows of so many numbers of a type, one after the other."""

    place: Path
    numbers: str
    width: int

    def read(self, low: int = 0, count: int = -1) -> Floats:
        """So many rows from one on; -1: all that follow."""
        size = np.dtype(self.numbers).itemsize * self.width
        found = np.fromfile(self.place, self.numbers, count * self.width if count > 0 else -1, offset=low * size)
        return found.reshape(-1, self.width)


class Kept(Mapping[str, Floats]):
    """Arrays by name, each read from its file when it is asked for."""

    def __init__(self) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="maviper-")
        self._files: dict[str, _File] = {}

    def keep(self, name: str, rows: Floats) -> None:
        """Writes rows behind those that a name has already."""
        if name not in self._files:
            place = Path(self._folder.name) / str(len(self._files))
            self._files[name] = _File(place, rows.dtype.name, rows.shape[1])
        with self._files[name].place.open("ab") as file:
            np.ascontiguousarray(rows).tofile(file)

    def parts(self, name: str) -> Iterator[tuple[int, Floats]]:
        """An array in parts of bounded memory, each with the place of its first row."""
        file, low = self._files[name], 0
        count = max(1, PART // max(1, file.width))
        while len(rows := file.read(low, count)):
            yield low, rows
            low += len(rows)

    def together(self, names: Sequence[str], count: int) -> Iterator[list[Floats]]:
        """The first `count` rows of some arrays, a block of each at a time."""
        for low in range(0, count, 64 * BLOCK):
            yield [self._files[name].read(low, min(64 * BLOCK, count - low)) for name in names]

    def __getitem__(self, name: str) -> Floats:
        return self._files[name].read()

    def __iter__(self) -> Iterator[str]:
        return iter(self._files)

    def __len__(self) -> int:
        return len(self._files)

    def __enter__(self) -> "Kept":
        return self

    def __exit__(self, *_: object) -> None:
        self._folder.cleanup()
