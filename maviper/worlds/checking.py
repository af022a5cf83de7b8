"""What a world has, lacks or has wrong: `maviper worlds check`.

Does: imports and makes a user's environment, looks at its spaces, plays it twice; compares our games with theirs; of a
  world file, says what it states, whether the checker shows its enclosures, how far play is from scipy's integration,
  and how far the file is from its reference.
Assumes: whoever calls it means to run the code that the name names.
Does not: print; judge whether a game is worth learning.
"""

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from codegen.errors import InputError
from codegen.ir import PHYSICS
from codegen.lowering.render import render
from codegen.wording import format_count, visible
from maviper.files import runs
from maviper.worlds import World, find_built_in
from maviper.worlds.outside import sources
from maviper.worlds.outside.making import import_maker, make_environment
from maviper.worlds.outside.pettingzoo import PROBE_STEPS, PettingZooWorld, faults
from maviper.worlds.outside.processes import Copy
from maviper.worlds.outside.sources import Source, asking, output_aside, space
from maviper.worlds.outside.spaces import random_actions, width
from maviper.worlds.outside.vmas import GAMES, VmasWorld
from maviper.worlds.remembering import split_memory
from maviper.worlds.seeds import fold_seed
from maviper.worlds.stated.deviation import deviation, is_known
from maviper.worlds.stated.systems import flow_rules, read, start
from maviper.worlds.world import Outcome
from verify.checker.reading import RejectedError
from verify.checker.systems.enclosures import ensure_enclosed
from verify.decimals import plain
from verify.systems.properties import ensure_claims
from verify.systems.statement import Statement
from verify.systems.system import Variable

WORLD_FILE = ".toml"  # how the name of a world file ends
SEED = fold_seed(2_000_000_000_000_000)  # as large as those of an extraction
COMPARED = 10  # episode seeds whose first observations are compared with the reference's
FIRST_STEPS = 5  # played before the episode that is repeated, so that what an environment keeps would show


class Mark(StrEnum):
    """The mark of a finding; only what is wrong prevents use."""

    OK = "ok"
    MISSING = "missing"
    WRONG = "wrong"


@dataclass(frozen=True)
class Finding:
    """One thing that was looked at, and what to do about it where something is to be done."""

    mark: Mark
    what: str
    next_step: str = ""

    def __str__(self) -> str:
        said = "; ".join(part for part in (self.what, self.next_step) if part)
        return visible(f"{self.mark:<8} {' '.join(said.split())}")


def usable(findings: Sequence[Finding]) -> bool:
    """Returns True if nothing was found that prevents use."""
    return all(finding.mark is not Mark.WRONG for finding in findings)


def check(
    name: str, run_reference: bool = False, on_found: Callable[[Finding], None] = lambda finding: None
) -> list[Finding]:
    """The findings on a world by its name, `module:function` or world file. `run_reference`: also run an environment
    (user code) that such a file names; `on_found`: told of each finding as soon as it is there.

    They end where a fault leaves nothing more to look at. UnknownNameError or InputError for a name that is neither.
    """
    if name.endswith(WORLD_FILE) and not sources.is_named_by_user(name):
        name = f"{sources.SYSTEM}:{name}"
    name = split_memory(name)[0]
    named = sources.is_named_by_user(name)
    steps = _check_named(sources.parse_source(name), run_reference) if named else _check_built_in(name)
    findings: list[Finding] = []
    try:
        while True:
            with output_aside():  # whatever an environment prints goes to standard error
                finding = next(steps, None)
            if finding is None:
                break
            findings.append(finding)
            on_found(finding)
    except InputError as error:
        if not findings and not named:
            raise
        lines = error.where.removeprefix(name).removeprefix(": ").split("\n")
        place = "; ".join(line.strip() for line in lines if line.strip() != "^")  # of a finding, which is one line
        findings.append(Finding(Mark.WRONG, f"{error.what} ({place})" if place else error.what, error.next_step))
        on_found(findings[-1])
    return findings


