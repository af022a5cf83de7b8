"""The report of a verification: one set of facts, shown as JSON, as text, as one page, and as lines of a terminal.

Does: puts together what the module of each kind of claim tells of its results; renders it; words the region and how
  much of it, of the start region and of the states met a proof is about; says what proofs with and without a
  certificate and counterexamples rest on.
Assumes: results about one profile; commands and hashes of other files are given by the caller; a module for each kind,
  imported where a result is of it, as most reports are about decisions alone; a test that holds the lists of
  verify/checker/README.md against what the checker imports.
Does not: contain times, paths or facts about the machine, so equal questions give equal reports.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib import import_module
from typing import Any

from codegen.floats import FLOAT32
from codegen.form import layout
from codegen.intervals import percent
from codegen.ir import NO_FEATURE, FeatureSpec, PolicyProfile
from codegen.lowering.render import render
from codegen.policy_json import content_hash
from codegen.wording import format_count, visible
from verify.checker.thresholds import AT_ONCE
from verify.claims.formula import agents, coordinates
from verify.claims.region_files import START
from verify.kinds import MACHINE, REAL, Kind
from verify.question import Question
from verify.reports.drawing import draw_picture
from verify.result import AnyResult, Verdict
from verify.states import shares

POSITIONS = "Positions are finite float64. Agents may leave the region during an episode (see the on-policy states)."
SHARES = (
    "Shares are estimated from uniform samples, with 95 % Wilson intervals. The verdict does not depend on them.",
)
NOWHERE = "no state within the ranges lies in what it avoids"
WEAK = ", so it says little about these trees"  # where most shuffled leaves fulfil the claim too

SETS = {  # by what the checker counts: one of them, and what they do
    "boxes": ("box", "cover all episodes"),
    "forms": ("form", "cover all episodes"),
    "sets": ("set", "hold all states at all times"),
    "cells": ("cell", "hold what they become"),
}


@dataclass(frozen=True)
class Telling:
    """The way in which a report tells of one kind of claim."""

    facts: Callable[[PolicyProfile, Any, str], dict[str, Any]]  # of a result, with the command that repeats it
    limits: Callable[[PolicyProfile, Sequence[Any]], list[str]]  # what the verdicts do not say
    trusted: tuple[str, ...]  # what proofs rest on
    lines: Callable[[Any], tuple[str, list[str]]] | None = None  # what was asked, and lines under it; None: of a game
    words: Callable[[Any, Mapping[str, Any]], list[str]] = lambda result, told: []  # first lines under it, of a game


def sets(told: Mapping[str, Any]) -> str:
    """Counts the sets of a result's proof, in words; "" where it is none by sets."""
    proof = told.get("certificate", {})
    return next((format_count(proof[kind], noun) for kind, (noun, _) in SETS.items() if kind in proof), "")


def describe_sets(told: Mapping[str, Any]) -> str:
    """The same with what they show."""
    proof = told.get("certificate", {})
    return next((f"{sets(told)} {does}" for kind, (_, does) in SETS.items() if kind in proof), "")


LISTED = "and the modules that verify/checker/README.md lists for it"
WITH_CERTIFICATE = (
    f"for a proof about single decisions with a certificate: its checker (verify/checker/decisions), {LISTED}"
)
WITHOUT_CERTIFICATE = (
    "for a proof about single decisions without a certificate: the solver, and the encoder of trees, roundings and "
    "claim (verify/solver/encode.py)"
)
EPISODES_WITH_CERTIFICATE = (
    f"for a proof about episodes with a certificate: its checker (verify/checker/episodes), {LISTED}; and the dynamics "
    "in the profile's world spec"
)
EPISODES_WITHOUT_CERTIFICATE = (
    "for a proof about episodes without a certificate: one reading, which nothing checks, by the zones and their steps "
    "(verify/episodes: composition, contacts, unroll, zones), and the dynamics in the profile's world spec"
)
SYSTEMS_WITH_CERTIFICATE = (
    f"for a proof about a stated system: its checker (verify/checker/systems), {LISTED}; and that the statement is "
    "true of what it is about"
)
SYSTEMS_WITH_COVER = (
    f"for a proof about a stated system by boxes or affine forms: its checker (verify/checker/covers), {LISTED}; "
    "that the processor rounds float64 to nearest, of which the checker asks samples; and that the statement is true "
    "of what it is about"
)
SYSTEMS_WITH_SETS = (
    f"for a proof about continuous time: its checker (verify/checker/flows), {LISTED}; that the processor rounds "
    "float64 to nearest, of which the checker asks samples; and that the statement is true of what it is about"
)
SYSTEM_READ = "that the world file was read as it is meant: verify/systems (files, and what it imports)"
SYSTEM_ENCLOSED = (
    "for rules that are not affine: the checker's own arithmetic (verify/checker/systems/enclosures.py), which showed "
    "their enclosures (verify/systems/enclosures.py) again, and does so at every `maviper check`"
)
SYSTEM_REPLAYED = (
    "for a counterexample: no engine, but the exact replay (verify/reach/replay.py, verify/systems/observing.py), "
    "which `maviper replay` runs again"
)
FLOW_REPLAYED = (
    "for a counterexample: the checker's steps, which follow its start alone (verify/flows/episodes.py); `maviper "
    "replay` runs them again"
)
REPLAYED = "for a counterexample: none of this, since it can be replayed"
REFEREED = (
    "for a counterexample in real arithmetic: the referee (verify/states/state.py, and what it imports); `maviper "
    "replay` asks it again"
)
MEANINGS = "the meanings of the features in the profile"
UNCHECKED = f"{MEANINGS} (not checked: this version cannot play the profile's world)"
CHECKED = f"{MEANINGS} (the same as those of this version's world)"
GIVEN = "that an agent is given the numbers that its features name, in their units (not checked)"
EXACT_WORLD = "that world's steps equal the reference environment's bit by bit"


