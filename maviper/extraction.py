"""Extraction as a command: find the expert, extract with a live line, write the profile or a whole run folder.

Does: joins expert store, algorithm, console and file.
Assumes: settings come from the command line or the demo.
Does not: know how trees are grown.
"""

import json
import platform
import time
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import asdict, dataclass, replace
from importlib import metadata
from pathlib import Path
from typing import Any, NamedTuple

from codegen import ir, policy_json
from codegen.errors import InputError
from maviper import refitting, runs, version
from maviper.console import Console, LiveLine
from maviper.evaluate.metrics import ratio, shown
from maviper.experts.expert import Expert
from maviper.experts.finding import find_expert, seeing
from maviper.experts.measured import Measured
from maviper.extract.algorithms import check_examples, extract
from maviper.extract.choosing import helpful_features
from maviper.extract.examples import NO_EXAMPLES, Examples
from maviper.extract.journal import NOTHING_KEPT, Journal
from maviper.extract.outcome import finalist_score, measured_of
from maviper.extract.selection import EXTRACTING, Progress
from maviper.extract.settings import Settings
from maviper.jobs import side_by_side
from maviper.worlds import ParticleWorld, World

AUTOMATIC = "auto"
FORMAT = "maviper-extraction-1"
METRICS_FILE, SEEDS_FILE, STEPS = "metrics.jsonl", "seeds.json", "steps"
MOST_SEEDS = 1_000
SAME = ("format", "tool", "world", "expert", "critic", "counterexamples")  # in every call for one run
PACKAGES = ("maviper", "mpe2", "numpy", "scikit-learn")


def extract_command(expert: str, output: Path, options: Mapping[str, Any], console: Console) -> Path:
    """Extracts from the named expert; returns where the profile is: `output` if that is a .json file, else in the run
    folder of that name.
    """
    chosen = dict(options)
    given = [chosen.pop(name) for name in ("critic", "world", "features", "jobs", "seeds", "resume", "command")]
    critic, named, features, jobs, seeds, resume, command = given
    counterexamples = chosen.pop("counterexamples", ())
    if jobs < 1 or not 1 <= seeds <= MOST_SEEDS:
        raise InputError(f"--seeds must be from 1 to {MOST_SEEDS}, --jobs at least 1", "--seeds, --jobs")
    found, world = find_expert(expert, critic, named, "" if features == AUTOMATIC else features)
    settings = Settings.of(chosen, world)
    if features == AUTOMATIC:
        features = helpful_features(world, found, settings) if isinstance(world, ParticleWorld) else ""
        console.line("features", features or "none helps")
        found, world = seeing(found, world, features) if features else (found, world)
    lessons = refitting.task_of(counterexamples, world, found, console)
    check_examples(settings, lessons.examples)
    asked = _Asked(expert, found, world, command, lessons)
    if output.suffix == ".json":
        if resume or seeds > 1:
            what = "only a run folder can be resumed" if resume else "several seeds need a run folder"
            raise InputError(what, str(output), "name a folder with -o: a name without .json")
        runs.target(output)  # before the work, not after it
        profile = extract_live(world, found, settings, console, jobs, examples=lessons.examples)
        return _written(output, profile, console, asked)
    task = _Task(output, expert, critic, command, resume, lessons)
    if seeds == 1:
        profile = _run(task, world, found, settings, console, jobs)
        return _written(output / runs.PROFILE_FILE, profile, console, asked)
    runs.folder(output)
    tasks = [
        (replace(task, folder=folder, resume=resume and (folder / runs.CONFIG_FILE).exists()), world, found, each)
        for seed in range(seeds)
        for each in [replace(settings, seed=settings.seed + seed)]
        for folder in [output / f"seed-{each.seed}"]
    ]
    profiles: list[ir.PolicyProfile] = []
    scores: list[float] = []
    for profile in side_by_side(_run, tasks, jobs):
        profiles.append(profile)
        scores.append(finalist_score(world, found, settings, profile.agents))
        console.line("seed", f"{profile.provenance.seed}: score {scores[-1]:.3f}")
    best = max(range(seeds), key=lambda place: (scores[place], -place))
    table = {str(profile.provenance.seed): value for profile, value in zip(profiles, scores, strict=True)}
    runs.write(output / SEEDS_FILE, runs.as_json({"best": profiles[best].provenance.seed, "scores": table}))
    say_measured(profiles[best], world, console)
    return _written(output / runs.PROFILE_FILE, profiles[best], console, asked)


class _Asked(NamedTuple):
    """What an extraction was asked for."""

    expert: str
    found: Expert
    world: World
    command: str
    lessons: refitting.Task


