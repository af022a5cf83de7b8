"""Making a cell: from a task to the bytes of its files, in any process, on any machine.

Does: extracts, plays the line-ups of each kind of cell, has the teams of a profile answered by the expert, the other
  algorithms' trees, a refined tree and networks, and keeps every episode's values; gathers what a cell tells beside its
  episodes: sizes, importances; times itself.
Assumes: the profiles that a cell needs are handed to it; on-policy states of the expert, the same for all of its
  profiles; networks need the extra `maviper[train]`.
Does not: touch files or claims, or raise for what goes wrong inside a cell: that is an outcome.
"""

import tempfile
import time
import traceback
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from codegen import ir, policy_json
from codegen.errors import InputError, MaviperError
from codegen.floats import observations as rounded
from codegen.ir import NO_FEATURE, Float64, PolicyProfile
from codegen.profiles import loads
from maviper.episodes import measures
from maviper.episodes.play import TALLY, Controller, Episodes, play, points
from maviper.episodes.trees import among
from maviper.evaluation.crossplay import Stage, decisions
from maviper.evaluation.exploitability import CHOSEN_ON as CHOICE
from maviper.evaluation.exploitability import exploitability
from maviper.experts.expert import Expert
from maviper.extraction.algorithms import extract
from maviper.extraction.exploiting import Effort, Frozen, Learning, responders
from maviper.extraction.extraction import profile_of
from maviper.extraction.journal import MEASURING
from maviper.extraction.settings import VIPER
from maviper.files import runs
from maviper.reproduction.cells.cell import (
    CROSSPLAY,
    DONE,
    EXPERT,
    EXPLOITABILITY,
    EXTRACTION,
    FAILED,
    FORMAT,
    ID_LETTERS,
    Document,
    Made,
    Task,
    tool,
)
from maviper.worlds import Measure, World
from maviper.worlds.world import RETURN, Int


@dataclass(frozen=True)
class Importances:
    """The importance of each feature of a policy, both [n_features], in the order of the policy's features."""

    decrease: Float64  # Gini impurity that its splits remove; sums to 1, or to 0 where no split removes any
    tested: Float64  # share of decisions whose path tests it, each from 0 to 1; a path tests several, so no fixed sum


def importances(policy: ir.AgentPolicy, observations: npt.ArrayLike, labels: Int | None = None) -> Importances:
    """The importances of a policy's features over observations [n, n_features].

    `labels`: [n] actions whose impurity is meant; None: the tree's own. With the data and labels that a tree was fitted
    to, `decrease` is scikit-learn's `feature_importances_`. InputError for no observations, another width or labels of
    another number.
    """
    tree, n_features, n_actions = policy.tree, len(policy.features), len(policy.actions)
    x = rounded(observations, n_features, policy.agent)
    leaf = ir.apply(tree, x)
    wanted = tree.action[leaf] if labels is None else np.asarray(labels)
    if not len(x) or wanted.shape != (len(x),) or not 0 <= wanted.min() <= wanted.max() < n_actions:
        raise InputError("importances need observations, each with one of the actions as its label", policy.agent)
    classes = np.zeros((len(tree.feature), n_actions))  # observations that reach each node
    np.add.at(classes, (leaf, wanted), 1)
    for node in reversed(list(ir.splits(tree))):  # children come after parents
        classes[node] = classes[tree.left[node]] + classes[tree.right[node]]
    count = classes.sum(axis=1)
    impurity = count - np.square(classes).sum(axis=1) / np.maximum(count, 1)  # Gini times observations
    removed, tested = np.zeros(n_features), np.zeros(n_features)
    passed = np.zeros((len(tree.feature), n_features), dtype=bool)  # features on the path to each node
    for node, feature in enumerate(tree.feature):
        if feature == NO_FEATURE:
            tested += passed[node] * count[node]
            continue
        children = [tree.left[node], tree.right[node]]
        removed[feature] += max(0.0, impurity[node] - impurity[children[0]] - impurity[children[1]])
        passed[children] = passed[node]
        passed[children, feature] = True
    return Importances(removed / (removed.sum() or 1.0), tested / count[ir.ROOT])


ON_POLICY_EPISODES = 400  # of the expert: 10,000 states in games of 25 steps


def of_expert(expert: Expert, world: World) -> dict[str, Any]:
    """Where an expert comes from and how it learned, as its card says."""
    kept = ("algorithm", "recipe", "command", "learned", "steps", "critic_reward")
    card = {name: expert.card[name] for name in kept if name in expert.card}
    return {"world": world.name, "hash": expert.hash, "card": card}


