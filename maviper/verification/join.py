"""Verifying a profile's claims: the verifier joined with simulator, compiled code and reference environment.

Does: hands `verify` its replays and the share of on-policy states, and makes the report's files.
Assumes: the profile's world is one of ours; otherwise only the reference replays.
Does not: decide verdicts.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from codegen import ir
from codegen.agreement.build import Build, ReplayBuild
from codegen.check import ensure
from codegen.errors import shown
from codegen.lowering.render import render
from codegen.policy_json import content_hash
from maviper.episodes.on_policy import on_policy
from maviper.episodes.play import Episodes
from maviper.verification.replays import rollouts, state_of
from maviper.worlds import ParticleWorld, WorldState
from maviper.worlds.matching import NO_WORLD, matching_places
from maviper.worlds.particle import placed
from verify.claims.catalogue import Claim
from verify.claims.decisions import DecisionClaim
from verify.claims.formula import Formula
from verify.claims.observed import RAISED, View, over
from verify.claims.region import MACHINE, Kind, Region, Verdict, called
from verify.question import DecisionQuestion, EpisodeQuestion, Question
from verify.reports import report
from verify.solver.encode import Query, query, reaching
from verify.solver.solve import smt_lib
from verify.states.acting import Acted, Replay, acted
from verify.states.episodes import Episode, EpisodeReplay, agreed
from verify.states.state import State, contains, observed
from verify.verdicts import decisions as engine
from verify.verdicts.decisions import Result, Visited

if TYPE_CHECKING:
    from verify.verdicts.episodes import EpisodeResult

NOT_SET = "claims over observations are replayed by observation; no state of the environment need show them"


@overload
def verify_claims(questions: Sequence[Question[DecisionClaim]], where: bool = ...) -> list[Result]: ...


@overload
def verify_claims(questions: Sequence[Question[Claim]], where: bool = ...) -> list[Result | EpisodeResult]: ...


def verify_claims(questions: Sequence[Question[Claim]], where: bool = False) -> list[Any]:
    """A result for each question; all are about one profile. Those about episodes are of the deployed arithmetic.

    `where`: also where claims about single decisions hold, and from how many starts those about episodes fail.
    """
    return list(one_by_one(questions, where))


def one_by_one(questions: Sequence[Question[Claim]], where: bool = False) -> Iterator[Result | EpisodeResult]:
    """As `verify_claims`, each result as soon as it is known."""
    profile = ensure(questions[0].origin)
    assert all(question.origin is profile for question in questions)
    observing = any(question.viewed is not None for question in questions)
    world = None if observing else matching_places(profile)
    made = ReplayBuild.of(profile)
    skipped = [] if made.compilable else ["compiled C: no compiler found"]
    skipped += (
        [] if world else [f"{shown(profile.world.reference) or 'environment'}: {NOT_SET if observing else NO_WORLD}"]
    )
    single = any(question.claim.kind is not Kind.EPISODES for question in questions)
    episodes = on_policy(profile, world) if world is not None and single else None
    with made:
        for number, question in enumerate(questions, 1):
            claim = question.claim
            if claim.kind is Kind.EPISODES:
                yield _of_episodes(question.about(claim).by(MACHINE), rollouts(made, world), skipped, where)
                continue
            decisions = _replays(made, question.profile, claim.team, world)

            def decided(question: DecisionQuestion, decisions: Mapping[str, Replay] = decisions) -> Result:
                visited = None if world is None or episodes is None else _visited(world, episodes, question.region)
                return engine.verify(question, decisions, visited, skipped)

            single_question = question.about(claim)
            result = decided(single_question)
            if where:
                from verify.extent.found import where as located

                found = located(single_question, result.verdict, region_file(number, claim))
                within = decided(single_question.within(found.part.region)) if found.part else None
                result = replace(result, where=found, within=within)
            yield result


def _of_episodes(
    question: EpisodeQuestion, replays: Mapping[str, EpisodeReplay], skipped: Sequence[str], where: bool
) -> EpisodeResult:
    from verify.extent.starts import start_share  # imported here, as most commands ask about decisions alone
    from verify.verdicts.episodes import verify_episodes

    found = verify_episodes(question, replays, skipped)
    return replace(found, starts=start_share(question, found.verdict) if where else None)


def verdicts(questions: Sequence[Question[Claim]]) -> Iterator[tuple[Verdict, str]]:
    """The verdict on each question and its reason: those of `verify_claims`, without what a report says beside them."""
    profile = ensure(questions[0].origin)
    assert all(question.origin is profile for question in questions)
    for question in questions:
        claim = question.claim
        if claim.kind is Kind.EPISODES:
            from verify.verdicts import episodes as closed_loop

            yield closed_loop.verdict(question.about(claim).by(MACHINE))
        else:
            yield engine.verdict(question.about(claim))


def region_file(number: int, claim: Claim) -> str:
    """The name of the file of the region that is found for a claim; claims are counted from 1."""
    return f"region-{number}-{claim.name}.toml"


def replayed(
    origin: ir.PolicyProfile, view: View | None, claim: Formula, team: str, state: State, semantics: str
) -> Acted:
    """A team's actions in a state, by everything that can replay it here: of a view by the compiled C alone."""
    profile, world = (origin, matching_places(origin)) if view is None else (over(origin, view), None)
    with ReplayBuild.of(origin) as made:
        return acted(profile, claim, team, state, _replays(made, profile, team, world), semantics)


