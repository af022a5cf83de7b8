"""Making a cell: from a task to the bytes of its files, in any process, on any machine.

Does: extracts, plays the line-ups of each kind of cell, and keeps every episode's values; times itself.
Assumes: the profiles that a cell needs are handed to it.
Does not: touch files or claims, or raise for what goes wrong inside a cell: that is an outcome.
"""

import time
import traceback
from collections.abc import Mapping, Sequence
from dataclasses import replace

from codegen import policy_json
from codegen.errors import InputError, MaviperError
from codegen.ir import Float64, PolicyProfile
from codegen.profiles import loads
from maviper.episodes import measures
from maviper.episodes.play import Controller
from maviper.episodes.trees import among
from maviper.experts.expert import Expert
from maviper.extraction.algorithms import extract
from maviper.extraction.extraction import Running, profile_of
from maviper.extraction.journal import Progress
from maviper.extraction.settings import VIPER
from maviper.files import runs
from maviper.reproduction.cells import facts
from maviper.reproduction.cells.cell import (
    CROSSPLAY,
    DONE,
    EXPERT,
    EXPLOITABILITY,
    EXTRACTION,
    FAILED,
    FORMAT,
    Cell,
    Document,
    Made,
    Task,
    settings_of,
    tool,
)
from maviper.reproduction.cells.responding import Asked, exploit_teams
from maviper.worlds import Measure, World

EPISODES_FILE, FACTS_FILE, ERROR_FILE = "episodes.csv", "facts.json", "error.txt"
HEAD = "lineup,measure,episode,value\n"
Files = dict[str, str]


def make_cell(task: Task, profiles: Mapping[str, bytes]) -> Made:
    """The files of a cell. `profiles`: algorithm -> the profile of the cell of `task.of`, as JSON."""
    from threadpoolctl import threadpool_limits  # pyright: ignore[reportMissingTypeStubs]

    started = time.thread_time()  # of this cell alone, also where a worker has several threads
    outcome, message, files = DONE, "", Files()
    with threadpool_limits(1):  # sums in one order, whatever the machine has cores
        try:
            _ensure_same_tool(task)
            files = _files(task, {name: loads(data, name) for name, data in profiles.items()})
        except MaviperError as error:
            outcome, message = FAILED, " ".join(str(error).split("\n"))
        except Exception as error:
            outcome, message = FAILED, f"{type(error).__name__}: {error}".split("\n")[0]
            files = {ERROR_FILE: traceback.format_exc()}
    spent = round(time.thread_time() - started, 3)
    document = Document(FORMAT, task.cell, task.identity, outcome, message, lower_is_better(task), spent)
    return Made(task.id, document, {name: text.encode() for name, text in files.items()})


def _ensure_same_tool(task: Task) -> None:
    if task.identity["tool"] != tool():
        raise InputError(
            f"the worker has {tool()}, not {task.identity['tool']}", "", "install the same on all machines"
        )


def lower_is_better(task: Task) -> list[str]:
    """The labels of measures of the task's world that are better when lower."""
    world = task.source.read()[1]
    return sorted(measure.label for measure in world.measures if measure.lower_is_better)


def _files(task: Task, profiles: Mapping[str, PolicyProfile]) -> Files:
    expert, world = task.source.read()
    if task.cell.kind == EXPERT:
        rows = play_lineups(world, task.cell, {"expert": ([expert] * len(world.agents), tuple(world.teams))})
        return {EPISODES_FILE: rows, FACTS_FILE: runs.as_json(facts.of_expert(expert, world))}
    if task.cell.kind == EXTRACTION:
        return _extract_cell(task.cell, world, expert, profiles.get(task.cell.algorithm))
    if task.cell.kind == CROSSPLAY:
        lineups = crossplay(world, expert, profiles)
        return {EPISODES_FILE: play_lineups(world, task.cell, lineups), FACTS_FILE: runs.as_json({})}
    assert task.cell.kind == EXPLOITABILITY, task.cell
    lines, told = exploit_teams(Asked(task.cell, world, expert, profiles, task.effort))
    return {EPISODES_FILE: HEAD + "".join(lines), FACTS_FILE: runs.as_json(told)}