@dataclass(frozen=True)
class _Task:
    """A run: its folder and how it was asked for."""

    folder: Path
    expert: str
    critic: str
    command: str
    resume: bool
    lessons: refitting.Task


def _run(
    task: _Task, world: World, expert: Expert, settings: Settings, console: Console | None = None, jobs: int = 1
) -> ir.PolicyProfile:
    """One extraction in a run folder, with its profile there."""
    config = {
        "format": FORMAT,
        "tool": f"maviper {version()}",
        "world": world.name,
        "expert": expert.hash or task.expert,
        "critic": task.critic,
        "command": task.command,
        "counterexamples": task.lessons.digests,
        "versions": {"python": platform.python_version()} | {name: metadata.version(name) for name in PACKAGES},
        "settings": asdict(settings),
    }
    runs.claim(task.folder, config, SAME, task.resume)
    quiet = console or Console(quiet=True)
    profile = extract_live(world, expert, settings, quiet, jobs, task.folder, task.lessons.examples)
    runs.write(task.folder / runs.PROFILE_FILE, policy_json.dumps(profile))
    return profile


def _written(place: Path, profile: ir.PolicyProfile, console: Console, asked: _Asked) -> Path:
    """The profile as a file, and what counterexamples did to it, where it learned from any."""
    runs.write(place, policy_json.dumps(profile))
    if asked.lessons.failing:
        report = refitting.report(asked.lessons, profile, place, asked.expert, asked.found, asked.world)
        report.say(console)
        runs.write(refitting.report_file(place), report.json(asked.command))
    console.line("wrote", f"{place}  id {policy_json.content_hash(profile)[:16]}")
    return place


def extract_live(
    world: World,
    expert: Expert,
    settings: Settings,
    console: Console,
    jobs: int = 1,
    folder: Path | None = None,
    examples: Examples = NO_EXAMPLES,
) -> ir.PolicyProfile:
    """Extracts with a live line, then says what the trees reach. `folder`: of a run that is kept and goes on."""
    made = expert.card.get("algorithm", "unknown")
    critic = ", measured critic" if isinstance(expert, Measured) else ""
    console.line("expert", f"{made} for {world.name}{critic}{f', id {expert.hash[:16]}' if expert.hash else ''}")
    journal = Journal(folder / STEPS) if folder else NOTHING_KEPT
    with Stages(console, folder / METRICS_FILE if folder else None) as stages:
        profile = extract(world, expert, settings, stages.show, jobs, journal, examples)
    say_measured(profile, world, console)
    return profile


class Stages:
    """A live line for each stage of an extraction, and a line of `metrics` for each step."""

    def __init__(self, console: Console, metrics: Path | None = None) -> None:
        self.console, self.metrics, self.stage = console, metrics, ""
        self._since = time.monotonic()
        self._lines: list[str] = []
        self._open = ExitStack()
        self._live: LiveLine | None = None

    def __enter__(self) -> "Stages":
        return self

    def __exit__(self, *caught: object) -> None:
        self._open.close()

    def show(self, progress: Progress) -> None:
        """Shows and writes one step. A run that goes on shows the steps that are done again, so the file is whole."""
        if self.metrics:
            self._lines.append(json.dumps(progress.line) + "\n")
            runs.write(self.metrics, "".join(self._lines))
        label = progress.stage if progress.stage == EXTRACTING else f"{progress.stage} {'+'.join(progress.measured)}"
        if label != self.stage or self._live is None:
            self._open.close()
            self.stage, self._live = label, self._open.enter_context(self.console.live(progress.stage, progress.total))
            self._live.started = self._since  # its first step was done before it was shown
        best = ", ".join(f"{team} {shown(found)}" for team, found in progress.measured.items())
        agreed = "" if progress.agreement is None else f"  agreement {progress.agreement:.2f}"
        self._live.update(progress.done, f"best {best}{agreed}  {progress.leaves} leaves")
        self._since = time.monotonic()


def say_measured(profile: ir.PolicyProfile, world: World, console: Console) -> None:
    """Each team's measures against expert opponents beside the expert's own, on held-out episodes."""
    measured = profile.provenance.evaluation
    for name in dict.fromkeys(measure.name for measure in world.measures):
        parts = []
        for measure in world.measures:
            if measure.name == name:
                ours, theirs = measured_of(measured, measure)
                found = ratio(measure, ours, theirs)
                text = "no ratio" if found is None else f"ratio {found:.2f}"
                parts.append(f"{measure.team} {ours:.3f} (expert {theirs:.3f}, {text})")
        console.line("measured", f"{name}: {'; '.join(parts)}, {measured['episodes']} held-out episodes")
