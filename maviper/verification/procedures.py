"""What is done with claims about games beside their verdict: answers, certificates, counterexamples, where they hold.

Does: names the functions that handle one kind of claim; those of claims about decisions and leaves, and about episodes.
Assumes: questions with their bench.
Does not: know claims about systems (stated.py), or choose among kinds (run.py).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from codegen import ir
from codegen.ir import PolicyProfile
from codegen.lowering.render import render
from codegen.policy_json import content_hash
from maviper.verification.bench import Bench, rollouts, state_replays
from maviper.verification.files.counterexamples import document, episode_document
from maviper.verification.files.states import zones_and_region
from verify.claims.region_files import name_region
from verify.claims.wording import spell_decisions
from verify.kinds import MACHINE
from verify.question import DecisionQuestion, EpisodeQuestion
from verify.result import Verdict
from verify.solver.encode import Query, query, reaching
from verify.solver.solve import smt_lib
from verify.verdicts import decisions
from verify.verdicts.decisions import DecisionResult

if TYPE_CHECKING:
    from verify.result import AnyResult, Verdict
    from verify.verdicts.episodes import EpisodeResult


def _nothing(*_: object) -> dict[str, str]:
    return {}


@dataclass(frozen=True)
class Procedure:
    """The functions that handle one kind of claim."""

    answer: Callable[[Any, Any, str | None], AnyResult]  # a question, by its bench; where it holds, for the file named
    verdict: Callable[[Any, Any], tuple[Verdict, str]]  # of a question, by its bench, with the reason
    counterexample: Callable[[PolicyProfile, Any], tuple[dict[str, Any], str] | None]  # and where it is, in words
    # files of where a result holds, which has a number; and what the solver is asked of a question, which has one
    places: Callable[[PolicyProfile, int, Any], dict[str, str]] = _nothing
    solver_files: Callable[[int, Any], dict[str, str]] = _nothing


def _answer(question: DecisionQuestion, bench: Bench, region_file: str | None) -> DecisionResult:
    replays = state_replays(bench.made, question.profile, question.claim.team, bench.world)

    def decide(asked: DecisionQuestion) -> DecisionResult:
        return decisions.verify(asked, replays, bench.count_visited(asked.region), bench.skipped)

    result = decide(question)
    if region_file is None:
        return result
    from verify.extent.largest import where as located  # imported here, as few ask where

    where = located(question, result.verdict, region_file)
    inner = decide(question.within(where.part.region)) if where.part else None
    return replace(result, evidence=replace(result.evidence, where=where, verdict_in_largest_region=inner))


def _counterexample(profile: PolicyProfile, result: DecisionResult) -> tuple[dict[str, Any], str] | None:
    if result.evidence.counterexample is None:
        return None
    where = "in its world state" if result.viewed is None else "at its observation"
    return document(profile, result, result.evidence.counterexample), where


def _queries(question: DecisionQuestion, goal: str | None) -> Iterator[tuple[str, Query]]:
    """Yields the queries to the solver for one goal, each with a name that suits a file."""
    team = question.team
    if question.claim.per_state:
        yield question.claim.name, query(question, goal, however_large=True)
        return
    for policy in team:
        for leaf in map(int, ir.leaves(policy.tree)):
            asked = reaching(policy, leaf, question.region, goal, semantics=question.semantics)
            yield f"{question.claim.name}-{policy.agent}-{leaf}", asked


def _solver_files(number: int, question: DecisionQuestion) -> dict[str, str]:
    claim = question.claim
    return {
        f"{number:02d}-{name}-{goal or 'no-goal'}.smt2": render(
            "smt/question.smt2.j2",
            profile=content_hash(question.origin),
            claim=f"{claim.shown}: {claim.written or spell_decisions(claim)}",
            assume=claim.assumption,
            leaf=not claim.per_state,
            region=name_region(question.profile, question.region) or "given",
            goal=goal,
            semantics=question.semantics,
            exact=made.exact,
            text=smt_lib(made),
        )
        for goal in question.goals
        for name, made in _queries(question, goal)
    }


def _verdict(question: DecisionQuestion, bench: object) -> tuple[Verdict, str]:
    return decisions.verdict(question)


DECISIONS = Procedure(_answer, _verdict, _counterexample, zones_and_region, _solver_files)


def _answer_episodes(question: EpisodeQuestion, bench: Bench, region_file: str | None) -> EpisodeResult:
    from verify.verdicts import episodes  # here, as most claims are about decisions

    return episodes.verify_episodes(question.by(MACHINE), rollouts(bench.made, bench.world), bench.skipped)


def _judge_episodes(question: EpisodeQuestion, bench: object) -> tuple[Verdict, str]:
    from verify.verdicts import episodes

    return episodes.verdict(question.by(MACHINE))


def _episode_counterexample(profile: PolicyProfile, result: EpisodeResult) -> tuple[dict[str, Any], str] | None:
    return None if result.evidence.state is None else (episode_document(profile, result), "from its start")


EPISODES = Procedure(_answer_episodes, _judge_episodes, _episode_counterexample)
