"""A comparison of algorithms, depths and seeds on a user's own expert: plan, make what is missing, write what came out.

Does: makes a cell of each expert, algorithm, depth and seed, and of what the expert does in the episodes of each seed;
  writes table, figures, LaTeX and the best trees.
Assumes: options as a user gives them; experts that play one world. An expert without a hash, or in a user's own world,
  is known again by how it acts in its first episodes.
Does not: know what a cell is made of, or compute a number of the table (compared.py).
"""

import hashlib
import tempfile
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from codegen.errors import InputError, UnknownNameError, escape_text
from codegen.wording import format_count
from maviper.console import Console
from maviper.episodes import measures
from maviper.episodes.play import rollout
from maviper.experts.expert import Expert
from maviper.extraction import refitting
from maviper.extraction.algorithms import check
from maviper.extraction.settings import KNOWN as ALGORITHMS
from maviper.files import runs
from maviper.options import CompareOptions, ExtractOptions, complete_options, table_of
from maviper.options.extraction import SETTINGS
from maviper.options.table import CALLED, split_setting
from maviper.reproduction import compared
from maviper.reproduction.cells import table
from maviper.reproduction.cells.cell import EXPERT, EXTRACTION, Budget, Cell, Named, Source, Task
from maviper.reproduction.cells.plan import Known, rejoin_names, tell_apart
from maviper.reproduction.cells.table import Store
from maviper.reproduction.compared import AlgorithmsCompared, Asked
from maviper.reproduction.grid import Making, ensure_own, ensure_spread, make_cells
from maviper.worlds import World
from maviper.worlds.outside import sources
from maviper.worlds.outside.sources import is_named_by_user

EPISODES, OUTSIDE = 200, 50  # held-out ones of each seed and line-up, in our games and in those of others
FIRST = 4  # episodes by which an expert, and its world, are known again


@dataclass(frozen=True)
class Request:
    """The options of a comparison."""

    world: str | Callable[..., Any] | None
    experts: tuple[Any, ...]  # further ones
    algorithms: tuple[str, ...]
    depths: tuple[int, ...]
    seeds: int
    max_episodes: int
    settings: tuple[tuple[str, Any], ...]  # of all extractions
    jobs: int
    backend: str
    scheduler: str | None


def request(options: Mapping[str, Any]) -> Request:
    """The options of the verb as a request. TypeError for an option that there is not, InputError for a value that it
    cannot have.
    """
    given = complete_options(CompareOptions, options)
    given["settings"] = tuple(map(_read_setting, given["settings"]))
    asked = Request(**given)
    asked = replace(asked, algorithms=_once(asked.algorithms), depths=_once(sorted(asked.depths)))
    ensure_spread(asked, asked.seeds, asked.depths)
    for name, given in (("algorithms", asked.algorithms), ("depths", asked.depths)):
        if not given:
            raise InputError(f"{name} is empty", f"--{name}", "leave it out for the usual ones")
    for algorithm in asked.algorithms:
        if algorithm not in ALGORITHMS:
            raise UnknownNameError("algorithm", algorithm, ALGORITHMS, "--algorithms")
    return asked


def _read_setting(text: str) -> tuple[str, Any]:
    """The name and the value of one of the settings that `maviper extract` has beside its options."""
    name, value = split_setting(text, SETTINGS)
    option = table_of(ExtractOptions)[name]
    try:
        return option.setting or name, option.base(value)
    except ValueError:
        what = f"{name} is {CALLED[option.base]}, not '{escape_text(value)[:40]}'"
        raise InputError(what, f"--set {name}", f"write --set {name}=VALUE") from None


def _once(given: Sequence[Any]) -> tuple[Any, ...]:
    return tuple(dict.fromkeys(given))


