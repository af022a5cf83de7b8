"""The algorithms by name, and what follows all of them.

Does: runs the one that the settings ask for, chooses among its iterates, refines the choice, makes the profile.
Assumes: checked settings.
Does not: know how any of them works.
"""

import math
import time
from collections.abc import Callable
from dataclasses import replace

from codegen import ir
from codegen.errors import InputError, UnknownNameError
from codegen.ir import GrownTree
from codegen.wording import format_count
from maviper.episodes.trees import agent_policies
from maviper.experts.expert import Expert
from maviper.experts.finding import lawful_expert
from maviper.extraction import baselines, dagger, refine, released
from maviper.extraction.arena import merge_leaves
from maviper.extraction.extraction import NO_EXAMPLES, QUIETLY, Examples, Extraction, Running, profile_of
from maviper.extraction.journal import MEASURING, NOTHING_KEPT, WHOLE, Journal, Part, Underway
from maviper.extraction.selection import Selection
from maviper.extraction.settings import (
    AGENT,
    BEST_RESPONSE,
    DEFAULT,
    EQUAL,
    FITTED_Q,
    IMITATION,
    NO_VOTES,
    RELEASED,
    RESPONSE,
    RGMDT,
    SUMMED,
    TEAM,
    VIPER,
    Settings,
    group_agents,
)
from maviper.files.jobs import side_by_side
from maviper.worlds import World
from maviper.worlds.remembering import Remembering


def extract(
    world: World,
    expert: Expert,
    settings: Settings,
    running: Running = QUIETLY,
    journal: Journal = NOTHING_KEPT,
    examples: Examples = NO_EXAMPLES,
) -> ir.PolicyProfile:
    """The policy profile that an algorithm extracts. `journal` keeps what is done, and a later call with the same
    arguments goes on from there. `examples`: states whose labels every iteration learns from as well; refinement
    keeps them.
    """
    settings = settings.complete().deal_budget(world, running.jobs)
    world, settings = settings.judge_world(world), replace(settings, measure=settings.measure_in(world))
    refine.check(settings, world)
    check(world, settings, examples)
    expert = lawful_expert(expert, world)
    agents = [_agent(world, settings)] if settings.algorithm == VIPER else list(range(len(world.agents)))
    ends = time.monotonic() + (settings.max_seconds or math.inf)
    asked = Extraction(world, expert, settings, journal, examples, ends)
    chosen, facts = _iterates(asked, agents, running)
    if asked.is_over():
        asked = replace(asked, settings=replace(settings, refinement=0))
    trees, spent = refine.refine_trees(asked, agents, chosen, running)
    if settings.preset == DEFAULT:  # the others write what their authors' code grows
        merged = {id(tree): merge_leaves(tree) for tree in trees}  # those who share a tree still do
        trees = [merged[id(tree)] for tree in trees]
    facts = {**facts, **spent, **examples.facts}
    settings = replace(asked.fit_held_out(), refinement=settings.refinement)
    running.on_underway(Underway(0, settings.plan(world)[MEASURING], "held-out episodes", MEASURING))
    return profile_of(world, expert, settings, agent_policies(world, trees, agents), facts)


def _agent(world: World, settings: Settings) -> int:
    """The one agent that VIPER is asked for, or that there is."""
    if not settings.agent and len(world.agents) == 1:
        return 0
    if not settings.agent:
        raise InputError("VIPER extracts one agent", "--agent", f"name one of {', '.join(world.agents)}")
    if settings.agent not in world.agents:
        raise UnknownNameError("agent", settings.agent, world.agents, "--agent")
    return world.agents.index(settings.agent)


def check(world: World, settings: Settings, examples: Examples) -> None:
    """InputError where the algorithm cannot learn from examples, or the preset's weight is beyond computing."""
    released.check(world, settings)
    _check_masks(world, settings)
    _check_shared(world, settings)
    _check_outputs(world, settings)
    if isinstance(world, Remembering) and settings.splits in SUMMED:
        what = f"--splits {settings.splits} adds numbers, and the place of a last action is none"
        raise InputError(what, world.name, "choose --splits histogram or exact")
    learns = {FITTED_Q: "rewards", RGMDT: "the expert's Q"}.get(settings.algorithm)
    if len(examples) and learns:
        what = f"{settings.algorithm} learns from {learns}, not from labelled states"
        raise InputError(what, "--counterexamples", "choose another --algorithm, or leave them out")


def _check_masks(world: World, settings: Settings) -> None:
    """InputError if the algorithm ignores action masks, or the depth leaves no room to test them."""
    if not world.masked:
        return
    where = f"{world.name}: its actions have masks"
    if settings.splits in SUMMED:
        what = f"--splits {settings.splits} takes no heed of illegal actions"
        raise InputError(what, where, "choose --splits histogram")
    if settings.algorithm in (FITTED_Q, RGMDT):
        raise InputError(f"{settings.algorithm} takes no heed of illegal actions", where, "choose another --algorithm")
    if settings.preset == RELEASED:
        raise InputError("the authors' code takes no heed of illegal actions", where, "choose another --preset")
    for agent, choices in zip(world.agents, world.actions, strict=True):
        if settings.max_depth + len(choices) - 1 > ir.MAX_DEPTH:
            what = (
                f"{agent} has {format_count(len(choices), 'action')}: with tests of their mask a tree may be too deep"
            )
            raise InputError(what, where, f"depth and actions together may be {ir.MAX_DEPTH + 1}")


