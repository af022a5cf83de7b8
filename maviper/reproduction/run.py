"""A reproduction by name: plan, make what is missing, write table and report.

Does: joins plan, cells, console and report; what is missing is made by the grid, where an earlier call or another
  process stands.
Assumes: options as a user gives them.
Does not: know what a cell is made of, or judge claims.
"""

import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from codegen.errors import ExitCode, InputError
from codegen.rows import Shown
from codegen.wording import format_count
from maviper.console import Console, duration
from maviper.options import ReproduceOptions, complete_options
from maviper.reproduction import register, report
from maviper.reproduction.cells import plan as plans
from maviper.reproduction.cells import table
from maviper.reproduction.cells.cell import KINDS, estimate, is_guessed
from maviper.reproduction.cells.plan import Asked, Plan
from maviper.reproduction.cells.table import Store
from maviper.reproduction.grid import Making, ensure_own, ensure_spread, make_cells

MAX_SHARDS = 10_000
_SHARD = re.compile(r"(?P<number>\d{1,5})/(?P<of>\d{1,5})")


@dataclass(frozen=True, kw_only=True)
class Request(Asked):
    """The options of a reproduction."""

    plan: bool  # say it, and make nothing
    report_only: bool
    shard: str | None  # "2/8"
    jobs: int
    backend: str
    scheduler: str | None  # Dask's; None: as DASK_SCHEDULER_ADDRESS says

    def ensure_usable(self) -> "Request":
        """The same; InputError or UnknownNameError for what cannot be used."""
        depths = (*(self.depths or ()), *(self.exploit_depths or ()))
        ensure_spread(self, 1 if self.seeds is None else self.seeds, depths)
        _ = self.ensure_known(), self.part
        return self

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
    """Says what a call did: its plan, what was made, what failed, and the lines of the report.

    For example:

        maviper.reproduce("paper/", quick=True).failed
    """

    plan: Plan
    making: Making = field(default_factory=Making)
    lines: list[str] = field(default_factory=list[str])

    @property
    def made(self) -> int:
        """The number of cells that this call made."""
        return self.making.made

    @property
    def failed(self) -> dict[str, str]:
        """The cells that failed, in words, with their messages."""
        return self.making.failed

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
        """The exit code of the command."""
        return self.making.code


def reproduce_paper(folder: str | Path, options: Request, console: Console | None = None) -> Reproduced:
    """Makes the cells that are missing, then writes the table and the report. `console`: None says nothing."""
    console = console or Console(quiet=True)
    claims = register.read().sha256  # of the claims, which were written before any cell was made
    plan = plans.plan_cells(options, claims)
    for what, why in plan.left_out:
        console.line("left out", f"{what}: {why}")
    mine = plans.shard(plan, *options.part)
    store, done = Store(Path(folder)), Reproduced(mine)
    if options.plan:
        done.lines = describe_plan(mine, store)
        return done
    ensure_own(store, (table.TABLE_FILE, *report.FILES, report.FIGURES), "reproduction")
    if not options.report_only:
        with store:
            make_cells(store, mine.tasks, options, done.making, console)
    finished = table.find_finished(store, plan.ids, claims)
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
    done.lines = [*report.write_report(store.folder), *done.making.lines]
    return done


# --- what is told


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