# --- line-ups

Lineups = dict[str, tuple[Sequence[Controller], tuple[str, ...]]]  # name -> who plays, whose measures are kept


def play_lineups(world: World, cell: Cell, lineups: Lineups) -> str:
    """Every line-up over the cell's episodes, as CSV: the measures and returns of the teams that are asked for."""
    per_lineup: dict[tuple[int, ...], dict[Measure, Float64]] = {}
    lines = [HEAD]
    for name, (controllers, teams) in lineups.items():
        key = tuple(map(id, controllers))  # a line-up that has two names is played once
        if key not in per_lineup:
            per_lineup[key] = measures.values(world, controllers, cell.episodes)
        for measure, values in per_lineup[key].items():
            if measure.team in teams:
                start = f"{name},{measure.label},"
                pairs = zip(cell.episodes, values.tolist(), strict=True)
                lines += [f"{start}{episode},{value!r}\n" for episode, value in pairs]
    return "".join(lines)


def replacing(world: World, expert: Expert, profile: PolicyProfile) -> Lineups:
    """Each team's trees among experts, each agent's tree among experts, and all trees."""
    experts: list[Controller] = [expert] * len(world.agents)
    ours = among(world, profile.agents, experts)
    lineups: Lineups = {}
    for team in world.teams:
        members = world.members(team)
        mixed = [ours[agent] if agent in members else expert for agent in range(len(ours))]
        lineups[f"joint:{team}"] = mixed, (team,)
    for place, agent in enumerate(world.agents):
        alone = [*experts[:place], ours[place], *experts[place + 1 :]]
        lineups[f"individual:{agent}"] = alone, (world.team_of(agent),)
    return {**lineups, "all": (ours, tuple(world.teams))}


def crossplay(world: World, expert: Expert, profiles: Mapping[str, PolicyProfile]) -> Lineups:
    """Each team of each algorithm, and of the expert, against the opponents of each (the paper's Tables 1, 3 and 4)."""
    experts: list[Controller] = [expert] * len(world.agents)
    players = {name: among(world, profile.agents, experts) for name, profile in profiles.items()} | {"expert": experts}
    lineups: Lineups = {}
    for team in world.teams:
        members = world.members(team)
        for name, ours in players.items():
            for other, theirs in players.items():
                mixed = [ours[agent] if agent in members else theirs[agent] for agent in range(len(experts))]
                lineups[f"{team}:{name}-vs-{other}"] = mixed, (team,)
    return lineups


# --- extraction


def _extract_cell(cell: Cell, world: World, expert: Expert, profile: PolicyProfile | None) -> Files:
    """An extraction, or what is there of it already under another name."""
    curve: list[Progress] = []
    profile = profile or _profile(cell, world, expert, Running(curve.append))
    told = facts.of_profile(cell, world, expert, profile, curve)
    rows = play_lineups(world, cell, replacing(world, expert, profile))
    return {
        runs.PROFILE_FILE: policy_json.dumps(profile),
        EPISODES_FILE: rows,
        FACTS_FILE: runs.as_json(told),
    }


def _profile(cell: Cell, world: World, expert: Expert, running: Running) -> PolicyProfile:
    settings = settings_of(cell, world)
    if cell.algorithm != VIPER:
        return extract(world, expert, settings, running)
    alone = [extract(world, expert, replace(settings, agent=agent), running) for agent in world.agents]
    trees = [each.agents[0] for each in alone]
    stopped = max(int(each.provenance.training["stopped_after"]) for each in alone)
    return profile_of(world, expert, replace(settings, agent=""), trees, {"stopped_after": stopped})
