"""Extraction by name: find the expert, extract with a live line, write the profile or a whole run folder.

Does: joins expert store, algorithm, console and file; chooses the further features that help trees to act as an expert
  does: trees are grown with and without each group on the expert's own episodes, and what predicts held-out ones better
  is kept.
Assumes: options as a user gives them; groups of features that are derived from what agents observe already.
Does not: know how trees are grown.
"""

import json
import platform
import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import asdict, dataclass, replace
from functools import partial
from importlib import metadata
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from codegen import ir, policy_json
from codegen.errors import InputError
from codegen.ir import Float32
from codegen.wording import format_count
from maviper.console import Console, LiveLine
from maviper.episodes import measures
from maviper.episodes.measures import format_estimate, ratio
from maviper.episodes.play import TALLY, points, rollout
from maviper.evaluation import held_out
from maviper.evaluation.held_out import format_cut, read_measure, stop_of
from maviper.experts.cards import how_learned
from maviper.experts.expert import Expert, labels
from maviper.experts.finding import NONE, critic_of, find_expert, origin_of, seeing
from maviper.experts.foreign.layers import LOG_PROBABILITIES
from maviper.extraction import refitting
from maviper.extraction.algorithms import check, extract
from maviper.extraction.dataset import Dataset
from maviper.extraction.extraction import Running, finalist_score
from maviper.extraction.growth.growing import Growth
from maviper.extraction.journal import (
    EXPERT_STEP,
    EXTRACTING,
    MEASURING,
    NOTHING_KEPT,
    REFINING,
    SELECTING,
    Journal,
    Progress,
    Underway,
)
from maviper.extraction.selection import explain_stop
from maviper.extraction.settings import STARTING, Settings, part_settings
from maviper.files import resuming, runs
from maviper.files.jobs import Scored, best_of, ensure_counts, folder_of, is_resumed, side_by_side
from maviper.files.profiles import version
from maviper.files.runs import working_alone
from maviper.options import ExtractOptions, complete_options
from maviper.worlds import ParticleWorld, World, find_built_in
from maviper.worlds.games.features import DERIVED, SEPARATOR
from maviper.worlds.matching import with_names
from maviper.worlds.outside.sources import Source, logging_output
from maviper.worlds.world import Int

EPISODES, HELD_OUT = 200, 50
NAMED = 4  # agents that a line names
LEAST_GAIN = 0.01  # of the share of held-out actions that are predicted right, all agents together


def helpful_features(world: ParticleWorld, expert: Expert, settings: Settings) -> str:
    """Groups of features, best first, joined as an option says them; "" when none helps."""
    seeds = settings.episodes(measures.ROLLOUT_SEEDS)[:EPISODES]
    (played,) = rollout(world, [expert] * len(world.agents), seeds)
    observations, state = points(played)
    wanted = labels(expert, observations, state)
    held = np.arange(len(wanted)) % EPISODES < HELD_OUT
    chosen: list[str] = []
    reached = _right(world, world.observe(state), wanted, held, settings)
    while True:
        accuracy: dict[str, float] = {}
        for group in DERIVED:
            try:
                wide = find_built_in(f"{world.name},features={SEPARATOR.join([*chosen, group])}")
            except InputError:  # it is there already, or adds nothing
                continue
            accuracy[group] = _right(wide, wide.observe(state), wanted, held, settings)
        best = max(accuracy, key=lambda group: accuracy[group], default="")
        if not best or accuracy[best] < reached + LEAST_GAIN:
            return SEPARATOR.join(chosen)
        chosen.append(best)
        reached = accuracy[best]


def _right(world: World, observations: tuple[Float32, ...], wanted: Int, held: ir.Bool, settings: Settings) -> float:
    """The share of held-out actions that trees grown on the others predict."""
    growth = Growth(world, settings)
    shape = wanted[~held].shape
    known = Dataset(tuple(seen[~held] for seen in observations), wanted[~held], np.ones(shape), np.ones(shape, bool))
    ones = [np.ones(len(known), dtype=np.int64)] * len(observations)
    shares = list[float]()
    for agent, seen in enumerate(observations):
        (tree,) = growth.team([agent], known, ones, [settings.seed] * len(observations), 0)
        shares.append(float((tree.action[ir.apply(tree, seen[held])] == wanted[held, agent]).mean()))
    return float(np.mean(shares))


