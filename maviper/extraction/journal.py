"""How far an extraction has come: finished steps in a folder, and what a step gave, for those who watch it run.

Does: keeps the result of every finished step as a file, so that an extraction goes on after any interruption: a step
  that is there already is read instead of done again. Holds a step's scores, the best so far with intervals, and
  figures of growth; writes them as a line.
Assumes: a step depends on the settings and on earlier steps alone, so that what is read is what would come out.
Does not: know what the steps are, or show anything.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np

from codegen import ir
from codegen.errors import InputError
from codegen.ir import GrownTree
from codegen.lowering.deploy import SummedTree
from maviper.episodes.measures import Estimate
from maviper.extraction.dataset import Met
from maviper.files import runs

EXTRACTING, SELECTING, REFINING, MEASURING = "extracting", "selecting", "refining", "measuring"


@dataclass(frozen=True)
class Part:
    """The place of this extraction among several, one after the other: those of single agents or teams."""

    place: int = 0
    count: int = 1
    name: str = ""  # of the agent or team


WHOLE = Part()


@dataclass(frozen=True)
class Progress:
    """The result of one step. Scores: the mean of the ratios to the expert while extracting, and the primary measure,
    higher being better, while refining.
    """

    stage: str
    done: int
    total: int
    score: float  # of this step's candidate
    best: float
    measured: Mapping[str, Estimate]  # team or agent -> primary measure of the best, against expert opponents
    fidelity: float | None  # share of the step's decisions that were the expert's
    leaves: int  # of the best, all agents
    # figures of the step's growth, where teams grow jointly
    growth: Mapping[str, float] = field(default_factory=dict[str, float])
    part: Part = WHOLE

    @property
    def line(self) -> dict[str, float | int | str | None]:
        """The step as one line of a metrics file."""
        entry: dict[str, float | int | str | None] = {"stage": self.stage, "step": self.done, "score": self.score}
        entry |= {"best": self.best}
        for name, estimate in self.measured.items():
            low, high = estimate.interval
            entry |= {f"best {name}": estimate.value, f"best {name} low": low, f"best {name} high": high}
        return entry | {"fidelity": self.fidelity, "leaves": self.leaves, **self.growth}


@dataclass(frozen=True)
class Underway:
    """The progress within a step that takes long: `done` of `total` steps, with the share of this one. Other stages
    than EXTRACTING are counted in episodes, from when they are told.
    """

    done: float
    total: int
    doing: str
    stage: str = EXTRACTING
    part: Part = WHOLE


OnProgress = Callable[[Progress], None]
OnUnderway = Callable[[Underway], None]


def count_leaves(trees: Sequence[GrownTree]) -> int:
    """Leaves of some trees together."""
    return sum(int((tree.feature == ir.NO_FEATURE).sum()) for tree in trees)


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
