"""A reproduction by name: plan, make what is missing, write table and report.

Does: joins plan, cells, processes and console; goes on where an earlier call or another process stands.
Assumes: options as a user gives them.
Does not: know what a cell is made of, or judge claims.
"""

import re
import time
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from codegen.errors import ExitCode, InputError, UnknownNameError
from codegen.rows import Shown
from codegen.wording import format_count
from maviper.console import Console, LiveLine, duration
from maviper.files import jobs as processes
from maviper.files import runs
from maviper.files.jobs import ensure_counts
from maviper.options import ReproduceOptions, complete_options
from maviper.reproduction.cells import plan as plans
from maviper.reproduction.cells import table
from maviper.reproduction.cells.cell import DONE, KINDS, Made, Task, estimate, is_guessed
from maviper.reproduction.cells.making import make_cell
from maviper.reproduction.cells.plan import Asked, Plan
from maviper.reproduction.cells.table import Store

LOCAL, DASK = "local", "dask"
BACKENDS = (LOCAL, DASK)
POLL = 1.0  # seconds between looks at cells that another process is making
MAX_SHARDS = 10_000
MAX_SHOWN = 20  # failed cells, at the end
_SHARD = re.compile(r"(?P<number>\d{1,5})/(?P<of>\d{1,5})")


@dataclass(frozen=True)
class Request:
    """The options of a reproduction; None: the tier's."""

    quick: bool
    full: bool
    experts: tuple[str, ...]
    games: tuple[str, ...] | None
    depths: tuple[int, ...] | None
    algorithms: tuple[str, ...] | None
    presets: tuple[str, ...]
    seeds: int | None
    plan: bool  # say it, and make nothing
    report_only: bool
    shard: str | None  # "2/8"
    jobs: int
    backend: str
    scheduler: str | None  # Dask's; None: as DASK_SCHEDULER_ADDRESS says

    def ensure_usable(self) -> "Request":
        """The same; InputError or UnknownNameError for what cannot be used."""
        if self.quick and self.full:
            raise InputError("--quick and --full exclude each other", "--quick, --full", "give one of them")
        ensure_counts(1 if self.seeds is None else self.seeds, self.jobs)
        if self.backend not in BACKENDS:
            raise UnknownNameError("backend", self.backend, BACKENDS, "--backend")
        if self.backend == DASK and self.jobs != 1:
            raise InputError("with Dask the workers say how many jobs there are", "--jobs", "leave --jobs out")
        for depth in self.depths or ():
            if not 1 <= depth <= 64:
                raise InputError(f"a depth must be from 1 to 64, not {depth}", "--depths")
        _ = self.asked.ensure_known(), self.part
        return self

    @property
    def asked(self) -> Asked:
        """The choices that decide which cells there are."""
        tier = plans.QUICK if self.quick else plans.FULL if self.full else plans.USUAL
        return Asked(tier, self.experts, self.games, self.depths, self.algorithms, self.presets, self.seeds)

    @property
    def part(self) -> tuple[int, int]:
        """The number of the shard, from 1, and how many there are."""
        if self.shard is None:
            return 1, 1
        match = _SHARD.fullmatch(self.shard)
        number, of = (int(match["number"]), int(match["of"])) if match else (0, 0)
        if not 1 <= number <= of <= MAX_SHARDS:
            raise InputError(f"'{self.shard[:20]}' is no shard", "--shard", "write --shard 2/8, from 1/8 to 8/8")
        return number, of


def request(options: Mapping[str, Any]) -> Request:
    """The options of the verb as a request. TypeError for an option that there is not, InputError for a value that it
    cannot have.
    """
    return Request(**complete_options(ReproduceOptions, options)).ensure_usable()


@dataclass(repr=False)
class Reproduced(Shown):
    """What a call did: its plan, what was made, what failed, and the lines of the report."""

    plan: Plan
    made: int = 0  # by this call
    failed: dict[str, str] = field(default_factory=dict[str, str])  # cell, in words -> message
    lines: list[str] = field(default_factory=list[str])

    @property
    def rows(self) -> list[dict[str, Any]]:
        """A row for each cell that failed."""
        return [{"cell": cell, "failed": message} for cell, message in self.failed.items()]

    @property
    def told(self) -> list[str]:
        """What was made, and what failed, in one line."""
        return [f"Reproduced: {self.made} made, {len(self.failed)} failed", *self.lines[:2]]

    @property
    def code(self) -> ExitCode:
        """As an exit code."""
        return ExitCode.VIOLATED if self.failed else ExitCode.DONE


def reproduce_paper(folder: str | Path, options: Request, console: Console | None = None) -> Reproduced:
    """Makes the cells that are missing, then writes the table and the report. `console`: None says nothing."""
    console = console or Console(quiet=True)
    register = _register()
    plan = plans.plan_cells(options.asked, register)
    for what, why in plan.left_out:
        console.line("left out", f"{what}: {why}")
    mine = plans.shard(plan, *options.part)
    store, done = Store(Path(folder)), Reproduced(mine)
    if options.plan:
        done.lines = describe_plan(mine, store)
        return done
    _ensure_own(store)
    if not options.report_only:
        with store:
            _make(store, options, done, console)
    _write_report(store, plan, register, done, console)
    return done


def _ensure_own(store: Store) -> None:
    """InputError, before any cell is made, for a folder that cannot be written, and where table, report or figures
    would be written over what no reproduction wrote.
    """
    runs.room(store.folder)
    report = _piece("report")
    names = () if report is None else (*report.FILES, report.FIGURES)
    there = [name for name in (table.TABLE_FILE, *names) if (store.folder / name).exists()]
    if there and not store.cells.is_dir():
        what = f"the folder holds another {there[0]}, which no reproduction wrote there"
        raise InputError(what, str(store.folder / there[0]), "choose another folder with -o")