AUTOMATIC = "auto"
WEIGHED = {
    "measured": "measured critic",
    LOG_PROBABILITIES: "its log-probabilities as critic",
    NONE: "no Q: all states weigh the same",
}
FORMAT = "maviper-extraction-6"
METRICS_FILE, STEPS, COMPARING = "metrics.jsonl", "steps", "comparing"
WORDS = {
    STARTING: "to get to know the game",
    SELECTING: "to select by",
    REFINING: "to refine by",
    MEASURING: "held out",
    COMPARING: "to compare with what failed",
}
SAME = ("format", "tool", "world", "expert", "critic", "counterexamples", "features_file")  # in every call for one run
PACKAGES = ("mpe2", "numpy", "scikit-learn")


@dataclass(frozen=True)
class Request:
    """The request for an extraction: the options that are no settings of an algorithm, and those that are."""

    features: str  # further ones, or AUTOMATIC
    features_file: Path | None  # that names those of a user's own world
    critic: str
    world: str | Callable[..., Any] | None  # of a user's own
    counterexamples: tuple[Path, ...]
    seeds: int  # from the setting `seed` on; the best is kept
    jobs: int  # seeds, agents or teams at a time
    resume: bool
    settings: Mapping[str, Any]
    command: str  # that asks for the same


def request(options: Mapping[str, Any], command: str = "maviper.extract") -> Request:
    """The options of the verb as a request. TypeError for an option that there is not, InputError for a value that it
    cannot have.
    """
    given, settings = part_settings(complete_options(ExtractOptions, options))
    ensure_counts(given["seeds"], given["jobs"])
    return Request(**given, settings=settings, command=command)


class Found(NamedTuple):
    """Everything that an extraction names, found and checked."""

    name: str  # of the expert
    expert: Expert
    world: World
    settings: Settings
    lessons: refitting.Task = refitting.NOTHING


def _find(expert: Any, options: Request, console: Console) -> Found:
    features = options.features
    seen = "" if features == AUTOMATIC else features
    loaded, world = find_expert(expert, options.critic, options.world, seen, giving=True)
    settings = Settings.of(options.settings, world, weighed=critic_of(loaded) != NONE)
    settings.judge_world(world)  # whether there is such a measure
    if features == AUTOMATIC:
        features = ""
        if isinstance(world, ParticleWorld):
            console.line("features", f"tried on {EPISODES} episodes of the expert")
            features = helpful_features(world, loaded, settings)
        console.line("features", features or "none helps")
        loaded, world = seeing(loaded, world, features) if features else (loaded, world)
    if options.features_file is not None:
        world = with_names(world, options.features_file)
    lessons = refitting.task_of(options.counterexamples, world, loaded, console)
    check(world, settings, lessons.examples)
    name = expert if isinstance(expert, str) else Source.of(expert).text
    return Found(name, loaded, world, settings, lessons)


def extract_named(expert: Any, output: Path | None, options: Request, console: Console) -> ir.PolicyProfile:
    """The trees of the named expert. `expert`: as for `find_expert`; `output`: the profile's .json file, or a run
    folder; None: no file is written.
    """
    alone = output is None or output.suffix == ".json"
    if alone and (options.resume or options.seeds > 1):
        what = "only a run folder can be resumed" if options.resume else "several seeds need a run folder"
        raise InputError(what, str(output or "output"), "name a folder with -o, without .json at the end")
    if output is not None:
        _ensure_room(output, options)  # before the work, not after it
    if output is None or alone:
        asked = _find(expert, options, console)
        profile = extract_live(asked, console, options.jobs)
        return profile if output is None else _write_profile(output, profile, console, asked, options.command)
    with logging_output(output, console.line):
        asked = _find(expert, options, console)
        resuming.resumable(partial(runs.holds_run, output))
        task = _Task(output, asked, options.critic, options.command, options.resume, console.quiet)
        try:
            if options.seeds == 1:
                profile = _run(task, console, options.jobs)
            else:
                say_expert(asked.expert, asked.world, console)
                profile = _best_of_seeds(task, options.seeds, options.jobs, console)
                say_measured(profile, asked.world, console)
        finally:
            asked.world.close()  # copies of a user's environment end
        return _write_profile(output / runs.PROFILE_FILE, profile, console, asked, options.command)


