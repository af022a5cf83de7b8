"""Verifying a profile's claims: the verifier joined with simulator, compiled code and reference environment.

Does: hands `verify` its replays and the share of on-policy states, and makes the report's files.
Assumes: the profile's world is one of ours; otherwise only the reference replays.
Does not: decide verdicts.
"""

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any, overload

import numpy as np

from codegen import ir, selfcheck
from codegen.errors import InputError, UnknownNameError
from codegen.lower import lower
from codegen.observe import observe
from codegen.targets import emit
from maviper import agreement, runs
from maviper.evaluate.play import Episodes
from maviper.rollouts import rollouts, state_of
from maviper.worlds import ParticleWorld, WorldState
from maviper.worlds.particle import placed
from verify import closed_loop, engine, report
from verify.closed_loop import LoopResult
from verify.counterexample import Replay
from verify.engine import Result, Visited
from verify.properties import BUILT_IN, Property, find_property
from verify.spec import Region, read_region
from verify.world import Point, contains, everywhere, observed_velocities

MOST_REGION_BYTES = 2**20
USUAL = {"margin": Property("", "").margin, "radius": Property("", "").radius}  # may be given to any claim


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


def find_claim(
    name: str, profile: ir.PolicyProfile, team: str | None = None, **given: Any
) -> Property | closed_loop.ClosedLoop:
    """The named claim, about single decisions or about episodes. `given`: parameters; those that are None are usual.

    InputError for one that the claim does not have.
    """
    chosen = {key: value for key, value in given.items() if value is not None}
    if name in closed_loop.CLOSED_LOOP:
        known, find = ("landmarks", "steps", "radius"), partial(closed_loop.find_claim, name, profile, team)
    elif name in BUILT_IN:
        known, find = BUILT_IN[name].parameters, partial(find_property, name, profile, team)
    else:
        raise UnknownNameError("property", name, [*BUILT_IN, *closed_loop.CLOSED_LOOP])
    for key in chosen:
        if key not in known and chosen[key] != USUAL.get(key):
            raise InputError(f"{name} has no {key}", f"--{key}", f"it has {', '.join(known)}")
    return find(**{key: value for key, value in chosen.items() if key in known})


@overload
def verify_claims(profile: ir.PolicyProfile, questions: Sequence[tuple[Property, Region]]) -> list[Result]: ...


@overload
def verify_claims(
    profile: ir.PolicyProfile,
    questions: Sequence[tuple[Property | closed_loop.ClosedLoop, Region]],
    budget: int = ...,
    zones: int = ...,
) -> list[Result | LoopResult]: ...


def verify_claims(
    profile: ir.PolicyProfile,
    questions: Sequence[tuple[Property | closed_loop.ClosedLoop, Region]],
    budget: int = engine.DEFAULT_BUDGET,
    zones: int = closed_loop.DEFAULT_ZONES,
) -> list[Any]:
    """A result for each (claim, region). `budget`: of the solver a query; `zones`: of a claim about episodes."""
    ir.ensure(profile)
    world = agreement.matching_world(profile)
    compiler = selfcheck.find_compiler()
    skipped = [] if compiler else ["compiled C: no compiler found"]
    skipped += [] if world else [f"{profile.world.reference}: {agreement.NO_WORLD}"]
    single = any(isinstance(claim, Property) for claim, _ in questions)
    episodes = agreement.on_policy(profile, world) if world is not None and single else None
    results: list[Result | LoopResult] = []
    with _compiled(profile, compiler) as compiled:
        for claim, region in questions:
            if isinstance(claim, closed_loop.ClosedLoop):
                replays = rollouts(profile, world, compiled)
                results.append(closed_loop.verify_episodes(profile, claim, region, replays, zones, skipped))
                continue
            visited = None if world is None or episodes is None else _visited(world, episodes, region)
            decisions = _replays(profile, claim, world, compiled)
            results.append(engine.verify(profile, claim, region, decisions, budget, visited, skipped))
    return results


@contextmanager
def _compiled(profile: ir.PolicyProfile, compiler: list[str] | None) -> Iterator[selfcheck.CompiledC | None]:
    """The compiled header, where there is a compiler."""
    if compiler is None:
        yield None
        return
    model = lower(profile)
    header = emit(profile, ["c"])[f"{model.prefix}.h"]
    with selfcheck.CompiledC(header, model, compiler) as compiled:
        yield compiled


def _replays(
    profile: ir.PolicyProfile, claim: Property, world: ParticleWorld | None, compiled: selfcheck.CompiledC | None
) -> Mapping[str, Replay]:
    """What replays a team's decisions in one world state."""
    team = profile.team(claim.team)
    replays: dict[str, Replay] = {}
    if compiled is not None:
        replays["compiled C"] = partial(_in_compiled, profile, team, compiled)
    if world is not None:
        replays[profile.world.reference] = partial(_in_reference, profile, team, world)
    return replays


def _in_compiled(
    profile: ir.PolicyProfile, team: Sequence[ir.AgentPolicy], compiled: selfcheck.CompiledC, point: Point
) -> list[int]:
    """The team's actions by the compiled header."""
    coordinates = point.coordinates(profile)
    seen = [observe(policy.features, coordinates, profile.world) for policy in team]
    return [int(compiled.act(policy.agent, obs)[0]) for policy, obs in zip(team, seen, strict=True)]


def _in_reference(
    profile: ir.PolicyProfile, team: Sequence[ir.AgentPolicy], world: ParticleWorld, point: Point
) -> list[int]:
    """The team's actions on what the reference environment itself observes in the world state; features that it does
    not have are observed by their meanings.
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


def digests(files: Mapping[str, str]) -> dict[str, str]:
    """SHA-256 of each text in hexadecimal, by name."""
    return {name: hashlib.sha256(text.encode()).hexdigest() for name, text in sorted(files.items())}


def report_files(
    profile: ir.PolicyProfile, results: Sequence[Result | LoopResult], commands: Sequence[str], files: Mapping[str, str]
) -> dict[str, str]:
    """report.html, report.json and report.txt, name -> text. `files`: texts whose hashes the report names."""
    facts = report.document(profile, results, commands, digests(files))
    return {
        "report.json": report.as_json(facts),
        "report.txt": report.as_text(facts),
        "report.html": report.as_html(facts),
    }
