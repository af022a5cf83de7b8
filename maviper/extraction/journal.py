"""What an extraction has done so far, in a folder, so that it can go on after any interruption.

Does: keeps the result of every finished step as a file; a step that is there already is read instead of done again.
Assumes: a step depends on the settings and on earlier steps alone, so that what is read is what would come out.
Does not: know what the steps are.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from codegen.errors import InputError
from codegen.ir import GrownTree
from codegen.lowering.deploy import SummedTree
from maviper.extraction.dataset import Met
from maviper.files import runs

MAX_BYTES = 2**31
EXPERT_STEP = "expert"  # the expert's own play, before there is a tree
Arrays = Mapping[str, np.ndarray]


@dataclass(frozen=True)
class Journal:
    """Finished steps by name. Without a folder nothing is kept."""

    folder: Path | None = None

    def arrays(self, name: str, compute: Callable[..., Arrays], *arguments: Any) -> Arrays:
        """The result of a step: read, or computed from `arguments` and written."""
        if self.folder is None:
            return compute(*arguments)
        from safetensors import SafetensorError
        from safetensors.numpy import load, save

        place = self.folder / f"{name}.safetensors"
        if place.exists():
            try:
                return load(runs.read(place, MAX_BYTES))
            except SafetensorError:
                advice = "remove it; what follows it is done again"
                raise InputError("a step of the run is damaged", str(place), advice) from None
        computed = compute(*arguments)
        runs.write(place, save({key: np.ascontiguousarray(array) for key, array in computed.items()}))
        return computed

    def trees(self, name: str, compute: Callable[..., Sequence[GrownTree]], *arguments: Any) -> list[GrownTree]:
        """Reads or computes a step whose result is some trees; see `arrays`."""
        return unpack_trees(self.arrays(name, lambda: pack_trees(compute(*arguments))))

    def load_or_collect(self, name: str, compute: Callable[..., Met], *arguments: Any) -> Met:
        """Reads or computes rollouts; see `arrays`."""
        return Met.of(self.arrays(name, lambda: compute(*arguments).arrays()))

    def part(self, name: str) -> "Journal":
        """A journal of its own for a part of the work."""
        return Journal(None if self.folder is None else self.folder / name)


NOTHING_KEPT = Journal()


def pack_trees(trees: Sequence[GrownTree]) -> dict[str, np.ndarray]:
    """Trees as named arrays."""
    return {
        f"{place:03d}.{item.name}": getattr(tree, item.name)
        for place, tree in enumerate(trees)
        for item in fields(tree)
    }


def unpack_trees(arrays: Arrays) -> list[GrownTree]:
    """The trees of `pack_trees`."""
    places = sorted({key.partition(".")[0] for key in arrays})
    trees: list[GrownTree] = []
    for place in places:
        kind = SummedTree if f"{place}.tests" in arrays else GrownTree
        trees.append(kind(*(arrays[f"{place}.{item.name}"] for item in fields(kind))))
    return trees
