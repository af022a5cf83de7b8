"""The machine under `maviper reproduce` and `maviper compare`: makes the cells of a plan that are missing.

Does: hands cells to processes of this machine or of a Dask cluster, keeps them as they come, waits for what another
  process is making, and shows how far all is.
Assumes: tasks whose `of` names only tasks that are there; a folder that all processes see.
Does not: know what a cell is made of (cells/making.py), which there are, or what they say.
"""

import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from codegen.errors import ExitCode, InputError, UnknownNameError
from codegen.wording import format_count
from maviper.console import Console
from maviper.files import jobs as processes
from maviper.files import runs
from maviper.files.jobs import ensure_counts
from maviper.reproduction.cells.cell import DONE, Made, Task, estimate
from maviper.reproduction.cells.making import make_cell
from maviper.reproduction.cells.table import Store

LOCAL, DASK = "local", "dask"
BACKENDS = (LOCAL, DASK)
POLL = 1.0  # seconds between looks at cells that another process is making
MAX_SHOWN = 20  # failed cells, at the end


class Spread(Protocol):
    """How cells are spread over processes, as the options of a verb say it."""

    @property
    def jobs(self) -> int:
        """Cells at the same time, on this machine."""
        ...

    @property
    def backend(self) -> str:
        """LOCAL or DASK."""
        ...

    @property
    def scheduler(self) -> str | None:
        """Dask's; None: as DASK_SCHEDULER_ADDRESS says."""
        ...


def ensure_spread(spread: Spread, seeds: int, depths: Sequence[int]) -> None:
    """InputError or UnknownNameError for counts, depths and backends that cannot be used."""
    ensure_counts(seeds, spread.jobs)
    if spread.backend not in BACKENDS:
        raise UnknownNameError("backend", spread.backend, BACKENDS, "--backend")
    if spread.backend == DASK and spread.jobs != 1:
        raise InputError("with Dask the workers say how many jobs there are", "--jobs", "leave --jobs out")
    for depth in depths:
        if not 1 <= depth <= 64:
            raise InputError(f"a depth must be from 1 to 64, not {depth}", "--depths")


@dataclass
class Making:
    """What a call made, and what failed."""

    made: int = 0
    failed: dict[str, str] = field(default_factory=dict[str, str])  # cell, in words -> message

    @property
    def lines(self) -> list[str]:
        """What failed, for people."""
        told = [f"failed  {what}: {why}" for what, why in list(self.failed.items())[:MAX_SHOWN]]
        again = [f"{format_count(len(self.failed), 'cell')} failed; run the command again to try again"]
        return told + again * bool(told)

    @property
    def code(self) -> ExitCode:
        """As an exit code."""
        return ExitCode.VIOLATED if self.failed else ExitCode.DONE


def ensure_own(store: Store, names: Sequence[str], who: str) -> None:
    """InputError, before any cell is made, for a folder that cannot be written, and where what is to be written would
    be written over what no `who` wrote.
    """
    runs.room(store.folder)
    there = [name for name in names if (store.folder / name).exists()]
    if there and not store.cells.is_dir():
        what = f"the folder holds another {there[0]}, which no {who} wrote there"
        raise InputError(what, str(store.folder / there[0]), "choose another folder with -o")


def make_cells(store: Store, tasks: Sequence[Task], spread: Spread, done: Making, console: Console) -> None:
    """All cells, those that need others after these. What another process makes is waited for."""
    missing = {task.id: estimate(task) for task in tasks if not store.is_done(task.id)}
    for task in tasks:
        if task.id not in missing:
            store.drop_claims(task.id)
    finished, worked = len(tasks) - len(missing), 0.0  # cells, and the estimated cost of what was made
    if finished:
        console.line("found", f"{finished} of {format_count(len(tasks), 'cell')} finished")
    with console.live("cells", len(tasks), finished) as live:
        for stage in ([task for task in tasks if not task.of], [task for task in tasks if task.of]):
            waiting = False
            while left := [task for task in stage if not store.is_done(task.id) and task.cell.said not in done.failed]:
                ready = [task for task in left if all(store.is_done(id_) for id_ in task.of.values())]
                if not ready:
                    needed = "a cell that it needs has failed"
                    done.failed |= {task.cell.said: needed for task in left}
                    break
                before = done.made + len(done.failed)
                for result in _results(store, ready, spread):
                    store.write(result)
                    said, message = result.document.cell.said, result.document.message
                    finished += 1
                    if result.document.outcome == DONE:
                        done.made += 1
                    else:
                        done.failed[said] = message
                        console.line("failed", f"{said}: {message}")
                    worked += missing.pop(result.id, 0.0)
                    live.update(finished, said, sum(missing.values()) / worked * live.elapsed if worked else None)
                if done.made + len(done.failed) == before:
                    if not waiting:
                        told = f"for {format_count(len(ready), 'cell')} that another process is making"
                        console.line("waiting", told)
                    waiting = True
                    time.sleep(POLL)


def _results(store: Store, tasks: Sequence[Task], spread: Spread) -> Iterator[Made]:
    """The cells that this process could claim, as they come; the most expensive first, so that none is late."""

    def claim_tasks() -> Iterable[tuple[Task, dict[str, bytes]]]:
        for task in sorted(tasks, key=lambda task: -estimate(task)):
            if store.claim(task.id):
                yield task, {name: store.profile(id_) for name, id_ in task.of.items()}

    if spread.backend == DASK:
        return processes.on_dask(make_cell, claim_tasks(), spread.scheduler)
    return processes.as_they_come(make_cell, claim_tasks(), spread.jobs)