def of_profile(world: World, expert: Expert, profile: PolicyProfile) -> dict[str, Any]:
    """Everything that is told of a profile."""
    seeds = np.arange(measures.ON_POLICY_SEEDS, measures.ON_POLICY_SEEDS + ON_POLICY_EPISODES)
    seen = points(play(world, [expert] * len(world.agents), world.start_from_seeds(seeds)))[0]
    # agent -> by feature, how much its tree's splits on it part its decisions, and how often it is tested
    by_agent: dict[str, Any] = {}
    for place, policy in enumerate(profile.agents):
        told = importances(policy, seen[place])
        names = [feature.name for feature in policy.features]
        by_agent[policy.agent] = {
            "impurity": dict(zip(names, map(float, told.decrease), strict=True)),
            "tested": dict(zip(names, map(float, told.tested), strict=True)),
        }
    return {
        "trees": _sizes(profile),
        "training": dict(profile.provenance.training),
        "importances": by_agent,
    }


def _sizes(profile: PolicyProfile) -> dict[str, Any]:
    """Agent -> the number of leaves of its tree, and its depth."""
    return {
        policy.agent: {"leaves": len(ir.leaves(policy.tree)), "depth": int(ir.depth(policy.tree).max())}
        for policy in profile.agents
    }


# joint steps of each network, episodes of the refined tree; of the quick and the default tier
UNTRAINED: Mapping[str, int] = {"steps": 0, "refinement": 0}
USUAL: Mapping[str, int] = {"steps": 256_000, "refinement": 100_000}
CHOSEN_ON = ":chosen-on"


def exploit_teams(
    task: Task, world: World, expert: Expert, profiles: Mapping[str, PolicyProfile]
) -> tuple[list[str], dict[str, Any]]:
    """Rows of episodes, and what is told of each team, whose trees are answered. `profiles`: the cell's own and other
    algorithms'.
    """
    cell, effort = task.cell, task.effort
    experts: list[Controller] = [expert] * len(world.agents)
    players = {name: among(world, profile.agents, experts) for name, profile in profiles.items()}
    policies, own = players.pop(cell.algorithm), profiles[cell.algorithm]
    others = [profile for name, profile in profiles.items() if name != cell.algorithm]
    trees = [policy for profile in (own, *others) for policy in profile.agents]
    rows: list[str] = []
    told: dict[str, Any] = {}
    for team in world.teams:
        frozen = Frozen(world, policies, team, policy_json.content_hash(own)[:ID_LETTERS])
        with tempfile.TemporaryDirectory() as scratch:
            learning = Learning(Path(scratch), effort["steps"], cell.seed) if effort["steps"] else None
            spent = Effort(learning, effort["refinement"], seed=cell.seed)
            candidates = responders(frozen, expert, players, trees, spent)
            outcome = exploitability(world, policies, team, candidates, CHOICE, cell.episodes)
        (measure,) = outcome.responding
        for answer in outcome.tried:
            rows += _rows(f"{team}:{answer.name}{CHOSEN_ON}", measure, answer, CHOICE)
        for answer in {outcome.usual.name: outcome.usual, outcome.chosen.name: outcome.chosen}.values():
            rows += _rows(f"{team}:{answer.name}", measure, answer, cell.episodes)
        told[team] = outcome.document()
    return rows, {"exploitability": told}


def _rows(lineup: str, measure: Measure, answer: Any, episodes: range) -> list[str]:
    """Returns the rows of a responder's results: the measure by which it is judged, and its return."""
    rows: list[str] = []
    worth = -answer.worth if measure.lower_is_better else answer.worth
    for label, values in ((measure.label, worth), (f"{measure.team} {RETURN}", answer.returns)):
        pairs = zip(episodes, values.tolist(), strict=True)
        rows += [f"{lineup},{label},{episode},{value!r}\n" for episode, value in pairs]
    return rows


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
            if task.identity["tool"] != tool():
                what = f"the worker has {tool()}, not {task.identity['tool']}"
                raise InputError(what, "", "install the same on all machines")
            files = _files(task, {name: loads(data, name) for name, data in profiles.items()})
        except MaviperError as error:
            outcome, message = FAILED, " ".join(str(error).split("\n"))
        except Exception as error:
            outcome, message = FAILED, f"{type(error).__name__}: {error}".split("\n")[0]
            files = {ERROR_FILE: traceback.format_exc()}
    spent = round(time.thread_time() - started, 3)
    document = Document(FORMAT, task.cell, task.identity, outcome, message, lower_is_better(task), spent)
    return Made(task.id, document, {name: text.encode() for name, text in files.items()})


def lower_is_better(task: Task) -> list[str]:
    """The labels of measures of the task's world that are better when lower."""
    world = task.source.read()[1]
    return sorted(measure.label for measure in world.measures if measure.lower_is_better)