def new(path: Path, flow: bool = False) -> None:
    """Writes a world file to start from, in steps or (`flow`) in continuous time. InputError where there is a file
    already.
    """
    name = re.sub(r"[^A-Za-z0-9_-]", "-", path.stem)
    if not runs.create(path, render(f"systems/{'flow' if flow else 'starter'}.toml.j2", name=name)):
        raise InputError("the file exists", str(path), "choose another name")


def _check_named(source: Source, run_reference: bool) -> Iterator[Finding]:
    if source.module == sources.SYSTEM:
        return _check_stated(source, run_reference)
    return _vmas(source) if source.module == sources.VMAS else _user(source)


def _user(source: Source) -> Iterator[Finding]:
    function = import_maker(source)
    yield Finding(Mark.OK, f"import: {source.reference}")
    env = make_environment(function, source)
    yield Finding(Mark.OK, "environment: a PettingZoo parallel environment")
    wrong = [Finding(Mark.WRONG, each.what, each.next_step) for each in faults(env)]
    if wrong:
        yield from wrong
        return
    yield from _spaces(env)
    yield from (findings := list(_start(env, source)))
    Copy(env, source).close()  # copies may share what only one can have
    if not usable(findings):
        return
    world = PettingZooWorld(function, source.text)
    yield from _length(world)
    yield from _names(world)
    yield from _play_world(env, world)
    yield from _meanings(world)


def _check_stated(source: Source, run_reference: bool) -> Iterator[Finding]:
    """Of a world file: what it states, whether that can be played, and how far it is from its reference."""
    statement = read(source.function)
    yield from check_statement(statement)
    if not statement.moves or statement.gives:
        return
    world = PettingZooWorld(import_maker(source), source.text)
    yield from _play_world(world.reference_env(), world)
    if statement.system.reference:
        yield from measure_reference(statement, run_reference)


def _vmas(source: Source) -> Iterator[Finding]:
    """A random episode in the first place of a batch, and the same in the last place of another one."""
    name = source.text
    world = VmasWorld(name)
    yield Finding(Mark.OK, f"scenario: {name}, {format_count(GAMES, 'game')} at once")
    yield Finding(Mark.OK, f"agents: {', '.join(world.agents)}")
    kind = "numbers within bounds" if world.continuous else "Discrete"
    yield Finding(Mark.OK, f"actions: {kind}, {', '.join(str(len(does)) for does in world.decided)}")
    seen = ", ".join(str(len(features)) for features in world.features)
    yield Finding(Mark.OK, f"observations: vectors of {seen} numbers")
    if world.length_known:
        yield from _length(world)
    else:
        said = f"episode length: scenarios have none, so {world.spec.episode_steps} steps are taken"
        yield Finding(Mark.MISSING, said, f"write {name},{sources.MAX_STEPS}=NUMBER")
    yield from _names(world)
    steps, everybody = min(world.spec.episode_steps, PROBE_STEPS), range(len(world.agents))
    uniform = np.random.default_rng(0).random((steps, *world.acting_shape))
    unseen = [np.zeros((steps, len(features)), np.float32) for features in world.features]  # there are no masks
    actions = world.draw_actions(everybody, unseen, uniform)
    played = [_in_place(game, place, actions) for game, place in ((world, 0), (world.apart(), GAMES - 1))]
    if played[0] == played[1]:
        yield Finding(Mark.OK, "repeats: the same seed and actions give the same episode anywhere in a batch")
    else:
        advice = "take a scenario or options without noise: only a start may be random"
        yield Finding(Mark.WRONG, "repeats: the same seed and actions give another episode elsewhere", advice)
    yield from _meanings(world)


