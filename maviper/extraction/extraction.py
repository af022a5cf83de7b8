"""One extraction as a value: what from, how, what is done already, and who watches it run.

Does: holds together what every algorithm needs.
Assumes: settings that were checked.
Does not: run anything.
"""

from dataclasses import dataclass

from maviper.experts.expert import Expert
from maviper.extraction.examples import NO_EXAMPLES, Examples
from maviper.extraction.journal import NOTHING_KEPT, Journal
from maviper.extraction.selection.progress import WHOLE, OnProgress, OnUnderway, Part
from maviper.extraction.settings import Settings
from maviper.worlds import World


@dataclass(frozen=True)
class Extraction:
    """The inputs of an extraction: from an expert of a world, as the settings say."""

    world: World
    expert: Expert
    settings: Settings
    journal: Journal = NOTHING_KEPT  # keeps the steps that are done
    examples: Examples = NO_EXAMPLES  # states whose labels every iteration learns from as well


def unseen(progress: object) -> None:
    """Shows a step to nobody."""
    del progress


@dataclass(frozen=True)
class Running:
    """The circumstances of a run, which never change what comes out."""

    on_progress: OnProgress = unseen
    jobs: int = 1  # agents or teams at the same time
    on_underway: OnUnderway = unseen  # told within a step that takes long
    part: Part = WHOLE


QUIETLY = Running()