def _ensure_room(output: Path, options: Request) -> None:
    """InputError where the results cannot be written, or would be written over what an extraction reads or over another
    profile.
    """
    if output.suffix != ".json":
        runs.ensure_vacant(output, runs.PROFILE_FILE, options.resume)
        return
    given = [each for path in options.counterexamples for each in (path.iterdir() if path.is_dir() else (path,))]
    for each in (output, *([refitting.report_file(output)] if given else ())):
        runs.target(runs.ensure_other(each, given))


@dataclass(frozen=True)
class _Task:
    """A run: its folder and how it was asked for."""

    folder: Path
    asked: Found
    critic: str
    command: str
    resume: bool
    quiet: bool


def _best_of_seeds(task: _Task, count: int, jobs: int, console: Console) -> ir.PolicyProfile:
    """Each seed in a folder of its own; the one with the best score on episodes that chose nothing yet."""
    settings = task.asked.settings.share_budget(task.asked.world, count)
    asked, first = task.asked._replace(settings=settings), settings.seed
    runs.folder(task.folder)
    seeds, tasks = range(first, first + count), list[tuple[_Task]]()
    for seed in seeds:
        folder, settings = folder_of(task.folder, seed), replace(asked.settings, seed=seed).complete()
        one = asked._replace(settings=settings)
        tasks.append((replace(task, folder=folder, asked=one, resume=is_resumed(folder, task.resume)),))

    dealt = settings.complete().deal_budget(asked.world)
    say_plan(plan_episodes(asked, dealt), console, dealt.budget, count)

    def score(profile: ir.PolicyProfile) -> Scored:
        return Scored(finalist_score(asked.world, asked.expert, dealt, profile.agents))

    return best_of(task.folder, seeds, side_by_side(_run, tasks, jobs), score, console.line)[1]


def _run(task: _Task, console: Console | None = None, jobs: int = 1) -> ir.PolicyProfile:
    """One extraction in a run folder, with its profile there."""
    asked = task.asked
    config = {
        "format": FORMAT,
        "tool": f"maviper {version()}",
        "world": asked.world.name,
        "expert": asked.expert.hash or asked.name,
        "critic": task.critic,
        "command": task.command,
        "counterexamples": asked.lessons.digests,
        "features_file": asked.world.features_from,
        "versions": {"python": platform.python_version(), "maviper": version()}
        | {name: metadata.version(name) for name in PACKAGES},
        "settings": asdict(asked.settings),
    }
    goes_on = runs.claim(task.folder, config, SAME, task.resume)
    told = console or Console(task.quiet, f"seed {asked.settings.seed}")
    with working_alone(task.folder):
        try:
            profile = extract_live(asked, told, jobs, task.folder)
        except InputError:
            if not goes_on:
                # A run that failed on what it was given before it had a tree is taken back: what is asked for next is
                # another run, and may have the folder. A run with more than the expert's own play stays.
                steps = task.folder / STEPS
                play = steps / f"{EXPERT_STEP}.safetensors"
                if {*steps.rglob("*")} <= {play}:
                    play.unlink(missing_ok=True)
                    if steps.exists():
                        steps.rmdir()
                    (task.folder / runs.CONFIG_FILE).unlink()
            raise
        runs.write(task.folder / runs.PROFILE_FILE, policy_json.dumps(profile))
    return profile


def _write_profile(
    place: Path, profile: ir.PolicyProfile, console: Console, asked: Found, command: str
) -> ir.PolicyProfile:
    """The profile as a file, and what counterexamples did to it, where it learned from any."""
    files = {place.name: policy_json.dumps(profile)}
    if asked.lessons.failing:
        outcomes = refitting.report(asked.lessons, profile, place, asked.name, asked.expert, asked.world)
        for outcome in outcomes:
            outcome.say(console)
        files[refitting.report_file(place).name] = refitting.report_text(outcomes, command)
    runs.write_all(place.parent, files)
    console.line("wrote", f"{place}  id {policy_json.content_hash(profile)[:16]}")
    return profile


