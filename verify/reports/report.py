"""The report of a verification: one set of facts, shown as JSON, text and one self-contained HTML page.

Does: puts together what the module of each kind of claim tells of its results; renders it.
Assumes: results about one profile; commands and hashes of other files are given by the caller.
Does not: contain times, paths or facts about the machine, so equal questions give equal reports.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from codegen.floats import FLOAT32
from codegen.form import layout
from codegen.ir import NO_FEATURE, PolicyProfile
from codegen.lowering.render import render
from codegen.policy_json import content_hash
from codegen.wording import visible
from verify.checker.thresholds import AT_ONCE
from verify.kinds import MACHINE, REAL
from verify.reports import trusted
from verify.reports.drawing import draw_picture
from verify.reports.kinds import by_telling, telling
from verify.result import AnyResult
from verify.states import shares

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
    replayed = [{MACHINE: trusted.REPLAYED, REAL: trusted.REFEREED}[kind] for kind in kinds]
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
            *trusted.texts(None if observing else known, [line for each, _ in told for line in each.trusted], replayed),
            *trusted.readers(profile),
        ],
        "limits": list(limits),
    }


def result_facts(profile: PolicyProfile, result: AnyResult, command: str) -> dict[str, Any]:
    """One result as plain data, as it stands in the document."""
    of_start = {"of_start": shares.of_start(result.question.profile, result.region)}
    return telling(result).facts(profile, result, command) | of_start


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


def as_html(facts: Mapping[str, Any]) -> str:
    """The report as one HTML page: inline styles and drawings, no scripts, nothing loaded from elsewhere."""
    return render(
        "report/report.html.j2", **{**facts, "results": [draw_picture(result) for result in facts["results"]]}
    )