def _in_place(world: VmasWorld, place: int, actions: Any) -> list[bytes]:
    """Plays one game of a batch and returns its outcomes, step by step. `actions`: as `draw_actions` gives them."""
    seeds = np.arange(place + 1)
    seeds[place] = SEED
    state = world.start_from_seeds(seeds)
    trace: list[bytes] = []
    for acted in actions:
        state = world.step(state, np.repeat(acted[None], place + 1, axis=0))
        trace += [seen[place].tobytes() for seen in state.observations] + [state.rewards[place].tobytes()]
    return trace


def _check_built_in(name: str) -> Iterator[Finding]:
    world = find_built_in(name)
    module, _, function = world.spec.reference.rpartition(".")
    source = Source(module, function, {})  # for messages only
    yield Finding(Mark.OK, f"world: {world.name}, after {world.spec.reference}")
    if PHYSICS in world.spec.options:
        yield Finding(Mark.OK, "no environment that can be installed moves so: there is nothing to compare it with")
        yield from _names(world)
        return
    env = world.reference_env()
    yield from _spaces(env)
    yield from _start(env, source)
    if sources.attribute(env, "max_cycles", source) == world.spec.episode_steps:
        yield Finding(Mark.OK, f"episode length: {format_count(world.spec.episode_steps, 'step')}, as in the reference")
    else:
        yield Finding(Mark.WRONG, "episode length: not the reference's", "please report it")
    yield from _names(world)
    copies = (Copy(each, source) for each in (env, world.reference_env()))
    yield from _play(env, world, *(partial(_by_copy, copy) for copy in copies))
    yield from _like_reference(env, world)
    yield from _meanings(world)


# --- before anything is played


def _spaces(env: Any) -> Iterator[Finding]:
    agents = env.possible_agents
    yield Finding(Mark.OK, f"agents: {', '.join(map(str, agents))}")
    choices = [space(env, "action", agent) for agent in agents]
    given = [width(each) for each in choices]
    counts = ", ".join(map(str, given if any(given) else [each.n for each in choices]))
    yield Finding(Mark.OK, f"actions: {'numbers within bounds' if any(given) else 'Discrete'}, {counts}")
    sizes = ", ".join(str(space(env, "observation", agent).shape[0]) for agent in agents)
    yield Finding(Mark.OK, f"observations: vectors of {sizes} numbers")


def _start(env: Any, source: Source) -> Iterator[Finding]:
    """Checks `reset`, for a seed as large as those of an extraction."""
    try:
        Copy(env, source).ask("reset", SEED)
    except InputError as error:
        try:
            Copy(env, source).ask("reset", 0)
        except InputError:
            raise error from None
        advice = "seed a numpy generator with it: np.random.default_rng(seed)"
        yield Finding(Mark.WRONG, f"reset: takes seed 0 but not {SEED}: {error.what}", advice)
        return
    try:
        env.reset(seed=SEED)
    except (Exception, SystemExit) as error:
        raise sources.fault(error, source, "the environment's second reset") from error
    yield Finding(Mark.OK, "reset: with a seed, observations of all agents")


# --- what the environment says about itself


def _length(world: PettingZooWorld | VmasWorld) -> Iterator[Finding]:
    steps = world.spec.episode_steps
    if world.length_known:
        yield Finding(Mark.OK, f"episode length: {format_count(steps, 'step')}")
    else:
        said = f"episode length: nobody states one, so an episode that goes on is cut after {steps:,} steps"
        advice = f"give the environment max_cycles, or write {world.source.reference},{sources.MAX_STEPS}=NUMBER"
        yield Finding(Mark.MISSING, said, advice)


def _names(world: World) -> Iterator[Finding]:
    if isinstance(world, PettingZooWorld):
        called = zip(map(str, world.env_agents), world.agents, strict=True)
        renamed = [f"{own} is {name}" for own, name in called if own != name]
        if renamed:
            yield Finding(Mark.OK, f"names: as profiles have them, {', '.join(renamed)}")
    teams = "; ".join(f"{team}: {', '.join(members)}" for team, members in world.teams.items())
    joined = isinstance(world, PettingZooWorld) and world.joined
    why = "equal rewards in a random episode make one team; `teams`, or wrap=rivals, says otherwise"
    yield Finding(Mark.OK, f"teams: {teams}{f' ({why})' if joined else ''}")


