"""`maviper.reproduce`, the verb: the paper's experiments, with the options of the command as parameters.

Does: hands its parameters to `maviper.reproduction.run`.
Assumes: it is imported with the package, so that nothing heavy may come with it.
Does not: print.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from maviper.reproduction.run import Reproduced


def reproduce(
    output: str | Path,
    *,
    quick: bool = False,
    full: bool = False,
    experts: Sequence[str] = ("mappo",),
    games: Sequence[str] | None = None,
    depths: Sequence[int] | None = None,
    algorithms: Sequence[str] | None = None,
    presets: Sequence[str] = ("paper",),
    seeds: int | None = None,
    shard: str | None = None,
    jobs: int = 1,
    backend: str = "local",
    scheduler: str | None = None,
    plan: bool = False,
    report_only: bool = False,
) -> Reproduced:
    """The experiments of the MAVIPER paper, as cells in the folder `output`, with their table and report.

    `quick`, `full`: less or more than by default; `experts`: mappo, maddpg, experts as `extract` takes them, or
    NAME=EXPERT; `seeds`: extraction seeds; `shard`: "2/8" makes part 2 of 8; `jobs`: cells at the same time; `backend`:
    local or dask, with the address of its `scheduler`; `plan`: makes nothing, `lines` are the plan; `report_only`:
    makes nothing, writes what is finished. None: as quick, default or full says. `failed` of what is returned: cells
    that failed, with their messages. Finished cells are not made again. InputError for what cannot be used,
    MissingToolError without room on the disk, without Dask, or when its scheduler goes away.
    """
    from maviper.reproduction.run import ReproduceOptions, reproduced

    some = [None if names is None else tuple(names) for names in (games, algorithms)]
    what = (quick, full, tuple(experts), some[0], None if depths is None else tuple(depths), some[1], tuple(presets))
    how = (seeds, shard, jobs, backend, scheduler, plan, report_only)
    return reproduced(output, ReproduceOptions(*what, *how))
