"""Verifying a profile's claims: the verifier joined with simulator, compiled code and reference environment.

Does: hands `verify` its replays and the share of on-policy states, and makes the report's files.
Assumes: the profile's world is one of ours; otherwise only the reference replays.
Does not: decide verdicts.
"""

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, overload

import numpy as np

from codegen import ir
from codegen.compiled import CompiledC, find_compiler
from codegen.errors import InputError
from codegen.lower import lower
from codegen.policy_json import content_hash
from codegen.render import render
from codegen.targets import c
from maviper import agreement, runs
from maviper.evaluate.play import Episodes
from maviper.rollouts import rollouts, state_of
from maviper.worlds import ParticleWorld, WorldState
from maviper.worlds.particle import placed
from verify import closed_loop, engine, report
from verify.claim import Claim
from verify.closed_loop import LoopResult
from verify.counterexample import Replay
from verify.encode import Question, question, reaching
from verify.engine import Result, Visited
from verify.episodes import ClosedLoop
from verify.properties import LEAVES, Property, sentence
from verify.rollout import Course, agreed
from verify.solve import smt_lib
from verify.spec import MACHINE, Region, read_region
from verify.where import where as located
from verify.world import Point, contains, everywhere, observed, observed_velocities, verifiable

MOST_REGION_BYTES = 2**20


def find_region(name: str, profile: ir.PolicyProfile) -> Region:
    """`start` for the start box, else the region in the file `name`."""
    if name == "start":
        return everywhere(profile)
    path = Path(name)
    try:
        source = runs.read(path, MOST_REGION_BYTES).decode()
    except UnicodeDecodeError:
        raise InputError("not a readable region file", f"{name}: not UTF-8 text", "is this the right file?") from None
    # a file called start must not be taken for the start box when the report names it
    where = f"./{path.name}" if path.name == "start" else path.name
    return read_region(source, profile.world, where, observed_velocities(profile))


@overload
def verify_claims(
    profile: ir.PolicyProfile,
    questions: Sequence[tuple[Property, Region]],
    budget: int = ...,
    semantics: str = ...,
    where: int | None = ...,
) -> list[Result]: ...


@overload
def verify_claims(
    profile: ir.PolicyProfile,
    questions: Sequence[tuple[Claim, Region]],
    budget: int = ...,
    semantics: str = ...,
    where: int | None = ...,
) -> list[Result | LoopResult]: ...


def verify_claims(
    profile: ir.PolicyProfile,
    questions: Sequence[tuple[Claim, Region]],
    budget: int = engine.DEFAULT_BUDGET,
    semantics: str = MACHINE,
    where: int | None = None,
) -> list[Any]:
    """A result for each (claim, region). `budget` and `semantics` are of claims about single decisions; those about
    episodes have their own budget and speak of the deployed arithmetic. `where`: also where claims about single
    decisions hold, by so many violating zones at most; None: not asked.
    """
    ir.ensure(profile)
    world = agreement.matching_world(profile)
    compiler = find_compiler()
    skipped = [] if compiler else ["compiled C: no compiler found"]
    skipped += [] if world else [f"{profile.world.reference}: {agreement.NO_WORLD}"]
    single = any(isinstance(claim, Property) for claim, _ in questions)
    episodes = agreement.on_policy(profile, world) if world is not None and single else None
    results: list[Result | LoopResult] = []
    with _compiled(profile, compiler) as compiled:
        for number, (claim, region) in enumerate(questions, 1):
            if isinstance(claim, ClosedLoop):
                replays = rollouts(profile, world, compiled)
                results.append(closed_loop.verify_episodes(profile, claim, region, replays, skipped))
                continue
            decisions = _replays(profile, profile.team(claim.team), world, compiled)

            def decided(claim: Property, region: Region, decisions: Mapping[str, Replay] = decisions) -> Result:
                visited = None if world is None or episodes is None else _visited(world, episodes, region)
                return engine.verify(profile, claim, region, decisions, budget, visited, skipped, semantics)

            result = decided(claim, region)
            if where is not None:
                name = region_file(number, claim)
                found = located(profile, claim, region, result.verdict, semantics, where, name)
                within = decided(claim, found.part.region) if found.part else None
                result = replace(result, where=found, within=within)
            results.append(result)
    return results


def region_file(number: int, claim: Claim) -> str:
    """The name of the file of the region that is found for a claim; claims are counted from 1."""
    return f"region-{number}-{claim.name}.toml"


def replayed(profile: ir.PolicyProfile, team: str, point: Point) -> dict[str, list[int]]:
    """A team's actions in a world state by everything that can replay it here, name -> actions in the team's order."""
    world, policies = agreement.matching_world(profile), profile.team(team)
    with _compiled(profile, find_compiler()) as compiled:
        return {name: each(point) for name, each in _replays(profile, policies, world, compiled).items()}


def replayed_course(profile: ir.PolicyProfile, point: Point, steps: int) -> tuple[Course, tuple[str, ...]]:
    """The episode from a start, and the names of everything that can play it here and took the same course.

    DisagreementError when one of them takes another course.
    """
    with _compiled(profile, find_compiler()) as compiled:
        players = rollouts(profile, agreement.matching_world(profile), compiled)
        return agreed(profile, point, steps, players), tuple(players)