def _meanings(world: World) -> Iterator[Finding]:
    lacking = [
        agent
        for agent, features in zip(world.agents, world.features, strict=True)
        if any(feature.meaning is None for feature in features)
    ]
    if lacking:
        said = f"meanings: some features of {', '.join(lacking)} have none"
        said = said if len(lacking) < len(world.agents) else "meanings: features have none"
        advice = "claims can only be about observations then; the environment may give `features`"
        yield Finding(Mark.MISSING, said, advice)
    else:
        yield Finding(Mark.OK, "meanings: every feature has one")


# --- playing


Player = Callable[[int, Sequence[list[Any]]], list[Outcome]]  # the episode of a seed and of all agents' actions


def _play_world(env: Any, world: PettingZooWorld) -> Iterator[Finding]:
    """Plays like `_play`, by the world's own copy, in whatever process that lives, and by a fresh one after its end."""

    def play_afresh(seed: int, actions: Sequence[list[Any]]) -> list[Outcome]:
        world.close()
        copy = Copy(world.reference_env(), world.source)
        try:
            return _by_copy(copy, seed, actions)
        finally:
            copy.close()

    try:
        yield from _play(env, world, partial(_by_world, world), play_afresh)
    finally:
        world.close()


def _play(env: Any, world: World, play: Player, play_afresh: Player) -> Iterator[Finding]:
    """A random episode, after the beginning of another, and the same one in a fresh copy."""
    rng = np.random.default_rng(0)
    choices = [space(env, "action", agent) for agent in env.possible_agents]
    actions = random_actions(choices, rng, min(world.spec.episode_steps, PROBE_STEPS))
    with asking(f"{world.name}: a random episode"):
        play(0, actions[:FIRST_STEPS])
        played = play(SEED, actions)
    ended = next((step for step, outcome in enumerate(played) if all(outcome.done)), None)
    said = "cut at our length" if ended is None else f"all agents done after step {ended}"
    yield Finding(Mark.OK, f"play: a random episode, {said}")
    yield from _sound(env, played)
    with asking(f"{world.name}: the same episode in a fresh copy"):
        again = play_afresh(SEED, actions)
    same = (a.bytes == b.bytes for a, b in zip(played, again, strict=True))
    first = next((step for step, equal in enumerate(same) if not equal), None)
    if first is None:
        yield Finding(Mark.OK, "repeats: the same seed and actions give the same episode in a fresh copy")
    else:
        place = f"step {first}" if first else "its start"
        advice = (
            "let reset(seed=...) decide everything random, and keep nothing from the episode before: freeze running "
            "statistics, such as those of NormalizeObservation"
        )
        yield Finding(Mark.WRONG, f"repeats: the same seed and actions give another episode from {place} on", advice)


def _by_copy(copy: Copy, seed: int, actions: Sequence[list[Any]]) -> list[Outcome]:
    outcomes = [copy.ask("reset", seed)]
    for acted in actions:
        outcomes.append(copy.ask("step", copy.lawful(acted, outcomes[-1])))
    return outcomes


def _by_world(world: PettingZooWorld, seed: int, actions: Sequence[list[Any]]) -> list[Outcome]:
    """By the world's own copy, in whatever process that lives."""
    sizes = [len(choices) for choices in world.actions]
    state = world.start_from_seeds([seed])
    outcomes: list[Outcome] = []
    for acted in [*actions, None]:
        others = (part[0].tolist() for part in (state.rewards, state.done, state.terminated, state.acting, state.told))
        outcomes.append(Outcome([seen[0] for seen in state.observations], *others))
        if acted is not None and world.continuous:
            padded: Any = np.zeros((1, *world.acting_shape), np.float32)
            for agent, given in enumerate(acted):
                padded[0, agent, : len(given)] = given
            state = world.step(state, padded)
        elif acted is not None:
            drawn = world.draw_actions(range(len(acted)), state.observations, (np.array([acted]) + 0.5) / sizes)
            state = world.step(state, drawn)
    return outcomes


