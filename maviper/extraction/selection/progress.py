"""What one step of an extraction gave, for those who watch it run.

Does: holds a step's scores, the best so far with intervals, and figures of growth; writes them as a line; says how far
  a step has come.
Assumes: nothing.
Does not: show or keep anything.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from codegen import ir
from codegen.ir import GrownTree
from maviper.episodes.measures import Estimate

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
