"""What is done with claims about single decisions, and about leaves.

Does: joins their verdicts with replays and the states met; certificates, counterexamples and queries as text.
Assumes: a bench for the profile that is asked about.
Does not: decide.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from codegen import ir
from codegen.ir import PolicyProfile
from codegen.lowering.render import render
from codegen.policy_json import content_hash
from maviper.verification.bench import Bench, state_replays
from maviper.verification.files.counterexamples import document
from maviper.verification.files.places import zones_and_region
from maviper.verification.procedures.procedure import Procedure
from verify.certificates.decisions import to_json
from verify.claims.uncertified.own import spell_decisions
from verify.claims.uncertified.starts import name_region
from verify.question import DecisionQuestion
from verify.result import Verdict
from verify.solver.encode import Query, query, reaching
from verify.solver.solve import smt_lib
from verify.verdicts import decisions
from verify.verdicts.decisions import DecisionResult


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


PROCEDURE = Procedure(_answer, _verdict, to_json, _counterexample, zones_and_region, _solver_files)