def compare_algorithms(
    expert: Any, output: str | Path | None, options: Request, console: Console | None = None
) -> AlgorithmsCompared:
    """Makes the cells that are missing, writes table, figures and the best trees, and returns them. `output`: the
    folder; None: nothing is kept. `console`: None says nothing.
    """
    console = console or Console(quiet=True)
    with ExitStack() as stack:
        folder = stack.enter_context(tempfile.TemporaryDirectory()) if output is None else output
        store, done = Store(Path(folder)), Making()
        ensure_own(store, (table.TABLE_FILE, *compared.FILES), "comparison")
        if output is not None:
            stack.enter_context(sources.logging_output(store.folder, console.line))
        further = options.experts  # whose options may have been cut off at commas
        further = rejoin_names(further) if all(isinstance(one, str) for one in further) else further
        experts, world = _find_experts([expert, *further], options)
        for one in experts:  # copies of users' environments end
            stack.callback(one.source.read()[1].close)
        tasks = list_tasks(experts, world, options)
        held = tasks[0].budget.held_out if tasks[0].budget else 0
        extractions = sum(task.cell.kind == EXTRACTION for task in tasks)
        each = f"{format_count(extractions, 'extraction')} of up to {options.max_episodes:,} episodes"
        console.line("plan", f"{each}; each is measured in {held} more, which the expert plays too")
        with store:
            make_cells(store, tasks, options, done, console)
        kept = table.find_finished(store, {task.id for task in tasks}, "").cells
        wanted = {task.id: kept[task.id] for task in tasks if task.id in kept}
        if not any(document.cell.kind == EXTRACTION for document in wanted.values()):
            raise InputError("no extraction was finished", str(store.folder), "; ".join(list(done.failed.values())[:1]))
        table.write(store, wanted)
        world = world.judge_by(dict(options.settings).get("measure", ""))
        asked = Asked(world, tuple(one.label for one in experts), options.algorithms, held, options.max_episodes)
        found = compared.read(store.folder, asked, done)
        runs.write_all(store.folder, found.files)
        if output is not None:
            console.line("wrote", f"{store.folder}: {', '.join(name for name in found.files)}")
    return found


# --- experts


def _find_experts(given: Sequence[Any], options: Request) -> tuple[list[Known], World]:
    """All experts, each once, under labels of their own, and their world."""
    found: dict[str, Known] = {}
    worlds: dict[str, World] = {}
    for one in given:
        text = one if isinstance(one, str) else sources.Source.of(one).text
        source = Source(text, named=Named(one, options.world))
        expert, world = source.read()
        worlds.setdefault(world.name, world)
        label = Path(source.text).name or source.text
        hashed = bool(expert.hash) and not is_named_by_user(world.name)
        known = expert.hash if hashed else fingerprint(expert, world)
        if not hashed and known in found and found[known].source.text != text:
            what = f"{label} acts as {found[known].label} does in the first {FIRST} held-out episodes"
            raise InputError(what, "--experts", "leave one of the two out")
        found.setdefault(known, Known(label, world.name, replace(source, world=world.name), known))
    if len(worlds) > 1:
        advice = "compare experts of one world, or say it with --world"
        raise InputError("the experts play different worlds", f"--experts: {', '.join(worlds)}", advice)
    return tell_apart(found.values()), next(iter(worlds.values()))


def fingerprint(expert: Expert, world: World) -> str:
    """The hash of what happens in the expert's first held-out episodes: another expert or world has another one."""
    seeds = range(measures.MEASUREMENT_SEEDS, measures.MEASUREMENT_SEEDS + FIRST)
    said = hashlib.sha256()
    for played in rollout(world, [expert] * len(world.agents), seeds):
        for part in (*played.observations, played.actions, played.returns, played.values):
            said.update(np.ascontiguousarray(part).tobytes())
    return said.hexdigest()


# --- cells


def list_tasks(experts: Sequence[Known], world: World, options: Request) -> list[Task]:
    """All cells, seed by seed, so that what an interrupted call leaves has whole seeds."""
    held = EPISODES if world.games is None else OUTSIDE
    budget = Budget(options.max_episodes, held, options.settings)
    tasks: dict[str, Task] = {}
    for seed, one in product(range(options.seeds), experts):
        cells = [Cell(EXPERT, world.name, one.label, seed=seed)]
        for algorithm, depth in product(options.algorithms, options.depths):
            cells.append(Cell(EXTRACTION, world.name, one.label, "", algorithm, depth, seed=seed))
        for cell in cells:
            task = Task(cell, one.source, one.hash, "", budget=budget)
            if cell.kind == EXTRACTION and not seed:
                settings = task.settings(world)
                try:  # whether its algorithm can extract in this world; the option is named as `compare` has it
                    check(settings.judge_world(world), settings, refitting.NOTHING.examples)
                except InputError as error:
                    what = error.what.replace("--algorithm", f"--algorithms {task.cell.algorithm}")
                    raise InputError(what, error.where, error.next_step.replace("--algorithm", "algorithm")) from None
            tasks.setdefault(task.id, task)
    return list(tasks.values())
