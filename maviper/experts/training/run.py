"""Training: one seed with a live line, or several side by side, of which the best is kept.

Does: joins worlds, trainers, console and run folders.
Assumes: the extra `maviper[train]`.
Does not: know how an algorithm learns.
"""

import math
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple, Unpack

from codegen.errors import InputError
from maviper.console import Console, LiveLine
from maviper.episodes.measures import Estimate, format_estimate
from maviper.experts.recipes import Request, schedule
from maviper.experts.training import train as training
from maviper.files import resuming, runs
from maviper.files.jobs import Scored, best_of, ensure_counts, folder_of, is_resumed, side_by_side
from maviper.options import TrainOptions, make_request
from maviper.worlds import World, find

MAX_SEED = 2**32


def train_expert(name: str, folder: Path, console: Console, **options: Unpack[TrainOptions]) -> dict[str, Any]:
    """Trains an expert for the named world into a run folder; returns its card.

    The card says `stopped` where a training had to stop early.
    """
    asked = make_request(TrainOptions, options)
    overrides: dict[str, Any] = {"seed": asked.seed}
    overrides |= {} if asked.steps is None else {"steps": asked.steps}
    overrides |= dict(_setting(text) for text in asked.settings)
    request = Request(asked.algorithm, asked.recipe, overrides, asked.device, asked.against).complete()
    world = find(name, giving=True)
    seeds = range(asked.seed, asked.seed + asked.seeds)
    ensure_counts(asked.seeds, asked.jobs)
    if not 0 <= seeds[0] <= seeds[-1] < MAX_SEED:
        raise InputError(f"seeds must be from 0 to {MAX_SEED - 1}, not {_seeds(seeds)}", "--seed, --seeds")
    runs.ensure_vacant(folder, training.EXPERT_FILE, asked.resume)
    resuming.resumable(partial(runs.holds_run, folder))
    console.line("training", f"{world.name}, {request.algorithm}, recipe {request.recipe}, {_seeds(seeds)}")
    console.line("", schedule(request, training.settings_of(world, request)))
    if len(seeds) == 1:
        return _one(world, folder, request, asked.resume, console)
    return _several(_Task(name, folder, request, asked.resume, console.quiet), seeds, asked.jobs, console)


def _setting(text: str) -> tuple[str, str]:
    name, separator, value = text.partition("=")
    if not separator:
        raise InputError(f"'{text[:40]}' is not a setting", "--set", "write --set NAME=VALUE")
    return name, value


def _seeds(seeds: Sequence[int]) -> str:
    return f"seed {seeds[0]}" if len(seeds) == 1 else f"seeds {seeds[0]} to {seeds[-1]}"


def _one(world: World, folder: Path, request: Request, resume: bool, console: Console) -> dict[str, Any]:
    with _Stages(console, resume) as stages:
        return training.train(world, folder, request, stages.keep_best, resume, stages.show)


class _Stages:
    """A live line for each stage of a training. `resumed`: what is told first was done by an earlier call."""

    def __init__(self, console: Console, resumed: bool) -> None:
        self.console, self.resumed, self.stage, self.best = console, resumed, "", -math.inf
        self._said = ""
        self._open = ExitStack()
        self._live: LiveLine | None = None

    def __enter__(self) -> "_Stages":
        return self

    def __exit__(self, *caught: object) -> None:
        self._open.close()

    def keep_best(self, checkpoint: training.Checkpoint, total: int) -> None:
        """Keeps what a checkpoint scored, if it is the best so far."""
        del total
        if checkpoint.score > self.best:
            self.best = checkpoint.score
            self._said = (
                f"best {_format_estimates(checkpoint.measured)}; return {_format_estimates(checkpoint.returns)}"
            )

    def show(self, step: training.Step) -> None:
        """Shows how far a stage is."""
        if step.stage != self.stage or self._live is None:
            self._open.close()
            live = self.console.live(step.stage, step.total, step.done if self.resumed else 0)
            self.stage, self._live = step.stage, self._open.enter_context(live)
        self._live.update(step.done, "  ".join(filter(None, (step.said, self._said))))


def _format_estimates(estimates: Mapping[str, Estimate]) -> str:
    return ", ".join(f"{team} {format_estimate(value)}" for team, value in estimates.items())


class _Task(NamedTuple):
    """A training: of what, where, how."""

    name: str
    folder: Path
    request: Request
    resume: bool
    quiet: bool


def _several(task: _Task, seeds: Sequence[int], jobs: int, console: Console) -> dict[str, Any]:
    """Each seed in a folder of its own; the one with the best score on its finalists' episodes becomes the run's."""
    folder, request = task.folder, task.request
    folders = [folder_of(folder, seed) for seed in seeds]
    asked = [replace(request, overrides={**request.overrides, "seed": seed}) for seed in seeds]
    tasks = [
        _Task(task.name, place, one, is_resumed(place, task.resume), task.quiet)
        for place, one in zip(folders, asked, strict=True)
    ]
    best, card = best_of(folder, seeds, side_by_side(_beside, tasks, jobs), _read_score, console.line)
    kept = (training.EXPERT_FILE, training.CARD_FILE, training.CURVE_FILE)
    runs.write_all(folder, {file: (folder_of(folder, best) / file).read_bytes() for file in kept})
    return card


def _read_score(card: Mapping[str, Any]) -> Scored:
    return Scored(card["score"], f", best after {card['steps']:,} steps, {card['seconds']:.0f} s", card["measured"])


def _beside(name: str, folder: Path, request: Request, resume: bool, quiet: bool) -> dict[str, Any]:
    """One of several seeds, whose lines say whose they are."""
    return _one(find(name, giving=True), folder, request, resume, Console(quiet, f"seed {request.overrides['seed']}"))
