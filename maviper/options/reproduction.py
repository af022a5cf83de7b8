"""The options of `maviper reproduce` and of `maviper.reproduce`.

Does: says each option once: its name, type, default, heading and help; None: as quick, default or full says.
Assumes: each is a field of `maviper.reproduction.run.Request`.
Does not: check values beyond their types.
"""

from collections.abc import Sequence
from typing import Annotated, TypedDict

from maviper.options.table import Option

WHAT, HOW = "What is reproduced", "How it runs"


class ReproduceOptions(TypedDict, total=False):
    """What a reproduction is asked for."""

    quick: Annotated[bool, Option(False, WHAT, "Physical deception, depth 4, one seed: a minute.")]
    full: Annotated[bool, Option(False, WHAT, "More: the ladder, preset released, leaf budgets, further experts.")]
    experts: Annotated[
        Sequence[str],
        Option(
            ("mappo",),
            WHAT,
            "mappo or maddpg (shipped), an expert of your own, or NAME=EXPERT; several with commas.",
            "NAMES",
            commas=True,
        ),
    ]
    games: Annotated[Sequence[str] | None, Option(None, WHAT, "Some of the three games.", "NAMES", commas=True)]
    depths: Annotated[Sequence[int] | None, Option(None, WHAT, "Default: 2,4,6.", "NUMBERS", commas=True)]
    algorithms: Annotated[
        Sequence[str] | None,
        Option(
            None,
            WHAT,
            "As for `maviper extract`, and rungs of the ladder (default: the paper's).",
            "NAMES",
            commas=True,
        ),
    ]
    presets: Annotated[Sequence[str], Option(("paper",), WHAT, "paper, released, default.", "NAMES", commas=True)]
    seeds: Annotated[int | None, Option(None, WHAT, "Extraction seeds (default: 10, with --quick 1).")]
    plan: Annotated[bool, Option(False, HOW, "Print the cells and their CPU time; make nothing.")]
    report_only: Annotated[bool, Option(False, HOW, "Write table and report from what is finished.")]
    shard: Annotated[str | None, Option(None, HOW, "Make part I of N, beside other calls on the folder.", "I/N")]
    jobs: Annotated[int, Option(1, HOW, "Cells at the same time.")]
    backend: Annotated[str, Option("local", HOW, "local or dask (maviper[scale]).", "NAME")]
    scheduler: Annotated[
        str | None, Option(None, HOW, "Of the Dask scheduler (default: DASK_SCHEDULER_ADDRESS).", "ADDRESS")
    ]