def texts(checked: bool | None, proofs: Sequence[str], replayed: Sequence[str]) -> list[str]:
    """All lines of a report. `checked`: the features have the meanings of a world that this version plays; None: claims
    are over observations, of which no meaning is asked. `proofs`: what those of each kind rest on.
    """
    lines = [f"{CHECKED}; {EXACT_WORLD}" if checked else UNCHECKED]
    lines = [GIVEN] if checked is None else lines
    return [*lines, *proofs, *replayed]


def readers(profile: PolicyProfile) -> list[str]:
    """A line for each imported agent whose source was compared with nothing: its reader must be right."""
    facts = profile.provenance.training
    if not any(name.endswith(" replayed by") for name in facts):  # nothing is imported, and no reader is loaded
        return []
    from codegen.importers.reading import find_uncompared

    return [
        f"that {agent} was read as its language means it (the reader of {facts.get(f'{agent} from', 'its file')}): its "
        "source was not compared"
        for agent in find_uncompared(profile)
    ]


def rests_on(enclosed: bool, counted: Collection[str], flowing: bool = False) -> list[str]:
    """All lines of a report about a stated system. `enclosed`: some of its rules are not affine; `counted`: what the
    checker counts in its certificates; `flowing`: it moves in continuous time.
    """
    if flowing:
        return [SYSTEMS_WITH_SETS, SYSTEM_READ, FLOW_REPLAYED]
    covers = [SYSTEMS_WITH_COVER] if set(counted) - {"branches"} else []
    walked = [SYSTEMS_WITH_CERTIFICATE] if "branches" in counted or not covers else []
    return [*walked, *covers, SYSTEM_READ, *([SYSTEM_ENCLOSED] if enclosed else []), SYSTEM_REPLAYED]


TELLINGS: Mapping[Kind, str] = {  # the module of a kind, which has the TELLING
    Kind.DECISIONS: "verify.reports.decisions",
    Kind.LEAVES: "verify.reports.decisions",
    Kind.EPISODES: "verify.reports.episodes",
    Kind.SYSTEMS: "verify.reports.systems",
}


def telling_of(result: AnyResult) -> Telling:
    """Returns the way in which a report tells of a result."""
    return import_module(TELLINGS[result.claim.kind]).TELLING


def by_telling(results: Sequence[AnyResult]) -> list[tuple[Telling, list[AnyResult]]]:
    """Results that are told of alike, together, in the order of the table."""
    groups = [[one for one in results if TELLINGS[one.claim.kind] == each] for each in dict.fromkeys(TELLINGS.values())]
    return [(telling_of(group[0]), group) for group in groups if group]