def _check_outputs(world: World, settings: Settings) -> None:
    """InputError for what needs numbered actions where agents give numbers, and for leaves of numbers elsewhere."""
    if not world.continuous:
        if settings.leaf:
            what, advice = "--leaves is for continuous actions, and these are numbered", "leave it out"
            raise InputError(what, world.name, advice)
        return
    where = f"{world.name}: its agents give numbers"
    unfit = {
        "--algorithm": (settings.algorithm in (FITTED_Q, RGMDT, BEST_RESPONSE), "it compares numbered actions"),
        "--preset released": (settings.preset == RELEASED, "the authors' code has numbered actions alone"),
        "--set labels": (settings.labels == RESPONSE, "a best reply is one of numbered actions"),
        "--set weights": (settings.weights != EQUAL, "a weight compares the Q of numbered actions"),
        "--set least_right": (settings.least_right != NO_VOTES, "votes count equal actions"),
    }
    for option, (wrong, why) in unfit.items():
        if wrong:
            raise InputError(f"{option} cannot be used with continuous actions: {why}", where, "leave it out")


def _check_shared(world: World, settings: Settings) -> None:
    """InputError where the agents of a team cannot share a tree, since what they observe or do differs."""
    for team in world.teams if settings.share else ():
        first, *others = world.members(team)
        for other in others:
            if _space(world, other) != _space(world, first):
                what = f"{world.agents[first]} and {world.agents[other]} cannot share a tree"
                where = f"--share: {world.name}: team {team}: they differ in features' number or units, or in actions"
                raise InputError(what, where, "leave --share out, or make their spaces equal")


def _space(world: World, agent: int) -> tuple[object, ...]:
    """Returns what agents that share a tree have in common: features by place, whatever their names, and actions."""
    units, given = [feature.unit for feature in world.features[agent]], world.given[agent]
    return units, given, [(action.name, action.effect) for action in world.actions[agent]], world.mask(agent)


Iterates = tuple[list[list[GrownTree]], dict[str, int]]


def _iterates(asked: Extraction, agents: list[int], running: Running) -> Iterates:
    """The best trees of each agent, the chosen one first, and what the provenance says of them."""
    world, settings, by = asked.world, asked.settings, asked.settings.together
    tasks = list[tuple[Extraction, list[int]]]()
    for place, together in enumerate(group_agents(world, by, agents)):
        part = {AGENT: world.agents[together[0]], TEAM: f"team-{place}"}.get(by)
        journal = asked.journal.part(part) if part else asked.journal
        tasks.append((replace(asked, journal=journal), together))
    if running.jobs == 1 or len(tasks) == 1:
        per_task = list[Iterates]()
        for place, (task, together) in enumerate(tasks):
            now = time.monotonic() + task.measuring  # each gets as much of the other time as those after it
            mine = replace(task, ends=now + (task.ends - now) / (len(tasks) - place))
            first = world.agents[together[0]]
            name = first if by == AGENT else world.team_of(first)
            part = Part(place, len(tasks), name) if len(tasks) > 1 else WHOLE
            per_task.append(_choose_iterates(mine, together, replace(running, part=part)))
    else:
        per_task = list[Iterates](side_by_side(_choose_iterates, tasks, running.jobs))
    trees = {
        agent: mine
        for (_, together), (chosen, _) in zip(tasks, per_task, strict=True)
        for agent, mine in zip(together, chosen, strict=True)
    }
    chosen, told = [trees[agent] for agent in agents], [facts for _, facts in per_task]
    last = {"stopped_after": max(facts["stopped_after"] for facts in told)}
    if by == AGENT and settings.algorithm != VIPER:  # of agents one by one, only how long that went on
        return chosen, last
    merged = {name: value for facts in told for name, value in facts.items()}
    return chosen, {**merged, **last, "points": sum(facts["points"] for facts in told)}


def _choose_iterates(asked: Extraction, agents: list[int], running: Running = QUIETLY) -> Iterates:
    """Returns the same as `_iterates`, for agents whose iterates depend on one another."""
    settings, selection = asked.settings, Selection(asked, agents, running)
    rounds: Callable[[Extraction, list[int], Selection], int] = dagger.dagger
    if settings.algorithm == FITTED_Q:
        rounds = baselines.fitted_q
    elif settings.algorithm == RGMDT:
        rounds = baselines.rgmdt
    elif settings.preset == RELEASED:
        rounds = released.imitation if settings.algorithm == IMITATION else released.rounds
    points = rounds(asked, agents, selection)
    return selection.choose_trees(), {**selection.facts, "points": points}