def _sound(env: Any, played: Sequence[Outcome]) -> Iterator[Finding]:
    """Checks that all numbers of an episode are finite and the observations within their spaces."""
    wrong: list[Finding] = []
    for index, agent in enumerate(env.possible_agents):
        box = space(env, "observation", agent)
        seen = np.stack([outcome.observations[index] for outcome in played])
        # NaN compares false, so it is never inside
        inside = (seen >= box.low.astype(np.float32)) & (seen <= box.high.astype(np.float32)) & np.isfinite(seen)
        for step, number in np.argwhere(~inside)[:1]:
            value = seen[step, number]
            said = f"observations: {agent}'s number {number} is {value:g} at step {step}"
            advice = "widen the space" if np.isfinite(value) else "observe finite numbers"
            wrong.append(Finding(Mark.WRONG, f"{said}, outside its space or not finite", advice))
        rewards = np.array([outcome.rewards[index] for outcome in played])
        if not np.isfinite(rewards).all():
            said = f"rewards: {agent} gets {rewards[~np.isfinite(rewards)][0]}"
            wrong.append(Finding(Mark.WRONG, said, "give finite rewards"))
    yield from wrong or [Finding(Mark.OK, "numbers: observations finite and in their spaces, rewards finite")]


def _like_reference(env: Any, world: World) -> Iterator[Finding]:
    """Our games' first observations against the reference's, for a few seeds."""
    ours = world.observe(world.start_from_seeds(range(COMPARED)))
    for seed in range(COMPARED):
        observations, _ = env.reset(seed=seed)
        for agent, seen in zip(world.agents, ours, strict=True):
            theirs = observations[agent]
            if theirs.shape != seen[seed].shape:
                said = f"reference: {agent} observes {len(theirs)} numbers there, {len(seen[seed])} here"
                yield Finding(Mark.MISSING, said, "this variant of the game has no reference to compare with")
                return
            if theirs.tobytes() != seen[seed].tobytes():
                said = f"reference: {agent} observes something else after reset(seed={seed})"
                yield Finding(Mark.WRONG, said, "please report it")
                return
    yield Finding(Mark.OK, f"reference: the same observations after reset, for {COMPARED} seeds")


# --- what a world file says


PERIODS = 200
NEAR = 1e-3  # beside the size of a state, of which play may be off
ADVICE = "a shorter period, or slower motion: play integrates a period in 8 parts"
UNDEFINED = "narrow the ranges: over them a derivative must be defined"


def check_integration(statement: Statement) -> Finding:
    """Measures how far play is from scipy's integration, over periods from starts and from anywhere in the ranges."""
    flow, rng = statement.system.flow, np.random.default_rng(0)
    assert flow is not None
    rules, worst, least = flow_rules(flow), dict.fromkeys(flow.rates, 0.0), 0.0
    for number in range(PERIODS):
        anywhere = {each.name: _within(each, rng) for each in statement.system.variables}
        state = start(statement, rng) if number % 2 else anywhere
        rule = next((each for each in rules if each.holds(state)), rules[0])
        chosen = {agent.name: str(rng.choice(list(agent.actions))) for agent in statement.agents}
        try:
            longer = float(rng.uniform(*rule.jitter)) if any(rule.jitter) else 0.0
            after = rule.move_state(state, chosen, longer)
            ends = rule.integrate_states(state, chosen, np.array([rule.period + longer]))[-1].tolist()
            exact = dict(zip(state, ends, strict=True))
        except (ArithmeticError, ValueError) as error:
            where = ", ".join(f"{name} = {value:.6g}" for name, value in state.items())
            return Finding(Mark.WRONG, f"flow: a derivative is not defined from {where}: {error}", UNDEFINED)
        for name, value in exact.items():
            worst[name] = max(worst[name], abs(after[name] - value))
            least = max(least, abs(after[name] - value) / (1 + abs(value)))
    off = ", ".join(f"{name} {value:.2g}" for name, value in worst.items() if name not in flow.kept)
    said = f"integration: {format_count(PERIODS, 'period')} by scipy, of which play is off by at most {off}"
    return Finding(Mark.OK, said) if least <= NEAR else Finding(Mark.MISSING, said, ADVICE)


