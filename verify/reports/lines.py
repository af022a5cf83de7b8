"""What a terminal shows of a result: what was asked, and the lines under it, from the facts of the report.

Does: words the region and how much of it, of the start region and of the states met a proof is about.
Assumes: results of one profile.
Does not: print.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from codegen.intervals import percent
from codegen.ir import PolicyProfile
from codegen.lowering.render import render
from verify.claims.formula import agents, coordinates
from verify.claims.region_files import START
from verify.kinds import REAL
from verify.question import Question
from verify.reports.kinds import telling
from verify.reports.report import result_facts
from verify.result import AnyResult, Verdict
from verify.states import shares


def as_lines(profile: PolicyProfile, result: AnyResult) -> tuple[str, list[str]]:
    """One result for a terminal, from the facts of the report: what was asked, and the lines under it."""
    own = telling(result).lines
    return _of_game(profile, result) if own is None else own(result)


def _of_game(profile: PolicyProfile, result: AnyResult) -> tuple[str, list[str]]:
    """One result about a game: what was asked, and the lines under it."""
    facts = _show_involved(result, result_facts(profile, result, ""))
    named = facts["label"] or f"{facts['property']} of the {facts['team']}"
    named += f" {facts['observations']}" if "observations" in facts else ""
    real = ", real arithmetic" if facts["semantics"] == REAL else ""
    text = render("report/lines.txt.j2", result=facts, left_out=result.evidence.left_out)
    proved = _extent(facts) if result.verdict is Verdict.PROVED else ""
    return f"{named}, region {facts['region_name'] or 'given'}{proved}{real}", [
        line for line in text.split("\n") if line
    ]


def _show_involved(result: AnyResult, facts: Mapping[str, Any]) -> Mapping[str, Any]:
    """The facts with a counterexample over observations of those agents that the claim speaks of, and of what they
    observe: the report has the others.
    """
    example: dict[str, Any] = facts.get("counterexample") or {}
    question: Question[Any] = result.question
    acting = agents(question.formula) if example and result.viewed is not None else frozenset[str]()
    if not acting:
        return facts
    policies = [policy for policy in question.profile.agents if policy.agent in acting]
    meanings = [feature.meaning for policy in policies for feature in policy.features]
    read = {name for meaning in meanings if meaning for _, name in meaning.terms} | {*coordinates(question.formula)}
    position: dict[str, Any] = {name: value for name, value in example["position"].items() if name in read}
    shown: list[dict[str, Any]] = [each for each in example["agents"] if each["agent"] in acting]
    return {**facts, "counterexample": {**example, "position": position, "agents": shown}}


def _extent(facts: Mapping[str, Any]) -> str:
    """Describes how much a proof is about: the region's share of the start region, and of the states the team meets."""
    parts: list[str] = []
    if facts["of_start"] is not None:
        whole = "it" if facts["region_name"] == START else "the start region"
        parts.append(shares.extent_words(facts["of_start"], whole))
    if facts.get("visited"):
        parts.append(f"{percent(facts['visited']['inside'], facts['visited']['states'])} of the states met")
    return f" ({', '.join(parts)})" if parts else ""