def replayed_course(profile: ir.PolicyProfile, state: State, steps: int) -> tuple[Episode, tuple[str, ...]]:
    """The episode from a start, and the names of everything that can play it here and took the same course.

    DisagreementError when one of them takes another course.
    """
    with ReplayBuild.of(profile) as made:
        players = rollouts(made, matching_places(profile))
        return agreed(profile, state, steps, players), tuple(players)


def _replays(made: Build, profile: ir.PolicyProfile, team: str, world: ParticleWorld | None) -> Mapping[str, Replay]:
    """What replays a team's decisions in one state. `profile`: the one that was built, or a view of it."""
    replays: dict[str, Replay] = {}
    if made.compilable:
        replays["compiled C"] = partial(_in_compiled, made, profile, team)
    if world is not None:
        replays[shown(profile.world.reference)] = partial(_in_reference, profile, profile.team(team), world)
    return replays


def _in_compiled(made: Build, profile: ir.PolicyProfile, team: str, state: State) -> list[int]:
    """The team's actions by the compiled header; a copy of an agent acts by that agent's function."""
    known = [policy.agent for policy in made.profile.agents]
    found: list[int] = []
    for policy in profile.team(team):
        agent = policy.agent if policy.agent in known else policy.agent.removesuffix(RAISED)
        found.append(int(made.library.act(agent, observed(profile, policy, state))[0]))
    return found


def _in_reference(
    profile: ir.PolicyProfile, team: Sequence[ir.AgentPolicy], world: ParticleWorld, state: State
) -> list[int]:
    """The team's actions on what the reference environment itself observes in the world state; features that it does
    not have, and those that a counterexample's errors change, are observed by their meanings.
    """
    env = world.reference_env()
    env.reset(seed=0)
    world_state = state_of(profile, state)
    placed(env, world_state)
    found = []
    for policy in team:
        agent = world.agents.index(policy.agent)
        obs = world.observe(world_state)[agent].copy()
        shown = env.aec_env.unwrapped.observe(policy.agent)
        obs[0, : world.shown[agent]] = shown[: world.shown[agent]]
        exact, wrong = observed(profile, policy, replace(state, errors={})), observed(profile, policy, state)
        obs = np.where(exact == wrong, obs, wrong)
        found.append(int(ir.act(policy, obs)[0]))
    return found


def _visited(world: ParticleWorld, episodes: Episodes, region: Region) -> Visited:
    """How many on-policy states lie inside a region, its goals included."""
    world_state = WorldState.joined(episodes.states[1:])
    within = contains(region, world.coordinates(world_state), world.spec)
    if region.goals:
        names = np.array([landmark.name for landmark in world.spec.landmarks])
        within &= np.isin(names[world_state.goal], region.goals)
    return Visited(int(within.sum()), len(within), len(episodes.states[0]))


def digests(files: Mapping[str, str | bytes]) -> dict[str, str]:
    """SHA-256 of each text in hexadecimal, by name."""
    encoded = {name: item.encode() if isinstance(item, str) else item for name, item in sorted(files.items())}
    return {name: hashlib.sha256(item).hexdigest() for name, item in encoded.items()}


def question_files(questions: Sequence[Question[Claim]]) -> dict[str, str]:
    """The very questions, one a property and goal (of alive_leaves: one a leaf and goal), as SMT-LIB, name -> text.

    Claims about episodes have none: no solver is asked about them.
    """
    files: dict[str, str] = {}
    for number, asked in enumerate(questions, 1):
        claim = asked.claim
        if claim.kind is Kind.EPISODES:
            continue
        question = asked.about(claim)
        for goal in question.goals:
            for name, made in _queries(question, goal):
                files[f"{number:02d}-{name}-{goal or 'no-goal'}.smt2"] = render(
                    "smt/question.smt2.j2",
                    profile=content_hash(question.origin),
                    claim=f"{claim.shown}: {claim.written or claim.sentence}",
                    assume=claim.assumption,
                    leaf=claim.kind is Kind.LEAVES,
                    region=called(question.profile, question.region) or "given",
                    goal=goal,
                    semantics=question.semantics,
                    exact=made.exact,
                    text=smt_lib(made),
                )
    return files


def _queries(question: DecisionQuestion, goal: str | None) -> Iterator[tuple[str, Query]]:
    """What the solver is asked for one goal, each query with a name that suits a file."""
    team = question.team
    if question.claim.kind is not Kind.LEAVES:
        yield question.claim.name, query(question, goal, however_large=True)
        return
    for policy in team:
        for leaf in map(int, ir.leaves(policy.tree)):
            asked = reaching(policy, leaf, question.region, goal, semantics=question.semantics)
            yield f"{question.claim.name}-{policy.agent}-{leaf}", asked


def report_files(
    profile: ir.PolicyProfile,
    results: Sequence[Result | EpisodeResult],
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