@contextmanager
def _compiled(profile: ir.PolicyProfile, compiler: list[str] | None) -> Iterator[CompiledC | None]:
    """The compiled header, where there is a compiler."""
    if compiler is None:
        yield None
        return
    model = lower(profile)
    header = c.emit(model, profile)[f"{model.prefix}.h"]
    with CompiledC(header, model, compiler) as compiled:
        yield compiled


def _replays(
    profile: ir.PolicyProfile,
    team: Sequence[ir.AgentPolicy],
    world: ParticleWorld | None,
    compiled: CompiledC | None,
) -> Mapping[str, Replay]:
    """What replays a team's decisions in one world state."""
    replays: dict[str, Replay] = {}
    if compiled is not None:
        replays["compiled C"] = partial(_in_compiled, profile, team, compiled)
    if world is not None:
        replays[profile.world.reference] = partial(_in_reference, profile, team, world)
    return replays


def _in_compiled(
    profile: ir.PolicyProfile, team: Sequence[ir.AgentPolicy], compiled: CompiledC, point: Point
) -> list[int]:
    """The team's actions by the compiled header."""
    seen = [observed(profile, policy, point) for policy in team]
    return [int(compiled.act(policy.agent, obs)[0]) for policy, obs in zip(team, seen, strict=True)]


def _in_reference(
    profile: ir.PolicyProfile, team: Sequence[ir.AgentPolicy], world: ParticleWorld, point: Point
) -> list[int]:
    """The team's actions on what the reference environment itself observes in the world state; features that it does
    not have, and those that a counterexample's errors change, are observed by their meanings.
    """
    env = world.reference_env()
    env.reset(seed=0)
    state = state_of(profile, point)
    placed(env, state)
    found = []
    for policy in team:
        agent = world.agents.index(policy.agent)
        obs = world.observe(state)[agent].copy()
        shown = env.aec_env.unwrapped.observe(policy.agent)
        obs[0, : world.shown[agent]] = shown[: world.shown[agent]]
        exact, wrong = observed(profile, policy, replace(point, errors={})), observed(profile, policy, point)
        obs = np.where(exact == wrong, obs, wrong)
        found.append(int(ir.act(policy, obs)[0]))
    return found


def _visited(world: ParticleWorld, episodes: Episodes, region: Region) -> Visited:
    """How many on-policy states lie inside a region, its goals included."""
    state = WorldState.joined(episodes.states[1:])
    within = contains(region, world.coordinates(state), world.spec)
    if region.goals:
        names = np.array([landmark.name for landmark in world.spec.landmarks])
        within &= np.isin(names[state.goal], region.goals)
    return Visited(int(within.sum()), len(within), len(episodes.states[0]))


def digests(files: Mapping[str, str | bytes]) -> dict[str, str]:
    """SHA-256 of each text in hexadecimal, by name."""
    encoded = {name: item.encode() if isinstance(item, str) else item for name, item in sorted(files.items())}
    return {name: hashlib.sha256(item).hexdigest() for name, item in encoded.items()}


def question_files(
    profile: ir.PolicyProfile, asked: Sequence[tuple[Claim, Region, str]], semantics: str = MACHINE
) -> dict[str, str]:
    """The very questions, one a property and goal (of alive_leaves: one a leaf and goal), as SMT-LIB, name -> text.

    Claims about episodes have none: no solver is asked about them.
    """
    files: dict[str, str] = {}
    for number, (claim, region, _) in enumerate(asked, 1):
        if isinstance(claim, ClosedLoop):
            continue
        for goal in region.goals or ("",):
            for name, made in _questions(profile, claim, region, goal, semantics):
                files[f"{number:02d}-{name}-{goal or 'no-goal'}.smt2"] = render(
                    "smt/question.smt2.j2",
                    profile=content_hash(profile),
                    claim=f"{claim.shown}: {claim.written or sentence(claim)}",
                    assume=claim.assumption,
                    leaf=claim.name == LEAVES,
                    region=region.name,
                    goal=goal,
                    semantics=semantics,
                    text=smt_lib(made),
                )
    return files


def _questions(
    profile: ir.PolicyProfile, claim: Property, region: Region, goal: str, semantics: str
) -> Iterator[tuple[str, Question]]:
    """What the solver is asked for one goal, each question with a name that suits a file."""
    team = verifiable(profile, claim.team)
    if claim.name != LEAVES:
        yield claim.name, question(profile, claim, region, goal, semantics=semantics)
        return
    for policy in team:
        for leaf in map(int, ir.leaves(policy.tree)):
            yield f"{LEAVES}-{policy.agent}-{leaf}", reaching(profile, policy.agent, leaf, region, goal)


def report_files(
    profile: ir.PolicyProfile,
    results: Sequence[Result | LoopResult],
    commands: Sequence[str],
    files: Mapping[str, str | bytes],
) -> dict[str, str]:
    """report.html, report.json and report.txt, name -> text. `files`: texts whose hashes the report names."""
    facts = report.document(profile, results, commands, digests(files))
    return {
        "report.json": report.as_json(facts),
        "report.txt": report.as_text(facts),
        "report.html": report.as_html(facts),
    }