LABELS = 14  # letters of a line of the text report, before its words
PLACES = ("where", "exactly", "leaves", "together", "holds in")  # labels of where a claim holds
FOLDED = ("visited", "replays", "engines", "alone", "solver", "zones", "followed")  # what few readers look at
NO_PAGE = "no page plays them: agents compare float64 numbers"
SEMANTICS = (
    "Verdicts are about the deployed arithmetic. Each observation is a float32, made from float64 positions by one "
    "subtraction and one rounding. A split goes left iff x <= threshold. With the rounding, this is true exactly on a "
    "half line of the unrounded difference. The engines use the exact end of this half line in place of the threshold. "
    "So a proof over real positions is a proof for the deployed arithmetic. A counterexample is a float64 world state "
    "that was replayed."
)
DOUBLES = "Agents that compare float64 ({agents}): what they observe is not rounded to float32."
LONG_SUMS = (
    "A sum of more than two coordinates is rounded after each addition. For such tests Z3 takes the exact sum and an "
    "unknown of bounded size, so a proof covers every rounding."
)
REAL_SEMANTICS = (
    "Verdicts are about real arithmetic, not the deployed one: a split compares the exact coordinate or difference "
    "with the threshold as it is written. A proof says nothing about what rounding does at thresholds. A "
    "counterexample is judged in exact arithmetic. It is a float64 world state if one was found, preferably one in "
    "which the claim fails in the deployed arithmetic too. Otherwise its coordinates are rationals, written as "
    "fractions. The report says what the deployed arithmetic does there."
)
OBSERVED = (
    "Claims are over observations. Each observed number is a finite float64 number of the region. The agent reads it "
    "after rounding to float32; in real arithmetic it is read as it is. Observations that are given as float32 are "
    "among these. A split goes left iff x <= threshold. The engines use the exact end of the half line on which this "
    "is true after rounding."
)


def document(
    profile: PolicyProfile,
    results: Sequence[AnyResult],
    commands: Sequence[str],
    files: Mapping[str, str] | None = None,
) -> dict[str, Any]:
    """All facts as plain data. `commands`: what repeats each result; `files`: name -> SHA-256 of files made with it."""
    observing = any(result.viewed is not None for result in results)
    known = all(result.evidence.plays_world for result in results)
    kinds = [kind for kind in (MACHINE, REAL) if kind in {result.semantics for result in results}]
    told = by_telling(results)
    limits = dict.fromkeys(limit for each, group in told for limit in each.limits(profile, group))
    double = ", ".join(policy.agent for policy in profile.agents if policy.numbers != FLOAT32)
    doubled = [DOUBLES.format(agents=double)] if double and MACHINE in kinds else []
    replayed = [{MACHINE: REPLAYED, REAL: REFEREED}[kind] for kind in kinds]
    return {
        "report": "maviper-verification-1",
        "profile": content_hash(profile),
        "world": {"name": profile.world.name, "reference": profile.world.reference},
        **({"no_page": NO_PAGE} if any(policy.numbers != FLOAT32 for policy in profile.agents) else {}),
        "provenance": {
            "algorithm": profile.provenance.algorithm,
            "preset": profile.provenance.preset,
            "seed": profile.provenance.seed,
            "expert": profile.provenance.expert,
            "tool": profile.provenance.tool,
        },
        "evaluation": dict(profile.provenance.evaluation),
        "files": dict(files or {}),
        "results": [result_facts(profile, result, command) for result, command in zip(results, commands, strict=True)],
        "semantics": " ".join(
            [*([OBSERVED] if observing else [_semantics(profile, kind) for kind in kinds]), *doubled]
        ),
        "trusted": [
            *texts(None if observing else known, [line for each, _ in told for line in each.trusted], replayed),
            *readers(profile),
        ],
        "limits": list(limits),
    }


def result_facts(profile: PolicyProfile, result: AnyResult, command: str) -> dict[str, Any]:
    """One result as plain data, as it stands in the document."""
    of_start = {"of_start": shares.of_start(result.question.profile, result.region)}
    return telling_of(result).facts(profile, result, command) | of_start


def _semantics(profile: PolicyProfile, kind: str) -> str:
    """Describes what an arithmetic means for a profile's tests."""
    if kind == REAL:
        return REAL_SEMANTICS
    tested = [p.features[int(place)].meaning for p in profile.agents for place in p.tree.feature if place != NO_FEATURE]
    long = any(meaning is not None and len(meaning.terms) > AT_ONCE for meaning in tested)
    return f"{SEMANTICS} {LONG_SUMS}" if long else SEMANTICS


def as_json(facts: Mapping[str, Any]) -> str:
    """The report as JSON text."""
    return layout(dict(facts)) + "\n"


def as_text(facts: Mapping[str, Any]) -> str:
    """The report as plain text; what a terminal would not print as it stands is escaped."""
    return "\n".join(map(visible, render("report/report.txt.j2", **facts).split("\n")))