def _within(variable: Variable, rng: np.random.Generator) -> float:
    """A value of a variable from its range, of a mode a whole number."""
    low, high = float(variable.range[0]), float(variable.range[1])
    return float(rng.integers(int(low), int(high) + 1)) if variable.modes else float(rng.uniform(low, high))


NO_CLAIMS = "add [[claim]], or give `maviper verify` a file of them"


def check_statement(statement: Statement) -> Iterator[Finding]:
    """Lists what a file states."""
    system = statement.system
    yield Finding(Mark.OK, f"file: {system.name}, units fit, and every number is exact")
    variables = ", ".join(f"{each.name} {each.unit}".removesuffix(" 1") for each in system.variables)
    yield Finding(Mark.OK, f"variables: {variables}")
    sizes = [f"{each.name} {len(system.features[each.name])} and {len(each.actions)}" for each in statement.agents]
    yield Finding(Mark.OK, f"features and actions: {', '.join(sizes)}")
    claims = ensure_claims(statement, system.name)
    yield Finding(Mark.OK, f"claims: {claims}") if claims else Finding(Mark.MISSING, "claims: none", NO_CLAIMS)
    if not statement.moves:
        said = "dynamics: none, so claims are about single decisions"
        yield Finding(Mark.MISSING, said, "add [dynamics.next] or [dynamics.flow] for claims about episodes")
        return
    if system.flow is not None:
        told = f"{format_count(len(system.flow.rates), 'derivative')}, a period of {plain(system.flow.period)} s"
        yield Finding(Mark.OK, f"flow: {told}, {format_count(system.steps, 'period')}")
        yield check_integration(statement)
        return
    pieces = "one piece" if len(system.pieces) == 1 else f"{len(system.pieces)} pieces"
    yield Finding(Mark.OK, f"dynamics: {pieces}, {format_count(system.steps, 'step')}")
    try:
        shown = ensure_enclosed(statement)  # by the checker, that the pieces hold what the rules say
    except RejectedError as error:
        yield Finding(Mark.WRONG, f"enclosures: {error}", "cut the ranges of more variables, or into more parts")
    else:
        said = f"{shown} bounds shown" if shown else "none, every rule is affine"
        yield Finding(Mark.OK, f"enclosures: {said}")


def measure_reference(statement: Statement, run: bool) -> Iterator[Finding]:
    """Measures the distance of a statement from its reference. `run`: also where that is code that the file names."""
    name = statement.system.reference
    if not (run or is_known(name)):
        said = f"reference: {name} is code that the file names, and was not run"
        yield Finding(Mark.MISSING, said, "add --run-reference to run it and measure the statement")
        return
    measurement = deviation(statement)
    reach = ", ".join(f"{name} [{low:.2g}, {high:.2g}]" for name, (low, high) in measurement.off.items())
    where = "all over the ranges" if measurement.placed else "where its episodes lead"
    yield Finding(Mark.OK, f"reference: {name}, {measurement.steps} steps {where}, off by {reach}")
    if measurement.outside:
        yield Finding(Mark.MISSING, f"reference: {measurement.outside} steps began where nothing is stated")
    if measurement.beyond:
        advice = "widen the error of the variable, narrow its range, or mend the rule"
        said = f"reference: {measurement.beyond} steps beyond the stated error; {measurement.worst}"
        yield Finding(Mark.WRONG, said, advice)
    else:
        yield Finding(Mark.OK, "error: no step is off by more than stated")
