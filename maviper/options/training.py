"""The options of `maviper train` and of `maviper.train`.

Does: says each option once: its name, type, default, heading and help; None: as the recipe says.
Assumes: `maviper.experts.training.train` reads them.
Does not: check values beyond their types.
"""

from collections.abc import Mapping, Sequence
from typing import Annotated, TypedDict

from maviper.options.table import Option

WHAT, HOW = "What is trained", "How it runs"


class TrainOptions(TypedDict, total=False):
    """What a training is asked for."""

    algorithm: Annotated[str, Option("", WHAT, "mappo, maddpg or vdn (default: the recipe's).", "NAME")]
    recipe: Annotated[
        str,
        Option("default", WHAT, "default, clone (of a script), or paper: MADDPG as released, in parallel games."),
    ]
    steps: Annotated[int | None, Option(None, WHAT, "Joint environment steps (default: the recipe's).")]
    settings: Annotated[
        Mapping[str, float], Option({}, WHAT, "Another setting of the algorithm.", "NAME=VALUE", called="set")
    ]
    against: Annotated[Sequence[str], Option((), WHAT, "Also meet this expert (mappo); repeatable.", "EXPERT")]
    seed: Annotated[int, Option(0, WHAT, "The random seed.")]
    seeds: Annotated[int, Option(1, WHAT, "Train this many seeds; keep the best.")]
    device: Annotated[str, Option("cpu", HOW, "A torch device, such as cpu or cuda.")]
    jobs: Annotated[int, Option(1, HOW, "Seeds to train in parallel.")]
    resume: Annotated[bool, Option(False, HOW, "Continue the run in the folder.")]