def as_html(facts: Mapping[str, Any], story: Mapping[str, Any] | None = None) -> str:
    """The report as one HTML page: inline styles and drawings, no scripts, nothing loaded from elsewhere. `story`: of
    how the profile came about, as `report/story.html.j2` tells it first.
    """
    ready = [{**draw_picture(result), **_evidence(result)} for result in facts["results"]]
    return render("report/report.html.j2", **{**facts, "results": ready, "story": story})


def _evidence(result: Mapping[str, Any]) -> dict[str, Any]:
    """The evidence of a result as labels with lines, from its text report: both say the same."""
    text = render(f"report/{result['kind']}.txt.j2", result=result)
    text += render("report/where.txt.j2", where=result["where"], result=result) if "where" in result else ""
    rows: list[tuple[str, list[str]]] = []
    for line in filter(None, text.split("\n")):
        label, words = line[:LABELS].strip(), line[LABELS:]
        if label:
            rows.append((label, [words]))
        else:
            rows[-1][1].append(words)
    arithmetic = "of the deployed code" if result["semantics"] == MACHINE else result["semantics"]
    shown = [row for row in rows if row[0] != "proof" or not result["certificate"]]
    return {
        "evidence": [row for row in shown if row[0] not in (*FOLDED, *PLACES)],
        "where_rows": [row for row in shown if row[0] in PLACES],
        "folded_rows": [("arithmetic", [arithmetic]), *(row for row in shown if row[0] in FOLDED)],
    }


def as_lines(profile: PolicyProfile, result: AnyResult) -> tuple[str, list[str]]:
    """One result for a terminal, from the facts of the report: what was asked, and the lines under it."""
    own = telling_of(result).lines
    return _of_game(profile, result) if own is None else own(result)


def _of_game(profile: PolicyProfile, result: AnyResult) -> tuple[str, list[str]]:
    """One result about a game: what was asked, and the lines under it."""
    facts = _show_involved(result, result_facts(profile, result, ""))
    named = facts["label"] or f"{facts['property']} of the {facts['team']}"
    named += f" {facts['observations']}" if "observations" in facts else ""
    real = ", real arithmetic" if facts["semantics"] == REAL else ""
    proved = _extent(facts) if result.verdict is Verdict.PROVED else ""
    asked = f"{named}, region {facts['region_name'] or 'given'}{proved}{real}"
    # a terminal waits for templates only where there is a counterexample, or where the claim holds
    there = {"counterexample": facts["counterexample"], "where": "where" in facts}
    parts = [render(f"report/lines-{part}.txt.j2", result=facts) for part, told in there.items() if told]
    texts = [*telling_of(result).words(result, facts), *parts]
    return asked, [visible(line) for text in texts for line in text.split("\n") if line]


def _show_involved(result: AnyResult, facts: Mapping[str, Any]) -> Mapping[str, Any]:
    """The facts with a counterexample over observations of those agents that the claim speaks of, and of the features
    that it or their paths name; `unlike`: those of one name that they observe unlike. The report has the others.
    """
    example: dict[str, Any] = facts.get("counterexample") or {}
    question: Question[Any] = result.question
    acting = agents(question.formula) if example and result.viewed is not None else frozenset[str]()
    if not acting or result.viewed is None:
        return facts
    shown: list[dict[str, Any]] = [each for each in example["agents"] if each["agent"] in acting]
    read, values = {*coordinates(question.formula)}, dict[FeatureSpec, set[Any]]()
    for each in shown:
        tested = {step["feature"] for step in each["path"]}
        for feature in question.profile.policy(each["agent"]).features:
            assert feature.meaning is not None
            ((_, name),) = feature.meaning.terms
            read |= {name} if feature.name in tested else set()
            if feature.name in tested and result.viewed.view.original(each["agent"]) == each["agent"]:
                values.setdefault(replace(feature, meaning=None), set()).add(example["position"][name])
    position: dict[str, Any] = {name: value for name, value in example["position"].items() if name in read}
    unlike = [feature.name for feature, found in values.items() if len(found) > 1]
    return {**facts, "counterexample": {**example, "position": position, "agents": shown, "unlike": unlike}}


def _extent(facts: Mapping[str, Any]) -> str:
    """Describes how much a proof is about: the region's share of the start region, and of the states the team meets."""
    parts: list[str] = []
    if facts["of_start"] is not None:
        whole = "it" if facts["region_name"] == START else "the start region"
        whole = "the stated ranges" if "observations" in facts else whole
        parts.append(shares.extent_words(facts["of_start"], whole))
    if facts.get("visited"):
        parts.append(f"{percent(facts['visited']['inside'], facts['visited']['states'])} of the states met")
    return f" ({', '.join(parts)})" if parts else ""