def _register() -> str:
    """The hash of the claims, which were written before any cell was made."""
    register = _piece("register")
    return "" if register is None else str(register.read().sha256)


def _piece(name: str) -> Any:
    """A module of this package, or None in a version that has none of that name."""
    full = f"{__package__}.{name}"
    return import_module(full) if find_spec(full) else None


# --- making


def _make(store: Store, options: Request, done: Reproduced, console: Console) -> None:
    """All cells, those that need others after these. What another process makes is waited for."""
    tasks = done.plan.tasks
    missing = {task.id: estimate(task) for task in tasks if not store.is_done(task.id)}
    for task in tasks:
        if task.id not in missing:
            store.drop_claims(task.id)
    finished = len(tasks) - len(missing)
    if finished:
        console.line("found", f"{finished} of {format_count(len(tasks), 'cell')} finished")
    with console.live("cells", len(tasks), finished) as live:
        shown = _Shown(live, console, finished, missing)
        for stage in (
            [task for task in tasks if not task.of],
            [task for task in tasks if task.of],
        ):
            waiting = False
            while left := [task for task in stage if not store.is_done(task.id) and task.cell.said not in done.failed]:
                ready = [task for task in left if all(store.is_done(id_) for id_ in task.of.values())]
                if not ready:
                    needed = "a cell that it needs has failed"
                    done.failed |= {task.cell.said: needed for task in left}
                    break
                before = done.made + len(done.failed)
                for result in _results(store, ready, options):
                    store.write(result)
                    shown.one(result, done)
                if done.made + len(done.failed) == before:
                    if not waiting:
                        console.line(
                            "waiting", f"for {format_count(len(ready), 'cell')} that another process is making"
                        )
                    waiting = True
                    time.sleep(POLL)


def _results(store: Store, tasks: Sequence[Task], options: Request) -> Iterator[Made]:
    """The cells that this process could claim, as they come; the most expensive first, so that none is late."""

    def claim_tasks() -> Iterable[tuple[Task, dict[str, bytes]]]:
        for task in sorted(tasks, key=lambda task: -estimate(task)):
            if store.claim(task.id):
                yield task, {name: store.profile(id_) for name, id_ in task.of.items()}

    if options.backend == DASK:
        return processes.on_dask(make_cell, claim_tasks(), options.scheduler)
    return processes.as_they_come(make_cell, claim_tasks(), options.jobs)


@dataclass
class _Shown:
    """The progress that a person sees."""

    live: LiveLine
    console: Console
    finished: int
    missing: dict[str, float]  # hash of a cell -> its estimated cost
    worked: float = 0.0  # the estimated cost of what was made

    def one(self, result: Made, done: Reproduced) -> None:
        """One more cell."""
        document = result.document
        self.finished += 1
        if document.outcome == DONE:
            done.made += 1
        else:
            done.failed[document.cell.said] = document.message
            self.console.line("failed", f"{document.cell.said}: {document.message}")
        self.worked += self.missing.pop(result.id, 0.0)
        left = sum(self.missing.values()) / self.worked * self.live.elapsed if self.worked else None
        self.live.update(self.finished, document.cell.said, left)


# --- what is told


def _write_report(store: Store, plan: Plan, register: str, done: Reproduced, console: Console) -> None:
    finished = table.find_finished(store, plan.ids, register)
    if finished.other:
        console.line(
            "ignored", f"{format_count(finished.other, 'cell')} of another version of maviper or of its claims"
        )
    if finished.doubled:
        console.line("ignored", f"{finished.doubled} cells that stand for the same as others, by another expert, say")
    if not finished.cells:
        raise InputError("there are no finished cells", str(store.folder), "run it without --report-only")
    place = table.write(store, finished.cells)
    console.line("wrote", f"{place}  {format_count(len(finished.cells), 'cell')}, {done.made} of them made now")
    report = _piece("report")
    done.lines = [] if report is None else list(report.write_report(store.folder))
    shown = list(done.failed.items())[:MAX_SHOWN]
    done.lines += [f"failed  {what}: {why}" for what, why in shown]
    if done.failed:
        done.lines.append(f"{format_count(len(done.failed), 'cell')} failed; run the command again to try again")


def describe_plan(plan: Plan, store: Store) -> list[str]:
    """The plan for people: a line for cells that differ by depth and seed only, then the sum."""
    counts, seconds = Counter[str](), Counter[str]()
    finished, left = 0, 0.0
    for task in plan.tasks:
        cell, cost = task.cell, estimate(task)
        words = [cell.kind, cell.game, cell.expert, cell.preset, cell.algorithm, cell.splits]
        row = " ".join(word for word in words if word)
        counts[row] += 1
        seconds[row] += cost  # pyright: ignore[reportArgumentType]
        here = store.is_done(task.id)
        finished += here
        left += 0.0 if here else cost
    ordered = sorted(counts, key=lambda row: KINDS.index(row.partition(" ")[0]))
    lines = [f"{'cells':>6}  {'CPU s':>7}  what"]
    lines += [f"{counts[row]:>6}  {seconds[row]:>7.0f}  {row}" for row in ordered]
    derived = sum(is_guessed(task.cell) for task in plan.tasks)
    if derived:
        lines.append(f"{derived} cells were not measured; they count as those that are most like them, times a factor")
    total = f"{format_count(len(plan.tasks), 'cell')}, {finished} of them finished; {left:.0f} CPU s are left"
    return [*lines, f"{total} ({duration(left)} on one core, {duration(left / 2)} on two)"]