def _files(task: Task, profiles: Mapping[str, PolicyProfile]) -> Files:
    expert, world = task.source.read()
    if task.cell.kind == EXPERT:
        rows = play_lineups(world, task.episodes, {"expert": ([expert] * len(world.agents), tuple(world.teams))})
        return {EPISODES_FILE: rows, FACTS_FILE: runs.as_json(of_expert(expert, world))}
    if task.budget is not None:
        return _compare_cell(task, world, expert)
    if task.cell.kind == EXTRACTION:
        profile = _profile(task, world, expert)
        facts = runs.as_json(of_profile(world, expert, profile))
        rows = play_lineups(world, task.episodes, replacing(world, expert, profile))
        return {runs.PROFILE_FILE: policy_json.dumps(profile), EPISODES_FILE: rows, FACTS_FILE: facts}
    if task.cell.kind == CROSSPLAY:
        lineups = crossplay(world, expert, profiles)
        return {EPISODES_FILE: play_lineups(world, task.episodes, lineups), FACTS_FILE: runs.as_json({})}
    assert task.cell.kind == EXPLOITABILITY, task.cell
    lines, told = exploit_teams(task, world, expert, profiles)
    return {EPISODES_FILE: HEAD + "".join(lines), FACTS_FILE: runs.as_json(told)}


# --- line-ups

JOINT = "joint:{}"  # the line-up in which a team's trees play among experts
Lineups = dict[str, tuple[Sequence[Controller], tuple[str, ...]]]  # name -> who plays, whose measures are kept


def play_lineups(world: World, episodes: range, lineups: Lineups) -> str:
    """Every line-up over some episodes, as CSV: the measures and returns of the teams that are asked for."""
    per_lineup: dict[tuple[int, ...], dict[Measure, Float64]] = {}
    lines = [HEAD]
    for name, (controllers, teams) in lineups.items():
        key = tuple(map(id, controllers))  # a line-up that has two names is played once
        if key not in per_lineup:
            per_lineup[key] = measures.values(world, controllers, episodes)
        for measure, values in per_lineup[key].items():
            if measure.team in teams:
                start = f"{name},{measure.label},"
                pairs = zip(episodes, values.tolist(), strict=True)
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
        lineups[JOINT.format(team)] = mixed, (team,)
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


def _compare_cell(task: Task, world: World, expert: Expert) -> Files:
    """An extraction whose teams play among experts, with what a comparison tells beside that."""
    settings, begun = task.settings(world), TALLY.episodes
    profile = _profile(task, world, expert)
    played = TALLY.episodes - begun
    if world.games is None:  # held-out episodes are no part of the budget there
        profiles = 1 + len(world.agents) * (settings.algorithm == VIPER)  # VIPER's of each agent, too
        played -= profiles * settings.plan(world)[MEASURING]
    # each team's trees among experts, as `play_lineups` writes it; and how like the expert each tree acts there, 0 to 1
    stage, lines, fidelity = Stage(world, task.episodes), [HEAD], dict[str, float]()
    trees = {world.agents.index(policy.agent): policy for policy in profile.agents}

    def ask(met: Episodes) -> Int:
        return expert.act(range(len(world.agents)), *points(met)).reshape(met.actions.shape)

    lineups = replacing(world, expert, profile)
    for team in world.teams:
        name = JOINT.format(team)
        controllers, ours = lineups[name][0], {agent: trees[agent] for agent in world.members(team)}
        seen = stage.play(tuple(controllers), lambda met, ours=ours: decisions(ours, met, ask(met)))
        means: list[float] = np.nanmean(seen[1], axis=1).tolist()
        fidelity |= dict(zip((world.agents[agent] for agent in ours), means, strict=True))
        for measure in measures.list_measures(world):
            if measure.team == team:
                pairs = zip(task.episodes, stage.values(tuple(controllers), measure).tolist(), strict=True)
                lines += [f"{name},{measure.label},{episode},{value!r}\n" for episode, value in pairs]
    facts = runs.as_json({"trees": _sizes(profile), "fidelity": fidelity, "played": played})
    return {runs.PROFILE_FILE: policy_json.dumps(profile), EPISODES_FILE: "".join(lines), FACTS_FILE: facts}


def _profile(task: Task, world: World, expert: Expert) -> PolicyProfile:
    settings = task.settings(world)
    if task.cell.algorithm != VIPER:
        return extract(world, expert, settings)
    alone = [extract(world, expert, replace(settings, agent=agent)) for agent in world.agents]
    trees = [each.agents[0] for each in alone]
    stopped = max(int(each.provenance.training["stopped_after"]) for each in alone)
    return profile_of(world, expert, replace(settings, agent=""), trees, {"stopped_after": stopped})