def extract_live(asked: Found, console: Console, jobs: int = 1, folder: Path | None = None) -> ir.PolicyProfile:
    """Extracts with a live line, then says what the trees reach. `folder`: of a run that is kept and goes on."""
    world, expert, settings, examples = asked.world, asked.expert, asked.settings, asked.lessons.examples
    if not console.of:  # one of several seeds, of all of which this is said
        say_expert(expert, world, console)
    journal = Journal(folder / STEPS) if folder else NOTHING_KEPT
    plan = plan_episodes(asked, settings.complete().deal_budget(world, jobs))
    if not console.of:
        say_plan(plan, console, settings.budget)
    with Stages(console, world, folder / METRICS_FILE if folder else None, plan) as stages:
        profile = extract(world, expert, settings, Running(stages.show, jobs, stages.underway), journal, examples)
    told = profile.provenance.training
    if int(told["stopped_after"]) < int(told["iterations"]):
        rounds = format_count(int(told["iterations"]), "round")
        console.line("stopped", f"after {told['stopped_after']} of {rounds}: {explain_stop(told)}")
    if not console.of:
        say_measured(profile, world, console)
    return profile


def say_expert(expert: Expert, world: World, console: Console) -> None:
    """Prints what made the expert, and how it learned."""
    algorithm, own = expert.card.get("algorithm", ""), "" if expert.hash else origin_of(expert)
    made = f"{own} ({algorithm})" if own and algorithm else own or algorithm or "unknown"
    critic = f", {WEIGHED[critic_of(expert)]}" if critic_of(expert) in WEIGHED else ""
    console.line("expert", f"{made} for {world.name}{critic}{f', id {expert.hash[:16]}' if expert.hash else ''}")
    if how_learned(expert.card):
        console.line("", f"it learned by {how_learned(expert.card)}")


def plan_episodes(asked: Found, dealt: Settings) -> dict[str, int]:
    """Counts the episodes that each stage plays at most, and those that compare the trees with policies that failed."""
    compared = 2 * held_out.EVALUATION_EPISODES * len(asked.lessons.failing)
    return dealt.plan(asked.world) | ({COMPARING: compared} if compared else {})


def say_plan(plan: Mapping[str, int], console: Console, budget: int = 0, seeds: int = 1) -> None:
    """Prints the number of episodes that are going to be played, stage by stage. `budget`: what --max-episodes says."""
    stages = ", ".join(f"{count:,} {WORDS.get(stage, stage)}" for stage, count in plan.items())
    each = "" if seeds == 1 else f" for each of {seeds} seeds, and the held-out ones again to choose among them"
    counted = sum(count for stage, count in plan.items() if stage not in (MEASURING, COMPARING))
    within = f", {counted:,} of them within --max-episodes" if 0 < budget < sum(plan.values()) else ""
    console.line("plan", f"up to {sum(plan.values()):,} episodes{within}{each}: {stages}")


class Stages:
    """A live line for each stage of an extraction, and a line of `metrics` for each step. The time that is left is that
    of all stages to come: of later ones, by the pace at which episodes of `plan` were played.
    """

    def __init__(self, console: Console, world: World, metrics: Path | None, plan: Mapping[str, int]) -> None:
        self.console, self.world, self.metrics, self.plan = console, world, metrics, plan
        self.stage: str = ""
        self._since = time.monotonic()
        self._lines: list[str] = []
        self._best = ""
        self._open = ExitStack()
        self._live: LiveLine | None = None
        self._begun = self._of_stage = TALLY.episodes
        self._shown: tuple[float, str] = (0, "")
        self._rounds = 0.0  # seconds that later rounds will take
        self._teams = 0  # that are refined after the one that is now

    def __enter__(self) -> "Stages":
        TALLY.on_played = self._count_played
        return self

    def __exit__(self, *caught: object) -> None:
        TALLY.on_played = lambda: None
        self._open.close()

    def underway(self, told: Underway) -> None:
        """Shows how far a step has come, or that a stage of episodes begins."""
        part, named = told.part, f"{told.part.name}, " if told.part.name else ""
        self._since = self._since if told.stage == EXTRACTING else time.monotonic()
        live = self._line(f"{told.stage} {part.place}" if told.stage == SELECTING else told.stage, told.stage, told)
        if told.stage == EXTRACTING:
            done = told.done + part.place * told.total
            self._show(live, done, named + (self._best or told.doing))
        else:
            self._of_stage, self._best = TALLY.episodes, named + told.doing

    def show(self, progress: Progress) -> None:
        """Shows and writes one step. A run that goes on shows the steps that are done again, so the file is whole."""
        if self.metrics:
            self._lines.append(json.dumps(progress.line) + "\n")
            runs.write(self.metrics, "".join(self._lines))
        label = progress.stage if progress.stage == EXTRACTING else f"{progress.stage} {'+'.join(progress.measured)}"
        part, live = progress.part, self._line(label, progress.stage, progress)
        self._teams = part.count - part.place - 1 if progress.stage == REFINING else 0
        best = ", ".join(f"{team} {format_estimate(estimate)}" for team, estimate in progress.measured.items())
        agreed = "" if progress.fidelity is None else f"  fidelity {progress.fidelity:.2f}"
        best = f"best {best}{agreed}  {format_count(progress.leaves, 'leaf')}"
        self._best = "" if progress.done == progress.total else best  # those of another part are others
        before = part.place * progress.total if progress.stage == EXTRACTING else 0
        self._show(live, progress.done + before, (f"{part.name}, " if part.name else "") + best)
        self._since = time.monotonic()

    def _count_played(self) -> None:
        """Shows the episodes of a stage that is counted in them, and in others how many were played."""
        done = TALLY.episodes - self._of_stage
        if self._live is None:
            return
        if self.stage == EXTRACTING:
            self._show(self._live, *self._shown)
        elif self.stage.startswith((SELECTING, MEASURING)) and done <= self._live.total:
            self._show(self._live, done, self._best)

    def _show(self, live: LiveLine, done: float, words: str) -> None:
        self._shown = done, words
        played = TALLY.episodes - self._begun
        counted = f"  {played:,} episodes" if played else ""
        own = live.ahead(done)
        if self.stage == EXTRACTING:
            self._rounds = own or 0.0
        if own is not None and self._teams:  # each takes about as long
            own += self._teams * (live.elapsed + own)
        live.update(done, words + counted, None if own is None else own + self._later())

    def _later(self) -> float:
        """Seconds of the stages after this one, as far as can be told."""
        stages = [EXTRACTING, SELECTING, REFINING, MEASURING]
        at = next(place for place, stage in enumerate(stages) if self.stage.startswith(stage))
        counts = [self.plan.get(stage, 0) for stage in stages[at + 1 :]]
        rounds = self._rounds if self.stage.startswith(SELECTING) else 0.0
        return rounds + TALLY.expect(self.world, *counts)

    def _line(self, label: str, stage: str, told: Progress | Underway) -> LiveLine:
        """The live line of a stage, a new one where another begins."""
        if label != self.stage or self._live is None:
            self._open.close()
            total = told.total * (told.part.count if stage == EXTRACTING else 1)
            begun = told.part.place * told.total if stage == EXTRACTING else 0
            self.stage, self._live = label, self._open.enter_context(self.console.live(stage, total, begun))
            self._live.started, self._best = self._since, ""  # its first step was done before it was shown
        return self._live


def say_measured(profile: ir.PolicyProfile, world: World, console: Console) -> None:
    """Each team's measures against expert opponents beside the expert's own, on held-out episodes."""
    measured = profile.provenance.evaluation
    for name in dict.fromkeys(measure.name for measure in world.measures):
        parts = list[str]()
        for measure in world.measures:
            if measure.name == name:
                ours, theirs = read_measure(measured, measure)
                relative = ratio(measure, ours, theirs)
                text = "no ratio" if relative is None else f"ratio {relative:.2f}"
                cut = format_cut(measured, measure.team)
                parts.append(f"{measure.team} {ours:.3f} (expert {theirs:.3f}, {text}{cut})")
        console.line("measured", f"{name}: {'; '.join(parts)}, {measured['episodes']} held-out episodes")
    if any(format_cut(measured, team) for team in world.teams):
        console.line("length", f"episodes that went on were cut after {stop_of(world)}")
    say_idle(profile, console)


def say_idle(profile: ir.PolicyProfile, console: Console) -> None:
    """Says which trees have leaves that decided nothing in the held-out episodes, if any have."""
    told: list[str] = []
    for policy in profile.agents:
        leaves, visits = ir.leaves(policy.tree), policy.tree.visits
        idle = int((visits[leaves] == 0).sum()) if len(visits) else 0
        if idle:
            told.append(f"{idle} of {policy.agent}'s {format_count(len(leaves), 'leaf')}")
    if told:
        others = f" and {format_count(len(told) - NAMED, 'other agent')}" if len(told) > NAMED else ""
        console.line("idle", f"{', '.join(told[:NAMED])}{others}: no decision in held-out episodes")
